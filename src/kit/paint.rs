//! Painting by hand: strokes of a soft round brush, kept as they were drawn.
//!
//! A stroke is a line through a few points and not a raster: it takes some dozen numbers, is the same at any size, and
//! the strokes of two people can be merged line by line. Over what lies below, a stroke moves each value towards its own
//! by `strength · f(d)`, with `d` the distance to its line; `f` is 1 up to the core `r (1 − softness)` and falls to 0 at
//! the radius `r` as `1 − 3 s² + 2 s³`. A stroke that crosses itself is as strong there as elsewhere.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::units::{Metres, Ratio};
use crate::value::curves::bezier::{dot, norm, sub, times};
use crate::value::{Bounds, Grid};

/// One stroke of a brush.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Stroke {
    /// x, y of the points of its line, in metres; one point is a dab.
    #[schemars(
        length(max = 8192),
        inner(range(min = -1e8, max = 1e8)),
        extend("x-unit" = "m", "x-items" = ["x", "y"])
    )]
    pub path: Vec<f64>,
    /// Radius of the brush.
    #[schemars(range(min = 0.01, max = 1_000_000.0), extend("x-soft" = [10.0, 2000.0], "x-log" = true))]
    pub radius: Metres,
    /// How much of the radius is soft: 0 for a hard edge, 1 for a brush that is soft from its middle.
    #[serde(skip_serializing_if = "is_usual_softness")]
    #[schemars(extend("default" = USUAL_SOFTNESS.0))]
    pub softness: Ratio,
    /// How far the stroke moves what lies below towards its value.
    #[serde(skip_serializing_if = "is_whole")]
    #[schemars(extend("default" = 1.0))]
    pub strength: Ratio,
    /// What it paints: 1 adds to the mask, 0 takes away.
    #[serde(skip_serializing_if = "is_whole")]
    #[schemars(extend("default" = 1.0))]
    pub value: Ratio,
}

const USUAL_SOFTNESS: Ratio = Ratio(0.7);

fn is_usual_softness(softness: &Ratio) -> bool {
    *softness == USUAL_SOFTNESS
}

fn is_whole(ratio: &Ratio) -> bool {
    ratio.0 == 1.0
}

impl Default for Stroke {
    fn default() -> Self {
        Self {
            path: Vec::new(),
            radius: Metres(300.0),
            softness: USUAL_SOFTNESS,
            strength: Ratio(1.0),
            value: Ratio(1.0),
        }
    }
}

impl Stroke {
    /// The points of its line.
    pub fn points(&self) -> &[[f64; 2]] {
        self.path.as_chunks::<2>().0
    }

    /// Where it paints; `None` when it has no point.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.points().iter().copied()).map(|b| b.grown(self.radius.0))
    }

    /// Nanoseconds that painting it takes on a grid, by estimate. In every row that it may touch each of its segments is
    /// looked at; the distance is worked out in the box around each segment, the weight in the box around all.
    fn nanoseconds(&self, grid: &Grid) -> f64 {
        let points = self.points();
        let Some(first) = points.first() else { return 0.0 };
        let (window, cell, r) = (grid.bounds(), grid.cell(), self.radius.0);
        // `f64::min` and `max` look for numbers that are none, which takes twice as long.
        let min = |a: f64, b: f64| if a < b { a } else { b };
        let max = |a: f64, b: f64| if a > b { a } else { b };
        // Samples along an axis within the radius of two coordinates, as far as they are in the window.
        let inside = |k: usize, low: f64, high: f64| {
            let metres = min(high + r, window.max[k]) - max(low - r, window.min[k]);
            if metres < 0.0 { 0.0 } else { metres / cell + 1.0 }
        };
        let along = |k: usize, a: [f64; 2], b: [f64; 2]| inside(k, min(a[k], b[k]), max(a[k], b[k]));
        let (mut low, mut high, mut near) = (*first, *first, 0.0);
        for segment in points.windows(2) {
            let (a, b) = (segment[0], segment[1]);
            near += along(0, a, b) * along(1, a, b);
            low = [min(b[0], low[0]), min(b[1], low[1])];
            high = [max(b[0], high[0]), max(b[1], high[1])];
        }
        let [columns, rows] = [0, 1].map(|k| inside(k, low[k], high[k]));
        if points.len() < 2 {
            near = columns * rows;
        }
        grid.rows as f64 * 4.0 + rows * (40.0 + 2.0 * points.len() as f64) + 5.0 * near + 5.0 * columns * rows
    }

    /// Paints over a row of values at the places `xs` and `y`; `bounds` are the stroke's, `near` is scratch memory.
    pub fn paint(&self, bounds: &Bounds, xs: &[f64], y: f64, values: &mut [f64], near: &mut Vec<f64>) {
        if y < bounds.min[1] || y > bounds.max[1] {
            return;
        }
        let from = xs.partition_point(|x| *x < bounds.min[0]);
        let to = xs.partition_point(|x| *x <= bounds.max[0]);
        near.clear();
        near.resize(to.saturating_sub(from), f64::INFINITY);
        let Some(xs) = xs.get(from..to) else { return };
        self.distances(xs, y, near);
        let (r, strength, value) = (self.radius.0, self.strength.0, self.value.0);
        let core = r * (1.0 - self.softness.0);
        for (out, square) in values[from..to].iter_mut().zip(near.iter()) {
            let weight = strength * falloff(square.sqrt(), core, r);
            if weight > 0.0 {
                *out += (value - *out) * weight;
            }
        }
    }

    /// The squares of the distances to the line, where they are below that of the radius.
    fn distances(&self, xs: &[f64], y: f64, near: &mut [f64]) {
        let points = self.points();
        let r = self.radius.0;
        let last = points.len() - 1;
        for i in 0..points.len() {
            let (a, b) = (points[i], points[(i + 1).min(last)]);
            if i == last && i > 0 {
                break;
            }
            if y < a[1].min(b[1]) - r || y > a[1].max(b[1]) + r {
                continue;
            }
            let from = xs.partition_point(|x| *x < a[0].min(b[0]) - r);
            let to = xs.partition_point(|x| *x <= a[0].max(b[0]) + r);
            let along = [b[0] - a[0], b[1] - a[1]];
            let square = along[0] * along[0] + along[1] * along[1];
            let scale = if square > 0.0 { 1.0 / square } else { 0.0 };
            for (x, out) in xs[from..to].iter().zip(&mut near[from..to]) {
                let d = [x - a[0], y - a[1]];
                let t = ((d[0] * along[0] + d[1] * along[1]) * scale).clamp(0.0, 1.0);
                let off = [d[0] - along[0] * t, d[1] - along[1] * t];
                *out = out.min(off[0] * off[0] + off[1] * off[1]);
            }
        }
    }
}

