//! Pictures of the main states, to be looked at: `OROGRAPH_PICTURES=DIR cargo test editor::pictures`.

use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

use super::{Window, ground, preset};

fn picture(window: &mut Window, name: &str) {
    let Some(folder) = std::env::var_os("OROGRAPH_PICTURES") else { return };
    let image = window.0.render().unwrap();
    image.save(std::path::Path::new(&folder).join(format!("{name}.png"))).unwrap();
}

#[test]
fn main_states() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::drawn(&preset(folder.path()));
    window.settle();
    picture(&mut window, "opened");
    window.0.get_all_by_label("Relief").next().unwrap().click();
    window.steps(3);
    window.settle();
    picture(&mut window, "relief");
    window.click("Map");
    let first = window.graph().nodes().next().unwrap();
    let name = window.graph().node(first).name.clone();
    window.click(&format!("node {name}"));
    window.settle();
    picture(&mut window, "chosen");
    window.hover(ground(200.0, 180.0));
    window.key(Key::Tab);
    window.text("er");
    picture(&mut window, "search");
    window.key(Key::Escape);
    window.key(Key::F1);
    picture(&mut window, "keys");
    window.key(Key::Escape);
    window.keys(Modifiers::COMMAND, Key::B);
    picture(&mut window, "build");
}
