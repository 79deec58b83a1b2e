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
    pub quantity: ValueQuantity,
}

/// What the numbers of a generated field mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ValueQuantity {
    /// A height in metres.
    #[default]
    Elevation,
    /// A share from 0 to 1.
    Mask,
    /// A plain number.
    Number,
}

impl From<ValueQuantity> for Quantity {
    fn from(quantity: ValueQuantity) -> Self {
        match quantity {
            ValueQuantity::Elevation => Self::Elevation,
            ValueQuantity::Mask => Self::Mask,
            ValueQuantity::Number => Self::Number,
        }
    }
}

impl Default for Constant {
    fn default() -> Self {
        Self { value: Number(0.0), quantity: ValueQuantity::Elevation }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// The value on every point.
        field: Field = Meaning::Chosen,
    }
}

impl Node for Constant {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&["value", "plain", "flat", "number", "level"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 0.5)
    }

    fn quantity(&self, _: &str, _: Quantities<'_>) -> Quantity {
        self.quantity.into()
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let quantity = self.quantity.into();
        let value = self.value.0 as f32;
        Ok(Outputs { field: cx.fill(quantity, |_, out| out.fill(value))? })
    }
}
