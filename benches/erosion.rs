//! Land that rises and wears: the whole ladder of levels up to a base grid.

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::kit::erosion::Level;
use orograph::kit::erosion::hydraulic::{self, Run, Settings, Site, State};
use orograph::kit::erosion::{stream_power, thermal};
use orograph::kit::hash;
use orograph::kit::noise::{Form, Fractal, Spectrum};
use orograph::value::{Field, Grid, Quantity, Terrain};
use orograph::work::Work;
use rayon::prelude::*;

fn main() {
    divan::main();
}

fn grid(size: u32) -> Grid {
    let terrain = Terrain { width: 15_360.0, depth: 15_360.0, ..Terrain::default() };
    terrain.grid(size).expect("a size")
}

#[divan::bench(args = [257, 513, 1025], sample_count = 3)]
fn rise(bencher: Bencher<'_, '_>, size: u32) {
    let base = Level::of(&grid(size));
    let land = stream_power::Land {
        height: None,
        uplift: None,
        erodibility: None,
        mask: None,
        sea: None,
        base: &base,
    };
    let settings = stream_power::Settings {
        years: 4e6,
        uplift: 1e-3,
        erodibility: stream_power::Erodibility::ForRelief(1000.0),
        exponent: 0.5,
        steepest: 0.9,
        creep: 1e-3,
        variety: 1.5,
        bodies: 2000.0,
        seed: 1,
    };
    let steps = stream_power::cell_steps(&base) as usize;
    bencher
        .counter(ItemsCount::new(steps))
        .bench_local(|| stream_power::erode(&land, &settings, &mut |_| (), &Work::default()).is_ok());
}

#[divan::bench(args = [257, 513], sample_count = 3)]
fn slip(bencher: Bencher<'_, '_>, size: u32) {
    let grid = grid(size);
    let height = (0..grid.len()).map(|k| hash::unit(1, k as u64) as f32 * 100.0).collect();
    let height = Field::new(grid, Quantity::Elevation, height);
    let land = thermal::Land {
        height: &height,
        loose: None,
        rock: (1.0, None),
        rubble: (0.6, None),
        mask: None,
        steps: 100,
    };
    let steps = grid.len() * land.steps;
    bencher.counter(ItemsCount::new(steps)).bench_local(|| thermal::slip(&land, &Work::default()).is_ok());
}

/// Rough land on which water runs.
fn wet(size: usize) -> Run {
    let cell = 15.0;
    let height = |k: usize| {
        let (x, y) = ((k % size) as f64, (k / size) as f64);
        let swell = 40.0 * libm::sin(0.3 * x + 0.7 * y) - y;
        (800.0 + swell + hash::unit(1, k as u64)) as f32
    };
    let mut site = Site::new(size, size, cell, (0..size * size).map(height).collect());
    site.rain = vec![1.4e-5; size * size];
    site.open = true;
    let settings = Settings::default();
    let state = State::of(&site);
    let mut run = Run::new(site, state, &settings, settings.longest_step(cell));
    (0..30).for_each(|_| run.step(&Work::default()).expect("nobody stops it"));
    run
}

/// A step of water of eight pipes; the bar is four times `copy_of_state`.
#[divan::bench(args = [257, 513, 1025])]
fn step(bencher: Bencher<'_, '_>, size: usize) {
    let mut run = wet(size);
    bencher.counter(ItemsCount::new(size * size)).bench_local(|| run.step(&Work::default()).is_ok());
}

/// Eight numbers a cell, read and written by all threads.
#[divan::bench(args = [257, 513, 1025])]
fn copy_of_state(bencher: Bencher<'_, '_>, size: usize) {
    let from = vec![1.0f32; 8 * size * size];
    let mut to = vec![0.0f32; from.len()];
    bencher.counter(ItemsCount::new(size * size)).bench_local(|| {
        let rows = to.par_chunks_mut(64 * size).zip(from.par_chunks(64 * size));
        rows.for_each(|(to, from)| to.copy_from_slice(from));
    });
}

/// Four hours of rain on a mountain, the whole ladder of levels.
#[divan::bench(args = [129, 513, 1025], sample_count = 3)]
fn rain(bencher: Bencher<'_, '_>, size: u32) {
    let terrain = Terrain { width: 10_240.0, depth: 10_240.0, ..Terrain::default() };
    let grid = terrain.grid(size).expect("a size");
    let spectrum = Spectrum { feature_size: 3400.0, octaves: 9, lacunarity: 2.0, gain: 0.5 };
    let noise = Fractal::new(Form::Fbm, spectrum, 7, 0.0, 1200.0);
    let over = noise.over(&grid.xs());
    let mut height = vec![0.0; grid.len()];
    for (j, row) in height.chunks_exact_mut(grid.cols).enumerate() {
        over.row(grid.y(j), row);
    }
    let height = Field::new(grid, Quantity::Elevation, height);
    let land = hydraulic::Land {
        height: &height,
        moisture: None,
        sources: None,
        temperature: None,
        hardness: None,
        loose: None,
        mask: None,
        sea: None,
        base: Level::of(&grid),
    };
    let settings = Settings { hours: 4.0, ..Settings::default() };
    let steps = hydraulic::cell_steps(&land.base, &settings) as usize;
    bencher
        .counter(ItemsCount::new(steps))
        .bench_local(|| hydraulic::erode(&land, &settings, &mut |_| (), &Work::default()).is_ok());
}
