//! Straight links become winding ways: they are halved again and again, and the points between them moved aside.
//!
//! A point between two vertices is put on a smooth way through them and their neighbours by the four-point rule
//! \[dyn1987\], and from there sideways by chance, in proportion to the length that is halved: midpoint displacement
//! \[fournier1982\] of a smooth curve. A tributary thus bends downstream where it joins. No two links come to touch that
//! did not before: a point without room moves less, and a link without any room stays straight.

use super::chance::Chance;
use super::gap::distance_squared;
use super::link_grid::LinkGrid;
use crate::kit::predicates::{Point, segments_touch};
use crate::value::{Bounds, RiverVertex};
use crate::work::{Cancelled, Work};

/// How far a point moves from the middle of its link, against what it would: less where there is no room.
const MOVES: [f64; 3] = [1.0, 0.5, 0.25];
/// The farthest a point moves from the middle of its link, in lengths of the link.
const FARTHEST: f64 = 0.25;
/// How near a moved point may come to other links, in lengths of its link.
const KEEP: f64 = 0.2;
/// Most times a link is halved.
const ROUNDS: u32 = 24;
/// Links between two looks at the switch that stops work.
const LOOK: usize = 1 << 10;

/// How rivers wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meander {
    /// Standard deviation of the chance by which a point moves aside, in lengths of the link that is halved.
    pub strength: f64,
    /// Links longer than this are halved, in metres.
    pub piece: f64,
    /// Chooses the chances.
    pub seed: u64,
}

/// The vertices of a network, and after them those that were put between, which have the area and the width of the vertex
/// upstream and heights in proportion to the halves. They no longer stand downstream first.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn meander(
    vertices: &[RiverVertex],
    how: Meander,
    work: &Work<'_>,
) -> Result<Vec<RiverVertex>, Cancelled> {
    let mut river = Winding::new(vertices, how);
    let rounds = river.rounds();
    for round in 0..rounds {
        let mut is_done = true;
        for link in 0..river.vertices.len() {
            if link.is_multiple_of(LOOK) {
                let share = link as f32 / river.vertices.len() as f32;
                work.step((round as f32 + share) / rounds as f32)?;
            }
            is_done &= !river.halve(link);
        }
        if is_done {
            break;
        }
    }
    Ok(river.vertices)
}

struct Winding {
    how: Meander,
    vertices: Vec<RiverVertex>,
    /// The tributary that goes on upstream of each vertex: the largest.
    main: Vec<Option<u32>>,
    grid: LinkGrid,
    chance: Chance,
    near: Vec<u32>,
}

impl Winding {
    fn new(vertices: &[RiverVertex], how: Meander) -> Self {
        let mut main: Vec<Option<u32>> = vec![None; vertices.len()];
        for (i, vertex) in vertices.iter().enumerate() {
            if let Some(down) = vertex.down {
                let known = &mut main[down as usize];
                let size = |i: u32| (vertices[i as usize].order, vertices[i as usize].area);
                if known.is_none_or(|other| size(other) < size(i as u32)) {
                    *known = Some(i as u32);
                }
            }
        }
        let links = || {
            vertices.iter().enumerate().filter_map(|(i, v)| Some((i, [v.at, vertices[v.down? as usize].at])))
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, [a, b]) in links() {
            sum += libm::hypot(a[0] - b[0], a[1] - b[1]);
            count += 1.0;
        }
        let nowhere = Bounds { min: [0.0; 2], max: [1.0; 2] };
        let around = Bounds::around(vertices.iter().map(|v| v.at)).unwrap_or(nowhere);
        let cell = if count > 0.0 { sum / count } else { 1.0 };
        let mut grid = LinkGrid::new(around, cell, vertices.len());
        links().for_each(|(i, segment)| grid.put(i as u32, segment));
        let chance = Chance::new(how.seed);
        Self { how, vertices: vertices.to_vec(), main, grid, chance, near: Vec::new() }
    }

    /// How often the longest link is halved.
    fn rounds(&self) -> u32 {
        let longest = (0..self.vertices.len()).filter_map(|i| self.segment(i)).map(|[a, b]| length(a, b));
        let halvings = libm::log2(longest.fold(0.0, f64::max) / self.how.piece.max(1e-3));
        // A moved point makes halves of somewhat more than half.
        (libm::ceil(1.2 * halvings).max(0.0) as u32 + 1).min(ROUNDS)
    }

