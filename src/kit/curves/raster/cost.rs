//! What rasterising curves takes, told from the curves themselves before any of it is done.
//!
//! A part of a curve visits the samples of the ground beside it, once for the strip that it marks and once more for the
//! strip that is smoothed around it, so the work follows the area of these strips inside the grid; where strips lie over
//! each other it is done for each, and the ground between them is found. Beside that every corner of the polyline takes
//! its time, once for each turn in which rows are filled.

use super::stock::MAX_PARTS;
use super::{TOLERANCE, tile::MAX_BINNED};
use crate::value::curves::bezier::{Cubic, Point, left_of, norm, sub, times};
use crate::value::{Bounds, Curve, Curves, Grid};

/// Seconds for a sample of the grid, whatever the curves: its planes.
const SAMPLE: f64 = 8e-9;
/// Seconds for a sample beside a curve.
const VISIT: f64 = 14e-9;
/// Seconds more for each curve whose slope holds a sample, where there are several.
const MEET: f64 = 100e-9;
/// Seconds for a corner of a polyline, each time it becomes a part.
const CORNER: f64 = 2.5e-6;
/// Pieces that are looked at, at most; of more every so many is.
const LOOKED_AT: usize = 1 << 16;
/// Samples along the side of a tile.
const SIDE: f64 = 32.0;

/// Strips and corners of some curves on a grid.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    /// Area of the strips inside the grid, in m².
    area: f64,
    /// Corners of the polylines.
    corners: f64,
}

/// Seconds on one core that rasterising takes.
pub fn seconds(curves: &Curves, grid: &Grid) -> f64 {
    let cell = grid.cell();
    let pieces: usize = curves.iter().map(Curve::pieces).sum();
    let stride = pieces / LOOKED_AT + 1;
    let mut work = Work::default();
    let mut place = 0;
    let window = grid.bounds().grown(cell);
    for curve in curves.iter() {
        let first = (stride - place % stride) % stride;
        for i in (first..curve.pieces()).step_by(stride) {
            work.add(curve, i, cell, &window);
        }
        place += curve.pieces();
    }
    let (area, corners) = (work.area * stride as f64, work.corners * stride as f64);
    let visits = area / (cell * cell);
    let binned = visits / (SIDE * SIDE) + corners;
    let turns = 1.0 + 2.0 * (binned / MAX_BINNED as f64).max(corners / MAX_PARTS as f64).floor();
    // Strips that are more than the grid lie over each other.
    let samples = grid.len() as f64;
    let meet = (visits - samples).max(0.0) * MEET;
    samples * SAMPLE + visits * VISIT + meet + turns * corners * CORNER
}

impl Work {
    /// Takes up a piece of a curve.
    fn add(&mut self, curve: &Curve, i: usize, cell: f64, window: &Bounds) {
        let piece = curve.piece(i);
        let bent = is_bent(&piece);
        // Chords are as good as the curve itself here; a bend needs some.
        let chords = if bent { 4 } else { 1 };
        let [from, to] = curve.piece_span(i);
        for k in 0..chords {
            let (t0, t1) = (f64::from(k) / f64::from(chords), f64::from(k + 1) / f64::from(chords));
            let u = (from + (to - from) * 0.5 * (t0 + t1)) / curve.length();
            for [left, right] in widths(curve, u, cell).into_iter().flatten() {
                self.area += strip(piece.at(t0), piece.at(t1), left, right, window);
            }
        }
        // A leaf of length l strays from its chord by about l² / 8 r; its number grows with the root of the size.
        let leaves = if bent { (piece.polygon() / (8.0 * TOLERANCE * cell)).sqrt().ceil() } else { 1.0 };
        self.corners += leaves.max(1.0);
    }
}

fn is_bent(piece: &Cubic) -> bool {
    let [a, b, c, d] = piece.0;
    let chord = sub(d, a);
    let aside = |p: Point| {
        let v = sub(p, a);
        (v[0] * chord[1] - v[1] * chord[0]).abs()
    };
    let length = norm(chord);
    aside(b).max(aside(c)) > 1e-6 * length * length
}

/// How wide the strips of a curve are on the left and on the right: the one that it marks, and the smoothed one.
fn widths(curve: &Curve, u: f64, cell: f64) -> [Option<[f64; 2]>; 2] {
    let t = curve.tracks();
    let radius = t.elevation.as_ref().map_or(0.0, |t| t.at(u)[1]);
    let extent = |side: usize| t.slope.as_ref().map_or(0.0, |t| t.at(u)[side]);
    let marked = [0, 1].map(|side| radius + extent(side).max(cell));
    let marks = t.elevation.is_some() || t.slope.is_some() || t.noise.is_some();
    let smoothed = t.envelope.as_ref().map(|t| [0, 1].map(|side| radius + extent(side) + t.at(u)[side]));
    [marks.then_some(marked), smoothed]
}

/// The area of the strip beside a chord inside a window, in m².
fn strip(from: Point, to: Point, left: f64, right: f64, window: &Bounds) -> f64 {
    let along = sub(to, from);
    let length = norm(along);
    if length == 0.0 {
        return 0.0;
    }
    let n = left_of(times(along, 1.0 / length));
    let beside = |p: Point, way: f64| [p[0] + n[0] * way, p[1] + n[1] * way];
    let corners = vec![beside(from, left), beside(to, left), beside(to, -right), beside(from, -right)];
    let inside = (0..2).fold(corners, |corners, axis| {
        let above = cut(&corners, |p| p[axis] - window.min[axis]);
        cut(&above, |p| window.max[axis] - p[axis])
    });
    area(&inside)
}

/// The part of a polygon where a linear function is not below 0.
fn cut(corners: &[Point], f: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, a) in corners.iter().enumerate() {
        let b = &corners[(i + 1) % corners.len()];
        let (fa, fb) = (f(a), f(b));
        if fa >= 0.0 {
            kept.push(*a);
        }
        if (fa >= 0.0) != (fb >= 0.0) {
            let t = fa / (fa - fb);
            kept.push([a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]);
        }
    }
    kept
}

fn area(corners: &[Point]) -> f64 {
    let Some(&last) = corners.last() else { return 0.0 };
    let mut sum = 0.0;
    let mut before = last;
    for &corner in corners {
        sum += before[0] * corner[1] - corner[0] * before[1];
        before = corner;
    }
    0.5 * sum.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_counts_as_far_as_the_window_sees_it() {
        let window = Bounds { min: [0.0, 0.0], max: [100.0, 100.0] };
        for (from, to, left, right, want) in [
            ([10.0, 50.0], [90.0, 50.0], 5.0, 15.0, 1600.0),
            ([50.0, 90.0], [50.0, 10.0], 5.0, 15.0, 1600.0),
            ([-100.0, 50.0], [100.0, 50.0], 10.0, 10.0, 2000.0),
            ([10.0, 50.0], [20.0, 50.0], 1e7, 1e7, 1000.0),
            ([200.0, 0.0], [300.0, 0.0], 10.0, 10.0, 0.0),
            ([0.0, 0.0], [100.0, 100.0], 1e5, 1e5, 10_000.0),
            ([5.0, 5.0], [5.0, 5.0], 1e5, 1e5, 0.0),
        ] {
            let got = strip(from, to, left, right, &window);
            assert!((got - want).abs() <= 1e-6 * want.max(1.0), "{from:?} {to:?}: {got}, not {want}");
        }
    }
}
