//! Tests of: filters and blends.

use orograph::kit::{blur, hash, sample};
use orograph::node::{AnyNode, Cancel, Context, Error, Node, Summary};
use orograph::nodes::Registry;
use orograph::nodes::blend::{combine, combine::Combine, mix::Mix, switch::Switch};
use orograph::nodes::filter::{
    blur::Blur, clamp::Clamp, curve::Curve, edge_falloff, edge_falloff::EdgeFalloff, equalize::Equalize,
    invert, invert::Invert, median::Median, remap::InputRange, remap::Remap, sharpen::Sharpen,
    terrace::Steps, terrace::Terrace, transform::Mirror, transform::Transform, warp::Warp,
};
use orograph::params::{Param, Shape};
use orograph::ports::{Ports, Wires};
use orograph::units::{Degrees, Metres, Number, Ratio, Seed};
use orograph::value::{Field, Grid, Lattice, Quantity, Raster, Terrain, Value, Vectors};
use serde_json::{Map, Value as Json, json};

const CELL: f64 = 8.0;

fn world() -> Terrain {
    Terrain { origin: [300.0, -200.0], width: 2048.0, depth: 1536.0, base: 129, ..Terrain::default() }
}

/// A window of the lattice of 257 samples (8 m).
fn window(from: [i64; 2], end: [i64; 2]) -> Grid {
    Grid::between(world().grid(257).expect("a size that fits").lattice, from, end)
}

/// The terrain and half a terrain around it, on the lattice of a grid.
fn apron(grid: &Grid) -> Grid {
    let half = i64::from(grid.lattice.intervals) / 2;
    let rows = i64::from(grid.lattice.intervals) * 3 / 4;
    Grid::between(grid.lattice, [-half, -half], [half * 3 + 1, rows + half + 1])
}

/// A window cut to the apron, never to nothing.
fn clipped(window: &Grid) -> Grid {
    let apron = apron(window);
    let cut = |from: i64, end: i64, [lo, hi]: [i64; 2]| {
        let from = from.clamp(lo, hi - 1);
        [from, end.clamp(from + 1, hi)]
    };
    let [col, col_end] = cut(window.col, window.col_end(), [apron.col, apron.col_end()]);
    let [row, row_end] = cut(window.row, window.row_end(), [apron.row, apron.row_end()]);
    Grid::between(window.lattice, [col, row], [col_end, row_end])
}

/// Hills with noise at every sample and a cliff.
fn rough(grid: &Grid) -> Field {
    field(grid, |x, y| {
        let noise = hash::unit(x.to_bits() ^ y.to_bits().rotate_left(17), 1);
        let cliff = if x + 0.5 * y > 900.0 { 180.0 } else { 0.0 };
        300.0 + 200.0 * libm::sin(x / 170.0) * libm::cos(y / 230.0) + 40.0 * noise + cliff
    })
}

fn field(grid: &Grid, f: impl Fn(f64, f64) -> f64) -> Field {
    Field::from_fn(*grid, Quantity::Elevation, |x, y| f(x, y) as f32)
}

type Source<'a> = &'a (dyn Fn(&str, &Grid) -> Option<Value> + Sync);

fn rough_field(port: &str, grid: &Grid) -> Option<Value> {
    matches!(port, "field" | "a" | "b").then(|| Value::Field(rough(grid)))
}

