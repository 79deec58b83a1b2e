//! The papers' solver: a cascade of Jacobi sweeps, coarse to fine \[hnaidi2010, 5.2\].
//!
//! Sweeps are bound by memory, so several are done on a tile while it lies in the fast cache: the tile is read with
//! a margin as wide as there are sweeps, and each sweep is one cell smaller all around. The finest level's maps are
//! read once and its field is written once.

use rayon::prelude::*;

use crate::kit::diffusion::problem::{Equation, FAINT, HUGE, Problem, constraint};
use crate::kit::diffusion::pyramid::{Coarse, Halving, Maps};
use crate::kit::diffusion::scratch::Scratch;
use crate::kit::simd::{Kernel, Level, larger, smaller};
use crate::work::{Cancelled, Work};

/// Sweeps per level: this times the number of levels from the finest down to it, itself included.
const SWEEPS: usize = 5;
/// Sweeps that are done on a tile at once, at most.
const FUSED: usize = 8;
/// Columns of a tile.
const WIDE: usize = 256;
/// Floats that a tile may take: three quarters of a fast cache of 512 KiB.
const TILE: usize = 96 * 1024;

/// Bytes of the tiles that all threads work on, beside what grows with the grid. Tiles of plain and of guided problems
/// have other shapes, and one has been both.
pub fn scratch() -> u64 {
    (TILE as u64 * 6 + (1 << 16)) * rayon::current_num_threads() as u64
}

/// What is known of the constraints of a whole problem.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) low: f32,
    pub(crate) high: f32,
    /// Whether constraints alone shape the field, so that it lies between them.
    pub(crate) bounded: bool,
}

impl Extent {
    /// What is taken off the constraints so that `f32` has digits to spare.
    pub(crate) fn offset(&self) -> f32 {
        self.low + 0.5 * (self.high - self.low)
    }
}

/// Runs the cascade.
pub(crate) fn cascade(
    finest: &Problem<'_>,
    extent: Extent,
    scratch: &mut Scratch,
    level: Level,
    work: &Work<'_>,
) -> Result<Vec<f32>, Cancelled> {
    let mut coarse: Vec<Maps> = Vec::new();
    let strongest = finest.strongest_guidance();
    loop {
        let last = coarse.last().map_or(*finest, Maps::problem);
        if last.len() <= 1 {
            break;
        }
        work.check()?;
        let next = Maps::halved(&last, strongest, scratch, level);
        coarse.push(next);
    }
    work.report(0.2);
    let (mut field, mut spare): (Vec<f32>, Vec<f32>) = Default::default();
    for k in (0..=coarse.len()).rev() {
        let problem = if k == 0 { *finest } else { coarse[k - 1].problem() };
        let sweeps = SWEEPS * (k + 1);
        let parts = sweeps.div_ceil(FUSED);
        for part in 0..parts {
            work.check()?;
            let from = match part {
                0 if field.is_empty() => Start::Zero,
                0 => Start::Coarse(Coarse {
                    field: &field,
                    h: Halving::of(problem.cols),
                    v: Halving::of(problem.rows),
                }),
                _ => Start::Field(&field),
            };
            let some = (part + 1) * sweeps / parts - part * sweeps / parts;
            let finish = (k == 0 && part + 1 == parts).then_some(extent);
            let mut next = std::mem::take(&mut spare);
            if next.len() != problem.len() {
                scratch.keep(std::mem::take(&mut next));
                next = scratch.take(problem.len());
            }
            sweep(&problem, extent.offset(), some, from, finish, scratch, level, work, &mut next)?;
            spare = std::mem::replace(&mut field, next);
        }
        coarse.drain(k.saturating_sub(1)..).for_each(|maps| maps.keep(scratch));
        work.report(1.0 - 0.8 * k as f32 / (k + 1) as f32);
    }
    scratch.keep(spare);
    Ok(field)
}

