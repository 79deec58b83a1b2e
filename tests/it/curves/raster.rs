//! The raster against closed forms, brute force and itself.

use orograph::kit::curves::{Options, rasterise};
use orograph::nodes::curves::cliff::Cliff;
use orograph::nodes::curves::crack::Crack;
use orograph::nodes::curves::hill::Hill;
use orograph::nodes::curves::ridge_line::RidgeLine;
use orograph::nodes::curves::river_bed::RiverBed;
use orograph::value::curves::CurveError;
use orograph::value::{Curves, Mark};

use super::{curves, grid, hypot, raster, samples};

const RIDGE: &str =
    r#"{"line":[20,50,80,50],"height":[0,100,4,1,160,4],"slope":[0,20,10,-30,45],"noise":[0,8,0.25]}"#;

/// How far a step across a slope reaches to its middle, with `|n_x|` and `|n_y|` as shares along the axes: a steepness
/// that fades linearly has its mean over the step there.
fn half_step(n: [f32; 2], cell: f64) -> f64 {
    let cube = |x: f32| {
        let x = f64::from(x.abs());
        x * x * x
    };
    0.5 * cell * (cube(n[0]) + cube(n[1]))
}

#[test]
fn a_straight_ridge_is_its_closed_form() {
    let g = grid([0.0; 2], 0.5, 201);
    let c = raster(&curves(&[RIDGE]), &g);
    let slack = 1e-5;
    for (at, [x, y]) in samples(&g) {
        let along = (20.0..=80.0).contains(&x);
        // To the north of a curve to the east is its left.
        let (d, left) = ((y - 50.0).abs(), y < 50.0);
        let (extent, tan) = if left { (20.0, -(libm::tan(30f64.to_radians()))) } else { (10.0, 1.0) };
        let height = (along && d <= 4.0).then(|| 100.0 + 60.0 * (x - 20.0) / 60.0);
        assert_eq!(c.height(at).is_some(), height.is_some(), "height at {x}, {y}");
        assert_eq!(c.noise(at).is_some(), height.is_some(), "noise at {x}, {y}");
        if let (Some(got), Some(want)) = (c.height(at), height) {
            assert!((f64::from(got) - want).abs() < slack, "height {got} for {want} at {x}, {y}");
            assert_eq!(c.noise(at), Some([8.0, 0.25]));
        }
        let slope = along && d > 4.0 && d <= 4.0 + extent;
        assert_eq!(c.gradient(at).is_some(), slope, "slope at {x}, {y}");
        if let Some((n, g)) = c.gradient(at) {
            assert_eq!(n, [0.0, if left { -1.0 } else { 1.0 }], "direction at {x}, {y}");
            // The rise of the step from the neighbour nearer to the crest, part of which may be plateau.
            let rise = |d: f64| tan * (d - 4.0).max(0.0) * (1.0 - 0.5 * (d - 4.0).max(0.0) / extent);
            let want = (rise(d) - rise(d - 0.5)) / 0.5;
            assert!((f64::from(g) - want).abs() < 1e-6, "steepness {g} for {want} at {x}, {y}");
        }
    }
}

