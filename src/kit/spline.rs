//! The interpolating cubic B-spline of a grid of samples: twice continuously differentiable, exact at the samples.
//!
//! Along each axis the coefficients solve `c[i-1] + 4 c[i] + c[i+1] = 6 f[i]` with natural ends (no curvature at
//! the border), so that a slope runs straight up to the edge; beyond the edge the border value continues.

use rayon::prelude::*;

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
        coefficients[wide..wide * (rows + 1)].par_chunks_mut(wide).zip(samples.par_chunks(cols)).for_each(
            |(line, samples)| {
                line[1..=cols].copy_from_slice(samples);
                factors.solve(&mut line[1..=cols], 1, 1);
                line[0] = extrapolate(line[1], line[2.min(cols)]);
                line[cols + 1] = extrapolate(line[cols], line[(cols - 1).max(1)]);
            },
        );
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
    pub fn taps(&self, positions: impl Iterator<Item = f64>) -> Vec<Tap> {
        positions.map(|p| Tap::at(p, self.cols)).collect()
    }

    /// The values at one position `v` down the rows and the taps of many columns.
    pub fn row(&self, v: f64, taps: &[Tap], out: &mut [f32]) {
        let (y, wide) = (Tap::at(v, self.rows), self.cols + 2);
        // Only the stretch of the line that the taps reach is put together: a tile of a large raster is small.
        let reach = |(lo, hi): (usize, usize), t: &Tap| (lo.min(t.first), hi.max(t.first + 4));
        let (from, to) = taps.iter().fold((usize::MAX, 0), reach);
        let mut line = vec![0.0f32; to.saturating_sub(from)];
        let lines = 4.min(self.rows + 2 - y.first);
        for (j, weight) in y.weights.iter().enumerate().take(lines) {
            let row = &self.coefficients[(y.first + j) * wide..][..wide];
            for (sum, c) in line.iter_mut().zip(row.get(from..).unwrap_or(&[])) {
                *sum += c * weight;
            }
        }
        for (o, tap) in out.iter_mut().zip(taps) {
            let c = &line[tap.first - from..][..4];
            let w = tap.weights;
            *o = c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3];
        }
    }

    /// Bytes of the coefficients.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.coefficients.as_slice()) as u64
    }
}

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
