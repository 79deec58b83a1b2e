//! Filters of each value by itself: curves, ranges, terraces.

use super::*;

#[test]
fn curve_is_the_monotone_cubic_of_scipy() {
    // scipy 1.17: PchipInterpolator(x, y)(t)
    let points = [[0.0, 0.05], [0.1, 0.3], [0.35, 0.32], [0.5, 0.9], [0.8, 0.7], [1.0, 0.72]];
    let known = [
        (0.03, 0.14978612276214834),
        (0.1, 0.3),
        (0.2, 0.3093959063005757),
        (0.34, 0.3184050899120042),
        (0.42, 0.5844354068634118),
        (0.6, 0.8481481481481482),
        (0.79, 0.7006518518518517),
        (0.93, 0.7054925),
        (1.0, 0.72),
    ];
    let node = Curve {
        points: points.map(|p| p.map(Ratio)).to_vec(),
        input: InputRange::Fixed { low: Number(100.0), high: Number(300.0) },
    };
    for (t, want) in known {
        let got = on(
            &node,
            &Field::constant(window([0, 0], [1, 1]), Quantity::Elevation, (100.0 + 200.0 * t) as f32),
        );
        let got = (f64::from(got.data()[0]) - 100.0) / 200.0;
        assert!((got - want).abs() < 1e-6, "{t}: {got}, not {want}");
    }
    let bad = Curve { points: [[0.5, 0.0], [0.4, 1.0]].map(|p| p.map(Ratio)).to_vec(), ..Curve::default() };
    assert!(Node::check(&bad).unwrap_err().to_string().contains("left to right"));
}

/// Runs a node on single values.
fn values<N: Node>(node: &N, quantity: Quantity, values: &[f32]) -> (Vec<f32>, Quantity) {
    // Many values stand in rows of a hundred, so that they stay on the terrain.
    let cols = if values.len() > 100 { 100 } else { values.len() };
    let at = window([0, 0], [cols as i64, (values.len() / cols) as i64]);
    let input = Field::new(at, quantity, values.to_vec());
    let out = run(node, at, &|port, g| {
        // The summary sees the same values, on the base grid.
        let spread = |i: usize| values[i % values.len()];
        let whole = || Field::new(*g, quantity, (0..g.len()).map(spread).collect());
        (port == "field").then(|| Value::Field(if g.lattice == at.lattice { input.crop(g) } else { whole() }))
    });
    (out.data().to_vec(), out.quantity())
}

#[test]
fn remap_brings_the_range_over() {
    let node = Remap {
        input: InputRange::Fixed { low: Number(100.0), high: Number(300.0) },
        out_low: Number(-10.0),
        out_high: Number(30.0),
        clamp: false,
        ..Remap::default()
    };
    let inputs = [100.0, 150.0, 300.0, 0.0, 400.0];
    assert_eq!(values(&node, Quantity::Elevation, &inputs).0, [-10.0, 0.0, 30.0, -30.0, 50.0]);
    let clamped = Remap { clamp: true, midpoint: Ratio(0.25), ..node.clone() };
    assert_eq!(values(&clamped, Quantity::Elevation, &inputs).0, [-10.0, 10.0, 30.0, -10.0, 30.0]);
    let flipped = Remap { out_low: Number(1.0), out_high: Number(0.0), clamp: true, ..node.clone() };
    assert_eq!(
        values(&flipped, Quantity::Elevation, &inputs),
        (vec![1.0, 0.75, 0.0, 1.0, 0.0], Quantity::Mask)
    );
    let auto = Remap::default();
    assert_eq!(values(&auto, Quantity::Elevation, &[-7.0, 3.0, 13.0]).0, [0.0, 0.5, 1.0]);
    assert_eq!(values(&node, Quantity::Mask, &[0.0]).1, Quantity::Elevation);
    // One spike in 400 values does not count when 1 % is left out.
    let mut spiked: Vec<f32> = (0..400).map(|i| i as f32).collect();
    spiked[7] = 1e6;
    let clip = Remap { input: InputRange::Auto { clip: Ratio(0.01) }, ..auto };
    let got = values(&clip, Quantity::Elevation, &spiked).0;
    assert!((got[200] - 0.5).abs() < 0.01, "{}", got[200]);
}

#[test]
fn clamp_is_hard_or_a_parabola() {
    let hard = Clamp { low: Number(0.0), high: Number(100.0), knee: Number(0.0) };
    assert_eq!(values(&hard, Quantity::Elevation, &[-5.0, 50.0, 100.0, 170.0]).0, [0.0, 50.0, 100.0, 100.0]);
    let soft = Clamp { knee: Number(20.0), ..hard };
    // At the limit the parabola lies a quarter of the knee inside it.
    let inputs = [-20.0, 0.0, 20.0, 50.0, 80.0, 100.0, 120.0, 1e9];
    assert_eq!(
        values(&soft, Quantity::Elevation, &inputs).0,
        [0.0, 5.0, 20.0, 50.0, 80.0, 95.0, 100.0, 100.0]
    );
    let crossed = Clamp { low: Number(5.0), high: Number(4.0), knee: Number(0.0) };
    assert!(Node::check(&crossed).unwrap_err().to_string().contains("at most `high`, 4, got 5"));
}

