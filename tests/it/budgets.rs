//! What a plan says an evaluation takes, held against the account of the run and against what an allocator saw.

use std::path::{Path, PathBuf};

use orograph::engine::{Engine, Evaluation, Files, Keep, Options, PlannedTask, Stage, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::Grid;
use serde_json::json;

use crate::engine::graph as test_graph;
use crate::kinds::registry;
use crate::memory::{SMALL, held, most_held};

fn presets() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("graphs");
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    all
}

/// A preset on a small base grid, with a small file where it reads one.
fn preset(path: &Path, base: u32) -> Graph {
    let mut graph = Graph::from_bytes(&std::fs::read(path).unwrap(), &registry()).unwrap();
    graph.assign("terrain.base", &base.to_string()).unwrap();
    if graph.exposed().any(|(name, _)| name == "file") {
        graph.assign("file", "small.asc").unwrap();
    }
    graph
}

fn engine(threads: usize, memory: u64, keep: Keep) -> Engine {
    Engine::new(&Options { threads, memory, keep, ..Options::default() }, crate::rig::graph::files()).unwrap()
}

/// Everything that the outputs of a graph want on a grid.
fn wants(graph: &Graph, grid: Grid) -> Vec<Want> {
    let source = |(name, _)| graph.output_source(name).unwrap();
    graph.outputs().map(source).map(|s| Want { node: s.node, port: s.port, grid }).collect()
}

fn evaluate(engine: &Engine, graph: &Graph, wants: &[Want]) -> Evaluation {
    let evaluation = engine.evaluate(graph, wants, &Unobserved, &Cancel::default()).unwrap();
    evaluation.values.iter().for_each(|v| assert!(v.is_ok(), "{:?}", v.as_ref().err()));
    evaluation
}

/// Evaluates on one thread; the bytes that it held at most beyond what it held before, and the evaluation.
fn watched(engine: &Engine, graph: &Graph, wants: &[Want]) -> (u64, Evaluation) {
    let before = engine.pool().install(held);
    let evaluation = evaluate(engine, graph, wants);
    ((engine.pool().install(most_held) - before).max(0) as u64, evaluation)
}

/// What is wrong with the account of a graph whose tiles are built one after the other within the least budget.
fn faults(name: &str, graph: &Graph, tiles: &[Grid]) -> Vec<String> {
    let whole = wants(graph, tiles[0]);
    let unbounded = engine(1, u64::MAX, Keep::Lasting);
    // Before its network is known, a graph of rivers is planned with a guess.
    let guessed = unbounded.plan(graph, &whole).peak_bytes();
    let least = guessed.max(evaluate(&unbounded, graph, &whole).planned_bytes);
    // With what the allocator holds back.
    let memory = least + least / 10;
    let (alone, many) = (engine(1, memory, Keep::Lasting), engine(4, memory, Keep::Lasting));
    let mut faults = Vec::new();
    for (i, tile) in tiles.iter().enumerate() {
        let wants = wants(graph, *tile);
        let (held, one) = watched(&alone, graph, &wants);
        if held > one.peak_bytes + SMALL {
            faults.push(format!("{name}, tile {i}: the account says {}, {held} were held", one.peak_bytes));
        }
        let four = evaluate(&many, graph, &wants);
        for evaluation in [&one, &four] {
            let (account, planned) = (evaluation.peak_bytes, evaluation.planned_bytes);
            if account > planned || planned > least {
                faults.push(format!("{name}, tile {i}: planned {planned} of {least}, by account {account}"));
            }
        }
        let again = |t: &&orograph::engine::TaskReport| t.stage == Stage::Base && t.cached.is_none();
        if i > 0
            && let Some(task) = one.tasks.iter().find(again)
        {
            faults.push(format!("{name}, tile {i}: `{}` ran again on the base grid", task.node));
        }
    }
    faults
}

