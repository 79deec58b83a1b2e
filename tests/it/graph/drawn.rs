//! Drawings of many numbers: a movement of a hand changes one of them, and the rest stays as it is and is shared.

use orograph::engine::{Engine, Files, Options};
use orograph::graph::{Graph, NodeId};
use orograph::kit::paint::Stroke;
use serde_json::{Value as Json, json};

fn strokes() -> Json {
    let path = |k: usize| (0..40).map(|i| json!((i * 7 + k) as f64 * 0.5)).map(tidy).collect::<Vec<_>>();
    (0..5).map(|k| json!({ "path": path(k), "radius": 60, "value": 0.25 })).collect()
}

/// Writes whole numbers without a point, as the file does.
fn tidy(json: Json) -> Json {
    let number = json.as_f64().unwrap();
    if number == number.trunc() { json!(number as i64) } else { json }
}

fn painted(strokes: Json) -> (Graph, NodeId) {
    let mut graph = Graph::new();
    let paint = graph.add("paint", "paint_mask").unwrap();
    graph.set(paint, "strokes", strokes).unwrap();
    (graph, paint)
}

fn key(graph: &Graph, node: NodeId) -> String {
    let engine = Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).unwrap();
    engine.key(graph, node).unwrap().to_string()
}

#[test]
fn a_part_of_a_drawing_is_set_like_the_whole() {
    let (first, paint) = painted(strokes());
    let parts: [(&str, &str, Json); 6] = [
        ("strokes.3.path.11", "/3/path/11", json!(17.25)),
        ("strokes.3.path.11", "/3/path/11", json!(-4)),
        ("strokes.0.path", "/0/path", json!([1, 2.5, 3, 4])),
        ("strokes.4.radius", "/4/radius", json!(80)),
        ("strokes.2.strength", "/2/strength", json!(0.5)),
        ("strokes.1", "/1", json!({ "path": [], "radius": 5 })),
    ];
    let mut moved = first.clone();
    let mut written = strokes();
    for (path, pointer, value) in parts {
        moved.set(paint, path, value.clone()).unwrap();
        match written.pointer_mut(pointer) {
            Some(place) => *place = value,
            None => written[2]["strength"] = value,
        }
        let (whole, other) = painted(written.clone());
        assert_eq!(moved.node(paint).set["strokes"], written, "{path}");
        assert_eq!(moved.canonical(), whole.canonical(), "{path}");
        assert_eq!(key(&moved, paint), key(&whole, other), "{path}");
        let read: Vec<Stroke> = moved.node(paint).set.read("strokes").unwrap().unwrap();
        assert_eq!(read, serde_json::from_value::<Vec<Stroke>>(written.clone()).unwrap(), "{path}");
    }
    assert_eq!(first.node(paint).set["strokes"], strokes(), "the copy in the history kept its own");
    assert!(moved.problems().iter().all(|p| !p.is_error()), "{:?}", moved.problems());
}

#[test]
fn a_part_of_a_drawing_that_does_not_fit_is_refused() {
    let (mut graph, paint) = painted(strokes());
    let before = graph.edits();
    for (path, value, message) in [
        ("strokes.3.path.11", json!("far"), "must be a number from -100000000 to 100000000, got \"far\""),
        ("strokes.3.path.11", json!(1e9), "must be a number from -100000000 to 100000000, got 1000000000"),
        ("strokes.3.path.40", json!(1), "has no item `40`; it has 40, counted from 0"),
        ("strokes.5.path.0", json!(1), "has no item `5`; it has 5, counted from 0"),
        ("strokes.3.path.1.2", json!(1), "has nothing inside it, so no `2`"),
        ("strokes.3.width", json!(1), "has no `width`; it has"),
    ] {
        let refused = graph.set(paint, path, value).unwrap_err().to_string();
        assert!(refused.contains(message), "{path}: {refused}");
    }
    let odd = json!([{ "path": [1, 2, 3], "radius": 5 }]);
    graph.set(paint, "strokes", odd).unwrap();
    let problems: Vec<_> = graph.problems().iter().map(ToString::to_string).collect();
    assert!(problems.iter().any(|p| p.contains("stroke 0: `path` must list x, y")), "{problems:?}");
    assert_eq!(graph.edits(), before + 1, "what is refused changes nothing");
    graph.set(paint, "strokes.0.path", json!([1, 2, 3])).unwrap();
    assert_eq!(graph.edits(), before + 1, "and so does what is there already");
}

#[test]
fn numbers_of_a_drawing_are_written_as_they_were() {
    let path = json!([0, -1, 2.5, 1e8, -0.1, 0.30000000000000004, 12345678, 1e-300]);
    let (graph, paint) = painted(json!([{ "path": path, "radius": 5 }]));
    assert_eq!(
        graph.node(paint).set["strokes"][0]["path"].to_string(),
        "[0,-1,2.5,100000000,-0.1,0.30000000000000004,12345678,1e-300]"
    );
    let again = Graph::from_bytes(&graph.canonical(), graph.registry()).unwrap();
    assert_eq!(again.canonical(), graph.canonical());
    assert_eq!(key(&again, again.find("paint").unwrap()), key(&graph, paint));
}
