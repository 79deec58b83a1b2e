//! Curves and masks drawn onto the terrain by hand.

use eframe::egui::{Key, Modifiers, Pos2, pos2, vec2};
use egui_kittest::kittest::Queryable as _;
use orograph::value::CurveSpec;
use serde_json::{Value as Json, json};

use super::{Window, ground};

const COMMAND: Modifiers = Modifiers::COMMAND;

/// One curve of two control points and two constraint points, made to land that is shown; the curves are chosen.
fn ridge() -> (Window, tempfile::TempDir) {
    ridge_on(257)
}

/// [`ridge`] on a base grid with this many samples along a side.
fn ridge_on(base: u32) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ridge.graph");
    let graph = json!({
        "orograph": 1,
        "terrain": { "origin": [0, 0], "width": 8000, "depth": 8000, "base": base },
        "nodes": {
            "curves": { "kind": "feature_curves", "at": [0, 0], "set": { "curves": [{
                "name": "crest",
                "through": [2000, 4000, 4000, 3500, 6000, 4000],
                "height": [0, 500, 0, 1, 800, 20],
                "slope": [0, 1000, 800, -30, -25]
            }] } },
            "raster": { "kind": "curve_raster", "at": [280, 0], "in": { "curves": "curves.curves" } },
            "land": { "kind": "diffuse", "at": [560, 0], "in": { "constraints": "raster.constraints" } }
        },
        "outputs": { "height": { "from": "land.height" } }
    });
    std::fs::write(&path, serde_json::to_vec(&graph).unwrap()).unwrap();
    let mut window = Window::on(&path);
    window.click("node curves");
    window.settle();
    (window, folder)
}

fn specs(window: &Window) -> Vec<CurveSpec> {
    let id = window.graph().find("curves").unwrap();
    serde_json::from_value(window.graph().node(id).set["curves"].clone()).unwrap()
}

/// Where a place of the terrain of 8 km is on the screen, in the map.
fn on_map(window: &Window, x: f64, y: f64) -> Pos2 {
    let rect = window.rect("map view");
    let side = f64::from((rect.width() - 16.0).min(rect.height() - 16.0));
    let at = |v: f64| ((v / 8000.0 - 0.5) * side) as f32;
    rect.center() + vec2(at(x), at(y))
}

#[test]
fn a_control_point_is_dragged_and_the_land_follows() {
    let (mut window, _folder) = ridge();
    let (before, bytes) = (window.editor().shown_range().unwrap(), window.graph().to_bytes());
    let crest = on_map(&window, 4000.0, 3500.0);
    window.press(crest);
    let from = window.at("control point 1");
    assert!((from - crest).length() < 2.0, "{from} {crest}");
    window.drag(&[from, on_map(&window, 4000.0, 2500.0)]);
    let moved = &specs(&window)[0].through[2..4];
    assert!((moved[0] - 4000.0).abs() < 30.0 && (moved[1] - 2500.0).abs() < 30.0, "{moved:?}");
    let (states, _) = window.editor().document().states();
    assert_eq!(states.last(), Some(&"Move control point"), "one drag is one change");
    assert_eq!(states.len(), 2);
    window.settle();
    let height = window.at("height 1");
    window.drag(&[height, height - vec2(0.0, 60.0)]);
    window.settle();
    let raised = specs(&window)[0].height[4];
    assert!(raised > 850.0, "{raised}");
    let after = window.editor().shown_range().unwrap();
    assert!(after.1 > before.1 + 40.0, "the land rises with the curve: {before:?} {after:?}");
    window.keys(COMMAND, Key::Z);
    window.keys(COMMAND, Key::Z);
    assert_eq!(window.graph().to_bytes(), bytes, "undone to the same bytes");
}