#[test]
fn angles_and_extents_go_linearly_and_a_tilted_ridge_is_its_closed_form() {
    // From (10, 90) to (90, 10) by a direction that no lattice has.
    let (from, to) = ([13.0, 88.0], [91.0, 21.0]);
    let json = r#"{"line":[13,88,91,21],"height":[0,10,2,1,10,6],"slope":[0,10,8,-60,0,1,20,8,40,50]}"#;
    let g = grid([0.0; 2], 0.4, 261);
    let c = raster(&curves(&[json]), &g);
    let [tx, ty] = [to[0] - from[0], to[1] - from[1]];
    let length = hypot(tx, ty);
    let t = [tx / length, ty / length];
    let mut seen = 0;
    for (at, [x, y]) in samples(&g) {
        let p = [x - from[0], y - from[1]];
        let along = (p[0] * t[0] + p[1] * t[1]) / length;
        let aside = p[0] * t[1] - p[1] * t[0];
        let r = 2.0 + 4.0 * along;
        let (extent, angle) =
            if aside > 0.0 { (10.0 + 10.0 * along, -60.0 + 100.0 * along) } else { (8.0, 50.0 * along) };
        let beyond = aside.abs() - r;
        let inside = (1e-6..=1.0 - 1e-6).contains(&along) && beyond > 1e-5 && beyond < extent - 1e-5;
        let outside = !(-1e-6..=1.0 + 1e-6).contains(&along) || beyond < -1e-5 || beyond > extent + 1e-5;
        assert!(!(inside && c.gradient(at).is_none()), "no slope at {x}, {y}");
        assert!(!(outside && c.gradient(at).is_some()), "a slope at {x}, {y}");
        // Beside the plateau a step is part of it.
        let inside = inside && beyond > 0.4;
        if let (true, Some((n, steepness))) = (inside, c.gradient(at)) {
            let middle = beyond - half_step(n, 0.4);
            let want = libm::tan(angle.to_radians()) * (1.0 - middle / extent);
            assert!(
                (f64::from(steepness) - want).abs() < 1e-5 * (1.0 + want.abs()),
                "{steepness} for {want}"
            );
            let side = aside.signum();
            assert!((f64::from(n[0]) - side * t[1]).abs() + (f64::from(n[1]) + side * t[0]).abs() < 1e-6);
            seen += 1;
        }
    }
    assert!(seen > 4000, "{seen}");
}

#[test]
fn without_elevation_direction_and_steepness_are_turned_round() {
    let crack = r#"{"line":[20,50,80,50],"slope":[0,20,10,30,60]}"#;
    let g = grid([0.0; 2], 1.0, 101);
    let c = raster(&curves(&[crack]), &g);
    assert!(c.planes().height.is_none() && c.planes().noise.is_none());
    let tan = |a: f64| libm::tan(a.to_radians()) as f32;
    let (n, s) = c.gradient([50, 40]).expect("the left side");
    assert_eq!(n, [0.0, 1.0]);
    // Heights flow towards it: the step is that from the neighbour beyond.
    assert!((s + tan(30.0) * (1.0 - 10.5 / 20.0)).abs() < 1e-6, "{s}");
    let (n, s) = c.gradient([50, 55]).expect("the right side");
    assert_eq!(n, [0.0, -1.0]);
    assert!((s + tan(60.0) * (1.0 - 5.5 / 10.0)).abs() < 1e-6, "{s}");
    // The bottom has no side.
    assert!(c.gradient([50, 50]).is_none() && !c.has(Mark::Open, [50, 50]));
    assert!(c.gradient([50, 51]).is_some() && c.gradient([50, 49]).is_some());
}

