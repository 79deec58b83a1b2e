//! Gaussian smoothing whose result does not depend on the window it is computed on.
//!
//! Up to `DIRECT` cells the Gaussian is summed tap by tap, columns first, then rows. A wider one is taken on a
//! coarser lattice \[burt1983\]: the field is halved `L` times by the binomial filter 1 4 6 4 1, smoothed there, and
//! doubled `L` times by the cubic B-spline subdivision 1 4 6 4 1. The points of level `k` are those whose lattice
//! index is a multiple of 2ᵏ, so a tile and the whole use the same points and give the same bits.
//!
//! A cascade of such filters is a cubic B-spline of width 2ᴸ, that is four boxes, once on the way down and once on
//! the way up. Their variance, `8 (4ᴸ − 1) / 12`, is taken off what is left to smooth, and their fourth cumulant
//! is made up for in the weights, so that the whole differs from the true Gaussian by less than 1e-4 of the range.
//!
//! Every sum is written as the centre and weighted differences from it: a flat field stays flat to the bit.

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::kit::simd::{Kernel, Level};
use crate::value::{Field, Grid};
use crate::work::{Cancelled, Work};

/// Widest standard deviation, in cells, that is summed directly; coarser levels work between half of it and it.
const DIRECT: f64 = 7.0;
/// Where the Gaussian is cut, in standard deviations: 2e-6 of its mass lies beyond.
const CUT: f64 = 4.8;
/// Below this many cells the neighbours weigh less than 1e-9.
const NOTHING: f64 = 0.15;
/// Columns that are worked on at a time, so that the rows of a band stay in the cache.
const STRIP: usize = 1024;

/// The window of the input that [`gaussian`] reads for a window of the output; `sigma` in metres.
pub fn footprint(window: Grid, sigma: f64) -> Grid {
    let plan = Plan::new(sigma / window.cell());
    let (cols, rows) = (plan.reads(Span::columns(&window)), plan.reads(Span::rows(&window)));
    Grid::between(window.lattice, [cols.from, rows.from], [cols.to + 1, rows.to + 1])
}

/// Bytes that [`gaussian`] needs beside input and output, at most; `sigma` in metres.
pub fn scratch(window: &Grid, sigma: f64) -> u64 {
    let plan = Plan::new(sigma / window.cell());
    // Input never reaches beyond the apron, half a terrain around it.
    let apron = 2.0 * f64::from(window.lattice.intervals) + 4.0;
    let input = footprint(*window, sigma);
    let samples = |cols: usize, rows: usize| (cols as f64).min(apron) * (rows as f64).min(apron);
    let (read, made) = (samples(input.cols, input.rows), window.len() as f64);
    // Level 1 and half as much again for the levels above it, each way; the border rows of small levels.
    let levels = if plan.levels == 0 { 0.0 } else { 0.375 * (read + made) + 4096.0 };
    let rows = 64.0 * (2 * STRIP + window.cols + input.cols.min(apron as usize) + 4 * plan.taps.len()) as f64;
    (4.0 * (levels + rows)) as u64
}

/// Nanoseconds a sample on one core; `sigma` in metres.
pub fn nanoseconds(window: &Grid, sigma: f64) -> f64 {
    let plan = Plan::new(sigma / window.cell());
    let input = footprint(*window, sigma);
    let apron = 2.0 * f64::from(window.lattice.intervals) + 4.0;
    let read = (input.cols as f64).min(apron) * (input.rows as f64).min(apron) / window.len().max(1) as f64;
    let taps = plan.taps.len() as f64 * 0.5;
    if plan.levels == 0 { 1.0 + taps } else { 3.0 + 5.0 * read + taps * 0.1 }
}

