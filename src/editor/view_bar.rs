//! The bar above the view: the shown node, and the settings of the view.

use eframe::egui::{self, ComboBox, DragValue, Ui};

use super::app::{Editor, Page};
use super::command::Command;
use super::drawing::Tool;
use super::drawing::sheet::Sheet;
use super::shade::Mode;
use crate::editor::shown;
use crate::graph::{Graph, Source};
use crate::value::WireType;

impl Editor {
    pub(super) fn view_bar(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (page, name, help) in [
                (Page::Map, "Map", "From above, with a read-out of the values"),
                (
                    Page::Relief,
                    "Relief",
                    "In space: drag turns, Shift-drag pans, the wheel comes nearer, WASD flies while dragging",
                ),
            ] {
                ui.selectable_value(&mut self.view, page, name).on_hover_text(help);
            }
            ui.separator();
            self.shown(ui);
            ui.separator();
            self.look(ui);
            ui.separator();
            self.tools(ui);
            if ui.button("Fit").on_hover_text("Shows the whole terrain").clicked() {
                self.map.show_all();
                self.relief.reset();
            }
        });
    }

    /// Shows the settings of the look.
    fn look(&mut self, ui: &mut Ui) {
        let mode = self.map.look.mode;
        let combo = ComboBox::from_id_salt("look").selected_text(mode.name()).width(64.0).show_ui(ui, |ui| {
            for mode in Mode::ALL {
                ui.selectable_value(&mut self.map.look.mode, mode, mode.name()).on_hover_text(mode.help());
            }
        });
        named(&combo.response, "look");
        self.colours(ui);
        self.samples(ui);
        ui.toggle_value(&mut self.map.look.contours, "Contours").on_hover_text("Lines of equal value");
        ui.toggle_value(&mut self.map.charts, "Charts")
            .on_hover_text("Histogram, and the profile along a line drawn with Shift");
        ui.toggle_value(&mut self.wipe.is_on, "Compare").on_hover_text(Command::Compare.help());
        if self.view == Page::Relief {
            self.in_space(ui);
        }
    }

    /// Shows the choice of the number of samples.
    fn samples(&mut self, ui: &mut Ui) {
        let text = |n: Option<u32>| n.map_or("auto".to_owned(), |n| format!("{n}²"));
        let samples = &mut self.map.samples;
        let combo = ComboBox::from_id_salt("samples").selected_text(text(*samples)).width(58.0);
        let combo = combo.show_ui(ui, |ui| {
            for n in [None, Some(257), Some(513), Some(1025), Some(2049), Some(4097)] {
                ui.selectable_value(samples, n, text(n));
            }
        });
        named(&combo.response, "samples");
        combo.response.on_hover_text(
            "Samples along the longer side; as many as the view can show, or more to look closely",
        );
    }

    /// Shows the choice of the output that colours the terrain.
    fn colours(&mut self, ui: &mut Ui) {
        let graph = self.document.graph();
        let drape = self.drape.clone().filter(|s| graph.wire_type(s).is_some());
        let text = drape.as_ref().map_or("own colours".to_owned(), |s| shown(&graph.source_text(s)));
        let mut picked = drape;
        let combo = ComboBox::from_id_salt("drape").selected_text(text).show_ui(ui, |ui| {
            ui.selectable_value(&mut picked, None, "own colours");
            for source in paints(graph) {
                let text = graph.source_text(&source);
                ui.selectable_value(&mut picked, Some(source), text);
            }
        });
        named(&combo.response, "colours");
        combo.response.on_hover_text("Colours the terrain by any output");
        self.drape = picked;
    }

    /// Shows the settings that only the relief has.
    fn in_space(&mut self, ui: &mut Ui) {
        let times = DragValue::new(&mut self.relief.exaggeration).range(0.1..=20.0).speed(0.02);
        let times = ui.add(times.prefix("× "));
        named(&times, "exaggeration");
        times.on_hover_text("Factor on heights");
        ui.toggle_value(&mut self.relief.water, "Water").on_hover_text("Shows the sea level");
        let sun = ui.button("☀").on_hover_text("Where the light comes from");
        egui::Popup::menu(&sun).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
            let light = &mut self.relief.light;
            let azimuth = egui::Slider::new(&mut light.azimuth, 0..=359).suffix("°").text("from");
            let azimuth = ui.add(azimuth);
            named(&azimuth, "sun from");
            let altitude = ui.add(egui::Slider::new(&mut light.altitude, 5..=90).suffix("°").text("height"));
            named(&altitude, "sun height");
        });
    }

    /// Shows the tools that draw and paint on the terrain.
    fn tools(&mut self, ui: &mut Ui) {
        let (draws, paints) = match self.drawing.sheet() {
            Some(Sheet::Strokes(_)) => (false, self.drawing.tool == Tool::Brush),
            Some(_) => (self.drawing.tool == Tool::Draw, false),
            None => (false, false),
        };
        let ctx = ui.ctx().clone();
        for (on, text, command) in [(draws, "✏ Draw", Command::Draw), (paints, "🎨 Paint", Command::Paint)]
        {
            if ui.selectable_label(on, text).on_hover_text(command.help()).clicked() {
                if on { self.drawing.end_tool() } else { self.perform(&ctx, command) }
            }
        }
    }

    /// Shows the name of the shown node, its pin, and the choice of its output.
    fn shown(&mut self, ui: &mut Ui) {
        let Some(source) = self.target() else {
            ui.weak("nothing selected");
            return;
        };
        let node = self.graph().node(source.node);
        let (name, outputs) = (node.name.clone(), node.kind().map_or(Vec::new(), |k| k.outputs.clone()));
        let mut pinned = self.pinned == Some(source.node);
        let pin = ui.toggle_value(&mut pinned, "📌").on_hover_text("Keeps this node in the view");
        pin.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Checkbox, true, "pin"));
        if pin.changed() {
            self.pinned = pinned.then_some(source.node);
        }
        // The name has a fixed width, so that the rest of the bar does not move.
        let name = shown(&name);
        let label = egui::Label::new(egui::RichText::new(&name).strong()).truncate();
        ui.add_sized([110.0, ui.spacing().interact_size.y], label).on_hover_text(&name);
        if outputs.len() > 1 {
            let combo = egui::ComboBox::from_id_salt("shown output").selected_text(source.port.as_str());
            combo.show_ui(ui, |ui| {
                for port in outputs {
                    let label = ui.selectable_label(port.name == source.port, port.name.as_str());
                    if label.on_hover_text(port.doc.as_str()).clicked() {
                        self.output = Some(port.name);
                    }
                }
            });
        }
    }
}

/// Every output that can colour a terrain.
fn paints(graph: &Graph) -> Vec<Source> {
    let outputs = |id| graph.get(id).and_then(|n| n.kind()).map_or(&[][..], |k| &k.outputs);
    let fits = |wire| matches!(wire, WireType::Field | WireType::Colors | WireType::Vectors);
    let all = graph.nodes().flat_map(|id| outputs(id).iter().map(move |p| (id, p)));
    all.filter(|(_, p)| fits(p.wire)).map(|(node, p)| Source { node, port: p.name.clone() }).collect()
}

fn named(response: &egui::Response, name: &str) {
    super::inspector::named(response, egui::WidgetType::Other, name);
}
