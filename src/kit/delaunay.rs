//! Delaunay triangulation of many sites.
//!
//! Sites are inserted one after the other: the triangle that holds a site is found by a walk, parted in three, and edges
//! are flipped until no circle through the corners of a triangle holds another site \[lawson1977\]. The order is that of
//! Amenta, Choi and Rote \[amenta2003\]: rounds of doubling size, each along a Hilbert curve, so that walks are short and
//! flips few wherever the sites lie. All decisions rest on exact predicates, so sites on a line, on a circle or on a
//! lattice are as good as any.
//!
//! # Differs from the textbook
//! Three *far corners* stand around all sites and are triangulated with them. So each site is inside, there is no hull,
//! and sites on one line, or a single one, have triangles too. Inside the bounds that the triangulation was made for, a
//! far corner is farther from each place than any site is. So Voronoi cells are right there to the last bit of rounding;
//! only edges of the hull whose circles lie outside the bounds may be missing.

use rayon::prelude::*;

use super::hash::mix;
use super::math::nearest_whole;
use super::predicates::{Point, is_in_circle, side};
use crate::value::Bounds;
use crate::work::{Cancelled, Work};

/// No half-edge.
pub const NONE: u32 = u32::MAX;
/// Steps per metre of the lattice that sites are rounded to. Differences of coordinates are exact on it, and triangles
/// are never so thin that a centre is not finite.
const STEPS: f64 = 1_048_576.0;
/// How far the far corners are, in half-widths of the bounds.
const FAR: f64 = 32.0;
/// Rounds of insertion at most.
const ROUNDS: u32 = 24;
/// Sites inserted between two looks at the switch that stops work.
const LOOK: usize = 1 << 14;

/// A Delaunay triangulation. Half-edge `3t + k` runs from the `k`-th corner of triangle `t` to the next; corners turn left
/// in the sense of [`side`].
#[derive(Clone, Debug)]
pub struct Delaunay {
    /// The sites, rounded to a micrometre, then the far corners.
    points: Vec<Point>,
    corners: Vec<u32>,
    /// The half-edge on the other side of each; [`NONE`] between far corners.
    twins: Vec<u32>,
    /// For each site the first site of the same place.
    same: Vec<u32>,
}

