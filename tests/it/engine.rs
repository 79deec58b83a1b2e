//! The engine: laws 2 to 10 and 12, with test kinds of every reach and lying ones.

mod base_grid;
mod budgets;
mod cache_folder;
mod failures;
mod files;
mod masks;
mod runs;
mod states;
mod windows;

use orograph::engine::{Engine, Evaluation, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::{Field, Grid, Value};
use serde_json::json;

use crate::kinds::registry;

pub(crate) fn graph(nodes: serde_json::Value) -> Graph {
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 2048, "base": 129, "seed": 3 },
        "nodes": nodes,
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).expect("a graph")
}

/// A graph with every reach: point, local, a global change, a mask, a summary.
pub(crate) fn chain() -> Graph {
    graph(json!({
        "hills": { "kind": "waves", "set": { "height": 200, "seed": 7 } },
        "detail": { "kind": "waves", "set": { "height": 9, "length": 61, "seed": 8 } },
        "rough": { "kind": "sum", "in": { "a": "hills.field", "b": "detail.field" } },
        "soft": { "kind": "smooth", "in": { "field": "rough.field" } },
        "where": { "kind": "stretch", "in": { "field": "hills.field" } },
        "dug": { "kind": "dig", "in": { "field": "soft.field", "mask": "where.field" } },
        "spread": { "kind": "spread", "in": { "field": "dug.field" } },
        "end": { "kind": "sum", "in": { "a": "dug.field", "b": "spread.field", "mask": "where.field" } },
    }))
}

pub(crate) fn engine(threads: usize) -> Engine {
    Engine::new(&Options { threads, ..Options::default() }, Files::default()).expect("an engine")
}

pub(crate) fn want(graph: &Graph, node: &str, grid: Grid) -> Want {
    Want { node: graph.find(node).expect("the node"), port: "field".into(), grid }
}

pub(crate) fn evaluate(engine: &Engine, graph: &Graph, node: &str, grid: Grid) -> Evaluation {
    engine
        .evaluate(graph, &[want(graph, node, grid)], &Unobserved, &Cancel::default())
        .expect("an evaluation")
}

pub(crate) fn field(evaluation: &Evaluation, i: usize) -> Field {
    match &evaluation.values[i] {
        Ok(Value::Field(f)) => f.clone(),
        other => panic!("a field, not {other:?}"),
    }
}

fn bits(field: &Field) -> Vec<u32> {
    field.data().iter().map(|x| x.to_bits()).collect()
}

/// The nodes that ran, without those from the cache.
fn ran(evaluation: &Evaluation) -> Vec<&str> {
    let mut names: Vec<_> =
        evaluation.tasks.iter().filter(|t| t.cached.is_none()).map(|t| t.node.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn grid(graph: &Graph, size: u32) -> Grid {
    graph.terrain().grid(size).expect("a size that fits")
}
