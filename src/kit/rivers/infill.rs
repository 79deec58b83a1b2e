//! Tributaries in empty land, until no place is far from a river.
//!
//! New vertices stand on a jittered lattice wherever no river is near, and in the gaps that remain. The Delaunay
//! triangulation joins them to each other and to the rivers, and Prim's search takes from it a tree for each outlet: it
//! adds the cheapest edge first, cheap being short, straight on, and not too far from the outlet, with some chance. What is
//! nearer to the border drains over it, to outlets on a rectangle some spacings outside, so that no frame shows.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::gap::{Room, distance_squared};
use super::link_grid::LinkGrid;
use crate::kit::delaunay::{Delaunay, NONE};
use crate::kit::hash::{mix, unit};
use crate::kit::predicates::Point;
use crate::kit::voronoi;
use crate::value::curves::MAX_HEIGHT;
use crate::value::{Bounds, RiverVertex};
use crate::work::{Cancelled, Work};

/// How far the land that is filled reaches beyond the terrain, in spacings.
const MARGIN: f64 = 4.0;
/// How far a vertex leaves its place on the lattice, in spacings.
const JITTER: f64 = 0.38;
/// How near to a river no vertex is added, in spacings.
const NEAR: f64 = 0.75;
/// Longest new link, in spacings.
const LONGEST: f64 = 3.0;
/// How much of the way to the outlet counts towards the cost of an edge: 0 gives the shortest tree, 1 the shortest ways.
const WAY: f64 = 0.6;
/// Rounds in which gaps are filled.
const ROUNDS: u32 = 4;
/// How near to another river a new link may pass without being costly, in spacings.
const CLEAR: f64 = 0.25;
/// Triangles seen, or edges taken off the heap, between two looks at the switch that stops work.
const LOOK: usize = 1 << 14;

/// How empty land is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Infill {
    /// The terrain.
    pub bounds: Bounds,
    /// How far from a river no place is, in metres.
    pub spacing: f64,
    /// By how much outlets beyond the border are higher than the given ones, as a tangent over their distance.
    pub rim: f64,
    /// Draws what is left to chance.
    pub seed: u64,
}

/// A network that leaves no land empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filled {
    /// Its vertices, downstream first: the given ones with long links divided, then those added. Areas, widths and orders
    /// of the latter are open.
    pub vertices: Vec<RiverVertex>,
    /// Number of the first vertex that was added.
    pub first_added: usize,
    /// Vertices that no river could be led to.
    pub unreached: usize,
}

impl Infill {
    /// The rectangle that is filled: the terrain and a margin around it.
    pub fn filled_bounds(&self) -> Bounds {
        self.bounds.grown(MARGIN * self.spacing)
    }

    /// About how many vertices a network has at most when it is filled.
    pub fn vertices(&self, rivers: &[RiverVertex]) -> f64 {
        let pieces = |vertex: &RiverVertex| {
            vertex.down.map_or(1.0, |down| pieces(vertex.at, rivers[down as usize].at, self.spacing))
        };
        let all = self.filled_bounds();
        let [cols, rows] = [all.width(), all.depth()].map(|extent| libm::ceil(extent / self.spacing));
        // Sites on the lattice and on the rectangle, and some for gaps.
        1.1 * cols * rows + 2.0 * (cols + rows) + rivers.iter().map(pieces).sum::<f64>()
    }

    /// Fills the land between rivers. None are returned for none.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn fill(&self, rivers: &[RiverVertex], work: &Work<'_>) -> Result<Filled, Cancelled> {
        if rivers.is_empty() {
            return Ok(Filled::default());
        }
        let given = divided(rivers, self.spacing);
        let land = Land::new(self, &given);
        let mut sites: Vec<Point> = given.iter().map(|vertex| vertex.at).collect();
        sites.extend(land.border());
        let roots = sites.len();
        sites.extend(land.lattice(work)?);
        let net = land.without_gaps(&sites, &work.stage(0.0, 0.5))?;
        let rise = mean_slope(&given);
        let mut tree = Tree { land: &land, net: &net, given: &given, roots, rise, filled: Filled::default() };
        tree.grow(&work.stage(0.5, 1.0))?;
        Ok(tree.filled)
    }
}

