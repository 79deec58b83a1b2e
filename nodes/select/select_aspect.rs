//! A mask of the slopes that face a direction.

use crate::kit::derivative::{self, Derivative};
use crate::kit::math::smooth;
use crate::prelude::*;

/// Selects the slopes that face a compass direction.
///
/// A slope faces where water would run: `direction = atan2(−∂h/∂x, ∂h/∂y)`, with x to the east and y to the south,
/// from the heights `scale` metres to either side \[zevenbergen1987\]. The mask is 1 within half of `width` of the
/// chosen direction and fades to 0 over `soft` degrees more. Flat ground faces nowhere: the mask rises with the
/// slope, from 0 on the flat to its whole value at `steepness`.
///
/// # Limits
/// The scale that takes effect is at least one cell of the build, or of the base grid where the build is coarser.
///
/// # See also
/// `select_slope`, `hillshade`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SelectAspect {
    /// Compass direction of the middle: 0 north, 90 east, 180 south, 270 west.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-soft" = [0.0, 360.0]))]
    pub direction: Degrees,
    /// Angle, from side to side, that is selected whole.
    #[schemars(range(min = 0.0, max = 360.0))]
    pub width: Degrees,
    /// Angle over which the mask fades out on either side.
    #[schemars(range(min = 0.0, max = 180.0), extend("x-soft" = [0.0, 90.0]))]
    pub soft: Degrees,
    /// Slope from which on the direction counts whole.
    #[schemars(range(min = 0.0, max = 90.0), extend("x-soft" = [0.0, 30.0]))]
    pub steepness: Degrees,
    /// Distance to either side over which the slope is taken; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub scale: Option<Metres>,
}

impl Default for SelectAspect {
    fn default() -> Self {
        Self {
            direction: Degrees(0.0),
            width: Degrees(90.0),
            soft: Degrees(45.0),
            steepness: Degrees(5.0),
            scale: None,
        }
    }
}

ports! {
    pub struct Inputs {
        /// Heights whose slopes are looked at.
        height: Field,
    }
    pub struct Outputs {
        /// How far each place is selected, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// Compass direction in which the ground falls, in degrees from 0 up to 360; 0 where it is flat.
        direction: Field = Meaning::Fixed(Quantity::Direction),
    }
}

impl Node for SelectAspect {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zevenbergen1987"])
        .keywords(&["mask", "orientation", "exposure", "facing", "north", "sunny side"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        derivative::reach(self.scale)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        derivative::footprint(window, self.scale, terrain.base_cell())
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        derivative::cost(grid, if self.scale.is_some() { 30.0 } else { 17.0 }, 8)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let scale = cx.scale(self.scale)?;
        let derivative = Derivative::new("height", &input.height, &cx.grid, scale)?;
        let direction = cx.stage(0.0, 0.5).fill(Quantity::Direction, |row, out| {
            let gradient = derivative.gradient(row.j);
            for ((o, &x), &y) in out.iter_mut().zip(&gradient.x).zip(&gradient.y) {
                *o = derivative::aspect(x, y);
            }
        })?;
        let sector = Sector::new(self);
        let mask = cx.stage(0.5, 1.0).fill(Quantity::Mask, |row, out| {
            let gradient = derivative.gradient(row.j);
            let faced = direction.row(row.j).iter().zip(gradient.x.iter().zip(&gradient.y));
            for (o, (&direction, (&x, &y))) in out.iter_mut().zip(faced) {
                *o = sector.weight(direction, derivative::slope(x, y));
            }
        })?;
        Ok(Outputs { mask, direction })
    }
}

/// The parameters as the loop needs them.
struct Sector {
    middle: f32,
    half: f32,
    per_soft: f32,
    per_steepness: f32,
}

impl Sector {
    fn new(node: &SelectAspect) -> Self {
        // A width of 0 becomes one too thin for any f32 to stand in.
        let per = |width: f64| 1.0 / width.max(1e-30) as f32;
        Self {
            middle: node.direction.0.rem_euclid(360.0) as f32,
            half: (node.width.0 / 2.0) as f32,
            per_soft: per(node.soft.0),
            per_steepness: per(node.steepness.0),
        }
    }

    #[inline]
    fn weight(&self, direction: f32, slope: f32) -> f32 {
        let apart = (direction - self.middle).abs();
        let outside = (apart.min(360.0 - apart) - self.half).max(0.0);
        (1.0 - smooth(outside * self.per_soft)) * smooth(slope * self.per_steepness)
    }
}