/// The next half-edge around a triangle.
#[inline]
pub fn next(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// The previous half-edge around a triangle.
#[inline]
pub fn previous(edge: usize) -> usize {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

impl Delaunay {
    /// The triangulation of sites, whose Voronoi cells are right inside some bounds. Sites at one place, rounded to a
    /// micrometre, are one. Coordinates must be at most 1e9 in size; memory is about 90 bytes a site.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn new(sites: &[Point], bounds: Bounds, work: &Work<'_>) -> Result<Self, Cancelled> {
        let all = Bounds::around(sites.iter().copied().chain([bounds.min, bounds.max])).unwrap_or(bounds);
        let mut net = Self {
            points: far_corners(all).to_vec(),
            corners: vec![0, 1, 2],
            twins: vec![NONE; 3],
            same: Vec::new(),
        };
        net.extend(sites, work)?;
        Ok(net)
    }

    /// Adds sites, whose numbers go on from those that are there. They must lie among these or in the bounds that the
    /// triangulation was made for.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop; what is left is a triangulation of some of the sites.
    pub fn extend(&mut self, sites: &[Point], work: &Work<'_>) -> Result<(), Cancelled> {
        let (before, added) = (self.sites(), sites.len() as u32);
        let far = self.points.split_off(before);
        self.points.extend(sites.iter().map(|site| site.map(|x| nearest_whole(x * STEPS) / STEPS)));
        let order = insertion_order(&self.points[before..]);
        self.points.extend(far);
        self.same.extend(before as u32..before as u32 + added);
        // Far corners have the last numbers.
        for corner in self.corners.iter_mut().filter(|corner| **corner as usize >= before) {
            *corner += added;
        }
        self.corners.reserve(6 * sites.len());
        self.twins.reserve(6 * sites.len());
        let (mut near, mut open) = (0, Vec::new());
        for (done, &site) in order.iter().enumerate() {
            if done % LOOK == 0 {
                work.step(done as f32 / order.len() as f32)?;
            }
            near = self.insert(before as u32 + site, near, &mut open);
        }
        // Whichever came first, the site of the smallest number stands for its place.
        self.name_smallest();
        Ok(())
    }

    /// Number of sites.
    pub fn sites(&self) -> usize {
        self.points.len() - 3
    }

    /// Where a site or far corner is: the given place, rounded to a micrometre.
    pub fn point(&self, site: u32) -> Point {
        self.points[site as usize]
    }

    /// Whether a number is that of a site, not of a far corner.
    pub fn is_site(&self, number: u32) -> bool {
        (number as usize) < self.sites()
    }

    /// The first site at the place of a site. Only that one is a corner of triangles.
    pub fn same(&self, site: usize) -> usize {
        self.same[site] as usize
    }

    /// Number of triangles, those at far corners included.
    pub fn triangles(&self) -> usize {
        self.corners.len() / 3
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [u32; 3] {
        [0, 1, 2].map(|k| self.corners[3 * triangle + k])
    }

    /// Number of half-edges.
    pub fn half_edges(&self) -> usize {
        self.corners.len()
    }

    /// Where a half-edge starts.
    #[inline]
    pub fn origin(&self, edge: usize) -> u32 {
        self.corners[edge]
    }

    /// Where a half-edge ends.
    #[inline]
    pub fn end(&self, edge: usize) -> u32 {
        self.corners[next(edge)]
    }

    /// The half-edge on the other side.
    #[inline]
    pub fn twin(&self, edge: usize) -> Option<usize> {
        let twin = self.twins[edge];
        (twin != NONE).then_some(twin as usize)
    }

    /// Each edge once, as a half-edge, but those between far corners.
    pub fn edges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.half_edges()).filter(|&edge| self.twins[edge] != NONE && edge < self.twins[edge] as usize)
    }

    /// A half-edge that starts at each site; [`NONE`] for a site that stands where an earlier one does.
    pub fn starts(&self) -> Vec<u32> {
        let mut starts = vec![NONE; self.sites()];
        // Falling, so that the first half-edge of each stays.
        for edge in (0..self.half_edges()).rev() {
            if let Some(start) = starts.get_mut(self.corners[edge] as usize) {
                *start = edge as u32;
            }
        }
        starts
    }

    /// The half-edges that start at a site, turning right, from one of them on. Each site has three or more.
    pub fn around(&self, start: usize) -> impl Iterator<Item = usize> + '_ {
        let turn = move |&edge: &usize| self.twin(edge).map(next).filter(|&edge| edge != start);
        std::iter::successors(Some(start), turn)
    }

    /// Inserts a site; the search starts at a triangle. Returns a triangle at the site.
    fn insert(&mut self, site: u32, near: usize, open: &mut Vec<usize>) -> usize {
        let point = self.points[site as usize];
        let t = self.find(point, near);
        if let Some(&same) =
            self.corners[3 * t..3 * t + 3].iter().find(|&&c| self.points[c as usize] == point)
        {
            self.same[site as usize] = same;
            return t;
        }
        self.part(t, site, open);
        while let Some(edge) = open.pop() {
            self.flip_unless_delaunay(edge, open);
        }
        t
    }

    /// The triangle that holds a point, on its border or inside.
    fn find(&self, point: Point, near: usize) -> usize {
        let mut t = near;
        let mut entered = NONE;
        'walk: loop {
            for edge in 3 * t..3 * t + 3 {
                // The point was found to be on this side of the edge that was crossed.
                if edge as u32 == entered {
                    continue;
                }
                let ends = [self.origin(edge), self.end(edge)].map(|c| self.points[c as usize]);
                // All points are inside the far corners, so that the walk never leaves.
                if side(ends[0], ends[1], point) < 0.0 && self.twins[edge] != NONE {
                    entered = self.twins[edge];
                    t = entered as usize / 3;
                    continue 'walk;
                }
            }
            return t;
        }
    }

    /// Parts a triangle in three at a site. A site on an edge leaves a triangle without area there, which the flip of that
    /// edge takes away, since the far side of a line is the inside of its circle.
    fn part(&mut self, t: usize, site: u32, open: &mut Vec<usize>) {
        let [a, b, c] = self.corners(t);
        let [first, second] = [self.corners.len(), self.corners.len() + 3];
        let [beyond_b, beyond_c] = [self.twins[3 * t + 1], self.twins[3 * t + 2]];
        self.corners[3 * t + 2] = site;
        self.corners.extend([b, c, site, c, a, site]);
        self.twins.extend([NONE; 6]);
        self.join(first, beyond_b);
        self.join(second, beyond_c);
        self.join(3 * t + 1, (first + 2) as u32);
        self.join(first + 1, (second + 2) as u32);
        self.join(second + 1, (3 * t + 2) as u32);
        open.extend([3 * t, first, second]);
    }

    /// Flips the edge opposite a new site if the circle through its triangle holds the corner beyond it.
    fn flip_unless_delaunay(&mut self, edge: usize, open: &mut Vec<usize>) {
        let Some(twin) = self.twin(edge) else { return };
        let (site, beyond) = (self.corners[previous(edge)], self.corners[previous(twin)]);
        let triangle = [self.origin(edge), self.end(edge), site].map(|c| self.points[c as usize]);
        if !is_in_circle(triangle, self.points[beyond as usize]) {
            return;
        }
        let [after_edge, after_twin, before_twin] = [next(edge), next(twin), previous(twin)];
        let outer = [self.twins[after_twin], self.twins[before_twin], self.twins[after_edge]];
        self.corners[after_twin] = self.corners[after_edge];
        self.corners[after_edge] = beyond;
        self.corners[twin] = beyond;
        self.corners[before_twin] = site;
        self.join(edge, outer[0]);
        self.join(twin, outer[1]);
        self.join(after_twin, outer[2]);
        self.join(after_edge, before_twin as u32);
        open.extend([edge, twin]);
    }

    fn join(&mut self, edge: usize, twin: u32) {
        self.twins[edge] = twin;
        if twin != NONE {
            self.twins[twin as usize] = edge as u32;
        }
    }

    /// Lets the site of the smallest number stand for its place, whichever was inserted first.
    fn name_smallest(&mut self) {
        let mut smallest: Vec<u32> = (0..self.points.len() as u32).collect();
        // Falling, so that the smallest is the last to be written.
        for site in (0..self.sites()).rev() {
            smallest[self.same[site] as usize] = site as u32;
        }
        for corner in self.corners.iter_mut().chain(&mut self.same) {
            *corner = smallest[*corner as usize];
        }
    }
}

