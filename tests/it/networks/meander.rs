//! Winding rivers: no links that touch, smooth ways, the same network.

use orograph::kit::predicates::segments_touch;
use orograph::kit::rivers::meander::{Meander, meander};
use orograph::value::{RiverVertex, Rivers};
use orograph::work::Work;
use proptest::prelude::*;

fn wind(vertices: &[RiverVertex], strength: f64, piece: f64, seed: u64) -> Rivers {
    let all = meander(vertices, Meander { strength, piece, seed }, &Work::default()).unwrap();
    Rivers::sorted(&all).unwrap().0
}

fn vertex(at: [f64; 2], down: Option<u32>) -> RiverVertex {
    RiverVertex { at, down, height: at[1] / 100.0, area: 1.0, width: 1.0, ..RiverVertex::default() }
}

/// Pairs of links that touch though they have no end in common, by trying all.
fn touching(rivers: &Rivers) -> Vec<[usize; 2]> {
    let v = rivers.vertices();
    let links: Vec<_> = rivers.links().collect();
    let mut found = Vec::new();
    for (i, &(a, b)) in links.iter().enumerate() {
        for &(c, d) in &links[i + 1..] {
            let apart = a != c && a != d && b != c && b != d;
            if apart && segments_touch([v[a].at, v[b].at], [v[c].at, v[d].at]) {
                found.push([a, c]);
            }
        }
    }
    found
}

/// Whether vertices stand at one place, or links that join lie on each other.
fn has_overlaps(vertices: &[RiverVertex]) -> bool {
    let ends = |i: usize| Some([vertices[i].at, vertices[vertices[i].down? as usize].at]);
    (0..vertices.len()).any(|i| {
        (0..vertices.len()).filter(|&k| k != i).any(|k| {
            let at = vertices[k].at;
            at == vertices[i].at
                || ends(i).is_some_and(|link| !link.contains(&at) && segments_touch([at, at], link))
        })
    })
}

/// A comb: a main river with teeth to either side, near each other.
fn comb() -> Vec<RiverVertex> {
    let mut all = vec![vertex([0.0, 0.0], None)];
    for k in 1..12 {
        let y = 300.0 * f64::from(k);
        let down = if k == 1 { 0 } else { 3 * (k - 2) + 1 };
        all.push(vertex([0.0, y], Some(down)));
        let own = all.len() as u32 - 1;
        all.push(vertex([900.0, y + 120.0], Some(own)));
        all.push(vertex([-900.0, y + 120.0], Some(own)));
    }
    all
}

#[test]
fn a_comb_winds_without_links_that_touch() {
    let straight = Rivers::new(comb()).unwrap();
    assert_eq!(touching(&straight), Vec::<[usize; 2]>::new());
    for seed in 0..8 {
        let rivers = wind(&comb(), 0.3, 25.0, seed);
        assert_eq!(touching(&rivers), Vec::<[usize; 2]>::new(), "seed {seed}");
        let v = rivers.vertices();
        let long = |(a, b): (usize, usize)| libm::hypot(v[a].at[0] - v[b].at[0], v[a].at[1] - v[b].at[1]);
        let too_long = rivers.links().filter(|&link| long(link) > 25.0).count();
        assert!(
            too_long * 20 < rivers.len(),
            "seed {seed}: {too_long} of {} links have no room",
            rivers.len()
        );
        assert!(rivers.len() > 20 * straight.len());
        // What was there stays, and drains to what it did.
        for old in straight.vertices() {
            let new = v.iter().find(|v| v.at == old.at).expect("a vertex stays");
            assert_eq!(new.order, old.order);
            assert!((new.height - old.height).abs() < 1e-12);
        }
        assert_eq!(rivers.outlets().count(), 1);
    }
    // The check finds what touches.
    let crossing = [
        vertex([0.0, 0.0], None),
        vertex([10.0, 10.0], Some(0)),
        vertex([0.0, 10.0], None),
        vertex([10.0, 0.0], Some(2)),
    ];
    assert_eq!(touching(&Rivers::new(crossing.to_vec()).unwrap()).len(), 1);
}

#[test]
fn without_chance_a_right_angle_becomes_round() {
    let corner =
        [vertex([0.0, 0.0], None), vertex([0.0, 1000.0], Some(0)), vertex([1000.0, 1000.0], Some(1))];
    let rivers = wind(&corner, 0.0, 20.0, 0);
    let v = rivers.vertices();
    let turn = |i: usize| {
        let (Some(down), Some(up)) = (rivers.down(i), (0..v.len()).find(|&k| rivers.down(k) == Some(i)))
        else {
            return 0.0;
        };
        let heading = |a: usize, b: usize| libm::atan2(v[b].at[1] - v[a].at[1], v[b].at[0] - v[a].at[0]);
        let turn = (heading(up, i) - heading(i, down)).abs();
        turn.min(2.0 * std::f64::consts::PI - turn).to_degrees()
    };
    let sharpest = (0..v.len()).map(turn).fold(0.0, f64::max);
    assert!(sharpest < 30.0, "{sharpest}° where there were 90");
    let straight = [vertex([0.0, 0.0], None), vertex([0.0, 1000.0], Some(0))];
    let line = wind(&straight, 0.0, 20.0, 0);
    assert!(line.vertices().iter().all(|v| v.at[0] == 0.0), "a straight river stays straight");
}

#[test]
fn short_links_and_empty_networks_stay() {
    assert!(wind(&[], 0.2, 10.0, 1).is_empty());
    let one = [vertex([5.0, 5.0], None)];
    assert_eq!(wind(&one, 0.2, 10.0, 1).vertices().len(), 1);
    let comb = comb();
    assert_eq!(wind(&comb, 0.2, 5000.0, 1), Rivers::sorted(&comb).unwrap().0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Networks of any shape, coincident vertices and links that lie on each other among them.
    #[test]
    fn no_network_gets_more_links_that_touch(
        places in prop::collection::vec((0..12u32, 0..12u32, 0.0..1.0f64), 1..24), strength in 0.0..0.5f64, seed: u64,
    ) {
        let down = |i: usize, share: f64| (i > 0 && share < 0.9).then_some((share * i as f64) as u32);
        let vertices: Vec<_> = places.iter().enumerate()
            .map(|(i, &(x, y, share))| vertex([f64::from(x) * 100.0, f64::from(y) * 100.0], down(i, share))).collect();
        let before = touching(&Rivers::new(vertices.clone()).unwrap());
        let after = wind(&vertices, strength, 30.0, seed);
        for vertex in after.vertices() {
            prop_assert!(vertex.at.iter().chain([&vertex.height]).all(|x| x.is_finite()));
        }
        if before.is_empty() && !has_overlaps(&vertices) {
            prop_assert_eq!(touching(&after), Vec::<[usize; 2]>::new());
        }
    }
}
