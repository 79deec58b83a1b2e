//! Upside down.

use crate::kit::rows::map;
use crate::kit::sample::fit;
use crate::prelude::*;

/// Turns a field upside down: peaks become pits.
///
/// `field = 2 · middle − x`. A mask is turned about 1/2 when `about` is its range.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Invert {
    /// The value that stays where it is.
    pub about: About,
}

/// The value about which [`Invert`] turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum About {
    /// The middle between the lowest and the highest value of the whole terrain, on the base grid; 1/2 of a mask.
    #[default]
    Range,
    /// A value that is given.
    Value {
        /// The value, in the unit of the field.
        #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
        value: Number,
    },
}

impl Default for Invert {
    fn default() -> Self {
        Self { about: About::Range }
    }
}

ports! {
    pub struct Inputs {
        /// Field to turn.
        field: Field,
    }
    pub struct Outputs {
        /// Turned field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Invert {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().mixes(&[("field", "field")]).keywords(&[
        "negate",
        "complement",
        "upside down",
        "reverse",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        (self.about == About::Range).then_some(|_, cx, input| cx.range_summary(&input.field, 0.0))
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let quantity = field.quantity();
        let sum = match self.about {
            About::Range if quantity == Quantity::Mask => 1.0,
            About::Range => cx.summary_range()?.iter().sum(),
            About::Value { value } => 2.0 * value.0,
        };
        Ok(Outputs {
            field: map(&cx.work, &cx.grid, &field, quantity, |x| fit(quantity, (sum - f64::from(x)) as f32))?,
        })
    }
}
