//! Geometric predicates whose sign is exact, whatever the rounding \[shewchuk1997\].
//!
//! The directions are those of mathematics, y upwards. In the world, whose y grows to the south, left and right change
//! places.

use robust::{Coord, incircle, orient2d};

/// A place in the plane.
pub type Point = [f64; 2];

fn coord([x, y]: Point) -> Coord<f64> {
    Coord { x, y }
}

/// On which side of the line from `a` to `b` a point lies: above 0 on the left, below 0 on the right, 0 on the line. The
/// sign is exact, the number nearly twice the area of the triangle.
#[inline]
pub fn side(a: Point, b: Point, point: Point) -> f64 {
    orient2d(coord(a), coord(b), coord(point))
}

/// Whether a point lies inside the circle through the corners of a triangle that turns left.
#[inline]
pub fn is_in_circle([a, b, c]: [Point; 3], point: Point) -> bool {
    incircle(coord(a), coord(b), coord(c), coord(point)) > 0.0
}

/// Whether two segments have a point in common, their ends included.
pub fn segments_touch([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let overlap = |i: usize| a[i].min(b[i]) <= c[i].max(d[i]) && c[i].min(d[i]) <= a[i].max(b[i]);
    // On one line, the rectangles around them decide.
    overlap(0)
        && overlap(1)
        && !is_apart(side(a, b, c), side(a, b, d))
        && !is_apart(side(c, d, a), side(c, d, b))
}

/// Whether two segments cross at a point inside both.
pub fn segments_cross([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let parts = |u: f64, v: f64| u > 0.0 && v < 0.0 || u < 0.0 && v > 0.0;
    parts(side(a, b, c), side(a, b, d)) && parts(side(c, d, a), side(c, d, b))
}

/// Whether two points lie on one side of a line, and neither on it.
fn is_apart(u: f64, v: f64) -> bool {
    u > 0.0 && v > 0.0 || u < 0.0 && v < 0.0
}
