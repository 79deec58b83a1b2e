//! Dialogs: questions before work is lost, the palette of commands and the search for nodes.

use eframe::egui::{self, Context, Key, Ui};

use super::actions::After;
use super::app::{Editor, FileFor};
use super::command::Command;
use super::fuzzy;
use super::inspector::named_text;
use super::recovery::Orphan;
use crate::editor::shown;
use crate::graph::NodeId;

/// The dialog that is open over the window.
pub(super) enum Dialog {
    None,
    /// The first-run page.
    Welcome,
    /// The offer of unsaved work of sessions that crashed.
    Recover(Vec<Orphan>),
    /// The question about unsaved work, and what follows the answer.
    Unsaved(After),
    /// The question about a file that another program has changed while there is unsaved work; holds its bytes.
    Changed(Vec<u8>),
    /// The list of keys.
    Help,
    /// The list of commands.
    Palette(Finder),
    /// The list of the nodes of the graph.
    Find(Finder),
    /// The settings and the progress of a build.
    Build,
    /// The field for a path, where the system has no file dialogs.
    Path(FileFor, String),
}

/// A search field over a list.
#[derive(Default)]
pub(super) struct Finder {
    query: String,
    chosen: usize,
    has_asked_focus: bool,
}

impl Dialog {
    pub(super) fn palette() -> Self {
        Self::Palette(Finder::default())
    }

    pub(super) fn find() -> Self {
        Self::Find(Finder::default())
    }

    /// Whether keys go to the dialog and not to the editor.
    pub(super) fn is_modal(&self) -> bool {
        !matches!(self, Self::None)
    }
}

impl Editor {
    pub(super) fn dialogs(&mut self, ctx: &Context) {
        let dialog = std::mem::replace(&mut self.dialog, Dialog::None);
        let stays = match dialog {
            Dialog::None => None,
            Dialog::Welcome => self.welcome(ctx),
            Dialog::Recover(orphans) => self.recover(ctx, orphans),
            Dialog::Unsaved(after) => self.unsaved(ctx, after),
            Dialog::Changed(bytes) => self.changed(ctx, bytes),
            Dialog::Help => help(ctx),
            Dialog::Palette(finder) => self.palette(ctx, finder),
            Dialog::Find(finder) => self.find(ctx, finder),
            Dialog::Build => self.build_window(ctx),
            Dialog::Path(purpose, text) => self.path(ctx, purpose, text),
        };
        // A dialog that was opened by a button of this one replaces it.
        if let (Some(dialog), Dialog::None) = (stays, &self.dialog) {
            self.dialog = dialog;
        }
    }

    /// The initial text of the field for a path: the folder of the graph, or the current folder.
    pub(super) fn typed_path(&self, purpose: &FileFor) -> String {
        let own = self.document.path().and_then(std::path::Path::parent).map(std::path::Path::to_owned);
        let folder = own.and_then(|f| std::path::absolute(f).ok()).or_else(|| std::env::current_dir().ok());
        let folder = folder.unwrap_or_default();
        let path = match purpose {
            FileFor::SaveAs => folder.join(format!("{}.graph", self.document.name())),
            FileFor::Build => folder.join("build"),
            FileFor::Open | FileFor::Parameter(..) => folder.join(""),
        };
        path.to_string_lossy().into_owned()
    }

