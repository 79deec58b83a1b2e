//! Rivers and ridges on samples.

use orograph::kit::land::{Feature, Line, Skeleton};
use orograph::kit::noise::{Form, Fractal, Spectrum};
use orograph::value::{Grid, Lattice};
use orograph::work::{Cancel, Cancelled, Work};
use proptest::prelude::*;

/// A grid whose first sample stands at (0, 0), with cells of a metre.
fn grid(cols: usize, rows: usize) -> Grid {
    let lattice = Lattice { origin: [0.0, 0.0], span: 64.0, intervals: 64 };
    Grid { lattice, col: 0, row: 0, cols, rows }
}

fn line(a: [f64; 2], b: [f64; 2], heights: [f64; 2]) -> Line {
    Line { ends: [a, b], heights }
}

fn drawn(grid: Grid, rivers: &[Line], ridges: &[Line], noise: Option<&Fractal>) -> Skeleton {
    let (mut skeleton, work) = (Skeleton::new(grid), Work::default());
    skeleton.rivers(&work, rivers.iter().copied()).unwrap();
    skeleton.ridges(&work, ridges.iter().copied()).unwrap();
    skeleton.roughen(&work, noise).unwrap();
    skeleton
}

/// Columns and rows of the samples that have a feature.
fn places(skeleton: &Skeleton, cols: usize, feature: Feature) -> Vec<[usize; 2]> {
    let is = |k: &usize| skeleton.features[*k] == feature;
    (0..skeleton.features.len()).filter(is).map(|k| [k % cols, k / cols]).collect()
}

/// Noise that is high enough to take any ridge of these tests below any river.
fn noise(seed: u64) -> Fractal {
    let spectrum = Spectrum { feature_size: 5.0, octaves: 3, lacunarity: 2.0, gain: 0.5 };
    Fractal::new(Form::Fbm, spectrum, seed, 0.0, 5000.0)
}

#[test]
fn lines_follow_bresenham_and_rise_evenly() {
    let g = grid(12, 8);
    let found = drawn(g, &[line([1.0, 1.0], [9.0, 4.0], [10.0, 18.0])], &[], None);
    // Of every column the row nearest to the line: 1 + 3/8 of the columns gone.
    let wanted: Vec<_> =
        (1..=9_usize).map(|i| [i, (1.0 + 0.375 * (i as f64 - 1.0) + 0.5).floor() as usize]).collect();
    let mut places = places(&found, 12, Feature::River);
    places.sort_unstable();
    assert_eq!(places, wanted);
    for [i, j] in wanted {
        assert_eq!(found.height[j * 12 + i], 9.0 + i as f32);
    }
    assert!(found.height.iter().zip(&found.features).all(|(h, f)| *f != Feature::Open || *h == 0.0));
}

#[test]
fn the_lowest_river_wins_over_others_and_over_any_ridge_and_the_highest_ridge_over_ridges() {
    let g = grid(9, 9);
    let across = |row: f64, height: f64| line([0.0, row], [8.0, row], [height; 2]);
    let down = |col: f64, height: f64| line([col, 0.0], [col, 8.0], [height; 2]);
    for rivers in [[across(4.0, 30.0), down(4.0, 20.0)], [down(4.0, 20.0), across(4.0, 30.0)]] {
        for ridges in [[across(2.0, 90.0), down(6.0, 80.0)], [down(6.0, 80.0), across(2.0, 90.0)]] {
            let found = drawn(g, &rivers, &ridges, None);
            assert_eq!(found.height[4 * 9 + 4], 20.0, "where two rivers cross");
            assert_eq!((found.height[2 * 9 + 4], found.features[2 * 9 + 4]), (20.0, Feature::River));
            assert_eq!((found.height[4 * 9 + 6], found.features[4 * 9 + 6]), (30.0, Feature::River));
            assert_eq!(found.height[2 * 9 + 6], 90.0, "where two ridges cross");
        }
    }
    // Of a line within one sample the end that wins.
    let found = drawn(
        g,
        &[line([3.1, 3.2], [2.9, 2.8], [7.0, 5.0])],
        &[line([6.1, 6.2], [5.9, 5.8], [7.0, 5.0])],
        None,
    );
    assert_eq!((found.height[3 * 9 + 3], found.height[6 * 9 + 6]), (5.0, 7.0));
}

