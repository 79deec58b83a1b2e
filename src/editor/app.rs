//! The window: its state, and what happens in one frame.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Context, Ui};
use eframe::wgpu::TextureFormat;

use super::ask::{Answer, Asker, Question, Reply, system};
use super::build::BuildDialog;
use super::canvas::{Canvas, CanvasContext};
use super::command::Command;
use super::dialogs::Dialog;
use super::document::Document;
use super::drawing::{Drawing, DrawingContext};
use super::evaluator::Evaluator;
use super::file_watch::FileWatch;
use super::notices::Notices;
use super::order::Contents;
use super::panels::Tab;
use super::preferences::Preferences;
use super::recovery::{Claim, Keeper};
use super::views::map::MapView;
use super::views::relief::ReliefView;
use super::views::wipe::Wipe;
use super::{shown, theme};
use crate::engine::Options;
use crate::graph::{Graph, NodeId, Source};
use crate::name::Name;
use crate::nodes::Registry;

/// What an editor starts with.
pub struct Setup {
    /// The graph to open.
    pub path: Option<PathBuf>,
    /// The user's own folder, for preferences and unsaved work; neither is stored where there is none.
    pub home: Option<PathBuf>,
    /// Opens the dialogs for files and folders.
    pub asker: Asker,
    /// The kinds that graphs may use.
    pub registry: Registry,
    /// Threads, memory and time that the engine may use.
    pub options: Options,
    /// The pixel format of the window; there is no relief view where it is `None`.
    pub format: Option<TextureFormat>,
}

impl Default for Setup {
    fn default() -> Self {
        let (registry, options) = (Registry::standard(), Options::default());
        Self { path: None, home: None, asker: Box::new(system), registry, options, format: None }
    }
}

/// The purpose for which a file dialog is open.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileFor {
    Open,
    SaveAs,
    /// The file that these nodes read by the parameter of this name.
    Parameter(Vec<NodeId>, String),
    /// The folder into which a build writes.
    Build,
}

impl FileFor {
    /// The path with the extension `.graph` where a graph is saved; otherwise the path itself.
    pub(super) fn completed(&self, path: PathBuf) -> PathBuf {
        let is_graph = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("graph"));
        if *self != Self::SaveAs || is_graph || path.file_name().is_none() {
            return path;
        }
        let mut completed = path.into_os_string();
        completed.push(".graph");
        completed.into()
    }
}

/// The editor.
pub struct Editor {
    pub(super) registry: Registry,
    pub(super) document: Document,
    pub(super) canvas: Canvas,
    pub(super) map: MapView,
    pub(super) relief: ReliefView,
    pub(super) wipe: Wipe,
    pub(super) drawing: Drawing,
    pub(super) view: Page,
    pub(super) notices: Notices,
    pub(super) preferences: Preferences,
    pub(super) dialog: Dialog,
    pub(super) build: BuildDialog,
    pub(super) tab: Tab,
    pub(super) pinned: Option<NodeId>,
    /// The node that was shown last; it stays in the view while nothing is chosen.
    pub(super) last_shown: Option<NodeId>,
    /// The name of the output that is shown; the first output is shown where the node has none of this name.
    pub(super) output: Option<Name>,
    /// The output that colours the terrain; `None` for the terrain's own colours.
    pub(super) drape: Option<Source>,
    pub(super) asking: Option<(FileFor, Answer)>,
    pub(super) asker: Asker,
    pub(super) evaluator: Option<Evaluator>,
    /// The state of the document whose estimate exceeded a limit and was accepted by the user.
    pub(super) accepted_state: Option<u64>,
    pub(super) last_order: Option<Contents>,
    pub(super) home: Option<PathBuf>,
    pub(super) keeper: Option<Keeper>,
    pub(super) claim: Option<Claim>,
    pub(super) watch: Option<FileWatch>,
    pub(super) map_pixels: egui::Vec2,
    title: String,
    pub(super) options: Options,
    /// Whether the window closes without another question about unsaved work.
    pub(super) is_closing: bool,
}

/// The kind of view above the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    Map,
    Relief,
}

