//! What kinds say they take beside inputs and outputs, held against what an allocator saw.
//!
//! Bytes are counted by thread, and a node is run on a pool of one: other tests do not disturb the count.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use orograph::engine::{Unobserved, Want};
use orograph::files::vectors::svg;
use orograph::files::{
    Closing, Companion, Format, Input, Limits, Reading, Relief, Request, WriteJob, Writing, encode,
};
use orograph::graph::Graph;
use orograph::kit::curves::raster::BESIDE;
use orograph::kit::curves::rasterise;
use orograph::name::Name;
use orograph::node::{Cancel, Context, Kind, Load, Reach, SourceFile};
use orograph::params::Shape;
use orograph::ports::Wires;
use orograph::value::{CurveSpec, Curves, Field, Grid, Object as _, Quantity, Terrain, Value};
use orograph::widget::Widget;
use orograph::work::Work;
use serde_json::{Map, Value as Json, json};

use crate::kinds::registry;
use crate::rig::graph::{engine, fed};
use crate::rig::sets::extremes;
use crate::rig::shipped;
use crate::vectors::{SQUARE, plain};

/// The system's allocator with an account of each thread.
struct Counting;

thread_local! {
    /// Bytes this thread holds more than it gave back, and the most of it.
    static HELD: Cell<(i64, i64)> = const { Cell::new((0, 0)) };
}

fn count(bytes: i64) {
    // A thread that ends may free after its account is gone.
    let _ = HELD.try_with(|held| {
        let now = held.get().0 + bytes;
        held.set((now, held.get().1.max(now)));
    });
}

#[allow(unsafe_code, reason = "an allocator cannot be written without")]
// SAFETY: every call goes to the system's allocator with the arguments as they came; counting allocates nothing, since
// the account is a constant-initialised cell.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(memory, layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes this thread holds more than it gave back; the most of it counts from here.
pub(crate) fn held() -> i64 {
    HELD.with(|held| {
        let now = held.get().0;
        held.set((now, now));
        now
    })
}

/// The most bytes this thread has held since.
pub(crate) fn most_held() -> i64 {
    HELD.with(|held| held.get().1)
}

/// Runs work on a pool of one thread; the most bytes it held at once beyond what it held before, and its result.
fn peak<T: Send>(work: impl FnOnce() -> T + Send) -> (u64, T) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let before = held();
        let result = work();
        ((most_held() - before) as u64, result)
    })
}

/// What a node said it takes on a grid beside inputs and outputs, and what it took. Inputs may come on windows that are
/// some cells wider than it asked for; then the engine counts a copy of each.
fn said_and_taken(kind: &Kind, set: &Map<String, Json>, size: u32, wider: i64) -> Option<(u64, u64)> {
    let mut graph = fed(kind, set, None);
    graph.assign("terrain.base", "257").unwrap();
    let id = graph.find("node").unwrap();
    let node = graph.node(id).parse().ok()?;
    if !node.files().is_empty() {
        return None;
    }
    let (terrain, e, cancel) = (graph.terrain(), engine(1), Cancel::default());
    let grid = if node.reach() == Reach::Global { terrain.base_grid() } else { terrain.grid(size).unwrap() };
    let evaluate = |want: Want| e.evaluate(&graph, &[want], &Unobserved, &cancel).unwrap().values.remove(0);
    let inputs = |window: &dyn Fn(&str) -> Grid| -> Wires {
        let ports = kind.inputs.iter().filter(|p| kind.hands_over(&p.name) && node.uses(&p.name));
        let value = |name: &str| {
            let source = graph.source(id, name)?;
            Some(evaluate(Want { node: source.node, port: source.port, grid: window(name) }).unwrap())
        };
        ports.filter_map(|p| Some((p.name.clone(), value(&p.name)?))).collect()
    };
    let mut cx = Context { reads: kind.reads, ..Context::bare(grid, terrain, &cancel) };
    let base = Context { grid: terrain.base_grid(), ..cx };
    let summary =
        node.needs_summary().then(|| node.summarize(&base, inputs(&|_| terrain.base_grid())).unwrap());
    cx.whole = summary.as_ref();
    let asked = |port: &str| within_apron(&node.footprint(port, &grid, terrain), terrain);
    let wires = inputs(&|port| within_apron(&asked(port).grow_cells(wider), terrain));
    let cut = |(port, value): (&Name, &Value)| match value.grid() {
        Some(given) if *given != asked(port) => value.wire_type().sample_bytes() * asked(port).len() as u64,
        _ => 0,
    };
    let copies: u64 = wires.iter().map(cut).sum();
    let mut views = Vec::new();
    for port in kind.inputs.iter() {
        let windows = node.views(&port.name, &grid, terrain).into_iter();
        for window in windows.map(|w| within_apron(&w, terrain)) {
            views.extend(inputs(&|_| window).take(&port.name).map(|value| (port.name.clone(), value)));
        }
    }
    cx.views = &views;
    let (took, outputs) = peak(|| node.run(&cx, wires));
    let said = node.cost(&Load::on(grid, terrain)).bytes;
    Some((said + copies, took.saturating_sub(outputs.ok()?.bytes())))
}

