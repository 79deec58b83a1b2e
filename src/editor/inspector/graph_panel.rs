//! The panel of the graph: exposed parameters, terrain, title and other texts.

use eframe::egui::{self, RichText, Ui};

use super::Panel;
use super::value::{self, Edited, Field, labelled};
use crate::editor::shown;
use crate::graph::{About, Exposed, terrain_params};
use crate::params::Param;

/// Shows exposed parameters, terrain and texts of the graph.
pub(crate) fn graph_panel(ui: &mut Ui, panel: &mut Panel<'_>) {
    exposed(ui, panel);
    ui.separator();
    egui::CollapsingHeader::new("Terrain").default_open(true).show(ui, |ui| terrain(ui, panel));
    egui::CollapsingHeader::new("About this graph").show(ui, |ui| about(ui, panel));
}

fn exposed(ui: &mut Ui, panel: &mut Panel<'_>) {
    ui.strong("Parameters");
    let names: Vec<(String, Exposed)> =
        panel.graph().exposed().map(|(name, e)| (name.to_owned(), e.clone())).collect();
    if names.is_empty() {
        let hint = "Nothing is exposed yet. Right-click a parameter of a node to offer it here.";
        ui.add(egui::Label::new(RichText::new(hint).weak()).wrap());
    }
    for (name, own) in names {
        let param = match panel.graph().exposed_param(&name) {
            Ok(param) => param,
            Err(problem) => {
                ui.colored_label(super::theme::ERROR, problem.to_string());
                continue;
            }
        };
        one(ui, panel, &name, &own, &param);
    }
}

fn one(ui: &mut Ui, panel: &mut Panel<'_>, name: &str, own: &Exposed, param: &Param) {
    let doc = if own.about.is_empty() { &param.doc } else { &own.about };
    let field = Field { name, doc, ..Field::of(param, panel.pick_file) };
    let mut next = own.value.clone();
    let mut edited = Edited::No;
    let label = if own.label.is_empty() { name.replace('_', " ") } else { own.label.clone() };
    let row = labelled(ui, &field, RichText::new(shown(&label)).size(13.0), |ui| {
        ui.push_id(("exposed", name), |ui| edited = value::edit(ui, &field, &mut next));
    });
    row.context_menu(|ui| {
        ui.weak(shown(&format!("Sets {}", own.bind.join(", "))));
        if ui.button("Expose no longer").clicked() {
            panel.apply("Unexpose", "", |g| g.unexpose(name).map(drop));
            ui.close();
        }
    });
    if edited != Edited::No && next != own.value {
        panel.apply(&format!("Set {name}"), &format!("exposed {name}"), |g| g.set_exposed(name, next));
        if edited == Edited::Done {
            panel.document.end_gesture();
        }
    }
}

fn terrain(ui: &mut Ui, panel: &mut Panel<'_>) {
    for param in terrain_params() {
        let field = Field::of(param, panel.pick_file);
        let own = panel.graph().terrain_settings().get(&param.name);
        let now = own.cloned().unwrap_or_else(|| param.default.clone());
        let mut next = now.clone();
        let mut edited = Edited::No;
        labelled(ui, &field, RichText::new(param.name.replace('_', " ")).size(13.0), |ui| {
            ui.push_id(("terrain", &param.name), |ui| edited = value::edit(ui, &field, &mut next));
        });
        if edited != Edited::No && next != now {
            let label = format!("Set terrain {}", param.name);
            panel.apply(&label, &label, |g| g.set_terrain(&param.name, next));
            if edited == Edited::Done {
                panel.document.end_gesture();
            }
        }
    }
    let terrain = panel.graph().terrain();
    ui.weak(format!("Base cell {:.2} m.", terrain.base_cell()));
}

fn about(ui: &mut Ui, panel: &mut Panel<'_>) {
    let own = panel.graph().about().clone();
    let mut next = own.clone();
    let line = |ui: &mut Ui, label: &str, text: &mut String| {
        ui.horizontal(|ui| {
            ui.label(label);
            let edit = ui.add(egui::TextEdit::singleline(text).desired_width(f32::INFINITY));
            value::named(&edit, egui::WidgetType::TextEdit, label);
        });
    };
    line(ui, "Title", &mut next.title);
    line(ui, "Author", &mut next.author);
    line(ui, "License", &mut next.license);
    let mut tags = next.tags.join(", ");
    line(ui, "Tags", &mut tags);
    let edit = egui::TextEdit::multiline(&mut next.about).desired_rows(4).hint_text("What it is");
    let edit = ui.add(edit.desired_width(f32::INFINITY));
    value::named(&edit, egui::WidgetType::TextEdit, "About");
    if tags != own.tags.join(", ") {
        next.tags = tags.split(',').map(|t| t.trim().to_owned()).filter(|t| !t.is_empty()).collect();
    }
    if next != own {
        panel.apply("Edit texts", "about", |g: &mut crate::graph::Graph| {
            let next: About = next;
            g.set_about(next);
            Ok(())
        });
    }
}
