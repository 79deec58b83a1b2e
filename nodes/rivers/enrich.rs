//! Samples beside a skeleton.

use crate::kit::distance;
use crate::kit::land::{self, Bits, Enrichment};
use crate::prelude::*;

/// Fills samples beside rivers and ridges by midpoint displacement, as soft hints for the land between.
///
/// Round `r` works on squares of `2^r` base cells. An unknown corner becomes the mean of the known centres and edge
/// midpoints of its four squares, weighted by one over the distance (the inverse of midpoint displacement); then, from that
/// size down to single cells, unknown centres are filled from two or more corners, and unknown midpoints of edges from two
/// or more of their ends and of the centres beside them \[zhang2016, section 5.B\]. A sample gets
/// `displacement · d · noise`, with `d` the distance it is filled over and noise of standard deviation 1. Nothing is filled
/// over more than `reach`, and what is known keeps its value to the bit.
///
/// `weight` is 1 on what was known. Beside it, where samples were filled, it is `hold · (1 − d / reach)`, with `d` the
/// distance to what was known.
///
/// # Differs from the paper
/// The paper holds what is filled as strictly as the skeleton. That makes benches and cliffs, and half of the rivers no
/// longer drain: so give `weight` to `diffuse_points`, and set it to take `known` as weights.
///
/// # Limits
/// It runs on the base grid. Rivers and ridges should lie some 8 base cells apart or more: where they are nearer, filled
/// squares of 4 cells cover all the land.
///
/// # See also
/// `skeleton_raster` makes what it reads, `diffuse_points` makes land of what it gives.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Enrich {
    /// Rounds: the last works on squares of 2 to that power base cells.
    #[schemars(range(min = 1, max = 6), extend("x-unit" = "1"))]
    pub rounds: u32,
    /// Largest distance over which a sample is filled, and the distance at which weights are gone.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [10.0, 500.0], "x-log" = true))]
    pub reach: Metres,
    /// Noise, in metres for each metre of distance.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-soft" = [0.0, 0.2]))]
    pub displacement: Number,
    /// Weight of filled samples beside the skeleton.
    pub hold: Ratio,
    /// Chooses another noise of the same kind.
    pub seed: Seed,
}

impl Default for Enrich {
    fn default() -> Self {
        Self { rounds: 3, reach: Metres(64.0), displacement: Number(0.03), hold: Ratio(0.3), seed: Seed(0) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights, in metres, that count where they are known.
        height: Field,
        /// Where they are known: from 0.5 on.
        known: Field,
    }
    pub struct Outputs {
        /// Heights with those that were filled.
        height: Field = Meaning::like("height"),
        /// How far each counts: 1 where it was known, less where it was filled, 0 elsewhere.
        weight: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for Enrich {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zhang2016", "fournier1982", "belhadj2005"])
        .keywords(&["midpoint displacement", "skeleton", "fractal", "constraint", "weights"])
        .reads(Reads::SEED);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let nanoseconds = 20.0 + 12.0 * f64::from(self.rounds);
        // Bits for what is known, a list of rows, the crops, and the distances.
        let cost = Cost::per_sample(grid, nanoseconds).with_fields(grid, 3.1);
        let rows = 64 * grid.rows as u64;
        Cost { bytes: cost.bytes + rows + distance::scratch(grid, self.measured(grid)), ..cost }
    }

    fn run(&self, cx: &Context<'_>, Inputs { height, known }: Inputs) -> Result<Outputs> {
        let (height, known) = (height.crop(&cx.grid), known.crop(&cx.grid));
        let is_known = |k: f32| k >= 0.5;
        let how = Enrichment {
            rounds: self.rounds,
            limit: self.reach.0 / cx.grid.cell(),
            displacement: self.displacement.0 * cx.grid.cell(),
            seed: cx.seed(self.seed)?,
        };
        let cols = cx.grid.cols;
        let bits = Bits::of(cols, known.data(), |k| is_known(*k));
        let enriched = land::enrich(cols, height.data().to_vec(), bits, &how, &cx.work.stage(0.0, 0.6))?;
        let far =
            distance::to_set(&cx.work.stage(0.6, 0.9), &known, &cx.grid, self.measured(&cx.grid), is_known)?;
        let (hold, reach) = (self.hold.0 as f32, self.reach.0.max(f64::MIN_POSITIVE) as f32);
        let weight = cx.stage(0.9, 1.0).fill(Quantity::Mask, |row, out: &mut [f32]| {
            for (i, (o, &d)) in out.iter_mut().zip(far.row(row.j)).enumerate() {
                *o = if d == 0.0 {
                    1.0
                } else if enriched.known.has([i, row.j]) {
                    hold * (1.0 - d / reach).max(0.0)
                } else {
                    0.0
                };
            }
        })?;
        Ok(Outputs { height: Field::new(cx.grid, height.quantity(), enriched.field), weight })
    }
}

impl Enrich {
    /// Metres within which distances are measured: none on the grid is longer than its diagonal.
    fn measured(&self, grid: &Grid) -> f64 {
        let bounds = grid.bounds();
        self.reach.0.min(libm::hypot(bounds.width(), bounds.depth()))
    }
}
