//! The converged field against an exact solve, written here from the definition alone.

use orograph::kit::diffusion::{Quality, solve};
use orograph::work::Work;

use super::scenes::Scene;

/// The four weights of the neighbours west, east, north, south, what stands on the diagonal and on the right side.
fn equation(s: &Scene, i: usize, j: usize) -> ([f64; 4], f64, f64) {
    let k = j * s.cols + i;
    let f = f64::from(s.fixed[k]);
    let there = [i > 0, i + 1 < s.cols, j > 0, j + 1 < s.rows];
    let (mut bx, mut by, mut rise, mut to) = (0.0, 0.0, 0.0, [0.0; 4]);
    if let Some([weight, x, y, slope]) = &s.guidance {
        let (x, y) = (f64::from(x[k]), f64::from(y[k]));
        let length = (x * x + y * y).sqrt();
        let b = f64::from(weight[k]).min((1.0 - f) * (1.0 - 1.0 / 256.0));
        if length > 1e-6 && b > 0.0 {
            let (ax, ay) = (x.abs() / length, y.abs() / length);
            let (from_x, from_y) = (if x > 0.0 { 0 } else { 1 }, if y > 0.0 { 2 } else { 3 });
            bx = if ax > 0.0 && there[from_x] { b * ax / (ax + ay) } else { 0.0 };
            by = if ay > 0.0 && there[from_y] { b * ay / (ax + ay) } else { 0.0 };
            to[from_x] += bx;
            to[from_y] += by;
            // The height difference along each axis; together cell · tan / (|nx| + |ny|).
            rise = f64::from(s.cell) * f64::from(slope[k]) * (bx * ax + by * ay);
        }
    }
    let l = 1.0 - f - bx - by;
    let (mut own, mut pulls) = (1.0, [0.0; 4]);
    for d in 0..4 {
        if there[d] {
            pulls[d] = 0.25 * l + to[d];
        } else {
            own -= 0.25 * l;
        }
    }
    let source = s.source.as_ref().map_or(0.0, |v| f64::from(v[k]));
    (pulls, own, f * f64::from(s.target[k]) + rise + l * source)
}

/// Banded elimination.
fn exact(s: &Scene) -> Vec<f64> {
    let (n, band) = (s.cols * s.rows, s.cols);
    let wide = 2 * band + 1;
    let (mut a, mut b) = (vec![0.0; n * wide], vec![0.0; n]);
    for k in 0..n {
        let (pulls, own, right) = equation(s, k % s.cols, k / s.cols);
        a[k * wide + band] = own;
        for (pull, at) in pulls.into_iter().zip([band.wrapping_sub(1), band + 1, 0, 2 * band]) {
            if pull != 0.0 {
                a[k * wide + at] -= pull;
            }
        }
        b[k] = right;
    }
    for k in 0..n {
        for r in k + 1..(k + band + 1).min(n) {
            let factor = a[r * wide + k + band - r] / a[k * wide + band];
            if factor != 0.0 {
                for c in k..(k + band + 1).min(n) {
                    a[r * wide + c + band - r] -= factor * a[k * wide + c + band - k];
                }
                b[r] -= factor * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        for c in k + 1..(k + band + 1).min(n) {
            b[k] -= a[k * wide + c + band - k] * b[c];
        }
        b[k] /= a[k * wide + band];
    }
    b
}

/// The largest error over the range; the solver must say that it converged, and not claim less than it has.
fn error(s: &Scene) -> f64 {
    let truth = exact(s);
    let found = solve(&s.problem(), Quality::CONVERGED, &Work::default()).expect("solves");
    assert!(found.converged, "{:?}", found.history);
    // The range is that of constraints and field together.
    let held = (0..s.fixed.len()).filter(|&k| s.fixed[k] > 0.0).map(|k| f64::from(s.target[k]));
    let all = held.chain(truth.iter().copied());
    let (low, high) = all.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    let worst = truth.iter().zip(&found.field).fold(0.0f64, |m, (t, &f)| m.max((t - f64::from(f)).abs()));
    worst / (high - low).max(1e-30)
}

#[track_caller]
fn check(name: &str, s: &Scene) {
    let e = error(s);
    println!("{name}: {e:.1e}");
    assert!(e < 1e-5, "{name}: error {e:.1e}");
}

#[test]
fn thin_lines() {
    for (cols, rows) in [(33, 33), (64, 64), (65, 65), (50, 61), (17, 90)] {
        check(&format!("curves {cols}x{rows}"), &Scene::curves(cols, rows));
    }
}

#[test]
fn soft_constraints() {
    for weight in [0.9f32, 0.3, 0.01, 1e-4] {
        let mut s = Scene::curves(49, 49);
        for (k, f) in s.fixed.iter_mut().enumerate() {
            *f *= if k % 3 == 0 { weight } else { 0.5 * weight };
        }
        check(&format!("soft {weight}"), &s);
    }
    let mut s = Scene::empty(40, 40);
    for k in 0..1600 {
        s.fix(k % 40, k / 40, 0.02, ((k * 7919) % 1000) as f32);
    }
    check("soft everywhere", &s);
}

#[test]
fn two_points() {
    let mut s = Scene::empty(65, 65);
    s.fix(31, 40, 1.0, -3.0);
    s.fix(2, 5, 1.0, 17.0);
    check("two points", &s);
}

#[test]
fn sources() {
    let mut s = Scene::curves(57, 57);
    s.source = Some((0..57 * 57).map(|k| ((k * 31) % 17) as f32 - 8.0).collect());
    check("sources", &s);
    let mut s = Scene::empty(45, 45);
    s.fix(22, 22, 1.0, 0.0);
    s.source = Some((0..45 * 45).map(|k| if k == 100 { 1.0 } else { 0.0 }).collect());
    check("a source and a sink", &s);
}

#[test]
fn guided_cells() {
    for weight in [0.05f32, 0.5, 0.9, 1.0] {
        let mut s = Scene::guided(65, 65);
        if let Some([w, ..]) = &mut s.guidance {
            w.iter_mut().for_each(|w| *w *= weight / 0.5);
        }
        check(&format!("guided {weight}"), &s);
    }
}

#[test]
fn guidance_towards_the_curves() {
    // Where a curve has slopes and no elevation, information flows the other way: a crack beside a ridge.
    for reach in [4.0, 8.0, 12.0] {
        let mut s = Scene::empty(64, 57);
        s.cell = 10.0;
        s.line((0.15, 0.3), (0.4, 0.8), (0.0, 0.0));
        s.line((0.8, 0.2), (0.85, 0.7), (100.0, 200.0));
        s.guide(0.5, reach, 0.6);
        if let Some([_, x, y, slope]) = &mut s.guidance {
            for k in (0..x.len()).filter(|k| k % 64 < 40) {
                (x[k], y[k], slope[k]) = (-x[k], -y[k], -slope[k]);
            }
        }
        check(&format!("inverted {reach}"), &s);
        (0..s.fixed.len()).filter(|k| k % 64 < 40).for_each(|k| s.fixed[k] = 0.0);
        check(&format!("crack {reach}"), &s);
    }
}

#[test]
fn guidance_that_disagrees() {
    let mut s = Scene::guided(65, 65);
    if let Some([_, x, y, _]) = &mut s.guidance {
        for (k, (x, y)) in x.iter_mut().zip(y).enumerate() {
            (*x, *y) =
                ((((k * 7919) % 200) as f32 - 100.0) * 0.01, (((k * 104_729) % 200) as f32 - 100.0) * 0.01);
        }
    }
    check("random directions", &s);
}
