//! The canvas: nodes, wires and notes that are edited with the pointer.
//!
//! The canvas draws the document itself and keeps no copy of the graph. Its state is the camera, the selection and the
//! gesture in progress. A gesture changes the document once, when it ends.

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

use camera::{Camera, Viewport};
use gesture::Gesture;
use layout::{Layout, covered};
use search::{Search, SearchOutcome};
use wire::{Course, courses};

use super::board::Board;
use super::document::Document;
use super::notices::Notices;
use super::ops::{self, End};
use crate::engine::Key;
use crate::graph::{Graph, NodeId, Problem};

/// Distance between the lines that nodes snap to, in units of the canvas.
pub(crate) const GRID: f32 = 20.0;

/// The chosen nodes and notes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chosen {
    pub(crate) nodes: BTreeSet<NodeId>,
    pub(crate) notes: BTreeSet<String>,
}

impl Chosen {
    pub(crate) fn only(id: NodeId) -> Self {
        Self { nodes: BTreeSet::from([id]), notes: BTreeSet::new() }
    }

    /// The chosen node, where exactly one is chosen.
    pub(crate) fn lone(&self) -> Option<NodeId> {
        self.nodes.first().copied().filter(|_| self.nodes.len() == 1)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.notes.is_empty()
    }

    /// Drops nodes and notes that the graph no longer has.
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
    /// The visible nodes, whose thumbnails the evaluator makes first.
    pub(crate) in_sight: Vec<NodeId>,
    gesture: Gesture,
    search: Option<Search>,
    pictures: BTreeMap<NodeId, (Key, TextureHandle)>,
    /// The last position of the pointer, on the canvas.
    pointer: Pos2,
    screen: Rect,
    needs_fit: bool,
    /// Whether the space bar was used to pan since it was pressed.
    was_panned: bool,
}

/// What the canvas borrows for a frame.
pub(crate) struct CanvasContext<'a> {
    pub(crate) document: &'a mut Document,
    pub(crate) board: &'a Board,
    pub(crate) notices: &'a mut Notices,
    pub(crate) pinned: Option<NodeId>,
    /// Whether nodes show how long they took.
    pub(crate) times: bool,
}

impl CanvasContext<'_> {
    pub(crate) fn graph(&self) -> &Graph {
        self.document.graph()
    }

    /// Changes the document; shows a notice where the change is refused.
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

/// What the user asked for on the canvas that the window has to do.
#[derive(Clone, Debug, Default)]
pub(crate) struct Requests {
    /// A node to pin in the view.
    pub(crate) pin: Option<NodeId>,
    /// A command chosen in a menu.
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
            needs_fit: true,
            was_panned: false,
        }
    }
}

impl Canvas {
    /// Fits the view to the whole graph in the next frame.
    pub(crate) fn show_all(&mut self) {
        self.needs_fit = true;
    }

    /// Opens the search at the pointer, or in the middle where the pointer is outside.
    pub(crate) fn open_search(&mut self) {
        let view = self.view();
        let at = view.pos(self.pointer);
        let at = if self.screen.contains(at) { at } else { self.screen.center() };
        self.search = Some(Search::new(at, view.world(at), None));
    }

    /// Whether a gesture is in progress or the search is open, so that keys do not run commands.
    pub(crate) fn is_busy(&self) -> bool {
        self.search.is_some() || !matches!(self.gesture, Gesture::None)
    }

    /// The place for new nodes and notes: the pointer, or the middle where the pointer is outside.
    pub(crate) fn place(&self) -> [f64; 2] {
        let at = if self.view().seen().contains(self.pointer) {
            self.pointer
        } else {
            self.camera.middle.to_pos2()
        };
        let at = self.snapped(at);
        [f64::from(at.x), f64::from(at.y)]
    }

    /// Fits the view to what is chosen, or to the whole graph.
    pub(crate) fn frame(&mut self, graph: &Graph) {
        let some = &self.chosen;
        let rect = if some.is_empty() {
            covered(graph, graph.nodes(), graph.notes().map(|(n, _)| n))
        } else {
            covered(graph, some.nodes.iter().copied(), some.notes.iter().map(String::as_str))
        };
        self.camera.fit(self.screen, rect);
    }

