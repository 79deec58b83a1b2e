//! Triangulations and Voronoi cells against brute force, of sites as bad as can be.

use orograph::kit::delaunay::Delaunay;
use orograph::kit::hash::unit;
use orograph::kit::predicates::{Point, is_in_circle, side};
use orograph::kit::voronoi;
use orograph::value::Bounds;
use orograph::work::{Cancel, Work};
use proptest::prelude::*;

const BOUNDS: Bounds = Bounds { min: [-100.0, -50.0], max: [300.0, 150.0] };

fn triangulation(sites: &[Point]) -> Delaunay {
    Delaunay::new(sites, BOUNDS, &Work::default()).unwrap()
}

/// What every triangulation keeps: triangles turn left, twins agree, no circle holds a site, and each site is there.
fn check(net: &Delaunay, sites: &[Point]) {
    let firsts: Vec<usize> = (0..sites.len()).filter(|&i| net.same(i) == i).collect();
    // Euler: three corners and n sites inside give 2n + 1 triangles.
    assert_eq!(net.triangles(), 2 * firsts.len() + 1);
    for t in 0..net.triangles() {
        let corners = net.corners(t).map(|c| net.point(c));
        assert!(side(corners[0], corners[1], corners[2]) > 0.0, "triangle {t} turns left");
        let inside = firsts.iter().find(|&&i| is_in_circle(corners, net.point(i as u32)));
        assert_eq!(inside, None, "triangle {t}: {corners:?}");
    }
    for edge in 0..net.half_edges() {
        if let Some(twin) = net.twin(edge) {
            assert_eq!(
                (net.twin(twin), net.origin(edge), net.end(edge)),
                (Some(edge), net.end(twin), net.origin(twin))
            );
        }
    }
    for (i, start) in net.starts().into_iter().enumerate() {
        assert_eq!(start == orograph::kit::delaunay::NONE, net.same(i) != i);
        assert!(net.same(i) <= i && net.point(net.same(i) as u32) == net.point(i as u32));
        if net.same(i) == i {
            assert!(net.around(start as usize).all(|edge| net.origin(edge) == i as u32));
            assert!(net.around(start as usize).count() >= 3);
        }
    }
}

/// Sites of a kind that is known to be hard.
fn hard(kind: usize) -> Vec<Point> {
    let n = 60_u32;
    let each = |f: &dyn Fn(f64) -> Point| (0..n).map(|i| f(f64::from(i))).collect();
    match kind {
        0 => Vec::new(),
        1 => vec![[3.0, 4.0]],
        2 => vec![[3.0, 4.0]; 9],
        3 => each(&|i| [i, 0.0]),
        4 => each(&|i| [0.1 * i, 0.3 * i]),
        5 => each(&|i| [i % 8.0, libm::floor(i / 8.0)]),
        6 => each(&|i| [100.0 * libm::cos(i * 0.104_719_755), 100.0 * libm::sin(i * 0.104_719_755)]),
        7 => each(&|i| [1e-6 * i * i, 1e-6 * (i % 7.0)]),
        8 => each(&|i| [if i % 2.0 == 0.0 { 0.0 } else { 1e-3 }, i]),
        9 => each(&|i| [1e-300 * i, 1e-310 * (i % 3.0)]),
        10 => each(&|i| [1e8 - i, -1e8 + i * (i % 5.0)]),
        _ => each(&|i| [200.0 * unit(1, i as u64), 100.0 * unit(2, i as u64)]),
    }
}

#[test]
fn triangulations_of_hard_sites_are_delaunay() {
    for kind in 0..12 {
        let sites = hard(kind);
        println!("{kind}");
        check(&triangulation(&sites), &sites);
    }
}

#[test]
fn cells_of_hard_sites_cover_the_bounds() {
    for kind in (1..12).filter(|&kind| kind != 10) {
        let sites = hard(kind);
        let areas = voronoi::areas(&triangulation(&sites), BOUNDS, &Work::default()).unwrap();
        let whole = BOUNDS.width() * BOUNDS.depth();
        assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-9 * whole, "{kind}: {areas:?}");
    }
}

#[test]
fn centres_are_finite() {
    for kind in 0..12 {
        let net = triangulation(&hard(kind));
        assert!(voronoi::centres(&net).iter().flatten().all(|x| x.is_finite()), "{kind}");
    }
}

#[test]
fn cells_agree_with_a_search_for_the_nearest_site() {
    let sites: Vec<Point> =
        (0..40).map(|i| [400.0 * unit(3, i) - 100.0, 200.0 * unit(4, i) - 50.0]).collect();
    let net = triangulation(&sites);
    let areas = voronoi::areas(&net, BOUNDS, &Work::default()).unwrap();
    let mut counted = vec![0.0; sites.len()];
    let step = 0.5;
    for row in 0..400 {
        for col in 0..800 {
            let at = [-100.0 + (f64::from(col) + 0.5) * step, -50.0 + (f64::from(row) + 0.5) * step];
            let far = |i: &usize| libm::hypot(sites[*i][0] - at[0], sites[*i][1] - at[1]);
            let nearest = (0..sites.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
            counted[nearest] += step * step;
        }
    }
    for (i, (area, counted)) in areas.iter().zip(&counted).enumerate() {
        // As many squares as its border cuts may be wrong.
        assert!((area - counted).abs() < 4.0 * step * libm::sqrt(*area), "cell {i}: {area} {counted}");
    }
}

#[test]
fn many_sites_have_triangles_that_are_delaunay_beside_their_neighbours() {
    let sites: Vec<Point> = (0..20_000).map(|i| [1000.0 * unit(5, i), 1000.0 * unit(6, i)]).collect();
    let net = triangulation(&sites);
    assert_eq!(net.triangles(), 2 * sites.len() + 1);
    for edge in net.edges() {
        let beyond = net.point(net.origin(orograph::kit::delaunay::previous(net.twin(edge).unwrap())));
        let corners = net.corners(edge / 3).map(|c| net.point(c));
        assert!(!is_in_circle(corners, beyond), "edge {edge}");
    }
}

#[test]
fn triangulations_grow_by_further_sites() {
    // Further sites among the first, and some on them.
    let first: Vec<Point> = (0..50).map(|i| [200.0 * unit(7, i), 100.0 * unit(8, i)]).collect();
    let further: Vec<Point> = (0..40)
        .map(|i| [200.0 * unit(9, i), 100.0 * unit(10, i)])
        .chain(first[3..9].iter().copied())
        .collect();
    let mut net = triangulation(&first);
    net.extend(&further, &Work::default()).unwrap();
    let all: Vec<Point> = first.into_iter().chain(further).collect();
    check(&net, &all);
    assert_eq!((net.sites(), net.same(90)), (96, 3));
}

#[test]
fn triangulation_stops_when_asked() {
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(Delaunay::new(&hard(11), BOUNDS, &Work::new(&cancel)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn triangulations_of_sites_on_a_small_lattice_are_delaunay(
        sites in prop::collection::vec((0_u8..6, 0_u8..6), 0..40)
    ) {
        let sites: Vec<Point> = sites.into_iter().map(|(x, y)| [x.into(), y.into()]).collect();
        check(&triangulation(&sites), &sites);
    }
}
