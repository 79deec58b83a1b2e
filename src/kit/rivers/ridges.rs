//! Ridges: the edges of the Voronoi diagram of river vertices that no river crosses \[zhang2016, section V.A\].
//!
//! An edge is cut if a link joins the two vertices that it parts, or if a link touches it. The three river nodes nearest
//! to a vertex of the diagram, p1 to p3 of equation (4), are the corners of its Delaunay triangle, so none is searched
//! for.
//!
//! # Differs from the paper
//! The height of a ridge over the rivers, α·d, levels off at some distance; edges are clipped to a rectangle; heights are
//! smoothed along ridges, and stay above the rivers beside them.

use super::meeting::Meetings;
use crate::kit::delaunay::{Delaunay, NONE};
use crate::kit::predicates::{Point, segments_touch};
use crate::kit::voronoi;
use crate::value::curves::MAX_HEIGHT;
use crate::value::{Bounds, RidgeEdge, RidgeVertex, RiverVertex};
use crate::work::{Cancelled, Work};

/// Links or edges looked at between two looks at the switch that stops work.
const LOOK: usize = 1 << 14;

/// How high ridges are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    /// Rise from the nearest river, α, as a tangent.
    pub rise: f64,
    /// Distance from rivers over which the rise levels off, in metres: a ridge stands at most `rise · reach` higher than
    /// the rivers.
    pub reach: f64,
    /// Rounds of smoothing along ridges.
    pub rounds: u32,
}

/// Vertices and edges of ridges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Places and heights.
    pub vertices: Vec<RidgeVertex>,
    /// Edges between them.
    pub edges: Vec<RidgeEdge>,
}

/// The ridges between rivers inside a rectangle. Vertices stand downstream first.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn ridges(
    vertices: &[RiverVertex],
    bounds: Bounds,
    heights: Heights,
    work: &Work<'_>,
) -> Result<Found, Cancelled> {
    let sites: Vec<Point> = vertices.iter().map(|vertex| vertex.at).collect();
    let net = Delaunay::new(&sites, bounds, &work.stage(0.0, 0.4))?;
    let centres = voronoi::centres(&net);
    work.step(0.5)?;
    let divides = clipped_edges(&net, &centres, bounds, &work.stage(0.5, 0.6))?;
    let mut found = Corners::new(&net, &centres, vertices, divides);
    found.cut_crossed(&work.stage(0.6, 0.8))?;
    found.ridges(heights, &work.stage(0.8, 1.0))
}

/// An edge of the diagram inside the rectangle.
#[derive(Clone, Copy, Debug)]
struct Divide {
    /// Its ends: triangles, whose centres they are, or, counted on, places on the border.
    ends: [u32; 2],
    /// The half-edge of the triangulation that it crosses.
    edge: u32,
    is_cut: bool,
}

/// The edges of the diagram that reach into the rectangle, and where the border clips them.
fn clipped_edges(
    net: &Delaunay,
    centres: &[Point],
    bounds: Bounds,
    work: &Work<'_>,
) -> Result<(Vec<Divide>, Vec<Point>), Cancelled> {
    let inside = |at: Point| (0..2).all(|k| (bounds.min[k]..=bounds.max[k]).contains(&at[k]));
    let (mut divides, mut border) = (Vec::new(), Vec::new());
    for (done, edge) in net.edges().enumerate() {
        if done % LOOK == 0 {
            work.step(edge as f32 / net.half_edges() as f32)?;
        }
        let sites = [net.origin(edge), net.end(edge)];
        let Some(twin) = net.twin(edge).filter(|_| sites.iter().all(|&site| net.is_site(site))) else {
            continue;
        };
        let triangles = [edge / 3, twin / 3];
        let ends = triangles.map(|t| centres[t]);
        let is_inside = ends.map(inside);
        let clipped = match is_inside {
            [true, true] => ends,
            _ => match clip(sites.map(|site| net.point(site)), ends, bounds) {
                Some(clipped) => clipped,
                None => continue,
            },
        };
        let ends = [0, 1].map(|k| {
            if is_inside[k] {
                return triangles[k] as u32;
            }
            border.push(clipped[k]);
            (centres.len() + border.len() - 1) as u32
        });
        divides.push(Divide { ends, edge: edge as u32, is_cut: false });
    }
    Ok((divides, border))
}

