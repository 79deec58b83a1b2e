//! Parameters by name: `--set`, exposed parameters, dotted paths.

use orograph::graph::{Exposed, Graph};
use orograph::params::Shape;
use serde_json::json;

use super::kinds::*;

fn refused(graph: &mut Graph, name: &str, text: &str, message: &str) {
    let before = canonical(graph);
    assert_eq!(graph.assign(name, text).unwrap_err().to_string(), message);
    assert_eq!(canonical(graph), before, "a refused edit changes nothing");
}

#[test]
fn set_reaches_exposed_names_nodes_and_the_terrain() {
    let mut graph = load(EXAMPLE);
    let hills = id(&graph, "hills");
    graph.assign("ruggedness", "200").unwrap();
    assert_eq!(graph.node(hills).set["amplitude"], 200);
    graph.assign("hills.octaves", "3").unwrap();
    graph.assign("plain.quantity", "mask").unwrap();
    graph.assign("hills.scale", "12.5").unwrap();
    graph.assign("hills.scale", "null").unwrap();
    graph.assign("height.minus", "false").unwrap();
    graph.assign("terrain.width", "4096").unwrap();
    graph.assign("terrain.origin", "[-5, 7.5]").unwrap();
    graph.assign("terrain.origin.1", "8").unwrap();
    graph.assign("terrain.geo", r#"{"epsg": 32611, "east": 1, "north": 2}"#).unwrap();
    graph.assign("terrain.geo.north", "3").unwrap();
    graph.assign_json("terrain.depth", &json!(2048)).unwrap();
    let terrain = graph.terrain();
    assert_eq!((terrain.width, terrain.depth, terrain.origin), (4096.0, 2048.0, [-5.0, 8.0]));
    assert_eq!(terrain.geo.unwrap().north, 3.0);
    assert_eq!(errors(&graph), [""; 0]);
    assert_eq!(load(&canonical(&graph)).terrain(), terrain);
}

#[test]
fn slips_are_told_with_the_nearest_name() {
    let mut graph = load(EXAMPLE);
    let g = &mut graph;
    refused(
        g,
        "rugedness",
        "3",
        "exposed `rugedness`: is no name that this graph exposes (exposed: `ruggedness`), and no `node.parameter`; did you mean `ruggedness`?",
    );
    refused(
        g,
        "octaves",
        "3",
        "exposed `octaves`: is no name that this graph exposes (exposed: `ruggedness`), and no `node.parameter`; did you mean `hills.octaves`?",
    );
    refused(
        g,
        "width",
        "3",
        "exposed `width`: is no name that this graph exposes (exposed: `ruggedness`), and no `node.parameter`; did you mean `terrain.width`?",
    );
    refused(g, "hils.octaves", "3", "node `hils`: is not in the graph; did you mean `hills`?");
    refused(
        g,
        "hills.octavs",
        "3",
        "node `hills`, parameter `octavs`: is not one of this kind's: `amplitude`, `octaves`, `mode`, `scale`, `points`, `seed`; did you mean `octaves`?",
    );
    refused(
        g,
        "hills.octaves",
        "17",
        "node `hills`, parameter `octaves`: must be a whole number from 1 to 16, got 17",
    );
    refused(
        g,
        "hills.octaves",
        "2.5",
        "node `hills`, parameter `octaves`: must be a whole number from 1 to 16, got 2.5",
    );
    refused(
        g,
        "hills.octaves",
        "NaN",
        "node `hills`, parameter `octaves`: must be a whole number from 1 to 16, got \"NaN\"",
    );
    refused(
        g,
        "hills.amplitude",
        "5",
        "node `hills`, parameter `amplitude`: is exposed as `ruggedness`: set that",
    );
    refused(g, "ruggedness", "401", "exposed `ruggedness`: must be a number from 0 to 400, got 401");
    refused(g, "terrain.width", "0", "terrain, setting `width`: must be a number from 1 to 20000000, got 0");
    refused(
        g,
        "terrain.widht",
        "0",
        "terrain, setting `widht`: is not one of the terrain's: `origin`, `width`, `depth`, `sea_level`, `seed`, `base`, `geo`; did you mean `width`?",
    );
    refused(
        g,
        "",
        "0",
        "exposed ``: is no name that this graph exposes (exposed: `ruggedness`), and no `node.parameter`",
    );
    refused(
        g,
        "hills.",
        "0",
        "node `hills`, parameter ``: is not one of this kind's: `amplitude`, `octaves`, `mode`, `scale`, `points`, `seed`",
    );
}

#[test]
fn paths_lead_into_modes_and_lists() {
    let mut graph = load(EXAMPLE);
    let g = &mut graph;
    refused(
        g,
        "hills.mode.turned.angle",
        "30",
        "node `hills`, parameter `mode.turned.angle`: is in the mode `plain`, not in `turned`: set the mode first",
    );
    g.assign("hills.mode", r#"{"turned": {"angle": 10}}"#).unwrap();
    g.assign("hills.mode.turned.angle", "30").unwrap();
    g.assign("hills.points.1.0", "0.5").unwrap();
    let hills = id(g, "hills");
    assert_eq!(g.node(hills).set["mode"], json!({"turned": {"angle": 30}}));
    assert_eq!(g.node(hills).set["points"], json!([[0.0, 0.0], [0.5, 1.0]]), "from the default");
    refused(
        g,
        "hills.mode.turned.angle",
        "361",
        "node `hills`, parameter `mode.turned.angle`: must be a number from -360 to 360, got 361",
    );
    refused(
        g,
        "hills.mode.turnt.angle",
        "3",
        "node `hills`, parameter `mode.turnt.angle`: has no mode `turnt`; it has `plain`, `turned`; did you mean `turned`?",
    );
    refused(
        g,
        "hills.mode.turned.angel",
        "3",
        "node `hills`, parameter `mode.turned.angel`: has no `angel`; it has `angle`; did you mean `angle`?",
    );
    refused(
        g,
        "hills.mode.turned",
        "3",
        "node `hills`, parameter `mode.turned`: has `turned` as a mode, not as a setting: set one of `angle` in it",
    );
    refused(
        g,
        "hills.points.7.0",
        "0.5",
        "node `hills`, parameter `points.7.0`: has no item `7`; it has 2, counted from 0",
    );
    g.expose("turn", Exposed::of("hills.mode.turned.angle")).unwrap();
    refused(g, "hills.mode", "plain", "node `hills`, parameter `mode`: is exposed as `turn`: set that");
    g.assign("turn", "45").unwrap();
    assert_eq!(g.node(hills).set["mode"], json!({"turned": {"angle": 45}}));
    assert_eq!(errors(g), [""; 0]);
    let deep = format!("hills.{}", "x.".repeat(40));
    assert!(g.assign(&deep, "1").unwrap_err().to_string().contains("is a path of 41 steps, the limit is 16"));
}

#[test]
fn an_exposed_parameter_is_what_its_binds_are() {
    let mut graph = load(EXAMPLE);
    let other = graph.add("other", "hills").unwrap();
    let param = graph.exposed_param("ruggedness").unwrap();
    assert_eq!(param.shape, Shape::Number { min: 0.0, max: 400.0, integer: false });
    assert_eq!(
        (param.unit.as_deref(), param.default, param.doc.as_str()),
        (Some("m"), json!(120), "Height.")
    );
    graph
        .expose(
            "layers",
            Exposed { bind: vec!["hills.octaves".into(), "other.octaves".into()], ..Exposed::default() },
        )
        .unwrap();
    assert_eq!(graph.exposed().nth(1).unwrap().1.value, 8);
    graph.set_exposed("layers", json!(5.0)).unwrap();
    assert_eq!(graph.node(other).set["octaves"], 5);
    assert_eq!(graph.node(id(&graph, "hills")).set["octaves"], 5);
    let told = |graph: &mut Graph, name: &str, exposed: Exposed| {
        graph.expose(name, exposed).unwrap_err().to_string()
    };
    let g = &mut graph;
    assert_eq!(told(g, "layers", Exposed::of("hills.seed")), "exposed `layers`: is exposed already");
    assert_eq!(
        told(g, "x", Exposed::of("hills.octaves")),
        "exposed `x`: cannot bind `hills.octaves`: it is exposed as `layers` already"
    );
    assert_eq!(told(g, "x", Exposed::default()), "exposed `x`: binds nothing");
    assert_eq!(
        told(g, "x", Exposed::of("octaves")),
        "exposed `x`: cannot bind `octaves`: it must be written as `node.parameter`"
    );
    assert_eq!(
        told(g, "X", Exposed::of("hills.seed")),
        "exposed `X`: must have a name of 1 to 64 of the characters a to z, 0 to 9 and _"
    );
    let mixed = Exposed { bind: vec!["height.minus".into(), "hills.seed".into()], ..Exposed::default() };
    assert_eq!(
        told(g, "x", mixed),
        "exposed `x`: binds `hills.seed`, whose values are of another kind or range than those before"
    );
    let limits = Exposed { min: Some(6e3), ..Exposed::of("other.amplitude") };
    assert_eq!(
        told(g, "x", limits),
        "exposed `x`: allows no value: `min` and `max` give 6000 to 5000, and its parameters take 0 to 5000"
    );
    let limits = Exposed { min: Some(1.0), ..Exposed::of("height.minus") };
    assert_eq!(told(g, "x", limits), "exposed `x`: has `min` or `max`, but its values are no numbers");
    // One may be null, the other not: together they may not.
    let both = Exposed {
        bind: vec!["hills.scale".into(), "other.amplitude".into()],
        value: json!(5),
        ..Exposed::default()
    };
    g.expose("both", both).unwrap();
    assert_eq!(
        g.exposed_param("both").unwrap().shape,
        Shape::Number { min: 0.1, max: 5000.0, integer: false }
    );
    g.expose("sea", Exposed::of("terrain.sea_level")).unwrap();
    g.assign("sea", "-20").unwrap();
    assert_eq!(g.terrain().sea_level, Some(-20.0));
    g.unexpose("sea").unwrap();
    g.assign("terrain.sea_level", "-21").unwrap();
    g.change_exposed("layers", Exposed { label: "Layers".into(), ..Exposed::of("hills.octaves") }).unwrap();
    let other = id(g, "other");
    g.set(other, "octaves", json!(2)).unwrap();
    assert_eq!(errors(g), [""; 0]);
    assert_eq!(canonical(&load(&canonical(g))), canonical(g));
}

#[test]
fn an_exposed_value_counts_more_than_what_the_node_says() {
    let text = EXAMPLE.replace("\"value\": 120", "\"value\": 150");
    let mut graph = load(&text);
    assert_eq!(
        told(&graph),
        [
            "node `hills`, parameter `amplitude`: is written as 120, but exposed as `ruggedness` with 150, which counts"
        ]
    );
    assert_eq!(graph.node(id(&graph, "hills")).set["amplitude"], 150);
    assert_eq!(graph.to_bytes(), text.as_bytes());
    graph.move_to(id(&graph, "plain"), [0.0, 121.0]).unwrap();
    assert_eq!(told(&graph), [""; 0], "what is written now agrees");
    // Without a value it takes over what the node says.
    let graph = load(&EXAMPLE.replace("\"value\": 120, ", ""));
    assert_eq!(canonical(&graph), EXAMPLE);
    // A broken one changes nothing, and stops what it would set.
    let graph = load(&EXAMPLE.replace("\"value\": 120", "\"value\": 500"));
    assert_eq!(graph.node(id(&graph, "hills")).set["amplitude"], 120);
    let problem = graph.problems().remove(0);
    assert_eq!(problem.to_string(), "exposed `ruggedness`: must be a number from 0 to 400, got 500");
    assert_eq!(problem.blames(), graph.find("hills"));
}

#[test]
fn an_exposed_null_is_a_value() {
    let graph = load(
        r#"{"orograph": 1, "expose": {"s": {"bind": ["a.scale"], "value": null}}, "nodes": {"a": {"kind": "hills", "set": {"scale": 5}}}}"#,
    );
    assert_eq!(graph.node(id(&graph, "a")).set["scale"], json!(null));
    let graph = load(
        r#"{"orograph": 1, "expose": {"s": {"bind": ["a.scale"]}}, "nodes": {"a": {"kind": "hills", "set": {"scale": 5}}}}"#,
    );
    assert_eq!(graph.exposed().next().unwrap().1.value, json!(5));
    let mut graph = graph;
    graph.assign("s", "null").unwrap();
    assert_eq!(graph.node(id(&graph, "a")).set["scale"], json!(null));
    graph.assign("s", "7").unwrap();
    assert_eq!(graph.node(id(&graph, "a")).set["scale"], json!(7));
    graph.assign("s", "null").unwrap();
    let again = load(&canonical(&graph));
    assert_eq!(
        again.node(id(&again, "a")).parse().map(|n| n.canonical()),
        graph.node(id(&graph, "a")).parse().map(|n| n.canonical())
    );
    assert_eq!(canonical(&load(&canonical(&graph))), canonical(&graph));
}

/// Found by fuzzing: an exposed parameter that an edit mends took its value over only when it was read again.
#[test]
fn an_edit_that_mends_an_exposed_parameter_gives_it_its_value() {
    for value in ["", r#", "value": null"#] {
        let mut graph = load(&format!(
            r#"{{"orograph": 1, "expose": {{"e": {{"bind": ["a.octaves", "b.octaves"]{value}}}, "s": {{"bind": ["a.scale", "b.scale"]{value}}}}},
            "nodes": {{"a": {{"kind": "unknown"}}, "b": {{"kind": "hills", "set": {{"octaves": 3, "scale": 9}}}}}}}}"#
        ));
        graph.remove(id(&graph, "a")).unwrap();
        let values: Vec<_> = graph.exposed().map(|(_, e)| e.value.clone()).collect();
        assert_eq!(values, [json!(3), json!(9)]);
        assert_eq!(canonical(&load(&canonical(&graph))), canonical(&graph));
    }
}
