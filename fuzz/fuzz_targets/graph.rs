//! Any bytes: reading, checking, writing, reading again. `cargo +nightly fuzz run graph`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use orograph::graph::{Graph, NodeId};
use orograph::nodes::Registry;

fuzz_target!(|bytes: &[u8]| {
    let registry = Registry::standard();
    let Ok(mut graph) = Graph::from_bytes(bytes, &registry) else { return };
    assert_eq!(graph.to_bytes(), bytes);
    let problems = texts(&graph);
    look(&graph);
    let canonical = graph.canonical();
    let again = Graph::from_bytes(&canonical, &registry).expect("what was written can be read");
    assert_eq!(again.canonical(), canonical);
    // What was settled by writing is not told again.
    assert!(texts(&again).iter().all(|p| problems.contains(p)));
    // Every edit that takes a node, on each of a few.
    let nodes: Vec<NodeId> = graph.nodes().take(8).collect();
    for (i, &id) in nodes.iter().enumerate() {
        let _ = graph.rename(id, &format!("renamed_{i}"));
        let parameters: Vec<String> = graph.node(id).set.keys().cloned().collect();
        for parameter in parameters {
            let _ = graph.reset(id, &parameter);
        }
        for &other in &nodes {
            let _ = graph.connect(id, "field", other, "field");
        }
    }
    for &id in nodes.iter().step_by(2) {
        let _ = graph.remove_bridged(id);
    }
    let canonical = graph.canonical();
    let again = Graph::from_bytes(&canonical, &registry).expect("what was edited can be read");
    assert_eq!(again.canonical(), canonical);
    let problems = texts(&graph);
    assert!(texts(&again).iter().all(|p| problems.contains(p)));
});

fn texts(graph: &Graph) -> Vec<String> {
    graph.problems().iter().map(ToString::to_string).collect()
}

fn look(graph: &Graph) {
    assert_eq!(graph.terrain().fault(), None);
    let _ = graph.order();
    for id in graph.nodes().take(100) {
        let _ = graph.node(id).parse().map(|n| n.canonical());
        let _ = (graph.upstream(id), graph.downstream(id), graph.inputs(id).count());
    }
    for (name, _) in graph.outputs() {
        let _ = graph.output_source(name);
    }
    for (name, _) in graph.exposed().take(100) {
        let _ = graph.exposed_param(name);
    }
}
