//! Transform, warp and the sampling they share.

use super::*;
use orograph::kit::sample::Interpolation;
use orograph::kit::simd::Level;

#[test]
fn transform_is_exact_for_whole_cells_quarter_turns_and_mirrors() {
    let at = window([100, 70], [131, 95]);
    let wide = rough(&world().apron(at.lattice));
    let check = |node: Transform, from: &dyn Fn(i64, i64) -> (i64, i64)| {
        let got = run(&node, at, &rough_field);
        for row in at.row..at.row_end() {
            for col in at.col..at.col_end() {
                let (c, r) = from(col, row);
                assert_eq!(got.at(col, row), wide.at(c, r), "{node:?} at {col}, {row}");
            }
        }
    };
    let (none, mid) = (Transform::default(), (128, 96));
    let shift = Transform { move_east: Metres(24.0), move_south: Metres(-80.0), ..none.clone() };
    check(shift, &|c, r| (c - 3, r + 10));
    // A quarter clockwise takes what is north to the east.
    check(Transform { rotate: Degrees(90.0), ..none.clone() }, &|c, r| {
        (mid.0 + (r - mid.1), mid.1 - (c - mid.0))
    });
    check(Transform { rotate: Degrees(-180.0), ..none.clone() }, &|c, r| (2 * mid.0 - c, 2 * mid.1 - r));
    check(Transform { mirror: Mirror::EastWest, ..none.clone() }, &|c, r| (2 * mid.0 - c, r));
    check(Transform { mirror: Mirror::NorthSouth, ..none.clone() }, &|c, r| (c, 2 * mid.1 - r));
    let about =
        Transform { rotate: Degrees(180.0), center_east: Metres(80.0), center_south: Metres(-8.0), ..none };
    check(about, &|c, r| (2 * (mid.0 + 10) - c, 2 * (mid.1 - 1) - r));
}

#[test]
fn transform_turns_and_scales_a_smooth_field_as_the_formula_says() {
    let smooth = |x: f64, y: f64| 100.0 * libm::sin(x / 150.0) + 80.0 * libm::cos(y / 120.0 + x / 400.0);
    let at = window([60, 60], [110, 90]);
    let node = Transform {
        rotate: Degrees(30.0),
        scale: Number(1.6),
        move_south: Metres(55.0),
        ..Transform::default()
    };
    let got = run(&node, at, &|_, g| Some(Value::Field(field(g, smooth))));
    let (cx, cy) = (300.0 + 1024.0, -200.0 + 768.0);
    let (s, c) = (libm::sin(std::f64::consts::PI / 6.0), libm::cos(std::f64::consts::PI / 6.0));
    for (i, j) in [(0, 0), (49, 0), (25, 29), (13, 7)] {
        let (u, v) = (at.x(i) - cx, at.y(j) - cy - 55.0);
        let want = smooth(cx + (c * u + s * v) / 1.6, cy + (c * v - s * u) / 1.6);
        assert!((f64::from(got.row(j)[i]) - want).abs() < 0.02, "at {i}, {j}");
    }
}

#[test]
fn enlarging_shows_the_detail_of_a_finer_lattice() {
    // Waves of 6 m, which samples 8 m apart cannot hold, drawn four times as large.
    let waves = |x: f64, _: f64| 10.0 * libm::sin(x * std::f64::consts::TAU / 6.0);
    let at = window([100, 90], [140, 96]);
    let node = Transform { scale: Number(4.0), ..Transform::default() };
    let got = run(&node, at, &|_, g| Some(Value::Field(field(g, waves))));
    for (i, &v) in got.row(3).iter().enumerate() {
        let want = waves(1324.0 + (at.x(i) - 1324.0) / 4.0, 0.0);
        assert!((f64::from(v) - want).abs() < 0.01, "{v}, not {want}");
    }
}

#[test]
fn warp_fetches_from_where_the_displacement_points_within_its_limit() {
    let at = window([50, 50], [70, 60]);
    let fetched = |dx: f64, dy: f64, limit: f64| {
        let source = move |port: &str, g: &Grid| match port {
            "field" => Some(Value::Field(rough(g))),
            "dx" => Some(Value::Field(field(g, |_, _| dx))),
            "dy" => Some(Value::Field(field(g, |_, _| dy))),
            _ => None,
        };
        run(&Warp { limit: Metres(limit), factor: Number(2.0), ..Warp::default() }, at, &source)
    };
    let wide = rough(&at.grow_cells(60));
    let moved = |c, r| wide.crop(&Grid { col: at.col + c, row: at.row + r, ..at });
    assert_eq!(fetched(16.0, -12.0, 100.0).data(), moved(4, -3).data());
    assert_eq!(fetched(1600.0, 0.0, 40.0).data(), moved(5, 0).data());
    // 300 and 400 m shortened to 40 are 24 and 32.
    assert_eq!(fetched(150.0, 200.0, 40.0).data(), moved(3, 4).data());
}

