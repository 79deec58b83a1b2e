//! Voronoi diagrams inside a rectangle: which land is nearest to which site.

use rayon::prelude::*;

use super::delaunay::{Delaunay, NONE};
use super::predicates::{Point, side};
use crate::value::Bounds;
use crate::work::{Cancelled, Work};

/// Sites whose cells are made with the same memory.
const RUN: usize = 256;
/// Runs between two looks at the switch that stops work.
const BAND: usize = 16;

/// The centre of the circle through the corners of each triangle: the vertices of the diagram. Those of triangles at far
/// corners lie outside the bounds of the triangulation; all are finite.
pub fn centres(net: &Delaunay) -> Vec<Point> {
    (0..net.triangles())
        .into_par_iter()
        .map(|t| centre(net.corners(t).map(|corner| net.point(corner))))
        .collect()
}

/// The centre of the circle through the corners of a triangle that turns left.
fn centre([a, b, c]: [Point; 3]) -> Point {
    let [b, c] = [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]];
    let [bb, cc] = [b, c].map(|v| v[0] * v[0] + v[1] * v[1]);
    // The exact sign keeps the centre of a thin triangle on the right side of it.
    let twice = 2.0 * side([0.0; 2], b, c);
    [a[0] + (c[1] * bb - b[1] * cc) / twice, a[1] + (b[0] * cc - c[0] * bb) / twice]
}

/// The area of the cell of each site inside the bounds, in square metres. Of sites at one place the first has it all. The
/// areas sum to that of the bounds, if there is a site.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn areas(net: &Delaunay, bounds: Bounds, work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
    let starts = net.starts();
    let mut areas = vec![0.0; net.sites()];
    work.rows(&mut areas, RUN, BAND, |run, areas| {
        let [mut cell, mut clipped] = [Vec::with_capacity(12), Vec::with_capacity(12)];
        for (site, area) in (run * RUN..).zip(areas) {
            if starts[site] != NONE {
                cut_cell(net, bounds, site, starts[site] as usize, &mut cell, &mut clipped);
                *area = area_of(&cell);
            }
        }
    })?;
    Ok(areas)
}

/// The cell of a site inside the bounds, a convex polygon; empty where the cell lies outside. The half-edge must start at
/// the site.
pub fn cell(net: &Delaunay, bounds: Bounds, site: usize, start: usize) -> Vec<Point> {
    let (mut cell, mut clipped) = (Vec::new(), Vec::new());
    cut_cell(net, bounds, site, start, &mut cell, &mut clipped);
    cell
}

/// Cuts a cell from the rectangle, neighbour by neighbour, so that it is right however far the centres of thin triangles
/// lie.
fn cut_cell(
    net: &Delaunay,
    bounds: Bounds,
    site: usize,
    start: usize,
    cell: &mut Vec<Point>,
    clipped: &mut Vec<Point>,
) {
    let Bounds { min, max } = bounds;
    let at = net.point(site as u32);
    cell.clear();
    cell.extend([min, [max[0], min[1]], max, [min[0], max[1]]]);
    for edge in net.around(start) {
        clip(cell, at, net.point(net.end(edge)), clipped);
        std::mem::swap(cell, clipped);
    }
}

/// The part of a convex polygon that is nearer to one place than to another.
fn clip(polygon: &[Point], near: Point, far: Point, clipped: &mut Vec<Point>) {
    let away = [far[0] - near[0], far[1] - near[1]];
    let middle = [0, 1].map(|i| near[i] + away[i] / 2.0);
    let beyond = |p: Point| (p[0] - middle[0]) * away[0] + (p[1] - middle[1]) * away[1];
    clipped.clear();
    for (i, &to) in polygon.iter().enumerate() {
        let from = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (u, v) = (beyond(from), beyond(to));
        if (u < 0.0) != (v < 0.0) && u != v {
            let t = u / (u - v);
            clipped.push([0, 1].map(|k| from[k] + t * (to[k] - from[k])));
        }
        if v < 0.0 {
            clipped.push(to);
        }
    }
}

/// The area of a polygon, in square metres.
pub fn area_of(polygon: &[Point]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let from_first = |p: Point| [p[0] - first[0], p[1] - first[1]];
    let triangle = |pair: &[Point]| {
        let [a, b] = [from_first(pair[0]), from_first(pair[1])];
        a[0] * b[1] - a[1] * b[0]
    };
    (polygon.windows(2).map(triangle).sum::<f64>() / 2.0).abs()
}
