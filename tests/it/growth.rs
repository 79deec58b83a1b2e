//! Growth: ten times the input takes at most fifteen times the time, for every reader and every kind that takes lists.
//!
//! Time is that of the processor in one thread, least of five, so that a busy machine changes nothing; inputs are large
//! enough that fixed costs do not hide a square.

use cpu_time::ThreadTime;
use orograph::files::vectors::{geojson, svg};
use orograph::files::{Format, Limits, WriteJob, Writing, encode, read_height};
use orograph::kit::curves::rasterise;
use orograph::node::{Cancel, Context, Kind, Load};
use orograph::params::page::sections;
use orograph::params::{Param, Shape};
use orograph::ports::Wires;
use orograph::value::{CurveSpec, Curves, Field, Grid, Object as _, Quantity, Terrain, Value, WireType};
use serde_json::{Map, Value as Json, json};

use crate::rig::graph::{engine, fed};
use crate::rig::shipped;
use crate::vectors::{SQUARE, place, plain};

/// The least of five times that work takes, in seconds, on a pool of one thread.
fn least<T: Send>(work: impl Fn() -> T + Sync) -> f64 {
    let pool = rayon_pool();
    let once = || {
        let before = ThreadTime::now();
        drop(work());
        before.elapsed().as_secs_f64()
    };
    pool.install(|| (0..5).map(|_| once()).fold(f64::INFINITY, f64::min))
}

fn rayon_pool() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap()
}

/// Seconds that are forgiven the larger input, which leaves the caches of the processor and takes its memory from the
/// system. A square shows all the same: ten times its input takes a hundred times as long.
const CACHES: f64 = 2e-3;

/// What grows too fast; `work` is given how many times as large its input is. The best of five tries counts: work beside
/// the tests takes the caches of the processor from the larger input first.
fn fault<T: Send>(name: &str, work: impl Fn(usize) -> T + Sync) -> Option<String> {
    let mut slow = None;
    for _ in 0..5 {
        let (one, ten) = (least(|| work(1)), least(|| work(10)));
        let (short, long) = (one * 1e3, ten * 1e3);
        let line = format!("{name}: {short:.2} ms, ten times as much {long:.2} ms, {:.1} times", ten / one);
        println!("{line}");
        if ten <= 15.0 * one + CACHES {
            return None;
        }
        slow = Some(line);
    }
    slow
}

fn quadratic(n: usize) -> usize {
    let items: Vec<usize> = (0..n * 3000).collect();
    items.iter().filter(|i| items.iter().take_while(|k| k < i).count() == usize::MAX).count()
}

#[test]
fn work_that_grows_with_the_square_is_found() {
    assert!(fault("a square", quadratic).is_some());
    assert_eq!(fault("a line", |n| (0..n * 100_000).map(|i: usize| i ^ 5).fold(0, |a, b| a ^ b)), None);
}

/// Makes a text of so many parts.
type Text = Box<dyn Fn(usize) -> String + Sync>;

