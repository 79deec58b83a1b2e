//! The panel of parameters. It is made from the schema of the kinds, so that a new kind needs no panel of its own.

mod curve;
mod curves;
mod gradient;
mod graph_panel;
mod list;
mod note;
mod number;
mod outputs;
mod strokes;
mod value;

pub(crate) use graph_panel::graph_panel;
pub(crate) use note::{focus_note, note_panel};
pub(crate) use outputs::outputs_panel;
pub(crate) use value::{named, named_text};

use std::collections::BTreeSet;

use eframe::egui::{self, Color32, RichText, Ui};
use serde_json::Value as Json;

use super::document::Document;
use super::drawing::{Drawing, DrawingContext};
use super::notices::Notices;
use super::ops;
use super::theme;
use crate::editor::shown;
use crate::graph::{Exposed, Graph, NodeId};
use crate::node::Kind;
use crate::params::Param;
use crate::params::page::{Section, sections};
use crate::widget::Widget;
use value::{Edited, Field};

/// What the panel borrows for a frame.
pub(crate) struct Panel<'a> {
    pub(crate) document: &'a mut Document,
    pub(crate) notices: &'a mut Notices,
    pub(crate) drawing: &'a mut Drawing,
    /// Opens the file dialog for the parameter of a name; the answer arrives in a later frame.
    pub(crate) pick_file: &'a dyn Fn(&str),
}

impl Panel<'_> {
    fn graph(&self) -> &Graph {
        self.document.graph()
    }

    /// The drawing and its context, for a node.
    fn drawing_context(&mut self, node: NodeId) -> (&mut Drawing, DrawingContext<'_>) {
        let cx = DrawingContext { document: self.document, notices: self.notices, node: Some(node) };
        (self.drawing, cx)
    }

    fn apply(
        &mut self,
        label: &str,
        gesture: &str,
        change: impl FnOnce(&mut Graph) -> Result<(), crate::graph::Problem>,
    ) {
        if let Err(problem) = self.document.gesture(label, gesture, change) {
            self.notices.problem(&problem);
        }
    }
}

/// Shows the parameters of the chosen node, or of several nodes of one kind at once.
pub(crate) fn nodes_panel(ui: &mut Ui, panel: &mut Panel<'_>, chosen: &BTreeSet<NodeId>) {
    let ids: Vec<NodeId> = chosen.iter().copied().filter(|id| panel.graph().get(*id).is_some()).collect();
    let Some(&first) = ids.first() else {
        ui.weak("Select a node to see its parameters.");
        return;
    };
    let node = panel.graph().node(first).clone();
    let Some(kind) = node.kind() else {
        ui.heading(shown(&node.name));
        let kind = shown(node.kind.id());
        ui.label(format!("`{kind}` is not known to this version. It is kept as it is and cannot run."));
        return;
    };
    if ids.iter().any(|id| panel.graph().node(*id).kind().map(|k| &k.id) != Some(&kind.id)) {
        ui.heading(format!("{} nodes", ids.len()));
        ui.weak("Select nodes of one kind to set their parameters together.");
        return;
    }
    if let [id] = ids[..] {
        name(ui, panel, id);
    } else {
        ui.heading(format!("{} × {}", ids.len(), kind.id));
    }
    ui.horizontal(|ui| {
        ui.label(RichText::new(kind.id.as_str()).color(ui.visuals().weak_text_color()));
        let help = ui.small_button("?").on_hover_text("What this kind does");
        egui::Popup::menu(&help).width(420.0).show(|ui| page(ui, kind));
    });
    ui.add(egui::Label::new(RichText::new(kind.summary()).size(12.0)).wrap());
    ui.separator();
    if kind.params().is_empty() {
        ui.weak("This kind has no parameters.");
    }
    for param in kind.params() {
        parameter(ui, panel, &ids, param);
    }
    problems(ui, panel, first);
}

fn problems(ui: &mut Ui, panel: &Panel<'_>, id: NodeId) {
    for problem in panel.document.problems().iter().filter(|p| p.blames() == Some(id)) {
        let color = if problem.is_error() { theme::ERROR } else { theme::WARNING };
        ui.separator();
        ui.add(egui::Label::new(RichText::new(problem.to_string()).color(color)).wrap());
    }
}

