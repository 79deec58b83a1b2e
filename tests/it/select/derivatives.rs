//! Slope, aspect, curvature, normals and shade.

use std::f64::consts::TAU;

use orograph::ports::Wires;
use orograph::value::{Terrain, Value};
use serde_json::{Value as Json, json};

use super::{Source, case, ground, thinned, window, world};

#[test]
fn derivatives_pick_the_same_places_at_every_size() {
    let terrain = Terrain { base: 1025, ..Terrain::default() };
    let at = |size: u32, k: i64| {
        window(&terrain, size, [k * 90, k * 70], [(k * 40) as usize + 1, (k * 30) as usize + 1])
    };
    let (coarse, middle, fine) = (at(513, 1), at(1025, 2), at(2049, 4));
    for id in ["select_slope", "select_aspect", "select_curvature", "normals", "hillshade"] {
        let case = case(id, json!({}));
        let [coarse, middle, fine] = [coarse, middle, fine].map(|w| case.run(&terrain, w, &ground));
        for (port, value) in coarse.iter() {
            let want = thinned(value, 1);
            assert_eq!(want, thinned(middle.get(port).unwrap(), 2), "{id} `{port}` at 513 and 1025");
            assert_eq!(want, thinned(fine.get(port).unwrap(), 4), "{id} `{port}` at 513 and 2049");
        }
    }
    // What lies far is read between the same samples; only the last bits hang on the columns in between.
    for case in
        [case("occlusion", json!({ "radius": 150.0 })), case("occlusion", json!({ "radius": 2000.0 }))]
    {
        let [coarse, middle, fine] = [coarse, middle, fine].map(|w| case.run(&terrain, w, &ground));
        let seen = |wires: &Wires, step| {
            let values = thinned(wires.get("visibility").unwrap(), step);
            values.into_iter().map(f32::from_bits).collect::<Vec<_>>()
        };
        let want = seen(&middle, 2);
        assert!(want.iter().any(|v| *v < 0.9), "{}: all is seen", case.0.label);
        for other in [seen(&coarse, 1), seen(&fine, 4)] {
            let off = want.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(want.len() == other.len() && off < 2e-6, "{}: {off}", case.0.label);
        }
    }
}

#[test]
fn derivative_scales_between_samples_are_interpolated() {
    // On a smooth ground a slope over 20 m is the same whether 20 m is 2.5 or 5 cells or 1.25.
    let terrain = world();
    let wave = |_: &str, x: f64, y: f64| (30.0 * libm::sin(x / 60.0) * libm::cos(y / 80.0)) as f32;
    let case = case("select_slope", json!({ "scale": 20.0 }));
    let runs = [(129, 1), (257, 2), (513, 4)].map(|(size, k)| {
        let grid = window(&terrain, size, [20 * k, 30 * k], [(20 * k) as usize + 1, (20 * k) as usize + 1]);
        let slope = case.field(&terrain, grid, &wave, "slope");
        thinned(&Value::Field(slope), k as usize).into_iter().map(f32::from_bits).collect::<Vec<_>>()
    });
    for ((coarse, middle), fine) in runs[0].iter().zip(&runs[1]).zip(&runs[2]) {
        assert!((coarse - fine).abs() < 0.15, "{coarse} {fine}");
        assert!((middle - fine).abs() < 0.02, "{middle} {fine}");
    }
    // And it is the difference over 2 · 20 m, not the slope at the point.
    let grid = window(&terrain, 513, [80, 120], [1, 1]);
    let slope = case.field(&terrain, grid, &wave, "slope").data()[0];
    let (x, y) = (grid.x(0), grid.y(0));
    let over = |a: f32, b: f32| f64::from(a - b) / 40.0;
    let p = over(wave("", x + 20.0, y), wave("", x - 20.0, y));
    let q = over(wave("", x, y + 20.0), wave("", x, y - 20.0));
    assert!((f64::from(slope) - libm::atan(libm::hypot(p, q)).to_degrees()).abs() < 1e-4);
}

