//! How the attributes of a curve go from constraint point to constraint point.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the height goes from constraint point to constraint point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rise {
    /// Smooth, and never above or below the two heights it goes between \[fritsch1980\].
    #[default]
    Monotone,
    /// The cubic spline of the paper: rounder, and free to swing past its points.
    Free,
}

/// The values of one group of attributes at rising `u`; linear between, held before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<const N: usize> {
    keys: Vec<(f64, [f64; N])>,
}

impl<const N: usize> Track<N> {
    /// From keys whose `u` rise; `None` when there is no key.
    pub(super) fn new(keys: Vec<(f64, [f64; N])>) -> Option<Self> {
        debug_assert!(keys.is_sorted_by(|a, b| a.0 < b.0), "u rises");
        (!keys.is_empty()).then_some(Self { keys })
    }

    /// `u` and the values there, in the order of `u`.
    pub fn keys(&self) -> &[(f64, [f64; N])] {
        &self.keys
    }

    /// The values at `u`.
    pub fn at(&self, u: f64) -> [f64; N] {
        let last = self.keys.len() - 1;
        match self.keys.partition_point(|k| k.0 <= u) {
            0 => self.keys[0].1,
            i if i > last => self.keys[last].1,
            i => {
                let ((u0, a), (u1, b)) = (self.keys[i - 1], self.keys[i]);
                let t = (u - u0) / (u1 - u0);
                std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
            }
        }
    }

    pub(crate) fn mapped(&self, f: impl Fn([f64; N]) -> [f64; N]) -> Self {
        Self { keys: self.keys.iter().map(|&(u, v)| (u, f(v))).collect() }
    }
}

/// A cubic through heights at rising `u`, held before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    points: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

impl Profile {
    /// Through points `[u, height]`, of which there is at least one.
    pub(super) fn new(points: Vec<[f64; 2]>, rise: Rise) -> Self {
        let slopes = match rise {
            _ if points.len() < 2 => vec![0.0; points.len()],
            Rise::Monotone => monotone(&points),
            Rise::Free => free(&points),
        };
        Self { points, slopes }
    }

    /// The height at `u` and its change by `u`, taken on the piece that ends (`from_below`) or starts there.
    pub fn at(&self, u: f64, from_below: bool) -> [f64; 2] {
        let last = self.points.len() - 1;
        let held = |i: usize| [self.points[i][1], 0.0];
        let i = self.points.partition_point(|p| if from_below { p[0] < u } else { p[0] <= u });
        match i {
            0 => held(0),
            i if i > last => held(last),
            i => {
                let ([u0, a], [u1, b]) = (self.points[i - 1], self.points[i]);
                let h = u1 - u0;
                hermite([a, b], [self.slopes[i - 1] * h, self.slopes[i] * h], (u - u0) / h, h)
            }
        }
    }
}

/// The cubic from `a` to `b` with the slopes `m` per piece, and its derivative over the piece's width; the height
/// as chord and what bends away from it, so that a straight one stays straight.
#[inline]
fn hermite([a, b]: [f64; 2], m: [f64; 2], t: f64, width: f64) -> [f64; 2] {
    let rise = b - a;
    let (p, q) = (m[0] - rise, m[1] - rise);
    let s = 1.0 - t;
    let value = a + t * rise + t * s * (p * s - q * t);
    let change = rise + p * s * (s - 2.0 * t) + q * t * (t - 2.0 * s);
    [value, change / width]
}

/// The cubic of a piece of a profile at its share `t`: `[a, b]` its ends, `m` its slopes over the whole piece.
#[inline]
pub fn hermite_value(ends: [f64; 2], m: [f64; 2], t: f64) -> f64 {
    hermite(ends, m, t, 1.0)[0]
}

/// Slopes of Fritsch and Carlson: three-point estimates, cut to the circle of radius 3 in which a piece is monotone.
fn monotone(points: &[[f64; 2]]) -> Vec<f64> {
    let secants: Vec<f64> = points.windows(2).map(|w| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0])).collect();
    let n = points.len();
    let mut slopes: Vec<f64> = (0..n)
        .map(|i| match i {
            0 => secants[0],
            i if i == n - 1 => secants[n - 2],
            i if secants[i - 1] * secants[i] <= 0.0 => 0.0,
            i => 0.5 * (secants[i - 1] + secants[i]),
        })
        .collect();
    for (i, &secant) in secants.iter().enumerate() {
        if secant == 0.0 {
            (slopes[i], slopes[i + 1]) = (0.0, 0.0);
            continue;
        }
        let (a, b) = (slopes[i] / secant, slopes[i + 1] / secant);
        let square = a * a + b * b;
        if square > 9.0 {
            let cut = 3.0 / square.sqrt();
            (slopes[i], slopes[i + 1]) = (cut * a * secant, cut * b * secant);
        }
    }
    slopes
}

/// Slopes of the natural cubic spline.
fn free(points: &[[f64; 2]]) -> Vec<f64> {
    let n = points.len();
    // Rows: 2 m₀ + m₁ = 3 d₀; m₍ᵢ₋₁₎/h₍ᵢ₋₁₎ + 2 mᵢ (1/h₍ᵢ₋₁₎ + 1/hᵢ) + m₍ᵢ₊₁₎/hᵢ = 3 (d₍ᵢ₋₁₎/h₍ᵢ₋₁₎ + dᵢ/hᵢ); the last as the first.
    let inverse: Vec<f64> = points.windows(2).map(|w| 1.0 / (w[1][0] - w[0][0])).collect();
    let secants: Vec<f64> = points.windows(2).zip(&inverse).map(|(w, k)| (w[1][1] - w[0][1]) * k).collect();
    let row = |i: usize| {
        let below = if i > 0 { inverse[i - 1] } else { 0.0 };
        let above = if i < n - 1 { inverse[i] } else { 0.0 };
        let right = if i > 0 { below * secants[i - 1] } else { 0.0 }
            + if i < n - 1 { above * secants[i] } else { 0.0 };
        (below, 2.0 * (below + above), above, 3.0 * right)
    };
    let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let (a, b, c, d) = row(i);
        let (before, value) = if i > 0 { (upper[i - 1], right[i - 1]) } else { (0.0, 0.0) };
        let pivot = b - a * before;
        upper[i] = c / pivot;
        right[i] = (d - a * value) / pivot;
    }
    for i in (0..n - 1).rev() {
        right[i] -= upper[i] * right[i + 1];
    }
    right
}