/// Shows the manual page of a kind.
fn page(ui: &mut Ui, kind: &Kind) {
    egui::ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
        for part in kind.doc().split("\n\n") {
            match part.strip_prefix("# ") {
                Some(title) => ui.strong(title),
                None => ui.label(part.replace('\n', " ")),
            };
        }
        sections(kind.params()).iter().for_each(|section| inside(ui, section));
    });
}

/// Shows the documentation of the values in a list or an object.
fn inside(ui: &mut Ui, section: &Section) {
    ui.strong(format!("In {}", section.name));
    ui.label(&section.form);
    for row in &section.rows {
        let range = if row.range.is_empty() { String::new() } else { format!(" ({})", row.range) };
        ui.label(format!("{}{range}: {}", row.name, row.doc).replace('`', ""));
    }
    if !section.example.is_null() {
        ui.monospace(section.example.to_string());
    }
}

/// Shows the field for the name of a node.
fn name(ui: &mut Ui, panel: &mut Panel<'_>, id: NodeId) {
    let field = ui.id().with(("name", id));
    let own = panel.graph().node(id).name.clone();
    let mut text = ui.data_mut(|d| d.get_temp::<String>(field)).unwrap_or_else(|| own.clone());
    let edit = egui::TextEdit::singleline(&mut text).font(egui::TextStyle::Heading).id(field.with("edit"));
    let edit = ui.add(edit.desired_width(f32::INFINITY));
    named_text(&edit, &text, "Node name");
    if edit.lost_focus() {
        ui.data_mut(|d| d.remove_temp::<String>(field));
        if text != own {
            let renamed = panel.document.edit("Rename", |g| g.rename(id, text.trim()));
            if let Err(problem) = renamed {
                panel.notices.problem(&problem);
            }
        }
    } else if edit.has_focus() {
        ui.data_mut(|d| d.insert_temp(field, text));
    }
}

/// The id of the field in which a node is renamed.
pub(crate) fn name_field(ui: &Ui, id: NodeId) -> egui::Id {
    ui.id().with(("name", id)).with("edit")
}

/// Shows one parameter of some nodes of a kind.
fn parameter(ui: &mut Ui, panel: &mut Panel<'_>, ids: &[NodeId], param: &Param) {
    if let [id] = *ids {
        match param.widget {
            Some(Widget::Curves) => return curves::panel(ui, panel, id, param),
            Some(Widget::Strokes) => return strokes::panel(ui, panel, id, param),
            Some(Widget::CurveOnMap | Widget::Lines) => curves::tool(ui, panel, id),
            _ => (),
        }
    }
    let values: Vec<Json> = ids.iter().map(|id| current(panel.graph(), *id, param)).collect();
    let Some(value) = values.first().cloned() else { return };
    let mixed = values.iter().any(|v| *v != value);
    let exposed = ops::exposed_as(panel.graph(), ids[0], &param.name).map(str::to_owned);
    let changed = values.iter().any(|v| *v != param.default);
    let before = previous(ui, ids, param);
    let field = Field {
        name: &param.name,
        doc: &param.doc,
        shape: &param.shape,
        unit: param.unit.as_deref(),
        soft: param.soft,
        widget: param.widget,
        previous: before.as_ref(),
        pick_file: panel.pick_file,
    };
    let mut edited = Edited::No;
    let mut next = value.clone();
    let row = value::labelled(ui, &field, label_of(ui, param, changed, mixed, exposed.as_deref()), |ui| {
        edited = value::edit(ui, &field, &mut next);
    });
    row.context_menu(|ui| parameter_menu(ui, panel, ids, param, exposed.as_deref(), changed));
    if edited == Edited::No || next == value && !mixed {
        return;
    }
    if param.widget == Some(Widget::Seed) {
        remember(ui, ids, param, value);
    }
    let label = format!("Set {}", path_of(panel.graph(), ids, param));
    let gesture = format!("set {:?}.{}", ids, param.name);
    panel.apply(&label, &gesture, |graph| ops::set(graph, ids, &param.name, next));
    if edited == Edited::Done {
        panel.document.end_gesture();
    }
}

