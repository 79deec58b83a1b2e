//! Land that rises and wears: the whole ladder of levels up to a base grid.

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::kit::erosion::Level;
use orograph::kit::erosion::{stream_power, thermal};
use orograph::kit::hash;
use orograph::value::{Field, Grid, Quantity, Terrain};
use orograph::work::Work;

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
