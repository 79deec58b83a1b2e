//! Ranges of masks and colours, and inputs that are refused.

use orograph::context::{Cancel, Context};
use orograph::nodes::Registry;
use orograph::value::{Grid, Lattice, Terrain};
use serde_json::{Value as Json, json};

use super::{case, ground, plane, window, world};

#[test]
fn masks_follow_their_ranges() {
    let terrain = world();
    let grid = window(&terrain, 257, [0, 0], [40, 1]);
    let ramp = |_: &str, x: f64, _: f64| x as f32;
    let mask = case("select_height", json!({ "low": 80.0, "high": 160.0, "soft": 32.0 }))
        .field(&terrain, grid, &ramp, "mask");
    for (h, want) in
        [(0, 0.0), (48, 0.0), (64, 0.5), (80, 1.0), (160, 1.0), (176, 0.5), (192, 0.0), (312, 0.0)]
    {
        assert_eq!(mask.data()[h / 8], want, "height {h}");
    }
    // A slope of 45° that faces west: chosen by the sector that wraps around, faded by steepness.
    let direction = |direction: f64, width: f64, soft: f64, steepness: f64| {
        let set = json!({ "direction": direction, "width": width, "soft": soft, "steepness": steepness });
        f64::from(case("select_aspect", set).field(&terrain, grid, &ramp, "mask").data()[20])
    };
    assert_eq!(direction(270.0, 10.0, 0.0, 0.0), 1.0);
    assert_eq!(direction(-90.0, 10.0, 0.0, 0.0), 1.0);
    assert_eq!(direction(0.0, 170.0, 0.0, 0.0), 0.0);
    assert!((direction(0.0, 170.0, 10.0, 0.0) - 0.5).abs() < 1e-3);
    assert!((direction(270.0, 10.0, 0.0, 90.0) - 0.5).abs() < 1e-3);
    let flat = |_: &str, _: f64, _: f64| 7.0;
    let faced = case("select_aspect", json!({ "width": 360.0 })).field(&terrain, grid, &flat, "mask");
    assert!(faced.data().iter().all(|&m| m == 0.0), "flat ground faces nowhere");
}

#[test]
fn ranges_that_are_turned_around_are_refused() {
    for (id, set) in [
        ("select_height", json!({ "low": 10.0, "high": 9.0 })),
        ("select_slope", json!({ "low": 10.0, "high": 9.0 })),
        ("select_curvature", json!({ "low": 0.2, "high": 0.1 })),
        ("colorize", json!({ "range": { "fixed": { "low": 5.0, "high": 5.0 } } })),
    ] {
        let kind = Registry::standard().find(id).cloned().unwrap();
        let error = kind.parse(set.as_object().unwrap()).unwrap_err().to_string();
        assert!(error.contains("low") && error.contains("high"), "{id}: {error}");
    }
}

#[test]
fn fields_on_another_lattice_are_refused() {
    let terrain = world();
    let tile = window(&terrain, 257, [10, 10], [20, 20]);
    let other = Lattice { intervals: 100, ..tile.lattice };
    for id in ["select_slope", "occlusion", "expand"] {
        let case = case(id, json!({}));
        let wires = case.0.inputs(&plane(&ground), &|_| Grid { lattice: other, ..tile });
        let cancel = Cancel::default();
        let error = case.0.node.run(&Context::bare(tile, &terrain, &cancel), wires).unwrap_err().to_string();
        assert!(error.contains("stands on"), "{id}: {error}");
    }
}

#[test]
fn colours_follow_the_ramp_the_range_and_the_shade() {
    let terrain = Terrain { width: 800.0, depth: 800.0, base: 101, ..Terrain::default() };
    let grid = window(&terrain, 101, [0, 0], [101, 1]);
    let source = |port: &str, x: f64, _: f64| if port == "field" { x as f32 } else { 0.5 };
    let colors = |set: Json| {
        case("colorize", set).run(&terrain, grid, &source).get("colors").unwrap().components().to_vec()
    };
    let grey = colors(json!({ "palette": "grey", "shading": 0.0 }));
    for i in 0..=100 {
        assert!((grey[3 * i] - i as f32 / 100.0).abs() < 1e-5, "the automatic range spans the terrain");
    }
    let shaded = colors(json!({ "palette": "grey" }));
    assert!((0..303).all(|i| (shaded[i] - 0.5 * grey[i]).abs() < 1e-6));
    let turned = colors(json!({ "palette": "grey", "shading": 0.0, "reverse": true }));
    assert!((0..=100).all(|i| (turned[3 * i] + grey[3 * i] - 1.0).abs() < 1e-5));
    let fixed = colors(
        json!({ "palette": "grey", "shading": 0.0, "range": { "fixed": { "low": 400.0, "high": 480.0 } } }),
    );
    assert_eq!([fixed[3 * 40], fixed[3 * 50], fixed[3 * 60], fixed[3 * 90]], [0.0, 0.0, 1.0, 1.0]);
    assert!((fixed[3 * 55] - 0.5).abs() < 1e-5);
    let own = colors(
        json!({ "palette": { "custom": { "stops": [[0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0]] } }, "shading": 0.0 }),
    );
    assert!((own[0] - 1.0).abs() < 1e-3 && own[1] < 1e-3 && (own[302] - 1.0).abs() < 1e-3);
}
