//! What a user waits for when a graph is opened: 1,000 nodes read, checked, ordered and written.

use divan::{Bencher, black_box};
use orograph::graph::Graph;
use orograph::nodes::Registry;

fn main() {
    divan::main();
}

/// A file of as many nodes, each of which reads one or two of those before it.
fn file(nodes: usize) -> Vec<u8> {
    let mut text = String::from(
        "{\"orograph\": 1, \"nodes\": {\"n0\": {\"kind\": \"constant\", \"set\": {\"value\": 3}}",
    );
    for i in 1..nodes {
        let node = match i % 4 {
            0 => format!("\"kind\": \"constant\", \"at\": [{i}, 0], \"set\": {{\"value\": {i}.5}}"),
            1 => format!(
                "\"kind\": \"combine\", \"at\": [{i}, 0], \"in\": {{\"a\": \"n{}.field\", \"b\": \"n{}.field\"}}",
                i - 1,
                i / 2
            ),
            2 => format!(
                "\"kind\": \"blur\", \"at\": [{i}, 0], \"in\": {{\"field\": \"n{}.field\"}}, \"set\": {{\"radius\": {}}}",
                i - 1,
                i % 1000
            ),
            _ => {
                format!("\"kind\": \"clamp\", \"at\": [{i}, 0], \"in\": {{\"field\": \"n{}.field\"}}", i - 1)
            }
        };
        text.push_str(&format!(", \"n{i}\": {{{node}}}"));
    }
    text.push_str(&format!("}}, \"outputs\": {{\"height\": {{\"from\": \"n{}.field\"}}}}}}", nodes - 1));
    text.into_bytes()
}

fn open(bytes: &[u8]) -> Graph {
    Graph::from_bytes(bytes, &Registry::standard()).unwrap_or_else(|e| panic!("{e}"))
}

#[divan::bench(args = [10, 1000, 20_000])]
fn read(bencher: Bencher<'_, '_>, nodes: usize) {
    let bytes = file(nodes);
    bencher.bench(|| open(black_box(&bytes)));
}

#[divan::bench(args = [10, 1000, 20_000])]
fn check_and_order(bencher: Bencher<'_, '_>, nodes: usize) {
    let graph = open(&file(nodes));
    let problems = graph.problems();
    assert!(problems.is_empty(), "{problems:?}");
    bencher.bench(|| (black_box(&graph).problems(), black_box(&graph).order()));
}

#[divan::bench(args = [10, 1000, 20_000])]
fn write(bencher: Bencher<'_, '_>, nodes: usize) {
    let graph = open(&file(nodes));
    bencher.bench(|| black_box(&graph).canonical());
}