#[test]
fn derivatives_of_a_plane_are_exact() {
    let terrain = world();
    let grid = window(&terrain, 257, [40, 50], [9, 9]);
    for (p, q) in [(0.3, 0.1), (-0.5, 0.2), (0.0, -1.0), (-2.0, -0.7), (0.04, 0.0)] {
        let plane = move |_: &str, x: f64, y: f64| (p * (x - 400.0) + q * (y - 400.0)) as f32;
        let first = |id: &str, set: Json, port: &str| {
            let field = case(id, set).field(&terrain, grid, &plane, port);
            f64::from(field.data()[40])
        };
        let close = |found: f64, want: f64, what: &str| {
            assert!((found - want).abs() < 2e-4, "{what} {p} {q}: {found} {want}")
        };
        let g = libm::hypot(p, q);
        for scale in [json!(null), json!(30.0)] {
            close(
                first("select_slope", json!({ "scale": scale }), "slope"),
                libm::atan(g).to_degrees(),
                "slope",
            );
            let down = libm::atan2(-p, q).to_degrees().rem_euclid(360.0);
            close(first("select_aspect", json!({ "scale": scale }), "direction"), down, "direction");
        }
        close(first("select_curvature", json!({}), "curvature"), 0.0, "curvature");
        let (azimuth, altitude) = (250.0f64.to_radians(), 35.0f64.to_radians());
        let sun = [libm::sin(azimuth), -libm::cos(azimuth)].map(|v| v * libm::cos(altitude));
        let lambert = (libm::sin(altitude) - p * sun[0] - q * sun[1]) / libm::sqrt(1.0 + g * g);
        let shade = first("hillshade", json!({ "azimuth": 250.0, "altitude": 35.0 }), "shade");
        close(shade, lambert.max(0.0), "shade");
        let wires = case("normals", json!({})).run(&terrain, grid, &plane);
        let up = 1.0 / libm::sqrt(1.0 + g * g);
        let normal = &wires.get("vectors").unwrap().components()[80..82];
        close(f64::from(normal[0]), -p * up, "east");
        close(f64::from(normal[1]), -q * up, "south");
        let map = &wires.get("colors").unwrap().components()[120..123];
        close(f64::from(map[0]), 0.5 - 0.5 * p * up, "red");
        close(f64::from(map[1]), 0.5 + 0.5 * q * up, "green");
        close(f64::from(map[2]), 0.5 + 0.5 * up, "blue");
        let wires = case("normals", json!({ "green": "south" })).run(&terrain, grid, &plane);
        close(f64::from(wires.get("colors").unwrap().components()[121]), 0.5 - 0.5 * q * up, "green");
    }
}

#[test]
fn hillshade_from_four_sides_is_weighted_as_published() {
    // Mark's formula for one slope, written out with angles.
    let terrain = world();
    let grid = window(&terrain, 257, [40, 50], [3, 3]);
    for (p, q) in [(0.3, 0.1), (-0.5, 0.2), (0.0, -1.0)] {
        let plane = move |_: &str, x: f64, y: f64| (p * (x - 400.0) + q * (y - 400.0)) as f32;
        let found = case("hillshade", json!({ "light": "multiple" })).field(&terrain, grid, &plane, "shade");
        let slope = libm::atan(libm::hypot(p, q));
        let aspect = libm::atan2(-p, q);
        let sum: f64 = [225.0f64, 270.0, 315.0, 360.0]
            .map(|azimuth| {
                let off = aspect - azimuth.to_radians();
                let high = TAU / 8.0;
                let cosine =
                    libm::sin(high) * libm::cos(slope) + libm::cos(high) * libm::sin(slope) * libm::cos(off);
                libm::sin(off) * libm::sin(off) * cosine.max(0.0)
            })
            .iter()
            .sum();
        assert!((f64::from(found.data()[4]) - sum / 2.0).abs() < 1e-5, "{} {}", found.data()[4], sum / 2.0);
    }
}

