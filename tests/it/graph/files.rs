//! What is read is what is written.

use std::fs;

use orograph::files::Format;
use orograph::graph::{Backend, Graph, KindRef, LoadError};
use serde_json::json;

use super::kinds::*;

#[test]
fn an_untouched_file_comes_back_byte_for_byte() {
    let odd = "\u{feff}{ \"nodes\":{\"a\" :{\"kind\":\"hills\",\"set\":{\"amplitude\":1.20e2}}},\r\n\t\"orograph\":1,\"x\":null }\n\n";
    for text in [odd, EXAMPLE] {
        let mut graph = load(text);
        assert_eq!(graph.to_bytes(), text.as_bytes());
        // Edits that change nothing leave it untouched, and refused ones too.
        let a = graph.nodes().next().unwrap();
        let name = graph.node(a).name.clone();
        graph.rename(a, &name).unwrap();
        graph.move_to(a, graph.node(a).at).unwrap();
        graph.set(a, "amplitude", json!("high")).unwrap_err();
        assert!(!graph.is_changed());
        graph.move_to(a, [1.0, 2.0]).unwrap();
        assert_eq!(graph.to_bytes(), graph.canonical());
    }
}

#[test]
fn the_canonical_form_is_the_one_of_the_description() {
    let graph = load(EXAMPLE);
    assert_eq!(told(&graph), [""; 0]);
    assert_eq!(canonical(&graph), EXAMPLE);
    let hills = graph.node(id(&graph, "hills"));
    assert!(matches!(&hills.kind, KindRef::Known(k) if k.id == "hills"));
    let height = id(&graph, "height");
    assert_eq!(graph.node(height).backend, Backend::Cpu);
    let source = graph.source(height, "b").unwrap();
    assert_eq!((graph.node(source.node).name.as_str(), source.port.as_str()), ("plain", "field"));
    let output = graph.output("for_unreal").unwrap();
    assert_eq!((output.format, output.range), (Some(Format::Png16), Some([-256.0, 1792.0])));
    assert_eq!(graph.output_source("height").unwrap().node, height);
}

#[test]
fn canonical_drops_defaults_and_keeps_what_it_does_not_know() {
    let graph = load(
        r#"{
        "future": {"b": [1, 2.50, 3e0], "a": null},
        "outputs": {"h": {"from": "far.out", "format": "vrml", "quality": 3}},
        "nodes": {
            "far": {"kind": "teleport", "set": {"to": [1, {"deep": true}]}, "in": {"x": "a.field", "y": 5}, "note": "mine"},
            "a": {"backend": "abacus", "kind": "hills", "set": {"octaves": 8.0, "amplitude": 1e2, "scale": null, "ghost": 1}},
            "b": {"kind": "sum", "in": {"zz": "a.field", "b": "nobody.field", "a": "a.field"}, "at": "left"}
        },
        "kinds": {"teleport": 7, "unused": 3},
        "terrain": {"width": 1000, "depth": 2000, "moons": 2},
        "orograph": 1
        }"#,
    );
    let text = canonical(&graph);
    let expected = r#"{
  "orograph": 1,
  "kinds": { "hills": 1, "sum": 1, "teleport": 7 },
  "terrain": {
    "origin": [0, 0],
    "width": 1000,
    "depth": 2000,
    "sea_level": 0,
    "seed": 1,
    "base": 1025,
    "moons": 2
  },
  "nodes": {
    "far": {
      "kind": "teleport",
      "at": [0, 0],
      "in": { "x": "a.field", "y": 5 },
      "set": { "to": [1, { "deep": true }] },
      "note": "mine"
    },
    "a": { "kind": "hills", "at": [0, 0], "set": { "ghost": 1 }, "backend": "abacus" },
    "b": {
      "kind": "sum",
      "at": "left",
      "in": { "a": "a.field", "b": "nobody.field", "zz": "a.field" }
    }
  },
  "outputs": {
    "h": { "from": "far.out", "format": "vrml", "quality": 3 }
  },
  "future": { "b": [1, 2.5, 3], "a": null }
}
"#;
    let expected = expected.replace(
        "    \"b\": {\n      \"kind\": \"sum\",\n      \"at\": \"left\",\n      \"in\": { \"a\": \"a.field\", \"b\": \"nobody.field\", \"zz\": \"a.field\" }\n    }",
        "    \"b\": { \"kind\": \"sum\", \"at\": \"left\", \"in\": { \"a\": \"a.field\", \"b\": \"nobody.field\", \"zz\": \"a.field\" } }",
    );
    let short_terrain = "  \"terrain\": { \"origin\": [0, 0], \"width\": 1000, \"depth\": 2000, \"sea_level\": 0, \"seed\": 1, \"base\": 1025, \"moons\": 2 },\n";
    assert!(short_terrain.trim_end().len() > 110, "the line is broken because it is long");
    assert_eq!(text, expected);
    let again = load(&text);
    assert_eq!(canonical(&again), text);
    assert_eq!(told(&again), told(&graph));
    let told = told(&graph);
    has(&told, &["node `far`: ", "`teleport`", "not known", "kept"]);
    has(&told, &["node `far`: ", "`note` is not known"]);
    has(&told, &["node `a`, parameter `ghost`", "not one of this kind's", "`amplitude`"]);
    has(&told, &["node `a`: `backend` must be one of auto, cpu, gpu, got \"abacus\""]);
    has(&told, &["node `b`, input `b`: reads `nobody.field`, but the graph has no node `nobody`"]);
    has(&told, &["node `b`, input `zz`: `sum` has no such input; it has `a`, `b`, `mask`"]);
    has(&told, &["node `b`: `at` must be a list, got \"left\""]);
    has(&told, &["output `h`: `format` must be one of png8", "got \"vrml\""]);
    has(&told, &["output `h`: ", "`quality` is not known"]);
    has(&told, &["output `h`: reads `far.out`, whose kind `teleport` is not known"]);
    has(&told, &["terrain, setting `moons`: is not known"]);
    has(&told, &["graph: ", "`future` is not known"]);
}

