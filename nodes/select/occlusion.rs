//! How much of the sky a place sees.

use crate::kit::derivative;
use crate::kit::far::{Extents, Far, Place, Sight};
use crate::kit::math::smooth;
use crate::kit::morphology;
use crate::kit::shifted::Shifted;
use crate::kit::simd::{self, Kernel};
use crate::prelude::*;
use crate::value::Lattice;

/// Measures how much of the sky each place sees: valleys and pits are dark, ridges and plains bright.
///
/// In each of `directions` evenly spaced directions the horizon is the steepest angle `γ` at which the ground rises
/// within `radius`; the result is the sky-view factor `1 − mean(sin γ)` with `γ ≥ 0` \[zaksek2011\]. What lies in the
/// outer half of the radius counts less and less, so that no circle shows around a peak.
///
/// Each direction is sampled at every `detail` metres near by, then at four distances an octave, up to the radius;
/// the farther, the more the ground is smoothed first, in proportion to the distance between samples, so that no
/// peak is missed or seen twice \[crassin2011\]. Where the samples are less than two base cells apart, they are read on
/// the build's own grid; farther away on the base grid, smoothed level by level, so that a wide radius asks no more of
/// a huge build than of a small one.
///
/// # Differs from the paper
/// The paper looks at every cell along a direction; smoothing makes far and narrow peaks count a little less.
///
/// # Limits
/// With few directions a lone spike throws a star instead of a halo.
/// The detail that takes effect is at least one cell of the build, or of the base grid where the build is coarser; such
/// a build reads the near ground on a finer grid, so that it sees the same sky. At sizes between two whole fractions
/// of the base grid that grid's cell is up to twice the base cell, and the near ground as much coarser.
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
        visibility: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for Occlusion {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zaksek2011", "crassin2011"])
        .keywords(&["ambient occlusion", "sky view factor", "ao", "horizon", "cavity", "shadow"])
        .reads(Reads::BASE)
        .migrations(&[|_| ()]);

    fn reach(&self) -> Reach {
        Reach::local(1.5 * self.radius.0).plus_cells(8)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        let rays = Rays::new(self, window.lattice, terrain.base_lattice());
        window.refined(rays.refinement).grow_cells(rays.near[0])
    }

    fn views(&self, _: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid> {
        let base = terrain.base_lattice();
        let rays = Rays::new(self, window.lattice, base);
        Extents::new(window, base, &rays.far).field().into_iter().collect()
    }

    fn cost(&self, Load { grid, terrain, .. }: &Load<'_>) -> Cost {
        let base = terrain.base_grid();
        let lattice = base.lattice;
        let rays = Rays::new(self, grid.lattice, lattice);
        // What lies beyond the apron is not there to be smoothed.
        let apron = base.grow_cells(i64::from(lattice.intervals.div_ceil(2)));
        let far = Extents::new(grid, lattice, &rays.far).within(&apron);
        let near = rays.near.iter().skip(1).map(|margin| grid.grow_cells(*margin).len() as u64);
        let largest = rays.near.get(1).map_or(0, |margin| grid.grow_cells(*margin).len() as u64);
        let lines = 6 * grid.cols as u64 * rayon::current_num_threads() as u64;
        let smoothed = near.clone().sum::<u64>();
        let looks: usize = rays.directions.iter().map(|d| d.near.len() + d.far.len()).sum();
        Cost {
            bytes: 4 * (smoothed + largest + lines) + far.bytes(grid, lattice),
            seconds: grid.len() as f64 * (2.5 * f64::from(self.directions) + 0.5 * looks as f64) * 1e-9
                + (2 * smoothed + far.work(grid, lattice)) as f64 * 1.5e-9,
        }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let base = cx.base_lattice()?;
        let rays = Rays::new(self, cx.grid.lattice, base);
        let levels = rays.smoothed(&cx.stage(0.0, 0.1), input.height)?;
        let near: Result<Vec<_>> =
            levels.iter().map(|level| Shifted::new("height", level, &cx.grid)).collect();
        let (near, extents) = (near?, Extents::new(&cx.grid, base, &rays.far));
        let far = match extents.field() {
            Some(_) => {
                let field = cx.view("height", 0)?;
                let far = Far::new(&cx.work.stage(0.1, 0.2), "height", field, &cx.grid, base, &extents)?;
                let places = rays
                    .directions
                    .iter()
                    .map(|d| d.far.iter().map(|look| far.place(look.level, look.offset)).collect());
                let places = places.collect();
                Some((far, places))
            }
            None => None,
        };
        let sky = Sky { exaggeration: self.exaggeration.0 as f32, directions: &rays.directions, near, far };
        let visibility = cx.stage(0.2, 1.0).fill(Quantity::Mask, |row, out| {
            simd::Level::best().run(SkyRow { sky: &sky, row, out });
        })?;
        Ok(Outputs { visibility })
    }
}

/// Where to look from every sample.
struct Rays {
    directions: Vec<Direction>,
    /// How many times finer than the build the lattice is on which the near ground is read.
    refinement: u32,
    /// Cells between the samples of the finest level, there.
    unit: f64,
    /// Cells that each level of the near ground reaches beyond the window, there.
    near: Vec<i64>,
    /// Base cells that each level of the far ground reaches beyond the window.
    far: Vec<f64>,
}

/// The looks along a direction.
#[derive(Default)]
struct Direction {
    near: Vec<Near>,
    far: Vec<Distant>,
}

/// A look at the near ground, between two of its samples.
struct Near {
    level: usize,
    left: [i64; 2],
    right: [i64; 2],
    toward_right: f32,
    /// One over the distance, less what the outer half of the radius loses.
    per_metre: f32,
}

/// A look at the far ground.
struct Distant {
    level: usize,
    /// Base cells to the east and south.
    offset: [f64; 2],
    per_metre: f32,
}

impl Rays {
    fn new(node: &Occlusion, build: Lattice, base: Lattice) -> Self {
        let wanted = node.detail.map_or(base.cell(), |m| m.0);
        let refinement = derivative::refinement(build.cell(), wanted, base.cell());
        let cell = build.refined(refinement).cell();
        let detail = wanted.max(cell);
        let scale = Scale { detail, cell, base: base.cell(), reach: (node.radius.0 / detail).max(2.0) };
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(node.directions);
        let directions: Vec<Direction> = (0..node.directions).map(|i| scale.direction(angle(i))).collect();
        let (mut near, mut far, unit) = (vec![0], Vec::new(), snapped(detail / cell));
        for look in directions.iter().flat_map(|d| &d.near) {
            near.resize(near.len().max(look.level + 1), 0);
            let cells = look.left.iter().chain(&look.right).map(|c| c.abs()).max().unwrap_or(0);
            near[look.level] = near[look.level].max(cells);
        }
        // A level is smoothed from the one below, which must reach a little farther.
        for level in (1..near.len()).rev() {
            near[level - 1] = near[level - 1].max(near[level] + hole(unit, level));
        }
        for look in directions.iter().flat_map(|d| &d.far) {
            far.resize(far.len().max(look.level + 1), 0.0f64);
            let cells = look.offset.iter().fold(0.0f64, |most, c| most.max(c.abs()));
            far[look.level] = far[look.level].max(cells);
        }
        Self { directions, refinement, unit, near, far }
    }

    /// The heights near by, and the heights smoothed by ever wider binomial kernels with holes.
    fn smoothed(&self, cx: &Context<'_>, height: Field) -> Result<Vec<Field>> {
        let mut levels = vec![height];
        let count = self.near.len() as f32 - 1.0;
        for (level, margin) in self.near.iter().enumerate().skip(1) {
            let work = cx.work.stage((level - 1) as f32 / count, level as f32 / count);
            let window = cx.grid.refined(self.refinement).grow_cells(*margin);
            let step = hole(self.unit, level);
            let next = morphology::blend(&work, "height", &levels[level - 1], &window, &[(step, 0.25)])?;
            levels.push(next);
        }
        Ok(levels)
    }
}

/// Cells from the middle to the ends of the kernel that makes a level of the near ground.
fn hole(unit: f64, level: usize) -> i64 {
    (unit * (1_i64 << (level - 1)) as f64).round() as i64
}

/// The whole number that a quotient stands for, where it is all but one.
fn snapped(quotient: f64) -> f64 {
    let whole = quotient.round();
    if (quotient - whole).abs() <= 1e-9 * whole { whole } else { quotient }
}

/// The lengths that decide where to look, in metres, and how many details to look far.
struct Scale {
    detail: f64,
    cell: f64,
    base: f64,
    reach: f64,
}

impl Scale {
    fn direction(&self, angle: f64) -> Direction {
        // Exact zeros where the direction is an axis.
        let clean = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
        let (x, y) = (clean(libm::cos(angle)), clean(libm::sin(angle)));
        let (eastward, (major, minor)) = if x.abs() >= y.abs() { (true, (x, y)) } else { (false, (y, x)) };
        let (mut direction, mut last) = (Direction::default(), 0.0);
        for (level, nominal) in distances() {
            let steps = (nominal * major.abs()).round().max(1.0);
            let distance = steps / major.abs();
            if distance >= self.reach {
                break;
            }
            if steps == last {
                continue;
            }
            last = steps;
            let fade = 1.0 - smooth((2.0 * distance / self.reach - 1.0) as f32);
            let [along, aside] = [steps * major.signum(), steps * minor / major.abs()];
            let between = self.detail * (1_i64 << level) as f64;
            // Ground whose samples are two base cells apart is as well read on the base grid.
            if between < 2.0 * self.base * (1.0 - 1e-9) {
                direction.near.push(self.near(level, [along, aside], eastward, fade));
            } else {
                let level = ((snapped(between / self.base) as u64).max(1)).ilog2() as usize;
                let cells = [along, aside].map(|v| v * snapped(self.detail / self.base));
                let offset = if eastward { cells } else { [cells[1], cells[0]] };
                let per_metre = fade / (distance * self.detail) as f32;
                direction.far.push(Distant { level, offset, per_metre });
            }
        }
        direction
    }

    /// A look at the near ground, between the two samples that lie nearest.
    fn near(&self, level: usize, [along, aside]: [f64; 2], eastward: bool, fade: f32) -> Near {
        let unit = snapped(self.detail / self.cell);
        let cells = |details: f64| (details * unit).round();
        let (floor, toward_right) = (aside.floor(), (aside - aside.floor()) as f32);
        let (along, left, right) = (cells(along), cells(floor), cells(floor + 1.0));
        let place = |aside: f64| {
            if eastward { [along as i64, aside as i64] } else { [aside as i64, along as i64] }
        };
        let aside = left + (right - left) * (aside - floor);
        let distance = self.cell * libm::sqrt(along * along + aside * aside);
        let per_metre = fade / distance as f32;
        Near { level, left: place(left), right: place(right), toward_right, per_metre }
    }
}

/// Distances in details with the level of smoothing to read there: 1, 2, 3, then four an octave.
fn distances() -> impl Iterator<Item = (usize, f64)> {
    let near = (1..4).map(|d| (0, f64::from(d)));
    let octaves = (0..40).flat_map(|level: i32| {
        let first = (1_i64 << level) as f64;
        (4..8).map(move |quarter| (level as usize, f64::from(quarter) * first))
    });
    near.chain(octaves)
}

/// What the rows of the result are made from.
struct Sky<'a> {
    exaggeration: f32,
    directions: &'a [Direction],
    near: Vec<Shifted<'a>>,
    far: Option<(Far, Vec<Vec<Place>>)>,
}