impl Editor {
    /// Starts with a graph or an empty canvas.
    pub fn new(ctx: &Context, setup: Setup) -> Self {
        theme::apply(ctx);
        let registry = setup.registry;
        let preferences = Preferences::read(setup.home.as_deref());
        let mut notices = Notices::default();
        let keeper = setup.home.as_deref().map(Keeper::start).transpose().unwrap_or_else(|e| {
            notices.fail(format!("Unsaved work cannot be kept: {e}. Save often"));
            None
        });
        let orphans = keeper.as_ref().map(Keeper::orphans).unwrap_or_default();
        let dialog = match (orphans.is_empty(), preferences.welcomed || setup.path.is_some()) {
            (false, _) => Dialog::Recover(orphans),
            (true, false) => Dialog::Welcome,
            (true, true) => Dialog::None,
        };
        let mut canvas = Canvas::default();
        canvas.snap = preferences.snap;
        let map = MapView::new(preferences.look, preferences.charts);
        let mut editor = Self {
            document: Document::untitled(&registry),
            registry,
            canvas,
            map,
            relief: ReliefView::new(setup.format),
            wipe: Wipe::default(),
            drawing: Drawing::default(),
            view: Page::Map,
            notices,
            preferences,
            dialog,
            build: BuildDialog::default(),
            tab: Tab::Node,
            pinned: None,
            last_shown: None,
            output: None,
            drape: None,
            asking: None,
            asker: setup.asker,
            evaluator: None,
            accepted_state: None,
            last_order: None,
            home: setup.home,
            keeper,
            claim: None,
            watch: None,
            map_pixels: egui::Vec2::splat(512.0),
            title: String::new(),
            options: setup.options,
            is_closing: false,
        };
        match setup.path {
            Some(path) => editor.open(ctx, &path),
            None => editor.start_evaluator(ctx),
        }
        editor.set_theme(ctx);
        editor
    }

    /// The document that is being edited.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The document, for changes from outside the window.
    pub fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// Shows the relief view, with this many samples along the longer side of the terrain.
    pub fn show_relief(&mut self, samples: u32) {
        (self.view, self.map.samples) = (Page::Relief, Some(samples));
    }

    /// Whether an evaluation is running or about to be ordered.
    pub fn is_busy(&self) -> bool {
        self.evaluator.as_ref().is_some_and(Evaluator::is_busy)
            || self.last_order != Some(self.order_contents())
    }

    /// The lowest and highest value of the field in the view; `None` for a draft and for values that are no field.
    pub fn shown_range(&self) -> Option<(f32, f32)> {
        let board = self.evaluator.as_ref()?.board();
        match &board.shown.as_ref().filter(|s| !s.is_draft)?.value {
            crate::value::Value::Field(field) => field.range(),
            _ => None,
        }
    }

    /// Whether the view shows a draft, which the exact result will replace.
    pub fn shows_draft(&self) -> bool {
        self.evaluator.as_ref().is_some_and(|e| e.board().shown.as_ref().is_some_and(|s| s.is_draft))
    }

    /// The number of results that the view has shown so far, drafts included.
    pub fn showings(&self) -> u64 {
        self.evaluator.as_ref().map_or(0, |e| e.board().showings)
    }

    /// The lowest and highest value in the thumbnail of a node.
    pub fn thumbnail_range(&self, node: &str) -> Option<(f32, f32)> {
        let id = self.document.graph().find(node)?;
        self.evaluator.as_ref()?.board().thumbnails.get(&id)?.range
    }

    /// The number of nodes that have a thumbnail.
    pub fn thumbnails(&self) -> usize {
        self.evaluator.as_ref().map_or(0, |e| e.board().thumbnails.len())
    }

    pub(super) fn set_theme(&self, ctx: &Context) {
        ctx.set_theme(if self.preferences.dark { egui::Theme::Dark } else { egui::Theme::Light });
    }