/// Smooths a field by a Gaussian of standard deviation `sigma`, in metres.
///
/// The result stands on `window`. Beyond the input its border value continues; to give the same bits whatever the
/// window, the input must cover the [`footprint`]. Lattice and quantity are those of the input.
///
/// # Errors
/// [`Error::Cancelled`] when the work was asked to stop; [`Error::Input`] when the input has no sample.
pub fn gaussian(work: &Work<'_>, input: &Field, window: Grid, sigma: f64) -> Result<Field> {
    let sigma = sigma / window.cell();
    if window.is_empty() || sigma < NOTHING {
        return Ok(input.crop(&window));
    }
    if input.grid().is_empty() {
        return Err(Error::Input { port: "field".into(), message: "has no samples".into() });
    }
    let plan = Plan::new(sigma);
    let base = Plane::of(input);
    let out = (Span::columns(&window), Span::rows(&window));
    let data = if plan.levels == 0 {
        smooth(work, base, out, &plan.taps)?
    } else {
        pyramid(work, base, out, &plan)?
    };
    Ok(Field::new(window, input.quantity(), data))
}

/// Down to the coarsest level, the smoothing there, and back.
fn pyramid(work: &Work<'_>, base: Plane<'_>, out: (Span, Span), plan: &Plan) -> Result<Vec<f32>> {
    let (cols, rows) = (plan.ladder(out.0), plan.ladder(out.1));
    let at = |level: usize| (cols[level], rows[level]);
    let mut held: Option<(Vec<f32>, (Span, Span))> = None;
    for level in 1..=plan.levels {
        let from = held.as_ref().map_or(base, |(data, span)| Plane::new(data, *span));
        // Beyond the input all is constant along an axis, and so it is a little beyond its image here.
        let need = (plan.down(cols[plan.levels], level), plan.down(rows[plan.levels], level));
        let span = (need.0.within(from.cols.halved()), need.1.within(from.rows.halved()));
        let stage = if level == 1 { work.stage(0.0, 0.4) } else { work.stage(0.4, 0.5) };
        held = Some((halve(&stage, from, span)?, span));
    }
    let (mut data, mut span) = held.unwrap_or_default();
    for level in (0..=plan.levels).rev() {
        let next = at(level);
        let from = Plane::new(&data, span);
        data = match level {
            l if l == plan.levels => smooth(&work.stage(0.5, 0.55), from, next, &plan.taps)?,
            0 => double(&work.stage(0.6, 1.0), from, next)?,
            _ => double(&work.stage(0.55, 0.6), from, next)?,
        };
        span = next;
    }
    Ok(data)
}

/// How a Gaussian is taken: how often the lattice is halved, and the weights on the coarsest.
struct Plan {
    levels: usize,
    /// Weights of the neighbours at distance 1, 2, …; that of the centre is what is left to 1.
    taps: Vec<f32>,
}

impl Plan {
    /// For a standard deviation in cells.
    fn new(sigma: f64) -> Self {
        if sigma.is_nan() || sigma < NOTHING {
            return Self { levels: 0, taps: Vec::new() };
        }
        let (mut levels, mut step) = (0, 1.0);
        while sigma / step >= DIRECT && levels < 60 {
            (levels, step) = (levels + 1, step * 2.0);
        }
        let shrink = 1.0 - 1.0 / (step * step);
        let variance = (sigma / step) * (sigma / step) - 8.0 / 12.0 * shrink;
        let fourth = 8.0 / 120.0 * (1.0 - 1.0 / (step * step * step * step));
        Self { levels, taps: weights(variance, fourth) }
    }

    /// What level 0 is read for an output span.
    fn reads(&self, out: Span) -> Span {
        let top = *self.ladder(out).last().unwrap_or(&out);
        self.down(top, 0)
    }

    /// The spans that are filled on the way up, from level 0 to the coarsest.
    fn ladder(&self, out: Span) -> Vec<Span> {
        std::iter::successors(Some(out), |s| Some(s.doubled_from())).take(self.levels + 1).collect()
    }

    /// The span of a level that is needed to smooth `top` on the coarsest.
    fn down(&self, top: Span, level: usize) -> Span {
        let smoothed = top.grown(self.taps.len() as i64);
        (level..self.levels).fold(smoothed, |s, _| Span { from: 2 * s.from - 2, to: 2 * s.to + 2 })
    }
}