/// Runs a node as the engine does: a summary on the base grid, inputs on their footprints, cut to the apron.
fn run_any(node: &dyn AnyNode, ports: &[&'static str], at: Grid, source: Source<'_>) -> Result<Value, Error> {
    let (terrain, cancel) = (world(), Cancel::default());
    let wires = |grid_of: &dyn Fn(&str) -> Grid| {
        let value = |&p: &&'static str| Some((p, source(p, &grid_of(p))?));
        ports.iter().filter_map(value).collect::<Wires>()
    };
    let summary: Option<Summary> = node.needs_summary().then(|| {
        let base = terrain.base_grid();
        node.summarize(&Context::bare(base, &terrain, &cancel), wires(&|_| base)).expect("a summary")
    });
    let cx = Context { whole: summary.as_ref(), ..Context::bare(at, &terrain, &cancel) };
    let inputs = wires(&|p| clipped(&node.footprint(p, &at, &terrain)));
    let out = node.run(&cx, inputs)?.get("field").cloned().expect("an output `field`");
    assert_eq!(out.grid(), Some(&at));
    assert_eq!(out.first_not_finite(), None, "{node:?}");
    Ok(out)
}

fn run<N: Node>(node: &N, at: Grid, source: Source<'_>) -> Field {
    let ports: Vec<_> = N::In::PORTS.iter().map(|p| p.name).collect();
    match run_any(node, &ports, at, source).expect("a result") {
        Value::Field(field) => field,
        other => panic!("a field, got {:?}", other.wire_type()),
    }
}

/// Runs a node with one input, given on exactly the window of the output and whatever lies around it.
fn on<N: Node>(node: &N, input: &Field) -> Field {
    run(node, *input.grid(), &|port, grid| {
        matches!(port, "field" | "a").then(|| Value::Field(input.crop(grid)))
    })
}

fn bits(field: &Field) -> Vec<u32> {
    field.data().iter().map(|v| v.to_bits()).collect()
}

/// The result on odd windows, in the middle and where the footprint leaves the apron, is the crop of the whole.
fn tiles_equal_whole<N: Node>(node: &N, source: Source<'_>) {
    let all = window([-128, -128], [385, 321]);
    let whole = run(node, all, source);
    let tiles = [
        window([0, 0], [65, 65]),
        window([17, -23], [90, 20]),
        window([101, 64], [102, 65]),
        window([33, 100], [180, 101]),
        window([-128, -128], [-60, -71]),
        window([311, 250], [385, 321]),
        window([-128, 40], [385, 47]),
    ];
    for tile in tiles {
        let part = run(node, tile, source);
        assert!(bits(&part) == bits(&whole.crop(&tile)), "{node:?} on {tile:?}");
    }
    // And from inputs on larger windows than asked for, where what was not asked for is poison.
    let tile = window([40, 31], [90, 66]);
    let part = run(node, tile, &|port, grid| {
        if grid.lattice == world().base_grid().lattice || grid.is_empty() {
            return source(port, grid);
        }
        source(port, &clipped(&grid.grow_cells(13))).map(|value| poisoned(value, grid))
    });
    assert!(bits(&part) == bits(&whole.crop(&tile)), "{node:?} from a larger input");
}

/// A field with a huge value wherever a window does not reach.
fn poisoned(value: Value, keep: &Grid) -> Value {
    let Value::Field(field) = value else { return value };
    let grid = *field.grid();
    let inside = |i: usize| {
        let (col, row) = (grid.col + (i % grid.cols) as i64, grid.row + (i / grid.cols) as i64);
        (keep.col..keep.col_end()).contains(&col) && (keep.row..keep.row_end()).contains(&row)
    };
    let data = field.data().iter().enumerate().map(|(i, &v)| if inside(i) { v } else { 1e30 }).collect();
    Value::Field(Field::new(grid, field.quantity(), data))
}

fn same_for_any_threads<N: Node>(node: &N, source: Source<'_>) {
    let at = window([-31, -7], [200, 150]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        // The source is not shared between threads: its values are made first, on the widest window.
        let wide = node_inputs::<N>(node, at, source);
        let given = |p: &str, g: &Grid| {
            if g.lattice == at.lattice { wide.get(p).map(|v| v.crop(g)) } else { source(p, g) }
        };
        pool.install(|| bits(&run(node, at, &given)))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7), "{node:?}");
}

fn node_inputs<N: Node>(node: &N, at: Grid, source: Source<'_>) -> Wires {
    let on = |p: &str| clipped(&Node::footprint(node, p, &at, &world()));
    N::In::PORTS.iter().filter_map(|p| Some((p.name, source(p.name, &on(p.name))?))).collect()
}

