//! A node is parsed when its parameters change, and never for anything else.

use std::cell::Cell;
use std::sync::LazyLock;

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::{Graph, NodeId};
use orograph::node::{Cancel, Kind};
use orograph::nodes::Registry;
use orograph::prelude::*;
use serde_json::json;

thread_local! {
    /// How often a node was parsed on this thread.
    static PARSED: Cell<usize> = const { Cell::new(0) };
}

ports! {
    struct In {
        /// A field.
        field: Option<Field>,
    }
    struct Out {
        /// A field.
        field: Field,
    }
}

/// Counts how often it is parsed: every parsed node is checked once.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Counted {
    /// An amount.
    amount: Metres,
}

impl Node for Counted {
    type In = In;
    type Out = Out;
    const META: Meta = Meta::new();

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn check(&self) -> Result<()> {
        PARSED.set(PARSED.get() + 1);
        Ok(())
    }

    fn run(&self, cx: &Context<'_>, In { field }: In) -> Result<Out> {
        Ok(Out { field: field.unwrap_or_else(|| Field::constant(cx.grid, Quantity::Number, 0.0)) })
    }
}

fn registry() -> Registry {
    static KINDS: LazyLock<Registry> =
        LazyLock::new(|| Registry::standard().with([Kind::of::<Counted>("test", "counted")]));
    KINDS.clone()
}

/// A chain of nodes, the first of which is set by an exposed parameter, and its end.
fn chain(length: usize) -> (Graph, NodeId) {
    let nodes: serde_json::Map<_, _> = (0..length)
        .map(|i| {
            let input = if i > 0 { json!({ "field": format!("n{}.field", i - 1) }) } else { json!({}) };
            (format!("n{i}"), json!({ "kind": "counted", "in": input }))
        })
        .collect();
    let from = format!("n{}.field", length - 1);
    let graph = json!({
        "orograph": 1, "nodes": nodes, "outputs": { "out": { "from": from } },
        "expose": { "first": { "bind": ["n0.amount"], "value": 5 } },
    });
    let graph = Graph::from_bytes(graph.to_string().as_bytes(), &registry()).unwrap();
    let end = graph.find(&format!("n{}", length - 1)).unwrap();
    (graph, end)
}

fn parsed(work: impl FnOnce()) -> usize {
    let before = PARSED.get();
    work();
    PARSED.get() - before
}

#[test]
fn a_movement_of_a_hand_parses_one_node() {
    let (mut graph, end) = chain(100);
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let grid = graph.terrain().grid(65).unwrap();
    let look = |graph: &Graph| {
        assert!(graph.problems().is_empty(), "{:?}", graph.problems());
        let want = Want { node: end, port: "field".into(), grid };
        assert!(engine.plan(graph, &[want]).tasks().len() >= 100);
        assert_eq!(engine.keys(graph, &[end], 0, &Unobserved, &Cancel::default()).unwrap().len(), 1);
    };
    assert_eq!(parsed(|| look(&graph)), 100, "each once");
    assert_eq!(parsed(|| look(&graph.clone())), 0, "a copy shares what was parsed");
    let moved = parsed(|| {
        graph.assign_json("n7.amount", &json!(3)).unwrap();
        look(&graph);
    });
    assert_eq!(moved, 1, "the one that changed");
    let moved = parsed(|| {
        graph.assign_json("first", &json!(9)).unwrap();
        look(&graph);
    });
    assert_eq!(moved, 1, "the one that the exposed parameter sets");
    let renamed = parsed(|| {
        graph.rename(graph.find("n7").unwrap(), "seven").unwrap();
        graph.move_to(end, [3.0, 4.0]).unwrap();
        look(&graph);
    });
    assert_eq!(renamed, 0, "names and places are no parameters");
}

#[test]
fn what_was_parsed_follows_the_parameters() {
    let (mut graph, end) = chain(2);
    let key = |graph: &Graph| {
        let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
        engine.key(graph, end).unwrap()
    };
    let before = key(&graph);
    let copy = graph.clone();
    graph.assign_json("n1.amount", &json!(3)).unwrap();
    assert_ne!(key(&graph), before);
    assert_eq!(key(&copy), before, "the copy kept its own");
    graph.assign_json("n1.amount", &json!(0)).unwrap();
    assert_eq!(key(&graph), before);
}
