//! From one field to another.

use crate::kit::rows::{lerp, zip};
use crate::kit::sample::finite;
use crate::prelude::*;

/// Goes from one field to another, by an amount or a mask.
///
/// `field = a + amount · mask · (b − a)`. Where that share is 0 or 1, `a` or `b` come out to the bit.
///
/// What comes out has the quantity of `a`, or of `b` where all of it is taken or `a` is a mask and `b` is not.
///
/// # See also
/// `combine` for arithmetic, `switch` to take one of several.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mix {
    /// Share of `b`; with a mask, its share where the mask is 1.
    pub amount: Ratio,
}

impl Default for Mix {
    fn default() -> Self {
        Self { amount: Ratio(1.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Where the mask is 0, or the amount.
        a: Field,
        /// Where mask and amount are 1.
        b: Field,
    }
    pub struct Outputs {
        /// Between the two.
        field: Field = Meaning::Chosen,
    }
}

impl Node for Mix {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().mixes(&[("field", "a")]).keywords(&["blend", "lerp", "layer", "cross fade"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 1.5)
    }

    fn quantity(&self, _: &str, inputs: Quantities<'_>) -> Quantity {
        let [a, b] = ["a", "b"].map(|port| inputs(port).unwrap_or(Quantity::Number));
        self.quantity_of(a, b)
    }

    fn run(&self, cx: &Context<'_>, Inputs { a, b }: Inputs) -> Result<Outputs> {
        let quantity = self.quantity_of(a.quantity(), b.quantity());
        let field = match self.amount.0 {
            0.0 => a.crop(&cx.grid),
            1.0 => b.crop(&cx.grid),
            amount => zip(&cx.work, &cx.grid, [&a, &b], quantity, |a, b| finite(lerp(a, b, amount as f32)))?,
        };
        Ok(Outputs { field })
    }
}

impl Mix {
    fn quantity_of(&self, a: Quantity, b: Quantity) -> Quantity {
        match self.amount.0 {
            0.0 => a,
            1.0 => b,
            _ if a == Quantity::Mask => b,
            _ => a,
        }
    }
}
