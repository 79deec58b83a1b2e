//! A ridge, from few numbers.

use super::short::{Grain, Ground, apart, curve, short_form};
use crate::prelude::*;
use crate::value::curves::Slope;

/// Draws a ridge: a crest of given heights with slopes that fall away on both sides.
///
/// Several ridges that start at one point with one height make a mountain [hnaidi2010, Figure 5].
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `river_bed` is its opposite; `feature_curves` draws any curve.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RidgeLine {
    /// East, south and height of points that the crest goes through.
    #[schemars(length(min = 2, max = 1024), extend("x-widget" = Widget::CurveOnMap, "x-items" = ["east", "south", "height"]))]
    pub through: Vec<[Metres; 3]>,
    /// Half the width of the flat crest.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub plateau: Metres,
    /// How steeply the ground falls beside the crest, on the left.
    #[schemars(range(min = 0.0, max = 85.0))]
    pub left: Degrees,
    /// How steeply the ground falls beside the crest, on the right.
    #[schemars(range(min = 0.0, max = 85.0))]
    pub right: Degrees,
    /// How far the slopes reach; steepness fades to nothing over it.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 3000.0]))]
    pub extent: Metres,
    /// Roughness of the ground on the crest.
    pub grain: Grain,
    /// Width of the strip that is smoothed into an existing terrain; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub blend: Metres,
}

impl Default for RidgeLine {
    fn default() -> Self {
        let through = [[1600.0, 4600.0, 500.0], [3400.0, 3700.0, 1100.0], [6400.0, 4200.0, 650.0]];
        Self {
            through: through.map(|p| p.map(Metres)).to_vec(),
            plateau: Metres(0.0),
            left: Degrees(35.0),
            right: Degrees(35.0),
            extent: Metres(900.0),
            grain: Grain::Unset,
            blend: Metres(0.0),
        }
    }
}

short_form!(RidgeLine, ["ridge", "crest", "mountain", "arête", "spur"]);

impl RidgeLine {
    /// The feature curve.
    ///
    /// # Errors
    /// Names the point or value.
    pub fn curves(&self) -> Result<Curves> {
        let (points, heights) = apart(&self.through);
        let slope = Slope {
            left_extent: self.extent.0,
            right_extent: self.extent.0,
            left_angle: -self.left.0,
            right_angle: -self.right.0,
        };
        let ground =
            Ground { radius: self.plateau.0, slope: Some(slope), grain: self.grain, blend: self.blend.0 };
        curve("ridge line", &points, Some(&heights), ground).map_err(Error::of_curves)
    }
}
