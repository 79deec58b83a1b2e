//! One value everywhere.

use crate::prelude::*;

/// Gives the same value everywhere.
///
/// A plain to add to, a strength to multiply with, a level to compare against.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Constant {
    /// The value, in the unit of what it is used for.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
    pub value: Number,
    /// What the value means.
    pub quantity: Meaning,
}

/// What the numbers of a generated field mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Meaning {
    /// A height in metres.
    #[default]
    Elevation,
    /// A share from 0 to 1.
    Mask,
    /// A plain number.
    Number,
}

impl Default for Constant {
    fn default() -> Self {
        Self { value: Number(0.0), quantity: Meaning::Elevation }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// The value on every point.
        field: Field,
    }
}

impl Node for Constant {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&["value", "plain", "flat", "number", "level"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, grid: &Grid) -> Cost {
        Cost::per_sample(grid, 0.5)
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let quantity = match self.quantity {
            Meaning::Elevation => Quantity::Elevation,
            Meaning::Mask => Quantity::Mask,
            Meaning::Number => Quantity::Number,
        };
        let value = self.value.0 as f32;
        Ok(Outputs { field: cx.fill(quantity, |_, out| out.fill(value))? })
    }
}