#[test]
fn built_in_warp_reaches_about_its_amplitude_and_not_beyond_its_limit() {
    let at = window([0, 0], [200, 150]);
    let east = |g: &Grid| field(g, |x, _| x);
    let warped = |limit| {
        let node = Warp { limit: Metres(limit), amplitude: Metres(120.0), octaves: 1, ..Warp::default() };
        let got = run(&node, at, &|p, g| (p == "field").then(|| Value::Field(east(g))));
        got.data().iter().zip(east(&at).data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let (free, bound) = (warped(1000.0), warped(30.0));
    assert!(free > 40.0 && free < 130.0, "{free}");
    assert!(bound > 25.0 && bound < 30.01, "{bound}");
}

#[test]
fn sampling_goes_through_the_samples_and_reproduces_polynomials() {
    let at = window([-4, -3], [12, 9]);
    let plane = field(&at, |x, y| 3.0 * x - 2.0 * y);
    let lattice = at.lattice;
    let sampler = sample::Sampler::new(&plane).unwrap();
    for (u, v) in [(0.25, 1.5), (3.9, 4.01), (-1.3, 0.0)] {
        let want = 3.0 * (lattice.origin[0] + u * CELL) - 2.0 * (lattice.origin[1] + v * CELL);
        assert!((f64::from(sampler.bilinear([u, v])) - want).abs() < 1e-3);
        assert!((f64::from(sampler.bicubic([u, v])) - want).abs() < 1e-3);
    }
    let bumps = rough(&at);
    let sampler = sample::Sampler::new(&bumps).unwrap();
    for (c, r) in [(-4, -3), (0, 0), (11, 8), (11, -3)] {
        let at = [c as f64, r as f64];
        assert_eq!([sampler.bilinear(at), sampler.bicubic(at), sampler.nearest(at)], [bumps.at(c, r); 3]);
    }
    // Beyond the window the border goes on, however far.
    assert_eq!(sampler.bicubic([1e12, -1e12]), bumps.at(11, -3));
    assert_eq!(sampler.bilinear([-70.5, 2.0]), bumps.at(-4, 2));
    // Quadratics come out of Catmull-Rom as they went in.
    let square = |t: f32| 0.5 * t * t - 3.0 * t + 1.0;
    let p = [-1.0, 0.0, 1.0, 2.0].map(square);
    assert!((sample::catmull_rom(p, 0.3) - square(0.3)).abs() < 1e-6);
}

/// A window of rough heights off the lattice's corner, `cols` by `rows`.
fn patch(cols: i64, rows: i64) -> Field {
    rough(&window([-7, 11], [-7 + cols, 11 + rows]))
}

#[test]
fn a_row_of_positions_reads_as_each_alone_on_every_instruction_set() {
    // Places about a window, on its samples, between, beside, and far off; some no numbers at all.
    let place = |i: usize, [cols, rows]: [i64; 2]| {
        let part = |k: u64, n: i64| (hash::unit(k, i as u64) * 1.4 - 0.2) * n as f64;
        let at = [part(1, cols) - 7.0, part(2, rows) + 11.0];
        match i % 97 {
            5 => at.map(f64::floor),
            23 => [at[0].ceil(), at[1]],
            41 => [at[0], f64::NAN],
            59 => [1e18, at[1]],
            77 => [at[0], f64::NEG_INFINITY],
            _ => at,
        }
    };
    // Inside alone, so that whole blocks are read at once.
    let inside = |i: usize, [cols, rows]: [i64; 2]| {
        let part = |k: u64, n: i64| 1.0 + hash::unit(k, i as u64) * (n as f64 - 3.0);
        [part(3, cols) - 7.0, part(4, rows) + 11.0]
    };
    type Place<'a> = &'a dyn Fn(usize, [i64; 2]) -> [f64; 2];
    for (size, place) in [[1, 1], [3, 9], [4, 4], [5, 4], [37, 1], [61, 43]]
        .into_iter()
        .flat_map(|size| [(size, &place as Place<'_>), (size, &inside)])
    {
        let field = patch(size[0], size[1]);
        let sampler = sample::Sampler::new(&field).unwrap();
        for (method, level, n) in [Interpolation::Nearest, Interpolation::Linear, Interpolation::Cubic]
            .into_iter()
            .flat_map(|m| Level::available().into_iter().map(move |l| (m, l)))
            .flat_map(|(m, l)| [1, 31, 32, 33, 500].map(|n| (m, l, n)))
        {
            let mut got = vec![0.0; n];
            let places = |first: usize, [us, vs]: [&mut [f64]; 2]| {
                for (i, (u, v)) in us.iter_mut().zip(vs).enumerate() {
                    [*u, *v] = place(first + i, size);
                }
            };
            sampler.on(level).row(method, Quantity::Elevation, places, &mut got);
            for (i, &got) in got.iter().enumerate() {
                let alone = sampler.value(method, place(i, size));
                let want = if method == Interpolation::Nearest { alone } else { sample::finite(alone) };
                assert_eq!(
                    got.to_bits(),
                    want.to_bits(),
                    "{size:?} {method:?} {level:?} {:?}",
                    place(i, size)
                );
            }
        }
    }
}