#[test]
fn terraces_rise_keep_their_levels_and_flatten_their_treads() {
    let ramp: Vec<f32> = (0..2000).map(|i| i as f32 * 0.5 - 300.0).collect();
    let even =
        Terrace { variation: Ratio(0.0), sharpness: Ratio(1.0), lip: Ratio(1.0), ..Terrace::default() };
    let got = values(&even, Quantity::Elevation, &ramp).0;
    let floor = |x: f32| (x / 60.0).floor() * 60.0;
    let on_level = ramp.iter().zip(&got).filter(|(x, y)| (*y - floor(**x)).abs() < 1.0).count();
    assert!(on_level > 1950, "{on_level} of 2000 lie on their tread");
    for (variation, lip) in [(0.0, 0.0), (1.0, 1.0), (0.6, 0.4)] {
        let node =
            Terrace { variation: Ratio(variation), lip: Ratio(lip), seed: Seed(7), ..Terrace::default() };
        let got = values(&node, Quantity::Elevation, &ramp).0;
        assert!(got.windows(2).all(|w| w[1] >= w[0]), "rises with the field");
        assert!(got.iter().zip(&ramp).all(|(y, x)| (y - x).abs() <= 1.9 * 60.0));
        let flat = got.windows(2).filter(|w| w[1] - w[0] < 0.15).count();
        assert!(flat > 400, "{flat} of 1999 steps of 0.5 m became less than 0.15 m");
    }
    let counted = Terrace { steps: Steps::Count { count: 4 }, ..even };
    let got = values(&counted, Quantity::Elevation, &ramp).0;
    let levels: Vec<f32> = (0..4).map(|i| -300.0 + i as f32 * (ramp[1999] - ramp[0]) / 4.0).collect();
    for level in levels {
        let near = got.iter().filter(|v| (*v - level).abs() < 4.0).count();
        assert!(near > 470, "{near} of 500 near {level}");
    }
}

#[test]
fn equalize_gives_every_band_the_same_area() {
    let at = world().grid(257).unwrap();
    let hills = |g: &Grid| {
        field(g, |x, y| {
            let t = 0.5 + 0.25 * libm::sin(x / 100.0) + 0.25 * libm::cos(y / 130.0);
            800.0 * t * t * t
        })
    };
    let got = run(&Equalize::default(), at, &|_, g| Some(Value::Field(hills(g))));
    let (lo, hi) = hills(&world().base_grid()).range().unwrap();
    let mut bands = [0usize; 10];
    for v in got.data() {
        bands[(((v - lo) / (hi - lo) * 10.0) as usize).min(9)] += 1;
    }
    let even = at.len() / 10;
    assert!(bands.iter().all(|&n| n.abs_diff(even) < even / 7), "{bands:?} of {even}");
    let flat = run(&Equalize::default(), at, &|_, g| Some(Value::Field(field(g, |_, _| 7.0))));
    assert!(flat.data().iter().all(|&v| v == 7.0));
}

#[test]
fn edge_falloff_reaches_its_level_at_the_edge_and_leaves_the_middle() {
    let at = world().grid(257).unwrap().grow_cells(3);
    let node = EdgeFalloff {
        distance: Metres(400.0),
        smoothness: Ratio(0.0),
        level: Number(-50.0),
        shape: edge_falloff::Shape::Rectangle,
    };
    let high = |_: &str, g: &Grid| Some(Value::Field(field(g, |_, _| 150.0)));
    let got = run(&node, at, &high);
    let metres = |x: i64, y: i64| got.at(x, y);
    assert_eq!([metres(-3, 50), metres(0, 96), metres(256, 96), metres(128, 192)], [-50.0; 4]);
    assert_eq!(
        [metres(25, 96), metres(50, 96), metres(128, 96), metres(128, 50)],
        [50.0, 150.0, 150.0, 150.0]
    );
    // In the corner: 30 and 40 cells from the round corner's centre at 50, 50.
    assert_eq!(metres(20, 10), -50.0);
    assert!((metres(35, 30) - 50.0).abs() < 0.01);
    let round = EdgeFalloff { shape: edge_falloff::Shape::Ellipse, smoothness: Ratio(1.0), ..node };
    let got = run(&round, at, &high);
    assert_eq!([got.at(0, 0), got.at(0, 96), got.at(128, 0)], [-50.0; 3]);
    assert_eq!(got.at(128, 96), 150.0);
    let half = got.at(25, 96);
    assert!((half - 50.0).abs() < 1.0, "{half}");
}

#[test]
fn invert_turns_about_a_value_the_range_or_a_half() {
    let about = invert::About::Value { value: Number(10.0) };
    assert_eq!(values(&Invert { about }, Quantity::Elevation, &[10.0, 0.0, 25.0]).0, [10.0, 20.0, -5.0]);
    assert_eq!(values(&Invert::default(), Quantity::Elevation, &[-4.0, 6.0, 1.0]).0, [6.0, -4.0, 1.0]);
    assert_eq!(values(&Invert::default(), Quantity::Mask, &[0.25, 0.5]).0, [0.75, 0.5]);
}
