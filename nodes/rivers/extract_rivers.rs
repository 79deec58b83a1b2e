//! The rivers of a land.

use crate::kit::flow::{Surface, Tree, accumulate, network, streams};
use crate::kit::rows::by_index;
use crate::prelude::*;
use crate::value::rivers::{MAX_VERTICES, RiverFault, RiverVertex};

/// Finds the rivers of a land: where the land that drains through is large enough.
///
/// Water goes to the neighbour of steepest descent, and out of a depression over its lowest pass (`flow_routing`, D8). A
/// sample through which at least `threshold` drains belongs to a river \[ocallaghan1984\], down to the outlet in the sea or
/// on the border. A vertex stands on each such sample; between sources, mouths and confluences the line is smoothed, since a
/// grid knows eight directions only. Beds are at the height of the ground, lowered where a river crosses a pass, so that
/// they fall all the way. A river is `width · √(A / 1 km²)` wide, where it drains `A` \[leopold1953\].
///
/// # Limits
/// It runs on the base grid. The threshold decides where rivers begin: where channels really do hangs on rain, soil and
/// slope.
///
/// # See also
/// `extract_ridges` for what lies between, `curves_from_rivers` to make land of them, `carve_rivers` to cut their beds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExtractRivers {
    /// Land that must drain through a place to make it a river.
    #[schemars(range(min = 1.0, max = 1e12), extend("x-soft" = [1e4, 1e7], "x-log" = true))]
    pub threshold: SquareMetres,
    /// Width of a river that drains a square kilometre.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.5, 20.0]))]
    pub width: Metres,
    /// How far along the river its line is smoothed; none for two cells of the base grid.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub smoothing: Option<Metres>,
}

impl Default for ExtractRivers {
    fn default() -> Self {
        Self { threshold: SquareMetres(500_000.0), width: Metres(2.5), smoothing: None }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// The network.
        rivers: Rivers,
        /// 1 on the samples of rivers, 0 elsewhere.
        mask: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for ExtractRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["ocallaghan1984", "leopold1953", "cordonnier2019"])
        .keywords(&["stream", "channel", "drainage", "network", "hydrology"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        cost(grid, self.threshold.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let smoothing = self.smoothing.map_or(2.0 * cx.grid.cell(), |metres| metres.0);
        let style = network::Style { smoothing, width: self.width.0, falls: true };
        let (vertices, mask) = extract(cx, &surface, self.threshold.0, style)?;
        let fault = |e: RiverFault| Error::Output { port: "rivers".into(), message: e.to_string() };
        Ok(Outputs { rivers: Rivers::new(vertices).map_err(fault)?, mask })
    }
}

/// The vertices of the streams of a surface, and where they are.
///
/// # Errors
/// When there are more than a network holds, or the work is cancelled.
pub(super) fn extract(
    cx: &Context<'_>,
    surface: &Surface<'_>,
    threshold: f64,
    style: network::Style,
) -> Result<(Vec<RiverVertex>, Field)> {
    let tree = Tree::of(surface, &cx.work.stage(0.0, 0.5))?;
    let count = accumulate::count(&tree, |i| surface.is_land(i), &cx.work.stage(0.5, 0.7))?;
    let cell = cx.grid.cell() * cx.grid.cell();
    let area = |i: usize| f64::from(count[i]) * cell;
    let is_river = |i: usize| surface.is_land(i) && area(i) >= threshold;
    let mask = |i: usize| f32::from(u8::from(is_river(i)));
    let mask = by_index(&cx.work.stage(0.7, 0.75), &cx.grid, Quantity::Mask, mask)?;
    let stream = streams::trace(&tree, is_river, &cx.work.stage(0.75, 0.9))?;
    if stream.len() > MAX_VERTICES {
        let message = format!("must leave at most {MAX_VERTICES} samples of rivers, got {}", stream.len());
        return Err(Error::Parameter { name: "threshold".into(), message });
    }
    Ok((network::vertices(surface, &cx.grid, &stream, area, style, &cx.work.stage(0.9, 1.0))?, mask))
}

/// What finding streams takes: the flow, and for each sample of a stream its vertex, twice as smoothing moves it. Real land has about one such sample to a width of `√threshold`; three are counted.
pub(super) fn cost(grid: &Grid, threshold: f64) -> Cost {
    let share = (3.0 * grid.cell() / threshold.max(1e-9).sqrt()).min(1.0);
    let streams = (grid.len() as f64 * share).min(MAX_VERTICES as f64);
    let cost = Cost::per_sample(grid, 150.0).with_fields(grid, 6.0);
    Cost { bytes: cost.bytes + (streams * 150.0) as u64, ..cost }
}
