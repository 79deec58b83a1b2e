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
    [Want { node, port: "field", grid: graph.terrain().grid(5).expect("a size") }]
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