/// Vertices with links longer than a length divided evenly, downstream first.
fn divided(rivers: &[RiverVertex], longest: f64) -> Vec<RiverVertex> {
    let mut all: Vec<RiverVertex> = Vec::with_capacity(rivers.len());
    let mut place = Vec::with_capacity(rivers.len());
    for vertex in rivers {
        let mut below = vertex.down.map(|down| place[down as usize]);
        if let Some(down) = below {
            let from = all[down as usize];
            let pieces = pieces(vertex.at, from.at, longest);
            let mix = |a: f64, b: f64, k: f64| a + (b - a) * (k / pieces);
            for k in (1..pieces as u32).map(f64::from) {
                let at = [0, 1].map(|i| mix(from.at[i], vertex.at[i], k));
                all.push(RiverVertex {
                    at,
                    height: mix(from.height, vertex.height, k),
                    down: below,
                    ..*vertex
                });
                below = Some(all.len() as u32 - 1);
            }
        }
        place.push(all.len() as u32);
        all.push(RiverVertex { down: below, ..*vertex });
    }
    all
}

/// How many pieces a link has that are no longer than a length.
fn pieces(a: Point, b: Point, longest: f64) -> f64 {
    libm::ceil(libm::hypot(a[0] - b[0], a[1] - b[1]) / longest).max(1.0)
}

/// The mean slope of links, at least a hundredth.
fn mean_slope(rivers: &[RiverVertex]) -> f64 {
    let (mut rise, mut length) = (0.0, 0.0);
    for vertex in rivers {
        if let Some(down) = vertex.down.map(|down| &rivers[down as usize]) {
            rise += vertex.height - down.height;
            length += libm::hypot(vertex.at[0] - down.at[0], vertex.at[1] - down.at[1]);
        }
    }
    (rise / f64::max(length, 1e-9)).clamp(0.01, 1.0)
}

/// The land, and the rivers that are given.
struct Land<'a> {
    infill: &'a Infill,
    all: Bounds,
    given: &'a [RiverVertex],
    links: LinkGrid,
}

impl<'a> Land<'a> {
    fn new(infill: &'a Infill, given: &'a [RiverVertex]) -> Self {
        let all = infill.filled_bounds();
        let mut links = LinkGrid::new(all, infill.spacing, given.len());
        for i in 0..given.len() {
            links.put(i as u32, segment(given, i));
        }
        Self { infill, all, given, links }
    }

    /// Whether a given river is nearer to a place than a distance.
    fn river_within(&self, at: Point, distance: f64) -> bool {
        let mut near = Vec::new();
        self.links.collect(Bounds { min: at, max: at }.grown(distance), &mut near);
        let is_near =
            |&link: &u32| distance_squared(at, segment(self.given, link as usize)) < distance * distance;
        near.iter().any(is_near)
    }

    /// Outlets along the border of the filled rectangle.
    fn border(&self) -> Vec<Point> {
        let (Bounds { min, max }, spacing) = (self.all, self.infill.spacing);
        let mut places = Vec::new();
        for (side, extent) in
            [self.all.width(), self.all.width(), self.all.depth(), self.all.depth()].into_iter().enumerate()
        {
            let count = libm::round(extent / spacing).max(1.0) as u64;
            let step = extent / count as f64;
            for k in 0..count {
                let aside = 0.6 * (unit(mix(self.infill.seed ^ mix(side as u64)), k) - 0.5);
                let along = (k as f64 + 0.5 + aside) * step;
                places.push(match side {
                    0 => [min[0] + along, min[1]],
                    1 => [min[0] + along, max[1]],
                    2 => [min[0], min[1] + along],
                    _ => [max[0], min[1] + along],
                });
            }
        }
        places.retain(|&at| !self.river_within(at, 1.2 * spacing));
        places
    }

    /// Places on a jittered lattice, away from rivers and from the outlets on the border. The lattice is that of the world,
    /// so a larger terrain has the same places.
    fn lattice(&self, work: &Work<'_>) -> Result<Vec<Point>, Cancelled> {
        let spacing = self.infill.spacing;
        let inner = self.all.grown(-0.3 * spacing);
        let [cols, rows] = [0, 1].map(|i| {
            let [from, to] = [self.all.min[i], self.all.max[i]].map(|v| libm::floor(v / spacing) as i64);
            from..=to
        });
        let row = |row: i64| -> Vec<Point> {
            let place = |col: i64| {
                let seed = mix(mix(self.infill.seed ^ mix(col as u64)) ^ row as u64);
                let aside = [0, 1].map(|i| JITTER * (2.0 * unit(seed, i) - 1.0));
                [(col as f64 + 0.5 + aside[0]) * spacing, (row as f64 + 0.5 + aside[1]) * spacing]
            };
            let is_free = |at: &Point| contains(inner, *at) && !self.river_within(*at, NEAR * spacing);
            cols.clone().map(place).filter(is_free).collect()
        };
        let rows = rows.into_par_iter().map(|index| work.check().map(|()| row(index)));
        Ok(rows.collect::<Result<Vec<_>, Cancelled>>()?.concat())
    }

