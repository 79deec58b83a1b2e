//! The interpolating cubic B-spline of a grid of samples: twice continuously differentiable, exact at the samples.
//!
//! Along each axis the coefficients solve `c[i-1] + 4 c[i] + c[i+1] = 6 f[i]` with natural ends (no curvature at
//! the border), so that a slope runs straight up to the edge; beyond the edge the border value continues.

mod rows;

use rayon::prelude::*;

use self::rows::RowKernel;
pub use self::rows::Taps;
use crate::kit::simd::Level;

/// A cubic B-spline through `cols` x `rows` samples one step apart.
#[derive(Clone, Debug)]
pub struct Spline {
    cols: usize,
    rows: usize,
    /// Coefficients with one extrapolated line around: `cols + 2` by `rows + 2`.
    coefficients: Vec<f32>,
}

/// The four weights of a position and the first of the coefficients they apply to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Index of the first coefficient in a padded line.
    pub first: usize,
    /// Weights of four coefficients in a row.
    pub weights: [f32; 4],
}

impl Tap {
    /// The tap of a position in steps along a line of `n` samples; beyond the ends it stands at the end.
    pub fn at(position: f64, n: usize) -> Self {
        let last = n.saturating_sub(1) as f64;
        let p = if position.is_finite() { position.clamp(0.0, last) } else { 0.0 };
        let i = p.floor().min((last - 1.0).max(0.0));
        let t = p - i;
        let s = 1.0 - t;
        let weights = [
            s * s * s / 6.0,
            (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
            (4.0 + s * s * (3.0 * s - 6.0)) / 6.0,
            t * t * t / 6.0,
        ];
        Self { first: i as usize, weights: weights.map(|w| w as f32) }
    }
}

impl Spline {
    /// Fits the spline through samples in row order.
    ///
    /// # Panics
    /// When there is not one sample per point, or none at all: that is a bug of the caller.
    pub fn fit(cols: usize, rows: usize, samples: &[f32]) -> Self {
        assert!(cols > 0 && rows > 0 && samples.len() == cols * rows, "one sample per point");
        let (wide, tall) = (cols + 2, rows + 2);
        let mut coefficients = vec![0.0; wide * tall];
        let factors = Factors::new(cols);
        let inner = &mut coefficients[wide..wide * (rows + 1)];
        let bands = inner.par_chunks_mut(TOGETHER * wide).zip(samples.par_chunks(TOGETHER * cols));
        bands.for_each(|(lines, samples)| {
            for (line, samples) in lines.chunks_mut(wide).zip(samples.chunks(cols)) {
                line[1..=cols].copy_from_slice(samples);
            }
            factors.solve_lines(lines, wide, cols);
            for line in lines.chunks_mut(wide) {
                line[0] = extrapolate(line[1], line[2.min(cols)]);
                line[cols + 1] = extrapolate(line[cols], line[(cols - 1).max(1)]);
            }
        });
        let mut spline = Self { cols, rows, coefficients };
        spline.solve_columns();
        spline
    }

    /// The second pass of the fit, down the columns; whole rows at a time, so that memory is read in order.
    fn solve_columns(&mut self) {
        let (wide, rows) = (self.cols + 2, self.rows);
        let factors = Factors::new(rows);
        let inner = &mut self.coefficients[wide..wide * (rows + 1)];
        factors.solve(inner, wide, wide);
        let (first, second) = (wide, wide * 2.min(rows));
        let (last, before) = (wide * rows, wide * (rows - 1).max(1));
        for c in 0..wide {
            let k = &mut self.coefficients;
            k[c] = extrapolate(k[first + c], k[second + c]);
            k[wide * (rows + 1) + c] = extrapolate(k[last + c], k[before + c]);
        }
    }

    /// The value at a position in steps from the first sample; beyond the edge the border value continues.
    pub fn value(&self, u: f64, v: f64) -> f32 {
        let (x, y) = (Tap::at(u, self.cols), Tap::at(v, self.rows));
        let wide = self.cols + 2;
        let line = |j: usize| {
            let c = &self.coefficients[(y.first + j) * wide + x.first..][..4.min(wide - x.first)];
            c.iter().zip(x.weights).map(|(c, w)| c * w).sum::<f32>()
        };
        let lines = 4.min(self.rows + 2 - y.first);
        (0..lines).map(|j| line(j) * y.weights[j]).sum()
    }

    /// The taps of positions along the columns, for [`row`](Self::row).
    pub fn taps(&self, positions: impl Iterator<Item = f64>) -> Taps {
        Taps::new(positions.map(|p| Tap::at(p, self.cols)).collect())
    }

