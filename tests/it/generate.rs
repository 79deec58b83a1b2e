//! Tests of: generate.
//!
//! Here the laws, on every generator; in the modules the truth of each.

mod cellular;
mod fractal;
mod kernels;
mod nodes;
mod perlin;

use orograph::kit::noise::{Form, Fractal, Measure, Metric, lattice};
use orograph::node::Kind;
use orograph::nodes::Registry;
use orograph::ports::Wires;
use orograph::value::{Field, Grid, Terrain, Value};
use serde_json::{Map, Value as Json, json};
use std::sync::Arc;

use crate::rig::bench::Bench;
use crate::rig::sets;

fn kind(id: &str) -> Arc<Kind> {
    Registry::standard().find(id).cloned().expect(id)
}

fn set(json: Json) -> Map<String, Json> {
    json.as_object().cloned().expect("an object")
}

/// Runs a kind on a grid with some inputs.
fn run_with(id: &str, params: Json, grid: Grid, terrain: &Terrain, wires: Wires) -> Field {
    let given = |port: &str, window: &Grid| wires.get(port).map(|v| v.crop(window));
    Bench::named(id, &params).field(terrain, grid, &given, "field")
}

fn run(id: &str, params: Json, grid: Grid, terrain: &Terrain) -> Field {
    run_with(id, params, grid, terrain, Wires::default())
}

/// The forms in which the generators that have some are tried.
fn cases() -> Vec<(&'static str, Json)> {
    let mut cases = vec![("constant", json!({"value": 3.5}))];
    let (metrics, measures) =
        (["euclidean", "manhattan", "chebyshev"], ["f1", "f2", "f2_minus_f1", "cell_value"]);
    for form in [
        json!("fbm"),
        json!({"billow": {"sharpness": 0.7}}),
        json!({"ridged": {"sharpness": 0.9}}),
        json!({"hybrid": {"base": 0.6}}),
    ] {
        cases.push(("fractal_noise", json!({"form": form, "lacunarity": 2.1})));
    }
    for metric in metrics {
        for measure in measures {
            cases.push(("cellular_noise", json!({"metric": metric, "measure": measure, "size": 333.0})));
        }
    }
    for form in [
        json!({"linear": {"direction": 30.0}}),
        json!({"radial": {"radius": 3000.0}}),
        json!({"cone": {"radius": 3000.0}}),
        json!({"dome": {"radius": 3000.0}}),
    ] {
        cases.push(("gradient", json!({"form": form, "center": [200.0, -300.0]})));
    }
    cases.push(("multifractal", json!({"roughness": 0.8, "octaves": 6})));
    cases
}

fn assert_same_bits(a: &Field, b: &Field, what: &str) {
    assert_eq!(a.grid(), b.grid(), "{what}");
    let differ = a.data().iter().zip(b.data()).filter(|(x, y)| x.to_bits() != y.to_bits()).count();
    assert_eq!(differ, 0, "{what}: samples that differ of {}", a.data().len());
}

fn forms() -> [Form; 5] {
    let round = Form::Ridged { sharpness: 0.8, focus: 2.0 };
    [Form::Fbm, Form::Billow { sharpness: 1.0 }, round, Form::Hybrid { base: 0.7 }, Form::Rough]
}

fn metrics_and_measures() -> Vec<(Metric, Measure)> {
    let measures = [Measure::F1, Measure::F2, Measure::F2MinusF1, Measure::CellValue];
    [Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev]
        .into_iter()
        .flat_map(|metric| measures.map(|measure| (metric, measure)))
        .collect()
}

/// Textbook Perlin noise in f64 over the slopes of the kit.
fn perlin_reference([col, row]: [u32; 2], [x, y]: [f64; 2]) -> f64 {
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for (i, j) in [(0u32, 0u32), (1, 0), (0, 1), (1, 1)] {
        let [cw, rw] = lattice::spread([col.wrapping_add(i), row.wrapping_add(j)]);
        let slope = lattice::slope(lattice::scramble(cw, rw)).map(f64::from);
        let d = [x - f64::from(i), y - f64::from(j)];
        sum += fade(1.0 - d[0].abs()) * fade(1.0 - d[1].abs()) * (slope[0] * d[0] + slope[1] * d[1]);
    }
    sum * 1.421
}

/// Runs a fractal on a square of samples.
fn square(noise: &Fractal, n: usize, cell: f64, origin: [f64; 2]) -> Vec<f32> {
    let xs: Vec<f64> = (0..n).map(|i| origin[0] + cell * i as f64).collect();
    let rows = noise.over(&xs);
    let mut data = vec![0.0; n * n];
    for (j, out) in data.chunks_mut(n).enumerate() {
        rows.row(origin[1] + cell * j as f64, out);
    }
    data
}

