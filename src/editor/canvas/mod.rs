//! The canvas: nodes, wires and notes under a pointer.
//!
//! It draws the document itself and keeps no second graph: what it holds is where one looks, what is chosen and what a
//! hand is doing. A gesture changes the document once, when it ends.

pub(crate) mod arrange;
pub(crate) mod camera;
mod drop;
mod gesture;
pub(crate) mod layout;
mod menu;
mod nodes;
mod notes;
mod paint;
pub(crate) mod search;
pub(crate) mod wire;
mod wires;

use std::collections::{BTreeMap, BTreeSet};

use eframe::egui::{self, PointerButton, Pos2, Rect, Response, Sense, TextureHandle, Ui, Vec2, vec2};

pub(crate) use paint::{short, time};

use camera::{Camera, View};
use gesture::Gesture;
use layout::{Layout, covered};
use search::{Found, Search};
use wire::{Course, courses};

use super::board::Board;
use super::document::Document;
use super::notices::Notices;
use super::ops::{self, End};
use crate::engine::Key;
use crate::graph::{Graph, NodeId, Problem};

/// Distance between the lines that nodes snap to.
pub(crate) const GRID: f32 = 20.0;

/// What is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chosen {
    pub(crate) nodes: BTreeSet<NodeId>,
    pub(crate) notes: BTreeSet<String>,
}

impl Chosen {
    pub(crate) fn only(id: NodeId) -> Self {
        Self { nodes: BTreeSet::from([id]), notes: BTreeSet::new() }
    }

    /// The chosen node where it is the only one.
    pub(crate) fn lone(&self) -> Option<NodeId> {
        self.nodes.first().copied().filter(|_| self.nodes.len() == 1)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.notes.is_empty()
    }

    /// Forgets what the graph no longer has.
    pub(crate) fn prune(&mut self, graph: &Graph) {
        self.nodes.retain(|id| graph.get(*id).is_some());
        self.notes.retain(|name| graph.note(name).is_some());
    }
}

/// The state of the canvas.
pub(crate) struct Canvas {
    pub(crate) camera: Camera,
    pub(crate) chosen: Chosen,
    pub(crate) snap: bool,
    /// Nodes that are seen, for the evaluator to hurry with.
    pub(crate) in_sight: Vec<NodeId>,
    gesture: Gesture,
    search: Option<Search>,
    pictures: BTreeMap<NodeId, (Key, TextureHandle)>,
    /// Where the pointer was last, on the canvas.
    pointer: Pos2,
    screen: Rect,
    fit: bool,
    /// Whether the space bar, while it was down, was used to pan.
    panned: bool,
}

/// What the canvas works with for a frame.
pub(crate) struct Desk<'a> {
    pub(crate) document: &'a mut Document,
    pub(crate) board: &'a Board,
    pub(crate) notices: &'a mut Notices,
    pub(crate) pinned: Option<NodeId>,
    /// Whether nodes tell how long they took.
    pub(crate) times: bool,
}

impl Desk<'_> {
    pub(crate) fn graph(&self) -> &Graph {
        self.document.graph()
    }

    /// Changes the document and tells what refuses to be changed.
    pub(crate) fn edit<T>(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Option<T> {
        match self.document.edit(label, change) {
            Ok(given) => Some(given),
            Err(problem) => {
                self.notices.problem(&problem);
                None
            }
        }
    }
}

/// What a frame of the canvas asks of the window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wishes {
    /// A node to pin in the view.
    pub(crate) pin: Option<NodeId>,
    /// A command that was chosen in a menu.
    pub(crate) command: Option<super::command::Command>,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            chosen: Chosen::default(),
            snap: true,
            in_sight: Vec::new(),
            gesture: Gesture::None,
            search: None,
            pictures: BTreeMap::new(),
            pointer: Pos2::ZERO,
            screen: Rect::NOTHING,
            fit: true,
            panned: false,
        }
    }
}

impl Canvas {
    /// Shows everything in the next frame.
    pub(crate) fn show_all(&mut self) {
        self.fit = true;
    }

