//! A riverbed, from few numbers.

use super::short::{Grain, Ground, apart, curve, short_form};
use crate::prelude::*;
use crate::value::curves::Slope;

/// Draws a riverbed: a flat bed of given heights with banks that rise on both sides.
///
/// The plateau is the bed, the banks are short slopes upwards [hnaidi2010, Figure 6 left].
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `crack` cuts into whatever ground it finds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RiverBed {
    /// East, south and height of points that the bed goes through, from source to mouth.
    #[schemars(length(min = 2, max = 1024), extend("x-widget" = Widget::CurveOnMap, "x-items" = ["east", "south", "height"]))]
    pub through: Vec<[Metres; 3]>,
    /// Width of the bed from bank to bank.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 300.0]))]
    pub width: Metres,
    /// How steeply the banks rise.
    #[schemars(range(min = 0.0, max = 85.0))]
    pub bank: Degrees,
    /// How far the banks reach.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 1000.0]))]
    pub extent: Metres,
    /// Roughness of the ground on the bed.
    pub grain: Grain,
    /// Width of the strip that is smoothed into an existing terrain; 0 for none.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub blend: Metres,
}

impl Default for RiverBed {
    fn default() -> Self {
        let through = [
            [900.0, 1200.0, 260.0],
            [2900.0, 3300.0, 190.0],
            [4700.0, 4100.0, 140.0],
            [7600.0, 7000.0, 80.0],
        ];
        Self {
            through: through.map(|p| p.map(Metres)).to_vec(),
            width: Metres(80.0),
            bank: Degrees(15.0),
            extent: Metres(250.0),
            grain: Grain::Unset,
            blend: Metres(0.0),
        }
    }
}

short_form!(RiverBed, ["river", "valley", "stream", "bed", "channel"]);

impl RiverBed {
    /// The feature curve.
    ///
    /// # Errors
    /// Names the point or value.
    pub fn curves(&self) -> Result<Curves> {
        let (points, heights) = apart(&self.through);
        let slope = Slope {
            left_extent: self.extent.0,
            right_extent: self.extent.0,
            left_angle: self.bank.0,
            right_angle: self.bank.0,
        };
        let ground =
            Ground { radius: 0.5 * self.width.0, slope: Some(slope), grain: self.grain, blend: self.blend.0 };
        curve("river bed", &points, Some(&heights), ground).map_err(Error::of_curves)
    }
}
