//! A cliff, from few numbers.

use super::short::{CurveSide, Grain, Ground, curve, extent, places, short_form};
use crate::prelude::*;
use crate::value::curves::Slope;

/// Draws a cliff: ground that rises steeply on one side of a line and falls as steeply on the other.
///
/// The steepness fades to both sides so that the ground drops by `drop` in all [hnaidi2010, Figure 6 right]. Without
/// a height the cliff takes that of its surroundings.
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `terrace` makes steps everywhere.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Cliff {
    /// East and south of points that the middle of the wall goes through.
    #[schemars(length(min = 2, max = 1024), extend("x-widget" = Widget::CurveOnMap, "x-items" = ["east", "south"]))]
    pub through: Vec<[Metres; 2]>,
    /// Height from foot to edge.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 1000.0]))]
    pub drop: Metres,
    /// How steep the wall is.
    #[schemars(range(min = 5.0, max = 88.0))]
    pub angle: Degrees,
    /// The side that is high.
    pub high: CurveSide,
    /// Height of the middle of the wall; without it the surroundings decide.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [-1000.0, 3000.0]))]
    pub height: Option<Metres>,
    /// Roughness of the ground on the wall.
    pub grain: Grain,
    /// Width of the strip that is smoothed into an existing terrain; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub blend: Metres,
}

impl Default for Cliff {
    fn default() -> Self {
        let through = [[1200.0, 2600.0], [3500.0, 4300.0], [5200.0, 3900.0], [7000.0, 5600.0]];
        Self {
            through: through.map(|p| p.map(Metres)).to_vec(),
            drop: Metres(300.0),
            angle: Degrees(70.0),
            high: CurveSide::Left,
            height: None,
            grain: Grain::Unset,
            blend: Metres(0.0),
        }
    }
}

short_form!(Cliff, ["cliff", "wall", "scarp", "step", "fault"]);

impl Cliff {
    /// The feature curve.
    ///
    /// # Errors
    /// Names the point or value.
    pub fn curves(&self) -> Result<Curves> {
        let reach = extent(0.5 * self.drop.0, self.angle.0);
        let up = if self.high == CurveSide::Left { self.angle.0 } else { -self.angle.0 };
        let slope = Slope { left_extent: reach, right_extent: reach, left_angle: up, right_angle: -up };
        let ground = Ground { radius: 0.0, slope: Some(slope), grain: self.grain, blend: self.blend.0 };
        let heights = self.height.map(|h| vec![h.0; self.through.len()]);
        curve("cliff", &places(&self.through), heights.as_deref(), ground).map_err(Error::of_curves)
    }
}
