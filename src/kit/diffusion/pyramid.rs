//! Coarser and coarser versions of a problem, and the way back up.
//!
//! An even axis is halved cell by cell (cells `2c` and `2c + 1` become cell `c`), an odd one point by point (point
//! `2c` becomes `c`, its neighbours count half), so that mirrored input has a mirrored pyramid at any size.

use rayon::prelude::*;

use crate::kit::diffusion::problem::{Guidance, HUGE, Problem, constraint};
use crate::kit::diffusion::scratch::Scratch;
use crate::kit::simd::{Kernel, Level, larger, smaller};

/// How an axis is halved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Halving {
    odd: bool,
    /// Cells of the coarse axis.
    pub(crate) coarse: usize,
}

impl Halving {
    pub(crate) fn of(n: usize) -> Self {
        Self { odd: n % 2 == 1, coarse: n.div_ceil(2) }
    }

    /// Weights of the neighbours before and after cell `2c`.
    fn sides(self) -> (f32, f32) {
        if self.odd { (0.5, 0.5) } else { (0.0, 1.0) }
    }

    /// Sum of the weights that exist.
    fn mass(self, c: usize) -> f32 {
        match (self.odd, self.coarse) {
            (false, _) => 2.0,
            (true, 1) => 1.0,
            (true, n) if c == 0 || c + 1 == n => 1.5,
            (true, _) => 2.0,
        }
    }

    /// The two coarse cells that a fine one lies between, the nearer first, with the share of the second.
    fn between(self, fine: usize) -> (usize, usize, f32) {
        let c = fine / 2;
        let next = (c + 1).min(self.coarse - 1);
        match (self.odd, fine % 2) {
            (true, 0) => (c, c, 0.0),
            (true, _) => (c, next, 0.5),
            (false, 0) => (c, c.saturating_sub(1), 0.25),
            (false, _) => (c, next, 0.25),
        }
    }
}

/// The maps of a coarse level; the meaning of each is that of [`Problem`].
#[derive(Debug, Default)]
pub(crate) struct Maps {
    cols: usize,
    rows: usize,
    fixed: Vec<f32>,
    target: Vec<f32>,
    source: Option<Vec<f32>>,
    /// Weight, x, y, slope.
    guidance: Option<[Vec<f32>; 4]>,
    cell: f32,
}

impl Maps {
    pub(crate) fn problem(&self) -> Problem<'_> {
        Problem {
            cols: self.cols,
            rows: self.rows,
            fixed: &self.fixed,
            target: &self.target,
            source: self.source.as_deref(),
            guidance: self.guidance.as_ref().map(|[weight, x, y, slope]| Guidance {
                weight,
                x,
                y,
                slope,
                cell: self.cell,
            }),
        }
    }

    /// Gives the maps' buffers back.
    pub(crate) fn keep(self, scratch: &mut Scratch) {
        let Self { fixed, target, source, guidance, .. } = self;
        let all = [fixed, target].into_iter().chain(source).chain(guidance.into_iter().flatten());
        all.for_each(|buffer| scratch.keep(buffer));
    }

    /// Halves a problem: a coarse cell has twice the mean share of its cells, so that a line stays a line and grows no
    /// wider, but half of a lone point's at least, at the mean target; guidance is the mean of the gradient, where it covers at
    /// least half of the cell. `strongest` is the largest weight of the finest guidance.
    ///
    /// A slope that is narrower than a coarse cell would dip its surroundings: at its far end it no longer fades, and
    /// the sweeps take it for a sink.
    pub(crate) fn halved(fine: &Problem<'_>, strongest: f32, scratch: &mut Scratch, level: Level) -> Self {
        let (h, v) = (Halving::of(fine.cols), Halving::of(fine.rows));
        let n = h.coarse * v.coarse;
        let mut out = Self {
            cols: h.coarse,
            rows: v.coarse,
            fixed: scratch.take(n),
            target: scratch.take(n),
            source: fine.source.map(|_| scratch.take(n)),
            guidance: fine.guidance.map(|_| std::array::from_fn(|_| scratch.take(n))),
            cell: fine.guidance.map_or(1.0, |g| g.cell * 2.0),
        };
        let mut planes: Vec<&mut [f32]> = vec![&mut out.fixed, &mut out.target];
        planes.extend(out.guidance.iter_mut().flatten().map(|v| &mut v[..]));
        planes.extend(out.source.as_mut().map(|v| &mut v[..]));
        // Each plane in bands of rows, then each band with its piece of every plane.
        let band = (1 << 14) / fine.cols + 1;
        let mut bands: Vec<Vec<&mut [f32]>> = Vec::new();
        for plane in planes {
            for (b, piece) in plane.chunks_mut(h.coarse * band).enumerate() {
                if b == bands.len() {
                    bands.push(Vec::new());
                }
                bands[b].push(piece);
            }
        }
        bands.into_par_iter().enumerate().for_each(|(b, mut pieces)| {
            let mut sums = Sums::new(fine);
            for k in 0..pieces[0].len() / h.coarse {
                let j = b * band + k;
                sums.gather(fine, v, j, level);
                let row = k * h.coarse..(k + 1) * h.coarse;
                let mut out: Vec<&mut [f32]> = pieces.iter_mut().map(|p| &mut p[row.clone()]).collect();
                let (mass, least) = (v.mass(j), 0.5 * strongest);
                level.run(Spread { sums: &sums, h, mass, least, out: &mut out });
            }
        });
        out
    }
}

