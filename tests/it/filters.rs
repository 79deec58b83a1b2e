//! Tests of: filters and blends.

mod blend;
mod levels;
mod place;
mod smooth;

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
use orograph::work::Work;
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
fn run_any(node: &dyn AnyNode, ports: &[&str], at: Grid, source: Source<'_>) -> Result<Value, Error> {
    let (terrain, cancel) = (world(), Cancel::default());
    let wires = |grid_of: &dyn Fn(&str) -> Grid| {
        let value = |p: &&str| Some((*p).to_owned()).zip(source(p, &grid_of(p)));
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
    let ports: Vec<_> = N::In::PORTS.iter().map(|p| p.name.as_str()).collect();
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
    N::In::PORTS.iter().filter_map(|p| Some((p.name.clone(), source(&p.name, &on(&p.name))?))).collect()
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
    for kind in registry.iter().filter(|k| matches!(k.family.as_str(), "blend" | "filter")) {
        kinds += 1;
        let ports: Vec<_> = kind.inputs.iter().map(|p| p.name.as_str()).filter(|n| *n != "mask").collect();
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
        assert_eq!(blur::gaussian(&cx.work, &rough(&at), at, metres).unwrap_err(), Error::Cancelled);
    }
    let wires = Wires::from_iter([("field", Value::Field(rough(&at)))]);
    assert_eq!(AnyNode::run(&Median::default(), &cx, wires).unwrap_err(), Error::Cancelled);
}