/// One row of the result.
struct SkyRow<'a> {
    sky: &'a Sky<'a>,
    row: Row,
    out: &'a mut [f32],
}

impl Kernel for SkyRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { sky, row, out } = self;
        let here = sky.near[0].line(row.j, [0, 0]);
        let mut horizon = vec![0.0f32; out.len()];
        let mut scratch = Vec::new();
        out.fill(0.0);
        for (i, direction) in sky.directions.iter().enumerate() {
            horizon.fill(0.0);
            for look in &direction.near {
                let level = &sky.near[look.level];
                let near = level.line(row.j, look.left);
                let far = if look.toward_right == 0.0 { None } else { Some(level.line(row.j, look.right)) };
                let far = far.as_deref().unwrap_or(&near);
                let sight = Sight { near: [&near; 2], far: [far; 2], along: look.toward_right, down: 0.0 };
                raise(&mut horizon, &here, sight, look.per_metre);
            }
            if let Some((far, places)) = &sky.far {
                for (look, place) in direction.far.iter().zip(&places[i]) {
                    raise(&mut horizon, &here, far.sight(row.row, place, &mut scratch), look.per_metre);
                }
            }
            hide(out, &horizon, sky.exaggeration);
        }
        let share = 1.0 / sky.directions.len() as f32;
        out.iter_mut().for_each(|o| *o = (1.0 - *o * share).clamp(0.0, 1.0));
    }
}

