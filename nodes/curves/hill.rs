//! A hill, from few numbers.

use super::short::{Grain, Ground, apart, curve, short_form};
use crate::prelude::*;
use crate::value::curves::Slope;

/// Draws a hill: heights along a line with level ground beside it, so that it is round on top.
///
/// The slopes are horizontal: the ground keeps its height near the curve and falls further out as the surroundings
/// ask [hnaidi2010, Figure 7 left].
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `ridge_line` has a sharp crest.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hill {
    /// East, south and height of points that the top goes through.
    #[schemars(length(min = 2, max = 1024), extend("x-widget" = Widget::CurveOnMap, "x-items" = ["east", "south", "height"]))]
    pub through: Vec<[Metres; 3]>,
    /// Half the width of the flat top.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub plateau: Metres,
    /// How far the level ground beside the top reaches.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub extent: Metres,
    /// Roughness of the ground on the top.
    pub grain: Grain,
    /// Width of the strip that is smoothed into an existing terrain; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub blend: Metres,
}

impl Default for Hill {
    fn default() -> Self {
        let through = [[3300.0, 4300.0, 150.0], [4100.0, 4000.0, 180.0], [4800.0, 4100.0, 160.0]];
        Self {
            through: through.map(|p| p.map(Metres)).to_vec(),
            plateau: Metres(40.0),
            extent: Metres(400.0),
            grain: Grain::Unset,
            blend: Metres(0.0),
        }
    }
}

short_form!(Hill, ["hill", "knoll", "dune", "mound"]);

impl Hill {
    /// The feature curve.
    ///
    /// # Errors
    /// Names the point or value.
    pub fn curves(&self) -> Result<Curves> {
        let (points, heights) = apart(&self.through);
        let level = Slope {
            left_extent: self.extent.0,
            right_extent: self.extent.0,
            left_angle: 0.0,
            right_angle: 0.0,
        };
        let ground =
            Ground { radius: self.plateau.0, slope: Some(level), grain: self.grain, blend: self.blend.0 };
        curve("hill", &points, Some(&heights), ground).map_err(Error::of_curves)
    }
}