#[test]
fn windows_and_threads_do_not_matter() {
    for cells in [0.3, 1.0, 6.0, 7.0, 14.0, 40.0, 100.0, 700.0] {
        tiles_equal_whole(&Blur { radius: Metres(cells * CELL) }, &rough_field);
    }
    for cells in [1.0, 4.6] {
        tiles_equal_whole(&Median { radius: Metres(cells * CELL) }, &rough_field);
    }
    let sharpen = Sharpen { radius: Metres(150.0), amount: Number(2.0), threshold: Number(3.0) };
    tiles_equal_whole(&sharpen, &rough_field);
    tiles_equal_whole(&Warp::default(), &rough_field);
    tiles_equal_whole(&Warp { limit: Metres(50.0), factor: Number(700.0), ..Warp::default() }, &displaced);
    tiles_equal_whole(&turned(), &rough_field);
    tiles_equal_whole(&Transform { scale: Number(2.5), ..turned() }, &rough_field);
    tiles_equal_whole(&Terrace::default(), &rough_field);
    tiles_equal_whole(&Equalize::default(), &rough_field);
    tiles_equal_whole(&Remap::default(), &rough_field);
    tiles_equal_whole(&Curve::default(), &rough_field);
    tiles_equal_whole(&EdgeFalloff::default(), &rough_field);
    tiles_equal_whole(&Combine { mode: combine::Mode::Average, ..Combine::default() }, &rough_field);

    same_for_any_threads(&Blur { radius: Metres(170.0) }, &rough_field);
    same_for_any_threads(&Median { radius: Metres(40.0) }, &rough_field);
    same_for_any_threads(&sharpen, &rough_field);
    same_for_any_threads(&Warp::default(), &rough_field);
    same_for_any_threads(&Equalize::default(), &rough_field);
}

#[test]
fn wide_medians_do_not_depend_on_the_window() {
    tiles_equal_whole(&Median { radius: Metres(70.0 * CELL) }, &rough_field);
    let (a, b) = (window([3, 5], [40, 30]), window([9, 7], [20, 29]));
    let node = Median { radius: Metres(150.0 * CELL) };
    assert!(bits(&run(&node, a, &rough_field).crop(&b)) == bits(&run(&node, b, &rough_field)));
}

fn turned() -> Transform {
    Transform {
        rotate: Degrees(31.0),
        scale: Number(0.7),
        move_east: Metres(333.3),
        center_south: Metres(90.0),
        mirror: Mirror::EastWest,
        ..Transform::default()
    }
}

fn displaced(port: &str, grid: &Grid) -> Option<Value> {
    match port {
        "field" => Some(Value::Field(rough(grid))),
        "dx" => Some(Value::Field(field(grid, |x, y| libm::sin(x / 90.0 + y / 50.0)))),
        "vectors" => Some(Value::Vectors(Vectors::from_fn(*grid, Quantity::Vector, |x, y| {
            [0.1, libm::cos(x / 60.0 - y / 200.0) as f32]
        }))),
        _ => None,
    }
}

/// A line of samples one metre apart; the only row, so that the plane is constant across it.
fn line(from: i64, values: Vec<f32>) -> Field {
    let lattice = Lattice { origin: [0.0, 0.0], span: 1024.0, intervals: 1024 };
    let grid = Grid::between(lattice, [from, 0], [from + values.len() as i64, 1]);
    Field::new(grid, Quantity::Elevation, values)
}

fn blurred(input: &Field, at: Grid, sigma: f64) -> Field {
    let (terrain, cancel) = (world(), Cancel::default());
    blur::gaussian(&Context::bare(at, &terrain, &cancel), input, at, sigma).expect("a blur")
}

/// Weights of a Gaussian at distances 0, 1, …, cut at 9 sigma and summing to 1.
fn gauss(sigma: f64) -> Vec<f64> {
    let n = (9.0 * sigma).ceil() as i64 + 1;
    let raw: Vec<f64> = (0..=n).map(|i| libm::exp(-0.5 * (i * i) as f64 / (sigma * sigma))).collect();
    let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.iter().map(|w| w / sum).collect()
}

fn convolved(values: &[f32], sigma: f64) -> Vec<f64> {
    let (w, last) = (gauss(sigma), values.len() as i64 - 1);
    let at = |i: i64| f64::from(values[i.clamp(0, last) as usize]);
    let one = |i: i64| {
        w[0] * at(i)
            + w.iter()
                .enumerate()
                .skip(1)
                .map(|(k, w)| w * (at(i - k as i64) + at(i + k as i64)))
                .sum::<f64>()
    };
    (0..=last).map(one).collect()
}

/// The largest difference from the direct sum that any input of range 1 can make, at one point: half the sum of the
/// differences of all weights.
fn worst_error(sigma: f64, at: i64) -> f64 {
    let (w, reach) = (gauss(sigma), (6.0 * sigma) as i64 + 70);
    let target = line(at, vec![0.0]);
    let weight = |i: i64| {
        let mut impulse = vec![0.0; 2 * reach as usize + 1];
        impulse[(i + reach) as usize] = 1.0;
        let got = blurred(&line(at - reach, impulse), *target.grid(), sigma).data()[0];
        (f64::from(got) - w.get(i.unsigned_abs() as usize).unwrap_or(&0.0)).abs()
    };
    0.5 * (-reach + 2..reach - 1).map(weight).sum::<f64>()
}

