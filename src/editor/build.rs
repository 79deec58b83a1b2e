//! The build: `orograph build` as a process of its own, so that it does the same as on a build farm, the window never
//! blocks, and stopping it always works.

mod progress;

use std::path::PathBuf;

use eframe::egui::{self, Context, RichText, Ui};

use super::app::{Editor, FileFor};
use super::board::BuildRequest;
use super::dialogs::{Dialog, modal};
use super::inspector::named;
use super::theme;
use crate::files::Format;
use crate::graph::Graph;
use progress::Running;

/// The settings of the build, and the build that runs.
pub(super) struct BuildDialog {
    pub(super) folder: String,
    size: u32,
    tiles: u32,
    /// The format of all outputs; `None` where each output has its own.
    format: Option<Format>,
    overwrite: bool,
    chosen: Vec<String>,
    running: Option<Running>,
    /// The program that builds; by default this one.
    pub(super) program: Option<PathBuf>,
}

impl Default for BuildDialog {
    fn default() -> Self {
        Self {
            folder: String::new(),
            size: 2049,
            tiles: 1,
            format: None,
            overwrite: false,
            chosen: Vec::new(),
            running: None,
            program: std::env::current_exe().ok(),
        }
    }
}

impl Editor {
    pub(super) fn open_build(&mut self) {
        let folder = self.document.path().and_then(|p| std::path::absolute(p.parent()?.join("build")).ok());
        if self.build.folder.is_empty()
            && let Some(folder) = folder
        {
            self.build.folder = folder.to_string_lossy().into_owned();
        }
        let names: Vec<String> = self.graph().outputs().map(|(n, _)| n.to_owned()).collect();
        self.build.chosen.retain(|n| names.contains(n));
        if self.build.chosen.is_empty() {
            self.build.chosen = names;
        }
        self.dialog = Dialog::Build;
    }

    pub(super) fn build_window(&mut self, ctx: &Context) -> Option<Dialog> {
        let mut closes = false;
        let closed = modal(ctx, "build", 480.0, |ui| {
            ui.heading("Build");
            if let Some(running) = &mut self.build.running {
                if running.show(ui, &self.build.folder) {
                    self.build.running = None;
                }
            } else {
                self.build_settings(ui, &mut closes);
            }
        });
        let busy = self.build.running.as_ref().is_some_and(Running::goes_on);
        if busy {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
        if (closed || closes) && !busy {
            self.build.running = None;
            return None;
        }
        Some(Dialog::Build)
    }

    fn build_settings(&mut self, ui: &mut Ui, closes: &mut bool) {
        let graph = self.document.graph();
        self.build.settings(ui, graph);
        ui.horizontal(|ui| {
            ui.label("Folder");
            let folder = egui::TextEdit::singleline(&mut self.build.folder).desired_width(300.0);
            let folder = ui.add(folder);
            folder.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::TextEdit, true, "Folder"));
            if ui.button("…").on_hover_text("Choose a folder").clicked() {
                let ctx = ui.ctx().clone();
                self.ask(&ctx, FileFor::Build);
            }
        });
        ui.checkbox(&mut self.build.overwrite, "Overwrite files of others in that folder");
        self.build_estimate(ui);
        let path = self.document.path().map(std::path::Path::to_owned);
        let fault = match &path {
            None => Some("Save the graph first: a build reads the file."),
            Some(_) if self.document.is_unsaved() => {
                Some("There are unsaved changes: a build reads the file.")
            }
            Some(_) if self.build.folder.is_empty() => Some("Say into which folder."),
            Some(_) if self.build.chosen.is_empty() => Some("Select an output."),
            Some(_) => None,
        };
        if let Some(fault) = fault {
            ui.colored_label(theme::WARNING, fault);
        }
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let words = path.as_ref().map(|p| self.build.words(p, self.document.graph()));
            if ui.add_enabled(fault.is_none(), egui::Button::new("Build")).clicked()
                && let Some(words) = &words
            {
                let program = self.build.program.as_deref();
                match Running::start(program, words, ui.ctx()) {
                    Ok(running) => self.build.running = Some(running),
                    Err(e) => self.notices.fail(format!("The build cannot be started: {e}")),
                }
            }
            let unsaved = path.is_some() && self.document.is_unsaved();
            if unsaved
                && ui.button("Save").clicked()
                && let Some(path) = &path
            {
                let ctx = ui.ctx().clone();
                self.save_to(&ctx, path);
            }
            if let Some(words) = &words
                && ui.button("Copy as command line").clicked()
            {
                ui.ctx().copy_text(line(words));
            }
            if ui.button("Close").clicked() {
                *closes = true;
            }
        });
    }

    /// Shows the estimated cost of the build.
    fn build_estimate(&self, ui: &mut Ui) {
        if self.graph().terrain().grid(self.build.size).is_err() {
            return;
        }
        let wanted = self.build.measured(self.document.state());
        let estimate = self.evaluator.as_ref().and_then(|e| e.board().estimate.clone());
        let Some(estimate) = estimate.filter(|e| e.of == wanted) else {
            ui.weak("Estimating…");
            return;
        };
        let mebibytes = estimate.bytes as f64 / f64::from(1 << 20);
        let time = super::canvas::time(estimate.seconds);
        ui.label(format!("Takes about {time} and {mebibytes:.0} MB of memory, before tiles."));
        if let Some(refusal) = estimate.refusal {
            ui.add(egui::Label::new(RichText::new(refusal).color(theme::WARNING)).wrap());
        }
    }
}

