//! Distances, and growing and shrinking by disks, against brute force.

use orograph::value::{Field, Grid, Quantity};
use serde_json::json;

use super::{case, ground, noise, window, world};

/// Squared distances by looking at every sample.
fn brute_distance(mask: &Field, grid: &Grid, limit: f64, set: impl Fn(f32) -> bool) -> Vec<f32> {
    let (cell, wide) = (grid.cell(), mask.grid());
    let mut sites = Vec::new();
    for r in wide.row..wide.row_end() {
        sites.extend((wide.col..wide.col_end()).filter(|&c| set(mask.at(c, r))).map(|c| (c, r)));
    }
    let nearest = |c: i64, r: i64| sites.iter().map(|s| (s.0 - c).pow(2) + (s.1 - r).pow(2)).min();
    let metres = |d: Option<i64>| d.map_or(limit, |d| ((d as f64).sqrt() * cell).min(limit)) as f32;
    let rows = grid.row..grid.row_end();
    rows.flat_map(|r| (grid.col..grid.col_end()).map(move |c| (c, r)))
        .map(|(c, r)| metres(nearest(c, r)))
        .collect()
}

#[test]
fn distances_are_those_of_brute_force() {
    let terrain = world();
    let grid = window(&terrain, 257, [33, 21], [50, 41]);
    for (limit, level) in [(100.0, 0.35), (400.0, 0.8), (60.0, 2.0), (8.0, 0.2), (40.0, -5.0)] {
        let blobs = move |_: &str, x: f64, y: f64| f32::from(u8::from(noise(x, y, 150.0, 3) > level));
        let mask = Field::from_fn(grid.grow_metres(limit), Quantity::Mask, |x, y| blobs("", x, y));
        let outside = brute_distance(&mask, &grid, limit, |m| m >= 0.5);
        let inside = brute_distance(&mask, &grid, limit, |m| m < 0.5);
        let run = |side: &str| {
            case("distance", json!({ "limit": limit, "side": side })).field(&terrain, grid, &blobs, "field")
        };
        assert_eq!(run("outside").data(), outside, "outside, limit {limit}, level {level}");
        assert_eq!(run("inside").data(), inside, "inside, limit {limit}, level {level}");
        let edge = |d: f32| if d < limit as f32 { d - 4.0 } else { d };
        let signed: Vec<_> =
            outside.iter().zip(&inside).map(|(&o, &i)| if o > 0.0 { edge(o) } else { -edge(i) }).collect();
        assert_eq!(run("signed").data(), signed, "signed, limit {limit}, level {level}");
    }
}

#[test]
fn falloffs_run_from_one_to_zero() {
    let terrain = world();
    let grid = window(&terrain, 257, [0, 0], [26, 1]);
    let dot = |_: &str, x: f64, y: f64| f32::from(u8::from(x == 0.0 && y == 0.0));
    for (shape, middle) in [("linear", 0.5), ("smooth", 0.5), ("concave", 0.25), ("convex", 0.75)] {
        let case = case("distance", json!({ "limit": 160.0, "shape": shape }));
        let falloff = case.field(&terrain, grid, &dot, "falloff");
        assert_eq!([0, 10, 20, 25].map(|i| falloff.data()[i]), [1.0, middle, 0.0, 0.0], "{shape}");
    }
}

fn brute_disk(field: &Field, grid: &Grid, radius: f64, largest: bool) -> Field {
    let cell = grid.cell();
    let n = (radius / cell).floor() as i64;
    let inside =
        |dc: i64, dr: i64| ((dc * dc + dr * dr) as f64) * cell * cell <= radius * radius * (1.0 + 1e-9);
    let disk: Vec<_> =
        (-n..=n).flat_map(|dr| (-n..=n).map(move |dc| (dc, dr))).filter(|&(c, r)| inside(c, r)).collect();
    let mut data = Vec::new();
    for r in grid.row..grid.row_end() {
        for c in grid.col..grid.col_end() {
            let around = disk.iter().map(|&(dc, dr)| field.at(c + dc, r + dr));
            data.push(if largest {
                around.fold(f32::MIN, f32::max)
            } else {
                around.fold(f32::MAX, f32::min)
            });
        }
    }
    Field::new(*grid, field.quantity(), data)
}

#[test]
fn disks_are_those_of_brute_force() {
    let terrain = world();
    let grid = window(&terrain, 257, [33, 21], [50, 71]);
    for radius in [0.0, 5.0, 8.0, 16.0, 40.0, 77.0, 130.0] {
        let n = (radius / 8.0f64).floor() as i64;
        let height = Field::from_fn(grid.grow_cells(2 * n), Quantity::Number, |x, y| ground("field", x, y));
        let run = |mode: &str| {
            case("expand", json!({ "mode": mode, "radius": radius })).field(&terrain, grid, &ground, "field")
        };
        let once = |largest| brute_disk(&height, &grid, radius, largest);
        let twice = |first| {
            brute_disk(&brute_disk(&height, &grid.grow_cells(n), radius, first), &grid, radius, !first)
        };
        assert_eq!(run("dilate"), once(true), "dilate {radius}");
        assert_eq!(run("erode"), once(false), "erode {radius}");
        assert_eq!(run("close"), twice(true), "close {radius}");
        assert_eq!(run("open"), twice(false), "open {radius}");
    }
}

#[test]
fn soft_edges_are_even_and_keep_plains() {
    let terrain = world();
    let grid = window(&terrain, 257, [0, 0], [80, 3]);
    let step = |_: &str, x: f64, _: f64| f32::from(u8::from(x >= 320.0));
    let soft = case("expand", json!({ "radius": 40.0, "soft": 80.0 })).field(&terrain, grid, &step, "field");
    let row = soft.row(1);
    // The edge moved 40 m west, to lie between columns 34 and 35.
    assert!((row[34] + row[35] - 1.0).abs() < 1e-6, "{} {}", row[34], row[35]);
    assert_eq!([row[20], row[24], row[45], row[60]], [0.0, 0.0, 1.0, 1.0]);
    assert!(row.windows(2).all(|w| w[1] >= w[0]), "rising");
    let plain = |_: &str, _: f64, _: f64| 0.1;
    let soft = case("expand", json!({ "radius": 40.0, "soft": 80.0 })).field(&terrain, grid, &plain, "field");
    assert!(soft.data().iter().all(|&v| v == 0.1));
}