/// Files of a shape and the size in which a reader takes a few milliseconds.
fn texts() -> Vec<(&'static str, Text)> {
    fn picture(body: &str) -> String {
        format!("<svg viewBox='0 0 100 100'>{body}</svg>")
    }
    fn many(n: usize, one: impl Fn(usize) -> String) -> String {
        (0..n).map(one).collect()
    }
    fn features(n: usize, one: &str) -> String {
        format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, vec![one; n].join(","))
    }
    vec![
        (
            "svg, paths on one line",
            Box::new(|n| picture(&many(n * 500, |k| format!("<path id='p{k}' d='M{k} 1 L2 3'/>")))),
        ),
        (
            "svg, faults",
            Box::new(|n| {
                picture(&many(n * 500, |_| "<path d='M0 0 L1 x'/><rect r='y' width='z'/>\n".into()))
            }),
        ),
        ("svg, one path", Box::new(|n| picture(&format!("<path d='M0 0{}'/>", " 1 1 0 2".repeat(n * 700))))),
        ("svg, subpaths", Box::new(|n| picture(&format!("<path d='{}'/>", "M0 0h5".repeat(n * 500))))),
        (
            "svg, points",
            Box::new(|n| picture(&format!("<polyline points='{}'/>", "0,0 1,5 ".repeat(n * 700)))),
        ),
        (
            "svg, shapes",
            Box::new(|n| picture(&"<circle r='5'/><rect width='4' height='9' rx='1'/>".repeat(n * 200))),
        ),
        (
            "svg, nested",
            Box::new(|n| {
                picture(&format!(
                    "{}{}",
                    "<g transform='scale(1)'>".repeat(n * 1000),
                    "</g>".repeat(n * 1000)
                ))
            }),
        ),
        (
            "svg, uses",
            Box::new(|n| {
                picture(&many(n * 300, |k| format!("<path id='p{k}' d='M0 0h1'/><use href='#p{k}'/>")))
            }),
        ),
        (
            "svg, attributes",
            Box::new(|n| picture(&format!("<g {}/>", many(n * 2000, |k| format!("a{k}='x' "))))),
        ),
        (
            "svg, namespaces",
            Box::new(|n| {
                picture(&many(n * 500, |k| format!("<g xmlns:n{k}='u'>")))
                    .replace("</svg>", &("</g>".repeat(n * 500) + "</svg>"))
            }),
        ),
        (
            "svg, entities",
            Box::new(|n| {
                format!(
                    "<!DOCTYPE svg [{}]>{}",
                    many(n * 500, |k| format!("<!ENTITY e{k} 'x'>")),
                    picture(&many(n * 500, |k| format!("<g id='&e{k};'/>")))
                )
            }),
        ),
        ("svg, styles", Box::new(|n| picture(&format!("<g style='{}'/>", "fill:red;".repeat(n * 5000))))),
        (
            "svg, selectors and declarations",
            Box::new(|n| {
                let selectors = many(n * 1000, |k| format!(".a{k},"));
                picture(&format!("<style>{selectors}b{{{}}}</style>", "display:a;".repeat(n * 300)))
            }),
        ),
        (
            "svg, parts of selectors",
            Box::new(|n| {
                let elements = "<g class='a'/>".repeat(n * 300);
                picture(&format!("<style>{}{{display:a}}</style>{elements}", ".a".repeat(n * 1000)))
            }),
        ),
        (
            "svg, rules and elements",
            Box::new(|n| {
                let rules = many(n * 300, |k| format!(".a{{display:a}}.b{k}.a{{display:a}}"));
                picture(&format!("<style>{rules}</style>{}", "<g class='a'/>".repeat(n * 300)))
            }),
        ),
        ("svg, style sheets", Box::new(|n| picture(&"<style>a{display:none</style>".repeat(n * 500)))),
        (
            "geojson, systems",
            Box::new(|n| {
                let crs =
                    |k: usize| format!(r#"{{"crs":{{"properties":{{"name":"EPSG:{}"}}}}}}"#, 32_601 + k % 60);
                format!(
                    r#"{{"type":"FeatureCollection","features":[{}null]}}"#,
                    many(n * 500, |k| crs(k) + ",")
                )
            }),
        ),
        (
            "geojson, features",
            Box::new(|n| {
                features(
                    n * 500,
                    r#"{"properties":{"h":1},"geometry":{"type":"LineString","coordinates":[[0,0],[9,-9]]}}"#,
                )
            }),
        ),
        (
            "geojson, one line",
            Box::new(|n| {
                format!(
                    r#"{{"type":"LineString","coordinates":[{}[500,-500]]}}"#,
                    many(n * 800, |k| format!("[{},{}],", k % 900, k % 7))
                )
            }),
        ),
        (
            "geojson, heights",
            Box::new(|n| {
                format!(
                    r#"{{"type":"LineString","coordinates":[{}[500,-500,1]]}}"#,
                    many(n * 300, |k| format!("[{k},{},{k}],", k % 7))
                )
            }),
        ),
        (
            "geojson, lines of one feature",
            Box::new(|n| {
                format!(
                    r#"{{"type":"MultiLineString","coordinates":[{}]}}"#,
                    vec!["[[0,0],[9,-9]]"; n * 500].join(",")
                )
            }),
        ),
        (
            "geojson, collections",
            Box::new(|n| {
                features(
                    n * 300,
                    r#"{"geometry":{"type":"GeometryCollection","geometries":[{"type":"Point"},{"type":"LineString","coordinates":[[0,0],[9,-9]]}]}}"#,
                )
            }),
        ),
        (
            "geojson, faults",
            Box::new(|n| {
                features(n * 1000, r#"{"geometry":{"type":"LineString","coordinates":[[0],[9,"x"]]}}"#)
            }),
        ),
        (
            "geojson, properties",
            Box::new(|n| {
                features(
                    n * 10,
                    &format!(r#"{{"properties":{{{}"h":1}}}}"#, many(100, |k| format!("\"p{k}\":[1,[2]],"))),
                )
            }),
        ),
    ]
}

#[test]
fn every_reader_of_lines_is_linear() {
    let mut faults = Vec::new();
    for (name, text) in texts() {
        let files = [text(1), text(10)];
        faults.extend(fault(name, |n| {
            let bytes = files[usize::from(n > 1)].as_bytes();
            let read = if name.starts_with("svg") {
                svg::read(bytes, SQUARE, svg::Fit::Inside, &plain(), &|_| true)
            } else {
                geojson::read(bytes, &place(), &plain(), &|_| true)
            };
            read.unwrap_or_else(|e| panic!("{name}: {e}"))
        }));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_reader_of_heights_is_linear() {
    let terrain = Terrain { width: 4096.0, depth: 4096.0, ..Terrain::default() };
    // Ten times as many samples: 129², and 408².
    let field = |n: usize| {
        let cols = if n == 1 { 129 } else { 408 };
        let lattice = orograph::value::Lattice { origin: [0.0; 2], span: 4096.0, intervals: cols - 1 };
        let grid = Grid { lattice, col: 0, row: 0, cols: cols as usize, rows: cols as usize };
        Value::Field(Field::from_fn(grid, Quantity::Elevation, |x, y| (x * 0.3 + y * 0.7) as f32 % 300.0))
    };
    let fields = [field(1), field(10)];
    let mut faults = Vec::new();
    for format in Format::of_samples() {
        let written = fields.each_ref().map(|value| {
            let grid = *value.grid().unwrap();
            let writing = Writing { range: Some([-500.0, 500.0]), ..format.into() };
            let job = WriteJob::new(value, writing, &terrain, grid);
            let mut out = std::io::Cursor::new(Vec::new());
            let sidecar = encode(&job, &mut out).unwrap().sidecar.map(|j| j.to_string().into_bytes());
            (out.into_inner(), sidecar)
        });
        let name = format!("a.{}", format.extension());
        faults.extend(fault(&format!("{format}"), |n| {
            let (bytes, sidecar) = &written[usize::from(n > 1)];
            read_height(&name, bytes, sidecar.as_deref(), &Limits::default()).unwrap()
        }));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// A list of so many items, each allowed where its neighbours are: numbers that come first rise along the list.
fn long(item: &Shape, example: &Json, n: usize) -> Json {
    let place = |k: usize| (k + 1) as f64 / (n + 1) as f64;
    let one = |k: usize| match item {
        Shape::List { item, .. } => {
            let (low, high) = match **item {
                Shape::Number { min, max, .. } => (min.max(0.0), max.min(8000.0)),
                _ => (0.0, 1.0),
            };
            let mut numbers = example[0].as_array().unwrap().clone();
            numbers[0] = json!(low + (high - low) * place(k));
            Json::from(numbers)
        }
        _ => example[k % example.as_array().unwrap().len()].clone(),
    };
    (0..n).map(one).collect()
}

/// The lists that a kind takes: the path, the shape of an item, and the most of them.
fn lists(kind: &Kind) -> Vec<(String, Shape, usize)> {
    fn of(prefix: &str, params: &[Param], all: &mut Vec<(String, Shape, usize)>) {
        for p in params {
            match &p.shape {
                Shape::List { item, min, max } if min < max => {
                    all.push((format!("{prefix}{}", p.name), (**item).clone(), *max));
                }
                Shape::Choice(modes) => {
                    modes.iter().for_each(|m| of(&format!("{prefix}{}.{}.", p.name, m.name), &m.fields, all));
                }
                _ => (),
            }
        }
    }
    let mut all = Vec::new();
    of("", kind.params(), &mut all);
    all
}

/// A node with its inputs on a small grid, ready to be run.
fn run(kind: &'static Kind, set: &Map<String, Json>, size: u32) -> impl Fn() -> Wires + Sync + use<> {
    let graph = fed(kind, set, None);
    let id = graph.find("node").unwrap();
    let node = graph.node(id).parse().unwrap_or_else(|e| panic!("{}: {e}", kind.id));
    let terrain = graph.terrain().clone();
    let grid = terrain.grid(size).unwrap();
    let (e, cancel) = (engine(1), Cancel::default());
    let inputs = |grid: Grid| -> Wires {
        let ports = kind.inputs.iter().filter(|p| kind.hands_over(&p.name) && node.uses(&p.name));
        let value = |name: &str| {
            let source = graph.source(id, name)?;
            let want = orograph::engine::Want { node: source.node, port: source.port, grid };
            let unobserved = &orograph::engine::Unobserved;
            Some(e.evaluate(&graph, &[want], unobserved, &cancel).unwrap().values.remove(0).unwrap())
        };
        ports.filter_map(|p| Some((p.name.clone(), value(&p.name)?))).collect()
    };
    let cx = Context { reads: kind.reads, ..Context::bare(grid, &terrain, &cancel) };
    let base = Context { grid: terrain.base_grid(), ..cx };
    let summary = node.needs_summary().then(|| node.summarize(&base, inputs(terrain.base_grid())).unwrap());
    let wires = inputs(grid);
    move || {
        let cancel = Cancel::default();
        let cx = Context { reads: kind.reads, ..Context::bare(grid, &terrain, &cancel) };
        node.run(&Context { whole: summary.as_ref(), ..cx }, wires.clone()).unwrap()
    }
}

#[test]
fn every_kind_that_takes_lists_is_linear_and_says_so() {
    let (mut faults, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        for (path, item, most) in lists(kind) {
            let section = sections(kind.params()).into_iter().find(|s| s.name == path).unwrap();
            let most = most.min(2000);
            let set = |n: usize| -> Map<String, Json> {
                let list = long(&item, &section.example, most * n / 10);
                let set = path.rsplit('.').fold(list, |value, name| json!({ name: value }));
                set.as_object().unwrap().clone()
            };
            let nodes = [run(kind, &set(1), 33), run(kind, &set(10), 33)];
            faults.extend(fault(&format!("{}.{path}", kind.id), |n| nodes[usize::from(n > 1)]()));
            tried += 1;
        }
    }
    assert!(tried >= 8, "{tried}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Curves across the square, so many that their work is more than the grid's.
fn curves(n: usize) -> Curves {
    let spec = |k: usize| {
        let y = 1000.0 * (k as f64 + 0.5) / n as f64;
        CurveSpec {
            through: vec![0.0, y, 300.0, y + 9.0, 600.0, y - 9.0, 1000.0, y],
            height: vec![0.0, k as f64, 0.0, 1.0, 50.0, 0.0],
            slope: vec![0.0, 80.0, 80.0, -20.0, 30.0],
            ..CurveSpec::default()
        }
    };
    Curves::from_specs(&(0..n).map(spec).collect::<Vec<_>>()).unwrap()
}

#[test]
fn every_kind_that_reads_curves_is_linear_and_its_cost_follows_them() {
    let sets = [curves(100), curves(1000)];
    let terrain = Terrain { width: 1000.0, depth: 1000.0, base: 129, ..Terrain::default() };
    let (grid, cancel) = (terrain.base_grid(), Cancel::default());
    let (mut faults, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        let ports: Vec<_> = kind
            .inputs
            .iter()
            .filter(|p| p.wire == WireType::Object(Curves::TYPE))
            .map(|p| p.name.clone())
            .collect();
        if ports.is_empty() {
            continue;
        }
        tried += 1;
        let node = kind.parse(&Map::new()).unwrap();
        let wires = |n: usize| -> Wires {
            ports.iter().map(|port| (port.clone(), Value::from(sets[usize::from(n > 1)].clone()))).collect()
        };
        let cx = Context { reads: kind.reads, ..Context::bare(grid, &terrain, &cancel) };
        // The curves of this test stand in one place: ten times as many are ten times as many near every mouth.
        if kind.id != "rivers_from_curves" {
            faults.extend(fault(&kind.id, |n| node.run(&cx, wires(n)).unwrap()));
        }
        let cost = |n: usize| {
            let known = |_: &str| (n > 0).then(|| Value::from(sets[usize::from(n > 1)].clone()));
            node.cost(&Load { known: &known, ..Load::on(grid, &terrain) }).seconds
        };
        let (none, one, ten) = (node.cost(&Load::on(grid, &terrain)).seconds, cost(1), cost(10));
        if ten - none < 5.0 * (one - none) || one <= none {
            faults.push(format!(
                "{}: says {none} s, {one} s for curves, {ten} s for ten times as many",
                kind.id
            ));
        }
    }
    assert!(tried >= 3, "{tried}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn strokes_cost_what_they_are() {
    let kind = shipped().into_iter().find(|k| k.id == "paint_mask").unwrap();
    let grid = Terrain { width: 1000.0, depth: 1000.0, ..Terrain::default() }.grid(129).unwrap();
    let cost = |n: usize, points: usize| {
        let path: Vec<f64> =
            (0..points).flat_map(|k| [(k * 7 % 1000) as f64, (k * 13 % 1000) as f64]).collect();
        let stroke = json!({ "path": path, "radius": 30 });
        let set = json!({ "strokes": vec![stroke; n] });
        kind.parse(set.as_object().unwrap()).unwrap().cost(&Load::on(grid, &Terrain::default())).seconds
    };
    let none = cost(0, 0);
    assert!(cost(100, 10) - none >= 9.0 * (cost(10, 10) - none), "more strokes");
    assert!(cost(10, 1000) - none >= 5.0 * (cost(10, 100) - none), "longer strokes");
}

/// How far the estimate for curves is off, in processor time of this build: a decimal power at most.
#[test]
fn rasterising_takes_about_what_it_says() {
    let terrain = Terrain { width: 1000.0, depth: 1000.0, ..Terrain::default() };
    for (n, size) in [(20, 257), (200, 129), (1000, 65), (1000, 257)] {
        let (curves, grid) = (curves(n), terrain.grid(size).unwrap());
        let took = least(|| rasterise(&curves, &grid, &Default::default(), &|| false).unwrap());
        let said = orograph::kit::curves::raster::seconds(&curves, &grid);
        println!("{n} curves on {size}: said {:.2} ms, took {:.2} ms", said * 1e3, took * 1e3);
        assert!((0.1..10.0).contains(&(said / took)), "{n} on {size}: said {said} s, took {took} s");
    }
}
