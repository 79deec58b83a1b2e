//! The actions of commands that take more than a line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use eframe::egui::{Context, Rect, ViewportCommand, pos2, vec2};
use serde_json::Value as Json;

use super::app::{Editor, FileFor};
use super::canvas::arrange::columns;
use super::canvas::layout::covered;
use super::canvas::{Chosen, GRID};
use super::dialogs::Dialog;
use super::document::Document;
use super::drawing::sheet::Sheet;
use super::drawing::{Drawing, DrawingContext, Tool};
use super::ops;
use super::panels::Tab;
use crate::graph::{Graph, NodeId, Note, Problem};
use crate::whole::Changed;

/// What happens after unsaved work was saved or discarded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum After {
    New,
    Open,
    Start,
    OpenFile(PathBuf),
    Quit,
}

impl Editor {
    pub(super) fn arrange_all(&mut self) {
        let all: BTreeSet<NodeId> = self.graph().nodes().collect();
        self.edit("Arrange all", |g| columns(g, &all));
        self.canvas.show_all();
    }

    fn edit<T>(&mut self, label: &str, change: impl FnOnce(&mut Graph) -> Result<T, Problem>) -> Option<T> {
        match self.document.edit(label, change) {
            Ok(given) => Some(given),
            Err(problem) => {
                self.notices.problem(&problem);
                None
            }
        }
    }