#[test]
fn plateau_extent_and_angle_are_dragged() {
    let (mut window, _folder) = ridge();
    window.press(on_map(&window, 4000.0, 3500.0));
    window.press(window.at("constraint point 0"));
    let [foot, left, angle] = ["control point 0", "extent left 0", "angle left 0"].map(|n| window.at(n));
    window.drag(&[left, left + (left - foot)]);
    let slope = specs(&window)[0].slope.clone();
    assert!((slope[1] - 2000.0).abs() < 80.0 && slope[2] == 800.0, "{slope:?}");
    let angle_now = window.at("angle left 0");
    assert!((angle_now - angle).length() > 1.0, "it stands in the middle of the wider slope");
    window.drag(&[angle_now, angle_now - vec2(0.0, 40.0)]);
    let risen = specs(&window)[0].slope[3];
    assert!(risen > -30.0 && risen < 0.0, "pulled up: {risen}");
    let plateau = window.at("plateau 0");
    window.drag(&[plateau, plateau + vec2(0.0, 15.0)]);
    assert!(specs(&window)[0].height[2] > 100.0, "{:?}", specs(&window)[0].height);
}

#[test]
fn points_are_added_cut_and_deleted() {
    let (mut window, _folder) = ridge();
    let middle = on_map(&window, 4000.0, 3500.0);
    window.press(middle);
    let beside = on_map(&window, 3000.0, 3660.0);
    window.steps(20);
    window.double_click(beside);
    assert_eq!(specs(&window)[0].anchors().len(), 4);
    window.key(Key::Delete);
    assert_eq!(specs(&window)[0].anchors().len(), 3, "the new point was chosen");
    assert!(window.graph().find("curves").is_some(), "the node stays");
    window.0.event(eframe::egui::Event::PointerMoved(beside));
    window.steps(1);
    window.secondary(beside);
    window.click("Add constraint point here");
    assert_eq!(specs(&window)[0].height.len(), 9);
    window.secondary(on_map(&window, 5000.0, 3660.0));
    window.click("Cut here");
    assert_eq!(specs(&window).len(), 2);
    for _ in 0..4 {
        window.keys(COMMAND, Key::Z);
    }
    assert_eq!(specs(&window).len(), 1);
}

#[test]
fn the_key_that_deletes_takes_one_thing_at_a_time() {
    let (mut window, _folder) = ridge();
    window.press(on_map(&window, 4000.0, 3500.0));
    window.press(window.at("control point 1"));
    // As a key that is held repeats.
    for _ in 0..5 {
        window.key(Key::Delete);
    }
    assert_eq!(specs(&window)[0].anchors().len(), 2, "the point, and neither the curve nor the node");
    window.press(window.at("control point 0"));
    (0..3).for_each(|_| window.key(Key::Delete));
    assert_eq!(specs(&window)[0].anchors().len(), 2, "two points stay");
    assert!(window.sees("must keep two control points"));
    window.keys(COMMAND, Key::X);
    window.0.event(eframe::egui::Event::Cut);
    window.steps(3);
    assert!(window.graph().find("curves").is_none(), "cutting is for nodes");
    window.keys(COMMAND, Key::Z);
    window.click("node curves");
    window.press(on_map(&window, 2000.0, 4000.0) - vec2(0.0, 60.0));
    window.key(Key::Delete);
    assert!(
        window.graph().find("curves").is_none(),
        "where nothing is chosen on the terrain, it is the node"
    );
}

#[test]
fn a_line_that_is_none_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.graph");
    for through in [json!([[1600]]), json!([[]]), json!([]), json!("no"), json!([[1, 2, 3], [4]])] {
        let graph = json!({
            "orograph": 1,
            "nodes": {
                "land": { "kind": "constant" },
                "ridge": { "kind": "ridge_line", "set": { "through": through } }
            },
            "outputs": { "height": { "from": "land.field" } }
        });
        std::fs::write(&path, graph.to_string()).unwrap();
        let mut window = Window::on(&path);
        window.settle();
        window.click("node ridge");
        window.key(Key::K);
        let middle = window.rect("map view").center();
        window.press(middle);
        window.steps(20);
        window.press(middle + vec2(40.0, 0.0));
        window.steps(5);
    }
}

#[test]
fn another_document_has_another_drawing() {
    let (mut window, _folder) = ridge();
    window.press(on_map(&window, 4000.0, 3500.0));
    assert!(window.has("control point 1"));
    window.keys(COMMAND, Key::N);
    window.steps(3);
    assert_eq!(window.graph().nodes().len(), 0);
    assert!(!window.has("control point 1"));
    window.add(ground(20.0, 30.0), "feature_curves");
    window.steps(3);
    assert!(window.sees("0 curves"));
}

