//! Random graphs evaluated, and those that once broke a promise.

mod graphs;
mod verdict;

use orograph::graph::Graph;
use orograph::nodes::Registry;

use graphs::Chance;
use verdict::{Tally, judge};

use crate::rig::breadth;

/// Graphs of each run of the tests, more where the whole is tried; `OROGRAPH_CHANCE` asks for any number.
fn cases() -> u32 {
    let asked = std::env::var("OROGRAPH_CHANCE").ok().and_then(|n| n.parse().ok());
    asked.unwrap_or(if breadth() { 2000 } else { 40 })
}

/// Some hundred bytes that look random and depend on a number alone.
fn bytes(number: u32) -> Vec<u8> {
    let mut bytes = vec![0; 60 + (number as usize * 37) % 340];
    blake3::Hasher::new().update(&number.to_le_bytes()).finalize_xof().fill(&mut bytes);
    bytes
}

#[test]
fn any_graph_keeps_its_promises() {
    let mut sum = Tally::default();
    for number in 0..cases() {
        let graph = Chance::new(&bytes(number)).graph();
        let text = String::from_utf8(graph.to_bytes()).unwrap();
        let tally = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| judge(&graph)));
        let tally = tally.unwrap_or_else(|e| {
            panic!("{}\n{text}", e.downcast_ref::<String>().map_or("a broken promise", String::as_str))
        });
        sum.made += tally.made;
        sum.refused += tally.refused;
    }
    // Graphs that are all refused would test nothing.
    assert!(sum.made > 4 * sum.refused && sum.made > 5 * cases() as usize, "{sum:?}");
}

#[test]
fn graphs_that_broke_a_promise_keep_it() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/chance/found");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    for path in paths.filter(|p| p.extension().is_some_and(|e| e == "graph")) {
        let graph = Graph::from_bytes(&std::fs::read(&path).unwrap(), &Registry::standard()).unwrap();
        judge(&graph);
    }
}
