//! The kinds of river networks through the engine: what they refuse, what they warn of, what they give for nothing.

use orograph::engine::{Engine, Evaluation, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::{Ridges, Rivers};
use serde_json::{Value as Json, json};

/// The chain of kinds, the first of them set.
fn evaluate(set: &Json, spacing: f64) -> Evaluation {
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 8192, "depth": 4096, "base": 513 },
        "nodes": {
            "rivers": { "kind": "tokunaga_rivers", "set": set },
            "filled": { "kind": "infill_rivers", "in": { "rivers": "rivers.rivers" }, "set": { "spacing": spacing } },
            "beds": { "kind": "river_profile", "in": { "rivers": "filled.rivers" } },
            "ridges": { "kind": "voronoi_ridges", "in": { "rivers": "beds.rivers" } },
        },
        "outputs": {},
    });
    let graph = Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).unwrap();
    let want = |node: &str, port: &str| Want {
        node: graph.find(node).unwrap(),
        port: port.into(),
        grid: graph.terrain().grid(33).unwrap(),
    };
    let wants = [want("rivers", "rivers"), want("beds", "rivers"), want("ridges", "ridges")];
    let engine = Engine::new(&Options { threads: 2, ..Options::default() }, Files::default()).unwrap();
    engine.evaluate(&graph, &wants, &Unobserved, &Cancel::default()).unwrap()
}

fn warnings(evaluation: &Evaluation, node: &str) -> Vec<String> {
    evaluation.tasks.iter().filter(|task| task.node == node).flat_map(|task| task.warnings.clone()).collect()
}

fn failure(set: &Json) -> String {
    evaluate(set, 300.0).values[0].as_ref().unwrap_err().to_string()
}

#[test]
fn rivers_nodes_give_a_drained_skeleton_by_default() {
    let found = evaluate(&json!({}), 300.0);
    let values: Vec<_> = found.values.iter().map(|value| value.as_ref().unwrap()).collect();
    let [plain, beds] = [0, 1].map(|i| values[i].object::<Rivers>().unwrap());
    let ridges = values[2].object::<Ridges>().unwrap();
    assert!(plain.len() > 10 && beds.len() > plain.len() && !ridges.is_empty());
    for (upper, lower) in beds.links() {
        assert!(beds.vertices()[upper].height > beds.vertices()[lower].height);
        assert!(beds.vertices()[upper].area <= beds.vertices()[lower].area);
    }
    let area: f64 = plain.outlets().map(|i| f64::from(plain.vertices()[i].area)).sum();
    assert!((area / (8192.0 * 4096.0) - 1.0).abs() < 1e-6, "{area}");
}

#[test]
fn no_line_gives_an_empty_network_and_a_warning() {
    let found = evaluate(&json!({ "lines": [] }), 300.0);
    let values: Vec<_> = found.values.iter().map(|value| value.as_ref().unwrap()).collect();
    assert_eq!(values[0].object::<Rivers>(), Some(&Rivers::default()));
    assert_eq!(values[1].object::<Rivers>(), Some(&Rivers::default()));
    assert_eq!(values[2].object::<Ridges>(), Some(&Ridges::default()));
    assert_eq!(warnings(&found, "rivers"), ["there is no line, so there is no river"]);
}

#[test]
fn bad_lines_are_refused_by_name_and_number() {
    for (lines, want) in [
        (json!([[100, 100, 900, 900], [5, 5, 5, 5]]), "parameter `lines` line 1 has no length"),
        (
            json!([[100, 100, 9000, 900]]),
            "parameter `lines` line 0 must lie inside the terrain, got [9000.0, 900.0]",
        ),
        (
            json!([[100, 100, 900, 900], [7, 8, 9, 9], [100, 100, 5, 5]]),
            "parameter `lines` line 2 starts where line 0 does",
        ),
    ] {
        let said = failure(&json!({ "lines": lines }));
        assert!(said.contains(want), "{said}");
    }
}

#[test]
fn too_many_links_are_refused_with_their_count() {
    let said = failure(
        &json!({ "max_depth": 12, "branching": { "generator": { "phi": 8 } }, "lines": [[0, 0, 8000, 0]] }),
    );
    assert!(
        said.contains("parameter `max_depth` asks for about") && said.contains("at most 4000000"),
        "{said}"
    );
    let dense = evaluate(&json!({}), 1.0).values[1].as_ref().unwrap_err().to_string();
    assert!(dense.contains("parameter `spacing` asks for about"), "{dense}");
}

#[test]
fn spacings_under_eight_base_cells_earn_a_warning() {
    assert_eq!(warnings(&evaluate(&json!({}), 130.0), "filled"), [""; 0]);
    let said = warnings(&evaluate(&json!({}), 120.0), "filled");
    assert!(
        said.len() == 1 && said[0].contains("`spacing` is 120 m; below eight cells of the base grid, 128 m"),
        "{said:?}"
    );
}

#[test]
fn branches_without_room_are_counted_in_a_warning() {
    let crowded = json!({ "max_depth": 8, "clearance": 0.6, "branching": { "generator": { "phi": 4 } } });
    let said = warnings(&evaluate(&crowded, 300.0), "rivers");
    assert!(said.len() == 1 && said[0].ends_with("branches are left out for want of room"), "{said:?}");
}
