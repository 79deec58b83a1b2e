//! Whatever is done to a graph, it can be saved and opened again, and nothing panics.

use orograph::graph::{Backend, Exposed, Graph, NodeId, Output};
use proptest::prelude::*;
use serde_json::{Value as Json, json};

use super::kinds::*;

#[derive(Clone, Debug)]
enum Edit {
    Add(usize, usize),
    Remove(usize, bool),
    Rename(usize, usize),
    Connect(usize, usize, usize, usize),
    Disconnect(usize, usize),
    Set(usize, usize, usize),
    Reset(usize, usize),
    Assign(usize, usize, usize),
    Expose(usize, usize, usize, usize),
    Unexpose(usize),
    SetExposed(usize, usize),
    AddOutput(usize, usize, usize),
    RemoveOutput(usize),
    Terrain(usize, usize),
    Move(usize, f64),
    Backend(usize),
}

const NAMES: [&str; 8] = ["a", "b", "c", "d", "ghost", "terrain", "Bad name", "x.y"];
const KINDS: [&str; 6] = ["hills", "sum", "flow", "aged", "constant", "nothing"];
const PORTS: [&str; 7] = ["field", "a", "b", "mask", "direction", "zz", ""];
const PARAMETERS: [&str; 13] = [
    "amplitude",
    "octaves",
    "mode",
    "mode.turned.angle",
    "scale",
    "points",
    "points.0.1",
    "seed",
    "minus",
    "size",
    "value",
    "quantity",
    "ghost",
];
const SETTINGS: [&str; 6] = ["width", "depth", "base", "origin", "geo", "ghost"];

fn value(i: usize) -> Json {
    let values = [
        json!(0),
        json!(1),
        json!(-1),
        json!(8.0),
        json!(4500),
        json!(0.1),
        json!(1e300),
        json!(true),
        json!(null),
        json!("plain"),
        json!({"turned": {"angle": 7.5}}),
        json!([[0, 0.5]]),
        json!([1, 2]),
        json!("mask"),
        json!({}),
        json!(1025),
        json!(u64::MAX),
    ];
    values[i % values.len()].clone()
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let n = || 0..64_usize;
    let edit = prop_oneof![
        4 => (n(), n()).prop_map(|(a, b)| Edit::Add(a, b)),
        1 => (n(), any::<bool>()).prop_map(|(a, b)| Edit::Remove(a, b)),
        2 => (n(), n()).prop_map(|(a, b)| Edit::Rename(a, b)),
        6 => (n(), n(), n(), n()).prop_map(|(a, b, c, d)| Edit::Connect(a, b, c, d)),
        1 => (n(), n()).prop_map(|(a, b)| Edit::Disconnect(a, b)),
        6 => (n(), n(), n()).prop_map(|(a, b, c)| Edit::Set(a, b, c)),
        1 => (n(), n()).prop_map(|(a, b)| Edit::Reset(a, b)),
        2 => (n(), n(), n()).prop_map(|(a, b, c)| Edit::Assign(a, b, c)),
        3 => (n(), n(), n(), n()).prop_map(|(a, b, c, d)| Edit::Expose(a, b, c, d)),
        1 => n().prop_map(Edit::Unexpose),
        2 => (n(), n()).prop_map(|(a, b)| Edit::SetExposed(a, b)),
        2 => (n(), n(), n()).prop_map(|(a, b, c)| Edit::AddOutput(a, b, c)),
        1 => n().prop_map(Edit::RemoveOutput),
        1 => (n(), n()).prop_map(|(a, b)| Edit::Terrain(a, b)),
        1 => (n(), any::<f64>()).prop_map(|(a, x)| Edit::Move(a, x)),
        1 => n().prop_map(Edit::Backend),
    ];
    prop::collection::vec(edit, 0..60)
}

fn of<'a>(names: &[&'a str], i: usize) -> &'a str {
    names[i % names.len()]
}

/// A node that no other graph has.
fn gone() -> NodeId {
    Graph::with_registry(registry()).add("gone", "sum").unwrap()
}

fn apply(graph: &mut Graph, edit: &Edit) -> bool {
    let nodes: Vec<NodeId> = graph.nodes().collect();
    // One in nine is a node that is not there any more.
    let gone = gone();
    let node = |i: usize| match nodes.get(i % nodes.len().max(1)) {
        Some(node) if i % 9 != 8 => *node,
        _ => gone,
    };
    match *edit {
        Edit::Add(name, kind) => graph.add(of(&NAMES, name), of(&KINDS, kind)).is_ok(),
        Edit::Remove(i, false) => graph.remove(node(i)).is_ok(),
        Edit::Remove(i, true) => graph.remove_bridged(node(i)).is_ok(),
        Edit::Rename(i, name) => graph.rename(node(i), of(&NAMES, name)).is_ok(),
        Edit::Connect(a, out, b, input) => {
            graph.connect(node(a), of(&PORTS, out), node(b), of(&PORTS, input)).is_ok()
        }
        Edit::Disconnect(a, input) => graph.disconnect(node(a), of(&PORTS, input)).is_ok(),
        Edit::Set(a, name, v) => graph.set(node(a), of(&PARAMETERS, name), value(v)).is_ok(),
        Edit::Reset(a, name) => graph.reset(node(a), of(&PARAMETERS, name)).is_ok(),
        Edit::Assign(a, name, v) => {
            let path = format!("{}.{}", of(&NAMES, a), of(&PARAMETERS, name));
            graph.assign(&path, &value(v).to_string()).is_ok()
        }
        Edit::Expose(name, a, p, v) => {
            let binds = [a, a + p].map(|i| format!("{}.{}", of(&NAMES, i), of(&PARAMETERS, p)));
            let bind = if v % 3 == 0 { binds.to_vec() } else { binds[..1].to_vec() };
            let exposed =
                Exposed { bind, value: if v % 2 == 0 { Json::Null } else { value(v) }, ..Exposed::default() };
            if v % 5 == 0 {
                graph.change_exposed(of(&NAMES, name), exposed).is_ok()
            } else {
                graph.expose(of(&NAMES, name), exposed).is_ok()
            }
        }
        Edit::Unexpose(name) => graph.unexpose(of(&NAMES, name)).is_ok(),
        Edit::SetExposed(name, v) => graph.set_exposed(of(&NAMES, name), value(v)).is_ok(),
        Edit::AddOutput(name, a, p) => {
            let from = format!("{}.{}", of(&NAMES, a), of(&PORTS, p));
            let output = Output {
                from,
                range: (p % 2 == 0).then_some([a as f64 - 20.0, p as f64]),
                ..Output::default()
            };
            if p % 3 == 0 {
                graph.change_output(of(&NAMES, name), output).is_ok()
            } else {
                graph.add_output(of(&NAMES, name), output).is_ok()
            }
        }
        Edit::RemoveOutput(name) => graph.remove_output(of(&NAMES, name)).is_ok(),
        Edit::Terrain(s, v) => graph.set_terrain(of(&SETTINGS, s), value(v)).is_ok(),
        Edit::Move(i, x) => graph.move_to(node(i), [x, -x]).is_ok(),
        Edit::Backend(i) => {
            graph.set_backend(node(i), if i % 2 == 0 { Backend::Gpu } else { Backend::Auto }).is_ok()
        }
    }
}

