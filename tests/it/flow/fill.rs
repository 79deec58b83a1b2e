//! Filling, with and without a slope, and cutting.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use orograph::kit::flow::{Depressions, Tree, breach, epsilon};
use orograph::work::Work;
use proptest::prelude::*;

use super::ground::{Ground, bits, grounds};

fn filled(ground: &Ground) -> Vec<f32> {
    let surface = ground.surface();
    Depressions::find(&surface, &Work::default()).unwrap().filled(&surface, &Work::default()).unwrap()
}

/// Filling by a queue of all cells in the order of height.
fn priority_flood(ground: &Ground) -> Vec<f32> {
    let mut filled = ground.height.clone();
    let mut reached: Vec<bool> = (0..ground.len()).map(|cell| ground.is_seed(cell)).collect();
    let key = |height: f32, cell: usize| Reverse(((f64::from(height) * 1e6) as i64, cell));
    let mut queue: BinaryHeap<_> =
        (0..ground.len()).filter(|&cell| reached[cell]).map(|cell| key(filled[cell], cell)).collect();
    while let Some(Reverse((_, cell))) = queue.pop() {
        for i in ground.around(cell) {
            if !std::mem::replace(&mut reached[i], true) {
                filled[i] = filled[i].max(filled[cell]);
                queue.push(key(filled[i], i));
            }
        }
    }
    filled
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn filling_is_the_least_height_to_climb(ground in grounds()) {
        prop_assert_eq!(bits(&filled(&ground)), bits(&ground.lowest(|height| height)));
    }

    #[test]
    fn filling_with_a_slope_is_the_lowest_such_surface(ground in grounds(), rise in 0.0f32..0.5) {
        let found = epsilon::fill(&ground.surface(), rise.into(), &Work::default()).unwrap();
        let wanted = ground.lowest(|height| (height + rise).max(height.next_up()));
        prop_assert_eq!(bits(&found), bits(&wanted));
    }

    #[test]
    fn cutting_leaves_nothing_that_does_not_drain(ground in grounds(), deepest in 0.0f64..8.0) {
        for deepest in [None, Some(0.0), Some(deepest)] {
            let cut = breach::cut(&ground.surface(), deepest, &Work::default()).unwrap();
            let after = Ground { height: cut, ..ground.clone() };
            prop_assert_eq!(bits(&filled(&after)), bits(&after.height), "{:?}", deepest);
            for cell in (0..after.len()).filter(|&cell| !after.is_seed(cell)) {
                let lower = |i: usize| !after.is_land(i) || after.height[i] < after.height[cell];
                let shore = after.sea.map(|sea| (sea as f32).next_up());
                prop_assert!(after.around(cell).into_iter().any(lower) || shore == Some(after.height[cell]));
            }
        }
    }

    #[test]
    fn cuts_are_no_deeper_than_they_may_be(ground in grounds(), deepest in 0.0f64..8.0) {
        let cut = breach::cut(&ground.surface(), Some(deepest), &Work::default()).unwrap();
        for (cell, (&after, &before)) in cut.iter().zip(&ground.height).enumerate() {
            // The bottom of a cut falls by a ten-thousandth of a metre from cell to cell.
            let kept = f64::from(after) >= f64::from(before) - deepest - 0.1;
            prop_assert!(kept || before.is_nan(), "{}: {} from {}", cell, after, before);
        }
    }
}

#[test]
fn filling_agrees_with_a_priority_flood() {
    for (cols, rows, seed) in [(300, 217, 1), (128, 400, 2), (257, 257, 3), (9, 900, 4)] {
        let ground = Ground::rough(cols, rows, seed);
        let found = filled(&ground);
        assert_eq!(found, priority_flood(&ground), "{cols}x{rows}");
        let raised = found.iter().zip(&ground.height).filter(|(a, b)| a > b).count();
        assert!(raised * 50 > ground.len(), "hardly any depression: {raised}");
    }
}

#[test]
fn cutting_and_filling_keep_what_drains() {
    let ground = Ground::of(70, 50, |c, r| (c * 3 + r) as f32 * 0.25);
    for deepest in [None, Some(2.0)] {
        assert_eq!(breach::cut(&ground.surface(), deepest, &Work::default()).unwrap(), ground.height);
    }
    assert_eq!(filled(&ground), ground.height);
    assert_eq!(epsilon::fill(&ground.surface(), 0.1, &Work::default()).unwrap(), ground.height);
    let mut rough = Ground::rough(90, 70, 8);
    let tree = Tree::of(&rough.surface(), &Work::default()).unwrap();
    let cut = breach::cut(&rough.surface(), None, &Work::default()).unwrap();
    let changed = cut.iter().zip(&rough.height).filter(|(a, b)| a != b).count();
    assert!(changed > 100 && changed < rough.len(), "{changed}");
    assert!(cut.iter().zip(&rough.height).all(|(after, before)| after <= before), "nothing is raised");
    // Where the water climbs it is cut, and only cells on the way of others are.
    for cell in 0..rough.len() {
        if let Some(down) = tree.receiver(cell) {
            let sinks = rough.height[down] > rough.height[cell] && rough.is_land(down);
            assert!(!sinks || cut[down] < rough.height[down]);
        }
    }
    rough.height = cut;
    assert_eq!(filled(&rough), rough.height);
}

#[test]
fn a_deep_pit_is_filled_as_far_as_a_cut_does_not_reach() {
    // A cone with a hole of 100 m, whose rim is 20 m high.
    let hole = |c: usize, r: usize| {
        let d = libm::hypotf(c as f32 - 20.0, r as f32 - 20.0);
        if d < 5.0 { 20.0 * d - 100.0 } else { 20.0 - d }
    };
    let ground = Ground::of(41, 41, hole);
    let pit = 20 * 41 + 20;
    let level = filled(&ground)[pit];
    assert!(level > 10.0, "{level}");
    for (deepest, wanted) in
        [(None, -100.0), (Some(0.0), level), (Some(8.0), level - 8.0), (Some(1000.0), -100.0)]
    {
        let cut = breach::cut(&ground.surface(), deepest, &Work::default()).unwrap();
        assert!((cut[pit] - wanted).abs() < 0.01, "{deepest:?}: {} and not {wanted}", cut[pit]);
    }
}