fn falloff(distance: f64, core: f64, radius: f64) -> f64 {
    if distance >= radius {
        return 0.0;
    }
    if distance <= core {
        return 1.0;
    }
    let s = (distance - core) / (radius - core);
    1.0 - s * s * (3.0 - 2.0 * s)
}

/// Nanoseconds that painting strokes takes on a grid, by estimate.
pub fn nanoseconds(strokes: &[Stroke], grid: &Grid) -> f64 {
    strokes.iter().map(|s| s.nanoseconds(grid)).sum()
}

/// The fewest of some points that keep a line within a tolerance of all of them \[douglas1973\].
pub fn thinned(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; points.len()];
    (kept[0], kept[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((a, b)) = spans.pop() {
        let off = |i: usize| from_segment(points[i], points[a], points[b]);
        let far = (a + 1..b).map(|i| (off(i), i)).max_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((_, i)) = far.filter(|(d, _)| *d > tolerance) {
            kept[i] = true;
            spans.extend([(a, i), (i, b)]);
        }
    }
    points.iter().zip(kept).filter(|(_, k)| *k).map(|(p, _)| *p).collect()
}

fn from_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (along, d) = (sub(b, a), sub(p, a));
    let square = dot(along, along);
    let t = if square > 0.0 { (dot(d, along) / square).clamp(0.0, 1.0) } else { 0.0 };
    norm(sub(d, times(along, t)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(path: &[f64]) -> Stroke {
        Stroke { path: path.to_vec(), radius: Metres(100.0), ..Stroke::default() }
    }

    fn at(strokes: &[Stroke], x: f64, y: f64) -> f64 {
        let mut value = [0.0];
        for stroke in strokes {
            if let Some(bounds) = stroke.bounds() {
                stroke.paint(&bounds, &[x], y, &mut value, &mut Vec::new());
            }
        }
        value[0]
    }

    #[test]
    fn paints_round_a_line_and_nowhere_else() {
        let line = [stroke(&[0.0, 0.0, 400.0, 0.0])];
        assert_eq!(at(&line, 200.0, 20.0), 1.0, "the core");
        assert!((0.2..0.8).contains(&at(&line, 200.0, 65.0)), "the soft edge");
        assert_eq!(at(&line, 200.0, 100.0), 0.0);
        assert_eq!(at(&line, -100.0, 0.0), 0.0, "the round end");
        // The end is as round as a dab.
        assert_eq!(at(&line, -60.0, 30.0), at(&[stroke(&[0.0, 0.0])], -60.0, 30.0));
        assert_eq!(at(&[stroke(&[])], 0.0, 0.0), 0.0, "no point, no paint");
    }

    #[test]
    fn later_strokes_lie_on_earlier_ones() {
        let half = Stroke { strength: Ratio(0.5), ..stroke(&[0.0, 0.0]) };
        let eraser = Stroke { value: Ratio(0.0), ..half.clone() };
        assert_eq!(at(&[half.clone(), half.clone()], 0.0, 0.0), 0.75);
        assert_eq!(at(&[half.clone(), half.clone(), eraser], 0.0, 0.0), 0.375);
        // A stroke that turns back over itself is no stronger for it.
        let back = Stroke { path: vec![0.0, 0.0, 50.0, 0.0, 0.0, 0.0], ..half };
        assert_eq!(at(&[back], 10.0, 0.0), 0.5);
    }

    #[test]
    fn hard_and_soft_edges() {
        let hard = Stroke { softness: Ratio(0.0), ..stroke(&[0.0, 0.0]) };
        let hard = [hard];
        assert_eq!((at(&hard, 99.9, 0.0), at(&hard, 100.1, 0.0)), (1.0, 0.0));
        let soft = Stroke { softness: Ratio(1.0), ..stroke(&[0.0, 0.0]) };
        assert_eq!(at(&[soft], 50.0, 0.0), 0.5);
    }

    #[test]
    fn thinning_keeps_the_line() {
        let arc: Vec<[f64; 2]> = (0..=200)
            .map(|k| {
                let a = f64::from(k) / 200.0 * 3.0;
                [1000.0 * libm::cos(a), 1000.0 * libm::sin(a)]
            })
            .collect();
        let thin = thinned(&arc, 2.0);
        assert!((10..60).contains(&thin.len()), "{}", thin.len());
        let off =
            |p: &[f64; 2]| thin.windows(2).map(|w| from_segment(*p, w[0], w[1])).fold(f64::MAX, f64::min);
        assert!(arc.iter().map(off).fold(0.0, f64::max) <= 2.0);
        assert_eq!(thinned(&[[1.0, 1.0]], 1.0), [[1.0, 1.0]]);
        assert!(thinned(&[], 1.0).is_empty());
    }
}
