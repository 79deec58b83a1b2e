//! How long filters and blends take, beside a plain copy of the same field.
//!
//! Throughput is bytes read and written once: 8 a sample for one input, 12 for two.

use divan::{Bencher, counter::BytesCount};
use orograph::engine;
use orograph::kit::hash;
use orograph::node::{Cancel, Context, Node};
use orograph::nodes::blend::combine::{self, Combine};
use orograph::nodes::filter::blur::Blur;
use orograph::nodes::filter::median::Median;
use orograph::nodes::filter::transform::Transform;
use orograph::nodes::filter::warp::Warp;
use orograph::nodes::select::colorize::{self, Colorize};
use orograph::ports::{Ports, Wires};
use orograph::units::{Degrees, Metres, Number, Ratio};
use orograph::value::{Field, Grid, Quantity, Terrain, Value};
use rayon::prelude::*;

const SIZE: u32 = 2049;

fn main() {
    divan::main();
}

fn terrain() -> Terrain {
    Terrain { width: 2048.0, depth: 2048.0, ..Terrain::default() }
}

fn grid() -> Grid {
    terrain().grid(SIZE).unwrap_or_else(|e| panic!("{e}"))
}

fn noise(grid: &Grid) -> Field {
    let data = (0..grid.len() as u64).map(|i| hash::unit(1, i) as f32 * 1000.0).collect();
    Field::new(*grid, Quantity::Elevation, data)
}

/// The terrain and half a terrain around it.
fn apron(grid: &Grid) -> Grid {
    let half = i64::from(grid.lattice.intervals) / 2;
    Grid::between(grid.lattice, [-half, -half], [3 * half + 1, 3 * half + 1])
}

fn bench<N: Node>(bencher: Bencher<'_, '_>, node: N, ports: &[&'static str]) {
    let (terrain, cancel, at) = (terrain(), Cancel::default(), grid());
    let input = |&p: &&'static str| {
        let window = Node::footprint(&node, p, &at, &terrain);
        (p, Value::Field(noise(&window.intersection(&apron(&window)))))
    };
    let wires: Wires = ports.iter().map(input).collect();
    let cx = Context::bare(at, &terrain, &cancel);
    bencher.counter(BytesCount::new(at.len() * 4 * (ports.len() + 1))).bench(|| {
        let input = N::In::take(&mut wires.clone()).unwrap_or_else(|e| panic!("{e}"));
        Node::run(&node, &cx, input).unwrap_or_else(|e| panic!("{e}")).give()
    });
}

#[divan::bench]
fn copy(bencher: Bencher<'_, '_>) {
    let input = noise(&grid());
    bencher.counter(BytesCount::new(input.data().len() * 8)).bench(|| {
        let mut out = vec![0.0f32; input.data().len()];
        out.par_chunks_mut(1 << 14)
            .zip(input.data().par_chunks(1 << 14))
            .for_each(|(o, i)| o.copy_from_slice(i));
        out
    });
}

#[divan::bench]
fn combine_add(bencher: Bencher<'_, '_>) {
    bench(bencher, Combine::default(), &["a", "b"]);
}

#[divan::bench]
fn combine_smooth_min_by_half(bencher: Bencher<'_, '_>) {
    let mode = combine::Mode::SmoothMin { width: Number(100.0) };
    bench(bencher, Combine { mode, strength: Ratio(0.5) }, &["a", "b"]);
}

#[divan::bench(args = [1.0, 3.0, 6.9, 7.0, 20.0, 100.0])]
fn blur(bencher: Bencher<'_, '_>, cells: f64) {
    bench(bencher, Blur { radius: Metres(cells) }, &["field"]);
}

#[divan::bench(args = [2.0, 8.0, 32.0, 100.0], sample_count = 3)]
fn median(bencher: Bencher<'_, '_>, cells: f64) {
    bench(bencher, Median { radius: Metres(cells) }, &["field"]);
}

#[divan::bench]
fn warp_by_fields(bencher: Bencher<'_, '_>) {
    let warp = Warp { limit: Metres(20.0), factor: Number(0.02), ..Warp::default() };
    bench(bencher, warp, &["field", "dx", "dy"]);
}

#[divan::bench]
fn warp_by_noise(bencher: Bencher<'_, '_>) {
    bench(bencher, Warp { limit: Metres(20.0), ..Warp::default() }, &["field"]);
}

#[divan::bench]
fn resample_twice_as_large(bencher: Bencher<'_, '_>) {
    bench(bencher, Transform { scale: Number(2.0), ..Transform::default() }, &["field"]);
}

#[divan::bench]
fn resample_twice_as_large_and_turned(bencher: Bencher<'_, '_>) {
    let node = Transform { scale: Number(2.0), rotate: Degrees(30.0), ..Transform::default() };
    bench(bencher, node, &["field"]);
}

#[divan::bench]
fn colorize(bencher: Bencher<'_, '_>) {
    let range = colorize::Range::Fixed { low: Number(0.0), high: Number(1000.0) };
    let (terrain, cancel, at) = (terrain(), Cancel::default(), grid());
    let (cx, node) = (Context::bare(at, &terrain, &cancel), Colorize { range, ..Colorize::default() });
    let field = noise(&at);
    // Three numbers are written for one that is read.
    bencher.counter(BytesCount::new(at.len() * 16)).bench(|| {
        let input = colorize::Inputs { field: field.clone(), shade: None, slope: None };
        node.run(&cx, input).unwrap_or_else(|e| panic!("{e}"))
    });
}

/// From the base grid to twice as many samples.
#[divan::bench]
fn lift(bencher: Bencher<'_, '_>) {
    let (terrain, cancel, at) = (terrain(), Cancel::default(), grid());
    let cx = Context::bare(at, &terrain, &cancel);
    let base = Value::Field(noise(&terrain.base_grid()));
    bencher
        .counter(BytesCount::new(at.len() * 5))
        .bench(|| engine::lift(&cx, &base).unwrap_or_else(|e| panic!("{e}")));
}
