//! Edits do what they say or leave the graph as it was.

use orograph::files::Format;
use orograph::graph::{About, Backend, Graph, Output};
use serde_json::json;

use super::kinds::*;

fn refused<T: std::fmt::Debug>(result: Result<T, orograph::graph::Problem>, text: &str) {
    assert_eq!(result.unwrap_err().to_string(), text);
}

#[test]
fn a_graph_made_by_hand_is_the_one_in_the_file() {
    let mut graph = Graph::with_registry(registry());
    let hills = graph.add("hills", "hills").unwrap();
    let plain = graph.add("plain", "constant").unwrap();
    let height = graph.add("height", "sum").unwrap();
    graph.set(hills, "seed", json!(7041)).unwrap();
    graph.set(hills, "amplitude", json!(120.0)).unwrap();
    graph.set(plain, "value", json!(12.5)).unwrap();
    graph.set(height, "minus", json!(true)).unwrap();
    graph.set_backend(height, Backend::Cpu).unwrap();
    graph.move_to(plain, [0.0, 120.0]).unwrap();
    graph.move_to(height, [240.0, 0.0]).unwrap();
    graph.connect(plain, "field", height, "b").unwrap();
    graph.connect(hills, "field", height, "a").unwrap();
    graph.set_about(About {
        title: "Hills on a plain".into(),
        author: "A. Nobody".into(),
        license: "CC0-1.0".into(),
        tags: vec!["hills".into(), "plain".into()],
        ..About::default()
    });
    let (min, max) = (Some(0.0), Some(400.0));
    let exposed = orograph::graph::Exposed {
        min,
        max,
        label: "Ruggedness".into(),
        ..orograph::graph::Exposed::of("hills.amplitude")
    };
    graph.expose("ruggedness", exposed).unwrap();
    let from = || "height.field".to_owned();
    graph
        .add_output("height", Output { from: from(), format: Some(Format::Exr), ..Output::default() })
        .unwrap();
    let unreal = Output {
        from: from(),
        format: Some(Format::Png16),
        range: Some([-256.0, 1792.0]),
        target: Some(orograph::files::Target::Unreal),
        ..Output::default()
    };
    graph.add_output("for_unreal", unreal).unwrap();
    assert_eq!(canonical(&graph), EXAMPLE);
    assert_eq!(told(&graph), [""; 0]);
}