#[test]
fn curvature_of_known_surfaces_is_exact() {
    let terrain = Terrain { width: 200.0, depth: 200.0, base: 401, ..Terrain::default() };
    let (cx, cy) = (100.0, 100.0);
    let at = |form: &str, surface: &Source, east: i64, south: i64| {
        let grid = window(&terrain, 401, [200 + east, 200 + south], [1, 1]);
        let field = case("select_curvature", json!({ "form": form, "scale": 2.0 })).field(
            &terrain,
            grid,
            surface,
            "curvature",
        );
        f64::from(field.data()[0])
    };
    let sphere = move |_: &str, x: f64, y: f64| {
        let r = libm::hypot(x - cx, y - cy);
        libm::sqrt((150.0f64 * 150.0 - r * r).max(0.0)) as f32
    };
    for (east, south) in [(40, 20), (-60, 90), (0, 100), (3, 0)] {
        for form in ["mean", "profile", "tangential"] {
            let found = at(form, &sphere, east, south);
            assert!((found - 1.0 / 150.0).abs() < 2e-5, "{form} of a sphere at {east} {south}: {found}");
        }
        // The contour is a circle of its own radius.
        let radius = 0.5 * libm::hypot(east as f64, south as f64);
        if radius > 20.0 {
            let found = at("plan", &sphere, east, south);
            assert!((found * radius - 1.0).abs() < 0.01, "plan at {radius} m: {found}");
        }
    }
    let cone = move |_: &str, x: f64, y: f64| (80.0 - 0.5 * libm::hypot(x - cx, y - cy)) as f32;
    let radius = 0.5 * libm::hypot(120.0, 90.0);
    assert!(at("profile", &cone, 120, 90).abs() < 2e-5, "a cone is straight downhill");
    let across = 0.5 / libm::sqrt(1.25) / radius;
    assert!((at("tangential", &cone, 120, 90) / across - 1.0).abs() < 0.01);
    assert!((at("mean", &cone, 120, 90) / (across / 2.0) - 1.0).abs() < 0.01);
    assert!((at("plan", &cone, 120, 90) * radius - 1.0).abs() < 0.01);
    let trough = move |_: &str, x: f64, _: f64| (0.01 * (x - cx) * (x - cx)) as f32;
    assert!((at("mean", &trough, 0, 30) + 0.01).abs() < 1e-5, "a valley is negative");
    let saddle = move |_: &str, x: f64, y: f64| (0.01 * (x - cx) * (y - cy)) as f32;
    // Twice the mixed derivative along the diagonal: the contour through (40, 40) bends outward there.
    let (p, s) = (0.2, 0.01);
    let along = -2.0 * p * p * s / (2.0 * p * p * (1.0 + 2.0 * p * p) * libm::sqrt(1.0 + 2.0 * p * p));
    assert!((at("profile", &saddle, 40, 40) - along).abs() < 2e-5);
}

#[test]
fn derivatives_of_a_wave_have_the_error_of_central_differences() {
    let terrain = world();
    let (length, high) = (300.0, 25.0);
    let wave = move |_: &str, x: f64, _: f64| (high * libm::sin(TAU * x / length)) as f32;
    let grid = window(&terrain, 257, [20, 60], [100, 1]);
    let slope = case("select_slope", json!({})).field(&terrain, grid, &wave, "slope");
    // (sin k(x+s) − sin k(x−s)) / 2s = k cos kx · sin(ks)/(ks).
    let k = TAU / length;
    let share = libm::sin(k * 8.0) / (k * 8.0);
    for (i, &found) in slope.data().iter().enumerate() {
        let exact = high * k * libm::cos(k * grid.x(i)) * share;
        assert!((f64::from(found) - libm::atan(exact.abs()).to_degrees()).abs() < 2e-3, "column {i}");
    }
}