/// The distance to a closed ring and to a bend by brute force: the strip has no hole, the nearest side wins.
#[test]
fn a_strip_that_folds_has_no_hole_and_no_spike() {
    let bends = [
        // Right angles, a hairpin, a spike, a bow much tighter than the strip is wide, an S.
        r#"{"line":[100,300,300,300,300,100],"height":[0,5,3],"slope":[0,60,60,-30,-30]}"#,
        r#"{"line":[100,200,300,200,300,216,100,216],"height":[0,5,3],"slope":[0,60,60,-30,-30]}"#,
        r#"{"line":[100,200,300,200,100,210],"height":[0,5,3],"slope":[0,60,60,-30,-30]}"#,
        r#"{"through":[100,250,200,200,210,190,200,180,100,130],"height":[0,5,3],"slope":[0,90,90,-30,-30]}"#,
        r#"{"bezier":[100,100,500,100,-100,300,300,300],"height":[0,5,3],"slope":[0,80,80,-30,-30]}"#,
        r#"{"bezier":[100,200,350,200,350,220,100,220],"height":[0,5,3],"slope":[0,80,80,-30,-30]}"#,
    ];
    let cell = 2.0;
    let g = grid([0.0; 2], cell, 201);
    for json in bends {
        let set = curves(&[json]);
        let curve = set.iter().next().expect("a curve");
        let c = raster(&set, &g);
        let line: Vec<_> = (0..=6000).map(|i| curve.point(f64::from(i) / 6000.0)).collect();
        let width = 3.0 + curve.attributes(0.0).slope.expect("slopes").left_extent;
        let tan = libm::tan(30f64.to_radians());
        let ends = [(line[0], curve.heading(0.0)), (line[6000], curve.heading(1.0).map(|x| -x))];
        for (at, p) in samples(&g) {
            let d = line.iter().map(|q| hypot(p[0] - q[0], p[1] - q[1])).fold(f64::INFINITY, f64::min);
            // Beyond an end the strip stops; leave out what is nearest to one.
            let at_end = |(q, t): ([f64; 2], [f64; 2])| {
                let v = [p[0] - q[0], p[1] - q[1]];
                v[0] * t[0] + v[1] * t[1] < 0.5 && hypot(v[0], v[1]) < d + 0.2
            };
            if ends.into_iter().any(at_end) {
                continue;
            }
            let (height, gradient) = (c.height(at), c.gradient(at));
            if d < 3.0 - 0.2 {
                assert_eq!(height, Some(5.0), "{json} at {p:?}, {d} m away");
            } else if d > 3.0 + 1.2 && d < width - 0.2 {
                assert_eq!(height, None, "{json} at {p:?}, {d} m away");
                let Some((n, steepness)) = gradient else {
                    // On a crease where both sides point at each other nothing can be said.
                    assert!(c.has(Mark::Open, at), "a hole in {json} at {p:?}, {d} m away");
                    continue;
                };
                let beyond = (d - 3.0 - half_step(n, cell)).max(0.0);
                let want = -tan * (1.0 - beyond / (width - 3.0));
                let on_crease = steepness > (want + 0.01) as f32;
                assert!(steepness <= 0.0, "a spike {steepness} in {json} at {p:?}");
                assert!(
                    f64::from(steepness) > want - 0.01,
                    "a spike {steepness} for {want} in {json} at {p:?}"
                );
                assert!((hypot(f64::from(n[0]), f64::from(n[1])) - 1.0).abs() < 1e-5);
                if on_crease {
                    // Two feet equally near: the common direction, less steep.
                    let near = line.iter().filter(|q| hypot(p[0] - q[0], p[1] - q[1]) < d + 0.1).count();
                    assert!(near > 2, "{steepness} for {want} in {json} at {p:?}");
                }
            } else if d > width + 0.2 {
                assert!(height.is_none() && gradient.is_none(), "{json} at {p:?}, {d} m away");
            }
        }
    }
}

/// A crack does not know how high its ground is.
#[test]
fn where_the_slope_of_a_crack_meets_another_the_gradient_is_left_open() {
    let crack = r#"{"line":[0,50,100,50],"slope":[0,20,20,30,30]}"#;
    let other = r#"{"line":[50,0,50,100],"slope":[0,20,20,30,30]}"#;
    let ridge = r#"{"line":[50,0,50,100],"height":[0,200,0],"slope":[0,20,20,-30,-30]}"#;
    for scene in [[crack, other], [crack, ridge], [ridge, crack]] {
        let c = raster(&curves(&scene), &grid([0.0; 2], 1.0, 101));
        assert!(c.has(Mark::Open, [60, 60]) && c.gradient([60, 60]).is_none());
        assert!(c.planes().ground.as_ref().is_none_or(|p| p[60 * 101 + 60] == 0.0));
        assert!(c.has(Mark::Gradient, [20, 60]) && !c.has(Mark::Open, [20, 60]));
    }
}

