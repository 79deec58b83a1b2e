//! Whole rows of a spline: down the rows first, then across, where columns that repeat are worked on together.
//!
//! A grid that is a whole number of times finer takes the same few sets of weights again and again, each time one
//! coefficient farther on. The samples of one set are then sums of stretches of a line, which vectorise; they are put
//! in turn afterwards. The sums are in one order wherever a sample stands.

use std::ops::Range;

use super::{Spline, Tap};
use crate::kit::simd::Kernel;

/// The taps of many columns, for [`Spline::row`].
#[derive(Clone, Debug, Default)]
pub struct Taps {
    taps: Vec<Tap>,
    /// The coefficients that they reach.
    reach: Range<usize>,
    /// Columns after which the weights repeat one coefficient farther on; none where they do not.
    period: Option<usize>,
    /// Stretches of columns in which they repeat so.
    runs: Vec<Range<usize>>,
}

impl Taps {
    /// Looks for what repeats in the taps of columns.
    pub fn new(taps: Vec<Tap>) -> Self {
        // Only the stretch of a line that the taps reach is put together: a tile of a large raster is small.
        let start = taps.iter().map(|t| t.first).min().unwrap_or(0);
        let end = taps.iter().map(|t| t.first + 4).max().unwrap_or(0);
        let period = period(&taps);
        let runs = period.map_or(Vec::new(), |period| runs(&taps, period));
        Self { taps, reach: start..end, period, runs }
    }

    /// The tap of each column.
    pub fn iter(&self) -> std::slice::Iter<'_, Tap> {
        self.taps.iter()
    }
}

/// Whether a tap is another one so many coefficients farther on.
fn repeats(taps: &[Tap], k: usize, period: usize) -> bool {
    match (taps.get(k), taps.get(k + period)) {
        (Some(a), Some(b)) => {
            b.first == a.first + 1 && a.weights.map(f32::to_bits) == b.weights.map(f32::to_bits)
        }
        _ => false,
    }
}

/// The period of the taps in the middle, which no border touches.
fn period(taps: &[Tap]) -> Option<usize> {
    (1..=LONGEST).find(|&period| repeats(taps, taps.len() / 2, period))
}

/// Splits columns into stretches whose taps repeat; one without repetition is a period long.
fn runs(taps: &[Tap], period: usize) -> Vec<Range<usize>> {
    let (mut runs, mut start) = (Vec::new(), 0);
    while start < taps.len() {
        let repeated = (start..taps.len()).take_while(|&k| repeats(taps, k, period)).count();
        let end = (start + repeated + period).min(taps.len());
        runs.push(start..end);
        start = end;
    }
    runs
}

/// Longer periods gain little.
const LONGEST: usize = 16;

/// Fewer periods are not worth the turn.
const FEWEST: usize = 8;

/// Samples of one set of weights that are worked on together.
const BLOCK: usize = 64;

/// A row at one position down the rows.
pub(super) struct RowKernel<'a> {
    pub(super) spline: &'a Spline,
    pub(super) down: Tap,
    pub(super) taps: &'a Taps,
    pub(super) out: &'a mut [f32],
}

impl Kernel for RowKernel<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { spline, down, taps, out } = self;
        let line = spline.line(&down, &taps.reach);
        let first = taps.reach.start;
        let Some(period) = taps.period else { return alone(&line, first, &taps.taps, out) };
        let mut sums = [[0.0; BLOCK]; LONGEST];
        for run in &taps.runs {
            let mut at = run.clone();
            // A block of whole periods, as long as there are some.
            while at.len() >= FEWEST * period {
                let count = (at.len() / period).min(BLOCK);
                let columns = at.start..at.start + count * period;
                for (sums, tap) in sums.iter_mut().zip(&taps.taps[at.start..][..period]) {
                    across(&line[tap.first - first..][..count + 3], &tap.weights, &mut sums[..count]);
                }
                in_turn(&sums[..period], &mut out[columns]);
                at.start += count * period;
            }
            alone(&line, first, &taps.taps[at.clone()], &mut out[at]);
        }
    }
}

impl Spline {
    /// The coefficients of a stretch of columns at one position down the rows.
    #[inline(always)]
    fn line(&self, down: &Tap, reach: &Range<usize>) -> Vec<f32> {
        let wide = self.cols + 2;
        // Fewer than two rows have fewer than four lines of coefficients.
        let rows = 4.min(self.rows + 2 - down.first);
        let row = |j: usize| {
            &self.coefficients[(down.first + j) * wide..][..wide][reach.start..reach.end.min(wide)]
        };
        let mut line = vec![0.0; reach.len()];
        let w = down.weights;
        if rows == 4 {
            let (upper, lower) = (row(0).iter().zip(row(1)), row(2).iter().zip(row(3)));
            for (sum, ((a, b), (c, d))) in line.iter_mut().zip(upper.zip(lower)) {
                *sum = (((0.0 + a * w[0]) + b * w[1]) + c * w[2]) + d * w[3];
            }
            return line;
        }
        for (j, weight) in w.iter().enumerate().take(rows) {
            for (sum, c) in line.iter_mut().zip(row(j)) {
                *sum += c * weight;
            }
        }
        line
    }
}

/// Samples with the same weights, each one coefficient on.
#[inline(always)]
fn across(line: &[f32], w: &[f32; 4], out: &mut [f32]) {
    let pairs = line.iter().zip(&line[1..]).zip(line[2..].iter().zip(&line[3..]));
    for (o, ((a, b), (c, d))) in out.iter_mut().zip(pairs) {
        *o = a * w[0] + b * w[1] + c * w[2] + d * w[3];
    }
}

/// Samples each with a tap of its own.
#[inline(always)]
fn alone(line: &[f32], first: usize, taps: &[Tap], out: &mut [f32]) {
    for (o, tap) in out.iter_mut().zip(taps) {
        let (c, w) = (&line[tap.first - first..][..4], tap.weights);
        *o = c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3];
    }
}

/// Puts samples of several sets of weights in turn.
#[inline(always)]
fn in_turn(sums: &[[f32; BLOCK]], out: &mut [f32]) {
    if let [even, odd] = sums {
        for (pair, (a, b)) in out.chunks_exact_mut(2).zip(even.iter().zip(odd)) {
            pair[0] = *a;
            pair[1] = *b;
        }
        return;
    }
    for (k, column) in sums.iter().enumerate() {
        for (o, sum) in out.iter_mut().skip(k).step_by(sums.len()).zip(column) {
            *o = *sum;
        }
    }
}