/// The part inside a rectangle of the edge between two centres, which lies on the bisector of two sites. It is measured
/// along the bisector from between the sites, since a centre may be too far away to be subtracted from.
fn clip([a, b]: [Point; 2], centres: [Point; 2], bounds: Bounds) -> Option<[Point; 2]> {
    let middle = [0, 1].map(|k| a[k] + (b[k] - a[k]) / 2.0);
    let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
    let along = [(a[1] - b[1]) / length, (b[0] - a[0]) / length];
    let reach = centres.map(|at| (at[0] - middle[0]) * along[0] + (at[1] - middle[1]) * along[1]);
    let (mut low, mut high) = (reach[0].min(reach[1]), reach[0].max(reach[1]));
    for k in 0..2 {
        let [from, to] = [bounds.min[k] - middle[k], bounds.max[k] - middle[k]];
        if along[k] == 0.0 {
            if from > 0.0 || to < 0.0 {
                return None;
            }
            continue;
        }
        let [from, to] = [from / along[k], to / along[k]];
        (low, high) = (low.max(from.min(to)), high.min(from.max(to)));
    }
    let at = |s: f64| [0, 1].map(|k| (middle[k] + s * along[k]).clamp(bounds.min[k], bounds.max[k]));
    let [first, last] = if reach[0] <= reach[1] { [low, high] } else { [high, low] };
    (low <= high).then(|| [at(first), at(last)])
}

/// The diagram inside the rectangle, and what of it rivers cut.
struct Corners<'a> {
    net: &'a Delaunay,
    centres: &'a [Point],
    rivers: &'a [RiverVertex],
    border: Vec<Point>,
    divides: Vec<Divide>,
    /// The edge of the diagram that crosses each half-edge of the triangulation; [`NONE`] for none.
    of_half_edge: Vec<u32>,
    /// A half-edge from each site.
    starts: Vec<u32>,
}

impl<'a> Corners<'a> {
    fn new(
        net: &'a Delaunay,
        centres: &'a [Point],
        rivers: &'a [RiverVertex],
        (divides, border): (Vec<Divide>, Vec<Point>),
    ) -> Self {
        let mut of_half_edge = vec![NONE; net.half_edges()];
        for (i, divide) in divides.iter().enumerate() {
            let edge = divide.edge as usize;
            of_half_edge[edge] = i as u32;
            if let Some(twin) = net.twin(edge) {
                of_half_edge[twin] = i as u32;
            }
        }
        Self { net, centres, rivers, border, divides, of_half_edge, starts: net.starts() }
    }

    /// Where an end of an edge is.
    fn place(&self, end: u32) -> Point {
        let end = end as usize;
        self.centres.get(end).copied().unwrap_or_else(|| self.border[end - self.centres.len()])
    }

    /// Cuts the edges that part the two ends of a link, or that a link touches.
    fn cut_crossed(&mut self, work: &Work<'_>) -> Result<(), Cancelled> {
        let rivers = self.rivers;
        for (i, vertex) in rivers.iter().enumerate() {
            if i % LOOK == 0 {
                work.step(i as f32 / rivers.len() as f32)?;
            }
            if let Some(down) = vertex.down {
                self.cut_link(i, down as usize);
            }
        }
        Ok(())
    }

    /// Cuts what one link crosses, on a walk through the cells that it crosses.
    fn cut_link(&mut self, upper: usize, lower: usize) {
        let link = [self.rivers[upper].at, self.rivers[lower].at];
        let ends = [upper, lower].map(|vertex| self.net.same(vertex) as u32);
        let mut site = ends[0];
        loop {
            let start = self.starts[site as usize] as usize;
            let mut nearest: Option<(f64, u32)> = None;
            for edge in self.net.around(start) {
                let other = self.net.end(edge);
                if let Some(divide) = self.divides.get(self.of_half_edge[edge] as usize) {
                    let joins = [site, other] == ends || [other, site] == ends;
                    let touched = || segments_touch(link, divide.ends.map(|end| self.place(end)));
                    if !divide.is_cut && (joins || touched()) {
                        self.divides[self.of_half_edge[edge] as usize].is_cut = true;
                    }
                }
                if self.net.is_site(other) {
                    let leaves = leaves_at(link, self.net.point(site), self.net.point(other));
                    nearest = leaves
                        .filter(|t| nearest.is_none_or(|(first, _)| *t < first))
                        .map(|t| (t, other))
                        .or(nearest);
                }
            }
            match nearest {
                Some((t, other)) if t < 1.0 && site != ends[1] => site = other,
                _ => return,
            }
        }
    }

