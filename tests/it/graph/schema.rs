//! The published schema agrees with the reader.

use serde_json::{Value as Json, json};

use super::kinds::*;

fn faults(file: &Json) -> Vec<String> {
    let schema = orograph::graph::schema(&registry());
    let validator = jsonschema::validator_for(&schema).unwrap_or_else(|e| panic!("{e}"));
    validator.iter_errors(file).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

#[test]
fn good_files_pass() {
    let mut file: Json = serde_json::from_str(EXAMPLE).unwrap();
    assert_eq!(faults(&file), [""; 0]);
    file["nodes"]["hills"]["set"]["mode"] = json!({"turned": {"angle": 3}});
    file["nodes"]["hills"]["set"]["scale"] = Json::Null;
    file["nodes"]["hills"]["set"]["points"] = json!([[0, 0], [1, 1]]);
    file["terrain"]["geo"] = json!({"epsg": 32611, "east": 0, "north": 0});
    assert_eq!(faults(&file), [""; 0]);
    assert_eq!(errors(&load(&file.to_string())), [""; 0]);
}

/// Every kind of the program: made, written, read and checked by reader and schema.
#[test]
fn every_kind_can_be_made_and_written() {
    let registry = orograph::nodes::Registry::standard();
    let schema = orograph::graph::schema(&registry);
    let validator = jsonschema::validator_for(&schema).unwrap_or_else(|e| panic!("{e}"));
    for kind in registry.iter() {
        let mut graph = orograph::graph::Graph::new();
        let id = graph.add("node", &kind.id).unwrap();
        let mut left_out = Vec::new();
        for port in kind.inputs.iter() {
            if port.wire == orograph::value::WireType::Field {
                let name = format!("in_{}", port.name);
                let from = graph.add(&name, "constant").unwrap();
                graph.connect(from, "field", id, &port.name).unwrap();
            } else {
                left_out.push(port.name.to_string());
            }
        }
        // Written in full, the defaults fit as well.
        for param in kind.params() {
            if graph.set(id, &param.name, param.default.clone()).is_err() {
                panic!("{}: the default of {} does not fit", kind.id, param.name);
            }
        }
        let unexpected = |p: &&orograph::graph::Problem| {
            let is_left_out = matches!(&p.place, orograph::graph::Place::Input { port, .. } if left_out.iter().any(|name| name == port));
            p.is_error() && !is_left_out
        };
        let problems = graph.problems();
        assert_eq!(problems.iter().find(unexpected), None, "{}", kind.id);
        let mut file: Json = serde_json::from_slice(&graph.canonical()).unwrap();
        let set: serde_json::Map<_, _> =
            kind.params().iter().map(|p| (p.name.clone(), p.default.clone())).collect();
        file["nodes"]["node"]["set"] = set.into();
        let faults: Vec<_> =
            validator.iter_errors(&file).map(|e| format!("{}: {e}", e.instance_path())).collect();
        if left_out.is_empty() {
            assert_eq!(faults, [""; 0], "{}", kind.id);
        }
        let text = String::from_utf8(graph.canonical()).unwrap();
        let again = orograph::graph::Graph::from_bytes(text.as_bytes(), &registry).unwrap();
        assert_eq!(again.canonical(), graph.canonical());
    }
}

#[test]
fn shipped_graphs_pass() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("graphs");
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let file: Json = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(faults(&file), [""; 0], "{}", path.display());
    }
}

#[test]
fn every_fault_that_a_schema_can_see_is_seen() {
    let good: Json = serde_json::from_str(EXAMPLE).unwrap();
    let cases: &[(&str, Json, &str)] = &[
        ("/orograph", json!(2), "/orograph"),
        ("/nodes/hills/kind", json!("hils"), "/nodes/hills/kind"),
        ("/nodes/hills/set/amplitude", json!(-1), "/nodes/hills/set/amplitude"),
        ("/nodes/hills/set/octavs", json!(1), "/nodes/hills/set"),
        ("/nodes/hills/set/mode", json!({"turned": {"angle": 999}}), "/nodes/hills/set/mode"),
        ("/nodes/hills/inn", json!({}), "/nodes/hills"),
        ("/nodes/hills/at", json!([1]), "/nodes/hills/at"),
        ("/nodes/height/in/a", json!("hills"), "/nodes/height/in/a"),
        ("/nodes/height/in/c", json!("hills.field"), "/nodes/height/in"),
        ("/nodes/height/in", json!({"b": "hills.field"}), "/nodes/height/in"),
        ("/nodes/height", json!({"kind": "sum"}), "/nodes/height"),
        ("/nodes/height/backend", json!("fpga"), "/nodes/height/backend"),
        ("/nodes/Hills", json!({"kind": "hills"}), "/nodes"),
        ("/outputs/height/format", json!("jpg"), "/outputs/height/format"),
        ("/outputs/height/target", json!("unrael"), "/outputs/height/target"),
        ("/outputs/height/range", json!([1]), "/outputs/height/range"),
        ("/outputs/bad", json!({}), "/outputs/bad"),
        ("/expose/ruggedness/bind", json!([]), "/expose/ruggedness/bind"),
        ("/terrain/base", json!(1_000_000), "/terrain/base"),
        ("/terrain/wdth", json!(1), "/terrain"),
        ("/titel", json!("x"), ""),
        ("/tags", json!([1]), "/tags/0"),
    ];
    for (pointer, value, place) in cases {
        let mut bad = good.clone();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        bad.pointer_mut(parent).unwrap()[key] = value.clone();
        let found = faults(&bad);
        assert!(found.iter().any(|f| f.split(": ").next() == Some(place)), "{pointer} = {value}: {found:?}");
        // The reader minds it too, by an error or at least by a warning.
        if let Ok(graph) = orograph::graph::Graph::from_bytes(bad.to_string().as_bytes(), &registry()) {
            assert_ne!(told(&graph), [""; 0], "{pointer} = {value}");
        }
    }
}
