//! The kinds that follow water over a land.

use orograph::ports::Wires;
use orograph::value::{
    Colors, Curves, Field, Grid, Quantity, Raster, Ridges, Rivers, Terrain, Value, Vectors,
};
use serde_json::{Value as Json, json};

use crate::rig::bench::Bench;

const SEA: f64 = 5.0;

fn terrain() -> Terrain {
    Terrain { width: 1280.0, depth: 960.0, base: 65, sea_level: Some(SEA), ..Terrain::default() }
}

/// Hills with hollows, over a sea in the west.
fn height(x: f64, y: f64) -> f64 {
    let wave =
        |x: f64, y: f64| libm::sin(x / 97.0) * libm::cos(y / 71.0) + 0.5 * libm::sin((x + 2.0 * y) / 53.0);
    0.06 * x + 9.0 * wave(x, y)
}

fn field(grid: &Grid, f: impl Fn(f64, f64) -> f64) -> Field {
    Raster::from_fn(*grid, Quantity::Elevation, |x, y| f(x, y) as f32)
}

fn run(kind: &str, set: &Json, at: Grid, inputs: &(dyn Fn(&str, &Grid) -> Option<Value> + Sync)) -> Wires {
    let bench = Bench::named(kind, set);
    bench.run(&terrain(), at, inputs).unwrap_or_else(|e| panic!("{kind} {set}: {e}"))
}

/// A kind that reads heights alone.
fn of_height(kind: &str, set: &Json, f: impl Fn(f64, f64) -> f64 + Sync) -> Wires {
    let inputs = |port: &str, grid: &Grid| (port == "height").then(|| Value::Field(field(grid, &f)));
    run(kind, set, terrain().base_grid(), &inputs)
}

fn take<T: orograph::ports::Wire>(wires: &mut Wires, port: &'static str) -> T {
    T::take(port, wires.take(port)).unwrap()
}

#[test]
fn fill_depressions_raises_or_cuts() {
    let before = field(&terrain().base_grid(), height);
    let after = |mode: Json| -> Field {
        take(&mut of_height("fill_depressions", &json!({ "mode": mode }), height), "height")
    };
    let changed = |after: &Field, up: bool| {
        let both = || after.data().iter().zip(before.data());
        assert!(both().all(|(a, b)| if up { a >= b } else { a <= b }));
        both().filter(|(a, b)| a != b).count()
    };
    let (fill, slope) = (after(json!("fill")), after(json!({ "slope": { "rise": 0.001 } })));
    let (cut, some) = (after(json!({ "breach": {} })), after(json!({ "breach": { "deepest": 0.5 } })));
    assert!(changed(&fill, true) > 100 && changed(&slope, true) >= changed(&fill, true));
    assert!(changed(&cut, false) > 20);
    assert!(some.data().iter().zip(before.data()).any(|(a, b)| a > b), "what is deeper is filled");
    assert_eq!(fill.quantity(), Quantity::Elevation);
}

#[test]
fn water_stands_in_lakes_and_ends_at_the_dam() {
    let mut lakes = of_height("lakes", &json!({ "smallest": 0, "shallowest": 0 }), height);
    let (level, label): (Field, Field) = (take(&mut lakes, "level"), take(&mut lakes, "label"));
    let fill: Field = take(&mut of_height("fill_depressions", &json!({}), height), "height");
    let base = terrain().base_grid();
    let inputs = |port: &str, grid: &Grid| {
        Some(Value::Field(match port {
            "height" => field(grid, height),
            "level" => level.clone(),
            _ => label.clone(),
        }))
    };
    let mut water = run("water_depth", &json!({}), base, &inputs);
    let (depth, mask): (Field, Field) = (take(&mut water, "depth"), take(&mut water, "water"));
    let ground = field(&base, height);
    for (i, (&depth, &mask)) in depth.data().iter().zip(mask.data()).enumerate() {
        assert_eq!(depth, fill.data()[i] - ground.data()[i], "sample {i}");
        assert_eq!(mask, f32::from(u8::from(depth > 0.0)));
    }
    assert!(depth.range().unwrap().1 > 0.5);
    let few: Field =
        take(&mut of_height("lakes", &json!({ "smallest": 2000, "shallowest": 0.2 }), height), "label");
    assert!(few.range().unwrap().1 < label.range().unwrap().1 && few.range().unwrap().1 > 0.0);
}