#[test]
fn a_curve_that_crosses_itself_averages_its_heights() {
    // A loop: the first passage to the east at u ≈ 0.25, the second to the north at u ≈ 0.75.
    let json = r#"{"line":[0,100,200,100,200,200,100,200,100,0],"height":[0,0,10,1,600,10]}"#;
    let g = grid([-50.0, -50.0], 2.0, 151);
    let set = curves(&[json]);
    let c = raster(&set, &g);
    let at = |x: f64, y: f64| [((x + 50.0) / 2.0) as usize, ((y + 50.0) / 2.0) as usize];
    // 100 of 600 m there, and 500 of 600: both share the crossing.
    assert!((c.height(at(100.0, 100.0)).expect("the crossing") - 300.0).abs() < 1e-3);
    assert!((c.height(at(80.0, 100.0)).expect("the first passage") - 80.0).abs() < 1e-3);
    assert!((c.height(at(100.0, 80.0)).expect("the second passage") - 520.0).abs() < 1e-3);
    assert!((c.height(at(106.0, 94.0)).expect("the crossing") - (106.0 + 506.0) / 2.0).abs() < 1e-3);
    // A corner is no crossing: the nearer arm counts.
    assert!((c.height(at(194.0, 104.0)).expect("the corner") - 194.0).abs() < 1e-3);
}

#[test]
fn where_curves_cross_plateaus_are_averaged_and_the_ground_lies_between() {
    let a = r#"{"line":[0,50,100,50],"height":[0,100,5],"slope":[0,20,20,-30,-30],"noise":[0,10,0.2]}"#;
    let b = r#"{"line":[50,0,50,100],"height":[0,200,5],"slope":[0,20,20,-30,-30],"noise":[0,30,0.6]}"#;
    let g = grid([0.0; 2], 1.0, 101);
    let c = raster(&curves(&[a, b]), &g);
    assert_eq!(c.height([50, 50]), Some(150.0));
    assert_eq!(c.noise([50, 50]), Some([20.0, 0.4]));
    assert_eq!(c.height([20, 50]), Some(100.0));
    assert_eq!(c.height([50, 20]), Some(200.0));
    // Slopes of both, equally near: the middle of their heights is followed, and no gradient.
    let fall = libm::tan(30_f64.to_radians()) * 5.0 * (1.0 - 0.5 * 5.0 / 20.0);
    let (height, share) = c.ground([60, 60]).expect("ground");
    assert!((f64::from(height) - (150.0 - fall)).abs() < 1e-3 && share == 1.0, "{height}, {share}");
    assert_eq!(c.planes().trust.as_ref().expect("a plane")[60 * 101 + 60], 0.0);
    assert!(c.height([60, 60]).is_none() && !c.has(Mark::Open, [60, 60]));
    // Near one of them its own slope holds, with a share of 1 − w / Σ w of the other four times over.
    let (height, share) = c.ground([57, 65]).expect("ground");
    let weight = |x: f64| (1.0 / x - 1.0 / 20.0) * (1.0 / x - 1.0 / 20.0);
    let [near, far] = [weight(2.0), weight(10.0)];
    let ground = |h: f64, x: f64| h - libm::tan(30_f64.to_radians()) * x * (1.0 - 0.5 * x / 20.0);
    let mean = (near * ground(200.0, 2.0) + far * ground(100.0, 10.0)) / (near + far);
    assert!((f64::from(height) - mean).abs() < 1e-3, "{height} for {mean}");
    assert!((f64::from(share) - 4.0 * far / (near + far)).abs() < 1e-5, "{share}");
    // The slope of one over the plateau of the other: both are told.
    assert!(c.height([50, 60]).is_some() && c.gradient([50, 60]).is_some());
    assert!(c.gradient([20, 60]).is_some());
    // In either order the same.
    let d = raster(&curves(&[b, a]), &g);
    assert_eq!(c.planes().marks, d.planes().marks);
    assert_eq!(c.planes().height, d.planes().height);
}