#[test]
fn no_input_blurs_further_from_the_direct_sum_than_a_ten_thousandth() {
    // Two axes: each may make half of it.
    for sigma in [0.2, 0.5, 1.0, 3.0, 6.9, 7.0, 7.7, 9.0, 13.9, 14.0, 17.0, 28.0] {
        let phases = if sigma < 14.0 { 2 } else { 4 };
        let worst = (0..phases).map(|at| worst_error(sigma, 100 + at)).fold(0.0, f64::max);
        assert!(worst < 0.5e-4, "sigma {sigma}: {worst}");
    }
}

#[test]
fn wide_blurs_match_the_direct_sum() {
    let n = 3000usize;
    let noise: Vec<f32> = (0..n).map(|i| hash::unit(5, i as u64) as f32).collect();
    let step: Vec<f32> = (0..n).map(|i| f32::from(i > 1411)).collect();
    let comb: Vec<f32> = (0..n).map(|i| f32::from(i / 64 % 2 == 1)).collect();
    for sigma in [3.0, 7.0, 27.9, 56.0, 100.0, 223.0, 224.0, 400.0] {
        for values in [&noise, &step, &comb] {
            let input = line(-777, values.clone());
            let (got, want) = (blurred(&input, *input.grid(), sigma), convolved(values, sigma));
            let worst =
                got.data().iter().zip(&want).map(|(g, w)| (f64::from(*g) - w).abs()).fold(0.0, f64::max);
            assert!(worst < 0.5e-4, "sigma {sigma}: {worst}");
        }
    }
}

#[test]
fn blur_in_the_plane_matches_the_direct_sum() {
    let at = window([-20, 3], [60, 70]);
    for cells in [1.3, 5.0, 9.0, 20.0] {
        let got = run(&Blur { radius: Metres(cells * CELL) }, at, &rough_field);
        let reach = (6.0 * cells) as i64;
        let (input, w) = (rough(&at.grow_cells(reach)), gauss(cells));
        let wide = *input.grid();
        let down = |c: i64, r: i64| {
            (-reach..=reach)
                .map(|k| w[k.unsigned_abs() as usize] * f64::from(input.at(c, r + k)))
                .sum::<f64>()
        };
        for row in [3, 30, 69] {
            let sums: Vec<f64> = (wide.col..wide.col_end()).map(|c| down(c, row)).collect();
            for col in [-20, 0, 1, 59] {
                let middle = (col - wide.col) as usize;
                let want: f64 = (0..=2 * reach as usize)
                    .map(|k| {
                        w[(k as i64 - reach).unsigned_abs() as usize] * sums[middle + k - reach as usize]
                    })
                    .sum();
                let got = f64::from(got.at(col, row));
                assert!(
                    (got - want).abs() < 1e-4 * 620.0,
                    "{cells} cells at {col}, {row}: {got}, not {want}"
                );
            }
        }
    }
}

