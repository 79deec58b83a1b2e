//! A running build: its process, and the progress of its nodes.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command as Process, Stdio};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{self, Context, ProgressBar, RichText, ScrollArea, Ui};

use crate::editor::canvas::time;
use crate::editor::shown;
use crate::editor::theme;

/// A build that was started.
pub(super) struct Running {
    child: Child,
    news: Arc<Mutex<News>>,
    ended: Option<bool>,
}

/// The output of the process so far.
#[derive(Default)]
struct News {
    /// The nodes that have started, in that order.
    nodes: Vec<Node>,
    lines: Vec<String>,
}

/// The progress of a node; a build in tiles runs it more than once.
struct Node {
    name: String,
    share: f32,
    seconds: f64,
    running: u32,
}

impl Drop for Running {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    /// Starts the program with these arguments.
    ///
    /// # Errors
    /// Fails when the program cannot be found or started.
    pub(super) fn start(program: Option<&Path>, words: &[String], ctx: &Context) -> std::io::Result<Self> {
        let missing = || std::io::Error::other("this program cannot find its own file");
        let mut process = Process::new(program.ok_or_else(missing)?);
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
                    news.lock().unwrap_or_else(PoisonError::into_inner).hear(line);
                    ctx.request_repaint();
                }
            });
        }
        Ok(Self { child, news, ended: None })
    }

    pub(super) fn goes_on(&self) -> bool {
        self.ended.is_none()
    }

    /// Shows the progress; returns whether the build was stopped, or has ended and was dismissed.
    pub(super) fn show(&mut self, ui: &mut Ui, folder: &str) -> bool {
        if self.ended.is_none()
            && let Ok(Some(status)) = self.child.try_wait()
        {
            self.ended = Some(status.success());
        }
        match self.ended {
            None => _ = ui.horizontal(|ui| (ui.spinner(), ui.label("Building"))),
            Some(true) => _ = ui.label(RichText::new(format!("Done: see {}", shown(folder))).strong()),
            Some(false) => _ = ui.colored_label(theme::ERROR, "The build did not end well."),
        }
        let news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        let nodes = ScrollArea::vertical().id_salt("nodes").max_height(200.0).stick_to_bottom(true);
        nodes.show(ui, |ui| news.nodes.iter().for_each(|node| node.show(ui)));
        let lines = ScrollArea::vertical().id_salt("lines").max_height(120.0).stick_to_bottom(true);
        lines.show(ui, |ui| {
            for line in &news.lines {
                ui.add(egui::Label::new(RichText::new(shown(line)).small()).wrap());
            }
        });
        drop(news);
        ui.button(if self.goes_on() { "Stop" } else { "Back" }).clicked()
    }
}

impl Node {
    fn show(&self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.add_sized([150.0, 16.0], egui::Label::new(shown(&self.name)).truncate());
            let text = if self.running > 0 { String::new() } else { time(self.seconds) };
            ui.add(ProgressBar::new(self.share).desired_width(260.0).desired_height(14.0).text(text));
        });
    }
}

impl News {
    /// Reads a line of the process: a progress event, or text for the user.
    fn hear(&mut self, line: String) {
        let event = serde_json::from_str::<serde_json::Value>(&line).ok();
        let Some(event) = event.filter(|e| e["event"].is_string()) else {
            self.lines.push(line);
            return;
        };
        let text = |key: &str| event[key].as_str().unwrap_or_default();
        if event["event"] == "news" || event["event"] == "message" {
            self.lines.push(text("text").to_owned());
            return;
        }
        let node = self.node(text("node"));
        match event["event"].as_str() {
            Some("started") => (node.running, node.share) = (node.running + 1, 0.0),
            Some("progress") => node.share = event["share"].as_f64().unwrap_or(0.0) as f32,
            Some("finished") => {
                (node.running, node.share) = (node.running.saturating_sub(1), 1.0);
                node.seconds += event["seconds"].as_f64().unwrap_or(0.0);
            }
            _ => (),
        }
    }

    fn node(&mut self, name: &str) -> &mut Node {
        let found = self.nodes.iter().position(|n| n.name == name);
        let at = found.unwrap_or_else(|| {
            self.nodes.push(Node { name: name.to_owned(), share: 0.0, seconds: 0.0, running: 0 });
            self.nodes.len() - 1
        });
        &mut self.nodes[at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hears_how_far_each_node_is() {
        let mut news = News::default();
        for line in [
            r#"{ "event": "started", "node": "hills" }"#,
            r#"{ "event": "started", "node": "soft" }"#,
            r#"{ "event": "progress", "node": "soft", "share": 0.5 }"#,
            r#"{ "event": "finished", "node": "hills", "seconds": 1.5 }"#,
            r#"{ "event": "started", "node": "hills" }"#,
            r#"{ "event": "finished", "node": "hills", "seconds": 0.5 }"#,
            "warning: x",
            r#"{ "event": "message", "text": "warning: y" }"#,
            r#"{ "event": "news", "text": "wrote height.exr" }"#,
        ] {
            news.hear(line.to_owned());
        }
        let told: Vec<_> = news.nodes.iter().map(|n| (&*n.name, n.share, n.seconds, n.running)).collect();
        assert_eq!(told, [("hills", 1.0, 2.0, 0), ("soft", 0.5, 0.0, 1)]);
        assert_eq!(news.lines, ["warning: x", "warning: y", "wrote height.exr"]);
    }
}
