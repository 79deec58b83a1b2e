//! Any size, any input, any number of threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use orograph::kit::diffusion::{Error, Quality, solve};
use orograph::work::{Cancel, Work};

use super::scenes::Scene;

const QUALITIES: [Quality; 2] = [Quality::Paper, Quality::CONVERGED];

#[test]
fn the_same_bits_for_any_number_of_threads() {
    for s in [Scene::curves(300, 211), Scene::guided(260, 190)] {
        for quality in QUALITIES {
            let run = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                pool.install(|| solve(&s.problem(), quality, &Work::default())).expect("solves")
            };
            let one = run(1);
            for threads in [2, 7] {
                let other = run(threads);
                assert!(one.field.iter().zip(&other.field).all(|(a, b)| a.to_bits() == b.to_bits()));
                assert_eq!(one.history, other.history);
            }
        }
    }
}

#[test]
fn any_size() {
    let sizes = [
        (0, 0),
        (0, 5),
        (1, 1),
        (1, 2),
        (2, 1),
        (2, 2),
        (3, 2),
        (3, 3),
        (1, 1000),
        (1000, 1),
        (2, 333),
        (5, 7),
        (9, 8),
        (31, 3),
    ];
    for (cols, rows) in sizes {
        for quality in QUALITIES {
            let mut s = Scene::empty(cols, rows);
            let n = cols * rows;
            if n > 0 {
                s.fix(0, 0, 1.0, 5.0);
                s.fix(cols - 1, rows - 1, 0.5, 7.0);
            }
            for guided in [false, true] {
                s.guidance = guided.then(|| [vec![0.5; n], vec![1.0; n], vec![-0.5; n], vec![0.1; n]]);
                let solution = solve(&s.problem(), quality, &Work::default()).expect("solves");
                assert_eq!(solution.field.len(), n);
                assert!(solution.field.iter().all(|v| v.is_finite()), "{cols}x{rows} {quality:?} {guided}");
            }
        }
    }
}

#[test]
fn nothing_gives_zero() {
    for quality in QUALITIES {
        let solution = solve(&Scene::empty(50, 40).problem(), quality, &Work::default()).expect("solves");
        assert!(solution.converged && solution.field.iter().all(|&v| v == 0.0));
    }
}

#[test]
fn all_fixed_is_all_held() {
    let mut s = Scene::empty(33, 20);
    for k in 0..660 {
        s.fix(k % 33, k / 33, 1.0, k as f32);
    }
    for quality in QUALITIES {
        assert_eq!(solve(&s.problem(), quality, &Work::default()).expect("solves").field, s.target);
    }
}

#[test]
fn slopes_without_elevation_hang_on_the_border() {
    let mut s = Scene::empty(65, 65);
    s.line((0.2, 0.5), (0.8, 0.5), (0.0, 0.0));
    s.guide(0.5, 12.0, 0.5);
    s.fixed.fill(0.0);
    if let Some([_, x, y, slope]) = &mut s.guidance {
        x.iter_mut().chain(y).chain(slope).for_each(|v| *v = -*v);
    }
    for quality in QUALITIES {
        let solution = solve(&s.problem(), quality, &Work::default()).expect("solves");
        assert_eq!(solution.field[0], 0.0);
        assert!(solution.converged, "{:?}", solution.history);
        assert!(solution.field.iter().all(|v| v.abs() < 20.0));
        assert!(solution.field.iter().any(|&v| v != 0.0));
    }
}

#[test]
fn hostile_input_gives_finite_fields() {
    let odd =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e30, 9e29, 1e-40, -0.0, 3.0, -7.0, 0.5, 1.0];
    let n = 40;
    let mut seed = 1u32;
    let mut pick = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        odd[(seed >> 16) as usize % odd.len()]
    };
    for round in 0..12 {
        let mut s = Scene::empty(n, n);
        let mut map = || (0..n * n).map(|_| pick()).collect::<Vec<f32>>();
        (s.fixed, s.target) = (map(), map());
        if round % 3 == 0 {
            // A few constraints only.
            s.fixed.iter_mut().enumerate().filter(|(k, _)| k % 97 != 0).for_each(|(_, f)| *f = 0.0);
        }
        s.guidance = (round % 2 == 0).then(|| [map(), map(), map(), map()]);
        s.source = (round % 4 == 1).then(&mut map);
        s.cell = if round == 4 { f32::NAN } else { 2.0 };
        for quality in [Quality::Paper, Quality::Converged { tolerance: 1e-5, cycles: 30 }] {
            let solution = solve(&s.problem(), quality, &Work::default()).expect("solves");
            assert!(solution.field.iter().all(|v| v.is_finite()), "round {round} {quality:?}");
        }
    }
}

#[test]
fn closed_loops_of_guidance_stay_finite() {
    // A whirl that rises all the way round.
    let n = 48;
    let mut s = Scene::empty(n, n);
    s.fix(0, 0, 1.0, 3.0);
    let at = |k: usize| ((k % n) as f32 - 23.5, (k / n) as f32 - 23.5);
    let map = |f: &dyn Fn(f32, f32) -> f32| (0..n * n).map(|k| f(at(k).0, at(k).1)).collect::<Vec<f32>>();
    s.guidance = Some([map(&|_, _| 1.0), map(&|_, y| -y), map(&|x, _| x), map(&|_, _| 0.5)]);
    for quality in QUALITIES {
        let solution = solve(&s.problem(), quality, &Work::default()).expect("solves");
        let most = solution.field.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        assert!(most < 1e7, "{quality:?}: {most}, {:?}", solution.history);
    }
}

#[test]
fn wrong_lengths_are_named() {
    let mut s = Scene::empty(10, 10);
    s.target.pop();
    let found = solve(&s.problem(), Quality::Paper, &Work::default());
    assert_eq!(found, Err(Error::Length { array: "target", found: 99, expected: 100 }));
}

#[test]
fn work_tells_and_stops() {
    let s = Scene::guided(129, 129);
    for quality in QUALITIES {
        for most in [0, 1, 2, 3] {
            let (cancel, told) = (Cancel::default(), AtomicUsize::new(0));
            let stop = |_: f32| {
                if told.fetch_add(1, Ordering::SeqCst) + 1 >= most {
                    cancel.cancel();
                }
            };
            if most == 0 {
                cancel.cancel();
            }
            let work = Work::new(&cancel).telling(&stop);
            assert_eq!(solve(&s.problem(), quality, &work), Err(Error::Cancelled), "{quality:?} {most}");
        }
        let told = Mutex::new(Vec::new());
        let tell = |done: f32| told.lock().expect("whole").push(done);
        solve(&s.problem(), quality, &Work::default().telling(&tell)).expect("solves");
        let told = told.into_inner().expect("whole");
        assert!(told.len() > 3 && told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    }
}
