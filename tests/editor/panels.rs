//! Parameters by hand.

use std::path::Path;

use eframe::egui::{Key, Modifiers};
use orograph::editor::{Answer, Setup};
use serde_json::json;

use super::{Window, ground, weighted};

#[test]
fn a_typed_value_is_one_change() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "blur");
    window.click("node blur");
    let blur = window.graph().find("blur").unwrap();
    let before = window.graph().node(blur).set.get("radius").cloned();
    window.type_into("radius", "321");
    assert_eq!(window.graph().node(blur).set.get("radius"), Some(&json!(321)));
    window.keys(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.graph().node(blur).set.get("radius").cloned(), before);
}

#[test]
fn dice_and_a_step_back() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    let id = window.graph().find("fractal_noise").unwrap();
    let seed = |w: &Window| w.graph().node(id).set["seed"].clone();
    let first = seed(&window);
    window.click("🎲");
    let second = seed(&window);
    assert_ne!(first, second);
    window.click("⟲");
    assert_eq!(seed(&window), first);
}

#[test]
fn several_nodes_of_a_kind_are_set_together() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.add(ground(330.0, 30.0), "fractal");
    window.keys(Modifiers::COMMAND, Key::A);
    assert!(window.sees("2 × fractal_noise"));
    window.type_into("octaves", "3");
    for name in ["fractal_noise", "fractal_noise_2"] {
        let node = window.graph().node(window.graph().find(name).unwrap());
        assert_eq!(node.set.get("octaves"), Some(&json!(3)), "{name}");
    }
}

#[test]
fn outputs_and_texts() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.click("Outputs");
    window.click("➕ Output of fractal_noise.field");
    let outputs: Vec<_> = window.graph().outputs().map(|(n, o)| (n.to_owned(), o.from.clone())).collect();
    assert_eq!(outputs, [("fractal_noise".to_owned(), "fractal_noise.field".to_owned())]);
    window.click("History");
    assert!(window.sees("Add output") && window.sees("Add fractal_noise"));
    window.click("New graph");
    assert_eq!(window.graph().nodes().len(), 0);
}

#[test]
fn a_long_number_does_not_push_the_panel() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.click("node fractal_noise");
    let before = window.rect("map view");
    // More digits than there is room for: it becomes the most that is allowed.
    window.type_into("feature_size", "99999999");
    window.steps(20);
    assert_eq!(window.rect("map view"), before);
}

#[test]
fn charts_have_room() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.settle();
    let before = window.rect("map view");
    window.click("Charts");
    window.steps(5);
    let after = window.rect("map view");
    let canvas = window.rect("canvas");
    assert!(before.height() - after.height() > 80.0, "{before} {after}");
    assert!(canvas.top() - after.bottom() > 80.0, "{canvas} {after}");
}

#[test]
fn a_kind_made_while_the_program_runs_has_sliders() {
    let registry = weighted::registry();
    let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
    let mut window = Window::of(Setup { registry, home: None, asker, ..Setup::default() });
    // By one of its words.
    window.add(ground(20.0, 30.0), "heap");
    window.type_into("the weight of what stands left", "-2.5");
    let graph = window.graph();
    let node = graph.find("weighted").unwrap();
    assert_eq!(graph.node(node).set["the weight of what stands left"], -2.5);
}
