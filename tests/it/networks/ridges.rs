//! Ridges: that none crosses a river or lies below one, and which rivers they part.

use orograph::kit::predicates::segments_touch;
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::infill::Infill;
use orograph::kit::rivers::meeting::Meetings;
use orograph::kit::rivers::ridges::{Found, Heights, ridges};
use orograph::kit::rivers::{drainage, profile};
use orograph::value::{Bounds, Ridges, RiverVertex, Rivers};
use orograph::work::{Cancel, Work};
use proptest::prelude::*;

use super::{LINE, SQUARE, grow, growth, link_grid, rivers, seeds, segment};

const HEIGHTS: Heights = Heights { rise: 0.5, reach: 600.0, rounds: 2, detour: 0.0 };

/// A network with infill, areas and beds.
fn network(seed: u64) -> Vec<RiverVertex> {
    let plain = rivers(&grow(&growth(Branching::Generator(2), 5, seed), &[LINE]));
    let infill = Infill { bounds: SQUARE, spacing: 600.0, rim: 0.03, seed };
    let mut filled = infill.fill(plain.vertices(), &Work::default()).unwrap().vertices;
    drainage::drain(&mut filled, infill.filled_bounds(), 2.5, &Work::default()).unwrap();
    profile::rise(&mut filled, profile::Rise::Concave { concavity: 0.45, relief: 900.0 });
    profile::limit_sides(&mut filled, 0.6, &Work::default()).unwrap();
    Rivers::new(filled).unwrap().vertices().to_vec()
}

fn of(vertices: &[RiverVertex], bounds: Bounds) -> Found {
    ridges(vertices, bounds, HEIGHTS, &Work::default()).unwrap()
}

/// Edges that a link touches.
fn touched(found: &Found, vertices: &[RiverVertex]) -> usize {
    let (grid, mut near) = (link_grid(vertices), Vec::new());
    let is_touched = |edge: &&orograph::value::RidgeEdge| {
        let ends = edge.ends.map(|end| found.vertices[end as usize].at);
        grid.collect(Bounds::around(ends).unwrap(), &mut near);
        near.iter().filter_map(|&i| segment(vertices, i as usize)).any(|link| segments_touch(link, ends))
    };
    found.edges.iter().filter(is_touched).count()
}

#[test]
fn ridges_cross_no_river_and_lie_below_none_beside_them() {
    for seed in seeds(10, 2) {
        let filled = network(seed);
        // The network alone has long links that are no edges of the triangulation.
        let alone = rivers(&grow(&growth(Branching::Generator(1), 6, seed), &[LINE]));
        for vertices in [filled.as_slice(), alone.vertices()] {
            let found = of(vertices, SQUARE);
            assert!(found.edges.len() > vertices.len() / 2);
            assert_eq!(touched(&found, vertices), 0, "seed {seed}");
            for edge in &found.edges {
                let beds = edge.rivers.map(|river| vertices[river as usize].height);
                for end in edge.ends.map(|end| found.vertices[end as usize]) {
                    assert!(end.height >= beds[0].max(beds[1]), "seed {seed}: {end:?} below {beds:?}");
                    let far = edge.rivers.map(|river| {
                        let at = vertices[river as usize].at;
                        libm::hypot(at[0] - end.at[0], at[1] - end.at[1])
                    });
                    assert!((far[0] - far[1]).abs() < 1e-3, "as far from both rivers: {far:?}");
                }
            }
            Ridges::new(found.vertices, found.edges).unwrap();
        }
    }
}

#[test]
fn ridge_heights_are_those_of_equation_4() {
    let vertices = network(4);
    let heights = Heights { rounds: 0, reach: 1e9, ..HEIGHTS };
    let found = ridges(&vertices, SQUARE, heights, &Work::default()).unwrap();
    let mut compared = 0;
    for ridge in &found.vertices {
        let far = |v: &RiverVertex| libm::hypot(v.at[0] - ridge.at[0], v.at[1] - ridge.at[1]);
        let mut near: Vec<&RiverVertex> = vertices.iter().collect();
        near.sort_by(|a, b| far(a).total_cmp(&far(b)));
        // On the border two are as near, inside three.
        let count = if far(near[2]) < far(near[0]) + 1e-3 { 3 } else { 2 };
        let highest = near[..count].iter().map(|v| v.height).fold(f64::MIN, f64::max);
        let want = highest + 0.5 * far(near[0]);
        assert!((ridge.height - want).abs() < 1e-3, "{} not {want}", ridge.height);
        compared += usize::from(count == 3);
    }
    assert!(compared > found.vertices.len() / 2);
}

#[test]
fn ridges_end_inside_their_bounds_and_rise_no_more_than_they_level_off_at() {
    let vertices = network(5);
    let found = of(&vertices, SQUARE);
    let highest = vertices.iter().map(|v| v.height).fold(f64::MIN, f64::max);
    for ridge in &found.vertices {
        assert!((0..2).all(|k| (SQUARE.min[k]..=SQUARE.max[k]).contains(&ridge.at[k])), "{ridge:?}");
        assert!(ridge.height <= highest + HEIGHTS.rise * HEIGHTS.reach);
    }
}