/// Everything that an engine or an editor would see of a graph.
fn seen(graph: &Graph) -> Vec<String> {
    let mut all = told(graph);
    for id in graph.nodes() {
        let node = graph.node(id);
        let inputs: Vec<_> =
            graph.inputs(id).map(|(p, s)| format!("{p}={}", graph.source_text(&s))).collect();
        let parsed = node.parse().map(|n| n.canonical().to_string());
        all.push(format!(
            "{} {:?} {inputs:?} {parsed:?} {:?} {:?}",
            node.name, node.kind, node.at, node.backend
        ));
    }
    let name = |id: &NodeId| graph.node(*id).name.clone();
    all.push(format!(
        "{:?}",
        graph.order().map(|o| o.iter().map(name).collect::<Vec<_>>()).map_err(|p| p.to_string())
    ));
    all.push(format!("{:?}", graph.terrain()));
    for (name, _) in graph.exposed() {
        all.push(format!(
            "{:?}",
            graph.exposed_param(name).map(|p| (p.shape, p.default.to_string())).map_err(|p| p.to_string())
        ));
    }
    for (name, output) in graph.outputs() {
        all.push(format!(
            "{name} {output:?} {:?}",
            graph.output_source(name).map(|s| graph.source_text(&s)).map_err(|p| p.to_string())
        ));
    }
    all
}

fn comes_back(graph: &Graph) {
    let text = canonical(graph);
    let again = load(&text);
    assert_eq!(canonical(&again), text);
    assert_eq!(seen(&again), seen(graph), "{text}");
    assert_eq!(graph.terrain().fault(), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_edits_never_panic_and_come_back(edits in edits()) {
        let mut graph = Graph::with_registry(registry());
        for edit in &edits {
            let before = graph.canonical();
            if !apply(&mut graph, edit) {
                prop_assert_eq!(graph.canonical(), before, "a refused edit changed the graph: {:?}", edit);
            }
        }
        comes_back(&graph);
    }

    #[test]
    fn random_edits_of_a_broken_file_come_back(edits in edits()) {
        let mut graph = load(r#"{"orograph": 1, "kinds": {"far": 3}, "expose": {"a": {"bind": ["ghost.octaves"], "value": 3}, "b": {"bind": ["a.mode.turned.angle", "d.mode.turned.angle"], "value": 5},
            "c": {"bind": ["d.mode"], "value": "plain"}, "d": {"bind": 3}}, "nodes": {"a": {"kind": "hills", "set": {"mode": {"turned": {"angle": 3}}, "octaves": 99}}, "d": {"kind": "hills"},
            "x.y": {"kind": "far", "in": {"q": "a.field"}}, "c": {"kind": "sum", "in": {"a": "ghost.field", "b": "c.field", "mask": 3, "zz": "a.field"}, "at": 7}},
            "outputs": {"a": {"from": "ghost.field"}, "B": {"from": "c.field", "format": "x"}}, "terrain": {"base": -3}, "title": 3, "inputs": {"later": 1}}"#);
        comes_back(&graph);
        for edit in &edits {
            apply(&mut graph, edit);
        }
        if graph.is_changed() {
            comes_back(&graph);
        }
    }

    #[test]
    fn damaged_files_never_panic(flips in prop::collection::vec((0..EXAMPLE.len(), any::<u8>(), 0..4_u8), 1..8)) {
        let mut bytes = EXAMPLE.as_bytes().to_vec();
        for (i, byte, what) in flips {
            let i = i % bytes.len().max(1);
            match what {
                0 => bytes.insert(i, byte),
                1 if !bytes.is_empty() => _ = bytes.remove(i),
                2 => bytes = bytes.iter().copied().chain(bytes[i..].iter().copied()).collect(),
                _ if i < bytes.len() => bytes[i] = b"0123456789{}[]\",:.-e abn"[byte as usize % 24],
                _ => (),
            }
        }
        if let Ok(graph) = Graph::from_bytes(&bytes, &registry()) {
            prop_assert_eq!(graph.to_bytes(), bytes);
            let text = canonical(&graph);
            prop_assert_eq!(canonical(&load(&text)), text);
            let _ = seen(&graph);
        }
    }
}
