//! Land that says little, nothing, or too much.

use orograph::kit::geomorphometry::{Figures, Land};
use orograph::kit::hash;
use orograph::work::{Cancel, Work};
use proptest::prelude::*;

use super::{figures, land};

/// No number of the figures is infinite or none.
#[track_caller]
fn sound(found: &Figures) {
    let text = format!("{found:?}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn land_that_is_not_there_has_no_figures() {
    for (cols, rows) in [(0, 0), (0, 5), (5, 0), (1, 1), (30, 20)] {
        let empty = land(cols, rows, 10.0, |_, _| f64::NAN);
        assert_eq!(Figures::of(&empty, None, &Work::default()), Ok(None), "{cols} x {rows}");
    }
    let sunk = land(9, 9, 10.0, |i, _| -i).above_sea(0.0);
    assert_eq!(Figures::of(&sunk, None, &Work::default()), Ok(None));
    let marks = land(9, 9, 10.0, |i, _| if i < 5.0 { f64::INFINITY } else { -1e35 });
    assert_eq!(Figures::of(&marks, None, &Work::default()), Ok(None));
}

#[test]
fn odd_sizes_and_flat_land_are_measured_as_far_as_they_go() {
    for (cols, rows) in [(1, 1), (1, 90), (90, 1), (2, 70), (3, 3), (12, 12), (13, 13), (64, 65), (101, 67)] {
        for (what, steep) in [("flat", 0.0), ("waves", 30.0)] {
            let found = figures(&land(cols, rows, 10.0, |i, j| 100.0 + steep * libm::sin(i * 0.7 + j * 0.3)));
            sound(&found);
            assert_eq!(found.slope.is_some(), cols.min(rows) >= 3, "{cols} x {rows}, {what}");
            assert_eq!(found.curvature.len(), if cols.min(rows) >= 13 { 3 } else { 0 }, "{cols} x {rows}");
            assert_eq!(found.spectrum.is_some(), steep > 0.0 && cols.min(rows) >= 64, "{cols} x {rows}");
        }
    }
}

#[test]
fn a_plain_is_level_and_nothing_else() {
    let found = figures(&land(120, 110, 10.0, |_, _| 55.5));
    sound(&found);
    assert_eq!((found.hypsometry.relief, found.hypsometry.integral), (0.0, 0.0));
    assert_eq!(
        (found.depressions.filled, found.depressions.pits_per_1000, found.depressions.volume),
        (0.0, 0.0, 0.0)
    );
    assert!(found.depressions.filled_or_level > 0.9, "all but the border");
    assert_eq!((found.aspect, found.spectrum), (None, None));
}

#[test]
fn extreme_heights_stay_numbers() {
    for scale in [1e-30, 1e9, 9e29] {
        for cell in [1e-9, 1.0, 1e9] {
            sound(&figures(&land(70, 70, cell, |i, j| scale * libm::sin(i * 1.3 + j * j * 0.11))));
        }
    }
}

#[test]
fn work_that_was_stopped_ends() {
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = Figures::of(&land(70, 70, 1.0, |i, j| i * j), None, &Work::new(&cancel));
    assert!(stopped.is_err());
}

#[test]
fn threads_change_no_bit() {
    let rough = land(203, 187, 12.0, |i, j| {
        let z = 80.0 * libm::sin(i * 0.21) * libm::cos(j * 0.17) + 9.0 * libm::sin(i * j * 0.37);
        if libm::hypot(i - 150.0, j - 20.0) < 9.0 { f64::NAN } else { z }
    });
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| figures(&rough))
    };
    let alone = with(1);
    sound(&alone);
    assert_eq!(format!("{alone:?}"), format!("{:?}", with(3)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn no_land_is_too_odd(
        cols in 1usize..40,
        rows in 1usize..40,
        steps in 1u32..6,
        voids in 0u32..100,
        seed in any::<u64>(),
    ) {
        let mix = |k: usize, n: u64| hash::nth(seed, k as u64 * 2 + n) as u32;
        let height = |k: usize| if mix(k, 0) % 100 < voids { f32::NAN } else { (mix(k, 1) % steps) as f32 };
        let any = Land::new(cols, rows, 7.0, (0..cols * rows).map(height).collect());
        if let Some(found) = Figures::of(&any, Some(3.0 * 49.0), &Work::default()).unwrap() {
            sound(&found);
        }
    }
}
