//! Moving, turning, scaling and mirroring curves.

use crate::kit::curves::transform::{Mirror, Transform};
use crate::prelude::*;

/// Mirrors, scales and turns feature curves about a point, in this order, then moves them.
///
/// Lengths along the ground scale with the ground, heights and amplitudes with heights; angles follow both, so that a
/// slope keeps its form. What lay on a side of a curve lies on that side of its mirror image.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TransformCurves {
    /// Way to the east and south.
    #[schemars(inner(range(min = -1.0e7, max = 1.0e7)), extend("x-unit" = "m", "x-items" = ["east", "south"]))]
    pub shift: [Metres; 2],
    /// Turn, clockwise on the map.
    #[schemars(range(min = -36_000.0, max = 36_000.0), extend("x-soft" = [-180.0, 180.0]))]
    pub rotate: Degrees,
    /// Factor of lengths along the ground.
    #[schemars(range(min = 0.001, max = 1000.0), extend("x-soft" = [0.1, 10.0], "x-log" = true))]
    pub scale: Number,
    /// Which sides change places.
    pub mirror: Mirror,
    /// The point that mirroring, scaling and turning leave where it is, from the middle of the terrain.
    #[schemars(inner(range(min = -1.0e7, max = 1.0e7)), extend("x-unit" = "m", "x-items" = ["east", "south"]))]
    pub pivot: [Metres; 2],
    /// Factor of heights and amplitudes.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 4.0]))]
    pub height_scale: Number,
    /// Added to heights.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [-1000.0, 1000.0]))]
    pub raise: Metres,
}

impl Default for TransformCurves {
    fn default() -> Self {
        Self {
            shift: [Metres(0.0); 2],
            rotate: Degrees(0.0),
            scale: Number(1.0),
            mirror: Mirror::None,
            pivot: [Metres(0.0); 2],
            height_scale: Number(1.0),
            raise: Metres(0.0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Feature curves.
        curves: Curves,
    }
    pub struct Outputs {
        /// The curves, transformed.
        curves: Curves,
    }
}

impl Node for TransformCurves {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().quick().keywords(&["move", "rotate", "scale", "mirror", "flip"]).reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let cost = Cost { bytes: 8 << 20, seconds: 1e-3 };
        let Some(curves) = load.object::<Curves>("curves") else { return cost };
        let pieces: usize = curves.iter().map(|c| c.pieces()).sum();
        let seconds = cost.seconds + curves.len() as f64 * 2e-6 + pieces as f64 * 1e-6;
        Cost { bytes: cost.bytes + 2 * curves.bytes(), seconds }
    }

    fn run(&self, cx: &Context<'_>, Inputs { curves }: Inputs) -> Result<Outputs> {
        let b = cx.terrain()?.bounds();
        let middle = |axis: usize| (b.min[axis] + b.max[axis]) / 2.0 + self.pivot[axis].0;
        let transform = Transform {
            mirror: self.mirror,
            scale: self.scale.0,
            rotate: self.rotate.0,
            pivot: [middle(0), middle(1)],
            shift: self.shift.map(|m| m.0),
            height_scale: self.height_scale.0,
            raise: self.raise.0,
        };
        Ok(Outputs { curves: transform.apply(&curves).map_err(Error::of_curves)? })
    }
}
