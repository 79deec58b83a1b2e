//! Ridges between rivers.

use super::network;
use crate::kit::rivers::ridges::{Heights, ridges};
use crate::prelude::*;
use crate::value::Bounds;

/// Finds the ridges between rivers: the edges of the Voronoi diagram of their vertices that no river crosses.
///
/// An edge is cut where a link joins the two vertices that it parts, or touches it [zhang2016, section V.A]. A ridge vertex
/// is as high as the highest of the three rivers nearest to it, and rises from there by `rise` times its distance d to them
/// (4): their places are the corners of its Delaunay triangle. The rise levels off, `rise · reach · (1 - exp(-d / reach))`,
/// so that wide land is no spike. Then heights are smoothed along the ridges, never below the rivers beside them.
///
/// No ridge stands inside the bend of a river: where the way along the rivers from one side to the other is shorter than
/// `detour` times the straight one.
///
/// The order of a ridge is the lower of the Strahler orders that the two rivers have where they meet: 1 between two
/// sources, high on a main divide.
///
/// # Differs from the paper
/// The height of (4) does not level off there, and edges are not clipped: circles through three nodes nearly on a line have
/// centres, and ridges heights, beyond any measure. Here edges end at the border of the land that terrain and rivers
/// take together.
///
/// # Limits
/// Vertices that stand at one place are one. No river gives no ridge, and one vertex alone neither.
///
/// # See also
/// `river_profile` sets the heights of the rivers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct VoronoiRidges {
    /// Rise of ridges from the rivers beside them, α, as a tangent.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-soft" = [0.0, 1.5]))]
    pub rise: Number,
    /// Distance from rivers over which the rise levels off.
    #[schemars(range(min = 1.0, max = 1_000_000.0), extend("x-soft" = [50.0, 3000.0]))]
    pub reach: Metres,
    /// Rounds of smoothing along ridges.
    #[schemars(range(min = 0, max = 50), extend("x-unit" = "1"))]
    pub smooth: u32,
    /// Between two places of one network there is a ridge where the way from one to the other along the rivers is this many
    /// times as long as the straight one. 1 gives every bend of a river a spur of its own.
    #[schemars(range(min = 1.0, max = 10.0), extend("x-soft" = [1.0, 2.0]))]
    pub detour: Number,
}

impl Default for VoronoiRidges {
    fn default() -> Self {
        Self { rise: Number(0.5), reach: Metres(600.0), smooth: 2, detour: Number(1.3) }
    }
}

ports! {
    pub struct Inputs {
        /// The rivers.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// The ridges.
        ridges: Ridges,
    }
}

impl Node for VoronoiRidges {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().reads(Reads::TERRAIN).cite(&["zhang2016", "shewchuk1997"]).keywords(&[
        "ridge",
        "divide",
        "watershed",
        "crest",
        "voronoi",
        "delaunay",
        "skeleton",
    ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        network::cost(network::vertices(load), 700.0, 10.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers }: Inputs) -> Result<Outputs> {
        if rivers.is_empty() {
            return Ok(Outputs { ridges: Ridges::default() });
        }
        let terrain = cx.terrain()?.bounds();
        let places = rivers.vertices().iter().map(|vertex| vertex.at);
        let bounds = Bounds::around(places.chain([terrain.min, terrain.max])).unwrap_or(terrain);
        let heights =
            Heights { rise: self.rise.0, reach: self.reach.0, rounds: self.smooth, detour: self.detour.0 };
        let found = ridges(rivers.vertices(), bounds, heights, &cx.work)?;
        let wrong = |fault: crate::value::RidgeFault| Error::Output {
            port: "ridges".into(),
            message: format!("has a fault: {fault}"),
        };
        Ok(Outputs { ridges: Ridges::new(found.vertices, found.edges).map_err(wrong)? })
    }
}
