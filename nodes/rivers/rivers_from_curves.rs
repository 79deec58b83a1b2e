//! Rivers along curves.

use crate::kit::curves::flatten::flatten;
use crate::kit::flow::join::{Polyline, join};
use crate::kit::flow::network::lower;
use crate::kit::rivers::drainage;
use crate::prelude::*;
use crate::value::Curve;
use crate::value::rivers::{MAX_VERTICES, RiverVertex};

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
        let joined = join(&lines, self.snap.0, &cx.work.stage(0.2, 0.5))?;
        let vertex = |&(at, down): &([f64; 3], Option<u32>)| RiverVertex {
            at: [at[0], at[1]],
            height: at[2],
            down,
            ..RiverVertex::default()
        };
        let vertices: Vec<RiverVertex> = joined.iter().map(vertex).collect();
        let fault =
            |e: crate::value::RiverFault| Error::Input { port: "curves".into(), message: e.to_string() };
        let (sorted, _) = Rivers::sorted(&vertices).map_err(fault)?;
        let mut vertices = sorted.vertices().to_vec();
        lower(&mut vertices);
        let bounds = cx.terrain()?.bounds();
        drainage::drain(&mut vertices, bounds, self.width.0, &cx.work.stage(0.5, 1.0))?;
        Ok(Outputs { rivers: Rivers::new(vertices).map_err(fault)? })
    }
}

fn too_many() -> Error {
    let message = format!("has more than {MAX_VERTICES} corners; raise `tolerance`");
    Error::Input { port: "curves".into(), message }
}