#[test]
fn flow_routing_sends_all_rain_to_the_outlets() {
    let base = terrain().base_grid();
    let land = field(&base, height).data().iter().filter(|&&z| z > SEA as f32).count() as f64;
    let cell = base.cell() * base.cell();
    for method in [json!("d8"), json!("d_infinity"), json!({ "mfd": { "exponent": 1.1 } })] {
        let inputs = |port: &str, grid: &Grid| {
            Some(Value::Field(match port {
                "height" => field(grid, height),
                _ => Field::constant(*grid, Quantity::Number, 0.5),
            }))
        };
        let mut out = run("flow_routing", &json!({ "method": method, "rain": 36 }), base, &inputs);
        let (area, flow, distance): (Field, Field, Field) =
            (take(&mut out, "area"), take(&mut out, "flow"), take(&mut out, "distance"));
        let direction: Vectors = take(&mut out, "direction");
        let ends: Vec<usize> = (0..base.len()).filter(|&i| direction.data()[i] == [0.0; 2]).collect();
        let sum = |of: &Field| ends.iter().map(|&i| f64::from(of.data()[i])).sum::<f64>();
        assert!((sum(&area) / (land * cell) - 1.0).abs() < 1e-5, "{method}: {}", sum(&area));
        // 36 mm/h are 1e-5 m/s, and half of it runs off.
        assert!((sum(&flow) / (land * cell * 0.5e-5) - 1.0).abs() < 1e-5, "{method}: {}", sum(&flow));
        assert!(ends.iter().all(|&i| distance.data()[i] == 0.0));
        assert!(direction.data().iter().all(|[x, y]| {
            let length = libm::hypotf(*x, *y);
            length == 0.0 || (length - 1.0).abs() < 1e-5
        }));
        assert!(distance.range().unwrap().1 > 500.0);
    }
}

#[test]
fn watersheds_part_the_land_and_their_boundaries_show_it() {
    let mut out = of_height("watersheds", &json!({}), height);
    let (label, edge): (Field, Field) = (take(&mut out, "label"), take(&mut out, "boundaries"));
    let colors: Colors = take(&mut out, "colors");
    let (base, ground) = (terrain().base_grid(), field(&terrain().base_grid(), height));
    let count = label.range().unwrap().1;
    assert!(count > 3.0);
    for i in 0..base.len() {
        let (col, row) = ((i % base.cols) as i64, (i / base.cols) as i64);
        assert_eq!(label.data()[i] > 0.0, ground.data()[i] > SEA as f32);
        assert_eq!(colors.data()[i] == [0.0; 3], label.data()[i] == 0.0);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let parted = around.into_iter().any(|(dx, dy)| label.at(col + dx, row + dy) != label.data()[i]);
        assert_eq!(edge.data()[i] == 1.0, parted && label.data()[i] > 0.0);
    }
}

#[test]
fn wetness_is_high_in_valleys_and_nothing_stands_over_its_river_there() {
    // A valley that falls to the west, along the middle.
    let valley = |x: f64, y: f64| 20.0 + 0.02 * x + 0.3 * (y - 480.0).abs();
    let mut out = of_height("wetness", &json!({ "threshold": 50_000 }), valley);
    let (index, above): (Field, Field) = (take(&mut out, "index"), take(&mut out, "above_river"));
    assert!(index.at(10, 24) > 3.0 + index.at(10, 10), "{} {}", index.at(10, 24), index.at(10, 10));
    assert_eq!(above.at(10, 24), 0.0);
    let side = above.at(30, 8);
    assert!((side - 0.3 * 16.0 * 20.0).abs() < 10.0, "{side}");
}

