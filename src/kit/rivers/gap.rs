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

/// The distance of a branch to the nearest of some segments, without its foot; 0 where it touches one, at most `most`.
pub fn clearance(foot: Point, tip: Point, others: &[[Point; 2]], most: f64) -> f64 {
    let body = [[0, 1].map(|i| foot[i] + FOOT * (tip[i] - foot[i])), tip];
    let mut least = most * most;
    for other in others {
        if segments_touch([foot, tip], *other) {
            return 0.0;
        }
        if rectangles_gap_squared(body, *other) < least {
            least = least.min(gap_squared(body, *other));
        }
    }
    libm::sqrt(least)
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
