//! Where water goes, and how much of it.

use orograph::kit::flow::neighbor::{LENGTH, NONE};
use orograph::kit::flow::{Depressions, Rule, Spread, Tree, accumulate};
use orograph::work::Work;
use proptest::prelude::*;

use super::ground::{Ground, grounds};

pub(crate) const RULES: [Rule; 4] = [
    Rule::Infinity,
    Rule::Slopes { exponent: 1.1 },
    Rule::Slopes { exponent: 0.0 },
    Rule::Slopes { exponent: 25.0 },
];

pub(crate) fn tree(ground: &Ground) -> Tree {
    Tree::of(&ground.surface(), &Work::default()).unwrap()
}

pub(crate) fn filled(ground: &Ground) -> Vec<f32> {
    let surface = ground.surface();
    Depressions::find(&surface, &Work::default()).unwrap().filled(&surface, &Work::default()).unwrap()
}

/// The cells from one down to its outlet.
pub(crate) fn way(tree: &Tree, from: usize) -> Vec<usize> {
    let way: Vec<usize> =
        std::iter::successors(Some(from), |&cell| tree.receiver(cell)).take(tree.cells.len() + 1).collect();
    assert!(way.len() <= tree.cells.len(), "a way that comes back");
    way
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_way_ends_at_an_outlet_and_climbs_no_more_than_it_must(ground in grounds()) {
        let (tree, level) = (tree(&ground), ground.lowest(|height| height));
        for cell in numbers(ground.len()) {
            let way = way(&tree, cell);
            prop_assert!(ground.is_seed(*way.last().unwrap()));
            prop_assert_eq!(tree.receiver(cell).is_some() || ground.is_seed(cell), true);
            prop_assert!(ground.is_land(cell) || tree.directions()[cell] == NONE);
            for &i in way.iter().filter(|&&i| ground.is_land(i)) {
                prop_assert!(ground.height[i] <= level[cell], "{} over {} m", i, level[cell]);
            }
        }
    }

    #[test]
    fn amounts_at_outlets_sum_to_the_whole(ground in grounds()) {
        let (surface, tree, filled) = (ground.surface(), tree(&ground), filled(&ground));
        let work = Work::default();
        let land = (0..ground.len()).filter(|&cell| ground.is_land(cell)).count();
        let roots: Vec<usize> = (0..ground.len()).filter(|&cell| tree.receiver(cell).is_none()).collect();
        let count = accumulate::count(&tree, |cell| ground.is_land(cell), &work).unwrap();
        prop_assert_eq!(roots.iter().map(|&cell| count[cell] as usize).sum::<usize>(), land);
        let amount = |cell: usize| if ground.is_land(cell) { 1.0 + (cell % 3) as f64 } else { 0.0 };
        let amounts: Vec<f64> = (0..ground.len()).map(amount).collect();
        let whole: f64 = amounts.iter().sum();
        for rule in RULES {
            let spread = Spread::new(surface, &tree, &filled, rule);
            let sum = spread.accumulate(amounts.clone(), &work).unwrap();
            let out: f64 = roots.iter().map(|&cell| sum[cell]).sum();
            prop_assert!((out - whole).abs() <= 1e-9 * whole.max(1.0), "{:?}: {} of {}", rule, out, whole);
            prop_assert!(sum.iter().zip(&amounts).all(|(sum, own)| sum >= own));
        }
    }

    #[test]
    fn shares_go_down_and_are_one_together(ground in grounds()) {
        let (surface, tree, filled) = (ground.surface(), tree(&ground), filled(&ground));
        for rule in RULES {
            let spread = Spread::new(surface, &tree, &filled, rule);
            for cell in numbers(ground.len()) {
                let shares = spread.shares(cell);
                let sum: f64 = shares.iter().sum();
                let wanted = if tree.receiver(cell).is_some() { 1.0 } else { 0.0 };
                prop_assert!((sum - wanted).abs() < 1e-12, "{:?} {}: {:?}", rule, cell, shares);
                let [x, y] = spread.direction(cell);
                let length = libm::hypot(x, y);
                prop_assert!(length < 1e-9 || (length - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn basins_part_the_land_and_have_one_outlet_each(ground in grounds()) {
        let tree = tree(&ground);
        let basins = tree.basins(|cell| ground.is_land(cell), &Work::default()).unwrap();
        let mut outlets = std::collections::BTreeMap::new();
        for cell in numbers(ground.len()) {
            prop_assert_eq!(basins[cell] > 0, ground.is_land(cell));
            if basins[cell] > 0 {
                let outlet = *way(&tree, cell).last().unwrap();
                prop_assert_eq!(*outlets.entry(basins[cell]).or_insert(outlet), outlet);
            }
        }
        // As many outlets as basins, and both in one order.
        let all: Vec<usize> = outlets.values().copied().collect();
        prop_assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
        prop_assert!(outlets.keys().copied().eq(1..=outlets.len() as u32));
    }

    #[test]
    fn sums_and_distances_are_those_of_walking_every_way(ground in grounds()) {
        let tree = tree(&ground);
        let mut count = vec![0u32; ground.len()];
        let distance = tree.distance(&Work::default()).unwrap();
        for cell in numbers(ground.len()) {
            let way = way(&tree, cell);
            if ground.is_land(cell) {
                way.iter().for_each(|&i| count[i] += 1);
            }
            let length: f64 = way.iter().map(|&i| tree.length(i)).sum();
            prop_assert!((distance[cell] - length).abs() < 1e-9);
        }
        prop_assert_eq!(accumulate::count(&tree, |cell| ground.is_land(cell), &Work::default()).unwrap(), count);
    }
}

#[test]
fn water_goes_the_steepest_way_and_of_equal_ones_the_first() {
    let ground = Ground::rough(120, 90, 5);
    let (tree, filled) = (tree(&ground), filled(&ground));
    let mut ties = 0;
    // The ways of pits leave the steepest descent; they and what touches them are left out.
    let dry = |cell: usize| filled[cell] == ground.height[cell];
    let plain =
        |cell: &usize| ground.is_land(*cell) && tree.cells.around(*cell).all(|(_, i)| dry(i)) && dry(*cell);
    for cell in (0..ground.len()).filter(plain) {
        let slopes: Vec<(f64, usize)> = (tree.cells.around(cell))
            .map(|(k, i)| ((ground.height[cell] - ground.height[i]) as f64 / LENGTH[k as usize], i))
            .collect();
        let steepest = slopes.iter().map(|(slope, _)| *slope).fold(0.0, f64::max);
        let all: Vec<usize> = slopes.iter().filter(|(s, _)| *s >= steepest - 1e-6).map(|(_, i)| *i).collect();
        if steepest > 0.0 {
            ties += usize::from(all.len() > 1);
            // Diagonal and straight descents are never quite equal.
            assert_eq!(tree.receiver(cell), all.first().copied(), "cell {cell}");
        }
    }
    assert!(ties > 50, "hardly any tie: {ties}");
}

#[test]
fn flats_drain_to_their_nearest_exit() {
    // A table with one notch, on a slope to the west.
    let height = |c: usize, r: usize| match (c, r) {
        (0, _) => 0.0,
        (1, 12) => 1.0,
        (1, _) | (40, _) | (_, 0 | 24) => 9.0,
        _ => 5.0,
    };
    let ground = Ground::of(41, 25, height);
    let tree = tree(&ground);
    for (c, r) in (2..40).flat_map(|c| (1..24).map(move |r| (c, r))) {
        // In eight directions a way has as many steps as the longer of its two sides.
        let steps = way(&tree, r * 41 + c).iter().filter(|&&i| ground.height[i] == 5.0).count();
        let nearest =
            [11, 12, 13].map(|row: usize| (c - 2).max(row.abs_diff(r))).into_iter().min().unwrap() + 1;
        assert_eq!(steps, nearest, "from {c}, {r}");
    }
}

#[test]
fn the_water_of_a_pit_keeps_to_the_bottom_of_its_valley() {
    // A valley to the south with a bar across, lowest in the middle.
    let height = |c: usize, r: usize| {
        let side = (c as f32 - 10.0).abs() * 3.0;
        side + 50.0 - r as f32 + if r == 30 { 25.0 + side } else { 0.0 }
    };
    let ground = Ground::of(21, 60, height);
    let tree = tree(&ground);
    let way = way(&tree, 12 * 21 + 4);
    let from = way.iter().position(|i| i / 21 > 20).unwrap();
    assert!(way[from..].iter().all(|i| i % 21 == 10), "{:?}", &way[from..]);
    assert_eq!(way.last(), Some(&(59 * 21 + 10)));
}

/// The numbers of so many cells.
fn numbers(count: usize) -> std::ops::Range<usize> {
    0..count
}

/// On a plane whose fall line lies between the eight directions, ways that are drawn run along it on the whole, where those
/// of steepest descent turn aside by up to 22.5°.
#[test]
fn drawn_ways_run_where_the_water_does() {
    let size = 201;
    for degrees in [0.0f64, 10.0, 22.5, 30.0, 45.0] {
        let [east, south] = [libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians())];
        let height = |k: usize| -(east * (k % size) as f64 + south * (k / size) as f64) as f32;
        let heights: Vec<f32> = (0..size * size).map(height).collect();
        let surface = orograph::kit::flow::Surface::new(size, size, 1.0, &heights, None);
        let tree = Tree::of(&surface, &Work::default()).unwrap();
        let spread = Spread::new(surface, &tree, &heights, Rule::Infinity);
        // Ways that meet go on together, so that each draw counts once: from near the north-west corner, 150 cells on.
        let (mut x, mut y) = (0.0, 0.0);
        for seed in 0..120 {
            let chance = |cell: usize| orograph::kit::hash::unit(seed, cell as u64);
            let way = way(&spread.draw(chance, &Work::default()).unwrap(), 10 * size + 10);
            let to = way[way.len().min(150) - 1];
            x += (to % size) as f64 - 10.0;
            y += (to / size) as f64 - 10.0;
        }
        let off = libm::atan2(y, x).to_degrees() - degrees;
        assert!(off.abs() < 1.0, "{degrees}°: {off}° aside");
    }
}

proptest! {
    #[test]
    fn drawn_ways_end_at_outlets_and_never_climb(ground in grounds(), seed in 0u64..1000) {
        let (tree, filled) = (tree(&ground), filled(&ground));
        let spread = Spread::new(ground.surface(), &tree, &filled, Rule::Infinity);
        let chance = |cell: usize| orograph::kit::hash::unit(seed, cell as u64);
        let drawn = spread.draw(chance, &Work::default()).unwrap();
        for cell in 0..ground.len() {
            let way = way(&drawn, cell);
            prop_assert!(way.windows(2).all(|w| filled[w[1]] <= filled[w[0]] || filled[w[1]].is_nan()));
            let end = way[way.len() - 1];
            prop_assert_eq!(tree.receiver(end), None);
        }
    }
}
