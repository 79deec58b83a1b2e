//! Commands that are asked to stop, or have nothing to read, end at once.

#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use orograph::engine::{Engine, EngineError, Files, Options, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;

use super::tiffs::{grey, tiff};
use crate::cli::{code, orograph, run, said, text};

/// How long the end may take: far more than it does, on a machine that is busy, and far less than the work.
const SOON: Duration = Duration::from_secs(5);

/// A TIFF of one strip of bytes, all the same, that takes a while to unpack.
fn one_strip(side: u32) -> Vec<u8> {
    let mut deflate = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let line = vec![0; side as usize * 4];
    (0..side).for_each(|_| std::io::Write::write_all(&mut deflate, &line).expect("into memory"));
    let strip = deflate.finish().expect("into memory");
    tiff(&strip, &grey([side; 2], (32, 3), 8, strip.len() as u32))
}

/// Waits until a process hears the signal; whether it still runs.
fn hears(child: &mut Child) -> bool {
    let begun = Instant::now();
    let listens = |status: &str| {
        let caught = status.lines().find_map(|l| l.strip_prefix("SigCgt:"))?;
        Some(u64::from_str_radix(caught.trim(), 16).ok()? & 2 != 0)
    };
    while child.try_wait().unwrap().is_none() {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id()));
        // A system that does not tell gives it a while.
        let waited = begun.elapsed() > if status.is_ok() { SOON } else { Duration::from_millis(200) };
        if waited || status.is_ok_and(|s| listens(&s) == Some(true)) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    false
}

/// Runs a command, interrupts it once it hears that, and tells how long it took to end.
fn interrupted(args: &[&str]) -> (i32, Duration, String) {
    let mut command = orograph();
    let mut child = command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    if hears(&mut child) {
        let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(killed.success());
    }
    let begun = Instant::now();
    let ended = child.wait_with_output().unwrap();
    (code(&ended), begun.elapsed(), said(&ended))
}

#[test]
fn reading_stops_when_it_is_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    std::fs::write(path("a.tif"), one_strip(8_000)).unwrap();
    let (tif, out) = (path("a.tif"), path("b.tif"));
    for args in [&["info", tif.as_str()][..], &["convert", &tif, &out]] {
        let (code, took, said) = interrupted(args);
        // A machine that has read it within that time has nothing left to stop.
        assert!(code == 130 || code == 0, "{args:?}: {code}, {said}");
        assert!(took < SOON, "{args:?}: {took:?}");
        assert!(code == 0 || !folder.path().join("b.tif").exists(), "{args:?} left a file");
    }
}

/// A file that is none of its kind is not read to its end to know that.
#[test]
fn a_plan_looks_at_headers_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    let curves = r#"
        "r": { "kind": "curve_raster", "in": { "curves": "n.curves" } },
        "d": { "kind": "diffuse", "in": { "constraints": "r.constraints" } },"#;
    for (kind, name, more, from) in [
        ("import_height", "a.tif", "", "n.height"),
        ("import_picture", "a.png", "", "n.mask"),
        ("import_curves", "a.svg", curves, "d.height"),
    ] {
        // A hole, which takes no room on the disk.
        std::fs::File::create(path(name)).unwrap().set_len(8 << 30).unwrap();
        let graph = format!(
            r#"{{ "orograph": 1,
                "nodes": {{ {more} "n": {{ "kind": "{kind}", "set": {{ "file": "{name}" }} }} }},
                "outputs": {{ "o": {{ "from": "{from}", "format": "tiff" }} }} }}"#
        );
        std::fs::write(path("a.graph"), graph).unwrap();
        let begun = Instant::now();
        let planned = run(&["plan", &path("a.graph")]);
        assert!(begun.elapsed() < SOON, "{name}: {:?}", begun.elapsed());
        assert_eq!(code(&planned), 4, "{name}: {}", said(&planned));
        assert!(said(&planned).contains(name), "{}", said(&planned));
    }
}

/// What only looks at a graph stops as well, however many nodes it has.
#[test]
fn a_long_chain_is_left_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = text(&folder.path().join("chain.graph"));
    let link = |i: u32| format!(r#""n{i}": {{ "kind": "invert", "in": {{ "field": "n{}.field" }} }}"#, i - 1);
    let links: Vec<_> = (1..20_000).map(link).collect();
    let graph = format!(
        r#"{{ "orograph": 1, "nodes": {{ "n0": {{ "kind": "constant" }}, {} }},
            "outputs": {{ "o": {{ "from": "n19999.field", "format": "r32" }} }} }}"#,
        links.join(", ")
    );
    std::fs::write(&path, graph).unwrap();
    for args in [&["check", path.as_str()][..], &["plan", &path], &["fmt", "--check", &path]] {
        let (code, took, said) = interrupted(args);
        assert!(took < SOON, "{args:?}: {code} after {took:?}, {:?}", said.lines().last());
    }
}

/// Who plans a graph of many nodes hears the signal between any two of them.
#[test]
fn planning_stops_when_it_is_asked_to() {
    let text = r#"{ "orograph": 1, "nodes": { "a": { "kind": "constant" }, "b": { "kind": "invert", "in": { "field": "a.field" } } } }"#;
    let registry = Registry::standard();
    let graph = Graph::from_bytes(text.as_bytes(), &registry).expect("a graph");
    let node = graph.find("b").expect("there");
    let wants = [Want { node, port: "field".into(), grid: graph.terrain().base_grid() }];
    let engine =
        Engine::new(&Options { threads: 1, ..Options::default() }, Files::default()).expect("starts");
    let cancel = Cancel::default();
    assert!(engine.plan_until(&graph, &wants, &cancel).is_ok());
    cancel.cancel();
    assert!(matches!(engine.plan_until(&graph, &wants, &cancel), Err(EngineError::Cancelled)));
}
