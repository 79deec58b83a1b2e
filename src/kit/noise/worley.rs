//! Distances to random points, one in each cell of a lattice.

use super::CHUNK;
use super::lattice::{Columns, Turned, scramble, spread, step};
use crate::kit::hash;
use crate::kit::simd::{Kernel, Level, larger, smaller};

/// How distance is measured, along the axes of the turned lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// `√(x² + y²)`.
    Euclidean,
    /// `|x| + |y|`.
    Manhattan,
    /// `max(|x|, |y|)`.
    Chebyshev,
}

/// What is made of the distances, which are in cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Distance to the nearest point.
    F1,
    /// Distance to the second nearest point.
    F2,
    /// Second less first: 0 on the borders between cells.
    F2MinusF1,
    /// A random number from 0 to 1 for the cell of the nearest point.
    CellValue,
}

/// Cellular noise after Worley, with one point in each cell \[worley1996\].
///
/// The search is exact: a point is skipped only when no sample of the cell can have it among its nearest one (twelve
/// cells are searched) or two (twenty-four), whatever metric and jitter.
#[derive(Clone, Debug)]
pub struct Worley {
    turned: Turned,
    metric: Metric,
    measure: Measure,
    /// Side of the square in a cell that its point may stand in.
    jitter: f32,
    /// Height of a measure of 1, in metres.
    amplitude: f32,
    /// Height of a measure of 0, in metres.
    base: f32,
}

impl Worley {
    /// Cellular noise with cells of `size` metres; points stand within `jitter` (0 to 1) of a cell around its middle.
    /// Heights become `base + amplitude · measure`.
    pub fn new(size: f64, jitter: f64, seed: u64, base: f64, amplitude: f64) -> Self {
        let turned = Turned::new(size, hash::nth(seed, 0));
        let (metric, measure) = (Metric::Euclidean, Measure::F1);
        Self {
            turned,
            metric,
            measure,
            jitter: jitter as f32,
            amplitude: amplitude as f32,
            base: base as f32,
        }
    }

    /// The same points, measured another way.
    pub fn measured(self, metric: Metric, measure: Measure) -> Self {
        Self { metric, measure, ..self }
    }

    /// Prepares the columns at some x, in metres.
    pub fn over(&self, xs: &[f64]) -> WorleyRows<'_> {
        WorleyRows { noise: self, columns: self.turned.columns(xs), level: Level::best() }
    }

    /// Bytes that [`over`](Self::over) takes for some columns.
    pub fn bytes(columns: usize) -> u64 {
        Columns::bytes(columns)
    }

    /// The random point of a cell of the turned lattice, in cells from the middle of it, and the hash it came from.
    pub fn point(&self, cell: [u32; 2]) -> ([f32; 2], u32) {
        let [col, row] = spread(cell);
        let (h, at) = jitter(col, row, self.jitter * PER_UNIT);
        (at, h)
    }

    /// The lattice that the cells are of.
    pub fn lattice(&self) -> &Turned {
        &self.turned
    }
}

/// Cellular noise on the rows of a grid.
#[derive(Clone, Debug)]
pub struct WorleyRows<'a> {
    noise: &'a Worley,
    columns: Columns,
    level: Level,
}

impl WorleyRows<'_> {
    /// The same on a given instruction set; the bits do not change.
    pub fn on(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// The heights of a row at y (in metres), one for each x.
    pub fn row(&self, y: f64, out: &mut [f32]) {
        match self.noise.metric {
            Metric::Euclidean => self.run(y, out, Euclidean),
            Metric::Manhattan => self.run(y, out, Manhattan),
            Metric::Chebyshev => self.run(y, out, Chebyshev),
        }
    }

    fn run<D: Distance>(&self, y: f64, out: &mut [f32], distance: D) {
        match self.noise.measure {
            Measure::F1 | Measure::CellValue => {
                self.level.run(RowKernel::<D, false> { rows: self, y, out, distance });
            }
            Measure::F2 | Measure::F2MinusF1 => {
                self.level.run(RowKernel::<D, true> { rows: self, y, out, distance });
            }
        }
    }
}

/// A distance by way of a number that grows with it and is cheaper.
trait Distance: Copy {
    fn compare(self, x: f32, y: f32) -> f32;
    fn finish(self, compared: f32) -> f32;
}

#[derive(Clone, Copy)]
struct Euclidean;
impl Distance for Euclidean {
    #[inline(always)]
    fn compare(self, x: f32, y: f32) -> f32 {
        x * x + y * y
    }
    #[inline(always)]
    fn finish(self, compared: f32) -> f32 {
        compared.sqrt()
    }
}

