//! What a hand does to a curve.

use orograph::value::Curve;
use orograph::value::curves::edit::Form;
use proptest::prelude::*;

use super::{hypot, spec};

const BEZIER: &str = r#"{"bezier":[0,0,300,-200,600,200,900,0,1200,-200,1500,300,2000,100],
    "height":[0,100,10,0.4,300,20,1,50,5],"slope":[0.5,200,300,-30,-40],"noise":[0,12,0.5]}"#;
const THROUGH: &str = r#"{"through":[0,0,500,200,900,-100,1500,0],"height":[0,100,0,1,300,0]}"#;
const RING: &str = r#"{"through":[0,0,500,0,500,500,0,500,0,0],"height":[0,100,0]}"#;

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    hypot(a[0] - b[0], a[1] - b[1])
}

/// How far the places of two curves are apart at most, at equal shares.
fn differ(a: &Curve, b: &Curve) -> f64 {
    (0..=200).map(|k| f64::from(k) / 200.0).map(|u| apart(a.point(u), b.point(u))).fold(0.0, f64::max)
}

#[test]
fn a_new_control_point_leaves_a_bezier_curve_as_it_was() {
    let before = spec(BEZIER);
    for u in [0.07, 0.31, 0.5, 0.83] {
        let mut after = before.clone();
        let i = after.insert_anchor(u).unwrap();
        let (old, new) = (before.build().unwrap(), after.build().unwrap());
        assert!(apart(after.anchors()[i], old.point(u)) < 2e-3, "{u}");
        assert!(differ(&old, &new) < 0.01, "{u}: {}", differ(&old, &new));
        after.remove_anchor(i).unwrap();
        assert_eq!(after.anchors(), before.anchors());
    }
}

