//! The panel of outputs, the files that a build writes.

use eframe::egui::{self, ComboBox, DragValue, RichText, Ui};

use super::Panel;
use super::value::named;
use crate::editor::shown;
use crate::files::{Format, Target};
use crate::graph::{NodeId, Output, Problem};

/// Shows the outputs, and a button that makes the chosen node an output.
pub(crate) fn outputs_panel(ui: &mut Ui, panel: &mut Panel<'_>, chosen: Option<NodeId>) {
    let outputs: Vec<(String, Output)> =
        panel.graph().outputs().map(|(name, o)| (name.to_owned(), o.clone())).collect();
    if outputs.is_empty() {
        ui.weak("No outputs yet: nothing would be built.");
    }
    for (name, output) in &outputs {
        egui::CollapsingHeader::new(RichText::new(shown(name)).strong())
            .id_salt(("output", name))
            .show(ui, |ui| one(ui, panel, name, output));
    }
    add(ui, panel, chosen);
}

fn add(ui: &mut Ui, panel: &mut Panel<'_>, chosen: Option<NodeId>) {
    let port = |id: NodeId| {
        let node = panel.graph().get(id)?;
        let port = node.kind()?.outputs.iter().find(|p| p.wire.is_raster())?;
        Some((node.name.clone(), format!("{}.{}", node.name, port.name)))
    };
    let source = chosen.and_then(port);
    let label = match &source {
        Some((_, from)) => format!("➕ Output of {}", shown(from)),
        None => "➕ Output of the selected node".to_owned(),
    };
    let button = ui.add_enabled(source.is_some(), egui::Button::new(label));
    if let Some((name, from)) = source.filter(|_| button.clicked()) {
        let taken = |n: &str| panel.graph().outputs().any(|(o, _)| o.eq_ignore_ascii_case(n));
        let mut names = std::iter::once(name.clone()).chain((2..).map(|k| format!("{name}_{k}")));
        let name = names.find(|n| !taken(n)).unwrap_or_default();
        panel.apply("Add output", "", |g| g.add_output(&name, Output { from, ..Output::default() }));
        panel.document.end_gesture();
    }
}

fn one(ui: &mut Ui, panel: &mut Panel<'_>, name: &str, own: &Output) {
    let mut next = own.clone();
    let mut text = name.to_owned();
    ui.horizontal(|ui| {
        ui.label("name");
        let id = ui.id().with(("output name", name));
        text = ui.data_mut(|d| d.get_temp::<String>(id)).unwrap_or(text);
        let edit = ui.add(egui::TextEdit::singleline(&mut text).desired_width(140.0));
        named(&edit, egui::WidgetType::TextEdit, "output name");
        if edit.lost_focus() {
            ui.data_mut(|d| d.remove_temp::<String>(id));
            if text != name {
                panel.apply("Rename output", "", |g| g.rename_output(name, text.trim()));
            }
        } else if edit.has_focus() {
            ui.data_mut(|d| d.insert_temp(id, text));
        }
        if ui.small_button("✖").on_hover_text("Remove this output").clicked() {
            panel.apply("Remove output", "", |g| g.remove_output(name).map(drop));
        }
    });
    from(ui, panel, &mut next);
    choose(ui, "format", &mut next.format, Format::ALL, Format::name, "by its values");
    choose(ui, "target", &mut next.target, Target::ALL, Target::name, "none");
    range(ui, &mut next);
    ui.horizontal(|ui| {
        ui.checkbox(&mut next.clip, "clip").on_hover_text("Cuts off what lies beyond the range");
        ui.checkbox(&mut next.flip, "flip").on_hover_text("Writes the rows from south to north");
    });
    if next != *own && panel.graph().output(name).is_some() {
        let gesture = format!("output {name}");
        panel.apply("Change output", &gesture, |g| -> Result<(), Problem> { g.change_output(name, next) });
    }
}

fn from(ui: &mut Ui, panel: &Panel<'_>, next: &mut Output) {
    ui.horizontal(|ui| {
        ui.label("from");
        let combo = ComboBox::from_id_salt("from").selected_text(next.from.clone()).width(170.0);
        let shown = combo.show_ui(ui, |ui| {
            for id in panel.graph().nodes() {
                let node = panel.graph().node(id);
                let ports = node.kind().into_iter().flat_map(|k| &k.outputs);
                for port in ports.filter(|p| p.wire.is_raster()) {
                    let text = format!("{}.{}", node.name, port.name);
                    let label = text.clone();
                    ui.selectable_value(&mut next.from, text, label);
                }
            }
        });
        named(&shown.response, egui::WidgetType::ComboBox, "output from");
    });
}

fn choose<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut Option<T>,
    all: impl IntoIterator<Item = T>,
    name: impl Fn(T) -> &'static str,
    none: &'static str,
) {
    ui.horizontal(|ui| {
        ui.label(label);
        let text = value.map_or(none, &name);
        let shown = ComboBox::from_id_salt(label).selected_text(text).show_ui(ui, |ui| {
            ui.selectable_value(value, None, none);
            for one in all {
                ui.selectable_value(value, Some(one), name(one));
            }
        });
        named(&shown.response, egui::WidgetType::ComboBox, label);
    });
}

fn range(ui: &mut Ui, next: &mut Output) {
    ui.horizontal(|ui| {
        let mut fixed = next.range.is_some();
        ui.checkbox(&mut fixed, "range").on_hover_text("The values of the lowest and the highest integer");
        match (&mut next.range, fixed) {
            (Some(_), false) => next.range = None,
            (slot @ None, true) => *slot = Some([0.0, 1000.0]),
            (Some([low, high]), true) => {
                ui.add(DragValue::new(low));
                ui.label("to");
                ui.add(DragValue::new(high));
            }
            (None, false) => _ = ui.weak("from the base grid"),
        }
    });
}
