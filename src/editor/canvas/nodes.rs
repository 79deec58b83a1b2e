//! Input on nodes: choosing, moving, dragging wires from their ports.

use std::collections::BTreeMap;

use eframe::egui::{self, Id, PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};

use super::camera::Viewport;
use super::gesture::Gesture;
use super::layout::Layout;
use super::{Canvas, CanvasContext, Chosen, Requests, menu, paint};
use crate::editor::ops::End;
use crate::graph::{Graph, NodeId, Source};
use crate::ports::Port;

/// Zoom below which ports are too small to be hit and do not react.
const PORTS: f32 = 0.3;

impl Canvas {
    pub(super) fn nodes(
        &mut self,
        ui: &mut Ui,
        view: &Viewport,
        layouts: &BTreeMap<NodeId, Layout>,
        cx: &mut CanvasContext<'_>,
        requests: &mut Requests,
    ) {
        self.pictures(ui, cx);
        let seen = view.seen();
        self.in_sight.clear();
        for (&id, layout) in layouts.iter().filter(|(_, l)| seen.intersects(l.rect)) {
            self.in_sight.push(id);
            let response = self.node(ui, view, id, layout, cx, requests);
            let look = paint::NodeLook {
                chosen: self.chosen.nodes.contains(&id),
                hovered: response.hovered(),
                pinned: cx.pinned == Some(id),
                picture: self.pictures.get(&id).map(|(_, t)| t.id()),
            };
            paint::node(ui, view, id, layout, &look, cx);
            if view.zoom() >= PORTS {
                self.ports(ui, view, id, layout, cx);
            }
        }
    }

    /// Uploads the thumbnails that have changed as textures.
    fn pictures(&mut self, ui: &Ui, cx: &CanvasContext<'_>) {
        let thumbnails = &cx.board.thumbnails;
        self.pictures.retain(|id, _| thumbnails.contains_key(id));
        for (id, seen) in thumbnails {
            if self.pictures.get(id).is_none_or(|(key, _)| *key != seen.key) {
                let image = super::super::image_of(&seen.picture);
                let name = format!("thumbnail {id:?}");
                let texture = ui.ctx().load_texture(name, image, egui::TextureOptions::LINEAR);
                self.pictures.insert(*id, (seen.key, texture));
            }
        }
    }

    fn node(
        &mut self,
        ui: &Ui,
        view: &Viewport,
        id: NodeId,
        layout: &Layout,
        cx: &mut CanvasContext<'_>,
        requests: &mut Requests,
    ) -> Response {
        let response = ui.interact(view.rect(layout.rect), node_id(id), Sense::click_and_drag());
        let node = cx.graph().node(id);
        let label = format!("node {}", node.name);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &label));
        let adds = ui.input(|i| i.modifiers.shift || i.modifiers.command);
        if response.clicked() {
            self.choose(id, adds);
        }
        if response.secondary_clicked() && !self.chosen.nodes.contains(&id) {
            self.chosen = Chosen::only(id);
        }
        if response.double_clicked() {
            requests.pin = Some(id);
        }
        if response.drag_started_by(PointerButton::Primary) {
            if !self.chosen.nodes.contains(&id) {
                self.choose(id, adds);
            }
            let from = ui.input(|i| i.pointer.press_origin()).map_or(self.pointer, |p| view.world(p));
            self.grab(from, layout.rect.min);
        }
        response.context_menu(|ui| requests.command = menu::node(ui).or(requests.command.take()));
        response
    }

    fn choose(&mut self, id: NodeId, adds: bool) {
        if !adds {
            self.chosen = Chosen::only(id);
        } else if !self.chosen.nodes.remove(&id) {
            self.chosen.nodes.insert(id);
        }
    }

    /// Starts to move the chosen nodes and notes.
    pub(super) fn grab(&mut self, from: Pos2, corner: Pos2) {
        let Chosen { nodes, notes } = self.chosen.clone();
        self.gesture = Gesture::Move { from, corner, by: vec2(0.0, 0.0), nodes, notes };
    }

    fn ports(&mut self, ui: &Ui, view: &Viewport, id: NodeId, layout: &Layout, cx: &CanvasContext<'_>) {
        let sides = [(&layout.inputs, "input"), (&layout.outputs, "output")];
        for (pins, side) in sides {
            for (port, at) in pins {
                if let Some(started) = self.port(ui, view, id, port, *at, side, cx) {
                    self.gesture = started;
                }
            }
        }
    }

    /// Handles input on a port; returns the gesture of dragging a wire when one begins.
    #[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
    fn port(
        &self,
        ui: &Ui,
        view: &Viewport,
        id: NodeId,
        port: &Port,
        at: Pos2,
        side: &'static str,
        cx: &CanvasContext<'_>,
    ) -> Option<Gesture> {
        let size = (15.0 * view.zoom()).clamp(9.0, 26.0);
        let rect = Rect::from_center_size(view.pos(at), vec2(size, size));
        let response = ui.interact(rect, port_id(id, side, &port.name), Sense::click_and_drag());
        let graph = cx.graph();
        let label = format!("{side} {}.{}", graph.node(id).name, port.name);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &label));
        let started = response.drag_started_by(PointerButton::Primary);
        if !started && matches!(self.gesture, Gesture::None) {
            response.on_hover_ui(|ui| {
                ui.strong(named(graph, id, port, side));
                ui.label(port.doc.as_str());
            });
        }
        if !started {
            return None;
        }
        let wire = |end, taken| Some(Gesture::Wire { end, taken });
        match (side, graph.source(id, &port.name)) {
            ("output", _) => wire(End::From(Source { node: id, port: port.name.clone() }), None),
            // A wire into this input is taken off it.
            (_, Some(source)) => wire(End::From(source), Some((id, port.name.clone()))),
            (_, None) => wire(End::To(id, port.name.clone()), None),
        }
    }
}

/// The text about a port: its name, the type of its wire and its quantity.
fn named(graph: &Graph, id: NodeId, port: &Port, side: &str) -> String {
    let (name, wire) = (&port.name, port.wire.name());
    let own = || Source { node: id, port: name.clone() };
    let source = if side == "output" { Some(own()) } else { graph.source(id, name) };
    match source.and_then(|source| graph.quantity(&source)) {
        Some(quantity) => format!("{name} · {wire} · {}", quantity.described()),
        None => format!("{name} · {wire}"),
    }
}

pub(super) fn node_id(id: NodeId) -> Id {
    Id::new(("canvas node", id))
}

fn port_id(id: NodeId, side: &str, port: &str) -> Id {
    Id::new(("canvas port", id, side, port))
}