/// The weights of a Gaussian with a small fourth cumulant (by Gram and Charlier), for distances 1, 2, …
fn weights(variance: f64, fourth: f64) -> Vec<f32> {
    let reach = (CUT * libm::sqrt(variance)).ceil() as usize;
    let weight = |n: usize| {
        let z2 = (n * n) as f64 / variance;
        let excess = fourth / (24.0 * variance * variance) * (z2 * z2 - 6.0 * z2 + 3.0);
        libm::exp(-0.5 * z2) * (1.0 + excess)
    };
    let raw: Vec<f64> = (1..=reach).map(weight).collect();
    let sum = weight(0) + 2.0 * raw.iter().rev().sum::<f64>();
    raw.iter().map(|w| (w / sum) as f32).collect()
}

/// Indices along one axis, both ends included.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Span {
    from: i64,
    to: i64,
}

impl Span {
    fn columns(grid: &Grid) -> Self {
        Self { from: grid.col, to: grid.col_end() - 1 }
    }

    fn rows(grid: &Grid) -> Self {
        Self { from: grid.row, to: grid.row_end() - 1 }
    }

    fn len(self) -> usize {
        usize::try_from(self.to - self.from + 1).unwrap_or(0)
    }

    fn grown(self, n: i64) -> Self {
        Self { from: self.from - n, to: self.to + n }
    }

    /// The points of the halved axis that see anything of this span, and one on each side that sees its end alone.
    fn halved(self) -> Self {
        Self { from: (self.from - 2).div_euclid(2), to: (self.to + 3).div_euclid(2) }
    }

    /// The points of the halved axis that doubling needs to fill this span.
    fn doubled_from(self) -> Self {
        Self { from: self.from.div_euclid(2) - 1, to: self.to.div_euclid(2) + 1 }
    }

    /// The span moved and cut into another, never to nothing.
    fn within(self, other: Self) -> Self {
        Self { from: self.from.clamp(other.from, other.to), to: self.to.clamp(other.from, other.to) }
    }
}

/// Samples of one level; beyond them the border value continues.
#[derive(Clone, Copy)]
struct Plane<'a> {
    data: &'a [f32],
    cols: Span,
    rows: Span,
}

impl<'a> Plane<'a> {
    fn of(field: &'a Field) -> Self {
        let grid = field.grid();
        Self { data: field.data(), cols: Span::columns(grid), rows: Span::rows(grid) }
    }

    fn new(data: &'a [f32], (cols, rows): (Span, Span)) -> Self {
        Self { data, cols, rows }
    }

    /// Where a row starts in `data`.
    fn start(&self, row: i64) -> usize {
        (row.clamp(self.rows.from, self.rows.to) - self.rows.from) as usize * self.cols.len()
    }

    /// Weighs rows around `row` into `buffer`, which stands for the columns of `span`.
    fn column_sums(
        &self,
        row: i64,
        taps: &[f32],
        span: Span,
        buffer: &mut [f32],
        pairs: &mut Vec<[usize; 2]>,
    ) {
        let inside = span.within(self.cols);
        let skip = (inside.from - self.cols.from) as usize;
        pairs.clear();
        pairs.extend(
            (1..=taps.len() as i64).map(|k| [self.start(row - k) + skip, self.start(row + k) + skip]),
        );
        spread(buffer, span, inside, |out| weigh(out, self.data, self.start(row) + skip, pairs, taps));
    }

    /// The mean of a row and the next, as [`column_sums`](Self::column_sums).
    fn mean_rows(&self, row: i64, span: Span, buffer: &mut [f32]) {
        let inside = span.within(self.cols);
        let skip = (inside.from - self.cols.from) as usize;
        let (a, b) = (&self.data[self.start(row) + skip..], &self.data[self.start(row + 1) + skip..]);
        spread(buffer, span, inside, |out| {
            for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
                *o = (a + b) * 0.5;
            }
        });
    }
}

/// Fills the part of a buffer that lies inside, and continues its ends over the rest.
fn spread(buffer: &mut [f32], span: Span, inside: Span, fill: impl FnOnce(&mut [f32])) {
    // A span beside the plane sees its border column alone; `inside` is then one column, not in the span.
    let at = (inside.from - span.from).clamp(0, buffer.len() as i64 - 1) as usize;
    let n = inside.len().min(buffer.len() - at);
    fill(&mut buffer[at..at + n]);
    let (first, last) = (buffer[at], buffer[at + n - 1]);
    buffer[..at].fill(first);
    buffer[at + n..].fill(last);
}