#[test]
fn extracted_rivers_stand_where_enough_land_drains() {
    let mut out = of_height("extract_rivers", &json!({ "threshold": 20_000, "smoothing": 0 }), height);
    let (rivers, mask): (Rivers, Field) = (take(&mut out, "rivers"), take(&mut out, "mask"));
    let base = terrain().base_grid();
    assert!(rivers.len() > 100 && rivers.outlets().count() > 2);
    let mut on_land = 0;
    for vertex in rivers.vertices() {
        let [col, row] = base.nearest(vertex.at);
        let masked = mask.row(row)[col] == 1.0;
        assert!(masked || vertex.down.is_none(), "only mouths may lie in the sea");
        on_land += usize::from(masked);
        let wanted = 2.5 * (f64::from(vertex.area) * 1e-6).sqrt();
        assert!((f64::from(vertex.width) - wanted).abs() < 1e-3);
    }
    assert!(on_land.abs_diff(mask.data().iter().filter(|&&m| m == 1.0).count()) < 5);
    for (upper, lower) in rivers.links() {
        let [upper, lower] = [upper, lower].map(|i| rivers.vertices()[i]);
        assert!(lower.height <= upper.height && lower.area >= upper.area);
    }
}

#[test]
fn extracted_ridges_run_along_the_top_of_a_roof() {
    let roof = |_: f64, y: f64| 300.0 - 0.4 * (y - 480.0).abs();
    let mut out = of_height("extract_ridges", &json!({ "threshold": 20_000 }), roof);
    let (ridges, mask): (Ridges, Field) = (take(&mut out, "ridges"), take(&mut out, "mask"));
    assert!(!ridges.is_empty());
    for vertex in ridges.vertices() {
        assert!((vertex.at[1] - 480.0).abs() < 1.0 && (vertex.height - 300.0).abs() < 0.01, "{vertex:?}");
    }
    assert!(mask.row(24).iter().filter(|&&m| m == 1.0).count() > 40);
}

#[test]
fn curves_from_rivers_come_back_as_rivers() {
    let mut out = of_height("extract_rivers", &json!({ "threshold": 30_000 }), height);
    let rivers: Rivers = take(&mut out, "rivers");
    let base = terrain().base_grid();
    let given = |_: &str, _: &Grid| Some(Value::from(rivers.clone()));
    let mut out = run("curves_from_rivers", &json!({ "tolerance": 0.1 }), base, &given);
    let curves: Curves = take(&mut out, "curves");
    assert!(curves.iter().all(|curve| curve.height(0.0) >= curve.height(1.0)));
    let given = |_: &str, _: &Grid| Some(Value::from(curves.clone()));
    let mut out = run("rivers_from_curves", &json!({ "snap": 0.5, "tolerance": 0.05 }), base, &given);
    let back: Rivers = take(&mut out, "rivers");
    let length = |rivers: &Rivers| {
        rivers
            .links()
            .map(|(a, b)| {
                let [a, b] = [a, b].map(|i| rivers.vertices()[i].at);
                libm::hypot(a[0] - b[0], a[1] - b[1])
            })
            .sum::<f64>()
    };
    assert!((length(&back) / length(&rivers) - 1.0).abs() < 0.02, "{} {}", length(&back), length(&rivers));
    assert_eq!(back.outlets().count(), rivers.outlets().count());
    let order = |rivers: &Rivers| rivers.vertices().iter().map(|v| v.order).max();
    assert_eq!(order(&back), order(&rivers));
    let none = |_: &str, _: &Grid| Some(Value::from(Rivers::default()));
    let mut out = run("curves_from_rivers", &json!({}), base, &none);
    assert!(take::<Curves>(&mut out, "curves").is_empty());
}