    pub(super) fn on_chosen(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Graph, &BTreeSet<NodeId>) -> Result<(), Problem>,
    ) {
        let ids = self.canvas.chosen.nodes.clone();
        if ids.is_empty() {
            self.notices.fail(format!("{label}: select some nodes first"));
            return;
        }
        self.edit(label, |g| change(g, &ids));
    }

    pub(super) fn pin(&mut self) {
        let chosen = self.canvas.chosen.nodes.first().copied();
        self.pinned =
            if self.pinned.is_some() && (chosen.is_none() || chosen == self.pinned) { None } else { chosen };
    }

    pub(super) fn rename_next(&self, ctx: &Context) {
        ctx.data_mut(|d| d.insert_temp(super::panels::focus_name(), true));
    }

    pub(super) fn copy(&mut self, ctx: &Context) {
        let Chosen { nodes, notes } = &self.canvas.chosen;
        if let Some(text) = ops::copied(self.document.graph(), nodes, notes) {
            ctx.copy_text(text);
        }
    }

    pub(super) fn duplicate(&mut self) {
        let Chosen { nodes, notes } = self.canvas.chosen.clone();
        let nodes: Vec<_> = nodes.into_iter().collect();
        let notes: Vec<_> = notes.into_iter().collect();
        let part = self.graph().fragment(&nodes, &notes);
        let by = f64::from(2.0 * GRID);
        if let Some(new) = self.edit("Duplicate", |g| g.graft(&part, [by, by])) {
            self.canvas.chosen = chosen_of(new);
        }
    }

    /// Pastes a text as nodes and notes where the pointer is.
    pub(super) fn paste(&mut self, text: &str) {
        let at = self.canvas.place();
        match ops::readable(text, &self.registry) {
            Err(e) => self.notices.fail(format!("What is on the clipboard is not a part of a graph: {e}")),
            Ok(part) => {
                if let Some(new) = self.edit("Paste", |g| ops::paste(g, &part, at)) {
                    self.canvas.chosen = chosen_of(new);
                }
            }
        }
    }

    pub(super) fn select_all(&mut self) {
        let graph = self.document.graph();
        let notes = graph.notes().map(|(name, _)| name.to_owned()).collect();
        self.canvas.chosen = Chosen { nodes: graph.nodes().collect(), notes };
    }

    /// Removes what is chosen in the drawing, or else on the canvas.
    pub(super) fn remove(&mut self, bridge: bool) {
        let (drawing, mut cx) = self.drawing_context();
        if !drawing.delete(&mut cx) {
            self.remove_nodes(bridge);
        }
    }

    pub(super) fn remove_nodes(&mut self, bridge: bool) {
        let Chosen { nodes, notes } = std::mem::take(&mut self.canvas.chosen);
        if nodes.is_empty() && notes.is_empty() {
            return;
        }
        let label =
            if nodes.len() > 1 { format!("Delete {} nodes", nodes.len()) } else { "Delete".to_owned() };
        self.edit(&label, |g| ops::remove(g, &nodes, &notes, bridge));
    }

    /// The drawing, with the chosen node as its node.
    fn drawing_context(&mut self) -> (&mut Drawing, DrawingContext<'_>) {
        let node = self.canvas.chosen.lone();
        (&mut self.drawing, DrawingContext { document: &mut self.document, notices: &mut self.notices, node })
    }

    /// Starts to draw curves: on the chosen node where its kind holds curves, else on new nodes that turn curves into
    /// heights.
    pub(super) fn draw(&mut self) {
        let (drawing, cx) = self.drawing_context();
        drawing.read(&cx);
        if matches!(drawing.sheet(), Some(Sheet::Curves(_) | Sheet::Trail(_))) {
            drawing.begin_curve();
            return;
        }
        let at = self.free_place();
        let chain = ["feature_curves", "curve_raster", "diffuse"];
        let new = self.edit("Draw curves", |g| ops::add_chain(g, at, &chain));
        if let Some([first, .., last]) = new.as_deref() {
            self.hold_view(*last);
            self.canvas.chosen = Chosen::only(*first);
            self.canvas.show_all();
            let (drawing, cx) = self.drawing_context();
            drawing.read(&cx);
            drawing.begin_curve();
        }
    }

    /// Starts to paint a mask: on the chosen node where its kind holds strokes, else on a new node.
    pub(super) fn paint(&mut self) {
        let (drawing, cx) = self.drawing_context();
        drawing.read(&cx);
        if !matches!(drawing.sheet(), Some(Sheet::Strokes(_))) {
            let at = self.free_place();
            let new = self.edit("Paint mask", |g| ops::add_chain(g, at, &["paint_mask"]));
            let Some(&[id]) = new.as_deref() else { return };
            self.hold_view(id);
            self.canvas.chosen = Chosen::only(id);
            self.canvas.show_all();
            let (drawing, cx) = self.drawing_context();
            drawing.read(&cx);
        }
        let terrain = self.graph().terrain();
        let long = terrain.width.max(terrain.depth);
        let brush = &mut self.drawing.brush.radius.0;
        // A brush much smaller than a pixel or larger than the terrain is of no use.
        *brush = brush.clamp(long / 1000.0, long / 4.0);
        self.drawing.tool = Tool::Brush;
    }

    /// A place where new nodes cover no others: the pointer, or else below all nodes.
    fn free_place(&self) -> [f64; 2] {
        let [x, y] = self.canvas.place();
        let graph = self.document.graph();
        let room = Rect::from_min_size(pos2(x as f32, y as f32), vec2(800.0, 160.0));
        if graph.nodes().all(|id| !covered(graph, [id], []).intersects(room)) {
            return [x, y];
        }
        let all = covered(graph, graph.nodes(), []);
        [all.left(), all.bottom() + 2.0 * GRID].map(|v| f64::from((v / GRID).ceil() * GRID))
    }

    /// Pins the shown node, so that it stays in the view when another node is chosen; where nothing is shown, pins a
    /// new node.
    fn hold_view(&mut self, new: NodeId) {
        self.pinned = Some(self.shown_node().unwrap_or(new));
    }

    pub(super) fn add_note(&mut self, ctx: &Context) {
        let graph = self.document.graph();
        let chosen = &self.canvas.chosen;
        let around = covered(graph, chosen.nodes.iter().copied(), []);
        let note = if around.is_positive() {
            let rect = around.expand2(vec2(GRID, GRID));
            let top = rect.top() - super::canvas::layout::NOTE_HEAD;
            Note {
                at: [f64::from(rect.left()), f64::from(top)],
                size: [f64::from(rect.width()), f64::from(rect.bottom() - top)],
                ..Note::default()
            }
        } else {
            Note { at: self.canvas.place(), ..Note::default() }
        };
        let note = Note { title: "Note".to_owned(), ..note };
        if let Some(name) = self.edit("Add note", |g| g.add_note(note)) {
            self.canvas.chosen = Chosen { nodes: BTreeSet::new(), notes: BTreeSet::from([name]) };
            self.tab = Tab::Node;
            ctx.data_mut(|d| d.insert_temp(super::inspector::focus_note(), true));
        }
    }

    /// Leaves the document for something else; asks first when there is unsaved work.
    pub(super) fn leave(&mut self, ctx: &Context, after: After) {
        if self.document.is_unsaved() {
            self.dialog = Dialog::Unsaved(after);
        } else {
            self.go_on(ctx, after);
        }
    }

    pub(super) fn go_on(&mut self, ctx: &Context, after: After) {
        match after {
            After::New => {
                let document = Document::untitled(&self.registry);
                self.adopt(ctx, document);
            }
            After::Open => self.ask(ctx, FileFor::Open),
            After::Start => self.dialog = Dialog::Welcome,
            After::OpenFile(path) => self.open(ctx, &path),
            After::Quit => {
                self.is_closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    pub(super) fn save(&mut self, ctx: &Context) {
        match self.document.path().map(Path::to_owned) {
            Some(path) => _ = self.save_to(ctx, &path),
            None => self.ask(ctx, FileFor::SaveAs),
        }
    }

    /// Writes the file; returns whether it was written.
    pub(super) fn save_to(&mut self, ctx: &Context, path: &Path) -> bool {
        let moved = self.document.path() != Some(path);
        if let Err(e) = self.document.save(path) {
            if Changed::is(&e) && self.changed_on_disk() {
                return false;
            }
            self.notices
                .fail(format!("{} cannot be written: {e}. Nothing is lost: save elsewhere", path.display()));
            return false;
        }
        self.notices.say(format!("Saved {}", path.display()));
        self.preferences.opened(path);
        self.write_preferences();
        if moved {
            self.reclaim(ctx);
            self.start_evaluator(ctx);
        }
        true
    }

    /// Whether saving there would replace a file that is not the document's own.
    pub(super) fn replaces(&self, path: &Path) -> bool {
        path.symlink_metadata().is_ok() && self.document.path() != Some(path)
    }

    /// Uses the path that was chosen in a file dialog.
    pub(super) fn answered(&mut self, ctx: &Context, purpose: FileFor, path: PathBuf) {
        match purpose {
            FileFor::Open => self.open(ctx, &path),
            FileFor::SaveAs => {
                let completed = FileFor::SaveAs.completed(path.clone());
                // The dialog asked about replacing the path as chosen, not with the added extension.
                if completed != path && self.replaces(&completed) {
                    self.dialog = Dialog::Path(FileFor::SaveAs, completed.to_string_lossy().into_owned());
                } else {
                    self.save_to(ctx, &completed);
                }
            }
            FileFor::Build => self.build.folder = path.to_string_lossy().into_owned(),
            FileFor::Parameter(ids, name) => {
                let beside = self.document.path().and_then(Path::parent).and_then(|f| f.canonicalize().ok());
                let inside = beside.as_ref().and_then(|f| path.strip_prefix(f).ok());
                let text = inside.unwrap_or(&path).to_string_lossy().into_owned();
                self.edit(&format!("Set {name}"), |g| ops::set(g, &ids, &name, Json::from(text)));
                if inside.is_none() {
                    self.notices.fail(
                        "This file lies outside the graph's folder. Put it there, or add its folder to \
                         allowed_folders in your configuration, so that graphs of others cannot read your files",
                    );
                }
            }
        }
    }
}

fn chosen_of(new: crate::graph::Grafted) -> Chosen {
    Chosen { nodes: new.nodes.into_iter().collect(), notes: new.notes.into_iter().collect() }
}