#[test]
fn no_preset_holds_more_than_its_plan_says() {
    let mut faults = Vec::new();
    for path in presets() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let graph = preset(&path, 129);
        let base = graph.terrain().base_grid();
        let fine = graph.terrain().grid(257).unwrap();
        let half = |col| Grid { col, cols: 129, rows: 129, ..fine };
        faults.extend(self::faults(&format!("{name} at its base"), &graph, &[base]));
        faults.extend(self::faults(&format!("{name} in tiles"), &graph, &[half(0), half(128)]));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_graph_that_holds_more_than_its_plan_says_is_found() {
    let hog = |share: f64| {
        let mut nodes = json!({ "hog": { "kind": "hog", "set": { "share": share } } });
        nodes["end"] = json!({ "kind": "copy", "in": { "field": "hog.field" } });
        let graph = test_graph(nodes);
        let grid = graph.terrain().grid(513).unwrap();
        let want = [Want { node: graph.find("end").unwrap(), port: "field".into(), grid }];
        let (held, evaluation) = watched(&engine(1, u64::MAX, Keep::Lasting), &graph, &want);
        held > evaluation.peak_bytes + SMALL
    };
    assert!(!hog(1.0));
    assert!(hog(0.25));
}

/// Many tasks that could run at once, each of some weight.
fn fan(n: usize) -> Graph {
    let mut nodes = serde_json::Map::new();
    for i in 0..n {
        nodes.insert(format!("a{i}"), json!({ "kind": "waves", "set": { "height": i + 1, "seed": i } }));
        let inputs = json!({ "field": format!("a{i}.field") });
        nodes.insert(format!("b{i}"), json!({ "kind": "smooth", "in": inputs }));
        let last = if i == 0 { "b0.field".to_owned() } else { format!("c{}.field", i - 1) };
        let inputs = json!({ "a": last, "b": format!("b{i}.field") });
        nodes.insert(format!("c{i}"), json!({ "kind": "sum", "in": inputs }));
    }
    test_graph(nodes.into())
}

#[test]
fn tasks_that_run_ahead_stay_within_the_plan() {
    let graph = fan(24);
    let grid = graph.terrain().grid(257).unwrap();
    let want = [Want { node: graph.find("c23").unwrap(), port: "field".into(), grid }];
    for keep in [Keep::Lasting, Keep::Nothing] {
        // However much there is, a build takes what its plan says.
        let evaluation = evaluate(&engine(8, 1 << 40, keep), &graph, &want);
        assert!(evaluation.peak_bytes <= evaluation.planned_bytes, "{evaluation:?}");
        assert_eq!(engine(8, 1 << 40, keep).cached_bytes(), 0);
    }
}

#[test]
fn a_lift_makes_what_is_read_and_nothing_else() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("graphs/mountain.graph");
    let graph = preset(&path, 129);
    let e = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let grid = graph.terrain().grid(513).unwrap();
    let diffuse = graph.nodes().find(|id| graph.node(*id).kind().is_some_and(|k| k.id == "diffuse")).unwrap();
    let lifted = |ports: &[&'static str]| {
        let wants: Vec<_> =
            ports.iter().map(|port| Want { node: diffuse, port: (*port).into(), grid }).collect();
        let lift = |t: &PlannedTask| t.kind == "diffuse" && t.stage == Stage::Lift;
        let lift = e.plan(&graph, &wants).tasks().into_iter().find(lift).unwrap();
        (lift.output_bytes, e.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).unwrap())
    };
    let samples = grid.len() as u64;
    let (height, alone) = lifted(&["height"]);
    let (both, together) = lifted(&["height", "gradient"]);
    assert_eq!((height, both), (4 * samples, 12 * samples));
    assert_eq!(alone.values[0].as_ref().unwrap(), together.values[0].as_ref().unwrap());
    // What was lifted without it does not stand for one that is asked for later.
    assert!(together.values[1].is_ok());
}
