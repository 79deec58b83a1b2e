//! Heights of beds: how rivers rise from their outlets, and how steep the land between them may be.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use crate::kit::delaunay::Delaunay;
use crate::kit::predicates::Point;
use crate::value::{Bounds, RiverVertex};
use crate::work::{Cancelled, Work};

/// The least fall of a bed, as a tangent: a metre in ten kilometres.
pub const LEAST_FALL: f64 = 1e-4;
/// Vertices taken off the heap between two looks at the switch that stops work.
const LOOK: usize = 1 << 16;

/// How rivers rise from their outlets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rise {
    /// By a slope, a tangent, times the length to the outlet \[zhang2016, section IV.C\].
    Even(f64),
    /// Ever steeper towards the sources, by slopes that go with `area ^ -concavity` \[flint1974\].
    Concave {
        /// The exponent θ.
        concavity: f64,
        /// Height above its outlet that one vertex in a hundred is over, in metres.
        relief: f64,
    },
}

/// Sets the heights of vertices that stand downstream first; outlets keep theirs. Each river falls by at least
/// [`LEAST_FALL`] all the way.
pub fn rise(vertices: &mut [RiverVertex], rise: Rise) {
    let rises = rises(vertices, rise);
    for i in 0..vertices.len() {
        let Some(down) = vertices[i].down else { continue };
        // Over a long network the least falls alone could leave the range of heights.
        vertices[i].height =
            (vertices[down as usize].height + rises[i]).min(crate::value::curves::MAX_HEIGHT);
    }
}

/// By how much each vertex is higher than the one downstream.
fn rises(vertices: &[RiverVertex], rise: Rise) -> Vec<f64> {
    let lengths = link_lengths(vertices);
    let (concavity, relief) = match rise {
        Rise::Even(slope) => return lengths.iter().map(|length| length * slope.max(LEAST_FALL)).collect(),
        Rise::Concave { concavity, relief } => (concavity, relief),
    };
    // Slopes level off below the area of the smallest tenth, so that a source without land is no cliff.
    let smallest = quantile(vertices.iter().map(|vertex| vertex.area.into()), 0.1).max(1e-6);
    let slope = |vertex: &RiverVertex| libm::pow(f64::from(vertex.area).max(smallest) / smallest, -concavity);
    let raw: Vec<f64> =
        vertices.par_iter().zip(&lengths).map(|(vertex, length)| slope(vertex) * length).collect();
    let mut above = raw.clone();
    for i in 0..vertices.len() {
        if let Some(down) = vertices[i].down {
            above[i] += above[down as usize];
        }
    }
    let scale = relief / quantile(above.into_iter(), 0.99).max(1e-9);
    raw.iter().zip(&lengths).map(|(rise, length)| (rise * scale).max(length * LEAST_FALL)).collect()
}

/// The length of each link, in metres; 0 for an outlet.
fn link_lengths(vertices: &[RiverVertex]) -> Vec<f64> {
    let length = |vertex: &RiverVertex| {
        vertex.down.map_or(0.0, |down| distance(vertex.at, vertices[down as usize].at))
    };
    vertices.iter().map(length).collect()
}

/// The value that a share of all values is not over; 0 of none.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return 0.0;
    }
    let at = (share * (values.len() - 1) as f64) as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