    fn path(&mut self, ctx: &Context, purpose: FileFor, mut text: String) -> Option<Dialog> {
        let (title, button) = match &purpose {
            FileFor::Open => ("Open a graph", "Open"),
            FileFor::SaveAs => ("Save the graph", "Save"),
            FileFor::Parameter(..) => ("Choose a file", "Choose"),
            FileFor::Build => ("Build into a folder", "Choose"),
        };
        let (mut done, mut cancelled) = (false, false);
        let closed = modal(ctx, "path", 560.0, |ui| {
            ui.heading(title);
            ui.weak("This system has no dialog for files: type the path.");
            let edit = ui.add(egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY));
            named_text(&edit, &text, "Path");
            if !edit.has_focus() && !edit.lost_focus() {
                edit.request_focus();
            }
            let replaces =
                purpose == FileFor::SaveAs && self.replaces(&purpose.completed(text.trim().into()));
            if replaces {
                ui.colored_label(super::theme::WARNING, "There is a file of this name.");
            }
            done |= !replaces && edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            ui.horizontal(|ui| {
                done |= ui.button(if replaces { "Replace it" } else { button }).clicked();
                cancelled = ui.button("Cancel").clicked();
            });
        });
        if done && !text.trim().is_empty() {
            let path = purpose.completed(text.trim().into());
            self.answered(ctx, purpose, path);
            return None;
        }
        (!closed && !cancelled).then_some(Dialog::Path(purpose, text))
    }

    fn recover(&mut self, ctx: &Context, mut orphans: Vec<Orphan>) -> Option<Dialog> {
        let (mut taken, mut thrown, mut postponed) = (None, None, false);
        let mut later = modal(ctx, "recover", 520.0, |ui| {
            ui.heading("Unsaved work was found");
            ui.label("The editor did not end well. What was not saved has been kept:");
            for (i, orphan) in orphans.iter().enumerate() {
                ui.separator();
                let name = orphan
                    .path
                    .as_ref()
                    .map_or("a graph without a file".to_owned(), |p| p.display().to_string());
                ui.strong(shown(&name));
                let age = match orphan.when.elapsed().map_or(0, |t| t.as_secs() / 60) {
                    0 => "a moment ago".to_owned(),
                    1 => "a minute ago".to_owned(),
                    n => format!("{n} minutes ago"),
                };
                ui.weak(format!("{age}, {} bytes", orphan.graph.len()));
                ui.horizontal(|ui| {
                    if ui.button("Recover").clicked() {
                        taken = Some(i);
                    }
                    if ui.button("Throw away").clicked() {
                        thrown = Some(i);
                    }
                });
            }
            ui.separator();
            let later = ui.button("Later").on_hover_text("It is offered again at the next start");
            postponed = later.clicked();
        });
        later |= postponed;
        if let Some(i) = thrown {
            orphans.remove(i).forget();
        }
        if let Some(orphan) = taken.filter(|i| *i < orphans.len()).map(|i| orphans.remove(i)) {
            match orphan.document(&self.registry) {
                Ok(document) => {
                    self.adopt(ctx, document);
                    self.notices.say("Recovered. Save it to keep it");
                    // Where there is no keeper, the work is offered again at the next start.
                    if let Some(keeper) = &mut self.keeper {
                        keeper.take(orphan);
                    }
                }
                Err(e) => self.notices.fail(format!("It cannot be read: {e}")),
            }
            later = true;
        }
        (!later && !orphans.is_empty()).then_some(Dialog::Recover(orphans))
    }

    fn unsaved(&mut self, ctx: &Context, after: After) -> Option<Dialog> {
        let mut choice = None;
        let cancelled = modal(ctx, "unsaved", 380.0, |ui| {
            ui.heading("Save the changes?");
            ui.label(format!("`{}` has changes that are in no file.", shown(&self.document.name())));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Save").clicked() {
                    choice = Some(true);
                }
                if ui.button("Discard").clicked() {
                    choice = Some(false);
                }
                if ui.button("Cancel").clicked() {
                    ui.close();
                }
            });
        });
        match choice {
            Some(true) => match self.document.path().map(std::path::Path::to_owned) {
                Some(path) => {
                    if self.save_to(ctx, &path) {
                        self.go_on(ctx, after);
                    }
                    None
                }
                None => {
                    self.ask(ctx, FileFor::SaveAs);
                    None
                }
            },
            Some(false) => {
                self.go_on(ctx, after);
                None
            }
            None => (!cancelled).then_some(Dialog::Unsaved(after)),
        }
    }

    fn changed(&mut self, ctx: &Context, bytes: Vec<u8>) -> Option<Dialog> {
        let mut reload = None;
        modal(ctx, "changed", 460.0, |ui| {
            ui.heading("The file has changed");
            ui.label("Another program has written to this file, and there is unsaved work here. Nothing is lost either way: what you do not choose now stays in the history, or in the file.");
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Read the file").on_hover_text("Undo brings this work back").clicked() {
                    reload = Some(true);
                }
                if ui.button("Keep mine").on_hover_text("The file stays as it is until you save").clicked() {
                    reload = Some(false);
                }
            });
        });
        match reload {
            Some(true) => self.reload(bytes),
            Some(false) => self.document.keep_mine(bytes),
            None => return Some(Dialog::Changed(bytes)),
        }
        None
    }

    fn palette(&mut self, ctx: &Context, mut finder: Finder) -> Option<Dialog> {
        let commands = Command::ALL.iter().copied().filter(|c| self.can(*c) && *c != Command::Palette);
        let hits = finder.hits(commands, |c| (c.name().to_owned(), c.help().to_owned()));
        let picked = finder.show(ctx, "commands", &hits, |ui, c| {
            let key = c.shortcut().map(|s| ui.ctx().format_shortcut(&s)).unwrap_or_default();
            (c.name().to_owned(), key)
        });
        match picked {
            Pick::One(command) => {
                self.perform(ctx, command);
                None
            }
            Pick::None => Some(Dialog::Palette(finder)),
            Pick::Closed => None,
        }
    }

    fn find(&mut self, ctx: &Context, mut finder: Finder) -> Option<Dialog> {
        let graph = self.document.graph();
        let name = |id: &NodeId| graph.node(*id).name.clone();
        let kind = |id: &NodeId| graph.node(*id).kind().map(|k| k.id.to_string()).unwrap_or_default();
        let hits = finder.hits(graph.nodes(), |id| (name(id), kind(id)));
        let picked = finder.show(ctx, "nodes of this graph", &hits, |_, id| (name(id), kind(id)));
        match picked {
            Pick::One(id) => {
                self.go_to(id);
                None
            }
            Pick::None => Some(Dialog::Find(finder)),
            Pick::Closed => None,
        }
    }
}