    /// The triangulation of sites and of those that are added where a place would be farther than the spacing from all.
    fn without_gaps(&self, sites: &[Point], work: &Work<'_>) -> Result<Delaunay, Cancelled> {
        let mut net = Delaunay::new(sites, self.all, &work.stage(0.0, 0.7))?;
        for _ in 0..ROUNDS {
            let gaps = self.gaps(&net, work)?;
            if gaps.is_empty() {
                break;
            }
            net.extend(&gaps, &work.stage(0.7, 1.0))?;
        }
        Ok(net)
    }

    /// Middles of places without a site or a river, one for each place.
    fn gaps(&self, net: &Delaunay, work: &Work<'_>) -> Result<Vec<Point>, Cancelled> {
        let spacing = self.infill.spacing;
        let inner = self.all.grown(-spacing);
        let mut taken = LinkGrid::new(self.all, spacing, net.sites() / 16);
        let (mut gaps, mut near): (Vec<Point>, Vec<u32>) = (Vec::new(), Vec::new());
        for (triangle, centre) in voronoi::centres(net).into_iter().enumerate() {
            if triangle % LOOK == 0 {
                work.check()?;
            }
            let corner = net.point(net.corners(triangle)[0]);
            let radius = libm::hypot(centre[0] - corner[0], centre[1] - corner[1]);
            if radius <= spacing || !contains(inner, centre) || self.river_within(centre, spacing) {
                continue;
            }
            taken.collect(Bounds { min: centre, max: centre }.grown(NEAR * spacing), &mut near);
            let is_near = |&gap: &u32| {
                distance_squared(centre, [gaps[gap as usize]; 2]) < (NEAR * spacing) * (NEAR * spacing)
            };
            if !near.iter().any(is_near) {
                taken.put(gaps.len() as u32, [centre; 2]);
                gaps.push(centre);
            }
        }
        Ok(gaps)
    }
}

fn contains(bounds: Bounds, at: Point) -> bool {
    (0..2).all(|i| (bounds.min[i]..=bounds.max[i]).contains(&at[i]))
}

/// The link of a vertex; of an outlet, its place.
fn segment(rivers: &[RiverVertex], i: usize) -> [Point; 2] {
    [rivers[i].at, rivers[i].down.map_or(rivers[i].at, |down| rivers[down as usize].at)]
}

/// Rivers that grow over the triangulation.
struct Tree<'a> {
    land: &'a Land<'a>,
    net: &'a Delaunay,
    given: &'a [RiverVertex],
    /// The number of sites that are there before: given vertices, then outlets on the border.
    roots: usize,
    /// Slope of what is added, as a tangent.
    rise: f64,
    filled: Filled,
}

