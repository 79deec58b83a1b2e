//! How much of the sky a place sees.

use crate::kit::math::smooth;
use crate::kit::morphology;
use crate::kit::shifted::Shifted;
use crate::prelude::*;

/// Measures how much of the sky each place sees: valleys and pits are dark, ridges and plains bright.
///
/// In each of `directions` evenly spaced directions the horizon is the steepest angle `γ` at which the ground rises
/// within `radius`; the result is the sky-view factor `1 − mean(sin γ)` with `γ ≥ 0` \[zaksek2011\]. What lies in the
/// outer half of the radius counts less and less, so that no circle shows around a peak.
///
/// Each direction is sampled at every `detail` metres near by, then at four distances an octave, up to the radius;
/// the farther, the more the ground is smoothed first, in proportion to the distance between samples, so that no
/// peak is missed or seen twice \[crassin2011\].
///
/// # Differs from the paper
/// The paper looks at every cell along a direction; smoothing makes far and narrow peaks count a little less.
///
/// # Limits
/// With few directions a lone spike throws a star instead of a halo.
/// The detail that takes effect is a whole number of cells, one at least.
///
/// # See also
/// `hillshade`; `remap` for more contrast.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Occlusion {
    /// How far to look.
    #[schemars(range(min = 1.0, max = 20_000.0), extend("x-soft" = [50.0, 2000.0], "x-log" = true))]
    pub radius: Metres,
    /// How many directions to look in.
    #[schemars(range(min = 4, max = 64), extend("x-unit" = "1"))]
    pub directions: u32,
    /// Factor on the heights.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 10.0]))]
    pub exaggeration: Number,
    /// Distance to the nearest ground that can hide the sky; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub detail: Option<Metres>,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { radius: Metres(500.0), directions: 32, exaggeration: Number(1.0), detail: None }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// The share of the sky that is seen, 0 to 1.
        visibility: Field,
    }
}

impl Node for Occlusion {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zaksek2011", "crassin2011"])
        .keywords(&["ambient occlusion", "sky view factor", "ao", "horizon", "cavity", "shadow"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        Reach::local(1.5 * self.radius.0).plus_cells(8)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        let detail = self.detail.map_or(terrain.base_cell(), |m| m.0);
        window.grow_cells(Rays::new(self, window.cell(), detail).margins[0])
    }

    fn cost(&self, grid: &Grid) -> Cost {
        // The finest detail there can be: a coarser one looks less often and smooths less.
        let rays = Rays::new(self, grid.cell(), self.detail.map_or(grid.cell(), |m| m.0));
        let looks: usize = rays.directions.iter().map(Vec::len).sum();
        let smoothed = |margin: &i64| grid.grow_cells(*margin);
        let levels = rays.margins.iter().skip(1).map(smoothed);
        let passes: f64 = levels.clone().map(|g| g.len() as f64).sum();
        let largest = rays.margins.get(1).map_or(0, |m| grid.grow_cells(*m).len() as u64);
        let lines = 6 * grid.cols as u64 * rayon::current_num_threads() as u64;
        Cost {
            bytes: 4 * (levels.map(|g| g.len() as u64).sum::<u64>() + largest + lines),
            seconds: grid.len() as f64 * (8.0 * f64::from(self.directions) + 0.7 * looks as f64) * 1e-9
                + passes * 3e-9,
        }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let detail = self.detail.map_or_else(|| cx.base_cell(), |m| Ok(m.0))?;
        let rays = Rays::new(self, cx.grid.cell(), detail);
        let levels = rays.smoothed(&cx.stage(0.0, 0.15), input.height)?;
        let seen: Result<Vec<_>> =
            levels.iter().map(|level| Shifted::new("height", level, &cx.grid)).collect();
        let (seen, exaggeration) = (seen?, self.exaggeration.0 as f32);
        let share = 1.0 / rays.directions.len() as f32;
        let visibility = cx.stage(0.15, 1.0).fill(Quantity::Mask, |row, out| {
            let mut horizon = vec![0.0f32; out.len()];
            let mut hidden = vec![0.0f32; out.len()];
            for direction in &rays.directions {
                horizon.fill(0.0);
                direction.iter().for_each(|look| look.raise(&mut horizon, &seen, row.j));
                for (h, &tangent) in hidden.iter_mut().zip(&horizon) {
                    let tangent = (exaggeration * tangent).min(1e9);
                    *h += tangent / (1.0 + tangent * tangent).sqrt();
                }
            }
            for (o, &h) in out.iter_mut().zip(&hidden) {
                *o = (1.0 - h * share).clamp(0.0, 1.0);
            }
        })?;
        Ok(Outputs { visibility })
    }
}

/// Where to look, in cells.
struct Rays {
    directions: Vec<Vec<Look>>,
    /// How far the window of each level reaches beyond that of the output.
    margins: Vec<i64>,
    /// Cells between the nearest samples.
    unit: i64,
}

/// One sample along a direction, read between two samples of the lattice.
struct Look {
    level: usize,
    near: [i64; 2],
    far: [i64; 2],
    toward_far: f32,
    /// One over the distance, less what the outer half of the radius loses.
    per_metre: f32,
}

impl Rays {
    fn new(node: &Occlusion, cell: f64, detail: f64) -> Self {
        let unit = (detail / cell).round().max(1.0);
        let metres = unit * cell;
        let reach = (node.radius.0 / metres).max(2.0);
        let unit = unit.min(1e9) as i64;
        let directions: Vec<Vec<Look>> = (0..node.directions)
            .map(|i| direction(std::f64::consts::TAU * f64::from(i) / f64::from(node.directions), reach))
            .map(|looks| looks.into_iter().map(|look| look.in_cells(unit, metres)).collect())
            .collect();
        let mut margins = Vec::new();
        for look in directions.iter().flatten() {
            margins.resize(margins.len().max(look.level + 1), 0);
            let cells = look.near.iter().chain(&look.far).map(|c| c.abs()).max().unwrap_or(0);
            margins[look.level] = margins[look.level].max(cells);
        }
        // A level is smoothed from the one below, which must reach a little farther.
        for level in (1..margins.len()).rev() {
            margins[level - 1] = margins[level - 1].max(margins[level] + (unit << (level - 1)));
        }
        Self { directions, margins, unit }
    }

