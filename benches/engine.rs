//! What the engine adds to the work of the nodes: planning a graph of a thousand, running them on a small grid, and
//! answering from the cache.

use divan::Bencher;
use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use serde_json::{Map, json};

fn main() {
    divan::main();
}

/// A chain of a thousand inversions about zero.
fn chain() -> Graph {
    let mut nodes = Map::new();
    nodes.insert("n0".into(), json!({ "kind": "constant", "set": { "value": 3 } }));
    for i in 1..1000 {
        let set = json!({ "about": { "value": { "value": 0 } } });
        let inputs = json!({ "field": format!("n{}.field", i - 1) });
        nodes.insert(format!("n{i}"), json!({ "kind": "invert", "set": set, "in": inputs }));
    }
    let file = json!({ "orograph": 1, "nodes": nodes, "outputs": { "end": { "from": "n999.field" } } });
    Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).expect("a graph")
}

fn engine() -> Engine {
    Engine::new(&Options::default(), Files::default()).expect("an engine")
}

fn want(graph: &Graph) -> [Want; 1] {
    let node = graph.find("n999").expect("the last node");
    [Want { node, port: "field".into(), grid: graph.terrain().grid(5).expect("a size") }]
}

#[divan::bench]
fn plan_1000_nodes(bencher: Bencher<'_, '_>) {
    let (graph, engine) = (chain(), engine());
    bencher.bench(|| engine.plan(&graph, &want(&graph)));
}

#[divan::bench]
fn run_1000_nodes_of_25_samples(bencher: Bencher<'_, '_>) {
    let graph = chain();
    let wants = want(&graph);
    bencher
        .with_inputs(engine)
        .bench_values(|engine| engine.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).is_ok());
}

#[divan::bench]
fn answer_from_the_cache(bencher: Bencher<'_, '_>) {
    let (graph, engine) = (chain(), engine());
    let wants = want(&graph);
    assert!(engine.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).is_ok());
    bencher.bench(|| engine.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).is_ok());
}

/// The chain with a mask of fifty strokes, 100,000 numbers, painted on its middle.
fn painted() -> Graph {
    let mut graph = chain();
    let path = |k: usize| (0..1000).flat_map(move |i| [(i + k) as f64 * 7.0, 100.0 + (i * 5 + k) as f64]);
    let stroke = |k: usize| json!({ "path": path(k).collect::<Vec<_>>(), "radius": 60 });
    let paint = graph.add("paint", "paint_mask").expect("a kind");
    let strokes: Vec<_> = (0..50).map(stroke).collect();
    graph.set(paint, "strokes", json!(strokes)).expect("strokes");
    let middle = graph.find("n500").expect("a node");
    graph.connect(paint, "mask", middle, "mask").expect("a wire");
    graph
}

/// A movement of a hand on a thousand nodes, as the editor follows it: a copy for the history, one parameter set,
/// problems, keys and plan looked at again. It drags a number beside the strokes, a point of one of them, or one of them
/// whole, as a brush does; or it sets all strokes anew, as a stroke more does.
#[divan::bench(args = ["number", "point", "stroke", "strokes"])]
fn movement(bencher: Bencher<'_, '_>, what: &str) {
    let (mut graph, engine) = (painted(), engine());
    let (middle, paint) = (graph.find("n500").expect("a node"), graph.find("paint").expect("a node"));
    let nodes: Vec<_> = graph.nodes().collect();
    let strokes = graph.node(paint).set.value("strokes").expect("strokes");
    let mut step = 0.0;
    bencher.bench_local(|| {
        step += 1.0;
        let mut moved = graph.clone();
        let done = match what {
            "number" => moved.set(middle, "about.value.value", json!(step)),
            "point" => moved.set(paint, "strokes.7.path.11", json!(step)),
            "stroke" => {
                let mut stroke = strokes[7].clone();
                stroke["path"][11] = json!(step);
                moved.set(paint, "strokes.7", stroke)
            }
            _ => {
                let mut strokes = strokes.clone();
                strokes[7]["path"][11] = json!(step);
                moved.set(paint, "strokes", strokes)
            }
        };
        done.expect("a movement");
        assert!(moved.problems().is_empty(), "{:?}", moved.problems());
        let keys = engine.keys(&moved, &nodes, 0, &Unobserved, &Cancel::default()).expect("keys").len();
        let plan = engine.plan(&moved, &want(&moved));
        graph = moved;
        (keys, plan)
    });
}
