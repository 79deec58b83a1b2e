//! Occlusion, the share of the sky that the ground sees.

use std::f64::consts::TAU;

use orograph::node::Load;
use orograph::value::{Grid, Terrain};
use serde_json::{Value as Json, json};

use super::{Case, Source, case, ground, noise, same, window, world};

/// Skies near and far, coarse and fine.
fn skies() -> Vec<Case> {
    vec![
        case("occlusion", json!({ "radius": 300.0 })),
        case("occlusion", json!({ "radius": 120.0, "directions": 11, "detail": 3.0 })),
        case("occlusion", json!({ "radius": 1000.0, "directions": 4, "detail": 40.0 })),
    ]
}

/// Skies whose far ground leaves the terrain, is coarse, or is near as well.
fn far_cases() -> Vec<Case> {
    vec![
        case("occlusion", json!({ "radius": 1900.0, "directions": 7 })),
        case("occlusion", json!({ "radius": 700.0, "directions": 9, "detail": 21.0 })),
        case("occlusion", json!({ "radius": 20_000.0, "directions": 5, "detail": 0.7 })),
    ]
}

#[test]
fn sky_in_tiles_equals_the_whole_at_sizes_above_and_below_the_base_grid() {
    let terrain = world();
    for case in skies().into_iter().chain(far_cases()) {
        // Twice and four times as coarse as the base grid, between the two, and finer by whole and odd factors.
        for size in [65u32, 129, 177, 257, 301, 513, 1153] {
            let n = i64::from(size);
            let cut = |k: i64, parts: i64| (n - 1) * k / parts;
            let strip = window(&terrain, size, [0, cut(2, 7)], [size as usize, 5]);
            let whole = case.run(&terrain, strip, &ground);
            for (col, cols, row, rows) in
                [(0, 9, 0, 5), (cut(1, 3), 31, 1, 2), (n - 8, 8, 2, 3), (cut(1, 2), 1, 4, 1)]
            {
                let tile = window(&terrain, size, [col, strip.row + row], [cols, rows]);
                same(&case.0.label, &case.run(&terrain, tile, &ground), &whole, &tile);
            }
        }
    }
}

#[test]
fn sky_reads_no_more_at_larger_builds() {
    let terrain = Terrain::default();
    let case = case("occlusion", json!({ "radius": 1200.0 }));
    let read = |size: u32| {
        let whole = terrain.grid(size).unwrap();
        let middle = i64::from(size / 2);
        let tile = Grid { col: middle, row: middle, cols: 129, rows: 129, ..whole };
        let near = case.0.node.footprint("height", &tile, &terrain);
        let far = case.0.node.views("height", &tile, &terrain);
        let cost = case.0.node.cost(&Load::on(tile, &terrain));
        (near.len(), far.iter().map(Grid::len).sum::<usize>(), cost.bytes)
    };
    let ((near, far, bytes), (_, far_before, _)) = (read(16_385), read(2049));
    assert!(near <= 360 * 360, "{near} samples near by, of which 7 base cells are 112 to a side");
    assert!(far <= far_before, "{far} samples far off, {far_before} at 2049");
    assert!(bytes < 16 << 20, "{bytes} bytes");
}

#[test]
fn sky_over_simple_ground_has_its_closed_form() {
    let terrain = world();
    let grid = window(&terrain, 257, [128, 128], [1, 1]);
    let (cx, cy) = (grid.x(0), grid.y(0));
    let seen = |set: Json, surface: &Source| {
        f64::from(case("occlusion", set).field(&terrain, grid, surface, "visibility").data()[0])
    };
    assert_eq!(seen(json!({}), &|_, _, _| 431.7), 1.0, "a plain sees all");
    let peak = move |_: &str, x: f64, y: f64| (-0.5 * libm::hypot(x - cx, y - cy)) as f32;
    assert_eq!(seen(json!({}), &peak), 1.0, "a peak sees all");
    // At the bottom of a cone every horizon is its slope; between samples, straight lines pass above a cone.
    let pit = move |_: &str, x: f64, y: f64| (0.75 * libm::hypot(x - cx, y - cy)) as f32;
    for (directions, tolerance) in [(8, 0.002), (16, 0.02), (32, 0.02)] {
        let found = seen(json!({ "directions": directions }), &pit);
        assert!((found - (1.0 - 0.6)).abs() < tolerance, "a pit in {directions}: {found}");
    }
    // Halving the heights is what an exaggeration of ½ does.
    let found = seen(json!({ "directions": 8, "exaggeration": 0.5 }), &pit);
    assert!((found - (1.0 - 0.375 / libm::sqrt(1.0 + 0.375 * 0.375))).abs() < 0.005, "{found}");
    // On a slope, uphill directions see the slope times the cosine.
    let slope = |_: &str, x: f64, _: f64| (0.6 * x) as f32;
    let count = 16;
    let sum: f64 = (0..count)
        .map(|i| (0.6 * libm::cos(TAU * f64::from(i) / f64::from(count))).max(0.0))
        .map(|tangent| tangent / libm::sqrt(1.0 + tangent * tangent))
        .sum();
    let found = seen(json!({ "directions": count }), &slope);
    assert!((found - (1.0 - sum / f64::from(count))).abs() < 1e-4, "a slope: {found}");
}

#[test]
fn sky_agrees_with_a_dense_march() {
    let terrain = world();
    let grid = window(&terrain, 257, [60, 60], [14, 14]);
    let height = |x: f64, y: f64| 200.0 * noise(x, y, 400.0, 4);
    let surface = move |_: &str, x: f64, y: f64| height(x, y) as f32;
    let (radius, count) = (400.0, 64);
    let set = json!({ "radius": radius, "directions": 32 });
    let found = case("occlusion", set).field(&terrain, grid, &surface, "visibility");
    let (mut worst, mut mean) = (0.0f64, 0.0);
    for (i, &found) in found.data().iter().enumerate() {
        let (x, y) = (grid.x(i % 14), grid.y(i / 14));
        let hidden: f64 = (0..count)
            .map(|d| {
                let angle = TAU * f64::from(d) / f64::from(count);
                let tangent = (1..200).map(|s| 8.0 + f64::from(s - 1) * 2.0).filter(|&r| r < radius).fold(
                    0.0f64,
                    |t, r| {
                        let u = (2.0 * r / radius - 1.0).clamp(0.0, 1.0);
                        let fade = 1.0 - u * u * (3.0 - 2.0 * u);
                        let rise = height(x + r * libm::cos(angle), y + r * libm::sin(angle)) - height(x, y);
                        t.max(fade * rise / r)
                    },
                );
                tangent / libm::sqrt(1.0 + tangent * tangent)
            })
            .sum();
        let error = f64::from(found) - (1.0 - hidden / f64::from(count));
        worst = worst.max(error.abs());
        mean += error / grid.len() as f64;
    }
    assert!(worst < 0.04 && mean.abs() < 0.015, "worst {worst}, mean {mean}");
}
