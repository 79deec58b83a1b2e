//! What the window costs: a frame of a graph of 500 nodes, all of them in sight; and how long a hand waits for the draft of
//! what it changed.

use std::collections::HashMap;
use std::path::Path;
use std::time::Duration;

use divan::Bencher;
use eframe::egui::{self, Context, RawInput, Rect, pos2, vec2};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use orograph::editor::{Editor, Setup};
use orograph::engine::Options;
use orograph::graph::Graph;
use serde_json::{Value as Json, json};

fn main() {
    divan::main();
}

/// A window of 1920 x 1080 without a device.
struct Window {
    ctx: Context,
    editor: Editor,
    time: f64,
}

impl Window {
    fn on(path: &Path, options: Options) -> Self {
        let ctx = Context::default();
        let editor = Editor::new(&ctx, Setup { path: Some(path.to_owned()), options, ..Setup::default() });
        Self { ctx, editor, time: 0.0 }
    }

    /// Draws a frame, triangles included.
    fn frame(&mut self) {
        self.time += 1.0 / 60.0;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1920.0, 1080.0))),
            time: Some(self.time),
            ..RawInput::default()
        };
        let mut output = self.ctx.run_ui(input, |ui| self.editor.frame(ui));
        // There is no device that wants the textures.
        output.textures_delta.clear();
        self.ctx.tessellate(output.shapes, output.pixels_per_point);
    }

    /// Draws frames until something holds.
    fn until(&mut self, holds: impl Fn(&Editor) -> bool) {
        while !holds(&self.editor) {
            self.frame();
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}

/// Noise, blurs and sums in chains, 25 columns of 20.
fn graph() -> Graph {
    let mut graph = Graph::new();
    let mut last = HashMap::new();
    for k in 0..500 {
        let (col, row) = (k / 20, k % 20);
        let kind = match col % 3 {
            0 => "fractal_noise",
            1 => "blur",
            _ => "combine",
        };
        let id = graph.add(&format!("node_{k}"), kind).expect("adds");
        graph.move_to(id, [280.0 * f64::from(col), 140.0 * f64::from(row)]).expect("moves");
        let input = if kind == "combine" { "a" } else { "field" };
        if let (true, Some(&before)) = (kind != "fractal_noise", last.get(&row)) {
            graph.connect(before, "field", id, input).expect("fits");
        }
        last.insert(row, id);
    }
    graph
}

#[divan::bench(sample_count = 50, sample_size = 1)]
fn frame_of_500_nodes(bencher: Bencher<'_, '_>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("large.graph");
    graph().save(&path).expect("saves");
    let mut window = Window::on(&path, Options { threads: 1, memory: 1 << 20, ..Options::default() });
    (0..5).for_each(|_| window.frame());
    bencher.bench_local(|| window.frame());
}

const SCENES: [&str; 4] = ["mountain", "hills", "canyon", "volcanic_island"];

/// From a change of a curve's height to its draft on the map.
#[divan::bench(sample_count = 30, sample_size = 1, args = SCENES)]
fn draft_on_the_map(bencher: Bencher<'_, '_>, preset: &str) {
    draft_after_a_change(bencher, preset, |_| ());
}

/// The same in the relief, under sun and sky.
#[divan::bench(sample_count = 30, sample_size = 1, args = SCENES)]
fn draft_in_the_relief(bencher: Bencher<'_, '_>, preset: &str) {
    draft_after_a_change(bencher, preset, |editor| editor.show_relief(513));
}

fn draft_after_a_change(bencher: Bencher<'_, '_>, preset: &str, view: impl Fn(&mut Editor)) {
    // A copy, so that no editor claims the preset.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.graph");
    std::fs::copy(format!("graphs/{preset}.graph"), &path).expect("a preset");
    let mut window = Window::on(&path, Options::default());
    view(&mut window.editor);
    window.until(|editor| !editor.is_busy());
    let graph = window.editor.document().graph();
    let kind = |id: &_| graph.node(*id).kind().is_some_and(|k| k.id == "feature_curves");
    let curves = graph.nodes().find(kind).expect("a node of curves");
    let mut raise = 0.0;
    bencher.bench_local(|| {
        raise += 1.0;
        let before = window.editor.showings();
        let change = |graph: &mut Graph| {
            let mut value = graph.node(curves).set["curves"].clone();
            let height: &mut Json = value.pointer_mut("/0/height/1").expect("a height");
            *height = json!(height.as_f64().unwrap_or(0.0) + raise);
            graph.set(curves, "curves", value)
        };
        window.editor.document_mut().gesture("Move height", "height", change).expect("a change");
        window.until(|editor| editor.showings() > before);
    });
}

/// A frame of the relief view on software Vulkan, 960 x 600, the terrain turning; the picture is read back.
#[divan::bench(sample_count = 20, sample_size = 1, args = [513, 1025, 2049, 4097])]
fn relief_on_software(bencher: Bencher<'_, '_>, samples: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.graph");
    std::fs::copy("graphs/first_light.graph", &path).expect("a preset");
    let device = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let mut setup = Some(Setup { path: Some(path), format: Some(device.target_format), ..Setup::default() });
    let builder = Harness::builder().with_size([960.0, 600.0]);
    let builder = builder.renderer(WgpuTestRenderer::from_render_state(device));
    let frame = move |ui: &mut egui::Ui, editor: &mut Option<Editor>| {
        let editor = editor.get_or_insert_with(|| Editor::new(ui.ctx(), setup.take().expect("once")));
        editor.frame(ui);
    };
    let mut window = builder.build_ui_state(frame, None);
    let view = |editor: &mut Editor| editor.show_relief(samples);
    window.run_steps(3);
    window.state_mut().as_mut().map(view).expect("an editor");
    window.run_steps(2);
    while window.state().as_ref().is_some_and(Editor::is_busy) {
        window.run_steps(1);
        std::thread::sleep(Duration::from_millis(5));
    }
    let middle = window.get_by_label("relief view").rect().center();
    window.drag_at(middle);
    let mut turn = 0.0;
    bencher.bench_local(|| {
        turn += 4.0;
        window.hover_at(middle + vec2(turn, 0.0));
        window.run_steps(1);
        window.render().expect("a picture")
    });
}
