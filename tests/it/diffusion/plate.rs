//! Thin plates.

use orograph::kit::diffusion::{Error, Plate, Solution, bend};
use orograph::work::Work;

use super::scenes::Scene;

const TOLERANCE: f64 = 1e-5;

fn solve(s: &Scene) -> Solution {
    let plate = Plate { cols: s.cols, rows: s.rows, known: &s.fixed, value: &s.target };
    bend(&plate, TOLERANCE, 200, &Work::default()).expect("solves")
}

/// All second differences of a grid, each as cells and weights; `u_xy` counts twice.
fn differences(cols: usize, rows: usize) -> Vec<(f64, Vec<(usize, f64)>)> {
    let at = |i: usize, j: usize| j * cols + i;
    let mut out = Vec::new();
    for j in 0..rows {
        for i in 0..cols {
            if i + 2 < cols {
                out.push((1.0, vec![(at(i, j), 1.0), (at(i + 1, j), -2.0), (at(i + 2, j), 1.0)]));
            }
            if j + 2 < rows {
                out.push((1.0, vec![(at(i, j), 1.0), (at(i, j + 1), -2.0), (at(i, j + 2), 1.0)]));
            }
            if i + 1 < cols && j + 1 < rows {
                let near =
                    [(at(i, j), 1.0), (at(i + 1, j), -1.0), (at(i, j + 1), -1.0), (at(i + 1, j + 1), 1.0)];
                out.push((2.0, near.to_vec()));
            }
        }
    }
    out
}

