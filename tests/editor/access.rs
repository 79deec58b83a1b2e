//! What assistive technology and odd screens find.

use eframe::egui::accesskit::Role;
use eframe::egui::{Color32, Context, FontFamily, FontId, Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::{Window, ground, preset};

/// Every control that can be seen and has no name.
fn nameless(window: &Window) -> Vec<String> {
    let controls = |role: Role| {
        matches!(
            role,
            Role::Button
                | Role::CheckBox
                | Role::ComboBox
                | Role::Slider
                | Role::SpinButton
                | Role::TextInput
                | Role::MultilineTextInput
                | Role::RadioButton
                | Role::ColorWell
        )
    };
    let all = window.0.query_all_by(|n| {
        let name = n.label().or(n.value()).unwrap_or_default();
        controls(n.role()) && name.trim().is_empty()
    });
    all.map(|n| format!("{:?} at {:?}", n.accesskit_node().role(), n.rect())).collect()
}

#[test]
fn every_control_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    let mut faults = Vec::new();
    let mut look = |window: &Window, state: &str| {
        faults.extend(nameless(window).into_iter().map(|n| format!("{state}: {n}")));
    };
    look(&window, "opened");
    for tab in ["Graph", "Outputs", "History"] {
        // The menu of the same name comes first.
        window.0.get_all_by_label(tab).last().unwrap().click();
        window.steps(3);
        look(&window, tab);
    }
    window.0.get_all_by_label("Node").last().unwrap().click();
    window.steps(2);
    // A node of every kind.
    let kinds: Vec<_> = window.graph().registry().iter().map(|k| k.id.clone()).collect();
    for kind in &kinds {
        window.add(ground(300.0, 200.0), kind);
        look(&window, kind);
        window.key(Key::Delete);
    }
    window.keys(Modifiers::COMMAND, Key::B);
    look(&window, "build");
    window.key(Key::Escape);
    window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    look(&window, "palette");
    window.key(Key::Escape);
    window.hover(ground(300.0, 200.0));
    window.key(Key::Tab);
    look(&window, "search");
    window.key(Key::Escape);
    window.view("Relief");
    look(&window, "relief");
    let mountain = folder.path().join("mountain.graph");
    std::fs::copy("graphs/mountain.graph", &mountain).unwrap();
    let mut window = Window::on(&mountain);
    window.click("node curves");
    window.click("stream 1");
    window.click("at 0.00");
    look(&window, "curves");
    assert!(faults.is_empty(), "{} without a name:\n{}", faults.len(), faults.join("\n"));
}

/// Where the picture of a sign stands among those of the fonts; one that no font has is drawn as another stands for it.
fn drawn(ctx: &Context, sign: char) -> ([u16; 2], [u16; 2]) {
    let font = FontId::new(14.0, FontFamily::Proportional);
    let galley = ctx.fonts_mut(|f| f.layout_no_wrap(sign.to_string(), font, Color32::WHITE));
    let uv = galley.rows[0].glyphs[0].uv_rect;
    (uv.min, uv.max)
}

#[test]
fn every_sign_in_the_texts_is_in_the_fonts() {
    let ctx = Context::default();
    // There is no device that wants the textures.
    ctx.run_ui(Default::default(), |_| ()).textures_delta.clear();
    let mut checked = 0;
    let mut missing = Vec::new();
    let mut folders = vec![std::path::PathBuf::from("src/editor")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|e| e != "rs") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            for sign in text.chars().filter(|c| !c.is_ascii()) {
                checked += 1;
                if drawn(&ctx, sign) == drawn(&ctx, '\u{10fff0}') {
                    missing.push(format!("{sign} in {}", path.display()));
                }
            }
        }
    }
    assert!(checked > 20 && missing.is_empty(), "{missing:?}");
}

#[test]
fn a_screen_of_twice_the_density_shows_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let [mut one, mut two] = [1.0, 2.0].map(|density| Window::dense(&path, density));
    one.settle();
    two.settle();
    for label in ["node height", "output bent.field", "Outputs", "map view"] {
        let (a, b) =
            (one.0.get_all_by_label(label).last().unwrap(), two.0.get_all_by_label(label).last().unwrap());
        assert!((a.rect().center() - b.rect().center()).length() < 2.0, "{label}");
    }
}
