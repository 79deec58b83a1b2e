//! Pictures of the main states, which are compared with those in `tests/snapshots`. `UPDATE_SNAPSHOTS=1` renews these,
//! and `OROGRAPH_PICTURES=DIR` writes these and more to a folder.

use std::path::Path;

use eframe::egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::Queryable as _;
use image::RgbaImage;

use super::skip::skip;
use super::{Window, ground, preset};

/// The most pixels that may differ, since rounding changes a few at edges of text and of the terrain.
const LOOSE: usize = 40;

fn picture(window: &mut Window, name: &str) {
    let Some(folder) = std::env::var_os("OROGRAPH_PICTURES") else { return };
    let image = window.0.render().unwrap();
    image.save(Path::new(&folder).join(format!("{name}.png"))).unwrap();
}

/// Compares the window with the picture of a name once the evaluation is done, whose sign is in the status bar.
fn compare(window: &mut Window, name: &str) {
    window.settle();
    picture(window, name);
    if !window.1 {
        // Other devices draw edges differently. CI has the software device and compares.
        skip(name, "the picture was not drawn by a software device", Path::new(""));
        assert!(std::env::var_os("CI").is_none(), "CI compares pictures: it needs Mesa's software Vulkan");
        return;
    }
    let options = SnapshotOptions::new().threshold(1.5).max_failed_pixels(LOOSE);
    window.0.snapshot_options(name, &options);
}

/// A small window on a file, without times on nodes, which differ between runs.
fn small(path: &Path) -> Window {
    let mut window = Window::drawn(path);
    window.0.set_size(vec2(960.0, 600.0));
    window.command("Times on nodes");
    window.key(Key::F);
    window.settle();
    window
}

#[test]
fn main_states() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = small(&preset(folder.path()));
    compare(&mut window, "opened");
    window.view("Relief");
    compare(&mut window, "relief");
    window.key(Key::C);
    window.settle();
    compare(&mut window, "compared");
    window.key(Key::C);
    window.view("Map");
    let first = window.graph().nodes().next().unwrap();
    let name = window.graph().node(first).name.clone();
    window.click(&format!("node {name}"));
    window.settle();
    picture(&mut window, "chosen");
    assert!(window.paints(&name), "the panel shows the chosen node");
    window.hover(ground(200.0, -60.0));
    window.key(Key::Tab);
    window.text("er");
    compare(&mut window, "search");
    window.key(Key::Escape);
    assert!(!window.paints("New graph"));
    window.key(Key::F1);
    // The first row of the list.
    window.until("the list of keys is open", |w| w.paints("New graph"));
    picture(&mut window, "keys");
    window.key(Key::Escape);
    window.until("the list of keys is closed", |w| !w.paints("New graph"));
    window.keys(Modifiers::COMMAND, Key::B);
    window.until("the build is estimated", |w| w.sees("MB of memory"));
    picture(&mut window, "build");
}

#[test]
fn curves_in_both_views() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mountain.graph");
    std::fs::copy("graphs/mountain.graph", &path).unwrap();
    let mut window = small(&path);
    window.click("node curves");
    window.settle();
    window.click("stream 1");
    window.steps(3);
    let point = window.0.query_all_by_label_contains("constraint point 1").next().unwrap().rect().center();
    window.press(point);
    window.steps(30);
    compare(&mut window, "curves_on_the_map");
    window.view("Relief");
    compare(&mut window, "curves_in_the_relief");
}

/// The number of pixels that differ between two pictures of one window.
fn changed_pixels(before: &RgbaImage, after: &RgbaImage) -> usize {
    assert_eq!(before.dimensions(), after.dimensions());
    before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn painting_and_colours_change_what_the_window_shows() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = small(&preset(folder.path()));
    window.hover(ground(500.0, 0.0));
    window.key(Key::M);
    window.settle();
    let middle = window.rect("map view").center();
    let at = |x: f32, y: f32| middle + vec2(x, y);
    let way: Vec<Pos2> =
        (0..=24).map(|k| at(-60.0 + 5.0 * k as f32, 30.0 * libm::sinf(k as f32 * 0.4))).collect();
    let empty = window.0.render().unwrap();
    window.drag(&way);
    window.settle();
    picture(&mut window, "painted");
    assert_eq!(window.editor().thumbnail_range("paint_mask"), Some((0.0, 1.0)));
    let tinted = changed_pixels(&empty, &window.0.render().unwrap());
    assert!(tinted > 1000, "the stroke changes {tinted} pixels of the window");
    window.view("Relief");
    let plain = window.0.render().unwrap();
    window.0.get_by_label("colours").click();
    window.steps(3);
    window.click("bent.field");
    window.settle();
    picture(&mut window, "coloured");
    assert!(window.paints("bent.field"), "the bar names the output that colours the terrain");
    let colored = changed_pixels(&plain, &window.0.render().unwrap());
    assert!(colored > 1000, "the colours change {colored} pixels of the window");
}

#[test]
fn the_first_page() {
    let mut window = Window::fresh();
    compare(&mut window, "welcome");
    window.click("Mountain");
    window.settle();
    assert!(window.graph().find("curves").is_some() && window.editor().shown_range().is_some());
}
