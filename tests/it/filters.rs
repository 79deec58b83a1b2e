//! Tests of: filters and blends.

mod blend;
mod levels;
mod place;
mod smooth;

use orograph::kit::{blur, hash, sample};
use orograph::node::Node;
use orograph::nodes::blend::{combine, combine::Combine, mix::Mix, switch::Switch};
use orograph::nodes::filter::{
    blur::Blur, clamp::Clamp, curve::Curve, edge_falloff, edge_falloff::EdgeFalloff, equalize::Equalize,
    invert, invert::Invert, median::Median, remap::InputRange, remap::Remap, sharpen::Sharpen,
    terrace::Steps, terrace::Terrace, transform::Mirror, transform::Transform, warp::Warp,
};
use orograph::units::{Degrees, Metres, Number, Ratio, Seed};
use orograph::value::{Field, Grid, Lattice, Quantity, Raster, Terrain, Value};
use orograph::work::Work;

use crate::rig::bench::{Bench, Source};

const CELL: f64 = 8.0;

fn world() -> Terrain {
    Terrain { origin: [300.0, -200.0], width: 2048.0, depth: 1536.0, base: 129, ..Terrain::default() }
}

/// A window of the lattice of 257 samples (8 m).
fn window(from: [i64; 2], end: [i64; 2]) -> Grid {
    Grid::between(world().grid(257).expect("a size that fits").lattice, from, end)
}

/// Hills with noise at every sample and a cliff.
fn rough(grid: &Grid) -> Field {
    field(grid, |x, y| {
        let noise = hash::unit(x.to_bits() ^ y.to_bits().rotate_left(17), 1);
        let cliff = if x + 0.5 * y > 900.0 { 180.0 } else { 0.0 };
        300.0 + 200.0 * libm::sin(x / 170.0) * libm::cos(y / 230.0) + 40.0 * noise + cliff
    })
}

fn field(grid: &Grid, f: impl Fn(f64, f64) -> f64) -> Field {
    Field::from_fn(*grid, Quantity::Elevation, |x, y| f(x, y) as f32)
}

fn rough_field(port: &str, grid: &Grid) -> Option<Value> {
    matches!(port, "field" | "a" | "b").then(|| Value::Field(rough(grid)))
}

fn run<N: Node>(node: &N, at: Grid, source: Source<'_>) -> Field {
    Bench::of(node).field(&world(), at, source, "field")
}

/// Runs a node with one input, given on exactly the window of the output and whatever lies around it.
fn on<N: Node>(node: &N, input: &Field) -> Field {
    run(node, *input.grid(), &|port, grid| {
        matches!(port, "field" | "a").then(|| Value::Field(input.crop(grid)))
    })
}

fn bits(field: &Field) -> Vec<u32> {
    field.data().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn wide_medians_do_not_depend_on_the_window() {
    let (a, b) = (window([3, 5], [40, 30]), window([9, 7], [20, 29]));
    let node = Median { radius: Metres(150.0 * CELL) };
    assert!(bits(&run(&node, a, &rough_field).crop(&b)) == bits(&run(&node, b, &rough_field)));
}