/// Runs `band` on bands of rows of an output in parallel; it gets the first row's index and the rows.
fn bands(
    work: &Work<'_>,
    (cols, rows): (Span, Span),
    band: impl Fn(i64, &mut [f32]) + Sync,
) -> Result<Vec<f32>> {
    let (width, height) = (cols.len(), rows.len());
    let mut data = vec![0.0; width * height];
    let done = AtomicUsize::new(0);
    let size = ((1 << 16) / width.max(1)).clamp(1, 64);
    data.par_chunks_mut(width.max(1) * size).enumerate().try_for_each(|(b, out)| {
        work.check()?;
        band(rows.from + (b * size) as i64, out);
        let finished = done.fetch_add(size, Ordering::Relaxed) + size;
        work.report(finished as f32 / height as f32);
        Ok::<(), Cancelled>(())
    })?;
    Ok(data)
}

/// Sums columns, then rows, by the weights.
fn smooth(work: &Work<'_>, from: Plane<'_>, to: (Span, Span), taps: &[f32]) -> Result<Vec<f32>> {
    let (width, reach) = (to.0.len(), taps.len());
    let across: Vec<[usize; 2]> = (1..=reach).map(|k| [reach - k, reach + k]).collect();
    bands(work, to, |first, out| {
        let mut pairs = Vec::with_capacity(reach);
        let mut buffer = vec![0.0; STRIP.min(width) + 2 * reach];
        for start in (0..width).step_by(STRIP) {
            let n = STRIP.min(width - start);
            let left = to.0.from + start as i64;
            let span = Span { from: left, to: left + n as i64 - 1 }.grown(reach as i64);
            let buffer = &mut buffer[..n + 2 * reach];
            for (j, row) in out.chunks_mut(width).enumerate() {
                from.column_sums(first + j as i64, taps, span, buffer, &mut pairs);
                weigh(&mut row[start..start + n], buffer, reach, &across, taps);
            }
        }
    })
}

/// Filters by 1 4 6 4 1 and keeps every second point.
fn halve(work: &Work<'_>, from: Plane<'_>, to: (Span, Span)) -> Result<Vec<f32>> {
    let span = Span { from: 2 * to.0.from - 2, to: 2 * to.0.to + 2 };
    bands(work, to, |first, out| {
        let (mut pairs, mut buffer) = (Vec::with_capacity(2), vec![0.0; span.len()]);
        for (j, row) in out.chunks_mut(to.0.len()).enumerate() {
            from.column_sums(2 * (first + j as i64), &[0.25, 0.0625], span, &mut buffer, &mut pairs);
            Level::best().run(HalveRow { out: row, buffer: &buffer });
        }
    })
}

/// Puts a point between every two and filters by 1 4 6 4 1.
fn double(work: &Work<'_>, from: Plane<'_>, to: (Span, Span)) -> Result<Vec<f32>> {
    let span = to.0.doubled_from();
    bands(work, to, |first, out| {
        let (mut pairs, mut buffer) = (Vec::with_capacity(1), vec![0.0; span.len()]);
        for (j, row) in out.chunks_mut(to.0.len()).enumerate() {
            let index = first + j as i64;
            if index.rem_euclid(2) == 0 {
                from.column_sums(index / 2, &[0.125], span, &mut buffer, &mut pairs);
            } else {
                from.mean_rows(index.div_euclid(2), span, &mut buffer);
            }
            let odd = to.0.from.rem_euclid(2) as usize;
            Level::best().run(DoubleRow { out: row, buffer: &buffer, odd });
        }
    })
}

/// The centre and weighted differences from it, by the widest instructions of this machine.
fn weigh(out: &mut [f32], source: &[f32], center: usize, pairs: &[[usize; 2]], weights: &[f32]) {
    Level::best().run(Weigh { out, source, center, pairs, weights });
}

