//! What is evaluated and shown.

use eframe::egui::{Key, Modifiers, vec2};

use egui_kittest::kittest::Queryable as _;

use super::{Window, ground, preset};

#[test]
fn shows_the_result_of_the_graph_and_of_what_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    let first = window.editor().shown_range();
    assert!(first.is_some(), "the first output is shown");
    assert!(window.editor().thumbnails() > 3);
    // The node of the first output is pinned when a graph is opened, and a pinned node is shown whatever is chosen.
    window.click("node bent");
    window.settle();
    assert_eq!(window.editor().shown_range(), first);
    window.click("pin");
    window.settle();
    let chosen = window.editor().shown_range();
    assert!(
        chosen.is_some() && chosen != first,
        "`bent` is shown and has the range of the output: {chosen:?}"
    );
}

#[test]
fn nothing_is_drawn_while_nothing_happens() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    window.steps(20);
    let delays = window.0.output().viewport_output.values().map(|v| v.repaint_delay);
    let causes = window.0.ctx.repaint_causes();
    assert!(delays.min().unwrap() > std::time::Duration::from_secs(3600), "{causes:?}");
}

#[test]
fn a_change_is_evaluated_and_a_fault_is_told() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "constant");
    window.settle();
    let (low, high) = window.editor().shown_range().unwrap();
    assert_eq!(low, high);
    window.add(ground(330.0, 30.0), "blur");
    window.settle();
    assert!(window.sees("1 error"), "a blur without an input");
    window.key(Key::Delete);
    window.settle();
    assert!(!window.sees("1 error"));
}

#[test]
fn two_nodes_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    assert!(!window.has("wipe"));
    window.key(Key::C);
    window.settle();
    let line = window.at("wipe");
    window.drag(&[line, line + vec2(-80.0, 0.0)]);
    assert!((window.at("wipe").x - line.x + 80.0).abs() < 2.0, "the line follows the hand");
    window.key(Key::C);
    window.settle();
    assert!(!window.has("wipe"));
}

#[test]
fn an_estimate_of_the_build_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    window.keys(Modifiers::COMMAND, Key::B);
    window.settle();
    assert!(window.sees("MB of memory"));
}

#[test]
fn more_memory_than_the_budget_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::frugal(&preset(folder.path()), 1 << 20);
    window.settle();
    assert!(window.editor().shown_range().is_none());
    assert!(window.sees("over the budget of memory"));
    let allow = window.0.query_all_by_label_contains("Allow").next().unwrap();
    allow.click();
    window.steps(3);
    window.settle();
    assert!(window.editor().shown_range().is_some(), "it was allowed");
}

#[test]
fn large_files_are_read_only_when_that_was_agreed_to() {
    let folder = tempfile::tempdir().unwrap();
    let side = 8300_u64;
    std::fs::File::create(folder.path().join("large.r32")).unwrap().set_len(4 * side * side).unwrap();
    let graph = serde_json::json!({
        "orograph": 1,
        "terrain": { "width": 1000, "depth": 1000, "base": 65 },
        "nodes": { "dem": { "kind": "import_height", "set": { "file": "large.r32" } } },
        "outputs": { "height": { "from": "dem.height" } },
    });
    let path = folder.path().join("large.graph");
    std::fs::write(&path, graph.to_string()).unwrap();
    let mut window = Window::on(&path);
    window.settle();
    assert!(window.editor().shown_range().is_none());
    assert!(window.sees("and read 262.8 MiB of files"));
    window.click("Evaluate");
    window.settle();
    assert_eq!(window.editor().shown_range(), Some((0.0, 0.0)));
}

#[test]
fn what_was_shown_stays_when_nothing_is_chosen() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.settle();
    let shown = window.editor().shown_range();
    window.press(ground(700.0, 200.0));
    window.settle();
    assert!(shown.is_some() && window.editor().shown_range() == shown);
}

#[test]
fn a_bypassed_node_shows_what_it_passes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    let range = |w: &Window, node: &str| w.editor().thumbnail_range(node);
    assert!(range(&window, "bent").is_some() && range(&window, "bent") != range(&window, "range"));
    window.click("node bent");
    window.key(Key::B);
    window.settle();
    assert_eq!(range(&window, "bent"), range(&window, "range"));
    window.key(Key::B);
    window.settle();
    assert_ne!(range(&window, "bent"), range(&window, "range"));
}