#[test]
fn handles_bend_a_curve() {
    let (mut window, _folder) = ridge();
    let middle = on_map(&window, 4000.0, 3500.0);
    window.press(middle);
    window.secondary(on_map(&window, 3000.0, 3660.0));
    window.click("Bend by handles");
    let before = specs(&window)[0].bezier.clone();
    assert_eq!(before.len(), 14);
    let handle = window.at("handle 2");
    window.drag(&[handle, handle + vec2(0.0, -40.0)]);
    let after = specs(&window)[0].bezier.clone();
    assert!(after[5] < before[5] - 100.0 && after[9] > before[9] + 50.0, "the pair turns: {after:?}");
}

#[test]
fn new_curves_are_clicked_or_drawn_freely() {
    let (mut window, _folder) = ridge();
    window.key(Key::K);
    for (x, y) in [(1000.0, 6500.0), (3000.0, 7000.0), (5000.0, 6600.0)] {
        window.press(on_map(&window, x, y));
        // Two clicks in quick succession would be a double-click.
        window.steps(20);
    }
    window.key(Key::Enter);
    let all = specs(&window);
    assert_eq!((all.len(), all[1].anchors().len()), (2, 3));
    assert_eq!(all[1].height.len(), 6, "it lies on the ground as it is");
    window.key(Key::K);
    let way: Vec<Pos2> = (0..=20)
        .map(|k| {
            let t = f64::from(k) / 20.0;
            on_map(&window, 1000.0 + 6000.0 * t, 1500.0 + 800.0 * libm::sin(9.0 * t))
        })
        .collect();
    window.drag(&way);
    window.key(Key::Escape);
    let all = specs(&window);
    assert_eq!(all.len(), 3);
    let anchors = all[2].anchors().len();
    assert!((4..=30).contains(&anchors), "as few points as will do: {anchors}");
}

#[test]
fn drawing_on_an_empty_graph_makes_the_nodes_it_needs() {
    let mut window = Window::empty();
    window.hover(ground(60.0, 60.0));
    window.key(Key::K);
    assert_eq!(window.graph().nodes().len(), 3);
    assert_eq!(window.reads("diffuse", "constraints").as_deref(), Some("curve_raster.constraints"));
    window.settle();
    let rect = window.rect("map view");
    for by in [vec2(-60.0, 0.0), vec2(60.0, 20.0)] {
        window.press(rect.center() + by);
        window.steps(20);
    }
    window.key(Key::Enter);
    let id = window.graph().find("feature_curves").unwrap();
    assert_eq!(window.graph().node(id).set["curves"].as_array().map(Vec::len), Some(1));
    window.settle();
    let (_, high) = window.editor().shown_range().unwrap();
    assert!(high > 100.0, "a curve on a plain rises over it: {high}");
}

#[test]
fn the_panel_sets_what_holds_at_a_point() {
    let (mut window, _folder) = ridge();
    window.click("crest");
    window.click("at 1.00");
    let field = window.0.get_all_by_label("height").last().unwrap().rect().center();
    window.press(field);
    window.keys(COMMAND, Key::A);
    window.text("321");
    window.key(Key::Enter);
    assert_eq!(specs(&window)[0].height[4], 321.0);
    window.click("Noise");
    assert_eq!(specs(&window)[0].noise, [1.0, 20.0, 0.4]);
    window.click("Turn round");
    assert_eq!(specs(&window)[0].height[1], 321.0);
}

#[test]
fn a_short_form_is_dragged_by_its_points() {
    let mut window = Window::empty();
    window.add(ground(20.0, 30.0), "ridge_line");
    window.settle();
    let through = |w: &Window| {
        let node = w.graph().node(w.graph().find("ridge_line").unwrap());
        node.set.get("through").cloned().unwrap_or(Json::Null)
    };
    let at = window.at("control point 1");
    window.drag(&[at, at + vec2(10.0, 12.0)]);
    let moved = through(&window);
    assert_eq!(moved.as_array().map(Vec::len), Some(3));
    assert_ne!(moved[1], json!([3400, 3700, 1100]));
    assert_eq!(moved[1][2], json!(1100), "its height stays");
    let height = window.at("height 1");
    window.drag(&[height, height - vec2(0.0, 30.0)]);
    assert!(through(&window)[1][2].as_f64().unwrap() > 1100.0);
}