#[test]
fn blur_keeps_what_is_flat_or_rises_evenly() {
    let at = window([0, 0], [70, 50]);
    for metres in [0.0, 4.0, 30.0, 90.0, 900.0, 10_000.0] {
        let blur = Blur { radius: Metres(metres) };
        let flat = run(&blur, at, &|_, g| Some(Value::Field(field(g, |_, _| 1234.567))));
        assert!(flat.data().iter().all(|&v| v == 1234.567), "{metres} m");
    }
    let slope = |g: &Grid| field(g, |x, y| 0.25 * x - 0.5 * y);
    let got = run(&Blur { radius: Metres(90.0) }, at, &|_, g| Some(Value::Field(slope(g))));
    let worst = got.data().iter().zip(slope(&at).data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn identities_change_no_bit() {
    let at = window([-5, 2], [60, 50]);
    let input = rough(&at);
    let same = |name: &str, out: Field| assert!(bits(&out) == bits(&input), "{name}");
    same("blur", on(&Blur { radius: Metres(0.0) }, &input));
    same("median", on(&Median { radius: Metres(7.0) }, &input));
    same("sharpen", on(&Sharpen { amount: Number(0.0), ..Sharpen::default() }, &input));
    same("transform", on(&Transform { rotate: Degrees(360.0), ..Transform::default() }, &input));
    same("warp", run(&Warp { limit: Metres(0.0), ..Warp::default() }, at, &rough_field));
    same("warp", run(&Warp { amplitude: Metres(0.0), ..Warp::default() }, at, &rough_field));
    same("terrace", on(&Terrace { sharpness: Ratio(0.0), ..Terrace::default() }, &input));
    same("equalize", on(&Equalize { strength: Ratio(0.0) }, &input));
    same("combine", run(&Combine { strength: Ratio(0.0), ..Combine::default() }, at, &rough_field));
    same("mix", run(&Mix { amount: Ratio(0.0) }, at, &rough_field));
    let points = [[0.0, 0.0], [0.3, 0.3], [1.0, 1.0]].map(|p| p.map(Ratio)).to_vec();
    same("curve", run(&Curve { points, ..Curve::default() }, at, &rough_field));
    let wide = Clamp { low: Number(-1e4), high: Number(1e4), knee: Number(0.0) };
    same("clamp", on(&wide, &input));
    same("clamp", on(&Clamp { knee: Number(500.0), ..wide }, &input));
}

#[test]
fn sharpen_adds_the_detail_beyond_its_threshold() {
    let at = window([0, 0], [50, 40]);
    let smooth = run(&Blur { radius: Metres(40.0) }, at, &rough_field);
    let node = Sharpen { radius: Metres(40.0), amount: Number(1.5), threshold: Number(4.0) };
    let (sharp, input) = (run(&node, at, &rough_field), rough(&at));
    for ((&s, &x), &b) in sharp.data().iter().zip(input.data()).zip(smooth.data()) {
        let d = x - b;
        let want = if d > 4.0 {
            x + 1.5 * (d - 4.0)
        } else if d < -4.0 {
            x + 1.5 * (d + 4.0)
        } else {
            x
        };
        assert!((s - want).abs() < 1e-3, "{s}, not {want}");
    }
}

/// The median by sorting, of samples `stride` apart.
fn sorted_median(input: &Field, [col, row]: [i64; 2], radius: f64, stride: i64) -> f32 {
    let reach = radius as i64;
    let square = radius * radius;
    let offsets = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
    let mut values: Vec<f32> = offsets
        .filter(|(x, y)| (x * x + y * y) as f64 <= square)
        .map(|(x, y)| input.at(col + x * stride, row + y * stride))
        .collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

#[test]
fn median_is_that_of_the_sorted_disk() {
    let at = window([-9, -70], [130, 20]);
    for cells in [1.0, 1.5, 2.0, 5.0, 13.7, 32.0] {
        let got = run(&Median { radius: Metres(cells * CELL) }, at, &rough_field);
        let input = rough(&at.grow_cells(33));
        let step = if cells > 10.0 { 11 } else { 3 };
        for row in (at.row..at.row_end()).step_by(step) {
            for col in (at.col..at.col_end()).step_by(step) {
                assert_eq!(
                    got.at(col, row),
                    sorted_median(&input, [col, row], cells, 1),
                    "{cells} at {col}, {row}"
                );
            }
        }
    }
}

#[test]
fn wide_median_is_exact_on_its_lattice_and_between_it_near() {
    let at = window([10, 10], [60, 40]);
    let got = run(&Median { radius: Metres(50.0 * CELL) }, at, &rough_field);
    let input = rough(&at.grow_cells(60));
    for (col, row) in [(10, 10), (12, 38), (58, 20)] {
        assert_eq!(got.at(col, row), sorted_median(&input, [col, row], 50.0, 1), "{col}, {row}");
        let (near, want) = (got.at(col + 1, row + 1), sorted_median(&input, [col + 1, row + 1], 50.0, 1));
        assert!((near - want).abs() < 1.5, "{near}, not {want}");
    }
    let got = run(&Median { radius: Metres(140.0 * CELL) }, window([18, 6], [19, 7]), &rough_field);
    let input = rough(&apron(&at));
    assert_eq!(got.data()[0], sorted_median(&input, [18, 6], 70.0, 2));
}

#[test]
fn median_takes_a_spike_away_and_leaves_a_cliff() {
    let at = window([0, 0], [40, 30]);
    let input = |g: &Grid| {
        let mut values: Vec<f32> = field(g, |x, _| if x < 500.0 { 0.0 } else { 90.0 }).data().to_vec();
        values[g.cols * (15 - g.row) as usize + (10 - g.col) as usize] = 5000.0;
        Field::new(*g, Quantity::Elevation, values)
    };
    let got = run(&Median { radius: Metres(24.0) }, at, &|_, g| Some(Value::Field(input(g))));
    assert!(
        got.data()
            .iter()
            .zip(field(&at, |x, _| if x < 500.0 { 0.0 } else { 90.0 }).data())
            .all(|(a, b)| a == b)
    );
}

#[test]
fn transform_is_exact_for_whole_cells_quarter_turns_and_mirrors() {
    let at = window([100, 70], [131, 95]);
    let wide = rough(&apron(&at));
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

fn combined(mode: combine::Mode, a: (Quantity, &[f32]), b: (Quantity, &[f32])) -> (Vec<f32>, Quantity) {
    let at = window([0, 0], [a.1.len() as i64, 1]);
    let out = run(&Combine { mode, ..Combine::default() }, at, &|port, g| {
        let (quantity, values) = if port == "a" { a } else { b };
        Some(Value::Field(Field::new(*g, quantity, values.to_vec())))
    });
    (out.data().to_vec(), out.quantity())
}

#[test]
fn combine_computes_what_its_modes_say() {
    use combine::Mode;
    let (height, mask) = (Quantity::Elevation, Quantity::Mask);
    let (a, b): (&[f32], &[f32]) = (&[6.0, -8.0, 0.0, 2.0], &[2.0, 3.0, -4.0, 0.0]);
    let width = Number(4.0);
    let cases: [(Mode, [f32; 4]); 11] = [
        (Mode::Add, [8.0, -5.0, -4.0, 2.0]),
        (Mode::Subtract, [4.0, -11.0, 4.0, 2.0]),
        (Mode::Multiply, [12.0, -24.0, 0.0, 0.0]),
        (Mode::Divide, [3.0, -8.0 / 3.0, 0.0, 2.0 / 1e-6]),
        (Mode::Min, [2.0, -8.0, -4.0, 0.0]),
        (Mode::Max, [6.0, 3.0, 0.0, 2.0]),
        (Mode::SmoothMin { width }, [2.0, -8.0, -4.0, -0.25]),
        (Mode::SmoothMax { width }, [6.0, 3.0, 0.0, 2.25]),
        (Mode::Average, [4.0, -2.5, -2.0, 1.0]),
        (Mode::Difference, [4.0, 11.0, 4.0, 2.0]),
        (Mode::Power, [36.0, -512.0, 1e24, 1.0]),
    ];
    for (mode, want) in cases {
        let (got, _) = combined(mode, (height, a), (height, b));
        let near = |(g, w): (&f32, &f32)| (g - w).abs() <= 1e-5 * w.abs();
        assert!(got.iter().zip(&want).all(near), "{mode:?}: {got:?}, not {want:?}");
    }
    let quantity = |mode, a, b| combined(mode, (a, &[0.7]), (b, &[0.8]));
    assert_eq!(quantity(Mode::Add, mask, mask), (vec![1.0], mask));
    assert_eq!(quantity(Mode::Multiply, mask, height).1, height);
    assert_eq!(quantity(Mode::Multiply, height, mask).1, height);
    assert_eq!(quantity(Mode::Difference, height, height).1, Quantity::Length);
    assert_eq!(quantity(Mode::Divide, height, height).1, Quantity::Number);
}

#[test]
fn mix_and_strength_go_between() {
    let at = window([0, 0], [30, 20]);
    let source = |p: &str, g: &Grid| Some(Value::Field(if p == "a" { rough(g) } else { field(g, |x, _| x) }));
    let (a, b) = (rough(&at), field(&at, |x, _| x));
    assert_eq!(bits(&run(&Mix::default(), at, &source)), bits(&b));
    let half = run(&Mix { amount: Ratio(0.25) }, at, &source);
    let subtract = Combine { mode: combine::Mode::Subtract, strength: Ratio(0.5) };
    let weak = run(&subtract, at, &source);
    for (i, (a, b)) in a.data().iter().zip(b.data()).enumerate() {
        assert!((half.data()[i] - (0.75 * a + 0.25 * b)).abs() < 1e-3);
        assert!((weak.data()[i] - (a - 0.5 * b)).abs() < 1e-3);
    }
}

#[test]
fn switch_takes_one_and_needs_no_other() {
    let at = window([0, 0], [9, 5]);
    let node = Switch { choice: 2 };
    let only_c = |p: &str, g: &Grid| match p {
        "a" => Some(Value::Field(Raster::constant(*g, Quantity::Elevation, 1.0))),
        "c" => Some(Value::Field(rough(g))),
        _ => None,
    };
    assert_eq!(bits(&run(&node, at, &only_c)), bits(&rough(&at)));
    assert!(!Node::uses(&node, "a") && Node::uses(&node, "c"));
    let ports = ["a", "b", "c", "d"];
    let error = run_any(&Switch { choice: 3 }, &ports, at, &only_c).unwrap_err().to_string();
    assert_eq!(error, "input `d` is not connected, and `choice` is 3");
}

/// The ends of what a parameter allows.
fn extremes(shape: &Shape) -> Vec<Json> {
    match shape {
        Shape::Number { min, max, integer: true } => vec![json!(*min as u64), json!(*max as u64)],
        Shape::Number { min, max, .. } => vec![json!(min), json!(max)],
        Shape::Flag => vec![json!(false), json!(true)],
        Shape::Choice(modes) => modes
            .iter()
            .flat_map(|m| {
                if m.fields.is_empty() {
                    return vec![json!(m.name)];
                }
                let pick = |last: bool| {
                    let one = |p: &Param| {
                        let all = extremes(&p.shape);
                        (p.name.clone(), all[if last { all.len() - 1 } else { 0 }].clone())
                    };
                    json!({ &m.name: m.fields.iter().map(one).collect::<Map<_, _>>() })
                };
                vec![pick(false), pick(true)]
            })
            .collect(),
        _ => Vec::new(),
    }
}

#[test]
fn results_are_finite_for_every_allowed_parameter_and_hostile_inputs() {
    let at = window([-3, 20], [14, 33]);
    type Pattern = fn(i64, i64) -> f32;
    let inputs: [(&str, Pattern); 4] = [
        ("huge", |c, r| if (c + r) % 2 == 0 { 1e9 } else { -1e9 }),
        ("tiny", |c, _| if c % 3 == 0 { 1e-40 } else { -1e-40 }),
        ("flat", |_, _| 1e9),
        ("steps", |c, r| (c * r % 7) as f32),
    ];
    let registry = Registry::standard();
    let mut kinds = 0;
    for kind in registry.iter().filter(|k| matches!(k.family, "blend" | "filter")) {
        kinds += 1;
        let ports: Vec<_> = kind.inputs().map(|p| p.name).filter(|n| *n != "mask").collect();
        let mut sets = vec![Map::new()];
        let all = kind.params().iter().map(|p| (p.name.clone(), extremes(&p.shape)));
        for (name, values) in all.clone() {
            sets.extend(values.iter().map(|v| Map::from_iter([(name.clone(), v.clone())])));
        }
        for last in [false, true] {
            let end = |v: &[Json]| if last { v.last().cloned() } else { v.first().cloned() };
            sets.push(all.clone().filter_map(|(n, v)| Some((n, end(&v)?))).collect());
        }
        for set in sets {
            let node = match kind.parse(&set) {
                Ok(node) => node,
                Err(e) if kind.id == "clamp" && e.to_string().contains("at most") => continue,
                Err(e) => panic!("{kind:?} {set:?}: {e}"),
            };
            for (name, f) in inputs {
                let source = |p: &str, g: &Grid| {
                    let make = |c, r| f(g.col + c as i64, g.row + r as i64);
                    let data = (0..g.len()).map(|i| make(i % g.cols, i / g.cols)).collect();
                    (p != "vectors").then(|| Value::Field(Field::new(*g, Quantity::Elevation, data)))
                };
                run_any(node.as_ref(), &ports, at, &source)
                    .unwrap_or_else(|e| panic!("{kind:?} {name} {set:?}: {e}"));
            }
        }
    }
    assert!(kinds >= 15, "{kinds} kinds");
}

#[test]
fn a_cancelled_filter_stops() {
    let (terrain, cancel) = (world(), Cancel::default());
    cancel.cancel();
    let at = terrain.grid(257).unwrap();
    let cx = Context::bare(at, &terrain, &cancel);
    for metres in [20.0, 900.0] {
        assert_eq!(blur::gaussian(&cx, &rough(&at), at, metres).unwrap_err(), Error::Cancelled);
    }
    let wires = Wires::from_iter([("field", Value::Field(rough(&at)))]);
    assert_eq!(AnyNode::run(&Median::default(), &cx, wires).unwrap_err(), Error::Cancelled);
}