/// `out[i] = c + Σ wₖ (aₖ + bₖ − 2 c)`, in order of k.
struct Weigh<'a> {
    out: &'a mut [f32],
    source: &'a [f32],
    /// Where `c` of the first point stands in the source, and the `a` and `b` of each weight.
    center: usize,
    pairs: &'a [[usize; 2]],
    weights: &'a [f32],
}

impl Kernel for Weigh<'_> {
    #[inline(always)]
    fn run(self) {
        const LANES: usize = 32;
        let Self { out, source, center, pairs, weights } = self;
        let (chunks, rest) = out.as_chunks_mut::<LANES>();
        let mut x = 0;
        for chunk in chunks {
            let c = &source[center + x..][..LANES];
            let mut sum = [0.0; LANES];
            for (&[a, b], &w) in pairs.iter().zip(weights) {
                let (a, b) = (&source[a + x..][..LANES], &source[b + x..][..LANES]);
                for i in 0..LANES {
                    sum[i] += w * ((a[i] + b[i]) - 2.0 * c[i]);
                }
            }
            for i in 0..LANES {
                chunk[i] = c[i] + sum[i];
            }
            x += LANES;
        }
        for o in rest {
            let c = source[center + x];
            let mut sum = 0.0;
            for (&[a, b], &w) in pairs.iter().zip(weights) {
                sum += w * ((source[a + x] + source[b + x]) - 2.0 * c);
            }
            *o = c + sum;
            x += 1;
        }
    }
}

/// 1 4 6 4 1 on every second point: `out[i]` stands at `buffer[2 i + 2]`.
struct HalveRow<'a> {
    out: &'a mut [f32],
    buffer: &'a [f32],
}

impl Kernel for HalveRow<'_> {
    #[inline(always)]
    fn run(self) {
        let buffer = &self.buffer[..2 * self.out.len() + 3];
        for (i, o) in self.out.iter_mut().enumerate() {
            let b = &buffer[2 * i..2 * i + 5];
            let twice = 2.0 * b[2];
            *o = b[2] + (0.25 * ((b[1] + b[3]) - twice) + 0.0625 * ((b[0] + b[4]) - twice));
        }
    }
}

/// A point between every two: `out[0]` stands at `buffer[1]`, or between it and the next when `odd` is 1.
struct DoubleRow<'a> {
    out: &'a mut [f32],
    buffer: &'a [f32],
    odd: usize,
}

impl Kernel for DoubleRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { out, buffer, odd } = self;
        let even = |b: &[f32]| b[1] + 0.125 * ((b[0] + b[2]) - 2.0 * b[1]);
        let between = |b: &[f32]| (b[1] + b[2]) * 0.5;
        let (head, out) = out.split_at_mut(odd.min(out.len()));
        for o in head {
            *o = between(&buffer[..3]);
        }
        let buffer = &buffer[odd..];
        let (twos, rest) = out.as_chunks_mut::<2>();
        for (two, b) in twos.iter_mut().zip(buffer.windows(3)) {
            *two = [even(b), between(b)];
        }
        for o in rest {
            *o = even(&buffer[twos.len()..][..3]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::hash;

    #[test]
    fn all_instruction_sets_give_the_same_bits() {
        let source: Vec<f32> = (0..700).map(|i| 900.0 * hash::unit(3, i) as f32).collect();
        let weights: Vec<f32> = weights(9.0, 0.06);
        let pairs: Vec<_> = (1..=weights.len()).map(|k| [20 - k, 20 + k]).collect();
        let bits = |level: Level, odd: usize| {
            let mut out = [vec![0.0; 333], vec![0.0; 333], vec![0.0; 333 + odd]];
            let [weighed, halved, doubled] = &mut out;
            level.run(Weigh { out: weighed, source: &source, center: 20, pairs: &pairs, weights: &weights });
            level.run(HalveRow { out: halved, buffer: &source });
            level.run(DoubleRow { out: doubled, buffer: &source, odd });
            out.map(|row| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        };
        for level in Level::available() {
            for odd in [0, 1] {
                assert!(bits(level, odd) == bits(Level::BASELINE, odd), "{level:?}");
            }
        }
    }
}
