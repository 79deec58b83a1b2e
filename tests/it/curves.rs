//! Tests of feature curves: the model, the raster.

mod crossing;
mod edit;
mod land;
mod model;
mod nodes;
mod raster;
mod symmetry;

use orograph::kit::curves::{Options, rasterise};
use orograph::value::{Constraints, CurveSpec, Curves, Grid, Lattice};

/// `n` × `n` samples, `cell` metres apart, from an origin.
pub(crate) fn grid(origin: [f64; 2], cell: f64, n: usize) -> Grid {
    let lattice = Lattice { origin, span: cell * (n - 1) as f64, intervals: n as u32 - 1 };
    Grid { lattice, col: 0, row: 0, cols: n, rows: n }
}

pub(crate) fn spec(json: &str) -> CurveSpec {
    serde_json::from_str(json).expect("a spec")
}

pub(crate) fn curves(specs: &[&str]) -> Curves {
    Curves::from_specs(&specs.iter().map(|s| spec(s)).collect::<Vec<_>>()).expect("curves")
}

pub(crate) fn raster(curves: &Curves, grid: &Grid) -> Constraints {
    rasterise(curves, grid, &Options::default(), &|| false).expect("a raster")
}

/// Every column and row of a grid with its place in metres.
pub(crate) fn samples(grid: &Grid) -> impl Iterator<Item = ([usize; 2], [f64; 2])> {
    let g = *grid;
    (0..g.rows).flat_map(move |j| (0..g.cols).map(move |i| ([i, j], [g.x(i), g.y(j)])))
}

pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
