//! Rivers along curves.

use super::network;
use crate::kit::curves::flatten::flatten;
use crate::kit::flow::join::Polyline;
use crate::prelude::*;
use crate::value::Curve;
use crate::value::rivers::MAX_VERTICES;

/// Makes a river network of curves: each is drawn from the source to the mouth, and ends in the river that it reaches.
///
/// The end of a curve that comes within `snap` of another joins it, at its nearest place; so does a curve that was drawn on
/// from where one ended. All other ends are outlets. Beds have the heights of the curves, or 0 where a curve has none, and
/// fall all the way from sources to outlets.
///
/// The area that drains through a vertex is that of the Voronoi cells of all vertices upstream inside the terrain. A river
/// is `width · √(A / 1 km²)` wide, where it drains `A` \[leopold1953\].
///
/// # Limits
/// Rivers that would run in a circle are left apart: of those that close it, the one listed last keeps its end as an outlet.
///
/// # See also
/// `curves_from_rivers`, `extract_rivers`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RiversFromCurves {
    /// Distance within which the end of a river joins another.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub snap: Metres,
    /// How far the straight links may lie from the curve.
    #[schemars(range(min = 0.01, max = 1000.0), extend("x-soft" = [0.1, 20.0]))]
    pub tolerance: Metres,
    /// Width of a river that drains a square kilometre.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 50.0]))]
    pub width: Metres,
}

impl Default for RiversFromCurves {
    fn default() -> Self {
        Self { snap: Metres(30.0), tolerance: Metres(1.0), width: Metres(2.5) }
    }
}

ports! {
    pub struct Inputs {
        /// Curves from source to mouth.
        curves: Curves,
    }
    pub struct Outputs {
        /// The network.
        rivers: Rivers,
    }
}

impl Node for RiversFromCurves {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["leopold1953"])
        .keywords(&["stream", "network", "convert", "draw", "join"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let pieces = load.object::<Curves>("curves").map_or(0, |c| c.iter().map(Curve::pieces).sum()) as u64;
        // Some corners a piece, each with its vertex several times over and its part in the Voronoi diagram.
        Cost { bytes: (1 << 20) + 16 * 600 * pieces, seconds: 1e-4 + 16.0 * pieces as f64 * 4e-6 }
    }

    fn run(&self, cx: &Context<'_>, Inputs { curves }: Inputs) -> Result<Outputs> {
        let mut left = MAX_VERTICES;
        let mut lines = Vec::with_capacity(curves.len());
        for (n, curve) in curves.iter().enumerate() {
            cx.work.step(0.2 * n as f32 / curves.len() as f32)?;
            let line = flatten(curve, self.tolerance.0, left).ok_or_else(too_many)?;
            left -= line.len();
            let corner = |v: &crate::kit::curves::flatten::Vertex| {
                let [x, y] = v.at;
                [x, y, curve.height(v.u).unwrap_or(0.0)]
            };
            lines.push(Polyline(line.iter().map(corner).collect()));
        }
        let wrong = |message: String| Error::Input { port: "curves".into(), message };
        let rivers = network::of_lines(&cx.stage(0.2, 1.0), &lines, [self.snap, self.width], wrong)?;
        Ok(Outputs { rivers })
    }
}

fn too_many() -> Error {
    let message = format!("has more than {MAX_VERTICES} corners; raise `tolerance`");
    Error::Input { port: "curves".into(), message }
}
