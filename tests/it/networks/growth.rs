//! Networks grown on a map: what is left out, how they branch, that nothing crosses.

use orograph::kit::predicates::Point;
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::grow::{Growth, Line};
use orograph::kit::rivers::statistics::Statistics;
use orograph::value::{Bounds, Rivers};
use orograph::work::{Cancel, Work};
use proptest::prelude::*;

use super::{LINE, SIDE, SQUARE, crossings, grow, growth, mean, rivers, seeds};

/// The figures of the links of a network with one line, whose first vertex is its outlet.
fn statistics(rivers: &Rivers) -> Statistics {
    let links = &rivers.vertices()[1..];
    Statistics::of(&links.iter().map(|vertex| vertex.down.unwrap().checked_sub(1)).collect::<Vec<_>>())
}

#[test]
fn grown_networks_leave_little_out_and_branch_as_they_should() {
    for (phi, depth) in [(2_u8, 6), (3, 5), (4, 5)] {
        let rule = Branching::Generator(phi);
        let (mut left_out, mut found) = (Vec::new(), Vec::new());
        for seed in seeds(50, 6) {
            let grown = grow(&growth(rule, depth + 1, seed), &[LINE]);
            left_out.push(grown.left_out as f64 / grown.asked as f64);
            let rivers = rivers(&grown);
            assert_eq!(crossings(rivers.vertices()), [[0; 2]; 0], "φ {phi}, seed {seed}");
            found.push(statistics(&rivers).side_branches());
        }
        assert!(mean(&left_out) <= 0.03, "φ {phi}: {left_out:?}");
        let (phi, r) = (f64::from(phi), rule.interior(1));
        for (k, want) in [phi - 1.0, r * phi, r * phi * (r + 1.0)].into_iter().enumerate() {
            let found = mean(&found.iter().map(|t| t[k]).collect::<Vec<_>>());
            assert!((found / want - 1.0).abs() < 0.05, "φ {phi}: T_{} {found}, not {want}", k + 1);
        }
    }
}

#[test]
fn a_line_has_the_depth_of_equation_3() {
    let line = |share: f64| Line { from: [0.0; 2], to: [0.0, share * SIDE] };
    let depths = [0.01, 0.24, 0.26, 1.0].map(|share| line(share).depth(SQUARE, 6));
    assert_eq!(depths, [1, 1, 2, 6]);
    // A line of depth 1 is one link.
    let grown = grow(&growth(Branching::Generator(2), 6, 1), &[line(0.1)]);
    assert_eq!((grown.at, grown.asked), (vec![[0.0, 0.0], [0.0, 0.1 * SIDE]], 0));
}

#[test]
fn a_main_stem_ends_where_its_line_does() {
    for phi in [1, 2, 3, 5] {
        for seed in 0..4 {
            let grown = grow(&Growth { wander: 0.0, ..growth(Branching::Generator(phi), 4, seed) }, &[LINE]);
            let far = |at: &Point| libm::hypot(at[0] - LINE.to[0], at[1] - LINE.to[1]);
            let nearest = grown.at.iter().map(far).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6, "φ {phi}, seed {seed}: {nearest} m");
        }
    }
}

#[test]
fn networks_keep_their_clearance_from_each_other_and_the_border() {
    let lines = [
        Line { from: [0.0, 4000.0], to: [7000.0, 5000.0] },
        Line { from: [4000.0, SIDE], to: [5000.0, 9000.0] },
        Line { from: [12_000.0, 0.0], to: [11_000.0, 7000.0] },
        Line { from: [SIDE, 12_000.0], to: [9000.0, 11_000.0] },
    ];
    let rivers = rivers(&grow(&growth(Branching::Generator(2), 8, 5), &lines));
    assert_eq!(rivers.outlets().count(), 4);
    assert_eq!(crossings(rivers.vertices()), [[0; 2]; 0]);
    let inner = SQUARE.grown(-1.0);
    let is_inside = |at: Point| (0..2).all(|k| (inner.min[k]..inner.max[k]).contains(&at[k]));
    assert!(rivers.links().all(|(upper, _)| is_inside(rivers.vertices()[upper].at)));
}

#[test]
fn rivers_stay_on_land() {
    let is_land = |at: Point| at[0] < 11_000.0;
    let grown = grow(&Growth { is_land: &is_land, ..growth(Branching::Generator(2), 6, 2) }, &[LINE]);
    // Points that divide a link may move to the side by a little.
    assert!(grown.at.iter().all(|at| at[0] < 11_200.0) && grown.at.len() > 100);
    let nowhere = Growth { is_land: &|_| false, ..growth(Branching::Generator(2), 6, 2) };
    let grown = grow(&nowhere, &[LINE]);
    // The first link is the artist's, and what divides it.
    assert_eq!(grown.left_out, grown.asked);
    assert!(grown.at.iter().all(|at| at[0] > 7000.0));
}

#[test]
fn lines_that_cross_are_left_out_and_named() {
    let lines = [
        Line { from: [4000.0, 0.0], to: [4000.0, 1800.0] },
        Line { from: [3000.0, 900.0], to: [5000.0, 900.0] },
        Line { from: [9000.0, 0.0], to: [9000.0, 1800.0] },
    ];
    let grown = grow(&growth(Branching::Generator(2), 6, 2), &lines);
    assert_eq!((grown.crossing, grown.at.len()), (vec![1], 4));
}

#[test]
fn growth_is_the_same_for_any_number_of_threads_and_stops_when_asked() {
    let growth = growth(Branching::Generator(3), 5, 7);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let four = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    assert_eq!(one.install(|| grow(&growth, &[LINE])), four.install(|| grow(&growth, &[LINE])));
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(growth.grow(&[LINE], &Work::new(&cancel)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_lines_give_a_forest_that_is_finite_and_crosses_nothing(
        lines in prop::collection::vec((0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0), 1..8),
        rule in prop_oneof![
            (1_u8..=8).prop_map(Branching::Generator),
            (0.0..6.0, 0.5..6.0).prop_map(|(a, c)| Branching::Statistics { a, c }),
        ],
        max_depth in 1_u32..6,
        angle in 0.1..1.4,
        lengthen in 0.0..1.0,
        wander in 0.0..0.3,
        clearance in 0.05..0.6,
        depth in 10.0..2e6,
        seed in any::<u64>(),
    ) {
        let bounds = Bounds { min: [-1e6, 5e6], max: [-1e6 + 30_000.0, 5e6 + depth] };
        let place = |x: f64, y: f64| [bounds.min[0] + x * bounds.width(), bounds.min[1] + y * bounds.depth()];
        let line = |&(a, b, c, d): &(f64, f64, f64, f64)| Line { from: place(a, b), to: place(c, d) };
        let lines: Vec<Line> = lines.iter().map(line).filter(|line| line.length() > 0.0).collect();
        let growth = Growth { bounds, branching: rule, max_depth, angle, lengthen, wander, clearance, seed, is_land: &|_| true };
        prop_assume!(growth.links(&lines) < 5000.0);
        let grown = grow(&growth, &lines);
        // Rivers refuses what is no forest, and what is not finite.
        let rivers = Rivers::new(grown.vertices().unwrap()).unwrap();
        prop_assert_eq!(rivers.outlets().count() + grown.crossing.len(), lines.len());
        prop_assert_eq!(crossings(rivers.vertices()), [[0; 2]; 0]);
    }
}