    /// The heights, and the heights smoothed by ever wider binomial kernels with holes.
    fn smoothed(&self, cx: &Context<'_>, height: Field) -> Result<Vec<Field>> {
        let mut levels = vec![height];
        let count = self.margins.len() as f32 - 1.0;
        for (level, margin) in self.margins.iter().enumerate().skip(1) {
            let cx = cx.stage((level - 1) as f32 / count, level as f32 / count);
            let window = cx.grid.grow_cells(*margin);
            let step = self.unit << (level - 1);
            let next = morphology::blend(&cx, "height", &levels[level - 1], &window, &[(step, 0.25)])?;
            levels.push(next);
        }
        Ok(levels)
    }
}

/// The looks along a direction, with offsets and distances in units, out to `reach`.
fn direction(angle: f64, reach: f64) -> Vec<Look> {
    // Exact zeros where the direction is an axis.
    let clean = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
    let (x, y) = (clean(libm::cos(angle)), clean(libm::sin(angle)));
    let (major, minor) = if x.abs() >= y.abs() { (x, y) } else { (y, x) };
    let place = |m: i64, n: i64| if x.abs() >= y.abs() { [m, n] } else { [n, m] };
    let mut looks: Vec<Look> = Vec::new();
    let mut last = 0;
    for (level, nominal) in distances() {
        let steps = (nominal * major.abs()).round().max(1.0);
        let distance = steps / major.abs();
        if distance >= reach {
            break;
        }
        if steps as i64 == last {
            continue;
        }
        last = steps as i64;
        let aside = steps * minor / major.abs();
        let (floor, along) = (aside.floor(), last * major.signum() as i64);
        let fade = 1.0 - smooth((2.0 * distance / reach - 1.0) as f32);
        looks.push(Look {
            level,
            near: place(along, floor as i64),
            far: place(along, floor as i64 + 1),
            toward_far: (aside - floor) as f32,
            per_metre: fade / distance as f32,
        });
    }
    looks
}

/// Distances in units with the level of smoothing to read there: 1, 2, 3, then four an octave.
fn distances() -> impl Iterator<Item = (usize, f64)> {
    let near = (1..4).map(|d| (0, f64::from(d)));
    let octaves = (0..40).flat_map(|level: i32| {
        let first = (1_i64 << level) as f64;
        (4..8).map(move |quarter| (level as usize, f64::from(quarter) * first))
    });
    near.chain(octaves)
}

impl Look {
    fn in_cells(self, unit: i64, metres: f64) -> Self {
        let cells = |offset: [i64; 2]| offset.map(|c| c * unit);
        let per_metre = self.per_metre / metres as f32;
        Self { near: cells(self.near), far: cells(self.far), per_metre, ..self }
    }

    /// Raises the tangents of the horizon of a row to what is seen here.
    fn raise(&self, horizon: &mut [f32], levels: &[Shifted<'_>], j: usize) {
        let here = levels[0].line(j, [0, 0]);
        let near = levels[self.level].line(j, self.near);
        let raised = |old: &mut f32, rise: f32| {
            let tangent = rise * self.per_metre;
            *old = if tangent > *old { tangent } else { *old };
        };
        if self.toward_far == 0.0 {
            let rises = near.iter().zip(&*here).map(|(n, h)| n - h);
            horizon.iter_mut().zip(rises).for_each(|(old, rise)| raised(old, rise));
            return;
        }
        let far = levels[self.level].line(j, self.far);
        let rises = near.iter().zip(&*far).zip(&*here).map(|((n, f), h)| (n - h) + self.toward_far * (f - n));
        horizon.iter_mut().zip(rises).for_each(|(old, rise)| raised(old, rise));
    }
}
