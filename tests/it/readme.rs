//! The graphs that the README shows are graphs, and give what it says.

use serde_json::Value as Json;

use super::cli::{code, run, said, text};

/// The JSON blocks of a page that are graphs.
fn graphs(page: &str) -> Vec<&str> {
    let blocks = page.split("```json\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.filter(|block| block.contains("\"orograph\"")).collect()
}

#[test]
fn the_graphs_of_the_readme_are_built() {
    let readme = std::fs::read_to_string("README.md").unwrap();
    let graphs = graphs(&readme);
    assert_eq!(graphs.len(), 2, "the README shows two graphs");
    let folder = tempfile::tempdir().unwrap();
    for (i, graph) in graphs.into_iter().enumerate() {
        let path = text(&folder.path().join(format!("{i}.graph")));
        std::fs::write(&path, graph).unwrap();
        let checked = run(&["check", &path, "--strict"]);
        assert_eq!(code(&checked), 0, "{graph}: {}", said(&checked));
        let out = folder.path().join(i.to_string());
        let mut words = vec!["build", &path, "-o", out.to_str().unwrap(), "--base", "65", "--size", "65"];
        // As the command below the second graph does.
        let sets = ["--set", "height=1400"];
        words.extend(sets.iter().take(if i == 1 { 2 } else { 0 }));
        let built = run(&words);
        assert_eq!(code(&built), 0, "{graph}: {}", said(&built));
        let report: Json = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
        let height = &report["outputs"][0];
        assert!(height["max"].as_f64().unwrap() - height["min"].as_f64().unwrap() > 100.0, "{height}");
    }
}
