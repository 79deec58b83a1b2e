//! Distances between links.

use crate::kit::predicates::{Point, segments_touch};

/// The share of a branch beside its foot that may be near to others.
const FOOT: f64 = 0.3;

/// The square of the distance from a place to a segment.
#[inline]
pub fn distance_squared(p: Point, [a, b]: [Point; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let from = [p[0] - a[0], p[1] - a[1]];
    let length = along[0] * along[0] + along[1] * along[1];
    let t =
        if length > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    let [x, y] = [from[0] - t * along[0], from[1] - t * along[1]];
    x * x + y * y
}

/// The square of the distance between two segments that do not touch.
pub fn gap_squared(a: [Point; 2], b: [Point; 2]) -> f64 {
    let [u, v] = [distance_squared(a[0], b), distance_squared(a[1], b)];
    let [s, t] = [distance_squared(b[0], a), distance_squared(b[1], a)];
    u.min(v).min(s.min(t))
}

/// How much room a branch has.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// The distance that it needs. A place with less is no place, however much less.
    pub least: f64,
    /// The distance beyond which more is of no use.
    pub most: f64,
}

impl Room {
    /// A distance that is needed, but for a thousandth that rounding may take, and of which more is of no use.
    pub fn just(distance: f64) -> Self {
        Self { least: 0.999 * distance, most: distance }
    }

    /// The distance of a branch to the nearest of some segments, without its foot, at most `most`. None where it touches one
    /// or has less than `least`.
    pub fn of(self, foot: Point, tip: Point, others: &[[Point; 2]]) -> Option<f64> {
        let body = [[0, 1].map(|i| foot[i] + FOOT * (tip[i] - foot[i])), tip];
        let mut nearest = self.most * self.most;
        let least = self.least * self.least;
        for other in others {
            let apart = rectangles_gap_squared([foot, tip], *other);
            if apart >= nearest {
                continue;
            }
            if apart == 0.0 && segments_touch([foot, tip], *other) {
                return None;
            }
            nearest = nearest.min(gap_squared(body, *other));
            if nearest < least {
                return None;
            }
        }
        (nearest >= least).then(|| libm::sqrt(nearest))
    }
}

/// Whether a segment touches none of the others and keeps a distance from all.
pub fn is_clear(segment: [Point; 2], others: &[[Point; 2]], distance: f64) -> bool {
    let keeps = |other: &[Point; 2]| {
        !segments_touch(segment, *other) && gap_squared(segment, *other) >= distance * distance
    };
    others.iter().all(keeps)
}

/// The square of the distance between the rectangles around two segments.
fn rectangles_gap_squared([a, b]: [Point; 2], [c, d]: [Point; 2]) -> f64 {
    let gap = |i: usize| {
        let before = a[i].min(b[i]) - c[i].max(d[i]);
        before.max(c[i].min(d[i]) - a[i].max(b[i])).max(0.0)
    };
    let [x, y] = [gap(0), gap(1)];
    x * x + y * y
}
