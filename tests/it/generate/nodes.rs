//! The kinds by themselves: profiles, inputs, parameters.

use orograph::ports::Wires;
use orograph::value::{Field, Grid, Lattice, Quantity, Terrain, Value};
use serde_json::{Value as Json, json};

use super::{assert_same_bits, kind, run, run_with, set};

#[test]
fn multifractal_follows_its_fields() {
    let terrain = Terrain::default();
    let grid = terrain.grid(129).unwrap();
    let plain = run("multifractal", json!({"amplitude": 80.0, "roughness": 0.25}), grid, &terrain);
    let larger = grid.grow_cells(3);
    let wires = |amplitude: Field, roughness: Field| -> Wires {
        [("amplitude", Value::Field(amplitude)), ("roughness", Value::Field(roughness))].into_iter().collect()
    };
    // Constant fields are the parameters, to the bit, and override them.
    let amplitude = Field::constant(larger, Quantity::Length, 80.0);
    let roughness = Field::constant(larger, Quantity::Mask, 0.25);
    let other = json!({"amplitude": 1.0, "roughness": 1.0});
    let by_fields =
        run_with("multifractal", other.clone(), grid, &terrain, wires(amplitude, roughness.clone()));
    assert_same_bits(&plain, &by_fields, "constant fields");
    // Amplitude scales, sample by sample.
    let ramp = Field::from_fn(larger, Quantity::Length, |x, _| (x / 64.0) as f32);
    let scaled = run_with("multifractal", other, grid, &terrain, wires(ramp.clone(), roughness));
    for row in 0..129 {
        for col in 0..129 {
            let want = plain.at(col, row) / 80.0 * ramp.at(col, row);
            assert!((scaled.at(col, row) - want).abs() < 1e-3 * (1.0 + want.abs()));
        }
    }
    // Huge amplitudes stay finite.
    let huge = Field::constant(grid, Quantity::Length, f32::MAX);
    let rough = Field::constant(grid, Quantity::Mask, -f32::MAX);
    let field = run_with("multifractal", json!({"octaves": 16}), grid, &terrain, wires(huge, rough));
    assert_eq!(Value::Field(field).first_not_finite(), None);
}

#[test]
fn gradients_have_their_profiles() {
    let terrain = Terrain { origin: [100.0, 50.0], width: 4000.0, depth: 2000.0, ..Terrain::default() };
    let grid = terrain.grid(401).unwrap();
    // 10 m a cell; the middle of the terrain is column 200, row 100.
    let at = |form: Json, col: i64, row: i64| {
        let params = json!({"form": form, "center": [-100.0, 50.0], "foot": 20.0, "top": 120.0});
        f64::from(run("gradient", params, grid, &terrain).at(col, row))
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a}, should be {b}");
    let ramp = |direction: f64| json!({"linear": {"direction": direction, "length": 400.0}});
    close(at(ramp(0.0), 190, 105), 70.0);
    close(at(ramp(0.0), 7, 95), 95.0); // 100 m north of the centre
    close(at(ramp(90.0), 200, 3), 95.0); // 100 m east
    close(at(ramp(225.0), 180, 115), 70.0 + 25.0 * std::f64::consts::FRAC_1_SQRT_2 * 2.0);
    close(at(ramp(90.0), 0, 0), 20.0);
    close(at(ramp(90.0), 400, 0), 120.0);
    for (form, profile) in [
        ("radial", [120.0, 20.0 + 100.0 * (1.0 - 3.0 * 0.0625 + 2.0 * 0.015_625), 70.0, 20.0]),
        ("cone", [120.0, 95.0, 70.0, 20.0]),
        ("dome", [120.0, 20.0 + 100.0 * 0.9375_f64.sqrt(), 20.0 + 100.0 * 0.75_f64.sqrt(), 20.0]),
    ] {
        let form = json!({form: {"radius": 200.0}});
        for (i, want) in profile.into_iter().enumerate() {
            let d = [0, 5, 10, 20][i];
            close(at(form.clone(), 190 + d, 105), want);
            close(at(form.clone(), 190, 105 - d), want);
        }
        close(at(form, 300, 5), 20.0);
    }
}

#[test]
fn modes_need_only_the_fields_that_differ() {
    let terrain = Terrain::default();
    let lattice = Lattice { origin: [0.0, 0.0], span: 8192.0, intervals: 64 };
    let grid = Grid { lattice, col: -3, row: 2, cols: 40, rows: 3 };
    let short = run("fractal_noise", json!({"form": {"ridged": {}}}), grid, &terrain);
    let long =
        run("fractal_noise", json!({"form": {"ridged": {"sharpness": 1.0, "focus": 2.0}}}), grid, &terrain);
    assert_same_bits(&short, &long, "ridged");
    let bad = kind("fractal_noise").parse(&set(json!({"form": {"ridged": {"focus": 9.0}}}))).unwrap_err();
    assert!(bad.to_string().contains("from 0 to 8, got 9"), "{bad}");
    let bad = kind("fractal_noise").parse(&set(json!({"octaves": 1e9 as i64}))).unwrap_err();
    assert!(bad.to_string().contains("from 1 to 16"), "{bad}");
}
