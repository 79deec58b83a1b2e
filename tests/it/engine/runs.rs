//! Which nodes run, and what their keys depend on (law 7).

use orograph::graph::Graph;
use serde_json::json;

use super::{bits, chain, engine, evaluate, field, graph, grid, ran};
use crate::kinds::registry;

#[test]
fn bypassed_nodes_do_not_run_and_change_no_key() {
    let (mut g, e) = (chain(), engine(2));
    let whole = grid(&g, 129);
    let rough = field(&evaluate(&e, &g, "rough", whole), 0);
    let soft = g.find("soft").unwrap();
    g.set_bypass(soft, true).unwrap();
    let passed = evaluate(&e, &g, "soft", whole);
    assert_eq!(bits(&field(&passed, 0)), bits(&rough));
    assert_eq!(ran(&passed), [""; 0], "what passes is in the cache already");
    let dug = g.find("dug").unwrap();
    let left_out = e.key(&g, dug);
    g.remove_bridged(soft).unwrap();
    assert_eq!(e.key(&g, dug), left_out, "as if it were not there");
    let hills = g.find("hills").unwrap();
    assert!(g.set_bypass(hills, true).is_err());
}

#[test]
fn nodes_upstream_of_a_want_run_once_and_no_others() {
    let (g, e) = (chain(), engine(2));
    let soft = evaluate(&e, &g, "soft", grid(&g, 129));
    assert_eq!(ran(&soft), ["detail", "hills", "rough", "soft"]);
    assert_eq!(soft.tasks.len(), 4, "each ran once: {:?}", soft.tasks);
    let again = evaluate(&e, &g, "soft", grid(&g, 129));
    assert_eq!(ran(&again), [""; 0]);
    assert_eq!(again.tasks.len(), 1, "what is cached asks for nothing");
    assert_eq!(field(&soft, 0), field(&again, 0));
}

#[test]
fn changes_run_only_the_nodes_downstream() {
    let (mut g, e) = (chain(), engine(2));
    evaluate(&e, &g, "end", grid(&g, 129));
    g.assign("dug.depth", "20").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), ["dug", "end", "spread"]);
    g.assign("dug.depth", "50").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), [""; 0], "the old value is still there");
    let hills = g.find("hills").unwrap();
    g.rename(hills, "mountains").unwrap();
    g.move_to(hills, [500.0, -20.0]).unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), [""; 0], "names and places are in no key");
    g.assign("terrain.sea_level", "12").unwrap();
    // `dug` declares that it reads the terrain; nothing else does.
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), ["dug", "end", "spread"]);
    g.assign("terrain.seed", "4").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "soft", grid(&g, 129))), ["detail", "mountains", "rough", "soft"]);
}

#[test]
fn keys_hold_the_values_of_parameters_not_their_text() {
    let e = engine(1);
    let make = |set: &str| {
        let text = format!(r#"{{"orograph":1,"nodes":{{"a":{{"kind":"waves","set":{set}}}}}}}"#);
        let g = Graph::from_bytes(text.as_bytes(), &registry()).unwrap();
        e.key(&g, g.find("a").unwrap()).unwrap()
    };
    let plain = make(r#"{"height":0,"length":700}"#);
    for same in
        [r#"{"length":700.0,"height":0.0}"#, r#"{"height":-0.0}"#, r#"{"height":0e5,"length":7e2,"seed":1}"#]
    {
        assert_eq!(make(same), plain, "{same}");
    }
    assert_ne!(make(r#"{"height":1e-9}"#), plain);
}

#[test]
fn chains_of_a_thousand_nodes_evaluate() {
    let mut nodes = serde_json::Map::new();
    nodes.insert("n0".into(), json!({ "kind": "waves" }));
    for i in 1..1000 {
        nodes.insert(
            format!("n{i}"),
            json!({ "kind": "copy", "in": { "field": format!("n{}.field", i - 1) } }),
        );
    }
    let g = graph(nodes.into());
    let deep = evaluate(&engine(2), &g, "n999", grid(&g, 17));
    assert_eq!(deep.tasks.len(), 1000);
    assert!(deep.values[0].is_ok());
}

#[test]
fn unused_inputs_of_a_switch_do_not_run_and_are_in_no_key() {
    let mut g = graph(json!({
        "hills": { "kind": "waves" },
        "bad": { "kind": "not_a_number" },
        "either": { "kind": "switch", "in": { "a": "hills.field", "b": "bad.field" } },
    }));
    let e = engine(1);
    let taken = evaluate(&e, &g, "either", grid(&g, 65));
    assert_eq!(ran(&taken), ["either", "hills"]);
    let key = e.key(&g, g.find("either").unwrap());
    let (either, other) = (g.find("either").unwrap(), g.find("hills").unwrap());
    g.connect(other, "field", either, "b").unwrap();
    assert_eq!(e.key(&g, either), key);
    g.assign("either.choice", "1").unwrap();
    assert_ne!(e.key(&g, either), key);
}