    fn view(&self) -> Viewport {
        Viewport { camera: self.camera, screen: self.screen }
    }

    fn snapped(&self, at: Pos2) -> Pos2 {
        if self.snap { (at / GRID).round() * GRID } else { at }
    }

    /// Draws the canvas and handles its input.
    pub(crate) fn show(&mut self, ui: &mut Ui, cx: &mut CanvasContext<'_>) -> Requests {
        let mut requests = Requests::default();
        let (screen, ground) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ground.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Other, true, "canvas"));
        self.screen = screen;
        self.chosen.prune(cx.graph());
        if std::mem::take(&mut self.needs_fit) {
            let graph = cx.graph();
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
        self.gesture.follow(self.pointer, self.snap, cx.graph());
        self.notes(&mut ui, &view, cx);
        let layouts = self.layouts(cx.graph());
        let courses = all_courses(cx.graph(), &layouts);
        self.wires(&mut ui, &view, &courses, &ground, cx);
        self.nodes(&mut ui, &view, &layouts, cx, &mut requests);
        self.overlay(&ui, &view, &layouts, &courses, cx);
        self.ground(&ui, &view, &ground, &layouts, cx, &mut requests);
        self.finish(&ui, &view, &layouts, &courses, cx);
        self.searching(&ui, cx);
        if cx.graph().nodes().len() == 0 && self.search.is_none() {
            paint::invitation(&ui, screen);
        }
        requests
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
        if released && !std::mem::take(&mut self.was_panned) && !ui.ctx().egui_wants_keyboard_input() {
            self.open_search();
        }
        if let Some(delta) = hand {
            self.camera.middle -= delta / self.camera.zoom;
            self.was_panned |= ui.input(|i| i.key_down(egui::Key::Space));
        } else if ground.dragged_by(PointerButton::Secondary) {
            self.camera.middle -= ground.drag_delta() / self.camera.zoom;
        }
    }

    /// The layouts of all nodes, with nodes that are being moved at their new places.
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

    /// Handles input on the empty ground: choosing by a box, the menu, the search.
    fn ground(
        &mut self,
        ui: &Ui,
        view: &Viewport,
        ground: &Response,
        layouts: &BTreeMap<NodeId, Layout>,
        cx: &mut CanvasContext<'_>,
        requests: &mut Requests,
    ) {
        let adds = ui.input(|i| i.modifiers.shift || i.modifiers.command);
        let space = ui.input(|i| i.key_down(egui::Key::Space));
        if ground.clicked() && !adds {
            self.chosen = Chosen::default();
        }
        if ground.double_clicked()
            && wires::under(&all_courses(cx.graph(), layouts), view, self.pointer).is_none()
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
            let notes = cx.graph().notes().filter(|(_, n)| inside(n)).map(|(name, _)| name.to_owned());
            chosen.notes.extend(notes);
            self.chosen = chosen;
        }
        ground.context_menu(|ui| requests.command = menu::ground(ui).or(requests.command.take()));
    }

    /// Shows the search, where it is open.
    fn searching(&mut self, ui: &Ui, cx: &mut CanvasContext<'_>) {
        let Some(mut search) = self.search.take() else { return };
        match search.show(ui, self.screen, cx.graph()) {
            SearchOutcome::Nothing => self.search = Some(search),
            SearchOutcome::Closed => (),
            SearchOutcome::Kind(kind) => {
                let at = self.snapped(match search.end {
                    Some(End::To(..)) => search.at - vec2(layout::WIDTH, layout::HEAD),
                    _ => search.at - vec2(0.0, layout::HEAD),
                });
                let at = [f64::from(at.x), f64::from(at.y)];
                let label = format!("Add {}", kind.id);
                if let Some(id) = cx.edit(&label, |g| ops::add(g, &kind, at, search.end)) {
                    self.chosen = Chosen::only(id);
                }
            }
        }
    }
}

fn all_courses(graph: &Graph, layouts: &BTreeMap<NodeId, Layout>) -> Vec<Course> {
    graph.nodes().flat_map(|id| courses(graph, id, |id| layouts.get(&id))).collect()
}
