//! Nodes and wires by hand.

use eframe::egui::{Key, Modifiers, vec2};

use super::{PRESET, Window, ground, preset};

const COMMAND: Modifiers = Modifiers::COMMAND;

/// Hills, a blur and a terrace on an empty canvas.
fn three() -> Window {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "fractal");
    window.add(ground(330.0, 30.0), "blur");
    window.add(ground(640.0, 30.0), "terrace");
    assert_eq!(window.graph().nodes().len(), 3);
    window
}

fn wire(window: &mut Window, from: &str, to: &str) {
    let way = [window.at(&format!("output {from}")), window.at(&format!("input {to}"))];
    window.drag(&way);
}

#[test]
fn adds_by_search_and_wires_by_dragging() {
    let mut window = three();
    wire(&mut window, "fractal_noise.field", "blur.field");
    wire(&mut window, "blur.field", "terrace.field");
    assert_eq!(window.reads("blur", "field").as_deref(), Some("fractal_noise.field"));
    assert_eq!(window.reads("terrace", "field").as_deref(), Some("blur.field"));
    for _ in 0..5 {
        window.keys(COMMAND, Key::Z);
    }
    assert_eq!(window.graph().nodes().len(), 0);
    for _ in 0..5 {
        window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!(window.reads("terrace", "field").as_deref(), Some("blur.field"));
}

#[test]
fn refuses_a_wire_that_does_not_fit_while_it_is_dragged() {
    let mut window = three();
    window.add(ground(20.0, 180.0), "curve_raster");
    let way = [window.at("output fractal_noise.field"), window.at("input curve_raster.curves")];
    window.drag(&way);
    assert_eq!(window.reads("curve_raster", "curves"), None);
    assert!(window.sees("takes curves, but `fractal_noise.field` gives"), "the reason is told");
    wire(&mut window, "blur.field", "terrace.field");
    wire(&mut window, "terrace.field", "blur.field");
    assert!(window.sees("would close a cycle"));
    assert_eq!(window.reads("blur", "field"), None);
}

#[test]
fn a_wire_dropped_on_empty_ground_searches_what_fits() {
    let mut window = three();
    let from = window.at("output fractal_noise.field");
    window.drag(&[from, ground(330.0, 200.0)]);
    window.text("curve_raster");
    assert!(!window.sees("curve_raster"), "what does not fit is not offered");
    window.keys(COMMAND, Key::A);
    window.text("clamp");
    window.key(Key::Enter);
    assert_eq!(window.reads("clamp", "field").as_deref(), Some("fractal_noise.field"));
}

#[test]
fn a_node_dropped_on_a_wire_goes_between_and_leaves_a_bridge() {
    let mut window = three();
    wire(&mut window, "fractal_noise.field", "terrace.field");
    let wired = (window.at("output fractal_noise.field").to_vec2()
        + window.at("input terrace.field").to_vec2())
        * 0.5;
    // The blur stands there: away with it, and back onto the wire.
    let title = window.at("node blur") - vec2(0.0, 40.0);
    window.drag(&[title, title + vec2(0.0, 170.0)]);
    let title = window.at("node blur") - vec2(0.0, 40.0);
    window.drag(&[title, wired.to_pos2()]);
    assert_eq!(window.reads("blur", "field").as_deref(), Some("fractal_noise.field"));
    assert_eq!(window.reads("terrace", "field").as_deref(), Some("blur.field"));
    window.key(Key::Delete);
    assert!(window.graph().find("blur").is_none());
    assert_eq!(window.reads("terrace", "field").as_deref(), Some("fractal_noise.field"));
}

#[test]
fn copies_travel_between_windows_with_their_wires() {
    let mut window = three();
    wire(&mut window, "fractal_noise.field", "blur.field");
    window.keys(COMMAND, Key::A);
    let text = window.copied();
    let mut other = Window::empty();
    other.hover(ground(60.0, 60.0));
    other.paste(&text);
    other.paste(&text);
    assert_eq!(other.graph().nodes().len(), 6);
    assert_eq!(other.reads("blur_2", "field").as_deref(), Some("fractal_noise_2.field"));
    other.paste("{ this is no graph");
    assert_eq!(other.graph().nodes().len(), 6);
    assert!(other.sees("not a part of a graph"));
}

#[test]
fn everything_can_be_undone_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let mut window = Window::on(&path);
    window.keys(COMMAND, Key::A);
    window.keys(COMMAND, Key::D);
    window.key(Key::B);
    window.key(Key::L);
    window.key(Key::N);
    // The title is asked for first.
    window.text("Mountains");
    window.key(Key::Escape);
    window.key(Key::Delete);
    let (states, at) = window.editor().document().states();
    assert!(states.len() > 3 && at == states.len() - 1, "{states:?}");
    assert!(window.editor().document().is_unsaved());
    for _ in 0..at {
        window.keys(COMMAND, Key::Z);
    }
    assert!(window.graph().to_bytes() == std::fs::read(PRESET).unwrap(), "undone to the same bytes");
    assert!(!window.editor().document().is_unsaved());
}

#[test]
fn boxes_choose_and_moves_are_one_change() {
    let mut window = three();
    let before = window.graph().node(window.graph().find("blur").unwrap()).at;
    window.drag(&[ground(0.0, 5.0), ground(900.0, 220.0)]);
    let title = window.at("node blur") - vec2(0.0, 40.0);
    window.drag(&[title, title + vec2(40.0, 60.0)]);
    let names = ["fractal_noise", "blur", "terrace"];
    let at = |w: &Window, n: &str| w.graph().node(w.graph().find(n).unwrap()).at;
    let moved = at(&window, "blur");
    assert!(moved[0] > before[0] && moved[1] > before[1]);
    assert!(names.iter().all(|n| at(&window, n)[0] % 20.0 == 0.0), "they snap");
    window.keys(COMMAND, Key::Z);
    assert_eq!(at(&window, "blur"), before);
}

#[test]
fn bypass_and_bends_by_hand() {
    let mut window = three();
    wire(&mut window, "fractal_noise.field", "blur.field");
    let middle =
        (window.at("output fractal_noise.field").to_vec2() + window.at("input blur.field").to_vec2()) * 0.5;
    window.double_click(middle.to_pos2());
    let blur = window.graph().find("blur").unwrap();
    assert_eq!(window.graph().bends(blur, "field").len(), 1);
    let bend = window.at("bend 0 of blur.field");
    let before = window.graph().bends(blur, "field")[0];
    window.drag(&[bend, bend + vec2(0.0, 100.0)]);
    assert_eq!(window.graph().bends(blur, "field")[0], [before[0], before[1] + 100.0]);
    window.click("node blur");
    window.key(Key::B);
    assert!(window.graph().node(blur).bypass);
}