#[test]
fn refusals_name_the_place_and_the_nearest_name() {
    let mut graph = load(EXAMPLE);
    let (hills, plain, height) = (id(&graph, "hills"), id(&graph, "plain"), id(&graph, "height"));
    refused(graph.add("a", "sums"), "node `a`: there is no kind `sums`; did you mean `sum`?");
    refused(graph.add("hills", "sum"), "node `hills`: is the name of another node");
    refused(
        graph.add("A b", "sum"),
        "node `A b`: must have a name of 1 to 64 of the characters a to z, 0 to 9 and _",
    );
    refused(graph.add("terrain", "sum"), "node `terrain`: cannot have the name of the terrain's settings");
    refused(graph.rename(hills, "plain"), "node `plain`: is the name of another node");
    refused(
        graph.connect(hills, "feild", height, "a"),
        "node `hills`, output `feild`: `hills` has no such output; it has `field`; did you mean `field`?",
    );
    refused(
        graph.connect(hills, "field", height, "maks"),
        "node `height`, input `maks`: `sum` has no such input; it has `a`, `b`, `mask`; did you mean `mask`?",
    );
    refused(
        graph.connect(height, "field", height, "b"),
        "node `height`, input `b`: cannot read `height.field`: a node cannot read itself",
    );
    refused(
        graph.set(plain, "valu", json!(3)),
        "node `plain`, parameter `valu`: is not one of this kind's: `value`, `quantity`; did you mean `value`?",
    );
    refused(
        graph.set(plain, "value", json!("x")),
        "node `plain`, parameter `value`: must be a number from -1000000 to 1000000, got \"x\"",
    );
    refused(
        graph.set(plain, "value.x", json!(1)),
        "node `plain`, parameter `value.x`: has nothing inside it, so no `x`",
    );
    refused(
        graph.move_to(plain, [f64::NAN, 0.0]),
        "node `plain`: must stand within 1e9 of the middle of the canvas, got [NaN, 0.0]",
    );
    refused(
        graph.remove_output("hight"),
        "output `hight`: is not an output of this graph; it has `height`, `for_unreal`; did you mean `height`?",
    );
    refused(
        graph.set_terrain("widht", json!(3)),
        "terrain, setting `widht`: is not one of the terrain's: `origin`, `width`, `depth`, `sea_level`, `seed`, `base`, `geo`; did you mean `width`?",
    );
    let to = |from: &str| Output { from: from.into(), ..Output::default() };
    refused(
        graph.add_output("nul", to("hills.field")),
        "output `nul`: has a name that Windows keeps for a device",
    );
    refused(
        graph.add_output("x", to("hils.field")),
        "output `x`: reads `hils.field`, but the graph has no node `hils`; did you mean `hills`?",
    );
    refused(
        graph.add_output("x", Output { range: Some([1.0, f64::NAN]), ..to("hills.field") }),
        "output `x`: `range` must be a lower and a higher number, got [1, NaN]",
    );
    refused(
        graph.add_output("height", to("hills.field")),
        "output `height`: is the name of another output, `height`",
    );
    refused(
        graph.disconnect(height, "c"),
        "node `height`, input `c`: `sum` has no such input; it has `a`, `b`, `mask`; did you mean `a`?",
    );
    let flow = graph.add("flow", "flow").unwrap();
    refused(
        graph.connect(flow, "direction", height, "b"),
        "node `height`, input `b`: takes field, but `flow.direction` gives vectors",
    );
    graph.connect(height, "field", flow, "field").unwrap();
    let more = graph.add("more", "sum").unwrap();
    graph.connect(height, "field", more, "a").unwrap();
    refused(
        graph.connect(more, "field", height, "mask"),
        "node `height`, input `mask`: cannot read `more.field`: that would close a cycle, `height` > `more` > `height`",
    );
    graph.remove(more).unwrap();
    graph.remove(flow).unwrap();
    assert!(
        graph.set(more, "minus", json!(true)).unwrap_err().to_string().contains("has no such node any more")
    );
    graph.connect(hills, "field", more, "a").unwrap_err();
    graph.connect(more, "field", height, "a").unwrap_err();
    graph.remove(more).unwrap_err();
    graph.rename(more, "x").unwrap_err();
    assert_eq!(canonical(&graph), EXAMPLE);
}

#[test]
fn renaming_rewires_all_that_names_the_node() {
    let mut graph =
        load(&EXAMPLE.replace("\"b\": \"plain.field\"", "\"b\": \"plain.field\", \"mask\": \"plain.ghost\""));
    let (hills, plain, height) = (id(&graph, "hills"), id(&graph, "plain"), id(&graph, "height"));
    graph.rename(hills, "ridge").unwrap();
    graph.rename(plain, "flat").unwrap();
    graph.rename(height, "sum_of_all").unwrap();
    assert_eq!(graph.find("hills"), None);
    assert_eq!(graph.find("ridge"), Some(hills));
    let text = canonical(&graph);
    for part in [
        r#""bind": ["ridge.amplitude"]"#,
        r#""a": "ridge.field", "b": "flat.field", "mask": "flat.ghost""#,
        r#""from": "sum_of_all.field""#,
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("hills.") && !text.contains("plain.") && !text.contains("height."), "{text}");
    // A node of a name that was missed picks its readers up.
    let mut graph = with_nodes(r#""s": {"kind": "sum", "in": {"a": "later.field"}}"#);
    let later = graph.add("now", "hills").unwrap();
    assert_eq!(graph.source(id(&graph, "s"), "a"), None);
    graph.rename(later, "later").unwrap();
    assert_eq!(graph.source(id(&graph, "s"), "a").unwrap().node, later);
}

#[test]
fn removing_leaves_what_can_be_mended() {
    let mut graph = load(EXAMPLE);
    let (hills, height) = (id(&graph, "hills"), id(&graph, "height"));
    graph.remove(hills).unwrap();
    assert_eq!(graph.exposed().count(), 0, "it bound nothing else");
    assert_eq!(errors(&graph), ["node `height`, input `a`: must be connected"]);
    graph.remove(height).unwrap();
    has(&errors(&graph), &["output `height`: reads `height.field`, but the graph has no node `height`"]);
    assert_eq!(graph.outputs().len(), 2);
    // The index of a removed node may be used again: the order of the file is still that of the edits.
    graph.add("first", "hills").unwrap();
    graph.add("second", "hills").unwrap();
    let names: Vec<_> = graph.nodes().map(|id| graph.node(id).name.clone()).collect();
    assert_eq!(names, ["plain", "first", "second"]);
    assert_eq!(canonical(&load(&canonical(&graph))), canonical(&graph));
}

#[test]
fn bridging_joins_what_was_changed_to_its_readers() {
    let mut graph = load(
        r#"{"orograph": 1, "nodes": {"hills": {"kind": "hills"}, "plain": {"kind": "constant"},
        "change": {"kind": "sum", "in": {"a": "hills.field", "b": "plain.field"}},
        "reader": {"kind": "sum", "in": {"a": "change.field", "b": "change.field"}}},
        "outputs": {"o": {"from": "change.field"}}}"#,
    );
    let (hills, reader) = (id(&graph, "hills"), id(&graph, "reader"));
    graph.remove_bridged(id(&graph, "change")).unwrap();
    for port in ["a", "b"] {
        assert_eq!(graph.source(reader, port).unwrap().node, hills);
    }
    assert_eq!(graph.output_source("o").unwrap().node, hills);
    assert_eq!(errors(&graph), [""; 0]);
    // A kind that changes nothing has nothing to join.
    graph.remove_bridged(hills).unwrap();
    assert_eq!(graph.source(reader, "a"), None);
}