/// The part of a window that the engine would hand over.
fn within_apron(window: &Grid, terrain: &Terrain) -> Grid {
    let apron = terrain.apron(window.lattice);
    let start = [window.col.max(apron.col), window.row.max(apron.row)];
    let end = [window.col_end().min(apron.col_end()), window.row_end().min(apron.row_end())];
    Grid::between(window.lattice, start, end)
}

/// Small things that nobody counts: names, rows of pointers, a line of work.
pub(crate) const SMALL: u64 = 48 << 10;

fn fault(kind: &Kind, set: &Map<String, Json>, wider: i64) -> Option<String> {
    let (said, took) = said_and_taken(kind, set, 257, wider)?;
    let samples = Json::from(set.clone());
    (took > said + SMALL)
        .then(|| format!("{} {samples}, {wider} cells wider: says {said} bytes, took {took}", kind.id))
}

/// The parameters that choose between modes, each mode alone and together with those of the others.
fn modes(kind: &Kind) -> Vec<Map<String, Json>> {
    let choices = kind.params().iter().filter(|p| matches!(p.shape, Shape::Choice(_)));
    let choices: Vec<_> = choices.map(|p| (p.name.clone(), extremes(&p.shape, &p.default))).collect();
    let mut all = vec![Map::new()];
    for (name, values) in choices {
        let with = |set: &Map<String, Json>, value: &Json| {
            let mut set = set.clone();
            set.insert(name.clone(), value.clone());
            set
        };
        all = all.iter().flat_map(|set| values.iter().map(move |v| with(set, v))).collect();
    }
    all
}

