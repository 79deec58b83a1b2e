//! The land that drains through each vertex, and how wide its river is.

use crate::kit::delaunay::Delaunay;
use crate::kit::predicates::Point;
use crate::kit::voronoi;
use crate::value::{Bounds, RiverVertex};
use crate::work::{Cancelled, Work};

/// The area that drains through each vertex, in square metres: its own Voronoi cell inside the bounds, and those of all
/// that drain to it. Of vertices at one place the first has the cell. Downstream stands first; outlets together have the
/// area of the bounds.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn areas(vertices: &[RiverVertex], bounds: Bounds, work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
    let sites: Vec<Point> = vertices.iter().map(|vertex| vertex.at).collect();
    let net = Delaunay::new(&sites, bounds, &work.stage(0.0, 0.5))?;
    let mut areas = voronoi::areas(&net, bounds, &work.stage(0.5, 1.0))?;
    sum_downstream(vertices, &mut areas);
    Ok(areas)
}

/// Adds to each vertex what all that drain to it have.
pub fn sum_downstream(vertices: &[RiverVertex], amounts: &mut [f64]) {
    for i in (0..vertices.len()).rev() {
        if let Some(down) = vertices[i].down {
            amounts[down as usize] += amounts[i];
        }
    }
}

/// The width of a river, in metres, that is so wide where it drains a square kilometre: the width grows with the root of
/// the discharge \[leopold1953\], and that with the area.
pub fn width(area: f64, of_square_kilometre: f64) -> f64 {
    of_square_kilometre * libm::sqrt(area * 1e-6)
}

/// Sets areas and widths.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn drain(
    vertices: &mut [RiverVertex],
    bounds: Bounds,
    of_square_kilometre: f64,
    work: &Work<'_>,
) -> Result<(), Cancelled> {
    let areas = areas(vertices, bounds, work)?;
    for (vertex, area) in vertices.iter_mut().zip(areas) {
        vertex.area = area as f32;
        vertex.width = width(area, of_square_kilometre) as f32;
    }
    Ok(())
}