/// Cells of a mark that hang together, corners included.
fn islands(c: &orograph::value::Constraints, mark: Mark) -> (usize, usize) {
    let g = *c.grid();
    let mut left: std::collections::BTreeSet<[usize; 2]> =
        samples(&g).map(|(at, _)| at).filter(|&at| c.has(mark, at)).collect();
    let all = left.len();
    let mut islands = 0;
    while let Some(seed) = left.pop_first() {
        islands += 1;
        let mut stack = vec![seed];
        while let Some([i, j]) = stack.pop() {
            for di in -1..=1 {
                for dj in -1..=1 {
                    let next = [i.wrapping_add_signed(di), j.wrapping_add_signed(dj)];
                    if left.remove(&next) {
                        stack.push(next);
                    }
                }
            }
        }
    }
    (islands, all)
}

#[test]
fn a_line_thinner_than_a_cell_marks_a_connected_line() {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    // Smooth curves swing out beyond their points.
    let g = grid([-50.0; 2], 1.0, 201);
    for round in 0..300 {
        let n = 2 + round % 5;
        let points: Vec<String> = (0..2 * n).map(|_| format!("{}", 3.0 + 94.0 * random())).collect();
        let key = if round % 2 == 0 { "through" } else { "line" };
        for group in [r#""height":[0,7,0]"#, r#""height":[0,7,0.3]"#, r#""noise":[0,7,0.5]"#] {
            let json = format!(r#"{{"{key}":[{}],{group}}}"#, points.join(","));
            let set = curves(&[&json]);
            let c = raster(&set, &g);
            let mark = if group.contains("noise") { Mark::Noise } else { Mark::Height };
            let (islands, cells) = islands(&c, mark);
            assert_eq!(islands, 1, "{json}");
            let length = set.iter().map(orograph::value::Curve::length).sum::<f64>();
            assert!((cells as f64) < 1.3 * length + 9.0, "{cells} cells for {length} m: {json}");
        }
    }
}

#[test]
fn a_curve_smaller_than_a_cell_marks_one() {
    let g = grid([0.0; 2], 10.0, 11);
    let c = raster(&curves(&[r#"{"line":[52,53,54,53],"height":[0,7,0]}"#]), &g);
    assert_eq!(islands(&c, Mark::Height), (1, 1));
    assert_eq!(c.height([5, 5]), Some(7.0));
}

#[test]
fn a_finer_grid_shows_the_same_regions() {
    let both = [
        r#"{"through":[100,100,300,180,420,60,700,400,500,800],"height":[0,5,20,1,50,30],"slope":[0,90,60,-30,-30]}"#,
        r#"{"bezier":[900,100,100,300,900,700,200,900],"slope":[0,40,40,60,60]}"#,
    ];
    let set = curves(&both);
    let area = |cell: f64, n: usize| {
        let c = raster(&set, &grid([0.0; 2], cell, n));
        let count = |m: Mark| c.mask(m).iter().map(|&x| f64::from(x)).sum::<f64>() * cell * cell;
        [count(Mark::Height), count(Mark::Gradient)]
    };
    let [coarse, middle, fine] = [area(8.0, 129), area(4.0, 257), area(2.0, 513)];
    let finest = area(1.0, 1025);
    for k in 0..2 {
        let off = |a: [f64; 2]| (a[k] - finest[k]).abs() / finest[k];
        assert!(
            off(coarse) < 0.05 && off(middle) < 0.02 && off(fine) < 0.01,
            "{k}: {coarse:?} {middle:?} {fine:?} {finest:?}"
        );
    }
    // Coincident samples agree but near edges. A steepness is that at the middle of a step, which is nearer to the crest
    // by 3 m on the coarse grid, and farther from the bottom of a crack.
    for (json, [tan, left, right]) in
        both.iter().zip([[-1.0 / 3f64.sqrt(), 90.0, 60.0], [3f64.sqrt(), 40.0, 40.0]])
    {
        let set = curves(&[json]);
        let (a, b) = (raster(&set, &grid([0.0; 2], 8.0, 129)), raster(&set, &grid([0.0; 2], 2.0, 513)));
        let differ = samples(a.grid()).filter(|&(at, _)| {
            let fine = at.map(|i| 4 * i);
            let both = (a.gradient(at), b.gradient(fine));
            let close = |(n, p): ([f32; 2], f32), q: f32| {
                let moved = half_step(n, 8.0) - half_step(n, 2.0);
                let ends = f64::from(q.abs()) < tan.abs() * 8.0 / left;
                ends || [left, right].iter().any(|a| (f64::from(p - q) - tan * moved / a).abs() < 0.02)
            };
            // Beside the plateau a step is part of it; so is one beside the end of a slope.
            let [i, j] = at.map(|i| i.clamp(1, 127));
            if [[i - 1, j], [i + 1, j], [i, j - 1], [i, j + 1]].iter().any(|&at| a.has(Mark::Height, at)) {
                return false;
            }
            a.has(Mark::Height, at) != b.has(Mark::Height, fine)
                || both.0.is_some() != both.1.is_some()
                || matches!(both, (Some(p), Some(q)) if !close(p, q.1))
        });
        let differ = differ.count();
        assert!(differ < 129 * 129 / 100, "{differ}");
    }
}

fn all_helpers() -> Curves {
    let sets = [
        RidgeLine::default().curves(),
        RiverBed::default().curves(),
        Cliff::default().curves(),
        Hill::default().curves(),
        Crack::default().curves(),
    ];
    orograph::kit::curves::merge(&sets.map(|s| s.expect("curves"))).expect("merged")
}

#[test]
fn a_tile_is_the_crop_of_the_whole_and_threads_do_not_matter() {
    let mut specs = all_helpers().specs();
    specs.iter_mut().for_each(|s| s.envelope = vec![0.0, 200.0, 100.0, 1.0, 50.0, 300.0]);
    let set = Curves::from_specs(&specs).expect("curves");
    let g = grid([0.0; 2], 32.0, 257);
    let options = Options { feather: 0.5 };
    let run = |threads: usize, g: &orograph::value::Grid| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| rasterise(&set, g, &options, &|| false)).expect("a raster")
    };
    let whole = run(1, &g);
    assert_eq!(whole, run(2, &g));
    assert_eq!(whole, run(7, &g));
    assert!(whole.planes().envelope.as_ref().is_some_and(|p| p.iter().any(|&w| w > 0.0 && w < 1.0)));
    let tile = orograph::value::Grid { col: 61, row: 87, cols: 75, rows: 41, ..g };
    let part = run(2, &tile);
    for (at @ [i, j], _) in samples(&tile) {
        let there = [i + 61, j + 87];
        assert_eq!(part.height(at), whole.height(there));
        assert_eq!(part.gradient(at), whole.gradient(there));
        assert_eq!(part.ground(at), whole.ground(there));
        assert_eq!(part.noise(at), whole.noise(there));
        assert_eq!(part.envelope(at).to_bits(), whole.envelope(there).to_bits());
        assert_eq!(part.has(Mark::Open, at), whole.has(Mark::Open, there));
    }
}

#[test]
fn the_envelope_goes_beyond_slopes_and_ends() {
    let json = r#"{"line":[40,60,100,60],"height":[0,5,2],"slope":[0,10,20,0,0],"envelope":[0,8,12]}"#;
    let g = grid([0.0; 2], 1.0, 141);
    let set = curves(&[json]);
    let c = raster(&set, &g);
    for (at, [x, y]) in samples(&g) {
        // Left 2 + 10 + 8, right 2 + 20 + 12; beyond the ends half an ellipse of 10.
        let reach = if y < 60.0 { 20.0 } else { 34.0 };
        let over = if x < 40.0 { 40.0 - x } else { (x - 100.0).max(0.0) };
        let far = hypot(over / 10.0, (y - 60.0) / reach);
        if (far - 1.0).abs() > 1e-6 {
            assert_eq!(c.envelope(at), if far < 1.0 { 1.0 } else { 0.0 }, "at {x}, {y}");
        }
    }
    let soft = rasterise(&set, &g, &Options { feather: 0.5 }, &|| false).expect("a raster");
    assert_eq!(soft.envelope([70, 60 - 16]), 1.0);
    assert!((soft.envelope([70, 60 - 18]) - 0.5).abs() < 1e-6);
    assert_eq!(soft.envelope([70, 60 - 20]), 0.0);
    assert!((soft.envelope([70, 60 + 31]) - 0.5).abs() < 1e-6);
    // Along the axis beyond an end, 10 m, of which the outer half fades.
    assert_eq!(soft.envelope([40 - 5, 60]), 1.0);
    assert!(soft.envelope([40 - 8, 60]) > 0.1 && soft.envelope([40 - 8, 60]) < 0.9);
    // The envelope alone asks for nothing else.
    assert!(c.has(Mark::Height, [70, 60]) && !c.has(Mark::Height, [70, 45]));
}

#[test]
fn closed_curves_have_no_seam() {
    let at = |k: i32| {
        let a = f64::from(k % 24) * std::f64::consts::TAU / 24.0;
        format!("{},{}", 100.0 + 50.0 * libm::cos(a), 100.0 + 50.0 * libm::sin(a))
    };
    let points: Vec<_> = (0..=24).map(at).collect();
    let ring = format!(r#"{{"through":[{}],"height":[0,5,6],"slope":[0,30,30,-20,-20]}}"#, points.join(","));
    let g = grid([0.0; 2], 1.0, 201);
    let set = curves(&[&ring]);
    assert!(set.iter().all(orograph::value::Curve::is_closed));
    let c = raster(&set, &g);
    let tan = libm::tan(20f64.to_radians());
    for (at, [x, y]) in samples(&g) {
        let d = (hypot(x - 100.0, y - 100.0) - 50.0).abs();
        if d < 5.9 {
            assert_eq!(c.height(at), Some(5.0), "{x}, {y}");
        } else if d > 6.1 && d < 35.9 {
            let (n, s) = c.gradient(at).expect("a slope");
            let middle = d - 6.0 - half_step(n, 1.0);
            // Beside the plateau a step is part of it.
            let whole = d > 7.1;
            let close = (f64::from(s) + tan * (1.0 - middle / 30.0)).abs() < 2e-3;
            assert!(s <= 0.0 && (close || !whole), "{s} at {x}, {y}");
        }
    }
}

#[test]
fn nothing_gives_nothing_and_too_much_is_refused() {
    let g = grid([0.0; 2], 1.0, 33);
    let none = raster(&Curves::default(), &g);
    assert!(none.planes().height.is_none() && none.planes().marks.iter().all(|&m| m == 0));
    let empty = orograph::value::Grid { cols: 0, rows: 0, ..g };
    assert_eq!(raster(&curves(&[RIDGE]), &empty).planes().marks.len(), 0);
    let far = raster(&curves(&[RIDGE]), &grid([1e6, -1e6], 1.0, 33));
    assert!(far.planes().marks.iter().all(|&m| m == 0));
    // A hundred kilometres in millimetres.
    let wild = r#"{"bezier":[0,0,9e7,9e7,-9e7,9e7,0,1],"height":[0,5,0]}"#;
    let fine = grid([0.0; 2], 1e-6, 33);
    let error = rasterise(&curves(&[wild]), &fine, &Options::default(), &|| false);
    assert!(matches!(error, Ok(_) | Err(CurveError::TooMany { .. })));
    let stopped = rasterise(&curves(&[RIDGE]), &g, &Options::default(), &|| true);
    assert_eq!(stopped, Err(CurveError::Cancelled));
    let bad = rasterise(&curves(&[RIDGE]), &g, &Options { feather: f64::NAN }, &|| false);
    assert!(bad.is_err_and(|e| e.to_string().contains("`feather`")));
    let huge = r#"{"line":[0,0,30,30],"height":[0,5,1e6],"slope":[0,1e6,1e6,-89,89],"envelope":[0,1e6,1e6]}"#;
    let c = raster(&curves(&[huge]), &g);
    assert!(c.height([16, 16]).is_some());
}
