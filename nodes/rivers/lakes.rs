//! The lakes of a land.

use crate::kit::flow::{self, Depressions, Puddles, Surface};
use crate::kit::rows::by_index;
use crate::prelude::*;

/// Cells around a lake that have its level, so that a finer grid finds it level up to the shore.
const MARGIN: usize = 2;

/// Finds the lakes of a land: what stands in its depressions when they are full.
///
/// A lake is connected ground that lies below the level of its depression, the least height that water must climb on any
/// way from there to the sea or over the border of the terrain \[barnes2014, cordonnier2019\]. Its level is the same
/// everywhere in the lake and two cells of the base grid beyond. The label numbers the lakes from 1, in the order of their
/// first samples from the north-west; it also covers the shores within those two cells, where the ground rises out of the
/// water, and is 0 elsewhere.
///
/// # Limits
/// It runs on the base grid. Water that is smaller or shallower than the least lake is none.
///
/// # See also
/// `water_depth` for the water on the ground of any size, `fill_depressions` for ground without depressions.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Lakes {
    /// Least area of a lake.
    #[schemars(range(min = 0.0, max = 1e12), extend("x-soft" = [0.0, 1e6]))]
    pub smallest: SquareMetres,
    /// Least depth of a lake at its deepest place.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 20.0]))]
    pub shallowest: Metres,
}

impl Default for Lakes {
    fn default() -> Self {
        Self { smallest: SquareMetres(20_000.0), shallowest: Metres(1.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// Level of the water in lakes and just beyond; the height of the ground elsewhere.
        level: Field = Meaning::Fixed(Quantity::Elevation),
        /// The number of the lake, from 1; 0 where there is none.
        label: Field = Meaning::Fixed(Quantity::Label),
    }
}

impl Node for Lakes {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["barnes2014", "cordonnier2019"])
        .keywords(&["water", "pond", "tarn", "depression", "level"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 120.0).with_fields(grid, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let depressions = Depressions::find(&surface, &cx.work.stage(0.0, 0.5))?;
        let puddles = Puddles { area: self.smallest.0, depth: self.shallowest.0 };
        let lakes = flow::Lakes::find(&surface, &depressions, puddles, &cx.work.stage(0.5, 0.7))?;
        drop(depressions);
        let widened = lakes.widened(&surface, MARGIN, &cx.work.stage(0.7, 0.8))?;
        let shores = lakes.with_shores(&surface, &widened, &cx.work.stage(0.8, 0.9))?;
        let level = |i: usize| lakes.lake(widened[i]).map_or(height.data()[i], |lake| lake.level);
        let level = by_index(&cx.work.stage(0.9, 0.95), &cx.grid, Quantity::Elevation, level)?;
        let label = |i: usize| shores[i] as f32;
        let label = by_index(&cx.work.stage(0.95, 1.0), &cx.grid, Quantity::Label, label)?;
        Ok(Outputs { level, label })
    }
}