enum Pick<T> {
    None,
    Closed,
    One(T),
}

impl Finder {
    fn hits<T: Copy>(
        &self,
        all: impl IntoIterator<Item = T>,
        text: impl Fn(&T) -> (String, String),
    ) -> Vec<T> {
        let score = |one: T| {
            let (name, more) = text(&one);
            Some((fuzzy::best(self.query.trim(), &name, [more.as_str()])?, one))
        };
        let mut found: Vec<_> = all.into_iter().filter_map(score).collect();
        if !self.query.trim().is_empty() {
            found.sort_by_key(|(score, _)| -score);
        }
        found.into_iter().map(|(_, one)| one).take(100).collect()
    }

    fn show<T: Copy>(
        &mut self,
        ctx: &Context,
        title: &str,
        hits: &[T],
        text: impl Fn(&Ui, &T) -> (String, String),
    ) -> Pick<T> {
        let mut picked = Pick::None;
        let closed = modal(ctx, title, 420.0, |ui| {
            let pressed = |key| ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, key));
            if pressed(Key::ArrowDown) {
                self.chosen += 1;
            }
            if pressed(Key::ArrowUp) {
                self.chosen = self.chosen.saturating_sub(1);
            }
            self.chosen = self.chosen.min(hits.len().saturating_sub(1));
            if pressed(Key::Enter) {
                picked = hits.get(self.chosen).map_or(Pick::Closed, |one| Pick::One(*one));
            }
            let edit = egui::TextEdit::singleline(&mut self.query).hint_text(format!("Search {title}"));
            let edit = ui.add(edit.desired_width(f32::INFINITY));
            named_text(&edit, &self.query, &format!("Search {title}"));
            if !std::mem::replace(&mut self.has_asked_focus, true) {
                edit.request_focus();
            }
            if edit.changed() {
                self.chosen = 0;
            }
            egui::ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
                for (i, one) in hits.iter().enumerate() {
                    let (name, more) = text(ui, one);
                    let name = shown(&name);
                    ui.horizontal(|ui| {
                        if ui.selectable_label(i == self.chosen, name).clicked() {
                            picked = Pick::One(*one);
                        }
                        ui.weak(more);
                    });
                }
            });
        });
        if closed && matches!(picked, Pick::None) { Pick::Closed } else { picked }
    }
}

/// Shows the list of keys, made from the list of commands.
fn help(ctx: &Context) -> Option<Dialog> {
    let closed = modal(ctx, "keys", 640.0, |ui| {
        ui.heading("Keys");
        egui::ScrollArea::vertical().max_height(460.0).show(ui, |ui| {
            egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
                for command in Command::ALL {
                    let key = command.shortcut().map(|s| ui.ctx().format_shortcut(&s)).unwrap_or_default();
                    ui.monospace(key);
                    ui.label(command.name()).on_hover_text(command.help());
                    ui.end_row();
                }
                let hands = [
                    ("Wheel", "Zoom at the pointer"),
                    ("Middle, right or Space + drag", "Pan"),
                    ("Drag on the ground", "Select by a box; Shift adds"),
                    ("Drag from a port", "Pull a wire; on empty ground it opens the search"),
                    ("Drag a node onto a wire", "Puts it in"),
                    ("Double-click on a wire", "Adds a bend; on a bend removes it"),
                    ("Alt-click on a wire", "Cuts it"),
                    ("Double-click on a node", "Pins it in the view"),
                    ("Shift-drag over the map", "Profile along a line"),
                    ("Drag, Shift-drag, wheel", "In the relief: turn, pan, come nearer"),
                    ("W A S D Q E while dragging", "Fly over the relief"),
                    ("Click on a curve", "Selects it; its points and handles can be dragged"),
                    ("Double-click on a curve", "Adds a control point; with Shift a constraint point"),
                    ("Enter, Esc, double-click", "End a curve that is drawn"),
                    ("Alt while painting", "Erases"),
                    ("[ and ]", "Smaller and larger brush"),
                ];
                for (hand, what) in hands {
                    ui.monospace(hand);
                    ui.label(what);
                    ui.end_row();
                }
            });
        });
    });
    (!closed).then_some(Dialog::Help)
}

/// Shows a modal dialog; returns whether it was closed.
pub(super) fn modal(ctx: &Context, id: &str, width: f32, contents: impl FnOnce(&mut Ui)) -> bool {
    let modal = egui::Modal::new(egui::Id::new(("dialog", id))).show(ctx, |ui| {
        ui.set_width(width);
        contents(ui);
    });
    modal.should_close()
}
