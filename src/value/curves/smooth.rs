//! Lines through points: smooth, or straight from each to the next.

use super::bezier::{Cubic, Point, add, norm, sub, times};
use super::{Fault, MAX_COORDINATE, MAX_PIECES};

/// The knots of a smooth curve through points: centripetal Catmull-Rom, which has no cusp and no loop between two
/// points \[yuksel2011\]. Points that repeat the one before are left out; when the last is the first, the curve is
/// closed and smooth there, too.
///
/// # Errors
/// When fewer than two points differ, there are too many, or one is out of bounds.
pub fn through(points: &[Point]) -> Result<Vec<Point>, Fault> {
    let points = distinct(points)?;
    let n = points.len();
    let closed = n > 3 && points[0] == points[n - 1];
    let mut knots = vec![points[0]];
    for i in 0..n - 1 {
        let (from, to) = (points[i], points[i + 1]);
        let before = if i > 0 { Some(points[i - 1]) } else { closed.then(|| points[n - 2]) };
        let after = if i + 2 < n { Some(points[i + 2]) } else { closed.then(|| points[1]) };
        let handle = |from, to, before| match before {
            Some(before) => handle(before, from, to),
            // An end that lets the first piece be a parabola would need its other handle; a third of the chord will do.
            None => add(from, times(sub(to, from), 1.0 / 3.0)),
        };
        knots.extend([handle(from, to, before), handle(to, from, after), to]);
    }
    Ok(knots)
}

/// The handle at `from` of the piece to `to`, of the parabola-blend through `before`, `from` and `to` whose parameter
/// runs with the square root of the distance.
fn handle(before: Point, from: Point, to: Point) -> Point {
    let (a, b) = (norm(sub(from, before)), norm(sub(to, from)));
    let (ra, rb) = (a.sqrt(), b.sqrt());
    // Barry and Goldman's pyramid in Bézier form: (a·to − b·before + (2a + 3√a√b + b)·from) / 3√a(√a + √b), about `from`.
    let toward = add(times(sub(to, from), a), times(sub(from, before), b));
    add(from, times(toward, 1.0 / (3.0 * ra * (ra + rb))))
}

/// The knots of straight pieces from point to point. Points that repeat the one before are left out.
///
/// # Errors
/// As [`through`].
pub fn straight(points: &[Point]) -> Result<Vec<Point>, Fault> {
    let points = distinct(points)?;
    let pieces = points.windows(2).flat_map(|w| {
        let [_, a, b, end] = Cubic::straight(w[0], w[1]).0;
        [a, b, end]
    });
    Ok(std::iter::once(points[0]).chain(pieces).collect())
}

fn distinct(points: &[Point]) -> Result<Vec<Point>, Fault> {
    if points.len() > MAX_PIECES + 1 {
        return Err(Fault(format!("may have {} points, got {}", MAX_PIECES + 1, points.len())));
    }
    let out = |p: &Point| !p.iter().all(|x| x.abs() <= MAX_COORDINATE);
    if let Some(i) = points.iter().position(out) {
        return Err(Fault(format!(
            "point {i} must lie within {MAX_COORDINATE} m of zero, got {:?}",
            points[i]
        )));
    }
    let mut kept = points.to_vec();
    kept.dedup();
    match kept.len() {
        0 | 1 => Err(Fault(format!("needs at least two different points, got {}", kept.len()))),
        _ => Ok(kept),
    }
}