impl Tree<'_> {
    fn grow(&mut self, work: &Work<'_>) -> Result<(), Cancelled> {
        let sites = self.net.sites();
        let spacing = self.land.infill.spacing;
        // The vertex of each site, and its way to the outlet.
        let mut vertex = vec![NONE; sites];
        let mut way = vec![0.0; sites];
        self.filled.vertices.extend_from_slice(self.given);
        self.filled.first_added = self.given.len();
        let starts = self.net.starts();
        let mut heap = BinaryHeap::new();
        for (site, (way, vertex)) in way.iter_mut().zip(&mut vertex).take(self.roots).enumerate() {
            if site >= self.given.len() {
                *way = spacing;
                self.filled.vertices.push(self.outlet(site));
            }
            *vertex = site as u32;
        }
        for (site, &way) in way.iter().enumerate().take(self.roots) {
            self.open(site, &starts, &vertex, way, &mut heap);
        }
        let mut done = 0;
        while let Some(Edge { from, to, length, .. }) = heap.pop() {
            let [from, to] = [from as usize, to as usize];
            if vertex[to] != NONE {
                continue;
            }
            vertex[to] = self.filled.vertices.len() as u32;
            way[to] = way[from] + length;
            let below = self.filled.vertices[vertex[from] as usize];
            self.filled.vertices.push(RiverVertex {
                at: self.net.point(to as u32),
                height: (below.height + self.rise * length).min(MAX_HEIGHT),
                down: Some(vertex[from]),
                ..RiverVertex::default()
            });
            self.open(to, &starts, &vertex, way[to], &mut heap);
            done += 1;
            if done % LOOK == 0 {
                work.step(done as f32 / (sites - self.roots) as f32)?;
            }
        }
        self.filled.unreached =
            (self.roots..sites).filter(|&i| vertex[i] == NONE && self.net.same(i) == i).count();
        Ok(())
    }

    /// An outlet on the border, as high as the given ones and the rim ask for.
    fn outlet(&self, site: usize) -> RiverVertex {
        let at = self.net.point(site as u32);
        let over = |vertex: &RiverVertex| {
            let distance = libm::hypot(vertex.at[0] - at[0], vertex.at[1] - at[1]);
            vertex.height + self.land.infill.rim * distance
        };
        let outlets = self.given.iter().filter(|vertex| vertex.down.is_none());
        let height = outlets.map(over).fold(f64::INFINITY, f64::min);
        RiverVertex { at, height: height.min(MAX_HEIGHT), ..RiverVertex::default() }
    }

    /// Puts the edges from a site to those that are not reached on the heap.
    fn open(&self, site: usize, starts: &[u32], vertex: &[u32], way: f64, heap: &mut BinaryHeap<Edge>) {
        if starts[site] == NONE {
            return;
        }
        let (spacing, at) = (self.land.infill.spacing, self.net.point(site as u32));
        let below = self.filled.vertices[vertex[site] as usize]
            .down
            .map(|down| self.filled.vertices[down as usize].at);
        for edge in self.net.around(starts[site] as usize) {
            let to = self.net.end(edge);
            if !self.net.is_site(to) || (to as usize) < self.roots || vertex[to as usize] != NONE {
                continue;
            }
            let end = self.net.point(to);
            let ahead = [end[0] - at[0], end[1] - at[1]];
            let length = libm::hypot(ahead[0], ahead[1]);
            if length > LONGEST * spacing {
                continue;
            }
            let Some(crowd) = self.crowding(site, at, end) else { continue };
            let turn = below.map_or(1.0, |below| turn(below, at, end));
            let chance = 0.4 + 1.2 * unit(mix(self.land.infill.seed ^ site as u64), to.into());
            heap.push(Edge {
                cost: WAY * way + length * turn * crowd * chance,
                from: site as u32,
                to,
                length,
            });
        }
    }

    /// How much more a link costs for the given rivers beside it; none where it touches one.
    fn crowding(&self, site: usize, at: Point, end: Point) -> Option<f64> {
        let (spacing, given) = (self.land.infill.spacing, self.given);
        let Some(around) = Bounds::around([at, end]) else { return Some(1.0) };
        let mut near = Vec::new();
        self.land.links.collect(around.grown(CLEAR * spacing), &mut near);
        near.retain(|&link| link as usize != site && given[link as usize].down != Some(site as u32));
        if near.is_empty() {
            return Some(1.0);
        }
        let others: Vec<[Point; 2]> = near.iter().map(|&link| segment(given, link as usize)).collect();
        let room = Room { least: 0.0, most: CLEAR * spacing };
        let clear = room.of(at, end, &others).filter(|clear| *clear > 0.0)?;
        Some(4.0 - 3.0 * clear / (CLEAR * spacing))
    }
}

/// How much more a link costs that turns: 1 straight on, 2.2 back.
fn turn(below: Point, at: Point, end: Point) -> f64 {
    let [u, v] = [[at[0] - below[0], at[1] - below[1]], [end[0] - at[0], end[1] - at[1]]];
    let lengths = libm::hypot(u[0], u[1]) * libm::hypot(v[0], v[1]);
    1.6 - 0.6 * (u[0] * v[0] + u[1] * v[1]) / lengths.max(1e-12)
}

/// An edge on the heap: the cheapest first, of those the one from the first site.
#[derive(Clone, Copy, PartialEq)]
struct Edge {
    cost: f64,
    from: u32,
    to: u32,
    length: f64,
}

impl Eq for Edge {}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.from.cmp(&self.from)).then(other.to.cmp(&self.to))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