    /// The values at one position `v` down the rows and the taps of many columns.
    pub fn row(&self, v: f64, taps: &Taps, out: &mut [f32]) {
        self.row_on(Level::best(), v, taps, out);
    }

    /// As [`row`](Self::row) on a given instruction set; the bits do not change.
    pub fn row_on(&self, level: Level, v: f64, taps: &Taps, out: &mut [f32]) {
        level.run(RowKernel { spline: self, down: Tap::at(v, self.rows), taps, out });
    }

    /// Bytes of the coefficients.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.coefficients.as_slice()) as u64
    }
}

/// Lines that are solved side by side: each step waits for the one before, those of other lines do not.
const TOGETHER: usize = 4;

fn extrapolate(edge: f32, inner: f32) -> f32 {
    2.0 * edge - inner
}

/// The elimination factors of the tridiagonal system of `n` unknowns, the first and last of which are known.
struct Factors(Vec<f32>);

impl Factors {
    fn new(n: usize) -> Self {
        let mut factors = vec![0.0f64; n];
        for i in 1..n.saturating_sub(1) {
            factors[i] = 1.0 / (4.0 - factors[i - 1]);
        }
        Self(factors.into_iter().map(|f| f as f32).collect())
    }

    /// Solves lines in place, each `wide` values long with its samples from the second on.
    fn solve_lines(&self, lines: &mut [f32], wide: usize, cols: usize) {
        let (a, rest) = lines.split_at_mut(wide.min(lines.len()));
        let (b, rest) = rest.split_at_mut(wide.min(rest.len()));
        let (c, d) = rest.split_at_mut(wide.min(rest.len()));
        if d.len() == wide {
            return self.solve_together([a, b, c, d].map(|line| &mut line[1..=cols]));
        }
        for line in [a, b, c].into_iter().filter(|line| !line.is_empty()) {
            self.solve(&mut line[1..=cols], 1, 1);
        }
    }

    /// As [`solve`](Self::solve) for several rows.
    fn solve_together(&self, mut lines: [&mut [f32]; TOGETHER]) {
        let n = self.0.len();
        for i in 1..n.saturating_sub(1) {
            for x in &mut lines {
                x[i] = (6.0 * x[i] - x[i - 1]) * self.0[i];
            }
        }
        for i in (1..n.saturating_sub(1)).rev() {
            for x in &mut lines {
                x[i] -= x[i + 1] * self.0[i];
            }
        }
    }

