//! Notes, bends and nodes that are left out; parts of graphs as graphs.

use orograph::graph::{Graph, Note, NoteColor, Source};
use serde_json::{Value as Json, json};

use super::kinds::*;

fn chain() -> Graph {
    load(
        &json!({
            "orograph": 1,
            "nodes": {
                "hills": { "kind": "hills" },
                "plain": { "kind": "constant" },
                "height": {
                    "kind": "sum", "in": { "a": "hills.field", "b": "plain.field" },
                    "bends": [{ "in": "b", "at": [[10, 20], [30.5, 40]] }]
                }
            },
            "outputs": { "height": { "from": "height.field" } },
            "notes": { "lands": { "at": [-20, -30], "size": [400, 300], "title": "Lands", "color": "green" } }
        })
        .to_string(),
    )
}

fn file(graph: &Graph) -> Json {
    serde_json::from_str(&canonical(graph)).unwrap()
}

#[test]
fn notes_and_bends_are_read_and_written() {
    let mut graph = chain();
    assert_eq!(told(&graph), [""; 0]);
    let note = graph.note("lands").unwrap().clone();
    assert_eq!((note.title.as_str(), note.color), ("Lands", NoteColor::Green));
    let height = graph.find("height").unwrap();
    assert_eq!(graph.bends(height, "b"), [[10.0, 20.0], [30.5, 40.0]]);
    let written = file(&graph);
    assert_eq!(written["notes"]["lands"]["size"], json!([400, 300]));
    assert_eq!(written["nodes"]["height"]["bends"], json!([{ "in": "b", "at": [[10, 20], [30.5, 40]] }]));
    let name = graph.add_note(Note { text: "Mind the gap".into(), ..Note::default() }).unwrap();
    graph.change_note(&name, Note { text: "Mind the step".into(), ..Note::default() }).unwrap();
    assert_eq!(file(&graph)["notes"][&name]["text"], "Mind the step");
    graph.remove_note(&name).unwrap();
    graph.remove_note("lands").unwrap();
    assert_eq!(file(&graph).get("notes"), None);
}

#[test]
fn bends_go_with_their_wire() {
    let mut graph = chain();
    let [hills, height] = ["hills", "height"].map(|n| graph.find(n).unwrap());
    graph.connect(hills, "field", height, "b").unwrap();
    assert_eq!(graph.bends(height, "b"), [[0.0; 2]; 0]);
    graph.set_bends(height, "b", vec![[1.0, 2.0]]).unwrap();
    graph.disconnect(height, "b").unwrap();
    assert_eq!(file(&graph)["nodes"]["height"].get("bends"), None);
    assert!(graph.set_bends(height, "b", vec![[1.0, 2.0]]).is_err(), "no wire, no bends");
}

#[test]
fn a_wrong_note_is_kept_and_stops_nothing() {
    let mut written = file(&chain());
    written["notes"]["lands"]["size"] = json!("large");
    written["notes"]["lands"]["mood"] = json!("calm");
    let graph = load(&written.to_string());
    assert_eq!(errors(&graph), [""; 0]);
    assert_eq!(told(&graph).len(), 2, "{:?}", told(&graph));
    assert_eq!(file(&graph)["notes"]["lands"]["mood"], "calm");
    assert_eq!(file(&graph)["notes"]["lands"]["size"], "large");
}

#[test]
fn what_is_left_out_passes_on_what_it_would_change() {
    let mut graph = chain();
    let [hills, height] = ["hills", "height"].map(|n| graph.find(n).unwrap());
    let out = Source { node: height, port: "field".into() };
    graph.set_bypass(height, true).unwrap();
    assert_eq!(graph.passed(out.clone()), Some(Source { node: hills, port: "field".into() }));
    assert_eq!(file(&graph)["nodes"]["height"]["bypass"], true);
    assert_eq!(errors(&graph), [""; 0]);
    graph.disconnect(height, "a").unwrap();
    assert_eq!(graph.passed(out), None);
    let all = errors(&graph).join("\n");
    assert!(all.contains("`height.field`, which is bypassed and has nothing to pass on"), "{all}");
    let refused = graph.set_bypass(hills, true).unwrap_err().to_string();
    assert_eq!(refused, "node `hills`: cannot be bypassed: `hills` changes no input");
    graph.set_bypass(height, false).unwrap();
    assert_eq!(file(&graph)["nodes"]["height"].get("bypass"), None);
}

#[test]
fn a_part_is_a_graph_and_can_be_put_into_another() {
    let graph = chain();
    let [plain, height] = ["plain", "height"].map(|n| graph.find(n).unwrap());
    let part = graph.fragment(&[height, plain], &["lands".into()]);
    let text = canonical(&part);
    let part = load(&text);
    assert_eq!(part.nodes().len(), 2);
    let own = part.find("height").unwrap();
    assert_eq!(part.source(own, "b").map(|s| s.node), part.find("plain"));
    assert_eq!((part.source(own, "a"), part.outputs().len()), (None, 0));
    let mut other = chain();
    let new = other.graft(&part, [100.0, -5.0]).unwrap();
    let names: Vec<_> = new.nodes.iter().map(|id| other.node(*id).name.as_str()).collect();
    assert_eq!(names, ["plain_2", "height_2"]);
    let copy = new.nodes[1];
    assert_eq!(other.source(copy, "b").map(|s| s.node), Some(new.nodes[0]));
    assert_eq!(other.bends(copy, "b"), [[110.0, 15.0], [130.5, 35.0]]);
    assert_eq!(other.note(&new.notes[0]).unwrap().at, [80.0, -35.0]);
    assert_eq!(load(&canonical(&other)).nodes().len(), 5);
}

#[test]
fn unknown_kinds_travel_with_their_versions() {
    let text = json!({
        "orograph": 1, "kinds": { "fold": 4 },
        "nodes": { "f": { "kind": "fold", "set": { "depth": 3 } } }, "outputs": {}
    });
    let graph = load(&text.to_string());
    let part = graph.fragment(&[graph.find("f").unwrap()], &[]);
    let mut other = chain();
    other.graft(&load(&canonical(&part)), [0.0; 2]).unwrap();
    assert_eq!(file(&other)["kinds"]["fold"], 4);
    assert_eq!(file(&other)["nodes"]["f"]["set"], json!({ "depth": 3 }));
}