    /// Handles the input of one frame and draws it.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.answer(&ctx);
        self.look_at_disk(&ctx);
        self.keep(&ctx);
        if !ctx.input(|i| i.pointer.any_down()) && !ctx.egui_wants_keyboard_input() {
            self.document.end_gesture();
        }
        if let Some(command) = self.key(&ctx) {
            self.perform(&ctx, command);
        }
        self.last_shown = self.shown_node();
        self.menu_bar(ui);
        self.status_bar(ui);
        self.side_panel(ui);
        self.views(ui);
        self.center(ui);
        self.dialogs(&ctx);
        self.notices.show(&ctx);
        self.send_order();
        self.set_title(&ctx);
        self.close(&ctx);
    }

    /// The command whose key was pressed; pastes the clipboard where the system asked for that.
    fn key(&mut self, ctx: &Context) -> Option<Command> {
        if self.dialog.is_modal() || self.canvas.is_busy() {
            return None;
        }
        let pasted = ctx.input(|i| {
            i.events.iter().find_map(|e| match e {
                egui::Event::Paste(text) => Some(text.clone()),
                _ => None,
            })
        });
        if let Some(text) = pasted.filter(|_| !ctx.egui_wants_keyboard_input()) {
            self.paste(&text);
        }
        Command::pressed(ctx)
    }

    /// Shows the canvas in the middle of the window and does what was asked there.
    fn center(&mut self, ui: &mut Ui) {
        let requests = egui::CentralPanel::no_frame().show(ui, |ui| {
            let empty = Default::default();
            let guard = self.evaluator.as_ref().map(|e| e.board());
            let board = guard.as_deref().unwrap_or(&empty);
            let pinned = self.pinned;
            let times = self.preferences.times;
            let mut cx = CanvasContext {
                document: &mut self.document,
                board,
                notices: &mut self.notices,
                pinned,
                times,
            };
            self.canvas.show(ui, &mut cx)
        });
        let requests = requests.inner;
        if let Some(id) = requests.pin {
            self.pinned = if self.pinned == Some(id) { None } else { Some(id) };
        }
        if let Some(command) = requests.command {
            let ctx = ui.ctx().clone();
            self.perform(&ctx, command);
        }
    }

    /// Shows the view above the canvas.
    fn views(&mut self, ui: &mut Ui) {
        let height = ui.available_height();
        let panel = egui::Panel::top("views").resizable(true).default_size(height * 0.55);
        panel.size_range(120.0..=(height - 120.0).max(121.0)).show(ui, |ui| {
            self.view_bar(ui);
            let guard = self.evaluator.as_ref().map(|e| e.board());
            let Some(board) = guard.as_deref() else {
                ui.weak("Nothing can be evaluated.");
                return;
            };
            if self.map.charts {
                let charts = egui::Panel::bottom("charts").resizable(true).default_size(120.0);
                charts.size_range(80.0..=400.0).show(ui, |ui| {
                    self.map.charts(ui, board);
                });
            }
            self.map_pixels = ui.available_size() * ui.pixels_per_point();
            let graph = self.document.graph();
            let named = |s: Option<Source>| s.map(|s| shown(&graph.source_text(&s))).unwrap_or_default();
            self.wipe.names = [named(self.target()), named(self.against())];
            let node = self.canvas.chosen.lone();
            let mut cx = DrawingContext { document: &mut self.document, notices: &mut self.notices, node };
            let (wipe, drawing) = (&mut self.wipe, &mut self.drawing);
            match self.view {
                Page::Map => self.map.show(ui, board, wipe, drawing, &mut cx),
                Page::Relief => self.relief.show(ui, board, wipe, drawing, &mut cx),
            }
        });
    }

    /// Opens the dialog for a file; the answer arrives in a later frame.
    pub(super) fn ask(&mut self, ctx: &Context, purpose: FileFor) {
        let question = match &purpose {
            FileFor::Open => Question::Open,
            FileFor::SaveAs => Question::Save(format!("{}.graph", self.document.name())),
            FileFor::Parameter(..) => Question::Source,
            FileFor::Build => Question::Folder,
        };
        let folder = self.document.path().and_then(Path::parent).map(Path::to_owned);
        let answer = (self.asker)(question, folder.as_deref(), ctx);
        self.asking = Some((purpose, answer));
    }

    fn answer(&mut self, ctx: &Context) {
        let Some((purpose, answer)) = self.asking.take() else { return };
        match answer.take() {
            None => self.asking = Some((purpose, answer)),
            Some(Reply::Nothing) => (),
            Some(Reply::Path(path)) => self.answered(ctx, purpose, path),
            Some(Reply::NoDialogs) => {
                let start = self.typed_path(&purpose);
                self.dialog = Dialog::Path(purpose, start);
            }
        }
    }

    pub(super) fn write_preferences(&mut self) {
        self.preferences.snap = self.canvas.snap;
        (self.preferences.look, self.preferences.charts) = (self.map.look, self.map.charts);
        if let Some(home) = &self.home
            && let Err(e) = self.preferences.write(home)
        {
            self.notices.fail(format!("The settings cannot be written: {e}"));
        }
    }

    fn set_title(&mut self, ctx: &Context) {
        let mark = if self.document.is_unsaved() { "* " } else { "" };
        let title = format!("{mark}{} — Orograph", shown(&self.document.name()));
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// The graph that is being edited.
    pub(super) fn graph(&self) -> &Graph {
        self.document.graph()
    }
}

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }
}
