//! Kernels on every instruction set.

use std::path::Path;

use orograph::kit::noise::{Fractal, Spectrum, Worley};
use orograph::kit::simd::Level;

use super::{forms, metrics_and_measures};
use crate::rig::skip::skip;

#[test]
fn instruction_sets_do_not_change_a_bit() {
    let spectrum = Spectrum { feature_size: 700.0, octaves: 9, lacunarity: 2.03, gain: 0.55 };
    // Widths around the chunk and the lanes.
    for cols in [1, 7, 16, 33, 256, 257, 1025] {
        let xs: Vec<f64> = (0..cols).map(|i| f64::from(i) * 7.3 - 2000.0).collect();
        let roughness: Vec<f32> = (0..cols).map(|i| (i % 100) as f32 / 80.0 - 0.1).collect();
        let check = |what: &str, row: &dyn Fn(Level, &mut [f32])| {
            let (mut reference, mut other) = (vec![0.0; xs.len()], vec![0.0; xs.len()]);
            row(Level::BASELINE, &mut reference);
            for level in Level::available() {
                // A level that leaves the row alone must not pass for the one before.
                other.fill(f32::NAN);
                row(level, &mut other);
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&reference), bits(&other), "{what}, {cols} columns, {level:?}");
            }
        };
        for form in forms() {
            let noise = Fractal::new(form, spectrum, 99, 10.0, 500.0);
            for y in [0.0, -12_345.678, 1e7] {
                check(&format!("{form:?}"), &|level, out| {
                    noise.over(&xs).on(level).rough_row(y, &roughness, out)
                });
            }
        }
        for (metric, measure) in metrics_and_measures() {
            let noise = Worley::new(55.0, 0.95, 7, 0.0, 100.0).measured(metric, measure);
            check(&format!("{metric:?} {measure:?}"), &|level, out| noise.over(&xs).on(level).row(77.7, out));
        }
    }
    if Level::available().len() == 1 {
        let reason = "this machine has the baseline alone, nothing to compare";
        skip("instruction_sets_do_not_change_a_bit", reason, Path::new(""));
    }
}