/// The order of the river that reaches the meeting, by walking down from both.
fn plain_order(vertices: &[RiverVertex], [a, b]: [usize; 2]) -> u8 {
    let way = |from: usize| {
        std::iter::successors(Some(from), |&i| vertices[i].down.map(|down| down as usize)).collect::<Vec<_>>()
    };
    let (a, b) = (way(a), way(b));
    let Some(i) = a.iter().position(|vertex| b.contains(vertex)) else {
        return vertices[a[a.len() - 1]].order.min(vertices[b[b.len() - 1]].order);
    };
    let j = b.iter().position(|vertex| *vertex == a[i]).unwrap();
    let came = |way: &[usize], k: usize| vertices[way[k.saturating_sub(1)]].order;
    came(&a, i).min(came(&b, j))
}

#[test]
fn ridges_have_the_order_of_the_rivers_where_they_meet() {
    let vertices = network(6);
    let meetings = Meetings::of(&vertices);
    let found = of(&vertices, SQUARE);
    for edge in &found.edges {
        let rivers = edge.rivers.map(|river| river as usize);
        assert_eq!(edge.order, plain_order(&vertices, rivers), "{rivers:?}");
        assert_eq!(edge.order, meetings.order([rivers[1], rivers[0]]));
    }
    assert!(found.edges.iter().any(|edge| edge.order > 3));
}

#[test]
fn ridges_of_few_and_of_coincident_vertices_are_defined() {
    let at = |x: f64, y: f64, down| RiverVertex { at: [x, y], down, ..RiverVertex::default() };
    assert_eq!(of(&[], SQUARE), Found::default());
    assert_eq!(of(&[at(5.0, 5.0, None)], SQUARE), Found::default());
    assert_eq!(of(&[at(5.0, 5.0, None), at(5.0, 5.0, Some(0))], SQUARE), Found::default());
    // Two outlets are parted by one line across the land.
    let two = of(&[at(4000.0, 5.0, None), at(8000.0, 5.0, None)], SQUARE);
    assert_eq!((two.edges.len(), two.vertices.iter().all(|v| v.at[0] == 6000.0)), (1, true));
    // A straight river leaves no ridge.
    let straight: Vec<RiverVertex> =
        (0..30).map(|i: u32| at(f64::from(i) * 100.0, 300.0, i.checked_sub(1))).collect();
    assert_eq!(of(&straight, SQUARE), Found::default());
}

#[test]
fn ridges_are_the_same_for_any_number_of_threads_and_stop_when_asked() {
    let vertices = network(7);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let [one, four] = [1, 4].map(|threads| pool(threads).install(|| of(&vertices, SQUARE)));
    assert_eq!(one, four);
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(ridges(&vertices, SQUARE, HEIGHTS, &Work::new(&cancel)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn ridges_of_any_vertices_on_a_lattice_cross_no_river(
        links in prop::collection::vec((any::<u8>(), 0_u8..7, 0_u8..7), 1..40)
    ) {
        // Rivers that cross each other, turn back and stand on each other are as bad as imported ones can be.
        let vertex = |(i, &(pick, x, y)): (usize, &(u8, u8, u8))| RiverVertex {
            at: [f64::from(x) * 1000.0, f64::from(y) * 1000.0],
            height: f64::from(pick),
            down: (i > 0 && pick % 5 != 0).then(|| u32::from(pick) % i as u32),
            ..RiverVertex::default()
        };
        let vertices: Vec<RiverVertex> = links.iter().enumerate().map(vertex).collect();
        let vertices = Rivers::new(vertices).unwrap().vertices().to_vec();
        let found = of(&vertices, SQUARE);
        let crossed = found.edges.iter().filter(|edge| {
            let ends = edge.ends.map(|end| found.vertices[end as usize].at);
            (0..vertices.len()).filter_map(|i| segment(&vertices, i)).any(|link| {
                orograph::kit::predicates::segments_cross(link, ends)
            })
        });
        prop_assert_eq!(crossed.count(), 0);
        Ridges::new(found.vertices, found.edges).unwrap();
    }
}

/// A river that winds has no spurs inside its bends, and a tributary still has a divide.
#[test]
fn bends_have_no_ridges_and_junctions_have() {
    let vertex = |x: f64, y: f64, down: Option<u32>| RiverVertex {
        at: [x, y],
        down,
        height: y / 50.0,
        ..RiverVertex::default()
    };
    let mut all = vec![vertex(0.0, 0.0, None)];
    for k in 1..20 {
        let x = if k % 2 == 0 { 0.0 } else { 60.0 };
        all.push(vertex(x, 100.0 * f64::from(k), Some(k as u32 - 1)));
    }
    let bounds = Bounds { min: [-1000.0, -200.0], max: [1000.0, 2200.0] };
    let of = |all: &[RiverVertex], detour: f64| {
        ridges(all, bounds, Heights { detour, ..HEIGHTS }, &Work::default()).unwrap().edges.len()
    };
    assert!(of(&all, 1.0) > 10, "the diagram has an edge inside every bend: {}", of(&all, 1.0));
    assert_eq!(of(&all, 1.3), 0);
    all.push(vertex(400.0, 1300.0, Some(10)));
    all.push(vertex(700.0, 1500.0, Some(20)));
    assert!(of(&all, 1.3) > 0, "a divide between the river and its tributary");
}
