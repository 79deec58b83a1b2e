//! Sums over octaves against their formulas.

use orograph::kit::noise::{Form, Fractal, Spectrum, lattice};

use super::{forms, perlin_reference, square};

/// Noise of every octave at a point, from the parts that are tested above.
fn octaves(spectrum: Spectrum, seed: u64, [x, y]: [f64; 2]) -> Vec<f64> {
    let mut size = spectrum.feature_size;
    let mut all = Vec::new();
    for k in 0..spectrum.octaves {
        let turned = lattice::Turned::new(size, orograph::kit::hash::nth(seed, u64::from(k)));
        let (cell, at) = turned.locate(x, y);
        all.push(perlin_reference(cell, at.map(f64::from)));
        size /= spectrum.lacunarity;
    }
    all
}

#[test]
fn fractals_are_what_their_formulas_say() {
    let spectrum = Spectrum { feature_size: 1000.0, octaves: 6, lacunarity: 2.3, gain: 0.6 };
    let xs: Vec<f64> = (0..301).map(|i| f64::from(i) * 13.7 - 1500.0).collect();
    let roughness: Vec<f32> = (0..301_u16).map(|i| f32::from(i) / 200.0 - 0.25).collect();
    let gain = |k: usize| (0..k).fold(1.0, |w, _| w * 0.6);
    let sum: f64 = (0..6).map(gain).sum();
    for form in forms() {
        let noise = Fractal::new(form, spectrum, 42, 5.0, 100.0);
        let mut out = vec![0.0; xs.len()];
        for y in [-800.0, 0.0, 4321.0] {
            noise.over(&xs).rough_row(y, &roughness, &mut out);
            for ((&x, &r), &ours) in xs.iter().zip(&roughness).zip(&out) {
                let n = octaves(spectrum, 42, [x, y]);
                let parts = match form {
                    Form::Fbm => n.iter().enumerate().map(|(k, n)| gain(k) * n).sum::<f64>() / sum,
                    Form::Billow { .. } => {
                        n.iter().enumerate().map(|(k, n)| gain(k) * n.abs()).sum::<f64>() / sum
                    }
                    Form::Ridged { sharpness, focus } => {
                        let width = 1.0 - f64::from(sharpness);
                        let round = |a: f64| if a < width { a * a / (2.0 * width) } else { a - width / 2.0 };
                        let (mut result, mut weight) = (0.0, 1.0);
                        for (k, n) in n.iter().enumerate() {
                            let crest = 1.0 - round(n.abs());
                            let signal = crest * crest * weight;
                            result += signal * gain(k);
                            weight = (signal * f64::from(focus)).clamp(0.0, 1.0);
                        }
                        result / sum
                    }
                    Form::Hybrid { base } => {
                        let (mut result, mut weight) = (0.0, 1.0);
                        for (k, n) in n.iter().enumerate() {
                            let signal = (n + f64::from(base)) * weight;
                            result += signal * gain(k);
                            weight = signal.clamp(0.0, 1.0);
                        }
                        result / sum / (1.0 + f64::from(base))
                    }
                    Form::Rough => {
                        let r = f64::from(r).clamp(0.0, 1.0);
                        let scaled =
                            n.iter().enumerate().map(|(k, n)| libm::pow(2.3, -(k as f64) * (1.0 - r)) * n);
                        scaled.sum()
                    }
                };
                let truth = 5.0 + 100.0 * parts;
                assert!(
                    (f64::from(ours) - truth).abs() < 3e-3,
                    "{form:?} at {x}, {y}: {ours}, should be {truth}"
                );
            }
        }
    }
}

#[test]
fn fractals_keep_their_bounds() {
    for gain in [0.0, 0.5, 1.0] {
        let spectrum = Spectrum { feature_size: 50.0, octaves: 6, lacunarity: 2.0, gain };
        for (form, low, high) in [
            (Form::Fbm, -1.0, 1.0),
            (Form::Billow { sharpness: 1.0 }, 0.0, 1.0),
            (Form::Ridged { sharpness: 1.0, focus: 8.0 }, 0.0, 1.0),
            (Form::Hybrid { base: 0.7 }, -0.3 / 1.7, 1.0),
            (Form::Hybrid { base: 0.0 }, -1.0, 1.0),
        ] {
            let data = square(&Fractal::new(form, spectrum, 8, 0.0, 1.0), 512, 9.1, [0.0, 0.0]);
            let (lo, hi) = data.iter().fold((f32::MAX, f32::MIN), |(lo, hi), &x| (lo.min(x), hi.max(x)));
            assert!(lo >= low - 1e-6 && hi <= high + 1e-6, "{form:?} gain {gain}: {lo} to {hi}");
            assert!(
                hi - lo > 0.4 * (high - low).min(1.0),
                "{form:?} gain {gain} has no relief: {lo} to {hi}"
            );
        }
    }
}
