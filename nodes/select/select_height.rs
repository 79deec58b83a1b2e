//! A mask of the heights in a range.

use crate::kit::math::Band;
use crate::prelude::*;

/// Selects the places whose height lies in a range.
///
/// The mask is 1 from `low` to `high` and fades to 0 over `soft` metres beyond either, along `3u² − 2u³`.
///
/// # See also
/// `select_slope`, `select_aspect`, `select_curvature`; `distance` and `expand` to work on the mask.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SelectHeight {
    /// Lowest height that is selected whole.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [0.0, 3000.0]))]
    pub low: Metres,
    /// Highest height that is selected whole.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [0.0, 3000.0]))]
    pub high: Metres,
    /// Height difference over which the mask fades out beyond the range.
    #[schemars(range(min = 0.0, max = 20_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub soft: Metres,
}

impl Default for SelectHeight {
    fn default() -> Self {
        Self { low: Metres(500.0), high: Metres(20_000.0), soft: Metres(100.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights to select from.
        height: Field,
    }
    pub struct Outputs {
        /// How far each place is selected, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for SelectHeight {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&["mask", "elevation", "altitude", "range", "threshold", "band"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 3.0)
    }

    fn check(&self) -> Result<()> {
        super::select_slope::ordered(self.low.0, self.high.0, "m")
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let band = Band::new(self.low.0, self.high.0, self.soft.0);
        Ok(Outputs { mask: cx.map(&input.height, Quantity::Mask, |h| band.weight(h))? })
    }
}
