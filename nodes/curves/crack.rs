//! A crack, from few numbers.

use super::short::{Grain, Ground, curve, extent, places, short_form};
use crate::prelude::*;
use crate::value::curves::Slope;

/// Draws a crack: ground that rises steeply on both sides of a line, whatever its height.
///
/// There is no elevation: the walls go down by `depth` from the ground they find [hnaidi2010, Figure 7 right].
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `river_bed` has heights of its own.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Crack {
    /// East and south of points that the bottom goes through.
    #[schemars(length(min = 2, max = 1024), extend("x-widget" = Widget::CurveOnMap, "x-items" = ["east", "south"]))]
    pub through: Vec<[Metres; 2]>,
    /// How deep the bottom lies below the ground beside.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub depth: Metres,
    /// How steeply the walls rise from the bottom.
    #[schemars(range(min = 5.0, max = 88.0))]
    pub angle: Degrees,
    /// Roughness of the ground on the bottom.
    pub grain: Grain,
    /// Width of the strip that is smoothed into an existing terrain; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub blend: Metres,
}

impl Default for Crack {
    fn default() -> Self {
        let through = [[1500.0, 6500.0], [3600.0, 4700.0], [4600.0, 4500.0], [6900.0, 1800.0]];
        Self {
            through: through.map(|p| p.map(Metres)).to_vec(),
            depth: Metres(120.0),
            angle: Degrees(60.0),
            grain: Grain::Unset,
            blend: Metres(0.0),
        }
    }
}

short_form!(Crack, ["crack", "gorge", "canyon", "rift", "ravine"]);

impl Crack {
    /// The feature curve.
    ///
    /// # Errors
    /// Names the point or value.
    pub fn curves(&self) -> Result<Curves> {
        let reach = extent(self.depth.0, self.angle.0);
        let walls = Slope {
            left_extent: reach,
            right_extent: reach,
            left_angle: self.angle.0,
            right_angle: self.angle.0,
        };
        let ground = Ground { radius: 0.0, slope: Some(walls), grain: self.grain, blend: self.blend.0 };
        curve("crack", &places(&self.through), None, ground).map_err(Error::of_curves)
    }
}
