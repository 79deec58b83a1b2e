//! What the window costs: a frame of a graph of 500 nodes, all of them in sight.

use std::collections::HashMap;

use divan::Bencher;
use eframe::egui::{Context, RawInput, Rect, pos2, vec2};
use orograph::editor::{Editor, Setup};
use orograph::engine::Options;
use orograph::graph::Graph;

fn main() {
    divan::main();
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
    let ctx = Context::default();
    let options = Options { threads: 1, memory: 1 << 20, ..Options::default() };
    let mut editor = Editor::new(&ctx, Setup { path: Some(path), options, ..Setup::default() });
    let mut time = 0.0;
    let mut frame = move || {
        time += 1.0 / 60.0;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1920.0, 1080.0))),
            time: Some(time),
            ..RawInput::default()
        };
        let mut output = ctx.run_ui(input, |ui| editor.frame(ui));
        // There is no device that wants the textures.
        output.textures_delta.clear();
        ctx.tessellate(output.shapes, output.pixels_per_point)
    };
    for _ in 0..5 {
        frame();
    }
    bencher.bench_local(frame);
}
