//! Straight lines through points, by least squares.

use serde::Serialize;

/// The slope of a fitted line, and how much of the scatter the line explains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The figure: an exponent, as the slope of a line through logarithms.
    pub value: f64,
    /// Coefficient of determination of the line: 1 where all points lie on it, 0 where it says nothing.
    pub r2: f64,
}

/// A line `y = intercept + slope · x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) intercept: f64,
    pub(super) slope: f64,
    /// Coefficient of determination; 1 where all `y` are the same.
    pub(super) r2: f64,
}

impl Line {
    /// The line with the least sum of `weight · error²` through points `[x, y, weight]`; none where they do not stand
    /// at two places or more.
    pub(super) fn through(points: &[[f64; 3]]) -> Option<Self> {
        let total: f64 = points.iter().map(|p| p[2]).sum();
        let mean = |k: usize| points.iter().map(|p| p[k] * p[2]).sum::<f64>() / total;
        let [x, y] = [mean(0), mean(1)];
        let about =
            |f: fn([f64; 2]) -> f64| points.iter().map(|p| p[2] * f([p[0] - x, p[1] - y])).sum::<f64>();
        let (xx, xy, yy) = (about(|[x, _]| x * x), about(|[x, y]| x * y), about(|[_, y]| y * y));
        let slope = xy / xx;
        let line = Self { intercept: y - slope * x, slope, r2: if yy > 0.0 { slope * xy / yy } else { 1.0 } };
        [line.intercept, line.slope, line.r2].iter().all(|v| v.is_finite()).then_some(line)
    }

    /// The line through points `[x, y]` of the same weight.
    pub(super) fn even(points: impl IntoIterator<Item = [f64; 2]>) -> Option<Self> {
        let points: Vec<_> = points.into_iter().map(|[x, y]| [x, y, 1.0]).collect();
        Self::through(&points)
    }

    /// The slope as a figure.
    pub(super) fn rising(self) -> Fit {
        Fit { value: self.slope, r2: self.r2 }
    }

    /// The slope as a figure that grows as the line falls.
    pub(super) fn falling(self) -> Fit {
        Fit { value: -self.slope, r2: self.r2 }
    }
}
