//! Any bytes as choices that make a graph, which is evaluated: it keeps what every graph owes.
//! `cargo +nightly fuzz run evaluate`.
#![no_main]

#[path = "../../tests/it/chance/graphs.rs"]
mod graphs;
#[path = "../../tests/it/chance/verdict.rs"]
mod verdict;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let graph = graphs::Chance::new(bytes).graph();
    if let Ok(path) = std::env::var("OROGRAPH_KEEP") {
        // A finding becomes a test: run its input alone with this variable, and keep the graph.
        std::fs::write(path, graph.to_bytes()).expect("the graph can be written");
    }
    verdict::judge(&graph);
});
