//! Transfer curves: smooth, monotone where their points are.

/// A curve through points, without overshoot: cubic pieces whose slopes are those of Fritsch and Butland
/// \[fritsch1984\], as in the PCHIP of many libraries. Before the first and after the last point it goes on straight.
#[derive(Clone, Debug, PartialEq)]
pub struct Monotone {
    points: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

impl Monotone {
    /// Through points with rising x; `None` when there are fewer than two, or x does not rise.
    pub fn through(points: &[[f64; 2]]) -> Option<Self> {
        let rising = points.windows(2).all(|w| w[1][0] > w[0][0]);
        if points.len() < 2 || !rising {
            return None;
        }
        let steps: Vec<f64> = points.windows(2).map(|w| w[1][0] - w[0][0]).collect();
        let rises: Vec<f64> = points.windows(2).map(|w| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0])).collect();
        let n = points.len();
        let slope = |i: usize| match i {
            _ if n == 2 => rises[0],
            0 => end_slope([steps[0], steps[1]], [rises[0], rises[1]]),
            i if i == n - 1 => end_slope([steps[n - 2], steps[n - 3]], [rises[n - 2], rises[n - 3]]),
            i => inner_slope([steps[i - 1], steps[i]], [rises[i - 1], rises[i]]),
        };
        Some(Self { points: points.to_vec(), slopes: (0..n).map(slope).collect() })
    }

    /// The value at x.
    pub fn at(&self, x: f64) -> f64 {
        let last = self.points.len() - 1;
        let i = self.points.partition_point(|p| p[0] <= x);
        match i {
            0 => self.points[0][1] + (x - self.points[0][0]) * self.slopes[0],
            i if i > last => self.points[last][1] + (x - self.points[last][0]) * self.slopes[last],
            i => self.piece(i - 1, x),
        }
    }

    /// The Hermite cubic from point `i` to the next.
    fn piece(&self, i: usize, x: f64) -> f64 {
        let ([x0, y0], [x1, y1]) = (self.points[i], self.points[i + 1]);
        let h = x1 - x0;
        let (t, rise) = ((x - x0) / h, (y1 - y0) / h);
        let (a, b) = (self.slopes[i] - rise, self.slopes[i + 1] - rise);
        // The chord and what bends away from it: a straight curve stays straight.
        y0 + (x - x0) * rise + h * t * (1.0 - t) * (a * (1.0 - t) - b * t)
    }
}

/// The weighted harmonic mean of the rises on both sides; none at a turn.
fn inner_slope([h0, h1]: [f64; 2], [d0, d1]: [f64; 2]) -> f64 {
    if d0 * d1 <= 0.0 {
        return 0.0;
    }
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / d0 + w1 / d1)
}

/// The three-point slope at an end, kept in the direction of the first rise and at most three times as steep.
fn end_slope([h0, h1]: [f64; 2], [d0, d1]: [f64; 2]) -> f64 {
    let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if slope * d0 <= 0.0 {
        0.0
    } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
        3.0 * d0
    } else {
        slope
    }
}

/// Bends the way from 0 to 1 so that 1/2 comes out as `middle` (0 to 1, exclusive) \[schlick1994\].
#[inline]
pub fn bias(t: f64, middle: f64) -> f64 {
    t / ((1.0 / middle - 2.0) * (1.0 - t) + 1.0)
}

/// [`bias`] up to the middle and its mirror image after it: steep in the middle where `middle` is small.
#[inline]
pub fn gain(t: f64, middle: f64) -> f64 {
    if t < 0.5 { 0.5 * bias(2.0 * t, middle) } else { 1.0 - 0.5 * bias(2.0 - 2.0 * t, middle) }
}
