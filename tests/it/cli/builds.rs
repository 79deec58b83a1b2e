//! `orograph build`: its files and its report.

use std::path::Path;

use serde_json::{Value as Json, json};

use super::{Desk, code, height, run, said, sha256, text};

#[test]
fn builds_leave_whole_files_and_a_true_report() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "picture": { "from": "hills.field", "format": "png16" },
    }));
    let built = desk.build(&["--set", "relief=300"]);
    assert_eq!(code(&built), 0, "{}", said(&built));
    let report = desk.report();
    assert_eq!(report["status"], "done");
    assert_eq!(report["variables"]["relief"], "300");
    assert_eq!(report["warnings"], json!([]));
    let outputs = report["outputs"].as_array().unwrap();
    assert_eq!(outputs.len(), 2);
    for o in outputs {
        let path = desk.path("out").join(o["path"].as_str().unwrap());
        assert_eq!(o["sha256"], sha256(&path));
        assert_eq!((o["cols"].as_u64(), o["rows"].as_u64()), (Some(129), Some(65)));
        assert_eq!(o["effective_cell"], o["cell"]);
    }
    let nodes: Vec<_> =
        report["nodes"].as_array().unwrap().iter().map(|n| n["node"].as_str().unwrap()).collect();
    assert!(nodes.contains(&"hills") && nodes.contains(&"soft") && !nodes.contains(&"dem"), "{nodes:?}");
    // The same again: the same bits, and no complaint about files that a build wrote.
    let before = report["outputs"][0]["sha256"].clone();
    assert_eq!(code(&desk.build(&["--set", "relief=300", "--threads", "1"])), 0);
    assert_eq!(desk.report()["outputs"][0]["sha256"], before);
}

#[test]
fn builds_go_on_when_standard_error_is_closed() {
    let desk = Desk::new(&height());
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_orograph"))
        .args(["build", &graph, "-o", &out, "--size", "257", "--progress", "json"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(desk.path("out/height.r32").exists());
}

#[test]
fn unity_gets_the_southernmost_row_first() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "for_unity": { "from": "soft.field", "target": "unity", "range": [-1000, 1000] },
    }));
    assert_eq!(code(&desk.build(&[])), 0);
    let sidecar: Json =
        serde_json::from_slice(&std::fs::read(desk.path("out/for_unity.json")).unwrap()).unwrap();
    assert_eq!((&sidecar["rows_from"], &sidecar["format"]), (&json!("south"), &json!("r16")));
    let heights = std::fs::read(desk.path("out/height.r32")).unwrap();
    let heights: Vec<f32> = heights.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let steps = std::fs::read(desk.path("out/for_unity.r16")).unwrap();
    let steps: Vec<u16> = steps.chunks(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect();
    for (row, line) in steps.chunks(129).rev().enumerate() {
        for (step, height) in line.iter().zip(&heights[row * 129..]) {
            let metres = f32::from(*step) / 65535.0 * 2000.0 - 1000.0;
            assert!((metres - height).abs() < 0.02, "row {row}: {metres} and {height}");
        }
    }
}

#[test]
fn failed_outputs_are_listed_and_the_others_are_made() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "file": { "from": "dem.height", "format": "r32" },
        "lost": { "from": "nobody.field" },
    }));
    let built = desk.build(&[]);
    assert_eq!(code(&built), 3, "{}", said(&built));
    let report = desk.report();
    assert_eq!(report["status"], "failed");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 1);
    let failures = report["failures"].to_string();
    assert!(failures.contains("missing.tif") && failures.contains("nobody"), "{failures}");
    assert!(desk.path("out/height.r32").exists());
    assert_eq!(code(&desk.build(&["--output", "file"])), 4);
}

fn samples(path: &Path) -> Vec<f32> {
    let bytes = std::fs::read(path).unwrap();
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn tiles_and_regions_on_disk_equal_the_whole() {
    let desk = Desk::new(&height());
    assert_eq!(code(&desk.build(&["--size", "257"])), 0);
    let whole = samples(&desk.path("out/height.r32"));
    assert_eq!(whole.len(), 257 * 129);
    assert_eq!(code(&desk.build(&["--size", "257", "--tile-size", "65"])), 0);
    for (i, j) in [(0, 0), (3, 1), (2, 0)] {
        let tile = samples(&desk.path(&format!("out/height_x{i}_y{j}.r32")));
        for r in 0..65 {
            let start = (j * 64 + r) * 257 + i * 64;
            assert_eq!(tile[r * 65..][..65], whole[start..start + 65], "tile {i},{j} row {r}");
        }
    }
    assert_eq!(code(&desk.build(&["--size", "257", "--region", "512,256,1024,512"])), 0);
    let region = samples(&desk.path("out/height.r32"));
    assert_eq!(region.len(), 65 * 33);
    assert_eq!(region[..65], whole[32 * 257 + 64..][..65]);
}

#[test]
fn cache_folders_serve_the_next_process() {
    let desk = Desk::new(&height());
    let cache = text(&desk.path("cache"));
    assert_eq!(code(&desk.build(&["--cache", &cache])), 0);
    let cold = desk.report()["outputs"][0]["sha256"].clone();
    assert_eq!(code(&desk.build(&["--cache", &cache])), 0);
    let report = desk.report();
    assert_eq!(report["outputs"][0]["sha256"], cold);
    let runs: u64 = report["nodes"].as_array().unwrap().iter().map(|n| n["runs"].as_u64().unwrap()).sum();
    assert_eq!(runs, 0, "{}", report["nodes"]);
}

/// What a node skips is said on standard error and in the report, once, by node.
#[test]
fn warnings_of_nodes_are_printed_and_reported_once() {
    let desk = Desk::new(&height());
    let line = json!({ "type": "LineString", "coordinates": [[100, -200], [900, -300], [1800, -700]] });
    let features = [
        json!({ "type": "Feature", "properties": { "elevation": 300 }, "geometry": line }),
        json!({ "type": "Feature", "properties": {}, "geometry": { "type": "Point", "coordinates": [1, 2] } }),
    ];
    let file = json!({ "type": "FeatureCollection", "features": features });
    std::fs::write(desk.path("lines.geojson"), file.to_string()).unwrap();
    let mapping = json!({ "height": { "property": { "name": "elevation" } } });
    let graph = json!({
        "orograph": 1,
        "kinds": { "import_curves": 2, "curve_raster": 1, "diffuse": 1 },
        "terrain": { "width": 2048, "depth": 1024, "base": 129 },
        "nodes": {
            "lines": { "kind": "import_curves", "set": { "file": "lines.geojson", "mapping": mapping } },
            "marks": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
            "land": { "kind": "diffuse", "in": { "constraints": "marks.constraints" } },
        },
        "outputs": { "height": { "from": "land.height", "format": "r32" } },
    });
    std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
    let built = desk.build(&["--tiles", "2x1"]);
    let said = said(&built);
    assert_eq!(code(&built), 0, "{said}");
    let warning = "node `lines`: 1 geometry that is no line, left out: feature 1, a Point";
    assert_eq!(said.matches(warning).count(), 1, "{said}");
    assert_eq!(desk.report()["warnings"], json!([warning]));
    let drawn = run(&["render", &text(&desk.path("a.graph")), "-o", &text(&desk.path("a.png"))]);
    let drawn = String::from_utf8_lossy(&drawn.stderr).into_owned();
    assert!(drawn.contains(warning), "{drawn}");
}
