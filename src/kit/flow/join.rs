//! Lines that end near others are joined to a network.

use crate::kit::rivers::link_grid::LinkGrid;
use crate::value::Bounds;
use crate::work::{Cancelled, Work};

/// A line from its source to its mouth: x, y and height of its corners, in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline(pub Vec<[f64; 3]>);

/// A corner of the network, and the number of the one downstream.
pub type Corner = ([f64; 3], Option<u32>);

/// Where the mouth of a line joins another: the number of the line, and the piece and the share of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Joint {
    line: usize,
    piece: usize,
    share: f64,
}

/// The corners of lines, where a mouth that lies within `snap` metres of another line joins it at its nearest place, of two
/// as near on the first line. A line that would drain to itself over others keeps its mouth.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn join(lines: &[Polyline], snap: f64, work: &Work<'_>) -> Result<Vec<Corner>, Cancelled> {
    let joints = joints(lines, snap, work)?;
    // Corners of lines, and of each line the places where others join it, by their place along it.
    let mut at_line: Vec<Vec<(usize, f64, usize)>> = vec![Vec::new(); lines.len()];
    for (from, joint) in joints.iter().enumerate() {
        if let Some(joint) = joint {
            at_line[joint.line].push((joint.piece, joint.share, from));
        }
    }
    let mut corners: Vec<Corner> = Vec::new();
    let mut joined_at = vec![None; lines.len()];
    let mut mouths = vec![None; lines.len()];
    for (n, line) in lines.iter().enumerate() {
        at_line[n].sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut guests = at_line[n].iter().peekable();
        let first = corners.len();
        for (piece, &corner) in line.0.iter().enumerate() {
            corners.push((corner, None));
            while let Some(&(_, share, from)) = guests.next_if(|guest| guest.0 == piece) {
                if share > 0.0 {
                    let end = line.0[(piece + 1).min(line.0.len() - 1)];
                    corners.push((between(corner, end, share), None));
                }
                joined_at[from] = Some(corners.len() as u32 - 1);
            }
        }
        for i in first + 1..corners.len() {
            corners[i - 1].1 = Some(i as u32);
        }
        mouths[n] = (corners.len() > first).then(|| corners.len() - 1);
    }
    for (mouth, joined) in mouths.into_iter().zip(joined_at) {
        if let Some(mouth) = mouth {
            corners[mouth].1 = joined;
        }
    }
    Ok(corners)
}

fn joints(lines: &[Polyline], snap: f64, work: &Work<'_>) -> Result<Vec<Option<Joint>>, Cancelled> {
    let around = Bounds::around(lines.iter().flat_map(|line| &line.0).map(|&[x, y, _]| [x, y]));
    let Some(around) = around else { return Ok(vec![None; lines.len()]) };
    let pieces: usize = lines.iter().map(|line| line.0.len()).sum();
    let cell = libm::sqrt(around.width() * around.depth() / pieces as f64).max(snap);
    let mut grid = LinkGrid::new(around, cell, pieces);
    for (n, line) in lines.iter().enumerate() {
        for piece in 0..line.0.len() {
            let [a, b] = [line.0[piece], line.0[(piece + 1).min(line.0.len() - 1)]];
            grid.put(n as u32, [[a[0], a[1]], [b[0], b[1]]]);
        }
    }
    let mut near = Vec::new();
    let mut joints: Vec<Option<Joint>> = vec![None; lines.len()];
    for (n, line) in lines.iter().enumerate() {
        work.step(n as f32 / lines.len() as f32)?;
        let Some(&[x, y, _]) = line.0.last() else { continue };
        let mut best = snap;
        grid.collect(Bounds { min: [x - snap, y - snap], max: [x + snap, y + snap] }, &mut near);
        for &other in near.iter().filter(|&&other| other as usize != n) {
            let (other, candidate) = (other as usize, &lines[other as usize]);
            // The way down from there must not come back here.
            let way = std::iter::successors(Some(other), |&line| joints[line].map(|joint: Joint| joint.line));
            if way.take(lines.len()).any(|line| line == n) {
                continue;
            }
            for piece in 0..candidate.0.len() {
                let end = candidate.0[(piece + 1).min(candidate.0.len() - 1)];
                let (distance, share) = nearest([x, y], candidate.0[piece], end);
                if distance < best || distance == best && joints[n].is_none() {
                    best = distance;
                    joints[n] = Some(settle(other, piece, share, candidate.0.len()));
                }
            }
        }
    }
    Ok(joints)
}

/// The joint at a share of a piece; at its end the next corner.
fn settle(line: usize, piece: usize, share: f64, count: usize) -> Joint {
    if share >= 1.0 && piece + 1 < count {
        return Joint { line, piece: piece + 1, share: 0.0 };
    }
    Joint { line, piece, share: if share >= 1.0 { 0.0 } else { share } }
}

/// Distance from a place to a piece, and the share of the piece where it is nearest.
fn nearest(at: [f64; 2], from: [f64; 3], to: [f64; 3]) -> (f64, f64) {
    let [along, off] = [[to[0] - from[0], to[1] - from[1]], [at[0] - from[0], at[1] - from[1]]];
    let square = along[0] * along[0] + along[1] * along[1];
    let dot = along[0] * off[0] + along[1] * off[1];
    let share = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
    (libm::hypot(off[0] - share * along[0], off[1] - share * along[1]), share)
}

fn between(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share)
}