impl BuildDialog {
    fn settings(&mut self, ui: &mut Ui, graph: &Graph) {
        let terrain = graph.terrain();
        ui.horizontal(|ui| {
            ui.label("Size");
            egui::ComboBox::from_id_salt("build size").selected_text(self.size.to_string()).show_ui(
                ui,
                |ui| {
                    for size in [513, 1009, 1025, 2017, 2049, 4033, 4097, 8129, 8193, 16385] {
                        if terrain.grid(size).is_ok() {
                            ui.selectable_value(&mut self.size, size, size.to_string());
                        }
                    }
                },
            );
            ui.add(egui::DragValue::new(&mut self.size).range(2..=65_537));
            match terrain.grid(self.size) {
                Ok(grid) => _ = ui.weak(format!("{} × {}, cell {:.2} m", grid.cols, grid.rows, grid.cell())),
                Err(why) => _ = ui.colored_label(theme::WARNING, why),
            }
        });
        ui.horizontal(|ui| {
            ui.label("Tiles per side");
            ui.add(egui::DragValue::new(&mut self.tiles).range(1..=256));
        });
        ui.horizontal(|ui| {
            let text = |f: Option<Format>| f.map_or("as the outputs say", Format::name);
            ui.label("Format");
            let combo = egui::ComboBox::from_id_salt("build format").selected_text(text(self.format));
            let combo = combo.show_ui(ui, |ui| {
                for format in std::iter::once(None).chain(Format::ALL.map(Some)) {
                    ui.selectable_value(&mut self.format, format, text(format));
                }
            });
            named(&combo.response, egui::WidgetType::ComboBox, "Format");
        });
        ui.label("Outputs");
        let quantities = graph.quantities();
        for (name, output) in graph.outputs() {
            let mut on = self.chosen.iter().any(|n| n == name);
            let source = graph.resolved(&output.from);
            let quantity = source.and_then(|source| quantities.get(graph, &source));
            let what = quantity.map_or("cannot be made".to_owned(), |quantity| {
                let format = self.format.unwrap_or_else(|| output.format_for(quantity));
                format!("{}, {}", format.name(), quantity.described())
            });
            if ui.checkbox(&mut on, format!("{name} ({what})")).changed() {
                self.chosen.retain(|n| n != name);
                if on {
                    self.chosen.push(name.to_owned());
                }
            }
        }
    }

    /// The build whose cost is to be estimated.
    pub(super) fn measured(&self, state: u64) -> BuildRequest {
        BuildRequest { state, outputs: self.chosen.clone(), size: self.size }
    }

    /// The arguments of the program.
    fn words(&self, graph: &std::path::Path, document: &Graph) -> Vec<String> {
        let mut words = vec!["build".to_owned(), graph.to_string_lossy().into_owned()];
        let mut say = |name: &str, value: String| words.extend([name.to_owned(), value]);
        say("-o", self.folder.clone());
        say("--size", self.size.to_string());
        if self.tiles > 1 {
            say("--tiles", format!("{0}x{0}", self.tiles));
        }
        if let Some(format) = self.format {
            say("--format", format.name().to_owned());
        }
        if self.chosen.len() < document.outputs().len() {
            self.chosen.iter().for_each(|name| say("--output", name.clone()));
        }
        if self.overwrite {
            words.push("--overwrite".to_owned());
        }
        words
    }
}

/// The command line with the arguments quoted for a shell.
fn line(words: &[String]) -> String {
    let plain = |w: &str| !w.is_empty() && w.chars().all(|c| c.is_ascii_alphanumeric() || "-_./".contains(c));
    let quoted = |w: &String| if plain(w) { w.clone() } else { format!("'{}'", w.replace('\'', r"'\''")) };
    std::iter::once("orograph".to_owned()).chain(words.iter().map(quoted)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_what_a_shell_would_split() {
        let words = ["build", "my hills.graph", "-o", "it's"].map(str::to_owned);
        assert_eq!(line(&words), r"orograph build 'my hills.graph' -o 'it'\''s'");
    }
}
