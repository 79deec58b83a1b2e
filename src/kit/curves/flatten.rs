//! From a curve to a polyline that stays within a tolerance of it.

use crate::value::Curve;
use crate::value::curves::bezier::{Cubic, Point, dot, norm, sub};

/// A corner of the polyline; it lies on the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where, in metres.
    pub at: Point,
    /// Length of the curve up to here, in metres.
    pub arc: f64,
    /// The same as a share of the whole; at a constraint point exactly its own.
    pub u: f64,
}

/// How often a piece is halved at most.
const DEPTH: u32 = 16;
/// Square of the cosine of 3°: handles of a leaf turn no further from its chord.
const STRAIGHT: f64 = 0.997_260_947_684_136_7;

/// The polyline of a curve within `tolerance` metres, with corners at all constraint points; no leaf turns by more
/// than 6° unless it is shorter than the tolerance. It depends on nothing but the curve and the tolerance. `None` when it has more
/// than `most` corners.
pub fn flatten(curve: &Curve, tolerance: f64, most: usize) -> Option<Vec<Vertex>> {
    let length = curve.length();
    let mut line = vec![Vertex { at: curve.knots()[0], arc: 0.0, u: 0.0 }];
    each_piece(curve, tolerance, |i, leaves| {
        let fits = line.len() + leaves.len() <= most;
        if fits {
            measure(&curve.piece(i), curve.piece_span(i), length, leaves, &mut line);
        }
        fits
    })?;
    if let Some(last) = line.last_mut() {
        last.u = 1.0;
    }
    Some(line)
}

/// How many corners that polyline has, without making it.
pub fn corners(curve: &Curve, tolerance: f64, most: usize) -> Option<usize> {
    let mut sum = 1;
    each_piece(curve, tolerance, |_, leaves| {
        sum += leaves.len();
        sum <= most
    })?;
    Some(sum)
}

/// Where a leaf ends: the parameter, and the `u` of the constraint point there.
type Leaf = (f64, Option<f64>);

/// Hands over the number and the leaves of each piece, as long as they are wanted.
fn each_piece(curve: &Curve, tolerance: f64, mut take: impl FnMut(usize, &[Leaf]) -> bool) -> Option<()> {
    let mut leaves = Vec::new();
    let mut cuts = curve.cuts().iter().peekable();
    for i in 0..curve.pieces() {
        let piece = curve.piece(i);
        leaves.clear();
        let mut t = 0.0;
        while let Some(cut) = cuts.next_if(|c| c.piece == i) {
            descend(&piece.part(t, cut.t), [t, cut.t], tolerance, DEPTH, &mut leaves);
            if let Some(last) = leaves.last_mut() {
                last.1 = Some(cut.u);
            }
            t = cut.t;
        }
        descend(&piece.part(t, 1.0), [t, 1.0], tolerance, DEPTH, &mut leaves);
        if !take(i, &leaves) {
            return None;
        }
    }
    Some(())
}

/// Halves a part until it is flat; pushes the parameters where leaves end.
fn descend(part: &Cubic, [t0, t1]: [f64; 2], tolerance: f64, depth: u32, leaves: &mut Vec<Leaf>) {
    if depth == 0 || is_flat(part, tolerance) {
        leaves.push((t1, None));
        return;
    }
    let [a, b] = part.halves();
    let middle = 0.5 * (t0 + t1);
    descend(&a, [t0, middle], tolerance, depth - 1, leaves);
    descend(&b, [middle, t1], tolerance, depth - 1, leaves);
}

/// Whether the chord stands for the curve: near, in the same order, and without a turn that would show.
fn is_flat(part: &Cubic, tolerance: f64) -> bool {
    let [a, b, c, d] = part.0;
    let chord = sub(d, a);
    let length = norm(chord);
    if part.polygon() <= 0.25 * tolerance {
        return true;
    }
    let (from, to) = (sub(b, a), sub(d, c));
    // The distance from the chord is at most 3/4 of the farther handle's.
    let aside = |v: Point| (v[0] * chord[1] - v[1] * chord[0]).abs();
    let near = 0.75 * aside(from).max(aside(to)) <= tolerance * length;
    let ahead = |v: Point| {
        let along = dot(v, chord);
        along >= 0.0 && along * along >= STRAIGHT * dot(v, v) * dot(chord, chord)
    };
    near && ahead(from) && ahead(to) && dot(sub(c, b), chord) >= 0.0
}

/// Appends the ends of leaves with their lengths, which add up to the length of the piece.
fn measure(piece: &Cubic, [start, end]: [f64; 2], total: f64, leaves: &[Leaf], line: &mut Vec<Vertex>) {
    let first = line.len();
    let (mut t, mut sum) = (0.0, 0.0);
    for &(next, u) in leaves {
        sum += piece.gauss(t, next);
        t = next;
        line.push(Vertex { at: piece.at(t), arc: sum, u: u.unwrap_or(-1.0) });
    }
    let scale = if sum > 0.0 { (end - start) / sum } else { 0.0 };
    for vertex in &mut line[first..] {
        vertex.arc = start + vertex.arc * scale;
        if vertex.u < 0.0 {
            vertex.u = vertex.arc / total;
        }
    }
    // The next piece starts on the very point, so that closed curves close.
    if let Some(last) = line.last_mut() {
        last.at = piece.0[3];
        last.arc = end;
    }
}
