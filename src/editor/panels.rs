//! The panels around canvas and view: menu bar, side panel and status bar.

use std::cell::RefCell;

use eframe::egui::{self, Context, Id, RichText, Ui};

use super::app::{Editor, FileFor};
use super::canvas::time;
use super::command::Command;
use super::inspector::{Panel, graph_panel, name_field, nodes_panel, note_panel, outputs_panel};
use super::{shown, theme};
use crate::engine::bytes;

/// The pages of the side panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tab {
    Node,
    Graph,
    Outputs,
    History,
}

impl Tab {
    const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Node, "Node", "Parameters of the selected nodes"),
        (Self::Graph, "Graph", "Exposed parameters, terrain and texts of the graph"),
        (Self::Outputs, "Outputs", "The files that a build writes"),
        (Self::History, "History", "All changes; click one to go back to it"),
    ];
}

/// The id under which egui stores that the name field gets the focus in the next frame.
pub(super) fn focus_name() -> Id {
    Id::new("rename next")
}

impl Editor {
    pub(super) fn menu_bar(&mut self, ui: &mut Ui) {
        use Command::*;
        let mut chosen = None;
        egui::Panel::top("menu").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                let menus: [(&str, &[&[Command]]); 5] = [
                    ("File", &[&[New, Start, Open], &[Save, SaveAs], &[Build], &[Quit]]),
                    (
                        "Edit",
                        &[
                            &[Undo, Redo, History],
                            &[Cut, Copy, Paste, Duplicate],
                            &[RemoveBridged, Remove],
                            &[SelectAll, Find],
                        ],
                    ),
                    (
                        "Graph",
                        &[
                            &[AddNode, AddFrame],
                            &[Bypass, Pin, Rename],
                            &[ArrangeTree, ArrangeAll, AlignLeft, AlignTop],
                        ],
                    ),
                    ("Terrain", &[&[Draw, Paint], &[Compare]]),
                    ("View", &[&[FrameView], &[Snap, Times, Theme], &[Palette, Help]]),
                ];
                for (title, groups) in menus {
                    ui.menu_button(title, |ui| {
                        ui.set_min_width(220.0);
                        for (i, group) in groups.iter().enumerate() {
                            if i > 0 {
                                ui.separator();
                            }
                            for &command in *group {
                                if command.button(ui, self.can(command), self.is_on(command)).clicked() {
                                    chosen = Some(command);
                                    ui.close();
                                }
                            }
                        }
                        if title == "File" {
                            self.recent(ui);
                        }
                    });
                }
                let title = &self.document.graph().about().title;
                if !title.is_empty() {
                    ui.separator();
                    ui.weak(title);
                }
            });
        });
        if let Some(command) = chosen {
            let ctx = ui.ctx().clone();
            self.perform(&ctx, command);
        }
    }

    fn recent(&mut self, ui: &mut Ui) {
        if self.preferences.recent.is_empty() {
            return;
        }
        ui.separator();
        ui.weak("Recent");
        for path in self.preferences.recent.clone() {
            let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let hover = path.display().to_string();
            if ui.button(shown(&name)).on_hover_text(shown(&hover)).clicked() {
                ui.close();
                let ctx = ui.ctx().clone();
                self.leave(&ctx, super::actions::After::OpenFile(path));
            }
        }
    }

    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                let nodes = self.graph().nodes().len();
                ui.weak(format!("{nodes} node{}", if nodes == 1 { "" } else { "s" }));
                self.problems(ui);
                self.work(ui);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let terrain = self.graph().terrain();
                    ui.weak(format!("{:.1} × {:.1} km", terrain.width / 1000.0, terrain.depth / 1000.0));
                    ui.weak(if self.document.is_unsaved() { "unsaved" } else { "saved" });
                });
            });
        });
    }

    fn problems(&mut self, ui: &mut Ui) {
        let problems = self.document.problems();
        let worst = problems.iter().filter(|p| p.is_error()).count();
        let (errors, warnings) = (worst, problems.len() - worst);
        // An empty graph has no output yet, which is not worth a warning.
        if problems.is_empty() || self.graph().nodes().len() == 0 {
            return;
        }
        let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let (errors, warnings) = (count(errors, "error"), count(warnings, "warning"));
        let text = match worst {
            0 => RichText::new(warnings).color(theme::WARNING),
            e if e == problems.len() => RichText::new(errors).color(theme::ERROR),
            _ => RichText::new(format!("{errors}, {warnings}")).color(theme::ERROR),
        };
        let mut go = None;
        ui.menu_button(text, |ui| {
            ui.set_min_width(460.0);
            egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
                for problem in problems {
                    let color = if problem.is_error() { theme::ERROR } else { theme::WARNING };
                    let label = egui::Button::new(RichText::new(problem.to_string()).color(color))
                        .wrap()
                        .frame(false);
                    if ui.add(label).clicked() {
                        go = problem.blames();
                        ui.close();
                    }
                }
            });
        });
        if let Some(id) = go {
            self.go_to(id);
        }
    }

    /// Chooses a node and shows it.
    pub(super) fn go_to(&mut self, id: crate::graph::NodeId) {
        self.canvas.chosen = super::canvas::Chosen::only(id);
        self.canvas.frame(self.document.graph());
        self.tab = Tab::Node;
    }

    /// Shows that an evaluation runs, or that one exceeds a limit and needs consent.
    fn work(&mut self, ui: &mut Ui) {
        let Some(evaluator) = &self.evaluator else { return };
        let (is_busy, unstarted) = {
            let board = evaluator.board();
            (board.is_busy, board.unstarted.clone())
        };
        if let Some(unstarted) = unstarted {
            match unstarted.over_budget {
                Some((why, need)) => self.over_budget(ui, &why, need),
                None => {
                    let files = (unstarted.unread > 0)
                        .then(|| format!(" and read {} of files", bytes(unstarted.unread)));
                    let text =
                        format!("would take about {}{}", time(unstarted.seconds), files.unwrap_or_default());
                    ui.colored_label(theme::WARNING, text);
                    if ui.button("Evaluate").clicked() {
                        self.accepted_state = Some(self.document.state());
                    }
                }
            }
        } else if is_busy {
            ui.spinner();
            if ui.small_button("Stop").on_hover_text("Gives up what is being evaluated").clicked() {
                evaluator.stop();
            }
        }
    }

    /// Offers to raise the memory budget.
    fn over_budget(&mut self, ui: &mut Ui, why: &str, need: u64) {
        // Half as much again leaves room for the cache.
        let room = need + need / 2;
        let gibibytes = room as f64 / f64::from(1 << 30);
        ui.colored_label(theme::ERROR, "over the budget of memory").on_hover_text(shown(why));
        let ask = ui.button(format!("Allow {gibibytes:.1} GB"));
        if ask.on_hover_text("Evaluates with so much memory, until the editor is closed").clicked() {
            self.options.memory = room;
            let ctx = ui.ctx().clone();
            self.start_evaluator(&ctx);
        }
    }

    pub(super) fn side_panel(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::right("side").resizable(true).default_size(330.0).size_range(240.0..=620.0);
        panel.show(ui, |ui| {
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                for (tab, name, help) in Tab::ALL {
                    ui.selectable_value(&mut self.tab, tab, name).on_hover_text(help);
                }
            });
            ui.separator();
            let ctx = ui.ctx().clone();
            // Wide contents scroll, so that a long number does not widen the panel beyond the window.
            egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| self.page(ui, &ctx));
        });
    }

    fn page(&mut self, ui: &mut Ui, ctx: &Context) {
        if self.tab == Tab::History {
            self.history(ui);
            return;
        }
        let picked = RefCell::new(None);
        let pick = |name: &str| *picked.borrow_mut() = Some(name.to_owned());
        let mut panel = Panel {
            document: &mut self.document,
            notices: &mut self.notices,
            drawing: &mut self.drawing,
            pick_file: &pick,
        };
        let chosen = &self.canvas.chosen;
        match self.tab {
            Tab::Node if chosen.nodes.is_empty() && chosen.notes.len() == 1 => {
                if let Some(name) = chosen.notes.first() {
                    note_panel(ui, &mut panel, name);
                }
            }
            Tab::Node => {
                if let (Some(id), true) = (chosen.nodes.first(), chosen.nodes.len() == 1)
                    && ctx.data_mut(|d| d.remove_temp::<bool>(focus_name())).is_some()
                {
                    ctx.memory_mut(|m| m.request_focus(name_field(ui, *id)));
                }
                nodes_panel(ui, &mut panel, &chosen.nodes);
            }
            Tab::Graph => graph_panel(ui, &mut panel),
            Tab::Outputs => outputs_panel(ui, &mut panel, chosen.nodes.first().copied()),
            Tab::History => (),
        }
        if let Some(name) = picked.into_inner() {
            let ids = self.canvas.chosen.nodes.iter().copied().collect();
            self.ask(ctx, FileFor::Parameter(ids, name));
        }
    }

    fn history(&mut self, ui: &mut Ui) {
        let (labels, at) = self.document.states();
        let mut go = None;
        for (i, label) in labels.iter().enumerate() {
            let text = RichText::new(shown(label));
            let text = if i > at { text.weak() } else { text };
            let row = ui.selectable_label(i == at, text);
            if row.clicked() {
                go = Some(i);
            }
        }
        if let Some(to) = go {
            self.document.go(to);
        }
    }
}
