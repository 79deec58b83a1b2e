//! Elliptical arcs of SVG paths as cubic pieces.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::value::curves::bezier::Point;

/// An arc from where the pen stands, as SVG writes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) from: Point,
    pub(super) to: Point,
    pub(super) radii: [f64; 2],
    /// Degrees.
    pub(super) rotation: f64,
    pub(super) large: bool,
    pub(super) sweep: bool,
}

impl Arc {
    /// Handles and end of each piece, none longer than a quarter turn \[SVG 2, appendix B.2\].
    pub(super) fn pieces(&self) -> Vec<[Point; 3]> {
        let [rx, ry] = self.radii.map(f64::abs);
        if self.from == self.to {
            return Vec::new();
        }
        if !(rx > 0.0 && ry > 0.0) {
            let third =
                |k: f64| -> Point { std::array::from_fn(|i| self.from[i] + (self.to[i] - self.from[i]) * k) };
            return vec![[third(1.0 / 3.0), third(2.0 / 3.0), self.to]];
        }
        let (sin, cos) = libm::sincos(self.rotation.to_radians());
        // Half the way from the end to the start, in the axes of the ellipse.
        let half = [0.5 * (self.from[0] - self.to[0]), 0.5 * (self.from[1] - self.to[1])];
        let x = cos * half[0] + sin * half[1];
        let y = -sin * half[0] + cos * half[1];
        // Radii that are too small for the distance grow.
        let grow = ((x / rx) * (x / rx) + (y / ry) * (y / ry)).sqrt().max(1.0);
        let (rx, ry) = (rx * grow, ry * grow);
        let across = (x / rx) * (x / rx) + (y / ry) * (y / ry);
        let away = (((1.0 - across) / across).max(0.0)).sqrt();
        let away = if self.large == self.sweep { -away } else { away };
        let (cx, cy) = (away * rx * y / ry, -away * ry * x / rx);
        let angle = |x: f64, y: f64| libm::atan2(y / ry, x / rx);
        let start = angle(x - cx, y - cy);
        let mut turn = angle(-x - cx, -y - cy) - start;
        if self.sweep && turn < 0.0 {
            turn += 2.0 * PI;
        } else if !self.sweep && turn > 0.0 {
            turn -= 2.0 * PI;
        }
        let middle = [0.5 * (self.from[0] + self.to[0]), 0.5 * (self.from[1] + self.to[1])];
        let centre = [middle[0] + cos * cx - sin * cy, middle[1] + sin * cx + cos * cy];
        let place = |x: f64, y: f64| {
            let (x, y) = (rx * x, ry * y);
            [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y]
        };
        let n = (turn.abs() / FRAC_PI_2 - 1e-9).ceil().max(1.0) as usize;
        let step = turn / n as f64;
        let handle = 4.0 / 3.0 * libm::tan(0.25 * step);
        let one = |i: usize| {
            let (a, b) = (start + step * i as f64, start + step * (i + 1) as f64);
            let ((sa, ca), (sb, cb)) = (libm::sincos(a), libm::sincos(b));
            let end = if i + 1 == n { self.to } else { place(cb, sb) };
            [place(ca - handle * sa, sa + handle * ca), place(cb + handle * sb, sb - handle * cb), end]
        };
        (0..n).map(one).collect()
    }
}
