//! Paths and shapes as curves.

use super::{drawn, read};
use crate::curves::hypot;

#[test]
fn svg_paths_lie_on_the_terrain() {
    let got = read(r#"<g transform="translate(10 0)"><path id="a" data-h="100,200" d="M0 50 h10 v10 l10,-10 C 30 50 40 40 50 40 S 60 30 70 40 Q 75 50 80 40 T 90 40"/></g>
        <polyline points="0,0 10,0 10,10" h="5"/><line x1="0" y1="90" x2="50" y2="90" data-angle="-30"/>
        <defs><path d="M0 0 L1 1"/></defs><polygon points="20,20 30,20 30,30" h="7"/>"#).expect("curves");
    assert_eq!(got.curves.len(), 4);
    let all: Vec<_> = got.curves.iter().collect();
    assert_eq!(all[0].name(), "a");
    assert_eq!(all[0].point(0.0), [100.0, 500.0]);
    assert_eq!(all[0].point(1.0), [1000.0, 400.0]);
    assert_eq!(all[0].height(0.0), Some(100.0));
    assert_eq!(all[0].height(1.0), Some(200.0));
    assert_eq!(all[2].attributes(0.5).slope.map(|s| s.left_angle), Some(-30.0));
    assert!(all[3].is_closed());
    assert!((all[3].length() - (200.0 + 100.0 * 2f64.sqrt())).abs() < 1e-6);
}

#[test]
fn svg_arcs_are_circles() {
    let got = read(r#"<path h="1" d="M 20 50 a 30 30 0 0 1 60 0 A 30 30 0 0 1 20 50 z m 1 1 h 5"/>"#)
        .expect("curves");
    assert_eq!(got.curves.len(), 2);
    let ring = got.curves.iter().next().expect("a ring");
    assert!(ring.is_closed());
    assert!((ring.length() / (600.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{}", ring.length());
    for k in 0..100 {
        let p = ring.point(f64::from(k) / 100.0);
        assert!((hypot(p[0] - 500.0, p[1] - 500.0) - 300.0).abs() < 0.2, "{p:?}");
    }
    // With the sweep flag set it goes clockwise on the map: first over the north.
    assert!(ring.point(0.25)[1] < 210.0, "{:?}", ring.point(0.25));
    // Radii that are too small grow; turned ellipses end where they should.
    let got = read(r#"<path h="1" d="M 10 10 A 1 2 30 0 0 50 40"/><path h="1" d="M0 0A0 5 0 0 0 9 9"/>"#)
        .expect("curves");
    let end = got.curves.iter().next().expect("an arc").point(1.0);
    assert!((end[0] - 500.0).abs() < 1e-6 && (end[1] - 400.0).abs() < 1e-6, "{end:?}");
}

#[test]
fn shapes_are_outlines() {
    let ring = |r: i64| [[500 + r, 600], [500, 600 + r], [500 - r, 600], [500, 600 - r], [500 + r, 600]];
    assert_eq!(drawn(r#"<circle cx="50" cy="60" r="20"/>"#), [ring(200)]);
    assert_eq!(drawn(r#"<ellipse cx="50" cy="60" rx="20"/>"#), [ring(200)]);
    let oval = [[600, 600], [500, 800], [400, 600], [500, 400], [600, 600]];
    assert_eq!(drawn(r#"<ellipse cx="50%" cy="60%" rx="10%" ry="20"/>"#), [oval]);
    let square = [[100, 200], [400, 200], [400, 300], [100, 300], [100, 200]];
    assert_eq!(drawn(r#"<rect x="10" y="20" width="30" height="10"/>"#), [square]);
    // Radii that are too large make an ellipse; the sides that are left have no length.
    let round = [[250, 200], [400, 250], [250, 300], [100, 250], [250, 200]];
    assert_eq!(drawn(r#"<rect x="10" y="20" width="30" height="10" rx="99"/>"#), [round]);
    let rounded = drawn(r#"<rect width="30" height="10" ry="2" rx="auto"/>"#);
    assert_eq!(rounded[0].len(), 9);
    assert_eq!(rounded[0][..3], [[20, 0], [280, 0], [300, 20]]);
    assert_eq!(drawn(r#"<line x2="10" y2="20"/>"#), [[[0, 0], [100, 200]]]);
    let triangle = [[0, 0], [100, 0], [0, 100], [0, 0]];
    assert_eq!(
        drawn(r#"<polygon points="0 0 10 0 0 10"/><polygon points="0,0,10,0,0,10,0,0"/>"#),
        [triangle; 2]
    );
}
