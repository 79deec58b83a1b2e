//! How wet the ground is.

use crate::kit::flow::{Depressions, Rule, Spread, Surface, accumulate, wetness};
use crate::kit::rows::by_index;
use crate::prelude::*;

/// Freeman's power of the slope, by which the water of a sample is divided.
const EXPONENT: f64 = 1.1;

/// Measures how wet the ground is: by the land that drains through it, and by its height above the nearest river.
///
/// The topographic wetness index is `ln(a / tan β)` \[beven1979\]: `a` is the land that drains through a metre of contour, in
/// m, divided over all lower neighbours (`flow_routing`, MFD with exponent 1.1), and `tan β` the slope towards the next
/// sample on the way of the water, `least_slope` at the least. It is about 5 on ridges and over 12 in wet hollows.
///
/// The height above the river is that over the place where the water of a sample first meets a river on its way (HAND)
/// \[nobre2011\]. A river is where the land that drains through is at least `threshold`, and any outlet. Floods, springs and
/// the plants of river banks follow it.
///
/// # Limits
/// It runs on the base grid.
///
/// # See also
/// `flow_routing`, `extract_rivers`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Wetness {
    /// Land that must drain through a place to make it a river.
    #[schemars(range(min = 1.0, max = 1e12), extend("x-soft" = [1e4, 1e7], "x-log" = true))]
    pub threshold: SquareMetres,
    /// Slope that level ground counts as, in metres per metre.
    #[schemars(range(min = 1e-6, max = 1.0), extend("x-soft" = [1e-4, 0.1], "x-log" = true))]
    pub least_slope: Number,
}

impl Default for Wetness {
    fn default() -> Self {
        Self { threshold: SquareMetres(500_000.0), least_slope: Number(1e-3) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// Topographic wetness index; 0 in the sea.
        index: Field = Meaning::Fixed(Quantity::Number),
        /// Height above the nearest river downstream, in metres.
        above_river: Field = Meaning::Fixed(Quantity::Distance),
    }
}

impl Node for Wetness {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["beven1979", "nobre2011", "freeman1991"])
        .keywords(&["twi", "hand", "moisture", "soil", "flood", "riparian", "swamp"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 1000.0).with_fields(grid, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let cell = cx.grid.cell();
        let depressions = Depressions::find(&surface, &cx.work.stage(0.0, 0.25))?;
        let filled = depressions.filled(&surface, &cx.work.stage(0.25, 0.3))?;
        let tree = depressions.into_tree(&surface, &cx.work)?;
        let index = {
            let land = |i: usize| if surface.is_land(i) { cell * cell } else { 0.0 };
            let spread = Spread::new(surface, &tree, &filled, Rule::Slopes { exponent: EXPONENT });
            let area =
                spread.accumulate(accumulate::each(tree.cells, land, &cx.work)?, &cx.work.stage(0.3, 0.7))?;
            let index = |i: usize| {
                if !surface.is_land(i) {
                    return 0.0;
                }
                let drop = |down: usize| f64::from(filled[i]) - f64::from(filled[down]);
                let slope = tree.receiver(i).map_or(0.0, |down| drop(down) / tree.length(i));
                wetness::index(area[i], cell, slope, self.least_slope.0) as f32
            };
            by_index(&cx.work.stage(0.7, 0.8), &cx.grid, Quantity::Number, index)?
        };
        drop(filled);
        let count = accumulate::count(&tree, |i| surface.is_land(i), &cx.work.stage(0.8, 0.9))?;
        let is_river = |i: usize| f64::from(count[i]) * cell * cell >= self.threshold.0;
        let above = wetness::above_river(&tree, |i| surface.at(i), is_river, &cx.work.stage(0.9, 1.0))?;
        let above_river = Field::new(cx.grid, Quantity::Distance, above);
        Ok(Outputs { index, above_river })
    }
}