#[derive(Clone, Copy)]
struct Manhattan;
impl Distance for Manhattan {
    #[inline(always)]
    fn compare(self, x: f32, y: f32) -> f32 {
        x.abs() + y.abs()
    }
    #[inline(always)]
    fn finish(self, compared: f32) -> f32 {
        compared
    }
}

#[derive(Clone, Copy)]
struct Chebyshev;
impl Distance for Chebyshev {
    #[inline(always)]
    fn compare(self, x: f32, y: f32) -> f32 {
        larger(x.abs(), y.abs())
    }
    #[inline(always)]
    fn finish(self, compared: f32) -> f32 {
        compared
    }
}

/// What the search knows of a sample.
#[derive(Clone, Copy)]
struct Nearest {
    first: f32,
    second: f32,
    hash: u32,
}

/// One over the span of an `i32`: a hash as such becomes a number from −1/2 to 1/2.
const PER_UNIT: f32 = 1.0 / 4_294_967_296.0;

/// The hash of a cell, and the place of its point around the middle, within a square of side `scale · 2³²`.
#[inline(always)]
fn jitter(col: u32, row: u32, scale: f32) -> (u32, [f32; 2]) {
    let h = scramble(col, row);
    // The place takes the lower bits too, which the hash leaves weak.
    let h = h ^ (h >> 12);
    (h, [h as i32 as f32 * scale, (h << 16) as i32 as f32 * scale])
}

/// Searches the cells around a sample. A cell is centred on its corner of the lattice, so the sample at 0 to 1 has
/// the cells 0 and 1 beside it.
#[inline(always)]
fn search<D: Distance, const TWO: bool>(
    distance: D,
    cell: [u32; 2],
    [x, y]: [f32; 2],
    scale: f32,
) -> Nearest {
    let [col, row] = spread(cell);
    let mut best = Nearest { first: f32::MAX, second: f32::MAX, hash: 0 };
    macro_rules! look {
        ($(($i:literal, $j:literal))*) => {$({
            let (h, [px, py]) = jitter(step(col, 0, $i), step(row, 1, $j), scale);
            let d = distance.compare(($i as f32 - x) + px, ($j as f32 - y) + py);
            if TWO {
                best.second = smaller(best.second, larger(best.first, d));
            }
            best.hash = if d < best.first { h } else { best.hash };
            best.first = smaller(best.first, d);
        })*};
    }
    look!((0, 0)(1, 0)(0, 1)(1, 1));
    look!((0, -1)(1, -1)(-1, 0)(2, 0)(-1, 1)(2, 1)(0, 2)(1, 2));
    if TWO {
        look!((-1, -1)(2, -1)(-1, 2)(2, 2));
        look!((0, -2)(1, -2)(-2, 0)(3, 0)(-2, 1)(3, 1)(0, 3)(1, 3));
    }
    best
}

struct RowKernel<'a, D, const TWO: bool> {
    rows: &'a WorleyRows<'a>,
    y: f64,
    out: &'a mut [f32],
    distance: D,
}

impl<D: Distance, const TWO: bool> Kernel for RowKernel<'_, D, TWO> {
    #[inline(always)]
    fn run(self) {
        let Self { rows, y, out, distance } = self;
        let noise = rows.noise;
        let scale = noise.jitter * PER_UNIT;
        let row = noise.turned.row(y);
        for (c, out) in out.chunks_mut(CHUNK).enumerate() {
            let (mut first, mut second, mut hash) = ([0.0; CHUNK], [0.0; CHUNK], [0; CHUNK]);
            let found = first.iter_mut().zip(&mut second).zip(&mut hash);
            for ((cell, at), ((first, second), hash)) in
                rows.columns.block(c * CHUNK, CHUNK).on(row).zip(found)
            {
                let best = search::<D, TWO>(distance, cell, at, scale);
                *first = distance.finish(best.first);
                *second = if TWO { distance.finish(best.second) } else { 0.0 };
                *hash = best.hash;
            }
            let measured = out.iter_mut().zip(first.iter().zip(&second).zip(&hash));
            let height = |v: f32| noise.base + noise.amplitude * v;
            match noise.measure {
                Measure::F1 => measured.for_each(|(o, ((f1, _), _))| *o = height(*f1)),
                Measure::F2 => measured.for_each(|(o, ((_, f2), _))| *o = height(*f2)),
                Measure::F2MinusF1 => measured.for_each(|(o, ((f1, f2), _))| *o = height(f2 - f1)),
                Measure::CellValue => measured.for_each(|(o, (_, h))| *o = height(value(*h))),
            }
        }
    }
}

/// A number from 0 to 1 that has nothing to do with the place of the point.
#[inline(always)]
fn value(hash: u32) -> f32 {
    let h = (hash ^ (hash >> 15)).wrapping_mul(0x297a_2d39);
    (h >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}
