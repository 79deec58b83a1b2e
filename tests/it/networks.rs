//! Tests of river networks: values, triangulations, topology, growth on a map, infill, profiles, ridges.

mod delaunay;
mod growth;
mod infill;
mod meander;
mod nodes;
mod profile;
mod ridges;
mod topology;
mod values;

use orograph::kit::predicates::{Point, segments_cross, segments_touch};
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::grow::{Grown, Growth, Line};
use orograph::kit::rivers::link_grid::LinkGrid;
use orograph::value::{Bounds, RiverVertex, Rivers};
use orograph::work::Work;

/// Side of the square that most tests work on, in metres.
const SIDE: f64 = 16_384.0;
const SQUARE: Bounds = Bounds { min: [0.0; 2], max: [SIDE; 2] };
/// From the middle of the southern border most of the way north.
const LINE: Line = Line { from: [SIDE / 2.0, SIDE], to: [SIDE / 2.0, SIDE * 0.08] };

/// How many seeds a test tries: all where the whole breadth is asked for.
fn seeds(all: u64, few: u64) -> std::ops::Range<u64> {
    let breadth = std::env::var_os("OROGRAPH_BREADTH").is_some_and(|v| !v.is_empty() && v != "0");
    0..if breadth { all } else { few }
}

/// Usual growth on the square.
fn growth(branching: Branching, max_depth: u32, seed: u64) -> Growth<'static> {
    Growth {
        bounds: SQUARE,
        branching,
        max_depth,
        angle: 35_f64.to_radians(),
        lengthen: 0.0,
        wander: 0.12,
        clearance: 0.38,
        seed,
        is_land: &|_| true,
    }
}

fn grow(growth: &Growth<'_>, lines: &[Line]) -> Grown {
    growth.grow(lines, &Work::default()).unwrap()
}

/// A network whose beds rise by two metres in a hundred.
fn rivers(grown: &Grown) -> Rivers {
    let mut vertices = grown.vertices().unwrap();
    for vertex in &mut vertices {
        vertex.height = 0.02 * f64::from(vertex.length);
    }
    Rivers::new(vertices).unwrap()
}

/// The link of a vertex.
fn segment(vertices: &[RiverVertex], i: usize) -> Option<[Point; 2]> {
    Some([vertices[i].at, vertices[vertices[i].down? as usize].at])
}

/// All links, for searches near a place.
fn link_grid(vertices: &[RiverVertex]) -> LinkGrid {
    let bounds = Bounds::around(vertices.iter().map(|vertex| vertex.at)).unwrap();
    let mut grid = LinkGrid::new(bounds, bounds.width().max(bounds.depth()) / 200.0, vertices.len());
    for i in 0..vertices.len() {
        if let Some(link) = segment(vertices, i) {
            grid.put(i as u32, link);
        }
    }
    grid
}

/// Pairs of links that have a point in common that is no vertex of both.
fn crossings(vertices: &[RiverVertex]) -> Vec<[usize; 2]> {
    let (grid, mut near, mut found) = (link_grid(vertices), Vec::new(), Vec::new());
    for i in 0..vertices.len() {
        let Some(link) = segment(vertices, i) else { continue };
        grid.collect(Bounds::around(link).unwrap(), &mut near);
        for j in near.iter().map(|&j| j as usize).filter(|&j| j < i) {
            let other = segment(vertices, j).unwrap();
            let ends = |k: usize| [k, vertices[k].down.unwrap() as usize];
            let joined = ends(i).iter().any(|end| ends(j).contains(end));
            if joined && segments_cross(link, other) || !joined && segments_touch(link, other) {
                found.push([j, i]);
            }
        }
    }
    found
}

/// The mean of a figure over seeds.
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