fn distance(a: Point, b: Point) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Lowers vertices that are so much higher than a neighbour that the land between them would be steeper than a tangent.
/// Neighbours are those of the Delaunay triangulation, and the ends of links. Rivers fall all the way, as before.
///
/// The result is the highest that is nowhere over the given heights. With `h' = h - LEAST_FALL · length` both demands,
/// on slopes and on falling beds, say that one vertex is over another by at most a number that is not negative, so that
/// Dijkstra's search finds it, from the lowest vertex up.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn limit_sides(vertices: &mut [RiverVertex], steepest: f64, work: &Work<'_>) -> Result<(), Cancelled> {
    let sites: Vec<Point> = vertices.iter().map(|vertex| vertex.at).collect();
    let Some(bounds) = Bounds::around(sites.iter().copied()) else { return Ok(()) };
    let net = Delaunay::new(&sites, bounds, &work.stage(0.0, 0.5))?;
    let neighbours = Neighbours::of(&net, vertices);
    let fall: Vec<f64> = falls(vertices);
    let mut heights: Vec<f64> =
        vertices.iter().zip(&fall).map(|(vertex, fall)| vertex.height - fall).collect();
    let over = |from: usize, to: u32| {
        let to = to as usize;
        (steepest * distance(vertices[from].at, vertices[to].at) + fall[from] - fall[to]).max(0.0)
    };
    // What lowers no other is not looked at before it is lowered itself.
    let lowers = |&i: &usize| {
        let is_over = |&to: &u32| heights[to as usize] > heights[i] + over(i, to);
        let down = vertices[i].down.is_some_and(|down| heights[down as usize] > heights[i]);
        down || neighbours.at(i).iter().any(is_over)
    };
    let first: Vec<usize> = (0..vertices.len()).into_par_iter().filter(lowers).collect();
    let open = |i: usize| Open { height: heights[i], vertex: i as u32 };
    let mut heap: BinaryHeap<Open> = first.into_iter().map(open).collect();
    let work = work.stage(0.5, 1.0);
    let mut settled = 0;
    while let Some(Open { height, vertex }) = heap.pop() {
        let i = vertex as usize;
        if height > heights[i] {
            continue;
        }
        settled += 1;
        if settled % LOOK == 0 {
            work.step(settled as f32 / vertices.len() as f32)?;
        }
        let mut lower = |other: u32, limit: f64| {
            if limit < heights[other as usize] {
                heights[other as usize] = limit;
                heap.push(Open { height: limit, vertex: other });
            }
        };
        for &other in neighbours.at(i) {
            lower(other, height + over(i, other));
        }
        // The vertex downstream is lower by the least fall at least.
        if let Some(down) = vertices[i].down {
            lower(down, height);
        }
    }
    for ((vertex, height), fall) in vertices.iter_mut().zip(heights).zip(fall) {
        vertex.height = height + fall;
    }
    Ok(())
}

/// The least that each vertex stands over its outlet.
fn falls(vertices: &[RiverVertex]) -> Vec<f64> {
    let mut falls = link_lengths(vertices);
    for i in 0..vertices.len() {
        let below = vertices[i].down.map_or(0.0, |down| falls[down as usize]);
        falls[i] = falls[i] * LEAST_FALL + below;
    }
    falls
}

/// Who is beside whom.
struct Neighbours {
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn of(net: &Delaunay, vertices: &[RiverVertex]) -> Self {
        let pairs = || {
            let edges = net.edges().map(|edge| [net.origin(edge), net.end(edge)]);
            let between = edges.filter(|ends| ends.iter().all(|&end| net.is_site(end)));
            let links = vertices.iter().enumerate().filter_map(|(i, vertex)| Some([i as u32, vertex.down?]));
            // What stands where an earlier vertex does is beside it.
            let same = (0..vertices.len()).map(|i| [i as u32, net.same(i) as u32]).filter(|[a, b]| a != b);
            between.chain(links).chain(same)
        };
        let mut starts = vec![0_u32; vertices.len() + 1];
        for end in pairs().flatten() {
            starts[end as usize + 1] += 1;
        }
        for i in 0..vertices.len() {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut list = vec![0; starts[vertices.len()] as usize];
        for [a, b] in pairs() {
            for (from, to) in [(a, b), (b, a)] {
                list[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        Self { starts, list }
    }

    fn at(&self, vertex: usize) -> &[u32] {
        &self.list[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// A vertex and its height on the heap, the lowest first, of those the first.
#[derive(Clone, Copy, PartialEq)]
struct Open {
    height: f64,
    vertex: u32,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.height.total_cmp(&self.height).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