#[test]
fn wires_are_replaced_and_taken_away() {
    let mut graph = load(EXAMPLE);
    let (hills, height) = (id(&graph, "hills"), id(&graph, "height"));
    graph.connect(hills, "field", height, "b").unwrap();
    assert_eq!(graph.inputs(height).count(), 2);
    assert_eq!(graph.consumers(hills).count(), 2);
    graph.disconnect(height, "a").unwrap();
    graph.disconnect(height, "a").unwrap();
    assert_eq!(graph.source(height, "a"), None);
    assert_eq!(errors(&graph), ["node `height`, input `a`: must be connected"]);
    let mut loose = with_nodes(r#""s": {"kind": "sum", "in": {"a": "x.y", "zz": 3}}"#);
    let s = id(&loose, "s");
    loose.disconnect(s, "zz").unwrap();
    loose.disconnect(s, "a").unwrap();
    assert_eq!(loose.node(s).unresolved().count(), 0);
}

#[test]
fn seeds_are_drawn_and_stay() {
    let mut graph = Graph::with_registry(registry());
    for name in ["a", "b", "c", "d"] {
        graph.add(name, "hills").unwrap();
    }
    graph.add_output("o", Output { from: "a.field".into(), ..Output::default() }).unwrap();
    assert_eq!(told(&graph), [""; 0], "no twins");
    let text = canonical(&graph);
    let again = load(&text);
    for id in graph.nodes() {
        assert_eq!(
            graph.node(id).set["seed"],
            again.node(again.find(&graph.node(id).name).unwrap()).set["seed"]
        );
    }
}

#[test]
fn resetting_gives_the_default_back() {
    let mut graph = load(EXAMPLE);
    let plain = id(&graph, "plain");
    graph.reset(plain, "value").unwrap();
    graph.reset(plain, "quantity").unwrap();
    assert!(graph.node(plain).set.is_empty());
    graph.reset(plain, "valu").unwrap_err();
    graph.set_terrain("width", json!(16384)).unwrap();
    assert_eq!(graph.terrain().width, 16384.0);
    graph.reset_terrain("width").unwrap();
    assert_eq!(canonical(&graph), EXAMPLE.replace(", \"set\": { \"value\": 12.5 }", ""));
}

#[test]
fn free_names_are_free() {
    let graph = load(EXAMPLE);
    assert_eq!(graph.free_name("hills"), "hills_2");
    assert_eq!(graph.free_name("new"), "new");
    assert_eq!(graph.free_name("Hügel!"), "node");
    assert_eq!(graph.free_name("terrain"), "terrain_2");
}

#[test]
fn the_id_of_a_node_that_is_gone_finds_no_other() {
    let mut graph = load(EXAMPLE);
    let before = graph.clone();
    let plain = id(&graph, "plain");
    graph.remove(plain).unwrap();
    let new = graph.add("plain", "constant").unwrap();
    assert_ne!(new, plain);
    assert!(graph.get(plain).is_none());
    assert_eq!(id(&before, "plain"), plain, "the state before has its own");
    // After an undo, too: what was added in between is another node than what is added then.
    let mut undone = before;
    undone.remove(plain).unwrap();
    assert_ne!(undone.add("plain", "constant").unwrap(), new);
    assert!(load(EXAMPLE).get(plain).is_none(), "another graph has other nodes");
}