#[test]
fn long_lists_of_numbers_stay_on_a_line_and_long_lists_of_points_are_broken() {
    let points: Vec<[f64; 2]> = (0..12).map(|i| [f64::from(i) / 16.0, 0.123_456_789]).collect();
    let mut graph = Graph::with_registry(registry());
    let a = graph.add("a", "hills").unwrap();
    graph.set(a, "points", json!(points)).unwrap();
    let text = canonical(&graph);
    assert!(
        text.contains(
            "        \"points\": [\n          [0, 0.123456789],\n          [0.0625, 0.123456789],\n"
        ),
        "{text}"
    );
    let long = load(&format!(r#"{{"orograph": 1, "x": {:?}}}"#, [1234.5; 40]));
    let line = format!("  \"x\": {:?}", [1234.5; 40]);
    assert!(canonical(&long).contains(&line));
}

#[test]
fn numbers_come_back_exactly() {
    let numbers = "0.1, 1e-320, 1.7976931348623157e308, 9007199254740993, -9007199254740993, 18446744073709551615, 123456789.125, 1e22, 4.35, 0.30000000000000004";
    let graph = load(&format!(r#"{{"orograph": 1, "x": [{numbers}]}}"#));
    let again = load(&canonical(&graph));
    assert_eq!(graph.extra(), again.extra());
    let text = canonical(&graph);
    for exact in ["9007199254740993, -9007199254740993, 18446744073709551615", "0.30000000000000004", "4.35"]
    {
        assert!(text.contains(exact), "{text}");
    }
    assert!(canonical(&load(r#"{"orograph": 1, "x": [-0.0, 8192.0, 1.5e3]}"#)).contains("[0, 8192, 1500]"));
}

#[test]
fn saving_is_atomic_and_keeps_what_it_cannot_replace() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.graph");
    let mut graph = load(EXAMPLE);
    graph.save(&path).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), EXAMPLE);
    let plain = id(&graph, "plain");
    graph.set(plain, "value", json!(3)).unwrap();
    graph.save(&path).unwrap();
    let again = Graph::open(&path, &registry()).unwrap();
    assert_eq!(again.to_bytes(), graph.canonical());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    // A folder of the name cannot be replaced by a file: the save fails and leaves nothing.
    let blocked = folder.path().join("blocked");
    fs::create_dir(&blocked).unwrap();
    graph.save(&blocked).unwrap_err();
    graph.save(&folder.path().join("no such folder/a.graph")).unwrap_err();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[cfg(unix)]
#[test]
fn saving_keeps_permissions_and_links() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.graph"), folder.path().join("link.graph"));
    load(EXAMPLE).save(&real).unwrap();
    assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o600, 0o600);
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    Graph::with_registry(registry()).save(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    assert_ne!(fs::read_to_string(&real).unwrap(), EXAMPLE);
}

#[test]
fn opening_looks_before_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let open = |path: &std::path::Path| Graph::open(path, &registry()).unwrap_err();
    assert!(matches!(open(folder.path()), LoadError::NotAFile));
    assert!(matches!(open(&folder.path().join("missing.graph")), LoadError::Read(_)));
    // 100 MB that take no room on the disk.
    let large = folder.path().join("large.graph");
    fs::File::create(&large).unwrap().set_len(100_000_000).unwrap();
    assert_eq!(open(&large).to_string(), "the file has 100000000 bytes, the limit is 16777216");
    #[cfg(unix)]
    {
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success(), "mkfifo");
        assert_eq!(open(&pipe).to_string(), "this is not a regular file");
    }
}

#[test]
fn old_kinds_are_migrated_with_what_is_exposed_of_them() {
    let old = r#"{"orograph": 1, "kinds": {"aged": 1}, "expose": {
        "width": {"bind": ["a.extent"], "value": 2.5, "min": 1, "max": 50}, "bare": {"bind": ["b.extent"]}},
        "nodes": {"a": {"kind": "aged", "set": {"extent": 2.5}}, "b": {"kind": "aged", "set": {"extent": 3}}},
        "outputs": {"o": {"from": "a.field"}}}"#;
    let graph = load(old);
    assert_eq!(told(&graph), [""; 0]);
    assert_eq!(graph.to_bytes(), old.as_bytes(), "an old file that is not edited stays as it is");
    assert_eq!(graph.node(id(&graph, "a")).set["size"], json!(2500));
    let text = canonical(&graph);
    assert!(text.contains(r#""kinds": { "aged": 3 }"#), "{text}");
    assert!(
        text.contains(r#""width": { "bind": ["a.size"], "value": 2500, "min": 1000, "max": 50000 }"#),
        "{text}"
    );
    assert!(text.contains(r#""bare": { "bind": ["b.size"], "value": 3000 }"#), "{text}");
    let second = load(&old.replace("\"aged\": 1", "\"aged\": 2"));
    assert!(canonical(&second).contains(r#""bind": ["a.size"], "value": 2.5, "min": 1, "max": 50"#));
    let unsaid = load(r#"{"orograph": 1, "nodes": {"a": {"kind": "aged", "set": {"size": 7}}}}"#);
    has(&told(&unsaid), &["graph: ", "does not say", "`aged`", "version 3"]);
    assert_eq!(unsaid.node(id(&unsaid, "a")).set["size"], json!(7));
}

#[test]
fn newer_kinds_are_kept() {
    for (version, words) in [
        ("9", &["`aged` in version 9", "has version 3"][..]),
        ("0", &["whole number from 1 to 3", "got 0"]),
        ("\"x\"", &["got \"x\""]),
    ] {
        let mut graph = load(&format!(
            r#"{{"orograph": 1, "kinds": {{"aged": {version}}}, "nodes": {{
            "a": {{"kind": "aged", "set": {{"size": 7, "colour": 3}}}}, "b": {{"kind": "sum", "in": {{"a": "a.field"}}}}}}}}"#
        ));
        let told = errors(&graph);
        has(&told, words);
        has(&told, &["node `b`, input `a`: reads `a.field`, whose kind `aged` is not known"]);
        assert_eq!(told.len(), 2, "{told:?}");
        let text = canonical(&graph);
        assert!(text.contains(&format!("\"aged\": {version}")), "{text}");
        assert!(text.contains(r#""set": { "size": 7, "colour": 3 }"#), "{text}");
        assert!(text.contains(r#""in": { "a": "a.field" }"#), "{text}");
        let a = id(&graph, "a");
        graph.set(a, "size", json!(3)).unwrap_err();
        graph.add("c", "aged").unwrap_err();
        graph.remove(a).unwrap();
        graph.add("c", "aged").unwrap();
        assert!(canonical(&graph).contains("\"aged\": 3"));
    }
}

#[test]
fn the_example_of_the_manual_is_canonical() {
    let manual = include_str!("../../../docs/graph-file.md");
    let example = manual.split("```json\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let graph = Graph::from_bytes(example.as_bytes(), &orograph::nodes::Registry::standard()).unwrap();
    assert_eq!(canonical(&graph), example);
    if graph.registry().find("fractal_noise").is_some() {
        assert_eq!(told(&graph), [""; 0]);
    }
}