#[test]
fn a_mask_is_painted_erased_and_undone() {
    let mut window = Window::empty();
    window.hover(ground(60.0, 60.0));
    window.key(Key::M);
    window.settle();
    let strokes = |w: &Window| {
        let node = w.graph().node(w.graph().find("paint_mask").unwrap());
        node.set.get("strokes").and_then(Json::as_array).cloned().unwrap_or_default()
    };
    assert_eq!(window.editor().shown_range(), Some((0.0, 0.0)));
    let middle = window.rect("map view").center();
    window.drag(&[middle - vec2(50.0, 0.0), middle + vec2(50.0, 10.0), middle + vec2(40.0, 60.0)]);
    window.settle();
    assert_eq!(strokes(&window).len(), 1);
    assert_eq!(window.editor().shown_range(), Some((0.0, 1.0)));
    window.key(Key::CloseBracket);
    window.click("Erase");
    window.drag(&[middle, middle + vec2(5.0, 0.0)]);
    let two = strokes(&window);
    assert_eq!((two.len(), &two[1]["value"]), (2, &json!(0)));
    assert!(two[1]["radius"].as_f64() > two[0]["radius"].as_f64());
    window.keys(COMMAND, Key::Z);
    assert_eq!(strokes(&window).len(), 1, "a stroke is a change");
    window.click("Clear");
    assert!(strokes(&window).is_empty());
}

/// Law 3: a draft is marked as a draft and followed by the exact result.
#[test]
fn drafts_of_a_drag_are_marked_and_followed_by_the_exact_result() {
    let (mut window, folder) = ridge_on(1025);
    window.press(on_map(&window, 4000.0, 3500.0));
    let from = window.at("control point 1");
    window.hover(from);
    window.button(from, true);
    assert!(!window.editor().shows_draft() && !window.paints("draft"), "the result is exact before the drag");
    for k in 1..=3 {
        let shown = window.editor().showings();
        window.hover(from + vec2(0.0, -10.0 * k as f32));
        window.until("a draft is shown", |w| w.editor().showings() > shown && w.editor().shows_draft());
        window.steps(1);
        assert!(!window.editor().shows_draft() || window.paints("draft"), "movement {k}");
        assert!(!window.editor().shows_draft() || window.editor().shown_range().is_none(), "movement {k}");
    }
    window.button(from - vec2(0.0, 30.0), false);
    window.settle();
    assert!(!window.editor().shows_draft() && !window.paints("draft"));
    // A second window opens the changed graph and evaluates it without any draft.
    let path = folder.path().join("moved.graph");
    std::fs::write(&path, window.graph().to_bytes()).unwrap();
    let mut other = Window::on(&path);
    other.click("node curves");
    other.settle();
    assert!(other.editor().shown_range().is_some());
    assert_eq!(window.editor().shown_range(), other.editor().shown_range());
}

#[test]
fn a_curve_is_dragged_in_the_relief() {
    let (window, folder) = ridge();
    drop(window);
    let mut window = Window::drawn(&folder.path().join("ridge.graph"));
    window.click("node curves");
    window.0.get_all_by_label("Relief").next().unwrap().click();
    window.steps(3);
    window.settle();
    window.click("crest");
    window.steps(2);
    let height = window.at("height 1");
    window.drag(&[height, height - pos2(0.0, 40.0).to_vec2()]);
    let raised = specs(&window)[0].height[4];
    assert!(raised > 900.0, "{raised}");
    let point = window.at("control point 1");
    window.drag(&[point, point + vec2(60.0, 0.0)]);
    let moved = &specs(&window)[0].through[2..4];
    assert!((moved[0] - 4000.0).abs() + (moved[1] - 3500.0).abs() > 200.0, "{moved:?}");
}