    /// Solves in place for lines of `len` values laid `stride` apart: `stride` and `len` 1 for a row, the row
    /// length for all columns at once.
    fn solve(&self, values: &mut [f32], stride: usize, len: usize) {
        let n = self.0.len();
        for i in 1..n.saturating_sub(1) {
            let f = self.0[i];
            let (before, here) = values.split_at_mut(i * stride);
            let before = &before[(i - 1) * stride..][..len];
            for (x, p) in here[..len].iter_mut().zip(before) {
                *x = (6.0 * *x - p) * f;
            }
        }
        for i in (1..n.saturating_sub(1)).rev() {
            let f = self.0[i];
            let (here, after) = values.split_at_mut((i + 1) * stride);
            for (x, a) in here[i * stride..][..len].iter_mut().zip(&after[..len]) {
                *x -= a * f;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rough(cols: usize, rows: usize) -> Vec<f32> {
        (0..cols * rows).map(|i| (crate::kit::hash::unit(7, i as u64) * 1000.0) as f32).collect()
    }

    #[test]
    fn meets_the_samples() {
        for (cols, rows) in [(1, 1), (1, 5), (2, 2), (3, 7), (33, 20)] {
            let f = rough(cols, rows);
            let s = Spline::fit(cols, rows, &f);
            for (i, &want) in f.iter().enumerate() {
                let got = s.value((i % cols) as f64, (i / cols) as f64);
                assert!((got - want).abs() < 2e-3, "{cols} x {rows} at {i}: {got}, not {want}");
            }
        }
    }

    #[test]
    fn reproduces_planes_up_to_the_edge_and_continues_the_border() {
        let f: Vec<f32> = (0..20 * 9).map(|i| 3.0 + 2.0 * (i % 20) as f32 - 5.0 * (i / 20) as f32).collect();
        let s = Spline::fit(20, 9, &f);
        for (u, v) in [(0.25, 0.75), (18.9, 7.5), (10.5, 3.3), (-4.0, 2.0), (30.0, 100.0)] {
            let want = 3.0 + 2.0 * f64::clamp(u, 0.0, 19.0) - 5.0 * f64::clamp(v, 0.0, 8.0);
            assert!((f64::from(s.value(u, v)) - want).abs() < 1e-4, "at ({u}, {v})");
        }
    }

    /// A natural spline against one solved densely in f64.
    #[test]
    fn is_the_natural_cubic_spline() {
        let f = rough(12, 1);
        let s = Spline::fit(12, 1, &f);
        let m = second_derivatives(&f);
        for k in 0..110 {
            let u = f64::from(k) / 10.0;
            let i = (u as usize).min(10);
            let (t, h) = (u - i as f64, 1.0 - (u - i as f64));
            let lin = h * f64::from(f[i]) + t * f64::from(f[i + 1]);
            let want = lin + (h * h * h - h) * m[i] / 6.0 + (t * t * t - t) * m[i + 1] / 6.0;
            assert!((f64::from(s.value(u, 0.0)) - want).abs() < 2e-3, "at {u}");
        }
    }

    fn second_derivatives(f: &[f32]) -> Vec<f64> {
        let n = f.len();
        let mut m = vec![0.0; n];
        for _ in 0..200 {
            for i in 1..n - 1 {
                let d = 6.0 * (f64::from(f[i - 1]) - 2.0 * f64::from(f[i]) + f64::from(f[i + 1]));
                m[i] = (d - m[i - 1] - m[i + 1]) / 4.0;
            }
        }
        m
    }

    /// A row as it is put together sample by sample.
    fn plain_row(s: &Spline, v: f64, taps: &Taps) -> Vec<f32> {
        let (y, wide) = (Tap::at(v, s.rows), s.cols + 2);
        let down = |c: usize| {
            let rows = (0..4.min(s.rows + 2 - y.first)).zip(y.weights);
            rows.fold(0.0, |sum, (j, w)| {
                sum + s.coefficients.get((y.first + j) * wide + c).unwrap_or(&0.0) * w
            })
        };
        let down = |c: usize| if c < wide { down(c) } else { 0.0 };
        let across = |t: &Tap| {
            let (c, w) = ([0, 1, 2, 3].map(|k| down(t.first + k)), t.weights);
            c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3]
        };
        taps.iter().map(across).collect()
    }

    #[test]
    fn rows_are_what_their_samples_are_alone_on_every_instruction_set() {
        for (cols, rows) in [(1, 1), (2, 5), (40, 7), (67, 31)] {
            let s = Spline::fit(cols, rows, &rough(cols, rows));
            // Whole ratios and others, windows that begin between samples, lie off the corner and beyond the border.
            for (step, start) in [
                (0.5, 0.0),
                (0.5, -20.0),
                (0.25, 3.75),
                (1.0 / 3.0, -1.0),
                (0.37, 2.0),
                (2.0, 0.0),
                (1e-3, 5.0),
            ] {
                for n in [1, 7, 150, 301] {
                    let taps = s.taps((0..n).map(|i| start + f64::from(i) * step));
                    for v in [-3.0, 0.0, 1.5, 4.3, rows as f64 - 1.0, rows as f64] {
                        let want = plain_row(&s, v, &taps);
                        for level in Level::available() {
                            let mut got = vec![f32::NAN; want.len()];
                            s.row_on(level, v, &taps, &mut got);
                            let same = got.iter().zip(&want).all(|(a, b)| a.to_bits() == b.to_bits());
                            assert!(same, "{cols} x {rows}, {n} by {step} from {start} at {v} on {level:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn lines_solved_together_are_what_each_is_alone() {
        for (cols, rows) in [(1, 4), (2, 4), (3, 9), (50, 6), (33, 8)] {
            let f = rough(cols, rows);
            let whole = Spline::fit(cols, rows, &f);
            for (r, line) in f.chunks(cols).enumerate() {
                let factors = Factors::new(cols);
                let mut alone = line.to_vec();
                factors.solve(&mut alone, 1, 1);
                let mut lines = vec![0.0; 4 * (cols + 2)];
                lines[cols + 2..][1..=cols].copy_from_slice(line);
                factors.solve_lines(&mut lines, cols + 2, cols);
                assert_eq!(&lines[cols + 2..][1..=cols], alone, "row {r} of {cols} x {rows}");
            }
            assert_eq!(whole.rows, rows);
        }
    }

    #[test]
    fn rows_and_points_agree() {
        let s = Spline::fit(17, 13, &rough(17, 13));
        let at = |i: usize| i as f64 * 0.37 - 1.0;
        let taps = s.taps((0..50).map(at));
        let mut out = vec![0.0; 50];
        for v in [-1.0, 0.0, 0.4, 6.0, 11.99, 12.0, 15.0] {
            s.row(v, &taps, &mut out);
            for (i, got) in out.iter().enumerate() {
                assert!((got - s.value(at(i), v)).abs() < 1e-3, "at ({}, {v})", at(i));
            }
        }
    }
}
