//! The select family against closed forms, brute force and the laws.

use std::f64::consts::TAU;

use orograph::context::{Cancel, Context};
use orograph::kit::hash;
use orograph::node::Load;
use orograph::nodes::Registry;
use orograph::ports::Wires;
use orograph::value::{Field, Grid, Lattice, Quantity, Terrain, Value};
use serde_json::{Value as Json, json};

use crate::rig::bench::Bench;

type Source = dyn Fn(&str, f64, f64) -> f32 + Sync;

/// A node of the family, on fields that are functions of the place.
struct Case(Bench);

fn case(id: &str, set: Json) -> Case {
    Case(Bench::named(id, &set))
}

/// Fields on every port.
fn plane<'a>(source: &'a Source) -> impl Fn(&str, &Grid) -> Option<Value> + Sync + 'a {
    |port, grid| Some(Value::Field(Field::from_fn(*grid, Quantity::Number, |x, y| source(port, x, y))))
}

impl Case {
    fn run(&self, terrain: &Terrain, window: Grid, source: &Source) -> Wires {
        let ran = self.0.run(terrain, window, &plane(source));
        ran.unwrap_or_else(|e| panic!("{}: {e}", self.0.label))
    }

    fn field(&self, terrain: &Terrain, window: Grid, source: &Source, port: &str) -> Field {
        self.0.field(terrain, window, &plane(source), port)
    }
}

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

/// A world 2 km wide with a base cell of 8 m.
fn world() -> Terrain {
    Terrain { width: 2048.0, depth: 2048.0, base: 257, ..Terrain::default() }
}

fn window(terrain: &Terrain, size: u32, [col, row]: [i64; 2], [cols, rows]: [usize; 2]) -> Grid {
    Grid { col, row, cols, rows, ..terrain.grid(size).expect("a size that fits") }
}

/// Value noise of some octaves, from about −1 to 1, from hashed lattice points.
fn noise(x: f64, y: f64, feature: f64, octaves: u32) -> f64 {
    let corner = |c: i64, r: i64, octave: u32| {
        2.0 * hash::unit(u64::from(octave), (c as u64).wrapping_mul(0x1_0000_0001) ^ (r as u64) << 20) - 1.0
    };
    let ease = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let octave = |o: u32| {
        let (u, v) = (x / feature * f64::from(1 << o) + 0.31, y / feature * f64::from(1 << o) + 0.17);
        let (c, r) = (u.floor() as i64, v.floor() as i64);
        let (s, t) = (ease(u - u.floor()), ease(v - v.floor()));
        let along = |r: i64| corner(c, r, o) * (1.0 - s) + corner(c + 1, r, o) * s;
        (along(r) * (1.0 - t) + along(r + 1) * t) / f64::from(1 << o)
    };
    (0..octaves).map(octave).sum()
}

/// A fractal ground, and masks and slopes to go with it.
fn ground(port: &str, x: f64, y: f64) -> f32 {
    let share = |v: f64| (0.5 + 0.6 * v).clamp(0.0, 1.0);
    (match port {
        "mask" => f64::from(noise(x + 900.0, y, 300.0, 3) > 0.35),
        "shade" => share(noise(x, y + 500.0, 100.0, 2)),
        "slope" => 45.0 * share(noise(x + 70.0, y, 200.0, 2)),
        _ => 150.0 + 180.0 * noise(x, y, 700.0, 6),
    }) as f32
}

fn same(label: &str, a: &Wires, b: &Wires, window: &Grid) {
    for (port, value) in a.iter() {
        let other = b.get(port).expect("the same ports").crop(window);
        let differs =
            value.components().iter().zip(other.components()).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(differs, None, "{label}: `{port}` on {window:?}");
        assert_eq!(value.components().len(), other.components().len());
    }
}

/// Every `step`-th sample of a raster.
fn thinned(value: &Value, step: usize) -> Vec<u32> {
    let (grid, parts) = (*value.grid().unwrap(), (value.wire_type().sample_bytes() / 4) as usize);
    let rows = value.components().chunks(grid.cols * parts).step_by(step);
    rows.flat_map(|row| row.chunks(parts).step_by(step).flatten().map(|v| v.to_bits())).collect()
}

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
fn the_sky_in_tiles_is_cut_from_the_whole_at_sizes_above_and_below_the_base_grid() {
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
fn what_the_sky_reads_does_not_grow_with_the_build() {
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
fn a_scale_between_samples_is_read_by_interpolation() {
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
fn a_plane_has_its_slope_direction_normal_and_shade() {
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
fn the_sun_from_four_sides_is_weighted_as_published() {
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
fn known_surfaces_have_their_curvature() {
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
fn a_wave_keeps_its_derivative_within_the_error_of_central_differences() {
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
fn a_field_on_another_lattice_is_an_error() {
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
fn a_soft_edge_is_even_and_keeps_plains() {
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

#[test]
fn the_sky_over_simple_ground_is_known() {
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
fn the_sky_agrees_with_a_dense_march() {
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
