//! A node is parsed when its parameters change, and never for anything else; a graph is made a program once.

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
    /// How often a program asked on this thread whether a node uses its input.
    static ASKED: Cell<usize> = const { Cell::new(0) };
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

/// Counts how often it is parsed, as every parsed node is checked once, and how often it is made a step of a program.
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

    fn uses(&self, _: &str) -> bool {
        ASKED.set(ASKED.get() + 1);
        true
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

fn asked(work: impl FnOnce()) -> usize {
    let before = ASKED.get();
    work();
    ASKED.get() - before
}

#[test]
fn a_movement_of_a_hand_makes_one_program() {
    let (mut graph, end) = chain(100);
    let all: Vec<_> = graph.nodes().collect();
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let want = Want { node: end, port: "field".into(), grid: graph.terrain().grid(65).unwrap() };
    let look = |graph: &Graph| {
        assert_eq!(engine.keys(graph, &all, 0, &Unobserved, &Cancel::default()).unwrap().len(), 100);
        let planned = engine.plan(graph, std::slice::from_ref(&want)).tasks().len();
        let ran = engine.evaluate(graph, std::slice::from_ref(&want), &Unobserved, &Cancel::default());
        assert_eq!(ran.unwrap().tasks.len(), planned);
        assert!(engine.key(graph, end).is_some());
    };
    assert_eq!(asked(|| look(&graph)), 100, "each node once, for keys, plan and evaluation");
    assert_eq!(asked(|| look(&graph.clone())), 0, "a copy is the same graph");
    graph.assign_json("n7.amount", &json!(3)).unwrap();
    assert_eq!(asked(|| look(&graph)), 100, "a changed graph has a program of its own");
    let other = chain(3).0;
    let other_end: Vec<_> = other.nodes().collect();
    assert_eq!(engine.keys(&other, &other_end, 0, &Unobserved, &Cancel::default()).unwrap().len(), 3);
    assert_eq!(asked(|| look(&graph)), 0, "another graph in between takes nothing away");
}

#[test]
fn a_part_of_a_program_is_planned_like_a_program_of_its_own() {
    let nodes = json!({
        "hills": { "kind": "fractal_noise", "set": { "seed": 3 } },
        "soft": { "kind": "blur", "in": { "field": "hills.field" } },
        "left": { "kind": "invert", "in": { "field": "soft.field" }, "bypass": true },
        "both": { "kind": "combine", "in": { "a": "left.field", "b": "hills.field", "mask": "band.mask" } },
        "band": { "kind": "select_height", "in": { "height": "soft.field" } },
        "worn": { "kind": "thermal_erosion", "in": { "height": "both.field" } },
        "loose": { "kind": "blur", "in": { "field": "nothing.field" } },
        "aside": { "kind": "combine", "in": { "a": "worn.height", "b": "soft.field" } },
    });
    let outputs = json!({ "out": { "from": "worn.height" } });
    let graph = json!({ "orograph": 1, "nodes": nodes, "outputs": outputs });
    let graph = Graph::from_bytes(graph.to_string().as_bytes(), &registry()).unwrap();
    let all: Vec<_> = graph.nodes().collect();
    let engine = || Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    let first = engine();
    first.keys(&graph, &all, 0, &Unobserved, &Cancel::default()).unwrap();
    let grid = graph.terrain().grid(257).unwrap();
    for node in &all {
        let port = graph.node(*node).kind().unwrap().outputs[0].name.clone();
        let want = [Want { node: *node, port, grid }];
        let told = |engine: &Engine| {
            let plan = engine.plan(&graph, &want);
            let failures: Vec<_> = plan.failures().iter().flatten().map(ToString::to_string).collect();
            let too_narrow = format!("{:?}", plan.too_narrow());
            (format!("{:?}", plan.tasks()), failures, plan.peak_bytes(), plan.quantity(0), too_narrow)
        };
        assert_eq!(told(&first), told(&engine()), "{}", graph.node(*node).name);
    }
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
