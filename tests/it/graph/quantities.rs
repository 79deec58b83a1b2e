//! What the numbers on the wires mean, known from the document alone.

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::{Graph, Source};
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::Quantity;
use serde_json::json;

use super::kinds::load;

fn quantity(graph: &Graph, node: &str, port: &str) -> Option<Quantity> {
    graph.quantity(&Source { node: graph.find(node).unwrap(), port: port.into() })
}

/// Heights, a mask of them, and what comes of the two.
fn graph() -> Graph {
    let file = json!({ "orograph": 1, "terrain": { "base": 17 }, "nodes": {
        "hills": { "kind": "fractal_noise" },
        "soft": { "kind": "blur", "in": { "field": "hills.field" } },
        "steep": { "kind": "select_slope", "in": { "height": "soft.field" } },
        "cut": { "kind": "combine", "set": { "mode": "multiply" }, "in": { "a": "steep.mask", "b": "soft.field" } },
        "share": { "kind": "remap", "in": { "field": "cut.field" },
            "set": { "out_low": 0, "out_high": 1, "clamp": true } },
        "taken": { "kind": "switch", "set": { "choice": 1 }, "in": { "a": "hills.field", "b": "share.field" } },
        "lines": { "kind": "feature_curves" },
    }, "outputs": { "out": { "from": "taken.field" } } });
    Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).unwrap()
}

#[test]
fn they_follow_ports_wires_and_parameters() {
    let mut graph = graph();
    let of = |graph: &Graph, name: &str| quantity(graph, name, "field");
    assert_eq!(of(&graph, "soft"), Some(Quantity::Elevation), "like its input");
    assert_eq!(quantity(&graph, "steep", "slope"), Some(Quantity::Slope), "fixed");
    assert_eq!(of(&graph, "cut"), Some(Quantity::Elevation), "a mask times heights");
    assert_eq!(of(&graph, "share"), Some(Quantity::Mask), "by its parameters");
    assert_eq!(of(&graph, "taken"), Some(Quantity::Mask));
    graph.assign("taken.choice", "0").unwrap();
    assert_eq!(of(&graph, "taken"), Some(Quantity::Elevation));
    assert_eq!(quantity(&graph, "lines", "curves"), None);
    graph.set_bypass(graph.find("share").unwrap(), true).unwrap();
    graph.assign("taken.choice", "1").unwrap();
    assert_eq!(of(&graph, "taken"), Some(Quantity::Elevation), "what passes through a node that is left out");
}

#[test]
fn plan_and_result_say_the_same() {
    let graph = graph();
    let quantities = graph.quantities();
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let grid = graph.terrain().grid(9).unwrap();
    let mut wants = Vec::new();
    for id in graph.nodes() {
        let ports = graph.node(id).kind().unwrap().outputs.iter();
        wants.extend(ports.map(|p| Want { node: id, port: p.name.clone(), grid }));
    }
    let plan = engine.plan(&graph, &wants);
    let evaluation = engine.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).unwrap();
    assert!(wants.len() >= 8);
    for (i, want) in wants.iter().enumerate() {
        let known = quantities.get(&graph, &want.source());
        assert_eq!(known, plan.quantity(i), "{}", graph.source_text(&want.source()));
        assert_eq!(known, evaluation.values[i].as_ref().unwrap().quantity());
    }
}

#[test]
fn faults_leave_open_what_hangs_on_them_and_nothing_else() {
    let broken = load(
        r#"{ "orograph": 1, "nodes": {
            "hills": { "kind": "fractal_noise", "set": { "amplitude": -1 } },
            "round": { "kind": "blur", "in": { "field": "round.field" } },
            "mixed": { "kind": "combine", "set": { "strength": 9 }, "in": { "a": "hills.field", "b": "hills.field" } },
            "soft": { "kind": "blur", "in": { "field": "mixed.field" } },
            "loose": { "kind": "blur", "in": { "field": "nobody.field" } } } }"#,
    );
    assert_eq!(quantity(&broken, "hills", "field"), Some(Quantity::Elevation), "whatever its amplitude");
    assert_eq!(quantity(&broken, "round", "field"), None, "on a cycle");
    assert_eq!(quantity(&broken, "mixed", "field"), None, "its parameters decide, and cannot be read");
    assert_eq!(quantity(&broken, "loose", "field"), Some(Quantity::Number));
    let all = broken.quantities();
    let of =
        |name: &str| all.get(&broken, &Source { node: broken.find(name).unwrap(), port: "field".into() });
    assert_eq!((of("hills"), of("round")), (Some(Quantity::Elevation), None));
}