    /// Opens the search where the pointer is, or in the middle.
    pub(crate) fn open_search(&mut self) {
        let view = self.view();
        let at = view.pos(self.pointer);
        let at = if self.screen.contains(at) { at } else { self.screen.center() };
        self.search = Some(Search::new(at, view.world(at), None));
    }

    /// Whether a hand is at work, so that keys should wait.
    pub(crate) fn is_busy(&self) -> bool {
        self.search.is_some() || !matches!(self.gesture, Gesture::None)
    }

    /// Where new things should go: the pointer, else the middle.
    pub(crate) fn place(&self) -> [f64; 2] {
        let at = if self.view().seen().contains(self.pointer) {
            self.pointer
        } else {
            self.camera.middle.to_pos2()
        };
        let at = self.snapped(at);
        [f64::from(at.x), f64::from(at.y)]
    }

    /// Shows what is chosen, or everything, as large as fits.
    pub(crate) fn frame(&mut self, graph: &Graph) {
        let some = &self.chosen;
        let rect = if some.is_empty() {
            covered(graph, graph.nodes(), graph.notes().map(|(n, _)| n))
        } else {
            covered(graph, some.nodes.iter().copied(), some.notes.iter().map(String::as_str))
        };
        self.camera.fit(self.screen, rect);
    }

    fn view(&self) -> View {
        View { camera: self.camera, screen: self.screen }
    }

    fn snapped(&self, at: Pos2) -> Pos2 {
        if self.snap { (at / GRID).round() * GRID } else { at }
    }

