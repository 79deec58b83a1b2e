//! The build: `orograph build` as a process of its own, so that the same happens as on a farm, the window waits for
//! nothing, and stopping is certain.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command as Process, Stdio};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{self, Context, RichText, Ui};

use super::app::{Editor, FileFor};
use super::dialogs::{Dialog, modal};
use super::theme;
use crate::graph::Graph;

/// What the build shall do, and how far it is.
pub(super) struct BuildDialog {
    pub(super) folder: String,
    size: u32,
    tiles: u32,
    overwrite: bool,
    chosen: Vec<String>,
    running: Option<Running>,
    /// The program that builds; this one.
    pub(super) program: Option<PathBuf>,
}

impl Default for BuildDialog {
    fn default() -> Self {
        Self {
            folder: String::new(),
            size: 2049,
            tiles: 1,
            overwrite: false,
            chosen: Vec::new(),
            running: None,
            program: std::env::current_exe().ok(),
        }
    }
}

/// A build that was started.
struct Running {
    child: Child,
    news: Arc<Mutex<News>>,
    ended: Option<bool>,
}

/// What the process has said.
#[derive(Default)]
struct News {
    node: String,
    share: f32,
    done: usize,
    lines: Vec<String>,
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Editor {
    pub(super) fn open_build(&mut self) {
        let folder = self.document.path().and_then(|p| p.parent().map(|f| f.join("build")));
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
            if self.build.running.is_some() {
                self.build_progress(ui);
            } else {
                self.build_settings(ui, &mut closes);
            }
        });
        let busy = self.build.running.as_ref().is_some_and(|r| r.ended.is_none());
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
                && let Err(e) = self.build.start(words, ui.ctx())
            {
                self.notices.fail(format!("The build cannot be started: {e}"));
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

    fn build_progress(&mut self, ui: &mut Ui) {
        let Some(running) = &mut self.build.running else { return };
        if running.ended.is_none()
            && let Ok(Some(status)) = running.child.try_wait()
        {
            running.ended = Some(status.success());
        }
        let news = running.news.lock().unwrap_or_else(PoisonError::into_inner);
        match running.ended {
            None => {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label(format!("{} · {} tasks done", news.node, news.done));
                });
                ui.add(egui::ProgressBar::new(news.share));
            }
            Some(true) => _ = ui.label(RichText::new("Done.").strong()),
            Some(false) => _ = ui.colored_label(theme::ERROR, "The build did not end well."),
        }
        egui::ScrollArea::vertical().max_height(180.0).stick_to_bottom(true).show(ui, |ui| {
            for line in &news.lines {
                ui.add(egui::Label::new(RichText::new(line).small()).wrap());
            }
        });
        drop(news);
        let text = if running.ended.is_none() { "Stop" } else { "Back" };
        if ui.button(text).clicked() {
            self.build.running = None;
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
        ui.label("Outputs");
        for (name, output) in graph.outputs() {
            let mut on = self.chosen.iter().any(|n| n == name);
            let format = output.format.map_or("by its values", crate::files::Format::name);
            if ui.checkbox(&mut on, format!("{name} ({format})")).changed() {
                self.chosen.retain(|n| n != name);
                if on {
                    self.chosen.push(name.to_owned());
                }
            }
        }
    }

    /// The command line, as words.
    fn words(&self, graph: &std::path::Path, document: &Graph) -> Vec<String> {
        let mut words = vec!["build".to_owned(), graph.to_string_lossy().into_owned()];
        let mut say = |name: &str, value: String| words.extend([name.to_owned(), value]);
        say("-o", self.folder.clone());
        say("--size", self.size.to_string());
        if self.tiles > 1 {
            say("--tiles", format!("{0}x{0}", self.tiles));
        }
        if self.chosen.len() < document.outputs().len() {
            self.chosen.iter().for_each(|name| say("--output", name.clone()));
        }
        if self.overwrite {
            words.push("--overwrite".to_owned());
        }
        words
    }

    fn start(&mut self, words: &[String], ctx: &Context) -> std::io::Result<()> {
        let missing = || std::io::Error::other("this program cannot find its own file");
        let program = self.program.clone().ok_or_else(missing)?;
        let mut process = Process::new(program);
        process.args(words).args(["--progress", "json"]);
        process.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = process.spawn()?;
        let news: Arc<Mutex<News>> = Arc::default();
        let streams: [Option<Box<dyn std::io::Read + Send>>; 2] =
            [child.stdout.take().map(|s| Box::new(s) as _), child.stderr.take().map(|s| Box::new(s) as _)];
        for stream in streams.into_iter().flatten() {
            let (news, ctx) = (news.clone(), ctx.clone());
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    hear(&mut news.lock().unwrap_or_else(PoisonError::into_inner), line);
                    ctx.request_repaint();
                }
            });
        }
        self.running = Some(Running { child, news, ended: None });
        Ok(())
    }
}

/// Takes in a line of the process: an event of its progress, or something it says.
fn hear(news: &mut News, line: String) {
    let event = serde_json::from_str::<serde_json::Value>(&line).ok().filter(|e| e["event"].is_string());
    let Some(event) = event else {
        news.lines.push(line);
        return;
    };
    let node = event["node"].as_str().unwrap_or_default().to_owned();
    match event["event"].as_str() {
        Some("started") => (news.node, news.share) = (node, 0.0),
        Some("progress") => (news.node, news.share) = (node, event["share"].as_f64().unwrap_or(0.0) as f32),
        Some("finished") => news.done += 1,
        _ => (),
    }
}

/// A command line for a shell.
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