    /// The edges that no river cut, with heights.
    fn ridges(&self, heights: Heights, work: &Work<'_>) -> Result<Found, Cancelled> {
        let kept: Vec<&Divide> = self.divides.iter().filter(|divide| !divide.is_cut).collect();
        let meetings = Meetings::of(self.rivers);
        let beds = self.highest_beds();
        let mut number = vec![NONE; self.centres.len() + self.border.len()];
        let mut found = Found { vertices: Vec::new(), edges: Vec::with_capacity(kept.len()) };
        // The highest river beside each vertex, below which it never falls.
        let mut floors = Vec::new();
        for (i, divide) in kept.into_iter().enumerate() {
            if i % LOOK == 0 {
                work.check()?;
            }
            let edge = divide.edge as usize;
            let rivers = [self.net.origin(edge), self.net.end(edge)];
            let ends = divide.ends.map(|end| {
                let slot = &mut number[end as usize];
                if *slot == NONE {
                    let (vertex, floor) = self.vertex(end, rivers, &beds, heights);
                    *slot = found.vertices.len() as u32;
                    found.vertices.push(vertex);
                    floors.push(floor);
                }
                *slot
            });
            let order = meetings.order([rivers[0] as usize, rivers[1] as usize]);
            found.edges.push(RidgeEdge { ends, rivers, order });
        }
        work.step(0.7)?;
        for _ in 0..heights.rounds {
            smooth(&mut found, &floors);
            work.check()?;
        }
        Ok(found)
    }

    /// The highest bed at the place of each site.
    fn highest_beds(&self) -> Vec<f64> {
        let mut beds: Vec<f64> = self.rivers.iter().map(|vertex| vertex.height).collect();
        for (i, vertex) in self.rivers.iter().enumerate() {
            let same = self.net.same(i);
            beds[same] = beds[same].max(vertex.height);
        }
        beds
    }

    /// A vertex of the ridges with the height of equation (4), and the highest river beside it. On the border the rivers
    /// beside it are those that its edge parts.
    fn vertex(&self, end: u32, parted: [u32; 2], beds: &[f64], heights: Heights) -> (RidgeVertex, f64) {
        let at = self.place(end);
        let corners = if (end as usize) < self.centres.len() {
            self.net.corners(end as usize)
        } else {
            [parted[0], parted[1], parted[0]]
        };
        let near = self.net.point(parted[0]);
        let distance = libm::hypot(at[0] - near[0], at[1] - near[1]);
        let sites = corners.into_iter().filter(|&corner| self.net.is_site(corner));
        let floor = sites.map(|corner| beds[corner as usize]).fold(f64::NEG_INFINITY, f64::max);
        let over = heights.rise * heights.reach * (1.0 - libm::exp(-distance / heights.reach));
        (RidgeVertex { at, height: (floor + over).min(MAX_HEIGHT) }, floor)
    }
}

/// The share of a link after which it leaves the cell of a site for that of another; none where it runs from the other to
/// the site.
fn leaves_at([a, b]: [Point; 2], site: Point, other: Point) -> Option<f64> {
    let toward = [other[0] - site[0], other[1] - site[1]];
    let speed = (b[0] - a[0]) * toward[0] + (b[1] - a[1]) * toward[1];
    let middle = [0, 1].map(|k| site[k] + toward[k] / 2.0);
    let ahead = (middle[0] - a[0]) * toward[0] + (middle[1] - a[1]) * toward[1];
    (speed > 0.0).then(|| ahead / speed)
}

/// Moves each vertex half the way to the mean height of those that edges join it to, but not below its floor.
fn smooth(found: &mut Found, floors: &[f64]) {
    let mut sums = vec![(0.0, 0_u32); found.vertices.len()];
    for edge in &found.edges {
        let [a, b] = edge.ends.map(|end| end as usize);
        for (to, from) in [(a, b), (b, a)] {
            sums[to].0 += found.vertices[from].height;
            sums[to].1 += 1;
        }
    }
    for ((vertex, (sum, count)), floor) in found.vertices.iter_mut().zip(sums).zip(floors) {
        let mean = sum / f64::from(count.max(1));
        vertex.height = (0.5 * (vertex.height + mean)).max(*floor);
    }
}
