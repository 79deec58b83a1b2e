//! Tributaries in empty land: that none is left, how they branch, that nothing crosses.

use orograph::kit::hash::unit;
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::drainage;
use orograph::kit::rivers::gap::distance_squared;
use orograph::kit::rivers::infill::{Filled, Infill};
use orograph::kit::rivers::statistics::Statistics;
use orograph::value::{Bounds, RiverVertex, Rivers};
use orograph::work::{Cancel, Work};

use super::{LINE, SIDE, SQUARE, crossings, grow, growth, link_grid, mean, rivers, seeds, segment};

const INFILL: Infill = Infill { bounds: SQUARE, spacing: 500.0, rim: 0.03, seed: 4 };

fn network(seed: u64) -> Rivers {
    rivers(&grow(&growth(Branching::Generator(2), 6, seed), &[LINE]))
}

fn fill(infill: &Infill, rivers: &Rivers) -> Filled {
    infill.fill(rivers.vertices(), &Work::default()).unwrap()
}

/// The farthest of many places of the square from a river.
fn farthest(vertices: &[RiverVertex], reach: f64) -> f64 {
    let (grid, mut near) = (link_grid(vertices), Vec::new());
    let place = |k| {
        let at = [unit(11, k) * SIDE, unit(12, k) * SIDE];
        grid.collect(Bounds { min: at, max: at }.grown(reach), &mut near);
        let links = near.iter().filter_map(|&i| segment(vertices, i as usize));
        libm::sqrt(links.map(|link| distance_squared(at, link)).fold(f64::INFINITY, f64::min))
    };
    (0..20_000).map(place).fold(0.0, f64::max)
}

#[test]
fn infill_leaves_no_place_far_from_a_river_and_crosses_nothing() {
    for seed in seeds(20, 3) {
        let infill = Infill { seed, ..INFILL };
        let given = network(seed);
        let filled = fill(&infill, &given);
        assert_eq!(filled.unreached, 0, "seed {seed}");
        assert_eq!(crossings(&filled.vertices), [[0; 2]; 0], "seed {seed}");
        let far = farthest(&filled.vertices, 2.0 * infill.spacing);
        assert!(far <= infill.spacing, "seed {seed}: {far} m");
        assert!((filled.vertices.len() as f64) <= infill.vertices(given.vertices()));
    }
}

#[test]
fn filled_networks_branch_like_real_ones() {
    let (mut ratio, mut first) = (Vec::new(), Vec::new());
    for seed in seeds(20, 4) {
        let filled = fill(&Infill { spacing: 350.0, seed, ..INFILL }, &network(seed));
        let found = Statistics::of(&filled.vertices.iter().map(|vertex| vertex.down).collect::<Vec<_>>());
        // Of the first orders, which have streams enough for a mean.
        ratio.push(mean(&found.bifurcation()[..3]));
        first.push(found.side_branches()[0]);
    }
    assert!((3.6..=5.8).contains(&mean(&ratio)), "R_B {ratio:?}");
    assert!((0.6..=1.4).contains(&mean(&first)), "a {first:?}");
}

#[test]
fn infill_keeps_the_given_rivers() {
    let rivers = network(1);
    let filled = fill(&INFILL, &rivers);
    // Every given vertex, in its order, with new ones on long links.
    let mut given = rivers.vertices().iter().peekable();
    for vertex in &filled.vertices[..filled.first_added] {
        if given.peek().is_some_and(|next| next.at == vertex.at) {
            given.next();
        }
    }
    assert_eq!(given.next(), None);
    let longest = filled
        .vertices
        .iter()
        .enumerate()
        .filter_map(|(i, _)| segment(&filled.vertices, i))
        .take(filled.first_added);
    for [a, b] in longest.take(filled.first_added - 1) {
        assert!(libm::hypot(a[0] - b[0], a[1] - b[1]) <= INFILL.spacing * (1.0 + 1e-12));
    }
}

#[test]
fn areas_of_outlets_sum_to_the_whole() {
    let mut filled = fill(&INFILL, &network(2)).vertices;
    let all = INFILL.filled_bounds();
    let areas = drainage::areas(&filled, all, &Work::default()).unwrap();
    let outlets = filled.iter().zip(&areas).filter(|(vertex, _)| vertex.down.is_none());
    let (sum, whole) = (outlets.map(|(_, area)| area).sum::<f64>(), all.width() * all.depth());
    assert!((sum / whole - 1.0).abs() < 1e-9, "{sum} of {whole}");
    drainage::drain(&mut filled, all, 2.0, &Work::default()).unwrap();
    for (vertex, area) in filled.iter().zip(&areas) {
        assert_eq!((vertex.area, vertex.width), (*area as f32, (2.0 * libm::sqrt(area * 1e-6)) as f32));
    }
}

#[test]
fn infill_takes_any_network_and_none() {
    assert_eq!(fill(&INFILL, &Rivers::default()), Filled::default());
    let lone = |at| Rivers::new(vec![RiverVertex { at, ..RiverVertex::default() }]).unwrap();
    for at in [[0.0, 0.0], [8000.0, 8000.0], [-900_000.0, 1.0]] {
        let filled = fill(&INFILL, &lone(at));
        assert_eq!(filled.vertices[0].at, at);
        assert!(Rivers::new(filled.vertices).unwrap().len() > 100);
    }
    // Land of one row, and land smaller than a spacing.
    for bounds in [Bounds { min: [0.0; 2], max: [SIDE, 1.0] }, Bounds { min: [0.0; 2], max: [3.0, 2.0] }] {
        let filled = fill(&Infill { bounds, ..INFILL }, &lone([1.0, 0.5]));
        assert_eq!(crossings(&filled.vertices), [[0; 2]; 0]);
    }
}

#[test]
fn infill_is_the_same_for_any_number_of_threads_and_stops_when_asked() {
    let rivers = network(3);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let [one, four] = [1, 4].map(|threads| pool(threads).install(|| fill(&INFILL, &rivers)));
    assert_eq!(one, four);
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(INFILL.fill(rivers.vertices(), &Work::new(&cancel)).is_err());
}
