//! The chain of nodes, from curves to a height, through the engine.

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::{Field, Value};
use serde_json::{Value as Json, json};

fn height(graph: &Json, node: &str, port: &'static str, size: u32) -> Field {
    let g = Graph::from_bytes(graph.to_string().as_bytes(), &Registry::standard()).unwrap();
    let want = Want { node: g.find(node).unwrap(), port: port.into(), grid: g.terrain().grid(size).unwrap() };
    let engine = Engine::new(&Options { threads: 2, ..Options::default() }, Files::default()).unwrap();
    let all = engine.evaluate(&g, &[want], &Unobserved, &Cancel::default()).unwrap();
    match all.values.into_iter().next().unwrap().unwrap() {
        Value::Field(f) => f,
        other => panic!("a field, not {:?}", other.wire_type()),
    }
}

fn graph(curves: &Json, base: Option<&str>) -> Json {
    let mut inputs = json!({ "constraints": "raster.constraints" });
    if let Some(base) = base {
        inputs["base"] = json!(base);
    }
    json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 4096, "base": 129 },
        "nodes": {
            "old": { "kind": "fractal_noise", "set": { "amplitude": 200, "feature_size": 900, "seed": 3 } },
            "lines": { "kind": "feature_curves", "set": { "curves": curves } },
            "raster": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
            "land": { "kind": "diffuse", "in": inputs, "set": { "quality": "converged" } },
        },
        "outputs": {},
    })
}

/// Law 3 and \[weiss2015, V\]: the base changes inside the envelopes alone, also where it is finer than the base grid.
#[test]
fn a_base_keeps_every_bit_beyond_the_envelopes() {
    let curves = json!([{ "line": [1000, 2000, 3000, 2000], "height": [0, 400, 60],
        "slope": [0, 300, 300, -30, -30], "envelope": [0, 200, 200] }]);
    let g = graph(&curves, Some("old.field"));
    let (old, new) = (height(&g, "old", "field", 513), height(&g, "land", "height", 513));
    let (mut kept, mut changed) = (0, 0);
    for j in 0..513i64 {
        for i in 0..513i64 {
            let (x, y) = (i as f64 * 8.0, j as f64 * 8.0);
            // Plateau, slope, envelope, and what a cubic spline through base cells of 32 m reaches.
            let reach = 60.0 + 300.0 + 200.0 + 4.0 * 32.0;
            let outside = x < 1000.0 - reach || x > 3000.0 + reach || (y - 2000.0).abs() > reach;
            let same = old.at(i, j).to_bits() == new.at(i, j).to_bits();
            assert!(same || !outside, "({x}, {y}): {} was {}", new.at(i, j), old.at(i, j));
            kept += i32::from(outside);
            changed += i32::from(!same);
        }
    }
    assert!(kept > 100_000 && changed > 10_000, "{kept} kept, {changed} changed");
    // Detail of the base that its base grid does not hold stays on the plateau as well.
    assert!((new.at(250, 250) - 400.0).abs() < 5.0, "{} on the plateau", new.at(250, 250));
}

#[test]
fn no_curves_give_level_ground_at_zero() {
    let flat = height(&graph(&json!([]), None), "land", "height", 65);
    assert_eq!(flat.range(), Some((0.0, 0.0)));
}

#[test]
fn a_fault_in_a_curve_names_it() {
    let g = graph(&json!([{ "name": "crest", "line": [0, 0, 100, 0], "slope": [0, 1, 1, 95, 0] }]), None);
    let g = Graph::from_bytes(g.to_string().as_bytes(), &Registry::standard()).unwrap();
    let said: Vec<String> = g.problems().iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|p| p.contains("node `lines`, parameter `curves`")), "{said:?}");
    assert!(said.iter().any(|p| p.contains("95")), "{said:?}");
}

/// Results where slopes meet are others than those of the first version; its parameters are the same.
#[test]
fn an_old_graph_of_curves_opens() {
    let mut old = graph(&json!([]), None);
    old["kinds"] = json!({ "curve_raster": 1 });
    old["nodes"]["raster"]["set"] = json!({ "feather": 0.25 });
    let g = Graph::from_bytes(old.to_string().as_bytes(), &Registry::standard()).unwrap();
    let said: Vec<String> = g.problems().iter().map(ToString::to_string).collect();
    assert!(!said.iter().any(|p| p.contains("curve_raster")), "{said:?}");
    let saved: Json = serde_json::from_slice(&g.canonical()).unwrap();
    assert_eq!(saved["nodes"]["raster"]["set"], json!({ "feather": 0.25 }));
    assert_eq!(saved["kinds"]["curve_raster"], json!(2));
}

#[test]
fn curves_are_outputs_in_formats_of_lines() {
    let mut g = graph(&json!([]), None);
    g["outputs"] = json!({
        "lines": { "from": "lines.curves" }, "samples": { "from": "lines.curves", "format": "exr" },
    });
    let g = Graph::from_bytes(g.to_string().as_bytes(), &Registry::standard()).unwrap();
    assert!(g.output_source("lines").is_ok());
    let said = g.output_source("samples").unwrap_err().to_string();
    assert!(said.contains("`format` exr holds samples on a grid, `lines.curves` is curves"), "{said}");
}

#[test]
fn the_graph_of_the_manual_is_faultless_and_rises() {
    let manual = include_str!("../../../docs/curves.md");
    let text = manual.split("```json\n").find(|block| block.contains("\"orograph\"")).expect("a graph");
    let text = text.split("```").next().expect("its end");
    let graph = Graph::from_bytes(text.as_bytes(), &orograph::nodes::Registry::standard()).expect("a graph");
    assert!(graph.problems().is_empty(), "{:?}", graph.problems());
    let source = graph.output_source("height").expect("an output");
    let grid = graph.terrain().grid(129).expect("a grid");
    let want = Want { node: source.node, port: source.port, grid };
    let all = crate::rig::graph::engine(2)
        .evaluate(&graph, &[want], &Unobserved, &Cancel::default())
        .expect("values");
    let Ok(Value::Field(field)) = &all.values[0] else { panic!("{:?}", all.values[0]) };
    let (low, high) = field.range().expect("samples");
    assert!(low < 150.0 && high > 900.0, "{low} to {high}");
}
