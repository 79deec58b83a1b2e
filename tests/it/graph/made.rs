//! A kind made while the program runs is one like all others: wired, set, saved, planned, evaluated.

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::{Graph, NodeId};
use orograph::node::Cancel;
use orograph::value::{Quantity, Value};
use serde_json::{Map, Value as Json, json};

use super::weighted::{kind, registry};

const LEFT: &str = "the weight of what stands left";
const RIGHT: &str = "the weight of what stands right";

/// Two constants and a weighted sum of them.
fn graph() -> (Graph, NodeId) {
    let mut graph = Graph::with_registry(registry());
    let sum = graph.add("sum", "weighted").unwrap();
    for (name, value, input) in [("three", 3.0, LEFT), ("five", 5.0, RIGHT)] {
        let constant = graph.add(name, "constant").unwrap();
        graph.set(constant, "value", json!(value)).unwrap();
        graph.connect(constant, "field", sum, input).unwrap();
    }
    (graph, sum)
}

fn value(graph: &Graph, node: NodeId) -> (Value, Option<Quantity>) {
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let want = [Want { node, port: "the sum".into(), grid: graph.terrain().grid(5).unwrap() }];
    let plan = engine.plan(graph, &want);
    let evaluation = engine.evaluate(graph, &want, &Unobserved, &Cancel::default()).unwrap();
    (evaluation.values[0].clone().unwrap(), plan.quantity(0))
}

fn first(value: &Value) -> f32 {
    value.components()[0]
}

#[test]
fn it_is_wired_and_set_and_evaluated() {
    let (mut graph, sum) = graph();
    assert!(graph.problems().iter().all(|p| !p.is_error()), "{:?}", graph.problems());
    let (eight, quantity) = value(&graph, sum);
    assert_eq!((first(&eight), eight.quantity(), quantity), (8.0, quantity, Some(Quantity::Length)));
    graph.assign(&format!("sum.{LEFT}"), "2.5").unwrap();
    assert_eq!(first(&value(&graph, sum).0), 12.5);
    graph.assign(&format!("sum.{LEFT}"), "0").unwrap();
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let want = [Want { node: sum, port: "the sum".into(), grid: graph.terrain().grid(5).unwrap() }];
    let planned: Vec<String> = engine.plan(&graph, &want).tasks().into_iter().map(|t| t.node).collect();
    assert_eq!(planned, ["five", "sum"], "what has no weight is not evaluated");
    let refused = graph.assign(&format!("sum.{LEFT}"), "10").unwrap_err().to_string();
    assert!(refused.contains("from -9 to 9, got 10"), "{refused}");
    let refused = graph.connect(sum, "sum", sum, RIGHT).unwrap_err().to_string();
    assert!(refused.contains("it has `the sum`"), "{refused}");
}

#[test]
fn the_engine_mixes_by_its_mask_and_lets_it_be_left_out() {
    let (mut graph, sum) = graph();
    let half = graph.add("half", "constant").unwrap();
    graph.set(half, "value", json!(0.5)).unwrap();
    graph.connect(half, "field", sum, "mask").unwrap();
    assert_eq!(first(&value(&graph, sum).0), 5.5, "half way from 3 to 8");
    graph.set_bypass(sum, true).unwrap();
    let add = graph.add("add", "combine").unwrap();
    graph.connect(sum, "the sum", add, "a").unwrap();
    assert_eq!(graph.passed(graph.source(add, "a").unwrap()).unwrap().node, graph.find("three").unwrap());
}

#[test]
fn it_is_saved_and_read_back_where_the_kind_is_known() {
    let (mut graph, sum) = graph();
    graph.assign(&format!("sum.{RIGHT}"), "-2").unwrap();
    let bytes = graph.canonical();
    let again = Graph::from_bytes(&bytes, &registry()).unwrap();
    assert_eq!(again.canonical(), bytes);
    assert_eq!(first(&value(&again, again.find("sum").unwrap()).0), -7.0);
    assert_eq!(first(&value(&graph, sum).0), -7.0);
    // Where nobody made the kind, or made it with other ports, the node is kept as it was written.
    let stranger = Graph::from_bytes(&bytes, &orograph::nodes::Registry::standard()).unwrap();
    assert!(stranger.problems().iter().any(|p| p.to_string().contains("`weighted`, which is not known")));
    assert_eq!(stranger.canonical(), bytes);
    let other = orograph::nodes::Registry::standard().with([kind(&[LEFT.to_owned()])]);
    let other = Graph::from_bytes(&bytes, &other).unwrap();
    let problems: Vec<String> = other.problems().iter().map(ToString::to_string).collect();
    assert!(problems.iter().any(|p| p.contains(RIGHT)), "{problems:?}");
    let written: Json = serde_json::from_slice(&other.canonical()).unwrap();
    assert_eq!(written["nodes"]["sum"]["in"][RIGHT], "five.field");
}

#[test]
fn its_schema_and_page_are_like_those_of_any_kind() {
    let registry = registry();
    let kind = registry.find("weighted").unwrap();
    assert_eq!(kind.summary(), "Adds what it reads.");
    let names: Vec<&str> = kind.params().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, [LEFT, RIGHT]);
    let validator = jsonschema::validator_for(&orograph::graph::schema(&registry)).unwrap();
    let (graph, _) = graph();
    let mut file: Json = serde_json::from_slice(&graph.canonical()).unwrap();
    assert!(validator.is_valid(&file), "{:?}", validator.iter_errors(&file).next());
    file["nodes"]["sum"]["set"] = Json::from(Map::from_iter([(LEFT.to_owned(), json!(99))]));
    assert!(!validator.is_valid(&file));
}