/// Raises the tangents of the horizon of a row to what is seen at a place.
#[inline(always)]
fn raise(horizon: &mut [f32], here: &[f32], sight: Sight<'_>, per_metre: f32) {
    let Sight { near: [above, below], far: [far_above, far_below], along, down } = sight;
    let each = horizon.iter_mut().zip(here);
    // A plain `max` stays a plain store; a choice of what to store becomes a masked one, which is slow on some machines.
    match (along == 0.0, down == 0.0) {
        (true, true) => {
            for ((old, h), a) in each.zip(above) {
                *old = old.max((a - h) * per_metre);
            }
        }
        (true, false) => between(horizon, here, above, below, down, per_metre),
        (false, true) => between(horizon, here, above, far_above, along, per_metre),
        (false, false) => {
            let pairs = above.iter().zip(far_above).zip(below.iter().zip(far_below));
            for ((old, h), ((a, fa), (b, fb))) in each.zip(pairs) {
                let (top, bottom) = (a + along * (fa - a), b + along * (fb - b));
                *old = old.max(((top - h) + down * (bottom - top)) * per_metre);
            }
        }
    }
}

/// Raises the horizon to what lies between two samples.
#[inline(always)]
fn between(horizon: &mut [f32], here: &[f32], near: &[f32], far: &[f32], share: f32, per_metre: f32) {
    for (((old, h), n), f) in horizon.iter_mut().zip(here).zip(near).zip(far) {
        *old = old.max(((n - h) + share * (f - n)) * per_metre);
    }
}

/// Adds the sine of each horizon to what is hidden.
#[inline(always)]
fn hide(hidden: &mut [f32], horizon: &[f32], exaggeration: f32) {
    for (o, &tangent) in hidden.iter_mut().zip(horizon) {
        let tangent = exaggeration * tangent;
        let tangent = if tangent < 1e9 { tangent } else { 1e9 };
        *o += tangent / (1.0 + tangent * tangent).sqrt();
    }
}
