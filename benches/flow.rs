//! Water over a terrain: filling, ways and areas, of 2048² and 4096² samples.
//!
//! What others take at 2048²: 0.355 s to fill (`TopoToolbox`), 0.30 s for D8 with areas (`HighMap`).

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::kit::flow::{
    Depressions, Lakes, Puddles, Rule, Spread, Surface, Tree, accumulate, breach, epsilon,
};
use orograph::node::{Cancel, Context};
use orograph::nodes::generate::multifractal::{self, Multifractal};
use orograph::prelude::Node;
use orograph::value::{Grid, Lattice, Terrain};
use orograph::work::Work;

const SIZES: [usize; 2] = [2048, 4096];

fn main() {
    divan::main();
}

/// Rough land with some two pits in a thousand samples, 30 m a cell, and a sea.
struct Land {
    size: usize,
    height: Vec<f32>,
}

impl Land {
    fn new(size: usize) -> Self {
        let span = 30.0 * (size - 1) as f64;
        let lattice = Lattice { origin: [0.0, 0.0], span, intervals: size as u32 - 1 };
        let grid = Grid { lattice, col: 0, row: 0, cols: size, rows: size };
        let (terrain, cancel) = (Terrain::default(), Cancel::default());
        let input = multifractal::Inputs { amplitude: None, roughness: None };
        let out = Node::run(&Multifractal::default(), &Context::bare(grid, &terrain, &cancel), input);
        Self { size, height: out.expect("runs").field.data().to_vec() }
    }

    fn surface(&self) -> Surface<'_> {
        Surface::new(self.size, self.size, 30.0, &self.height, Some(-200.0))
    }

    fn bench<T>(&self, bencher: Bencher<'_, '_>, run: impl Fn(&Surface<'_>) -> T) {
        let surface = self.surface();
        bencher.counter(ItemsCount::new(self.height.len())).bench_local(|| run(&surface));
    }
}

fn depressions(surface: &Surface<'_>) -> Depressions {
    Depressions::find(surface, &Work::default()).expect("nobody stops it")
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn fill(bencher: Bencher<'_, '_>, size: usize) {
    let work = Work::default();
    Land::new(size).bench(bencher, |surface| depressions(surface).filled(surface, &work));
}

#[divan::bench(args = SIZES, sample_count = 10)]
fn d8_with_area(bencher: Bencher<'_, '_>, size: usize) {
    let work = Work::default();
    Land::new(size).bench(bencher, |surface| {
        let tree = Tree::of(surface, &work).expect("nobody stops it");
        accumulate::count(&tree, |cell| surface.is_land(cell), &work)
    });
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn fill_with_a_slope(bencher: Bencher<'_, '_>, size: usize) {
    Land::new(size).bench(bencher, |surface| epsilon::fill(surface, 1e-3, &Work::default()));
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn cut(bencher: Bencher<'_, '_>, size: usize) {
    Land::new(size).bench(bencher, |surface| breach::cut(surface, None, &Work::default()));
}

#[divan::bench(args = SIZES, sample_count = 5)]
fn lakes(bencher: Bencher<'_, '_>, size: usize) {
    Land::new(size).bench(bencher, |surface| {
        Lakes::find(surface, &depressions(surface), Puddles::default(), &Work::default())
    });
}

fn spread(bencher: Bencher<'_, '_>, size: usize, rule: Rule) {
    let (land, work) = (Land::new(size), Work::default());
    let surface = land.surface();
    let found = depressions(&surface);
    let filled = found.filled(&surface, &work).expect("nobody stops it");
    let tree = found.into_tree(&surface, &work).expect("nobody stops it");
    land.bench(bencher, |surface| {
        Spread::new(*surface, &tree, &filled, rule).accumulate(vec![1.0; land.height.len()], &work)
    });
}

#[divan::bench(args = SIZES, sample_count = 3)]
fn area_by_d_infinity(bencher: Bencher<'_, '_>, size: usize) {
    spread(bencher, size, Rule::Infinity);
}

#[divan::bench(args = SIZES, sample_count = 3)]
fn area_by_mfd(bencher: Bencher<'_, '_>, size: usize) {
    spread(bencher, size, Rule::Slopes { exponent: 1.1 });
}