#[test]
fn noise_is_that_of_the_place_and_leaves_rivers_alone() {
    let g = grid(40, 30);
    let rivers = [line([0.0, 25.0], [39.0, 28.0], [5.0, 9.0])];
    let ridges = [line([0.0, 3.0], [39.0, 14.0], [9000.0, 9500.0])];
    let (plain, rough) = (drawn(g, &rivers, &ridges, None), drawn(g, &rivers, &ridges, Some(&noise(3))));
    assert_eq!(plain.features, rough.features);
    for [i, j] in places(&rough, 40, Feature::Ridge) {
        let mut wanted = [0.0];
        noise(3).over(&[g.x(i)]).row(g.y(j), &mut wanted);
        assert_eq!(rough.height[j * 40 + i], plain.height[j * 40 + i] + wanted[0]);
    }
    for [i, j] in places(&rough, 40, Feature::River) {
        assert_eq!(rough.height[j * 40 + i], plain.height[j * 40 + i]);
    }
}

#[test]
fn lines_that_are_far_off_or_not_finite_cost_nothing_and_those_that_cross_the_grid_are_clipped() {
    let g = grid(10, 6);
    let far = line([-1e9, -1e9], [1e9, 1e9], [0.0, 1.0]);
    let found = drawn(
        g,
        &[far, line([f64::NAN, 0.0], [3.0, 3.0], [1.0; 2])],
        &[line([1e300, 4.0], [4.0, 1.0], [0.0; 2])],
        None,
    );
    let wanted: Vec<_> = (0..6).map(|k| [k, k]).collect();
    assert_eq!(places(&found, 10, Feature::River), wanted);
    assert!(found.height.iter().take(1).all(|h| (h - 0.5).abs() < 1e-6));
    let aside = drawn(g, &[line([-50.0, 20.0], [50.0, 20.0], [1.0; 2])], &[], None);
    assert_eq!(places(&aside, 10, Feature::River), [[0; 2]; 0]);
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = Skeleton::new(g).rivers(&Work::new(&cancel), [far].into_iter());
    assert_eq!(stopped, Err(Cancelled));
}

#[test]
fn a_cleared_skeleton_is_as_new() {
    let g = grid(10, 6);
    let mut found = drawn(g, &[line([0.0, 0.0], [9.0, 5.0], [3.0, 4.0])], &[], None);
    assert_ne!(found, Skeleton::new(g));
    found.clear();
    assert_eq!(found, Skeleton::new(g));
}

fn any_lines(most: usize) -> impl Strategy<Value = Vec<Line>> {
    let point = || [-9.0..50.0f64, -9.0..50.0f64];
    let one = (point(), point(), [-100.0..100.0f64, -100.0..100.0f64]);
    prop::collection::vec(one.prop_map(|(a, b, h)| line(a, b, h)), 0..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_ridge_lies_below_a_river_beside_it(
        rivers in any_lines(8), ridges in any_lines(12),
        (cols, rows) in prop_oneof![Just((1, 40)), Just((40, 1)), (2usize..45, 2usize..45)],
        seed in 0u64..99,
    ) {
        let found = drawn(grid(cols, rows), &rivers, &ridges, Some(&noise(seed)));
        let at = |i: usize, j: usize| (found.features[j * cols + i], found.height[j * cols + i]);
        for [i, j] in places(&found, cols, Feature::Ridge) {
            for y in j.saturating_sub(1)..(j + 2).min(rows) {
                for x in i.saturating_sub(1)..(i + 2).min(cols) {
                    let (feature, river) = at(x, y);
                    prop_assert!(feature != Feature::River || at(i, j).1 >= river);
                }
            }
        }
    }

    #[test]
    fn a_chain_of_lines_has_no_gap(points in prop::collection::vec([0.0..44.0f64, 0.0..44.0f64], 2..12)) {
        let lines: Vec<_> = points.windows(2).map(|p| line(p[0], p[1], [0.0; 2])).collect();
        let found = drawn(grid(45, 45), &lines, &[], None);
        let all = places(&found, 45, Feature::River);
        // What is reached from the first sample over all eight neighbours.
        let mut reached = vec![all[0]];
        let mut next = 0;
        while next < reached.len() {
            let [i, j] = reached[next];
            let near = all.iter().filter(|[x, y]| x.abs_diff(i) <= 1 && y.abs_diff(j) <= 1);
            let fresh: Vec<_> = near.filter(|p| !reached.contains(p)).copied().collect();
            reached.extend(fresh);
            next += 1;
        }
        prop_assert_eq!(reached.len(), all.len());
        for [x, y] in points {
            prop_assert!(all.contains(&[x.round() as usize, y.round() as usize]));
        }
    }
}
