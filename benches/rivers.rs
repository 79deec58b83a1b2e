//! Networks and ridges of the sizes of Table 3 \[zhang2016\] and of a million vertices.

use divan::Bencher;
use divan::counter::ItemsCount;
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::grow::{Growth, Line};
use orograph::kit::rivers::infill::Infill;
use orograph::kit::rivers::ridges::{Heights, ridges};
use orograph::kit::rivers::{drainage, profile};
use orograph::value::{Bounds, RiverVertex, Rivers};
use orograph::work::Work;

const SIDE: f64 = 16_384.0;
const SQUARE: Bounds = Bounds { min: [0.0; 2], max: [SIDE; 2] };
const LINE: Line = Line { from: [SIDE / 2.0, SIDE], to: [SIDE / 2.0, 0.08 * SIDE] };

/// Depths whose networks have about the vertices of Table 3 for 1024² and 2048², and a hundred thousand and more.
const DEPTHS: [u32; 3] = [7, 8, 10];
/// Spacings that give about 2,000, 12,000, 100,000 and a million vertices.
const SPACINGS: [f64; 4] = [400.0, 153.0, 52.5, 16.5];

fn main() {
    divan::main();
}

fn growth(max_depth: u32) -> Growth<'static> {
    Growth {
        bounds: SQUARE,
        branching: Branching::Generator(2),
        max_depth,
        angle: 35_f64.to_radians(),
        lengthen: 0.0,
        wander: 0.12,
        clearance: 0.38,
        seed: 1,
        is_land: &|_| true,
    }
}

fn network(max_depth: u32) -> Vec<RiverVertex> {
    let grown = growth(max_depth).grow(&[LINE], &Work::default()).expect("nobody stops it");
    grown.vertices().expect("a network")
}

fn filled(spacing: f64) -> Vec<RiverVertex> {
    let infill = Infill { bounds: SQUARE, spacing, rim: 0.03, seed: 1 };
    let filled = infill.fill(&network(6), &Work::default()).expect("nobody stops it");
    let mut vertices = Rivers::new(filled.vertices).expect("a network").vertices().to_vec();
    drainage::drain(&mut vertices, SQUARE, 2.5, &Work::default()).expect("nobody stops it");
    profile::rise(&mut vertices, profile::Rise::Concave { concavity: 0.45, relief: 900.0 });
    vertices
}

#[divan::bench(args = DEPTHS)]
fn grow(bencher: Bencher<'_, '_>, depth: u32) {
    bencher.counter(ItemsCount::new(network(depth).len())).bench(|| network(depth));
}

#[divan::bench(args = SPACINGS, max_time = 10)]
fn infill(bencher: Bencher<'_, '_>, spacing: f64) {
    let (rivers, infill) = (network(6), Infill { bounds: SQUARE, spacing, rim: 0.03, seed: 1 });
    let fill = || infill.fill(&rivers, &Work::default()).expect("nobody stops it").vertices.len();
    bencher.counter(ItemsCount::new(fill())).bench(fill);
}

#[divan::bench(args = SPACINGS, max_time = 10)]
fn heights(bencher: Bencher<'_, '_>, spacing: f64) {
    let vertices = filled(spacing);
    bencher.counter(ItemsCount::new(vertices.len())).bench(|| {
        let mut vertices = vertices.clone();
        profile::limit_sides(&mut vertices, 0.6, &Work::default()).expect("nobody stops it");
        vertices
    });
}

#[divan::bench(args = SPACINGS, max_time = 10)]
fn to_ridges(bencher: Bencher<'_, '_>, spacing: f64) {
    let vertices = filled(spacing);
    let heights = Heights { rise: 0.5, reach: 600.0, rounds: 2, detour: 1.3 };
    bencher
        .counter(ItemsCount::new(vertices.len()))
        .bench(|| ridges(&vertices, SQUARE, heights, &Work::default()).expect("nobody stops it").edges.len());
}