/// Three places far around a rectangle.
fn far_corners(Bounds { min, max }: Bounds) -> [Point; 3] {
    let half = ((max[0] - min[0]).max(max[1] - min[1]) / 2.0).max(1.0);
    let at =
        |x: f64, y: f64| [(min[0] + max[0]) / 2.0 + x * FAR * half, (min[1] + max[1]) / 2.0 + y * FAR * half];
    [at(-1.0, -0.5), at(1.0, -0.5), at(0.0, 1.0)]
}

/// Rounds of doubling size, drawn by chance, each along a Hilbert curve.
fn insertion_order(sites: &[Point]) -> Vec<u32> {
    let Some(Bounds { min, max }) = Bounds::around(sites.iter().copied()) else { return Vec::new() };
    let scale = f64::from(HILBERT_CELLS - 1) / (max[0] - min[0]).max(max[1] - min[1]).max(1e-9);
    let key = |(i, site): (usize, &Point)| {
        let round = ROUNDS - mix(i as u64).trailing_zeros().min(ROUNDS);
        let [x, y] = [0, 1].map(|k| ((site[k] - min[k]) * scale) as u32);
        (u64::from(round) << (2 * HILBERT_BITS) | hilbert(x, y), i as u32)
    };
    let mut keys: Vec<(u64, u32)> = sites.par_iter().enumerate().map(key).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

/// Bits of a coordinate on the Hilbert curve.
const HILBERT_BITS: u32 = 20;
/// Cells of the Hilbert curve along a side.
const HILBERT_CELLS: u32 = 1 << HILBERT_BITS;

/// The place of a cell on the Hilbert curve.
fn hilbert(mut x: u32, mut y: u32) -> u64 {
    let mut place = 0;
    for bit in (0..HILBERT_BITS).rev() {
        let [right, up] = [x >> bit & 1, y >> bit & 1];
        place = place << 2 | u64::from((3 * right) ^ up);
        // The curve in a quarter is turned, so that it starts where the last one ended.
        if up == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    place
}