#[test]
fn no_kind_takes_more_memory_than_it_says() {
    let (mut faults, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        for wider in [0, 7] {
            faults.extend(modes(kind).iter().filter_map(|set| fault(kind, set, wider)));
        }
        for p in kind.params().iter().filter(|p| p.widget != Some(Widget::File)) {
            for value in extremes(&p.shape, &p.default) {
                let set: Map<String, Json> = [(p.name.clone(), value)].into_iter().collect();
                faults.extend(fault(kind, &set, 0));
                tried += 1;
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(tried > 100, "{tried}");
}

#[test]
fn a_kind_that_takes_more_than_it_says_is_found() {
    let registry = registry();
    let hog = registry.find("hog").unwrap();
    let share = |share: f64| json!({ "share": share }).as_object().unwrap().clone();
    assert_eq!(fault(hog, &share(1.0), 0), None);
    assert!(fault(hog, &share(0.5), 0).is_some());
}

/// Half of it void, so that the filling is counted as well.
fn coast(size: usize) -> Field {
    let grid = Terrain { width: 4096.0, depth: 4096.0, ..Terrain::default() }.grid(size as u32).unwrap();
    Field::from_fn(grid, Quantity::Elevation, |x, y| crate::kinds::waves(x, y, 900.0, 3) * 100.0)
}

#[test]
fn no_height_file_takes_more_memory_than_its_header_tells() {
    let size = 513;
    let field = coast(size);
    let terrain = Terrain { width: 4096.0, depth: 4096.0, ..Terrain::default() };
    let value = Value::Field(field.clone());
    let job = |format: Format| {
        let writing = Writing { range: Some([-500.0, 500.0]), ..format.into() };
        WriteJob::new(&value, writing, &terrain, *field.grid())
    };
    for format in Format::of_samples() {
        let mut out = std::io::Cursor::new(Vec::new());
        let written = encode(&job(format), &mut out).unwrap();
        let (bytes, name) = (out.into_inner(), format!("a.{}", format.extension()));
        let sidecar = written.sidecar.map(|j| j.to_string().into_bytes());
        let beside: Vec<_> = sidecar.iter().map(|bytes| Companion { name: "a.json", bytes }).collect();
        let (reading, limits, work) = (Reading::default(), Limits::default(), Work::default());
        let input = Input {
            name: &name,
            bytes: &bytes,
            companions: &beside,
            reading: &reading,
            limits: &limits,
            work,
        };
        let claim = input.claim().unwrap();
        let [cols, rows] = [claim.cols, claim.rows];
        assert_eq!([cols, rows], [size as u64; 2], "{format}");
        for cubic in [false, true] {
            let (reading, limits, work) = (Reading::default(), Limits::default(), Work::default());
            let request = Request {
                name: &name,
                companions: &beside,
                reading: &reading,
                closing: Closing::Smooth,
                cubic,
            };
            let (took, relief) = peak(|| Relief::new(&request, &bytes, &limits, work));
            relief.unwrap();
            let said = Relief::bytes(cols, rows, cubic).max(claim.bytes);
            assert!(took <= said + SMALL, "{format}, cubic {cubic}: says {said}, took {took}");
            println!("{format}, cubic {cubic}: {:.1} bytes a sample", took as f64 / (cols * rows) as f64);
        }
    }
}

/// Texts of some megabyte that make as much as can be of each byte.
fn pictures() -> Vec<(&'static str, String)> {
    let n = 200_000;
    let many = |n: usize, one: &dyn Fn(usize) -> String| -> String { (0..n).map(one).collect() };
    let with = |css: &str, body: &str| format!("<svg viewBox='0 0 1 1'><style>{css}</style>{body}</svg>");
    let moves = "*{transform:scale(1);transform-origin:1px 1px;transform-box:view-box}";
    vec![
        ("selectors", with(&(many(n, &|k| format!(".{k:x},")) + "b{display:a}"), "")),
        ("selectors that are read", with(&(many(60_000, &|k| format!(".{k:x},")) + "b{display:a}"), "")),
        ("rules", with(&many(60_000, &|k| format!(".{k:x}{{display:a}}")), "")),
        ("rules of one", with(&"a{display:a}".repeat(n / 2), "")),
        ("parts", with(&(".a".repeat(2 * n) + "{display:a}"), "")),
        ("comments", with(&"/**/a".repeat(n), "")),
        ("sheets", with("", &"<style>a</style>".repeat(n / 2))),
        ("elements", with("", &"<g/>".repeat(n))),
        ("elements of one rule", with(moves, &"<g/>".repeat(n))),
        ("elements of their own", with("", &many(n / 2, &|k| format!("<g style='transform:{k:x}'/>")))),
        ("classes", with("a.b{display:a}", &format!("<g class='{}'/>", many(n, &|k| format!("{k:x} "))))),
    ]
}

#[test]
fn no_picture_takes_more_memory_than_its_length_tells() {
    let kind = shipped().into_iter().find(|kind| kind.id == "import_curves").unwrap();
    let node = kind.parse(json!({ "file": "a.svg" }).as_object().unwrap()).unwrap();
    for (name, text) in pictures() {
        let source = SourceFile::new("a.svg".into(), text.clone().into_bytes());
        let said = node.reading(&[std::sync::Arc::new(source)]).unwrap().bytes;
        let (took, read) = peak(|| svg::read(text.as_bytes(), SQUARE, svg::Fit::Inside, &plain(), &|_| true));
        read.unwrap_or_else(|e| panic!("{name}: {e}"));
        println!("{name}: {} bytes, says {said}, took {took}", text.len());
        assert!(took <= said, "{name}: says {said}, took {took}");
    }
}

#[test]
fn an_import_counts_in_the_plan_with_what_it_decodes() {
    let graph = |interpolation: &str| {
        let file = json!({
            "orograph": 1,
            "nodes": { "land": { "kind": "import_height", "set": {
                "file": "small.asc", "interpolation": interpolation } } },
            "outputs": { "height": { "from": "land.height" } },
        });
        Graph::from_bytes(file.to_string().as_bytes(), &registry()).unwrap()
    };
    let planned = |interpolation: &str| {
        let g = graph(interpolation);
        let want =
            Want { node: g.find("land").unwrap(), port: "height".into(), grid: g.terrain().grid(3).unwrap() };
        engine(1).plan(&g, &[want]).peak_bytes()
    };
    let samples = 20 * 13;
    // A reader may take more for a while than the surface that it leaves.
    let (cubic, linear) = (planned("cubic"), planned("linear"));
    assert!(cubic > linear, "{cubic}, {linear}");
    assert!(
        cubic >= Relief::bytes(20, 13, true) && linear >= Relief::bytes(20, 13, false),
        "{cubic}, {linear}"
    );
    assert!(planned("linear") > samples * 8);
}

/// A scene of many lines with slopes and envelopes: `n` across 8 km, each of `corners` corners.
fn lines(n: usize, corners: usize) -> Curves {
    let spec = |i: usize| {
        let y = 8192.0 * (i as f64 + 0.5) / n as f64;
        let point = |k: usize| {
            let bend = if k.is_multiple_of(2) { 3.0 } else { -3.0 };
            [8192.0 * k as f64 / (corners - 1) as f64, y + bend]
        };
        CurveSpec {
            line: (0..corners).flat_map(point).collect(),
            height: vec![0.0, 100.0, 0.0],
            slope: vec![0.0, 20.0, 20.0, -30.0, -30.0],
            envelope: vec![0.0, 5.0, 5.0],
            ..CurveSpec::default()
        }
    };
    Curves::from_specs(&(0..n).map(spec).collect::<Vec<_>>()).unwrap()
}

/// What rasterising curves takes is stated before they are known: it holds for few, for so many that rows are filled in
/// turn, and for too many, which are refused.
#[test]
fn rasterising_takes_no_more_than_it_says_whatever_the_curves() {
    let grid = Terrain::default().grid(257).unwrap();
    let run = |curves: &Curves| {
        let (took, result) =
            peak(|| rasterise(curves, &grid, &orograph::kit::curves::Options::default(), &|| false));
        let planes = result.as_ref().map_or(0, |c| c.bytes());
        assert!(took - planes <= BESIDE, "took {took} bytes, {planes} of them for planes");
        (took - planes, result)
    };
    let (few, result) = run(&lines(3, 300));
    assert!(result.is_ok() && few < BESIDE / 8, "{few}");
    // Some 60 000 parts, of which 16 384 may be in memory at once.
    let (_, many) = run(&lines(40, 400));
    assert!(many.is_ok(), "{many:?}");
    let (_, wild) = run(&lines(2000, 500));
    let said = wild.unwrap_err().to_string();
    assert!(said.contains("parts of curves") && said.contains("at most"), "{said}");
    let (_, long) = run(&lines(90, 16_000));
    assert!(long.is_err_and(|e| e.to_string().contains("corners of curves on this grid: at most 1048576")));
}