/// What the first sweep reads.
#[derive(Clone, Copy)]
enum Start<'a> {
    Zero,
    Coarse(Coarse<'a>),
    Field(&'a [f32]),
}

/// Some sweeps over a whole level, tile by tile.
#[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
fn sweep(
    problem: &Problem<'_>,
    offset: f32,
    sweeps: usize,
    from: Start<'_>,
    finish: Option<Extent>,
    scratch: &Scratch,
    level: Level,
    work: &Work<'_>,
    out: &mut [f32],
) -> Result<(), Cancelled> {
    let guided = problem.guidance.is_some();
    let margin = sweeps.next_multiple_of(2);
    let arrays = if guided { 7 } else { 4 };
    let wide = problem.cols.min(WIDE) + 2 * margin + 2;
    let high = (TILE / arrays / wide).saturating_sub(2 * margin + 2).clamp(32, 4 * WIDE);
    let one = |band: usize, rows: &mut [f32]| {
        work.check()?;
        let mut tile = scratch.take_tile();
        tile.fit(wide, high + 2 * margin + 2, guided);
        let span = (band * high, band * high + rows.len() / problem.cols);
        for x in (0..problem.cols).step_by(WIDE) {
            let end = (x + WIDE).min(problem.cols);
            tile.load(problem, offset, margin, (x, end), span, from, level);
            for done in 1..=sweeps {
                tile.sweep(done, level);
            }
            tile.store(problem, (x, end), span, finish.map(|e| (e, offset)), level, rows);
        }
        scratch.keep_tile(tile);
        Ok(())
    };
    out.par_chunks_mut(problem.cols * high).enumerate().try_for_each(|(band, rows)| one(band, rows))
}

/// A piece of a level in the fast cache, with a margin for the sweeps and one line more all around.
#[derive(Default)]
pub(crate) struct Tile {
    stride: usize,
    /// First cell and size, with the margin.
    at: (usize, usize),
    size: (usize, usize),
    /// Whether the grid ends with the tile: west, east, north, south.
    border: [bool; 4],
    field: Vec<f32>,
    next: Vec<f32>,
    add: Vec<f32>,
    /// One plane of a quarter of the Laplace weight, or four of west, east, north and south.
    weights: Vec<Vec<f32>>,
    equation: Equation,
    line: Vec<f32>,
}

impl Tile {
    /// Makes room; what is in it stays arbitrary.
    fn fit(&mut self, wide: usize, high: usize, guided: bool) {
        self.stride = wide;
        self.weights.resize_with(if guided { 4 } else { 1 }, Vec::new);
        let planes = [&mut self.field, &mut self.next, &mut self.add].into_iter().chain(&mut self.weights);
        for plane in planes.filter(|p| p.len() < wide * high) {
            plane.resize(wide * high, 0.0);
        }
        if guided && self.equation.add.len() < wide {
            self.equation = Equation::new(wide);
        }
        if self.line.len() < wide {
            self.line.resize(wide, 0.0);
        }
    }

    /// Reads the maps and the field.
    #[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
    fn load(
        &mut self,
        problem: &Problem<'_>,
        offset: f32,
        margin: usize,
        cols: (usize, usize),
        rows: (usize, usize),
        from: Start<'_>,
        level: Level,
    ) {
        let (x0, y0) = (cols.0.saturating_sub(margin), rows.0.saturating_sub(margin));
        let (x1, y1) = ((cols.1 + margin).min(problem.cols), (rows.1 + margin).min(problem.rows));
        self.at = (x0, y0);
        self.size = (x1 - x0, y1 - y0);
        self.border = [x0 == 0, x1 == problem.cols, y0 == 0, y1 == problem.rows];
        let n = self.size.0;
        for j in 0..self.size.1 {
            let at = (j + 1) * self.stride + 1;
            let span = (y0 + j) * problem.cols + x0..(y0 + j) * problem.cols + x1;
            let field = &mut self.field[at..at + n];
            match from {
                Start::Zero => field.fill(0.0),
                Start::Coarse(coarse) => coarse.row(level, y0 + j, x0, field, &mut self.line),
                Start::Field(old) => field.copy_from_slice(&old[span.clone()]),
            }
            if problem.guidance.is_some() {
                problem.equation(level, y0 + j, x0, n, offset, &mut self.equation);
                let e = &self.equation;
                for (to, row) in self.weights.iter_mut().zip([&e.west, &e.east, &e.north, &e.south]) {
                    to[at..at + n].copy_from_slice(&row[..n]);
                }
                self.add[at..at + n].copy_from_slice(&e.add[..n]);
                level.run(Pin { field, fixed: &e.fixed[..n], target: &e.target[..n] });
            } else {
                level.run(Plain {
                    fixed: &problem.fixed[span.clone()],
                    target: &problem.target[span.clone()],
                    source: problem.source.map(|s| &s[span]),
                    offset,
                    field,
                    quarter: &mut self.weights[0][at..at + n],
                    add: &mut self.add[at..at + n],
                });
            }
        }
        level.run(Mirror { tile: self });
    }

    /// One sweep; `done` counts from 1.
    fn sweep(&mut self, done: usize, level: Level) {
        let cut = |border: bool| if border { 0 } else { done };
        let x = (cut(self.border[0]), self.size.0 - cut(self.border[1]));
        let y = (cut(self.border[2]), self.size.1 - cut(self.border[3]));
        if self.weights.len() == 1 {
            level.run(Sweep::<false> { tile: self, x, y });
        } else {
            level.run(Sweep::<true> { tile: self, x, y });
        }
        std::mem::swap(&mut self.field, &mut self.next);
        level.run(Mirror { tile: self });
    }

    /// Writes the cells that belong to the tile.
    fn store(
        &self,
        problem: &Problem<'_>,
        cols: (usize, usize),
        rows: (usize, usize),
        finish: Option<(Extent, f32)>,
        level: Level,
        out: &mut [f32],
    ) {
        let n = cols.1 - cols.0;
        for j in rows.0..rows.1 {
            let at = (j - self.at.1 + 1) * self.stride + 1 + cols.0 - self.at.0;
            let to = (j - rows.0) * problem.cols + cols.0;
            let out = &mut out[to..to + n];
            out.copy_from_slice(&self.field[at..at + n]);
            if let Some((extent, offset)) = finish {
                finish_row(problem, extent, offset, j * problem.cols + cols.0, level, out);
            }
        }
    }
}

/// Puts the offset back on a piece of a row that starts at cell `at`, and makes strict constraints exact.
pub(crate) fn finish_row(
    problem: &Problem<'_>,
    extent: Extent,
    offset: f32,
    at: usize,
    level: Level,
    row: &mut [f32],
) {
    let span = at..at + row.len();
    level.run(Finish {
        fixed: &problem.fixed[span.clone()],
        target: &problem.target[span],
        extent,
        offset,
        row,
    });
}

struct Finish<'a> {
    fixed: &'a [f32],
    target: &'a [f32],
    extent: Extent,
    offset: f32,
    row: &'a mut [f32],
}

