//! A mask of the slopes in a range.

use crate::kit::derivative::{self, Derivative};
use crate::kit::math::Band;
use crate::prelude::*;

/// Selects the places whose slope lies in a range.
///
/// The slope is `atan |∇h|`, with the gradient from the heights `scale` metres to the east, west, north and south
/// \[zevenbergen1987\]. The mask is 1 from `low` to `high` and fades to 0 over `soft` degrees beyond either.
///
/// # Limits
/// The scale that takes effect is at least one cell of the build, or of the base grid where the build is coarser.
/// A build coarser than the base grid reads the heights on a finer grid, so that it selects the same places.
///
/// # See also
/// `select_height`, `select_aspect`, `select_curvature`, `hillshade`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SelectSlope {
    /// Gentlest slope that is selected whole.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub low: Degrees,
    /// Steepest slope that is selected whole.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub high: Degrees,
    /// Angle over which the mask fades out beyond the range.
    #[schemars(range(min = 0.0, max = 90.0), extend("x-soft" = [0.0, 30.0]))]
    pub soft: Degrees,
    /// Distance to either side over which the slope is taken; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub scale: Option<Metres>,
}

impl Default for SelectSlope {
    fn default() -> Self {
        Self { low: Degrees(30.0), high: Degrees(90.0), soft: Degrees(5.0), scale: None }
    }
}

ports! {
    pub struct Inputs {
        /// Heights whose slope is taken.
        height: Field,
    }
    pub struct Outputs {
        /// How far each place is selected, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// The slope in degrees: 0 flat, 90 upright.
        slope: Field = Meaning::Fixed(Quantity::Slope),
    }
}

impl Node for SelectSlope {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zevenbergen1987"])
        .keywords(&["mask", "steepness", "gradient", "angle", "cliff", "flat"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        derivative::reach(self.scale)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        derivative::footprint(window, self.scale, terrain.base_cell())
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        derivative::cost(grid, if self.scale.is_some() { 20.0 } else { 12.0 }, 8)
    }

    fn check(&self) -> Result<()> {
        ordered(self.low.0, self.high.0, "degrees")
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let scale = cx.scale(self.scale)?;
        let derivative = Derivative::new("height", &input.height, &cx.grid, scale)?;
        let slope = cx.stage(0.0, 0.8).fill(Quantity::Slope, |row, out| {
            let gradient = derivative.gradient(row.j);
            for ((o, &x), &y) in out.iter_mut().zip(&gradient.x).zip(&gradient.y) {
                *o = derivative::slope(x, y);
            }
        })?;
        let band = Band::new(self.low.0, self.high.0, self.soft.0);
        let mask = cx.stage(0.8, 1.0).map(&slope, Quantity::Mask, |s| band.weight(s))?;
        Ok(Outputs { mask, slope })
    }
}

/// Checks that a range is not turned around.
///
/// # Errors
/// Names `low`, the limit and the value found.
pub(super) fn ordered(low: f64, high: f64, unit: &str) -> Result<()> {
    if low <= high {
        return Ok(());
    }
    let message = format!("must be at most `high`, which is {high} {unit}, got {low}");
    Err(Error::Parameter { name: "low".into(), message })
}
