//! Carrying from level to level: what is there stays, and nothing comes from nowhere.

use orograph::kit::erosion::Ladder;
use orograph::kit::erosion::ladder::Level;
use orograph::kit::erosion::prolong::{Carried, Curve, Least, Rule, Volume, prolong, sum};
use orograph::kit::hash::unit;
use orograph::value::{Grid, Lattice};
use orograph::work::Work;

/// Every two neighbouring levels of ladders of several shapes.
fn pairs() -> Vec<[Level; 2]> {
    let mut pairs = Vec::new();
    for (cols, rows) in [(257usize, 257usize), (300, 77), (101, 200), (1, 150), (140, 2)] {
        let lattice = Lattice { origin: [0.0; 2], span: 4096.0, intervals: (cols.max(rows) - 1) as u32 };
        let base = Grid { lattice, col: 0, row: 0, cols, rows };
        let ladder = Ladder::new(&base, f64::INFINITY);
        pairs.extend(ladder.levels().windows(2).map(|pair| [pair[0], pair[1]]));
    }
    pairs
}

fn carry(levels: &[Level; 2], values: &[f32], rule: &Rule<'_>) -> Carried {
    prolong([&levels[0], &levels[1]], values, rule, &Work::default()).unwrap()
}

/// Lumps of up to ten metres on a third of the points, in random places.
fn lumps(level: &Level, seed: u64) -> Vec<f32> {
    let lump = |i: u64| if unit(seed, i) < 0.3 { (10.0 * unit(seed + 1, i)) as f32 } else { 0.0 };
    (0..level.grid.len() as u64).map(lump).collect()
}

#[test]
fn amounts_stay_above_0_and_none_is_lost() {
    for (seed, levels) in pairs().iter().enumerate() {
        let values = lumps(&levels[0], seed as u64);
        for curve in [Curve::Smooth, Curve::Straight] {
            let carried = carry(levels, &values, &Rule { curve, ..Rule::AMOUNT });
            let before = sum(&values, |value| value) * levels[0].cell_area();
            let after = sum(&carried.values, |value| value) * levels[1].cell_area();
            assert!(carried.values.iter().all(|&value| value >= 0.0));
            assert!((after / before - 1.0).abs() < 1e-7, "{after} of {before}, {levels:?}");
            assert!((before - after - carried.left_behind).abs() < 1e-6 * before);
        }
    }
}

#[test]
fn changes_with_a_floor_of_their_own_keep_their_sum() {
    for (seed, levels) in pairs().iter().enumerate() {
        let mut values = lumps(&levels[0], seed as u64);
        values.iter_mut().step_by(2).for_each(|value| *value = -*value);
        let floor: Vec<f32> = (0..levels[1].grid.len() as u64).map(|i| -8.0 * unit(9, i) as f32).collect();
        let rule = Rule { least: Least::Each(&floor), ..Rule::AMOUNT };
        let carried = carry(levels, &values, &rule);
        assert!(carried.values.iter().zip(&floor).all(|(value, floor)| value >= floor));
        let moved = sum(&values, f32::abs) * levels[0].cell_area();
        assert!(carried.left_behind.abs() < 1e-7 * moved, "{levels:?}");
    }
}

#[test]
fn where_a_bound_leaves_no_room_the_rest_is_told() {
    let [from, to] = pairs()[0];
    let values = vec![-1.0; from.grid.len()];
    let carried = carry(&[from, to], &values, &Rule::AMOUNT);
    assert!(carried.values.iter().all(|&value| value == 0.0));
    assert_eq!(carried.left_behind, -from.cell_area() * from.grid.len() as f64);
}

#[test]
fn what_nothing_touched_stays_0_to_the_bit() {
    for levels in pairs() {
        let (cols, rows) = (levels[0].grid.cols, levels[0].grid.rows);
        let mut values = vec![0.0; cols * rows];
        values[rows / 2 * cols + cols / 2] = 100.0;
        let carried = carry(&levels, &values, &Rule::AMOUNT).values;
        for (n, &value) in carried.iter().enumerate() {
            let [i, j] = [n % levels[1].grid.cols, n / levels[1].grid.cols];
            let away = |i, centre: usize| (levels[1].steps_on(&levels[0], i) - centre as f64).abs();
            if away(i, cols / 2) >= 2.0 || away(j, rows / 2) >= 2.0 {
                assert_eq!(value.to_bits(), 0, "{i} {j} of {levels:?}");
            }
        }
    }
}

#[test]
fn a_mask_of_0_takes_nothing() {
    for levels in pairs() {
        let mask: Vec<f32> = (0..levels[1].grid.len() as u64).map(|i| (i % 3) as f32 / 2.0).collect();
        let values = lumps(&levels[0], 5);
        let rule = Rule { mask: Some(&mask), ..Rule::AMOUNT };
        let carried = carry(&levels, &values, &rule);
        assert!(carried.values.iter().zip(&mask).all(|(value, mask)| *mask > 0.0 || value.to_bits() == 0));
        let before = sum(&values, |value| value) * levels[0].cell_area();
        assert!(carried.left_behind.abs() < 1e-7 * before);
    }
}

#[test]
fn heights_are_carried_by_a_smooth_curve_through_them() {
    let wave = |x: f64, y: f64| (40.0 * libm::sin(x * 8e-3) * libm::cos(y * 6e-3) + 0.02 * x) as f32;
    for levels in pairs() {
        let on = |level: &Level| -> Vec<f32> {
            let point = |n: usize| wave(level.grid.x(n % level.grid.cols), level.grid.y(n / level.grid.cols));
            (0..level.grid.len()).map(point).collect()
        };
        let carried = carry(&levels, &on(&levels[0]), &Rule::CHANGE).values;
        // A natural end has no curvature, which the wave has: only the inside is the wave's.
        let [cols, rows] = [levels[1].grid.cols, levels[1].grid.rows];
        let inside = |i: usize, n: usize| n <= 2 || (12..n - 12).contains(&i);
        for (n, want) in on(&levels[1]).into_iter().enumerate() {
            if cols > 30 && rows > 30 && inside(n % cols, cols) && inside(n / cols, rows) {
                assert!((carried[n] - want).abs() < 0.05, "{} not {want}", carried[n]);
            }
        }
        let plane: Vec<f32> = on(&levels[0]).iter().map(|_| 3.5).collect();
        assert!(
            carry(&levels, &plane, &Rule { volume: Volume::Free, ..Rule::AMOUNT })
                .values
                .iter()
                .all(|value| (value - 3.5).abs() < 1e-5)
        );
    }
}
