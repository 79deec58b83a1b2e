//! The panel of a painted mask: the brush and the strokes.

use eframe::egui::{self, RichText, Slider, Ui, WidgetType};

use super::Panel;
use super::value::named;
use crate::editor::drawing::Tool;
use crate::editor::drawing::sheet::Sheet;
use crate::graph::NodeId;
use crate::params::Param;

pub(super) fn panel(ui: &mut Ui, panel: &mut Panel<'_>, id: NodeId, param: &Param) {
    let terrain = panel.graph().terrain();
    let long = terrain.width.max(terrain.depth);
    let (drawing, mut cx) = panel.drawing_context(id);
    drawing.read(&cx);
    let Some(Sheet::Strokes(strokes)) = drawing.sheet() else { return };
    let numbers: usize = strokes.iter().map(|s| s.path.len()).sum();
    let count = strokes.len();
    ui.label(RichText::new(&param.name).strong()).on_hover_text(&param.doc);
    ui.horizontal(|ui| {
        let paints = drawing.tool == Tool::Brush && drawing.brush.value.0 >= 0.5;
        let erases = drawing.tool == Tool::Brush && !paints;
        if ui.selectable_label(paints, "Paint").on_hover_text("Drag over the terrain; Esc ends").clicked() {
            drawing.tool = if paints { Tool::Select } else { Tool::Brush };
            drawing.brush.value.0 = 1.0;
        }
        if ui.selectable_label(erases, "Erase").on_hover_text("As holding Alt while painting").clicked() {
            drawing.tool = if erases { Tool::Select } else { Tool::Brush };
            drawing.brush.value.0 = 0.0;
        }
        if ui.add_enabled(count > 0, egui::Button::new("Clear")).clicked() {
            drawing.clear(&mut cx);
        }
    });
    let brush = &mut drawing.brush;
    let row = |ui: &mut Ui, name: &str, slider: Slider<'_>| {
        ui.horizontal(|ui| {
            ui.label(name);
            let moved = ui.add(slider);
            named(&moved, WidgetType::Slider, &format!("brush {name}"));
        });
    };
    let radius = Slider::new(&mut brush.radius.0, long / 2000.0..=long / 2.0).logarithmic(true).suffix(" m");
    row(ui, "radius", radius.max_decimals(1));
    row(ui, "softness", Slider::new(&mut brush.softness.0, 0.0..=1.0).max_decimals(2));
    row(ui, "strength", Slider::new(&mut brush.strength.0, 0.0..=1.0).max_decimals(2));
    ui.weak(format!(
        "{count} stroke{}, {numbers} numbers. [ and ] change the radius.",
        if count == 1 { "" } else { "s" }
    ));
}
