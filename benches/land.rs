//! From a skeleton to land, and a block of land in other land, as in Table 3 of \[zhang2016\]: as many rivers and ridges,
//! on grids of the same sizes.

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::kit::hash;
use orograph::kit::land::carve::Carving;
use orograph::kit::land::{Bits, Enrichment, Feature, Line, Skeleton, WideLine, enrich};
use orograph::kit::poisson::{Blend, Gradients};
use orograph::value::{Field, Grid, Quantity, Terrain};
use orograph::work::Work;

/// Samples along a side, with the river nodes and the ridges that the paper has there.
const TABLE: [(usize, usize, usize); 2] = [(1024, 2_033, 5_968), (2048, 12_267, 33_291)];

fn main() {
    divan::main();
}

fn grid(size: usize) -> Grid {
    let terrain = Terrain { width: 16_384.0, depth: 16_384.0, ..Terrain::default() };
    terrain.grid(size as u32).expect("a size")
}

/// So many short lines, spread evenly at random: each joins two neighbours of a jittered square pattern.
fn lines(count: usize, width: f64, seed: u64) -> Vec<Line> {
    let side = (count as f64).sqrt().ceil() as usize;
    let pitch = width / side as f64;
    let point = |i: usize, j: usize| {
        let shake = |k: u64| 0.8 * hash::unit(seed, (j * (side + 1) + i) as u64 * 2 + k);
        [(i as f64 + shake(0)) * pitch, (j as f64 + shake(1)) * pitch]
    };
    let one = |k: usize| {
        let (i, j) = (k % side, k / side);
        let to = if hash::nth(seed, k as u64) & 1 == 0 { point(i + 1, j) } else { point(i, j + 1) };
        Line { ends: [point(i, j), to], heights: [i as f64, i as f64 + 5.0] }
    };
    (0..count).map(one).collect()
}

struct Scene {
    grid: Grid,
    rivers: Vec<Line>,
    ridges: Vec<Line>,
}

impl Scene {
    fn of((size, nodes, edges): (usize, usize, usize)) -> Self {
        let grid = grid(size);
        let width = grid.bounds().width();
        Self { grid, rivers: lines(nodes, width, 1), ridges: lines(edges, width, 2) }
    }

    fn draw(&self, skeleton: &mut Skeleton) {
        let work = Work::default();
        skeleton.rivers(&work, self.rivers.iter().copied()).expect("nobody stops it");
        skeleton.ridges(&work, self.ridges.iter().copied()).expect("nobody stops it");
    }
}

#[divan::bench(args = TABLE)]
fn raster_into_a_ready_buffer(bencher: Bencher<'_, '_>, size: (usize, usize, usize)) {
    let scene = Scene::of(size);
    let mut skeleton = Skeleton::new(scene.grid);
    scene.draw(&mut skeleton);
    bencher.counter(ItemsCount::new(size.1 + size.2)).bench_local(|| scene.draw(&mut skeleton));
}

#[divan::bench(args = TABLE)]
fn enrichment(bencher: Bencher<'_, '_>, size: (usize, usize, usize)) {
    let scene = Scene::of(size);
    let mut skeleton = Skeleton::new(scene.grid);
    scene.draw(&mut skeleton);
    let known = Bits::of(scene.grid.cols, &skeleton.features, |f| *f != Feature::Open);
    let how = Enrichment { rounds: 3, limit: 8.0, displacement: 0.2, seed: 1 };
    bencher
        .with_inputs(|| (skeleton.height.clone(), known.clone()))
        .bench_local_values(|(height, known)| enrich(scene.grid.cols, height, known, &how, &Work::default()));
}

/// Rough ground.
fn ground(grid: &Grid, seed: u64) -> Vec<f32> {
    (0..grid.len()).map(|k| hash::unit(seed, k as u64) as f32 * 300.0).collect()
}

fn blend(bencher: Bencher<'_, '_>, size: usize, gradients: Gradients) {
    let grid = grid(size);
    let (source, reference) = (ground(&grid, 1), ground(&grid, 2));
    // A disc of half the width.
    let inside = |k: usize| {
        let far = |v: usize| {
            let off = v as f64 / size as f64 - 0.5;
            off * off
        };
        far(k % size) + far(k / size) < 0.0625
    };
    let mask: Vec<f32> = (0..grid.len()).map(|k| f32::from(u8::from(inside(k)))).collect();
    let (cols, rows) = (grid.cols, grid.rows);
    let blend =
        Blend { cols, rows, source: &source, reference: &reference, mask: &mask, gain: 1.0, gradients };
    bencher.counter(ItemsCount::new(grid.len())).bench_local(|| blend.run(&Work::default()));
}

#[divan::bench(args = [1024, 2048], sample_count = 10)]
fn blend_a_disc(bencher: Bencher<'_, '_>, size: usize) {
    blend(bencher, size, Gradients::Reference);
}

#[divan::bench(args = [1024, 2048], sample_count = 10)]
fn blend_a_disc_of_mixed_gradients(bencher: Bencher<'_, '_>, size: usize) {
    blend(bencher, size, Gradients::Mixed);
}

#[divan::bench(args = [2048, 4096], sample_count = 10)]
fn carve(bencher: Bencher<'_, '_>, size: usize) {
    let grid = grid(size);
    let link = |line: Line| WideLine { line, width: 12.0, order: 1 };
    let wide: Vec<WideLine> = lines(12_267, grid.bounds().width(), 1).into_iter().map(link).collect();
    let land = Field::new(grid, Quantity::Elevation, ground(&grid, 3));
    let carving = Carving { cell: 8.0, rise: 0.5, reach: 80.0 };
    bencher
        .counter(ItemsCount::new(grid.len()))
        .bench_local(|| carving.carve(&Work::default(), &land, &grid, &wide));
}
