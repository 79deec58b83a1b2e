//! How networks branch, counted, against the formulas of the paper.

use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::statistics::Statistics;

use super::mean;

const SEEDS: std::ops::Range<u64> = 0..50;

/// Mean `T_1` to `T_3` over seeds of networks of a depth.
fn side_branches(branching: Branching, depth: u32) -> [f64; 3] {
    let of = |seed| Statistics::of(&branching.topology(depth, 0.0, seed)).side_branches();
    let all: Vec<Vec<f64>> = SEEDS.map(of).collect();
    [0, 1, 2].map(|k| mean(&all.iter().map(|t| t[k]).collect::<Vec<_>>()))
}

fn sources(links: &[Option<u32>]) -> usize {
    let mut is_source = vec![true; links.len()];
    for &down in links.iter().flatten() {
        is_source[down as usize] = false;
    }
    is_source.into_iter().filter(|&source| source).count()
}

#[test]
fn exterior_links_are_one_more_than_interior_ones() {
    let rules = (1..=8).map(Branching::Generator).chain([
        Branching::Statistics { a: 1.05, c: 2.5 },
        Branching::Statistics { a: 0.0, c: 3.0 },
        Branching::Statistics { a: 0.7, c: 1.0 },
    ]);
    for rule in rules {
        for seed in SEEDS {
            let links = rule.topology(4, 0.2, seed);
            assert_eq!(2 * sources(&links), links.len() + 1, "{rule:?}, seed {seed}");
            assert!(links.iter().enumerate().all(|(i, down)| down.is_none_or(|down| (down as usize) < i)));
        }
    }
}

#[test]
fn generator_2_has_tokunagas_numbers_exactly() {
    for depth in 1..=7 {
        let links = Branching::Generator(2).topology(depth, 0.0, 3);
        assert_eq!(sources(&links), (2 * 4_usize.pow(depth - 1) + 1) / 3, "depth {depth}");
        let found = Statistics::of(&links).side_branches();
        let want: Vec<f64> = (0..found.len()).map(|k| f64::from(1_u32 << k)).collect();
        assert_eq!(found, want, "depth {depth}");
    }
}

#[test]
fn generators_have_the_means_of_theory() {
    for phi in [3_u8, 4, 5] {
        let rule = Branching::Generator(phi);
        let found = side_branches(rule, 6);
        let (phi, r) = (f64::from(phi), rule.interior(1));
        let want = [phi - 1.0, r * phi, r * phi * (r + 1.0)];
        for k in 0..3 {
            assert!((found[k] / want[k] - 1.0).abs() < 0.03, "φ {phi}: {found:?}, not {want:?}");
        }
    }
}

#[test]
fn given_statistics_are_met() {
    for (a, c, depth) in [(1.05, 2.5, 7), (0.7, 2.0, 8), (1.2, 3.0, 6), (1.0, 1.0, 8)] {
        let found = side_branches(Branching::Statistics { a, c }, depth);
        let want = [a, a * c, a * c * c];
        for k in 0..3 {
            assert!((found[k] / want[k] - 1.0).abs() < 0.03, "a {a}, c {c}: {found:?}, not {want:?}");
        }
    }
}

#[test]
fn statistics_of_a_2_1_network_are_those_of_generator_2() {
    let [given, generator] = [Branching::Statistics { a: 1.0, c: 2.0 }, Branching::Generator(2)]
        .map(|rule| rule.topology(6, 0.0, 1));
    assert_eq!(Statistics::of(&given), Statistics::of(&generator));
    assert!((Branching::Statistics { a: 1.0, c: 2.0 }.shrink() - 2.0).abs() < 1e-12);
}

#[test]
fn links_are_foretold() {
    for rule in [Branching::Generator(3), Branching::Generator(8), Branching::Statistics { a: 1.2, c: 3.0 }] {
        for lengthen in [0.0, 0.4] {
            // Sizes vary by a fifth from seed to seed.
            let counts: Vec<f64> =
                (0..1000).map(|seed| rule.topology(5, lengthen, seed).len() as f64).collect();
            let foretold = rule.links(5, lengthen);
            assert!((mean(&counts) / foretold - 1.0).abs() < 0.03, "{rule:?}: {foretold}, {}", mean(&counts));
        }
    }
    assert!(Branching::Generator(8).links(60, 0.0) > 1e12);
}

#[test]
fn statistics_count_side_branches_by_their_definition() {
    // Two sources make an order 2; a third joins it from the side; three sources at one joint make one order 2 and a side
    // branch; the two make an order 3.
    let links = [None, Some(0), Some(1), Some(1), Some(2), Some(2), Some(0), Some(6), Some(6), Some(6)];
    let found = Statistics::of(&links);
    assert_eq!(found.streams, [6, 2, 1]);
    assert_eq!(found.sides, [[0, 2, 0], [0, 0, 0], [0, 0, 0]]);
    assert_eq!(found.side_branches(), [0.5, 0.0]);
    assert_eq!(found.bifurcation(), [3.0, 2.0]);
    assert_eq!(Statistics::of(&[]), Statistics::default());
}

#[test]
fn bifurcation_is_that_of_theory() {
    let generators = [(1, 2.0), (2, 4.0), (3, 5.5352), (4, 6.9212)];
    for (phi, want) in generators {
        assert!((Branching::Generator(phi).bifurcation() - want).abs() < 1e-3, "φ {phi}");
    }
    for (a, c, want) in
        [(1.0, 2.0, 4.0), (1.05, 2.5, 4.42), (0.7, 2.0, 3.58), (1.2, 3.0, 5.0), (0.0, 6.0, 2.0)]
    {
        assert!((Branching::Statistics { a, c }.bifurcation() - want).abs() < 0.01, "a {a}, c {c}");
    }
}
