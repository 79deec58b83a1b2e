//! Notices: short messages in a corner of the window, which disappear after a while.

use std::time::{Duration, Instant};

use eframe::egui::{self, Align2, Color32, Context, RichText, vec2};

use super::theme;
use crate::graph::Problem;
use crate::text::printable;

/// Time that a notice stays visible.
const STAY: Duration = Duration::from_secs(8);
/// The most notices at once.
const MOST: usize = 4;

#[derive(Clone, Debug)]
struct Notice {
    text: String,
    color: Color32,
    until: Instant,
}

/// The notices that are shown.
#[derive(Debug, Default)]
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    /// Shows that something was done.
    pub(crate) fn say(&mut self, text: impl Into<String>) {
        self.put(text.into(), Color32::from_rgb(96, 170, 120));
    }

    /// Shows that something could not be done, and why.
    pub(crate) fn fail(&mut self, text: impl Into<String>) {
        self.put(text.into(), theme::ERROR);
    }

    /// Shows why an edit was refused.
    pub(crate) fn problem(&mut self, problem: &Problem) {
        self.fail(problem.to_string());
    }

    fn put(&mut self, text: String, color: Color32) {
        let text = printable(&text).into_owned();
        self.0.retain(|n| n.text != text);
        if self.0.len() >= MOST {
            self.0.remove(0);
        }
        self.0.push(Notice { text, color, until: Instant::now() + STAY });
    }

    pub(crate) fn show(&mut self, ctx: &Context) {
        let now = Instant::now();
        self.0.retain(|n| n.until > now);
        let Some(next) = self.0.iter().map(|n| n.until - now).min() else { return };
        ctx.request_repaint_after(next);
        let mut closed = None;
        let area = egui::Area::new(egui::Id::new("notices")).order(egui::Order::Foreground);
        area.anchor(Align2::RIGHT_BOTTOM, vec2(-12.0, -34.0)).show(ctx, |ui| {
            for (i, notice) in self.0.iter().enumerate() {
                let frame = egui::Frame::popup(ui.style()).stroke((1.5, notice.color));
                frame.show(ui, |ui| {
                    ui.set_max_width(420.0);
                    ui.horizontal(|ui| {
                        ui.add(egui::Label::new(&notice.text).wrap());
                        if ui.small_button(RichText::new("✖")).on_hover_text("Close").clicked() {
                            closed = Some(i);
                        }
                    });
                });
            }
        });
        if let Some(i) = closed {
            self.0.remove(i);
        }
    }
}
