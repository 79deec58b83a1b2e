//! A cache folder in which somebody changed a file: the result is that of a cold build, or, where the sum was made right
//! again, at least some finite field. `cargo +nightly fuzz run cache`.
//!
//! The first byte says how the file is changed: all of it, a few bytes of it, the header alone; with or without its sum.
#![no_main]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use orograph::engine::{Engine, Evaluation, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;

/// A graph with two results that go to the folder, one of them a summary, and one that is made of them.
const GRAPH: &[u8] = br#"{ "orograph": 1, "terrain": { "width": 1000, "depth": 500, "base": 33 },
  "nodes": { "a": { "kind": "fractal_noise" }, "b": { "kind": "blur", "in": { "field": "a.field" } },
             "c": { "kind": "equalize", "in": { "field": "b.field" } } }, "outputs": {} }"#;
const MAGIC: &[u8] = b"orograph cache\n";

struct Scene {
    folder: tempfile::TempDir,
    graph: Graph,
    cold: Vec<u32>,
    entries: Vec<(PathBuf, Vec<u8>)>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let graph = Graph::from_bytes(GRAPH, &Registry::standard()).expect("a graph");
    let cold = bits(&run(folder.path(), &graph));
    let mut entries = Vec::new();
    collect(folder.path(), &mut entries);
    assert!(entries.len() > 1 && !cold.is_empty());
    Scene { folder, graph, cold, entries }
});

fn collect(folder: &Path, entries: &mut Vec<(PathBuf, Vec<u8>)>) {
    for path in fs::read_dir(folder).expect("a folder").flatten().map(|e| e.path()) {
        if path.is_dir() {
            collect(&path, entries);
        } else if let Ok(bytes) = fs::read(&path) {
            if bytes.starts_with(MAGIC) {
                entries.push((path, bytes));
            }
        }
    }
}

fn run(folder: &Path, graph: &Graph) -> Evaluation {
    let options = Options { threads: 1, cache: Some(folder.to_owned()), ..Options::default() };
    let engine = Engine::new(&options, Files::default()).expect("an engine");
    let node = graph.find("c").expect("the node");
    let want = Want { node, port: "field".into(), grid: graph.terrain().base_grid() };
    engine.evaluate(graph, &[want], &Unobserved, &Cancel::default()).expect("a result")
}

fn bits(all: &Evaluation) -> Vec<u32> {
    let value = all.values[0].as_ref().expect("a field");
    value.components().iter().map(|x| x.to_bits()).collect()
}

fuzz_target!(|bytes: &[u8]| {
    let [how, at, far, rest @ ..] = bytes else { return };
    let scene = &*SCENE;
    let (path, whole) = &scene.entries[usize::from(how >> 4) % scene.entries.len()];
    let length = whole.len() - blake3::OUT_LEN;
    let offset = usize::from(u16::from_le_bytes([*at, *far])) % length;
    let mut file = match how & 3 {
        0 => rest.to_vec(),
        1 => [&whole[..offset], rest].concat(),
        2 => {
            let mut file = whole[..length].to_vec();
            file.iter_mut().skip(offset).zip(rest).for_each(|(old, new)| *old ^= new);
            file
        }
        _ => {
            let start = MAGIC.len() + 8;
            let header = u64::from_le_bytes(whole[MAGIC.len()..start].try_into().expect("a length")) as usize;
            [MAGIC, &(rest.len() as u64).to_le_bytes(), rest, &whole[start + header..length]].concat()
        }
    };
    let summed = how & 4 != 0;
    let sum =
        if summed { *blake3::hash(&file).as_bytes() } else { whole[length..].try_into().expect("a sum") };
    file.extend(sum);
    let same = file == *whole;
    fs::write(path, &file).expect("the entry can be written");
    let found = bits(&run(scene.folder.path(), &scene.graph));
    if !summed || same {
        assert!(found == scene.cold);
    }
    assert!(found.len() == scene.cold.len() && found.iter().all(|&b| f32::from_bits(b).is_finite()));
    fs::write(path, whole).expect("the entry can be written");
});