fn label_of(ui: &Ui, param: &Param, changed: bool, mixed: bool, exposed: Option<&str>) -> RichText {
    let name = param.name.replace('_', " ");
    let text = match exposed {
        Some(_) => RichText::new(format!("{name} ⬈")).color(Color32::from_rgb(120, 180, 240)),
        None if mixed => RichText::new(format!("{name} ≠")).color(theme::WARNING),
        None if changed => RichText::new(name).strong(),
        None => RichText::new(name).color(ui.visuals().text_color()),
    };
    text.size(13.0)
}

fn parameter_menu(
    ui: &mut Ui,
    panel: &mut Panel<'_>,
    ids: &[NodeId],
    param: &Param,
    exposed: Option<&str>,
    changed: bool,
) {
    if ui.add_enabled(changed && exposed.is_none(), egui::Button::new("Reset to default")).clicked() {
        let label = format!("Reset {}", path_of(panel.graph(), ids, param));
        panel.apply(&label, "", |g| ids.iter().try_for_each(|id| g.reset(*id, &param.name)));
        panel.document.end_gesture();
        ui.close();
    }
    match exposed {
        Some(name) => {
            ui.weak(format!("Exposed as `{name}`"));
            if ui.button("Expose no longer").clicked() {
                panel.apply("Unexpose", "", |g| g.unexpose(name).map(drop));
                ui.close();
            }
        }
        None if ui.button("Expose as graph parameter").clicked() => {
            let (name, binds) = exposure(panel.graph(), ids, param);
            let exposed = Exposed { bind: binds, label: param.name.replace('_', " "), ..Exposed::default() };
            panel.apply("Expose", "", |g| g.expose(&name, exposed));
            panel.document.end_gesture();
            ui.close();
        }
        None => (),
    }
    ui.separator();
    let path = format!("{}.{}", panel.graph().node(ids[0]).name, param.name);
    if ui.button("Copy as --set").clicked() {
        let value = current(panel.graph(), ids[0], param);
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        ui.ctx().copy_text(format!("--set '{}={text}'", exposed.unwrap_or(&path)));
        ui.close();
    }
}

/// A free name for an exposed parameter, and the parameters that it binds.
fn exposure(graph: &Graph, ids: &[NodeId], param: &Param) -> (String, Vec<String>) {
    let bind = |id: &NodeId| format!("{}.{}", graph.node(*id).name, param.name);
    let taken = |name: &str| graph.exposed().any(|(n, _)| n == name);
    let long = format!("{}_{}", graph.node(ids[0]).name, param.name);
    let mut names =
        [param.name.clone(), long.clone()].into_iter().chain((2..).map(|n| format!("{long}_{n}")));
    let name = names.find(|n| !taken(n)).unwrap_or_default();
    (name, ids.iter().map(bind).collect())
}

/// The name of a parameter of nodes in the history.
fn path_of(graph: &Graph, ids: &[NodeId], param: &Param) -> String {
    match ids {
        [id] => format!("{}.{}", graph.node(*id).name, param.name),
        _ => format!("{} of {} nodes", param.name, ids.len()),
    }
}

/// The value of a parameter of a node.
fn current(graph: &Graph, id: NodeId, param: &Param) -> Json {
    graph.node(id).set.value(&param.name).unwrap_or_else(|| param.default.clone())
}

/// The seed before the last throw of the dice.
fn previous(ui: &Ui, ids: &[NodeId], param: &Param) -> Option<Json> {
    let key = egui::Id::new(("previous", ids.first(), &param.name));
    let text = ui.data(|d| d.get_temp::<String>(key))?;
    serde_json::from_str(&text).ok()
}

fn remember(ui: &Ui, ids: &[NodeId], param: &Param, value: Json) {
    let key = egui::Id::new(("previous", ids.first(), &param.name));
    ui.data_mut(|d| d.insert_temp(key, value.to_string()));
}
