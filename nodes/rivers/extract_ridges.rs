//! The ridges of a land.

use super::extract_rivers::{cost, extract};
use crate::kit::flow::{Surface, network};
use crate::kit::rows::by_index;
use crate::prelude::*;
use crate::value::{RidgeEdge, RidgeVertex, RiverVertex};

/// Finds the ridges of a land: the rivers of the same land upside down.
///
/// On the surface of negative heights water runs along the ridges, from spurs to peaks, and from peak to peak over the
/// saddles \[zhang2016\]. What at least `threshold` of land drains to in this way is a ridge. Its order is Strahler's, 1 at
/// the end of a spur and higher where ridges meet. The sea, and the border where the land is highest, end the ridges.
///
/// # Limits
/// It runs on the base grid. The ridges part the land of no particular rivers, and name none.
///
/// # See also
/// `extract_rivers`, `watersheds` for divides that close.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExtractRidges {
    /// Land that must lie at the foot of a place to make it a ridge.
    #[schemars(range(min = 1.0, max = 1e12), extend("x-soft" = [1e4, 1e7], "x-log" = true))]
    pub threshold: SquareMetres,
    /// How far along the ridge its line is smoothed; none for two cells of the base grid.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub smoothing: Option<Metres>,
}

impl Default for ExtractRidges {
    fn default() -> Self {
        Self { threshold: SquareMetres(500_000.0), smoothing: None }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// The ridges.
        ridges: Ridges,
        /// 1 on the samples of ridges, 0 elsewhere.
        mask: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for ExtractRidges {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zhang2016", "ocallaghan1984"])
        .keywords(&["crest", "divide", "watershed", "spur", "network"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        cost(grid, self.threshold.0).with_fields(grid, 1.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let ground = Surface::of(&height, cx.terrain()?.sea_level);
        let turned = |i: usize| if ground.is_land(i) { -ground.at(i) } else { f32::NAN };
        let turned = by_index(&cx.work.stage(0.0, 0.05), &cx.grid, Quantity::Elevation, turned)?;
        let surface = Surface::of(&turned, None);
        let smoothing = self.smoothing.map_or(2.0 * cx.grid.cell(), |metres| metres.0);
        let style = network::Style { smoothing, width: 0.0, falls: false };
        let (vertices, mask) = extract(&cx.stage(0.05, 0.95), &surface, self.threshold.0, style)?;
        let fault = |message: String| Error::Output { port: "ridges".into(), message };
        let network = Rivers::new(vertices).map_err(|e| fault(e.to_string()))?;
        let top = |v: &RiverVertex| RidgeVertex { at: v.at, height: -v.height };
        let edge = |(upper, lower): (usize, usize)| RidgeEdge {
            ends: [upper as u32, lower as u32],
            rivers: [u32::MAX; 2],
            order: network.vertices()[upper].order,
        };
        let (tops, edges) =
            (network.vertices().iter().map(top).collect(), network.links().map(edge).collect());
        Ok(Outputs { ridges: Ridges::new(tops, edges).map_err(|e| fault(e.to_string()))?, mask })
    }
}