    /// The link of a vertex, from it down.
    fn segment(&self, link: usize) -> Option<[Point; 2]> {
        let vertex = &self.vertices[link];
        Some([vertex.at, self.vertices[vertex.down? as usize].at])
    }

    /// Halves a link that is too long; whether it did.
    fn halve(&mut self, link: usize) -> bool {
        let Some([upper, lower]) = self.segment(link) else { return false };
        let long = length(upper, lower);
        if long <= self.how.piece {
            return false;
        }
        let middle = [0, 1].map(|k| (upper[k] + lower[k]) / 2.0);
        let aside = self.moved(link, [upper, lower]);
        let Some(at) = MOVES
            .map(|share| [0, 1].map(|k| middle[k] + share * aside[k]))
            .into_iter()
            .find(|&at| self.has_room(link, at, KEEP * long))
        else {
            return false;
        };
        self.put_between(link, at);
        true
    }

    /// How far the point between the ends of a link moves from its middle.
    fn moved(&mut self, link: usize, [upper, lower]: [Point; 2]) -> Point {
        let down = self.vertices[link].down.map_or(link, |down| down as usize);
        // Beyond the end of a river the way goes on straight.
        let mirrored = |at: Point, from: Point| [0, 1].map(|k| 2.0 * at[k] - from[k]);
        let above = self.main[link].map_or(mirrored(upper, lower), |i| self.vertices[i as usize].at);
        let below = self.vertices[down].down.map_or(mirrored(lower, upper), |i| self.vertices[i as usize].at);
        let chance = self.how.strength * self.chance.bell().clamp(-2.0, 2.0);
        let side = [lower[1] - upper[1], upper[0] - lower[0]];
        let smooth = |k: usize| (upper[k] + lower[k] - above[k] - below[k]) / 16.0;
        let aside = [0, 1].map(|k| smooth(k) + chance * side[k]);
        let (far, most) = (libm::hypot(aside[0], aside[1]), FARTHEST * length(upper, lower));
        if far > most { aside.map(|x| x * most / far) } else { aside }
    }

    /// Whether a point may stand between the ends of a link: the way over it touches no other link but where they join,
    /// and it keeps a distance from all.
    fn has_room(&mut self, link: usize, at: Point, keep: f64) -> bool {
        let Some([upper, lower]) = self.segment(link) else { return false };
        let low = |k: usize| at[k].min(upper[k]).min(lower[k]) - keep;
        let high = |k: usize| at[k].max(upper[k]).max(lower[k]) + keep;
        let around = Bounds { min: [low(0), low(1)], max: [high(0), high(1)] };
        let mut near = std::mem::take(&mut self.near);
        self.grid.collect(around, &mut near);
        let others = near.iter().filter(|&&other| other as usize != link);
        let mut others = others.filter_map(|&other| self.segment(other as usize));
        let is_clear = others.all(|other| keeps_clear([upper, at, lower], other, keep));
        self.near = near;
        is_clear
    }

    fn put_between(&mut self, link: usize, at: Point) {
        let new = self.vertices.len() as u32;
        let upper = self.vertices[link];
        let Some(down) = upper.down else { return };
        let lower = self.vertices[down as usize];
        let share =
            length(upper.at, at) / (length(upper.at, at) + length(at, lower.at)).max(f64::MIN_POSITIVE);
        let height = upper.height + (lower.height - upper.height) * share;
        self.vertices.push(RiverVertex { at, height, down: Some(down), ..upper });
        self.vertices[link].down = Some(new);
        self.main.push(Some(link as u32));
        if self.main[down as usize] == Some(link as u32) {
            self.main[down as usize] = Some(new);
        }
        self.grid.put(link as u32, [upper.at, at]);
        self.grid.put(new, [at, lower.at]);
    }
}

/// Whether the two pieces of a way over a point keep clear of a link. One that has an end of the way as its own may touch
/// there alone.
fn keeps_clear([upper, at, lower]: [Point; 3], other: [Point; 2], keep: f64) -> bool {
    if distance_squared(at, other) < keep * keep {
        return false;
    }
    [[upper, at], [lower, at]].into_iter().all(|[end, at]| {
        let shared = other.iter().position(|p| *p == end);
        match shared {
            None => !segments_touch([end, at], other),
            // Two links that join touch elsewhere only where one lies on the other.
            Some(k) => !segments_touch([other[1 - k]; 2], [end, at]),
        }
    })
}

fn length(a: Point, b: Point) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