fn mean_and_variance(data: &[f32]) -> (f64, f64) {
    let n = data.len() as f64;
    let mean = data.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    (mean, data.iter().map(|&x| (f64::from(x) - mean) * (f64::from(x) - mean)).sum::<f64>() / n)
}

#[test]
fn coincident_samples_are_equal_at_all_sizes() {
    let terrain = Terrain { origin: [-1234.5, 987.25], width: 7000.0, depth: 7000.0, ..Terrain::default() };
    for (coarse, fine) in [(65, 129), (65, 257), (127, 379), (64, 64 * 5 - 4)] {
        let step = (fine - 1) / (coarse - 1);
        assert_eq!(step * (coarse - 1), fine - 1);
        for (id, params) in cases() {
            let small = run(id, params.clone(), terrain.grid(coarse).unwrap(), &terrain);
            let large = run(id, params.clone(), terrain.grid(fine).unwrap(), &terrain);
            for row in 0..i64::from(coarse) {
                for col in 0..i64::from(coarse) {
                    let (a, b) = (small.at(col, row), large.at(col * i64::from(step), row * i64::from(step)));
                    assert_eq!(
                        a.to_bits(),
                        b.to_bits(),
                        "{id} {params} at {col}, {row} of {coarse} in {fine}"
                    );
                }
            }
        }
    }
}

#[test]
fn coincident_samples_are_equal_at_real_sizes() {
    let terrain = Terrain::default();
    let params = json!({"octaves": 3});
    let fields = [505, 513, 1025, 1513, 2049]
        .map(|size| (size, run("fractal_noise", params.clone(), terrain.grid(size).unwrap(), &terrain)));
    for (small, large) in [(1, 2), (1, 4), (0, 3)] {
        let ((n, small), (m, large)) = (&fields[small], &fields[large]);
        let step = i64::from((m - 1) / (n - 1));
        for row in 0..i64::from(*n) {
            for col in 0..i64::from(*n) {
                assert_eq!(small.at(col, row).to_bits(), large.at(col * step, row * step).to_bits());
            }
        }
    }
}

#[test]
fn seeds_change_the_noise_everywhere() {
    let terrain = Terrain::default();
    let grid = terrain.grid(257).unwrap();
    let other = Terrain { seed: 2, ..terrain.clone() };
    for (id, params) in cases().into_iter().filter(|(id, _)| !["constant", "gradient"].contains(id)) {
        let mut params = set(params);
        for size in ["feature_size", "size"] {
            if kind(id).param(size).is_some() {
                params.insert(size.into(), json!(100.0));
            }
        }
        let first = run(id, Json::Object(params.clone()), grid, &terrain);
        let graph_seed = run(id, Json::Object(params.clone()), grid, &other);
        params.insert("seed".into(), json!(1));
        let node_seed = run(id, Json::Object(params.clone()), grid, &terrain);
        for (what, field) in [("graph", graph_seed), ("node", node_seed)] {
            let same = first.data().iter().zip(field.data()).filter(|(a, b)| a == b).count();
            let r = correlation(first.data(), field.data());
            assert!(same < 2000, "{id} {params:?}: {same} samples do not feel the seed of the {what}");
            assert!(r.abs() < 0.06, "{id} {params:?}: correlation {r} under another seed of the {what}");
        }
    }
}

fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let mean = |v: &[f32]| v.iter().map(|&x| f64::from(x)).sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut saa, mut sab, mut sbb) = (0.0, 0.0, 0.0);
    for (&x, &y) in a.iter().zip(b) {
        let (x, y) = (f64::from(x) - ma, f64::from(y) - mb);
        saa += x * x;
        sab += x * y;
        sbb += y * y;
    }
    sab / (saa * sbb).sqrt()
}

#[test]
fn far_from_zero_and_on_the_largest_terrain_all_is_finite() {
    let far =
        |origin: f64| Terrain { origin: [origin, -origin], width: 2e7, depth: 2e7, ..Terrain::default() };
    for terrain in [Terrain::default(), far(1e8), far(-1e8)] {
        let grid = Grid { cols: 37, rows: 5, ..terrain.grid(9).unwrap().grow_cells(4) };
        for kind in Registry::standard().iter().filter(|k| k.family == "generate") {
            for set in sets::all(kind) {
                let params = Json::Object(set);
                let field = run(&kind.id, params.clone(), grid, &terrain);
                assert_eq!(Value::Field(field).first_not_finite(), None, "{} {params}", kind.id);
            }
        }
    }
}
