//! The document and its file: opening, claims, changes by other programs, recovery.

use std::path::Path;

use eframe::egui::{Context, ViewportCommand};

use super::actions;
use super::app::Editor;
use super::dialogs::Dialog;
use super::document::Document;
use super::evaluator::Evaluator;
use super::file_watch::FileWatch;
use super::recovery::{Claimed, claim};
use crate::engine::{Files, Options, kept_folders};

/// Estimated seconds up to which an evaluation starts without asking the user.
const PATIENCE: f64 = 60.0;

impl Editor {
    /// Opens a file in place of the document, whose unsaved changes are lost.
    pub(super) fn open(&mut self, ctx: &Context, path: &Path) {
        match Document::open(path, &self.registry) {
            Ok(document) => {
                self.preferences.opened(path);
                self.adopt(ctx, document);
            }
            Err(e) => {
                self.notices.fail(format!("{} cannot be opened: {e}", path.display()));
                if self.evaluator.is_none() {
                    self.start_evaluator(ctx);
                }
            }
        }
        self.write_preferences();
    }

    /// Replaces the document.
    pub(super) fn adopt(&mut self, ctx: &Context, document: Document) {
        self.document = document;
        self.canvas.chosen = Default::default();
        self.drawing.forget();
        self.canvas.show_all();
        self.map.show_all();
        self.relief.reset();
        (self.pinned, self.last_shown, self.output) = (None, None, None);
        (self.drape, self.accepted_state) = (None, None);
        self.reclaim(ctx);
        self.choose_result();
        self.start_evaluator(ctx);
    }

    /// Shows the node of the first output of the graph; where it has no output, the last node that no other reads.
    fn choose_result(&mut self) {
        let graph = self.document.graph();
        let first = graph.outputs().find_map(|(name, _)| graph.output_source(name).ok());
        self.pinned = first.map(|s| s.node);
        self.last_shown = graph.nodes().filter(|id| graph.consumers(*id).next().is_none()).last();
    }

    /// Claims the file of the document and watches it; warns when another editor has it open.
    pub(super) fn reclaim(&mut self, ctx: &Context) {
        self.claim = None;
        let wake = ctx.clone();
        let watch = |path: &Path| FileWatch::on(path, move || wake.request_repaint());
        self.watch = self.document.path().map(watch);
        let (Some(home), Some(path)) = (&self.home, self.document.path()) else { return };
        match claim(home, path) {
            Claimed::Ours(claim) => self.claim = Some(claim),
            Claimed::Taken => self.notices.fail(
                "Another editor has this file open. Save under another name, or close it there, so that neither \
                 overwrites the other",
            ),
            Claimed::Unknown => (),
        }
    }

    /// Starts the engine over the folder of the document.
    pub(super) fn start_evaluator(&mut self, ctx: &Context) {
        let mut files = Files::default();
        let folder = self.document.path().map(|p| p.parent().unwrap_or(Path::new(".")).to_owned());
        for folder in folder.into_iter().chain(kept_folders()) {
            if let Err(e) = files.allow_folder(&folder) {
                self.notices.fail(format!("{} cannot be read: {e}", folder.display()));
            }
        }
        let repaint = ctx.clone();
        // The editor asks about long evaluations, so that the engine must not refuse them.
        let options = Options { seconds: f64::INFINITY, ..self.options.clone() };
        let started = Evaluator::start(&options, files, PATIENCE, move || repaint.request_repaint());
        self.last_order = None;
        match started {
            Ok(evaluator) => self.evaluator = Some(evaluator),
            Err(e) => self.notices.fail(format!("Nothing can be evaluated: {e}")),
        }
    }

    /// Reacts to a change of the file by another program.
    pub(super) fn look_at_disk(&mut self, ctx: &Context) {
        if self.dialog.is_modal() || !self.watch.as_ref().is_some_and(FileWatch::take) {
            return;
        }
        if self.changed_on_disk() {
            ctx.request_repaint();
        }
    }

    /// Reads what another program wrote to the file, or asks about it where there is unsaved work. Returns false where
    /// the file is unchanged.
    pub(super) fn changed_on_disk(&mut self) -> bool {
        let Some(bytes) = self.document.foreign_change() else { return false };
        if self.document.is_unsaved() {
            self.dialog = Dialog::Changed(bytes);
        } else {
            self.reload(bytes);
        }
        true
    }

    pub(super) fn reload(&mut self, bytes: Vec<u8>) {
        match self.document.reload(bytes) {
            Ok(()) => {
                // The nodes of the new graph have new ids, even where the names are the same.
                self.canvas.chosen = Default::default();
                self.drawing.forget();
                self.choose_result();
                self.notices.say("The file was changed by another program and has been read again");
            }
            Err(e) => {
                self.notices
                    .fail(format!("The file was changed by another program and is no graph now: {e}"));
            }
        }
    }

    /// Stores unsaved work for recovery when that is due.
    pub(super) fn keep(&mut self, ctx: &Context) {
        let Some(keeper) = &mut self.keeper else { return };
        match keeper.keep(&self.document) {
            Ok(Some(wait)) => ctx.request_repaint_after(wait),
            Ok(None) => (),
            Err(e) => self.notices.fail(format!("Unsaved work cannot be kept: {e}. Save now")),
        }
    }

    /// Handles a request to close the window: asks first where there is unsaved work.
    pub(super) fn close(&mut self, ctx: &Context) {
        let asked = ctx.input(|i| i.viewport().close_requested());
        if asked && self.document.is_unsaved() && !self.is_closing {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.dialog = Dialog::Unsaved(actions::After::Quit);
        } else if asked {
            self.write_preferences();
        }
    }
}