/// The truth, by elimination in the band.
fn exact(s: &Scene) -> Vec<f64> {
    let (n, band) = (s.cols * s.rows, 2 * s.cols + 2);
    let wide = 2 * band + 1;
    let (mut a, mut b) = (vec![0.0; n * wide], vec![0.0; n]);
    for (weight, cells) in differences(s.cols, s.rows) {
        for &(k, x) in &cells {
            for &(q, y) in &cells {
                a[k * wide + band + q - k] += weight * x * y;
            }
        }
    }
    for k in (0..n).filter(|&k| s.fixed[k] > 0.0) {
        a[k * wide..(k + 1) * wide].fill(0.0);
        (a[k * wide + band], b[k]) = (1.0, f64::from(s.target[k]));
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

#[track_caller]
fn check(name: &str, s: &Scene) {
    let (truth, found) = (exact(s), solve(s));
    assert!(found.converged, "{name}: {:?}", found.history);
    let (low, high) = truth.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    let worst = truth.iter().zip(&found.field).fold(0.0f64, |m, (t, &f)| m.max((t - f64::from(f)).abs()));
    let error = worst / (high - low);
    let said = found.history.last().expect("a cycle");
    println!("{name}: {error:.1e}, said {said:.1e}, after {} cycles", found.cycles);
    assert!(error < TOLERANCE, "{name}: error {error:.1e}");
    assert!(found.cycles <= 30, "{name}: {} cycles", found.cycles);
}

/// Lone points, `count` of them.
fn points(cols: usize, rows: usize, count: usize) -> Scene {
    let mut s = Scene::empty(cols, rows);
    let mut seed = 7u32;
    let mut pick = |n: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as usize % n
    };
    for _ in 0..count {
        let (i, j, v) = (pick(cols), pick(rows), pick(1000));
        s.fix(i, j, 1.0, v as f32);
    }
    s
}

#[test]
fn lines_and_an_island() {
    for (cols, rows) in [(33, 33), (48, 48), (50, 61), (17, 70)] {
        check(&format!("curves {cols}x{rows}"), &Scene::curves(cols, rows));
    }
}

#[test]
fn points_few_and_many() {
    for count in [4, 12, 100, 1000] {
        check(&format!("{count} points"), &points(47, 52, count));
    }
}

#[test]
fn a_void_is_filled() {
    let mut s = Scene::empty(49, 40);
    for k in 0..49 * 40 {
        let (i, j) = (k % 49, k / 49);
        if !(9..38).contains(&i) || !(6..33).contains(&j) {
            s.fix(i, j, 1.0, ((i * i) as f32 * 0.3 - (i * j) as f32 * 0.1) + ((k * 7919) % 10) as f32);
        }
    }
    check("void", &s);
}

#[test]
fn narrow_grids() {
    for (cols, rows) in [(1, 40), (40, 1), (2, 30), (30, 2), (3, 25), (60, 5)] {
        check(&format!("{cols}x{rows}"), &points(cols, rows, 9));
    }
}

#[test]
fn a_plane_stays_a_plane() {
    for (cols, rows) in [(65, 65), (40, 33), (129, 17), (2, 2), (1, 9)] {
        let plane = |k: usize| 100.0 + 3.0 * (k % cols) as f32 - 1.5 * (k / cols) as f32;
        let mut s = Scene::empty(cols, rows);
        for k in [0, cols - 1, (rows - 1) * cols, cols * rows / 2] {
            s.fix(k % cols, k / cols, 1.0, plane(k));
        }
        let range = 3.0 * cols as f32 + 1.5 * rows as f32;
        for (k, &v) in solve(&s).field.iter().enumerate() {
            assert!(
                (v - plane(k)).abs() <= range * 2e-5,
                "{cols}x{rows} at {k}: {v}, should be {}",
                plane(k)
            );
        }
    }
}

#[test]
fn what_is_known_stays_to_the_bit() {
    let s = Scene::curves(100, 73);
    let found = solve(&s);
    for k in (0..7300).filter(|&k| s.fixed[k] > 0.0) {
        assert_eq!(found.field[k].to_bits(), s.target[k].to_bits());
    }
}

#[test]
fn mirrored_input_gives_mirrored_output() {
    for (cols, rows) in [(65, 50), (64, 51)] {
        let s = Scene::curves(cols, rows);
        let there = solve(&s).field;
        for (in_x, in_y) in [(true, false), (false, true)] {
            let from = |k: usize| {
                let (i, j) = (k % cols, k / cols);
                (if in_y { rows - 1 - j } else { j }) * cols + if in_x { cols - 1 - i } else { i }
            };
            let mut m = Scene::empty(cols, rows);
            for k in 0..cols * rows {
                (m.fixed[k], m.target[k]) = (s.fixed[from(k)], s.target[from(k)]);
            }
            let (low, high) = there.iter().fold((f32::MAX, f32::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            for (k, v) in solve(&m).field.into_iter().enumerate() {
                assert!((v - there[from(k)]).abs() < 2e-5 * (high - low), "{cols}x{rows} at {k}");
            }
        }
    }
}

#[test]
fn what_is_left_open_is_level() {
    // Known cells on a line: as bent as if one cell beside it were known, and without tilt across it on the whole.
    let (n, m) = (41, 30);
    let mut s = Scene::empty(n, m);
    for (i, v) in [(5, 10.0), (20, 40.0), (33, -5.0)] {
        s.fix(i, 12, 1.0, v);
    }
    let found = solve(&s);
    assert!(found.converged);
    let field: Vec<f64> = found.field.iter().map(|&v| f64::from(v)).collect();
    let tilt: f64 = (0..n).map(|i| field[(m - 1) * n + i] - field[i]).sum();
    assert!(tilt.abs() < 0.1, "{tilt}");
    s.fix(0, 0, 1.0, 0.0);
    let truth = exact(&s);
    let rise = (truth[0] - field[0]) / -12.0;
    for (k, t) in truth.iter().enumerate() {
        let turned = field[k] + rise * ((k / n) as f64 - 12.0);
        assert!((turned - t).abs() < 0.05, "at {k}: {turned}, should be {t}");
    }
    // Two points: an even slope from one to the other, along a slanting line too.
    let mut s = Scene::empty(n, 30);
    s.fix(4, 3, 1.0, 0.0);
    s.fix(28, 15, 1.0, 90.0);
    for (k, &v) in solve(&s).field.iter().enumerate() {
        let along = ((k % n) as f32 - 4.0) * 2.0 + ((k / n) as f32 - 3.0);
        assert!((v - 1.5 * along).abs() < 0.01, "at {k}: {v}, should be {}", 1.5 * along);
    }
}

#[test]
fn little_known() {
    let mut s = Scene::empty(50, 31);
    assert!(solve(&s).field.iter().all(|&v| v == 0.0));
    s.fix(7, 30, 1.0, -12.5);
    assert!(solve(&s).field.iter().all(|&v| v == -12.5));
    s.fix(8, 30, 1.0, f32::NAN);
    assert!(solve(&s).field.iter().all(|&v| v == -12.5));
}

#[test]
fn any_size_and_any_input_is_finite() {
    let odd = [f32::NAN, f32::INFINITY, f32::MAX, -1e30, 9e29, 1e-40, -0.0, 3.0, -7.0, 0.5, 1.0];
    for (cols, rows) in
        [(0, 0), (0, 5), (1, 1), (2, 1), (1, 2), (2, 2), (3, 2), (3, 3), (1, 500), (500, 1), (2, 99), (9, 8)]
    {
        let n = cols * rows;
        let mut s = Scene::empty(cols, rows);
        for k in 0..n {
            s.target[k] = odd[(k * 7 + 3) % odd.len()];
            s.fixed[k] = odd[(k * 5 + 1) % odd.len()];
        }
        let field = solve(&s).field;
        assert!(field.len() == n && field.iter().all(|v| v.is_finite()), "{cols}x{rows}");
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let s = Scene::curves(300, 211);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| solve(&s))
    };
    let one = run(1);
    for threads in [2, 7] {
        let other = run(threads);
        assert!(one.field.iter().zip(&other.field).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert_eq!(one.history, other.history);
    }
}

#[test]
fn wrong_lengths_are_named() {
    let plate = Plate { cols: 3, rows: 3, known: &[0.0; 9], value: &[0.0; 8] };
    let found = bend(&plate, TOLERANCE, 10, &Work::default());
    assert_eq!(found, Err(Error::Length { array: "value", found: 8, expected: 9 }));
}
