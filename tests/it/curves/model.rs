//! The curves themselves: length, interpolation, the form in the file, hostile input.

use orograph::nodes::curves::cliff::Cliff;
use orograph::nodes::curves::crack::Crack;
use orograph::nodes::curves::hill::Hill;
use orograph::nodes::curves::ridge_line::RidgeLine;
use orograph::nodes::curves::river_bed::RiverBed;
use orograph::value::curves::{MAX_CURVES, Rise};
use orograph::value::{CurveSpec, Curves};
use proptest::prelude::*;

use super::{curves, hypot, spec};

fn curve(json: &str) -> orograph::value::Curve {
    spec(json).build().expect("a curve")
}

#[test]
fn length_is_that_of_a_fine_polyline() {
    let shapes = [
        r#"{"bezier":[0,0,100,0,100,100,0,100],"noise":[0,1,0]}"#,
        r#"{"bezier":[0,0,300,200,-200,200,100,0],"noise":[0,1,0]}"#,
        // A cusp, and one that runs back over itself.
        r#"{"bezier":[0,0,100,100,0,100,100,0],"noise":[0,1,0]}"#,
        r#"{"bezier":[0,0,300,0,-200,0,100,0],"noise":[0,1,0]}"#,
        r#"{"bezier":[0,0,0,0,100,50,100,50,120,50,120,50,200,10],"noise":[0,1,0]}"#,
        r#"{"through":[0,0,10,40,80,-20,85,-15,300,0],"noise":[0,1,0]}"#,
    ];
    for json in shapes {
        let c = curve(json);
        let n = 200_000 / c.pieces();
        let polyline: f64 = (0..c.pieces())
            .map(|i| {
                let piece = c.piece(i);
                let at = |k: usize| piece.at(k as f64 / n as f64);
                (0..n).map(|k| hypot(at(k + 1)[0] - at(k)[0], at(k + 1)[1] - at(k)[1])).sum::<f64>()
            })
            .sum();
        assert!((c.length() - polyline).abs() < 1e-7 * polyline, "{json}: {} for {polyline}", c.length());
        // Equal steps of u are equal steps along the curve.
        for k in 0..20 {
            let (u0, u1) = (f64::from(k) / 20.0, f64::from(k + 1) / 20.0);
            let step: f64 = (0..400)
                .map(|m| {
                    let at = |m: i32| c.point(u0 + (u1 - u0) * f64::from(m) / 400.0);
                    hypot(at(m + 1)[0] - at(m)[0], at(m + 1)[1] - at(m)[1])
                })
                .sum();
            assert!((step * 20.0 / c.length() - 1.0).abs() < 2e-3, "{json} from {u0}: {step}");
        }
        let t = c.heading(0.3);
        assert!((hypot(t[0], t[1]) - 1.0).abs() < 1e-9);
    }
    let quarter = curve(r#"{"bezier":[1000,0,1000,552.2847498,552.2847498,1000,0,1000],"noise":[0,1,0]}"#);
    assert!((quarter.length() / (500.0 * std::f64::consts::PI) - 1.0).abs() < 3e-4);
}

#[test]
fn a_polyline_stays_within_its_tolerance() {
    use orograph::kit::curves::flatten::flatten;
    let c = curve(
        r#"{"bezier":[0,0,300,200,-200,200,100,0,150,-37.5,0,300,500,300],"height":[0.3,1,0,0.7,2,0]}"#,
    );
    for tolerance in [5.0, 0.5, 0.05] {
        let line = flatten(&c, tolerance, 1 << 20).expect("a line");
        assert!(line.iter().any(|v| v.u == 0.3) && line.iter().any(|v| v.u == 0.7));
        assert_eq!((line[0].u, line[line.len() - 1].u), (0.0, 1.0));
        assert!(line.windows(2).all(|w| w[0].u < w[1].u && w[0].arc < w[1].arc));
        for v in &line {
            let p = c.point(v.u);
            let off = hypot(p[0] - v.at[0], p[1] - v.at[1]);
            assert!(off < 1e-3 * tolerance + 1e-6, "{off} at {} of {tolerance}", v.u);
        }
        for k in 0..=4000 {
            let p = c.point(f64::from(k) / 4000.0);
            let near = |w: &[orograph::kit::curves::flatten::Vertex]| {
                let (a, b) = (w[0].at, w[1].at);
                let v = [b[0] - a[0], b[1] - a[1]];
                let t = ((p[0] - a[0]) * v[0] + (p[1] - a[1]) * v[1]) / (v[0] * v[0] + v[1] * v[1]);
                let t = t.clamp(0.0, 1.0);
                hypot(p[0] - a[0] - t * v[0], p[1] - a[1] - t * v[1])
            };
            let off = line.windows(2).map(near).fold(f64::INFINITY, f64::min);
            assert!(off <= tolerance, "{off} > {tolerance} at {k}");
        }
    }
}

#[test]
fn values_go_linearly_and_are_held() {
    let c = curve(r#"{"line":[0,0,100,0],"slope":[0.2,10,20,-30,40,0.6,30,20,10,0],"noise":[0.5,8,0.25]}"#);
    let s = c.attributes(0.3).slope.expect("slopes");
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    close(s.left_extent, 15.0);
    close(s.left_angle, -20.0);
    close(s.right_angle, 30.0);
    close(c.attributes(0.0).slope.expect("slopes").left_extent, 10.0);
    close(c.attributes(1.0).slope.expect("slopes").right_angle, 0.0);
    close(c.attributes(0.9).noise.expect("noise").amplitude, 8.0);
    assert!(c.attributes(0.5).elevation.is_none());
    assert_eq!(c.points().iter().map(|p| p.u).collect::<Vec<_>>(), [0.2, 0.5, 0.6]);
}

#[test]
fn the_free_cubic_is_the_natural_spline_and_may_overshoot() {
    let heights = r#""line":[0,0,100,0],"height":[0,0,0,0.25,100,0,0.5,100,0,1,0,0]"#;
    let monotone = curve(&format!("{{{heights}}}"));
    let free = curve(&format!(r#"{{{heights},"rise":"free"}}"#));
    let top = |c: &orograph::value::Curve| {
        (0..=1000).filter_map(|k| c.height(f64::from(k) / 1000.0)).fold(f64::MIN, f64::max)
    };
    assert_eq!(top(&monotone), 100.0);
    assert!(top(&free) > 105.0, "{}", top(&free));
    for c in [&monotone, &free] {
        for (u, h) in [(0.0, 0.0), (0.25, 100.0), (0.5, 100.0), (1.0, 0.0)] {
            assert!((c.height(u).expect("a height") - h).abs() < 1e-9);
        }
    }
    // Second derivatives of the natural spline: continuous, none at the ends.
    let h = |u: f64| free.height(u).expect("a height");
    let second = |u: f64, d: f64| (h(u + d) - 2.0 * h(u) + h(u - d)) / (d * d);
    let e = 1e-4;
    assert!((second(0.25 - 2.0 * e, e) - second(0.25 + 2.0 * e, e)).abs() < 20.0);
    assert!(second(2.0 * e, e).abs() < 20.0 && second(1.0 - 2.0 * e, e).abs() < 20.0);
    assert_eq!(free.rise(), Rise::Free);
}

proptest! {
    #[test]
    fn the_monotone_cubic_stays_between_its_points(
        heights in prop::collection::vec(-500.0..500.0_f64, 2..8),
        steps in prop::collection::vec(0.01..1.0_f64, 8),
    ) {
        let total: f64 = steps[..heights.len() - 1].iter().sum();
        let mut u = 0.0;
        let mut keys = Vec::new();
        for (i, h) in heights.iter().enumerate() {
            keys.push((u, *h));
            u = f64::min(1.0, u + steps[i] / total);
        }
        let mut s = spec(r#"{"line":[0,0,100,0]}"#);
        s.height = keys.iter().flat_map(|&(u, h)| [u, h, 0.0]).collect();
        let c = s.build().expect("a curve");
        for w in keys.windows(2) {
            let (low, high) = (w[0].1.min(w[1].1), w[0].1.max(w[1].1));
            let mut before = w[0].1;
            for k in 1..=40 {
                let h = c.height(w[0].0 + (w[1].0 - w[0].0) * f64::from(k) / 40.0).expect("a height");
                prop_assert!(h >= low - 1e-9 && h <= high + 1e-9, "{h} not in {low} to {high}");
                prop_assert!((h - before) * (w[1].1 - w[0].1) >= -1e-7);
                before = h;
            }
        }
    }

    #[test]
    fn any_numbers_are_a_curve_or_an_error(
        bezier in prop::collection::vec(prop_oneof![-1e9..1e9_f64, Just(f64::NAN), Just(f64::INFINITY), Just(0.0)], 0..24),
        height in prop::collection::vec(prop_oneof![0.0..1.0_f64, -1e6..1e6_f64, Just(f64::NAN)], 0..10),
    ) {
        let s = CurveSpec { bezier, height, ..CurveSpec::default() };
        if let Ok(c) = s.build() {
            prop_assert!(c.length().is_finite() && c.point(0.5).iter().all(|x| x.is_finite()));
        }
    }
}

/// As the graph file writes it: whole numbers without a point, spaces after commas, a line for each key.
fn written(spec: &CurveSpec) -> String {
    let json = serde_json::to_value(spec).expect("json");
    let number = |v: &serde_json::Value| v.to_string().trim_end_matches(".0").to_owned();
    let one = |(key, v): (&String, &serde_json::Value)| match v.as_array() {
        Some(list) => format!("\"{key}\": [{}]", list.iter().map(number).collect::<Vec<_>>().join(", ")),
        None => format!("\"{key}\": {v}"),
    };
    json.as_object().expect("an object").iter().map(one).collect::<Vec<_>>().join(",\n")
}

#[test]
fn the_form_in_the_file_is_short_and_comes_back() {
    let typical = r#"{"name":"north ridge","bezier":[1024,2048,1300,1900,1700,1850,2100,2000,2450,2130,2700,2500,2900,2850],"height":[0,820,12,0.45,1140,8,1,760,15],"slope":[0,420,380,-34,-38,1,300,260,-28,-30],"noise":[0,60,0.7,1,35,0.6]}"#;
    let s = spec(typical);
    assert!(written(&s).len() <= 300, "{} bytes: {}", written(&s).len(), written(&s));
    let set = Curves::from_specs(std::slice::from_ref(&s)).expect("curves");
    assert_eq!(set.specs(), std::slice::from_ref(&s));
    assert_eq!(
        serde_json::from_str::<CurveSpec>(&serde_json::to_string(&s).expect("json")).expect("a spec"),
        s
    );
    // Nothing but what is not a default.
    assert_eq!(
        written(&spec(r#"{"line":[0,0,1,1],"noise":[0,1,0],"rise":"monotone","name":""}"#)).lines().count(),
        2
    );
    let schema = serde_json::to_value(schemars::schema_for!(CurveSpec)).expect("a schema");
    assert!(schema["properties"]["slope"]["description"].as_str().is_some_and(|d| d.contains("degrees")));
    // What the helpers make is short when the numbers are.
    for set in [
        RidgeLine::default().curves(),
        RiverBed::default().curves(),
        Cliff::default().curves(),
        Hill::default().curves(),
        Crack::default().curves(),
    ] {
        let set = set.expect("curves");
        let back = Curves::from_specs(&set.specs()).expect("curves");
        assert_eq!(back, set);
    }
}

#[test]
fn errors_name_the_place() {
    let fault =
        |json: &str| match Curves::from_specs(&[spec(r#"{"line":[0,0,9,9],"noise":[0,1,0]}"#), spec(json)]) {
            Err(e) => e.to_string(),
            Ok(_) => panic!("{json} is a curve"),
        };
    let line = r#""line":[0,0,9,9]"#;
    for (json, message) in [
        (format!(r#"{{"name":"crest",{line}}}"#), "curve 1 `crest`: has no constraint"),
        (
            format!(r#"{{{line},"height":[0,1]}}"#),
            "curve 1: `height` must list 3 numbers a point (u, height, radius), got 2",
        ),
        (
            format!(r#"{{{line},"height":[0,1,0,0,2,0]}}"#),
            "curve 1: `height` point 1: u must rise from point to point, got 0 after 0",
        ),
        (
            format!(r#"{{{line},"height":[1.5,1,0]}}"#),
            "`height` point 0: u must be a number from 0 to 1, got 1.5",
        ),
        (
            format!(r#"{{{line},"slope":[0,1,1,0,90]}}"#),
            "`slope` point 0: the right angle must be a number from -89 to 89, got 90",
        ),
        (format!(r#"{{{line},"noise":[0,1,2]}}"#), "the roughness must be a number from 0 to 1, got 2"),
        (
            format!(r#"{{{line},"envelope":[0,-1,2]}}"#),
            "the left width must be a number from 0 to 1000000, got -1",
        ),
        (r#"{"noise":[0,1,0]}"#.into(), "has no line; one of `bezier`, `through` or `line`"),
        (r#"{"line":[0,0,1,1],"through":[0,0,1,1],"noise":[0,1,0]}"#.into(), "has `through` and `line`"),
        (r#"{"bezier":[0,0,1,1,2,2],"noise":[0,1,0]}"#.into(), "4, 7, 10, … points, got 3"),
        (r#"{"line":[0,0,1],"noise":[0,1,0]}"#.into(), "`line` must list x, y, x, y, …, got 3 numbers"),
        (
            r#"{"through":[5,5,5,5],"noise":[0,1,0]}"#.into(),
            "`through` needs at least two different points, got 1",
        ),
        (r#"{"bezier":[5,5,5,5,5,5,5,5],"noise":[0,1,0]}"#.into(), "must be at least 0.001 m long, got 0 m"),
        (r#"{"line":[0,0,1e9,0],"noise":[0,1,0]}"#.into(), "`line` point 1 must lie within"),
    ] {
        let got = fault(&json);
        assert!(got.contains(message), "{json}: {got}");
    }
    let mut s = spec(r#"{"line":[0,0,9,9],"noise":[0,1,0]}"#);
    s.line[2] = f64::NAN;
    assert!(s.build().is_err());
    s.line = (0..2_000_000).map(f64::from).collect();
    assert!(s.build().is_err_and(|e| e.0.contains("16385 points, got 1000000")));
    s.line = (0..20).map(f64::from).collect();
    s.height = (0..300_000).map(f64::from).collect();
    assert!(s.build().is_err_and(|e| e.0.contains("4096 points, got 100000")));
    let shared = curves(&[r#"{"line":[0,0,9,9],"noise":[0,1,0]}"#]);
    let many: Vec<_> = std::iter::repeat_n(shared.shared()[0].clone(), MAX_CURVES + 1).collect();
    assert!(Curves::new(many).is_err_and(|e| e.to_string().starts_with("curves: at most 65536, got 65537")));
}

#[test]
fn helpers_have_the_profiles_of_the_paper() {
    let one = |set: Result<Curves, _>| set.expect("curves").shared()[0].clone();
    let ridge = one(RidgeLine::default().curves());
    let crest = ridge.attributes(1.0);
    assert_eq!(crest.elevation.map(|e| e.height), Some(650.0));
    assert!(crest.slope.is_some_and(|s| s.left_angle < 0.0 && s.right_angle < 0.0));
    let bed = one(RiverBed::default().curves()).attributes(0.0);
    assert!(bed.slope.is_some_and(|s| s.left_angle > 0.0 && s.right_angle > 0.0));
    assert_eq!(bed.elevation.map(|e| e.radius), Some(40.0));
    let cliff = one(Cliff::default().curves()).attributes(0.5);
    let s = cliff.slope.expect("slopes");
    assert!(s.left_angle == -s.right_angle && s.left_angle > 60.0 && cliff.elevation.is_none());
    // tan θ · a / 2 on both sides is the drop.
    let rise = libm::tan(s.left_angle.to_radians()) * s.left_extent / 2.0;
    assert!((2.0 * rise - 300.0).abs() < 1e-6, "{rise}");
    let hill = one(Hill::default().curves()).attributes(0.5);
    assert!(
        hill.slope.is_some_and(|s| s.left_angle == 0.0 && s.left_extent > 0.0) && hill.elevation.is_some()
    );
    let crack = one(Crack::default().curves()).attributes(0.5);
    let s = crack.slope.expect("slopes");
    assert!(crack.elevation.is_none());
    assert!((libm::tan(s.left_angle.to_radians()) * s.left_extent / 2.0 - 120.0).abs() < 1e-6);
}