/// Sums over the fine rows of one coarse row, with a zero before and after.
struct Sums {
    most: Vec<f32>,
    fixed: Vec<f32>,
    target: Vec<f32>,
    guidance: Option<[Vec<f32>; 4]>,
    source: Option<Vec<f32>>,
}

impl Sums {
    fn new(fine: &Problem<'_>) -> Self {
        let row = || vec![0.0; fine.cols + 2];
        Self {
            most: row(),
            fixed: row(),
            target: row(),
            guidance: fine.guidance.map(|_| std::array::from_fn(|_| row())),
            source: fine.source.map(|_| row()),
        }
    }

    fn gather(&mut self, fine: &Problem<'_>, v: Halving, j: usize, level: Level) {
        let n = fine.cols;
        let guides = self.guidance.iter_mut().flatten();
        for sum in [&mut self.most, &mut self.fixed, &mut self.target]
            .into_iter()
            .chain(guides)
            .chain(&mut self.source)
        {
            sum.fill(0.0);
        }
        let (before, after) = v.sides();
        let rows = [((2 * j).checked_sub(1), before), (Some(2 * j), 1.0), (Some(2 * j + 1), after)];
        for (fine_row, weight) in rows {
            let Some(row) = fine_row.filter(|&r| r < fine.rows && weight > 0.0) else { continue };
            let span = row * n..(row + 1) * n;
            level.run(Add {
                weight,
                fixed: &fine.fixed[span.clone()],
                target: &fine.target[span.clone()],
                most: &mut self.most[1..=n],
                sum: &mut self.fixed[1..=n],
                product: &mut self.target[1..=n],
            });
            if let (Some(g), Some(sums)) = (fine.guidance, &mut self.guidance) {
                level.run(AddGuidance {
                    weight,
                    input: [g.weight, g.x, g.y, g.slope].map(|m| &m[span.clone()]),
                    sums: sums.each_mut().map(|s| &mut s[1..=n]),
                });
            }
            if let (Some(source), Some(sum)) = (fine.source, &mut self.source) {
                for (o, &s) in sum[1..=n].iter_mut().zip(&source[span]) {
                    *o += weight * if s.abs() < HUGE { s } else { 0.0 };
                }
            }
        }
    }
}

/// Adds one fine row of constraints to the sums.
struct Add<'a> {
    weight: f32,
    fixed: &'a [f32],
    target: &'a [f32],
    most: &'a mut [f32],
    sum: &'a mut [f32],
    product: &'a mut [f32],
}

impl Kernel for Add<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.fixed.len();
        let (target, most) = (&self.target[..n], &mut self.most[..n]);
        let (sum, product) = (&mut self.sum[..n], &mut self.product[..n]);
        for i in 0..n {
            let (f, e) = constraint(self.fixed[i], target[i], 0.0);
            most[i] = larger(most[i], f);
            sum[i] += self.weight * f;
            product[i] += self.weight * f * e;
        }
    }
}

/// Adds one fine row of guidance to the sums.
struct AddGuidance<'a> {
    weight: f32,
    input: [&'a [f32]; 4],
    sums: [&'a mut [f32]; 4],
}

impl Kernel for AddGuidance<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.input[0].len();
        let [weight, x, y, slope] = self.input.map(|m| &m[..n]);
        let [sum, sum_x, sum_y, sum_slope] = self.sums.map(|m| &mut m[..n]);
        for i in 0..n {
            let length2 = x[i] * x[i] + y[i] * y[i];
            let sound = (length2 > 1e-12) & (length2 < HUGE) & (slope[i].abs() < HUGE) & (weight[i] > 0.0);
            let w = self.weight * if sound { if weight[i] < 1.0 { weight[i] } else { 1.0 } } else { 0.0 };
            let inverse = w / (if sound { length2 } else { 1.0 }).sqrt();
            sum[i] += w;
            sum_x[i] += if sound { x[i] } else { 0.0 } * inverse;
            sum_y[i] += if sound { y[i] } else { 0.0 } * inverse;
            sum_slope[i] += if sound { slope[i] } else { 0.0 } * w;
        }
    }
}

/// Adds neighbouring columns of the sums and makes them the maps of a coarse row.
struct Spread<'a, 'b> {
    sums: &'a Sums,
    h: Halving,
    /// Weight of the rows in the sums.
    mass: f32,
    /// Mean weight below which guidance is dropped.
    least: f32,
    out: &'a mut [&'b mut [f32]],
}

/// The sum of three neighbouring columns around fine column `2c`; one zero stands before the row.
#[inline(always)]
fn columns(sum: &[f32], c: usize, (before, after): (f32, f32)) -> f32 {
    (before * sum[2 * c] + after * sum[2 * c + 2]) + sum[2 * c + 1]
}