impl Kernel for Finish<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.row.len();
        let (fixed, target) = (&self.fixed[..n], &self.target[..n]);
        let Extent { low, high, bounded } = self.extent;
        let (low, high) = if bounded { (low, high) } else { (f32::NEG_INFINITY, f32::INFINITY) };
        let row = &mut self.row[..n];
        for i in 0..n {
            let value = smaller(larger(row[i] + self.offset, low), high);
            let strict = (fixed[i] >= 1.0 - FAINT) & (target[i].abs() < HUGE);
            row[i] = if strict { target[i] } else { value };
        }
    }
}

/// Starts constrained cells at their target.
struct Pin<'a> {
    field: &'a mut [f32],
    fixed: &'a [f32],
    target: &'a [f32],
}

impl Kernel for Pin<'_> {
    #[inline(always)]
    fn run(self) {
        for ((o, &f), &e) in self.field.iter_mut().zip(self.fixed).zip(self.target) {
            *o += f * (e - *o);
        }
    }
}

/// The equations of a row without guidance, and [`Pin`].
struct Plain<'a> {
    fixed: &'a [f32],
    target: &'a [f32],
    source: Option<&'a [f32]>,
    offset: f32,
    field: &'a mut [f32],
    quarter: &'a mut [f32],
    add: &'a mut [f32],
}

impl Kernel for Plain<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.fixed.len();
        let (target, field) = (&self.target[..n], &mut self.field[..n]);
        let (quarter, add) = (&mut self.quarter[..n], &mut self.add[..n]);
        for i in 0..n {
            let (f, e) = constraint(self.fixed[i], target[i], self.offset);
            quarter[i] = 0.25 * (1.0 - f);
            add[i] = f * e;
            field[i] += f * (e - field[i]);
        }
        if let Some(source) = self.source {
            for (i, &s) in source[..n].iter().enumerate() {
                add[i] += 4.0 * quarter[i] * if s.abs() < HUGE { s } else { 0.0 };
            }
        }
    }
}

/// Continues the field beyond the border of the grid.
struct Mirror<'a> {
    tile: &'a mut Tile,
}

impl Kernel for Mirror<'_> {
    #[inline(always)]
    fn run(self) {
        let Tile { stride, size: (n, m), border, field, .. } = self.tile;
        let (stride, n, m) = (*stride, *n, *m);
        for j in 1..=m {
            let row = &mut field[j * stride..j * stride + n + 2];
            if border[0] {
                row[0] = row[1];
            }
            if border[1] {
                row[n + 1] = row[n];
            }
        }
        if border[2] {
            field.copy_within(stride..2 * stride, 0);
        }
        if border[3] {
            field.copy_within(m * stride..(m + 1) * stride, (m + 1) * stride);
        }
    }
}

/// One Jacobi sweep over the cells from `x.0` to `x.1`, `y.0` to `y.1`.
struct Sweep<'a, const GUIDED: bool> {
    tile: &'a mut Tile,
    x: (usize, usize),
    y: (usize, usize),
}

impl<const GUIDED: bool> Kernel for Sweep<'_, GUIDED> {
    #[inline(always)]
    fn run(self) {
        let Tile { stride, field, next, add, weights, .. } = self.tile;
        let n = self.x.1.saturating_sub(self.x.0);
        for j in self.y.0..self.y.1 {
            let at = (j + 1) * *stride + 1 + self.x.0;
            let north = &field[at - *stride..][..n];
            let south = &field[at + *stride..][..n];
            let (west, east) = (&field[at - 1..][..n], &field[at + 1..][..n]);
            let (add, out) = (&add[at..][..n], &mut next[at..][..n]);
            if GUIDED {
                let w = &weights[0][at..][..n];
                let e = &weights[1][at..][..n];
                let (u, d) = (&weights[2][at..][..n], &weights[3][at..][..n]);
                for i in 0..n {
                    let sum = (w[i] * west[i] + e[i] * east[i]) + (u[i] * north[i] + d[i] * south[i]);
                    out[i] = sum + add[i];
                }
            } else {
                let quarter = &weights[0][at..][..n];
                for i in 0..n {
                    out[i] = quarter[i] * ((west[i] + east[i]) + (north[i] + south[i])) + add[i];
                }
            }
        }
    }
}