#[test]
fn a_new_control_point_of_a_smooth_line_is_where_it_was_put() {
    for u in [0.1, 0.5, 0.9] {
        let mut after = spec(THROUGH);
        let at = after.build().unwrap().point(u);
        let i = after.insert_anchor(u).unwrap();
        assert!(apart(after.anchors()[i], at) < 2e-3);
        assert_eq!(after.anchors().len(), 5);
    }
    let mut line = spec(r#"{"line":[0,0,0,0,100,0,200,0],"height":[0,1,0]}"#);
    let i = line.insert_anchor(0.75).unwrap();
    assert_eq!(line.anchors()[i], [150.0, 0.0], "a point that repeats makes no piece");
}

#[test]
fn handles_go_with_their_anchor_and_turn_in_pairs() {
    let mut bent = spec(BEZIER);
    bent.move_anchor(1, [950.0, 30.0]);
    assert_eq!(bent.bezier[4..10], [650.0, 230.0, 950.0, 30.0, 1250.0, -170.0]);
    bent.move_handle(4, [950.0, 130.0], true);
    // As long as before, and opposite.
    assert!(apart([bent.bezier[4], bent.bezier[5]], [950.0, 30.0 - hypot(300.0, 200.0)]) < 0.01);
    let mut loose = bent.clone();
    loose.move_handle(2, [0.0, 0.0], false);
    assert_eq!(loose.bezier[8..10], bent.bezier[8..10]);
    let mut ring = spec(RING);
    ring.move_anchor(0, [-50.0, -60.0]);
    assert!(ring.build().unwrap().is_closed(), "both ends of a ring are one");
    let before = ring.clone();
    ring.move_anchor(99, [0.0; 2]);
    ring.move_handle(1, [0.0; 2], true);
    assert_eq!(ring, before, "what is not there is not moved");
}

#[test]
fn a_cut_keeps_course_and_values() {
    let whole = spec(BEZIER).build().unwrap();
    for cut in [0.2, 0.4, 0.61] {
        let halves = spec(BEZIER).split(cut).unwrap().map(|h| h.build().unwrap());
        for k in 1..40 {
            let u = f64::from(k) / 40.0;
            let (half, own) =
                if u < cut { (&halves[0], u / cut) } else { (&halves[1], (u - cut) / (1.0 - cut)) };
            assert!(apart(half.point(own), whole.point(u)) < 0.5, "{cut} {u}");
            let (a, b) = (half.attributes(own), whole.attributes(u));
            assert!((a.slope.unwrap().left_angle - b.slope.unwrap().left_angle).abs() < 0.1, "{cut} {u}");
            assert!((a.noise.unwrap().amplitude - b.noise.unwrap().amplitude).abs() < 0.1, "{cut} {u}");
        }
        let here = whole.height(cut).unwrap();
        assert!((halves[0].height(1.0).unwrap() - here).abs() < 1e-6, "the height at the cut");
        assert!((halves[1].height(0.0).unwrap() - here).abs() < 1e-6);
    }
    assert!(spec(BEZIER).split(0.0).is_err() && spec(BEZIER).split(1.0).is_err());
}

#[test]
fn turning_round_changes_no_place() {
    let turned = spec(BEZIER).reversed();
    let (a, b) = (spec(BEZIER).build().unwrap(), turned.build().unwrap());
    for k in 0..=20 {
        let u = f64::from(k) / 20.0;
        assert!(apart(a.point(u), b.point(1.0 - u)) < 1e-6);
        let (p, q) = (a.attributes(u), b.attributes(1.0 - u));
        assert!((p.elevation.unwrap().height - q.elevation.unwrap().height).abs() < 1e-6);
        assert_eq!(p.slope.unwrap().left_angle, q.slope.unwrap().right_angle);
    }
    assert_eq!(turned.reversed(), spec(BEZIER));
}

#[test]
fn forms_change_and_ends_go_on() {
    let through = spec(THROUGH);
    let bezier = through.in_form(Form::Bezier).unwrap();
    assert!(differ(&through.build().unwrap(), &bezier.build().unwrap()) < 0.01);
    assert_eq!(bezier.in_form(Form::Through).unwrap(), through);
    assert_eq!(bezier.in_form(Form::Line).unwrap().anchors(), through.anchors());
    for mut curve in [through, bezier] {
        curve.extend([1700.0, 300.0]).unwrap();
        assert_eq!(curve.anchors().last(), Some(&[1700.0, 300.0]));
    }
}

#[test]
fn a_new_constraint_point_says_what_holds_there() {
    let mut curve = spec(BEZIER);
    let before = curve.build().unwrap();
    let k = curve.insert_point(0.2).unwrap();
    let after = curve.build().unwrap();
    let point = after.points()[k];
    assert_eq!((k, point.u), (1, 0.2));
    assert!((point.elevation.unwrap().height - before.height(0.2).unwrap()).abs() < 0.1);
    assert_eq!(point.slope.unwrap().right_angle, -40.0);
    assert!(curve.insert_point(0.2).is_err(), "there is one already");
    let mut points = after.points();
    points.remove(k);
    curve.set_points(&points);
    assert_eq!(curve, spec(BEZIER));
}

#[test]
fn the_nearest_place_is_found() {
    let curve = spec(BEZIER).build().unwrap();
    for u in [0.0, 0.123, 0.5, 0.77, 1.0] {
        let (found, far) = curve.nearest(curve.point(u));
        assert!((found - u).abs() < 1e-3 && far < 1.0, "{u}: {found} {far}");
    }
}

proptest! {
    /// Whatever a hand does, the curve is valid or as it was.
    #[test]
    fn no_stroke_breaks_a_curve(
        form in 0usize..3,
        strokes in prop::collection::vec((0u8..7, 0usize..9, -3e3f64..3e3, -3e3f64..3e3, 0f64..1.0), 1..30),
    ) {
        let mut curve = spec([BEZIER, THROUGH, RING][form]);
        for (what, k, x, y, u) in strokes {
            match what {
                0 => curve.move_anchor(k, [x, y]),
                1 => curve.move_handle(k, [x, y], k % 2 == 0),
                2 => _ = curve.insert_anchor(u),
                3 => _ = curve.remove_anchor(k),
                4 => _ = curve.extend([x, y]),
                5 => _ = curve.insert_point(u),
                _ => {
                    if let Ok([a, b]) = curve.split(u) {
                        prop_assert!(a.build().is_ok() && b.build().is_ok());
                    }
                }
            }
            prop_assert!(curve.build().is_ok() || curve.anchors().windows(2).all(|w| w[0] == w[1]), "{curve:?}");
        }
    }
}