    /// Draws the canvas and does what hands do.
    pub(crate) fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) -> Wishes {
        let mut wishes = Wishes::default();
        let (screen, ground) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ground.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, "canvas"));
        self.screen = screen;
        self.chosen.prune(desk.graph());
        if std::mem::take(&mut self.fit) {
            let graph = desk.graph();
            let all = covered(graph, graph.nodes(), graph.notes().map(|(n, _)| n));
            self.camera.fit(screen, all);
        }
        self.travel(ui, &ground);
        let view = self.view();
        if let Some(at) = ui.input(|i| i.pointer.hover_pos()).filter(|p| screen.contains(*p)) {
            self.pointer = view.world(at);
        }
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(screen).id_salt("canvas"));
        ui.set_clip_rect(screen.intersect(ui.clip_rect()));
        paint::ground(&ui, &view);
        self.gesture.follow(self.pointer, self.snap, desk.graph());
        self.notes(&mut ui, &view, desk);
        let layouts = self.layouts(desk.graph());
        let courses = all_courses(desk.graph(), &layouts);
        self.wires(&mut ui, &view, &courses, &ground, desk);
        self.nodes(&mut ui, &view, &layouts, desk, &mut wishes);
        self.overlay(&ui, &view, &layouts, &courses, desk);
        self.ground(&ui, &view, &ground, &layouts, desk, &mut wishes);
        self.finish(&ui, &view, &layouts, &courses, desk);
        self.searching(&ui, desk);
        if desk.graph().nodes().len() == 0 && self.search.is_none() {
            paint::invitation(&ui, screen);
        }
        wishes
    }

    /// Pans and zooms.
    fn travel(&mut self, ui: &Ui, ground: &Response) {
        let over = ui.input(|i| i.pointer.hover_pos()).filter(|p| {
            self.screen.contains(*p) && ui.ctx().layer_id_at(*p).is_none_or(|l| l == ui.layer_id())
        });
        let Some(at) = over else { return };
        let (scroll, pinch, hand) = ui.input(|i| {
            let hand = i.pointer.middle_down() || (i.key_down(egui::Key::Space) && i.pointer.primary_down());
            let pinch = i.zoom_delta();
            (i.smooth_scroll_delta(), pinch, hand.then(|| i.pointer.delta()))
        });
        if self.search.is_some() {
            return;
        }
        if pinch != 1.0 {
            self.camera.zoom_at(self.screen, at, pinch);
        } else if scroll.y != 0.0 {
            self.camera.zoom_at(self.screen, at, libm::expf(scroll.y * 0.004));
        }
        if scroll.x != 0.0 {
            self.camera.middle.x -= scroll.x / self.camera.zoom;
        }
        let released = ui.input(|i| i.key_released(egui::Key::Space));
        if released && !std::mem::take(&mut self.panned) && !ui.ctx().egui_wants_keyboard_input() {
            self.open_search();
        }
        if let Some(delta) = hand {
            self.camera.middle -= delta / self.camera.zoom;
            self.panned |= ui.input(|i| i.key_down(egui::Key::Space));
        } else if ground.dragged_by(PointerButton::Secondary) {
            self.camera.middle -= ground.drag_delta() / self.camera.zoom;
        }
    }

    /// Where all nodes are, with those that are being moved where they would come to be.
    fn layouts(&self, graph: &Graph) -> BTreeMap<NodeId, Layout> {
        let by = self.gesture.shift();
        let one = |id: NodeId| {
            let mut layout = Layout::of(graph.node(id));
            if by != Vec2::ZERO && self.gesture.moves(id) {
                layout = layout.moved(by);
            }
            (id, layout)
        };
        graph.nodes().map(one).collect()
    }

    /// What happens on the empty ground: choosing by a box, menus, the search.
    fn ground(
        &mut self,
        ui: &Ui,
        view: &View,
        ground: &Response,
        layouts: &BTreeMap<NodeId, Layout>,
        desk: &mut Desk<'_>,
        wishes: &mut Wishes,
    ) {
        let adds = ui.input(|i| i.modifiers.shift || i.modifiers.command);
        let space = ui.input(|i| i.key_down(egui::Key::Space));
        if ground.clicked() && !adds {
            self.chosen = Chosen::default();
        }
        if ground.double_clicked()
            && wires::under(&all_courses(desk.graph(), layouts), view, self.pointer).is_none()
        {
            self.open_search();
        }
        if ground.drag_started_by(PointerButton::Primary) && !space {
            let from = ui.input(|i| i.pointer.press_origin()).map_or(self.pointer, |p| view.world(p));
            let before = if adds { self.chosen.clone() } else { Chosen::default() };
            self.gesture = Gesture::Box { from, before };
        }
        if let Gesture::Box { from, before } = &self.gesture {
            let area = Rect::from_two_pos(*from, self.pointer);
            let mut chosen = before.clone();
            chosen.nodes.extend(layouts.iter().filter(|(_, l)| area.intersects(l.rect)).map(|(id, _)| *id));
            let inside = |n: &&crate::graph::Note| area.contains_rect(layout::note_rect(n));
            let notes = desk.graph().notes().filter(|(_, n)| inside(n)).map(|(name, _)| name.to_owned());
            chosen.notes.extend(notes);
            self.chosen = chosen;
        }
        ground.context_menu(|ui| wishes.command = menu::ground(ui).or(wishes.command.take()));
    }

    /// Runs the search that is open.
    fn searching(&mut self, ui: &Ui, desk: &mut Desk<'_>) {
        let Some(mut search) = self.search.take() else { return };
        match search.show(ui, self.screen, desk.graph()) {
            Found::Nothing => self.search = Some(search),
            Found::Closed => (),
            Found::Kind(kind) => {
                let at = self.snapped(match search.end {
                    Some(End::To(..)) => search.at - vec2(layout::WIDTH, layout::HEAD),
                    _ => search.at - vec2(0.0, layout::HEAD),
                });
                let at = [f64::from(at.x), f64::from(at.y)];
                let label = format!("Add {}", kind.id);
                if let Some(id) = desk.edit(&label, |g| ops::add(g, &kind, at, search.end)) {
                    self.chosen = Chosen::only(id);
                }
            }
        }
    }
}

fn all_courses(graph: &Graph, layouts: &BTreeMap<NodeId, Layout>) -> Vec<Course> {
    graph.nodes().flat_map(|id| courses(graph, id, |id| layouts.get(&id))).collect()
}
