//! From curves to a height field, as in Table 2 of \[hnaidi2010\]: raster, diffusion and noise apart, on the presets of
//! its scenes.

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::graph::Graph;
use orograph::kit::diffusion::{Problem, Quality as Solver, solve};
use orograph::node::{Cancel, Context};
use orograph::nodes::Registry;
use orograph::nodes::curves::curve_raster::{self, CurveRaster};
use orograph::nodes::curves::diffuse::{self, Diffuse, Quality};
use orograph::nodes::curves::feature_curves::{self, FeatureCurves};
use orograph::nodes::generate::multifractal::{self, Multifractal};
use orograph::prelude::Node;
use orograph::value::{Constraints, Curves, Grid, Mark, Terrain};
use orograph::work::Work;

const SIZES: [u32; 3] = [513, 1025, 2049];
const SCENE: &str = include_str!("../graphs/mountain.graph");

fn main() {
    divan::main();
}

/// The curves of the mountain preset.
fn curves(terrain: &Terrain) -> Curves {
    let graph = Graph::from_bytes(SCENE.as_bytes(), &Registry::standard()).expect("a graph");
    let id = graph.find("curves").expect("the node of the curves");
    let set = serde_json::Value::Object((*graph.node(id).set).clone());
    let node: FeatureCurves = serde_json::from_value(set).expect("curves");
    let cancel = Cancel::default();
    let cx = Context::bare(Grid::NOWHERE, terrain, &cancel);
    Node::run(&node, &cx, feature_curves::Inputs {}).expect("runs").curves
}

fn grid(size: u32) -> (Terrain, Grid) {
    let terrain = Terrain { width: 8192.0, depth: 8192.0, ..Terrain::default() };
    let grid = terrain.grid(size).expect("a size");
    (terrain, grid)
}

fn constraints(size: u32) -> (Terrain, Grid, Constraints) {
    let (terrain, grid) = grid(size);
    let cancel = Cancel::default();
    let input = curve_raster::Inputs { curves: curves(&terrain) };
    let out = Node::run(&CurveRaster::default(), &Context::bare(grid, &terrain, &cancel), input);
    (terrain.clone(), grid, out.expect("runs").constraints)
}

#[divan::bench(args = SIZES)]
fn raster(bencher: Bencher<'_, '_>, size: u32) {
    let (terrain, grid) = grid(size);
    let (curves, cancel) = (curves(&terrain), Cancel::default());
    let cx = Context::bare(grid, &terrain, &cancel);
    bencher.bench_local(|| {
        Node::run(&CurveRaster::default(), &cx, curve_raster::Inputs { curves: curves.clone() }).is_ok()
    });
}

fn diffusion(bencher: Bencher<'_, '_>, size: u32, quality: Quality) {
    let (terrain, grid, constraints) = constraints(size);
    let cancel = Cancel::default();
    let cx = Context::bare(grid, &terrain, &cancel);
    let node = Diffuse { quality, ..Diffuse::default() };
    bencher.bench_local(|| {
        let input = diffuse::Inputs { constraints: constraints.clone(), base: None };
        Node::run(&node, &cx, input).is_ok()
    });
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn diffusion_as_in_the_paper(bencher: Bencher<'_, '_>, size: u32) {
    diffusion(bencher, size, Quality::Paper);
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn diffusion_converged(bencher: Bencher<'_, '_>, size: u32) {
    diffusion(bencher, size, Quality::Converged);
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn noise_of_four_octaves(bencher: Bencher<'_, '_>, size: u32) {
    let (terrain, grid, constraints) = constraints(size);
    let cancel = Cancel::default();
    let cx = Context::bare(grid, &terrain, &cancel);
    let out = Node::run(&Diffuse::default(), &cx, diffuse::Inputs { constraints, base: None }).expect("runs");
    bencher.bench_local(|| {
        let input = multifractal::Inputs {
            amplitude: Some(out.amplitude.clone()),
            roughness: Some(out.roughness.clone()),
        };
        Node::run(&Multifractal::default(), &cx, input).is_ok()
    });
}

/// One Laplace field from the heights of the curves, setup and solve.
#[divan::bench(args = [257, 513, 1025, 2049, 4097], sample_count = 5)]
fn laplace_converged(bencher: Bencher<'_, '_>, size: u32) {
    let (_, grid, constraints) = constraints(size);
    let fixed = constraints.mask(Mark::Height);
    let target = constraints.planes().height.clone().expect("heights");
    let (cols, rows) = (grid.cols, grid.rows);
    let problem = Problem { cols, rows, fixed: &fixed, target: &target, guidance: None, source: None };
    let cycles = solve(&problem, Solver::CONVERGED, &Work::default()).map(|s| s.cycles);
    eprintln!("{size}²: {cycles:?} V-cycles");
    bencher
        .counter(ItemsCount::new(grid.len()))
        .bench_local(|| solve(&problem, Solver::CONVERGED, &Work::default()));
}