impl Kernel for Spread<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let n = self.h.coarse;
        let sides = self.h.sides();
        let first = if self.h.odd { 1.0 } else { 0.0 };
        // `columns` reads no further.
        let end = 2 * n + 1;
        let (most, fixed, target) =
            (&self.sums.most[..end], &self.sums.fixed[..end], &self.sums.target[..end]);
        let mut out = self.out.iter_mut();
        let mut next = || out.next().map_or(&mut [][..], |row| &mut row[..n]);
        let (share, value) = (next(), next());
        for c in 0..n {
            let most = larger(larger(first * most[2 * c], most[2 * c + 2]), most[2 * c + 1]);
            let twice = 0.5 * columns(fixed, c, sides);
            share[c] = smaller(larger(twice, smaller(most, 0.5)), 1.0);
            let (sum, product) = (columns(fixed, c, sides), columns(target, c, sides));
            value[c] = if sum > 0.0 { product / sum } else { 0.0 };
        }
        if let Some(sums) = &self.sums.guidance {
            let [weight, x, y, slope] = sums.each_ref().map(|s| &s[..end]);
            let (out_weight, out_x, out_y, out_slope) = (next(), next(), next(), next());
            let over = 1.0 / (2.0 * self.mass);
            for c in 0..n {
                let w = columns(weight, c, sides);
                let (gx, gy) = (columns(x, c, sides), columns(y, c, sides));
                // Directions that cancel leave no direction, and those that differ less of a slope.
                let length2 = gx * gx + gy * gy;
                let whole = length2 > 1e-6 * w * w;
                out_weight[c] = if whole { w * over } else { 0.0 };
                (out_x[c], out_y[c]) = (gx, gy);
                let s = columns(slope, c, sides);
                out_slope[c] = if whole { s * length2.sqrt() / (w * w) } else { 0.0 };
            }
            out_weight[0] *= 2.0 / self.h.mass(0);
            if n > 1 {
                out_weight[n - 1] *= 2.0 / self.h.mass(n - 1);
            }
            for o in out_weight.iter_mut() {
                *o = if *o < self.least { 0.0 } else { *o };
            }
        }
        if let Some(source) = &self.sums.source {
            // The right side grows with the square of the cell: a sum of four, not a mean.
            for (c, o) in next().iter_mut().enumerate() {
                *o = columns(source, c, sides);
            }
        }
    }
}

/// A coarse field that is read at fine cells, bilinearly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coarse<'a> {
    pub(crate) field: &'a [f32],
    pub(crate) h: Halving,
    pub(crate) v: Halving,
}

impl Coarse<'_> {
    /// Fills `out` with fine row `j` from the even column `from` on; `line` is scratch of half the length and 3 more.
    pub(crate) fn row(&self, level: Level, j: usize, from: usize, out: &mut [f32], line: &mut [f32]) {
        let (a, b, share) = self.v.between(j);
        let pairs = out.len().div_ceil(2);
        let (first, cols) = (from / 2, self.h.coarse);
        let (low, high) = (first.saturating_sub(1), (first + pairs + 1).min(cols));
        let row = |r: usize| &self.field[r * cols + low..r * cols + high];
        // `line[1]` is coarse column `first`.
        let start = 1 + low - first;
        let line = &mut line[..pairs + 2];
        level.run(Blend { a: row(a), b: row(b), share, out: &mut line[start..start + high - low] });
        if start == 1 {
            line[0] = line[1];
        }
        if high == first + pairs {
            line[pairs + 1] = line[pairs];
        }
        level.run(Double { line, odd: self.h.odd, out });
    }
}

struct Blend<'a> {
    a: &'a [f32],
    b: &'a [f32],
    share: f32,
    out: &'a mut [f32],
}

impl Kernel for Blend<'_> {
    #[inline(always)]
    fn run(self) {
        for ((o, &a), &b) in self.out.iter_mut().zip(self.a).zip(self.b) {
            *o = a + self.share * (b - a);
        }
    }
}

struct Double<'a> {
    line: &'a [f32],
    odd: bool,
    out: &'a mut [f32],
}

impl Kernel for Double<'_> {
    #[inline(always)]
    fn run(self) {
        let pairs = self.out.len() / 2;
        let (before, here, after) = (&self.line[..pairs], &self.line[1..=pairs], &self.line[2..pairs + 2]);
        let (first, second) = if self.odd { (0.0, 0.5) } else { (0.25, 0.25) };
        for (k, out) in self.out.chunks_exact_mut(2).enumerate() {
            out[0] = between(here[k], before[k], first);
            out[1] = between(here[k], after[k], second);
        }
        if self.out.len() % 2 == 1 {
            self.out[2 * pairs] = between(self.line[pairs + 1], self.line[pairs], first);
        }
    }
}

/// The value a share of the way from one to another.
#[inline(always)]
fn between(here: f32, other: f32, share: f32) -> f32 {
    here + share * (other - here)
}
