//! Painting of nodes and of the ground.

use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, StrokeKind, TextureId, Ui, pos2, vec2,
};

use super::camera::Viewport;
use super::layout::{Layout, Pin};
use super::{CanvasContext, GRID};
use crate::editor::board::NodeState;
use crate::editor::shown;
use crate::editor::theme;
use crate::graph::{GraphNode, NodeId, Problem};

/// Zoom below which nodes are boxes without texts.
const TEXT: f32 = 0.35;

/// The state of a node's look that is not in the graph.
pub(super) struct NodeLook {
    pub(super) chosen: bool,
    pub(super) hovered: bool,
    pub(super) pinned: bool,
    pub(super) picture: Option<TextureId>,
}

/// The font size at a zoom, rounded to steps, so that zooming does not fill the font atlas with letters of many sizes.
pub(super) fn font_size(size: f32, zoom: f32) -> f32 {
    ((size * zoom * 2.0).round() * 0.5).max(1.0)
}

/// Paints the ground and its grid.
pub(super) fn ground(ui: &Ui, view: &Viewport) {
    let painter = ui.painter();
    painter.rect_filled(view.screen, 0.0, ui.visuals().extreme_bg_color);
    let seen = view.seen();
    let faint = ui.visuals().text_color();
    for (step, alpha) in [(GRID, 0.035), (GRID * 5.0, 0.07)] {
        if step * view.zoom() < 8.0 {
            continue;
        }
        let stroke = Stroke::new(1.0, faint.gamma_multiply(alpha));
        let lines = |from: f32, to: f32| {
            let first = (from / step).ceil() as i64;
            (first..=(to / step).floor() as i64).map(move |k| k as f32 * step)
        };
        for x in lines(seen.left(), seen.right()) {
            painter.vline(view.pos(pos2(x, 0.0)).x, view.screen.y_range(), stroke);
        }
        for y in lines(seen.top(), seen.bottom()) {
            painter.hline(view.screen.x_range(), view.pos(pos2(0.0, y)).y, stroke);
        }
    }
}

/// Paints the text of an empty canvas.
pub(super) fn invitation(ui: &Ui, screen: Rect) {
    let text = "Nothing here yet.\nDouble-click, or press Tab, to add a node.";
    let font = FontId::proportional(16.0);
    let galley = ui.painter().layout(text.to_owned(), font, ui.visuals().weak_text_color(), 400.0);
    ui.painter().galley(screen.center() - galley.size() * 0.5, galley, Color32::GRAY);
}

/// Paints a node.
pub(super) fn node(
    ui: &Ui,
    view: &Viewport,
    id: NodeId,
    layout: &Layout,
    look: &NodeLook,
    cx: &CanvasContext<'_>,
) {
    let node = cx.graph().node(id);
    let zoom = view.zoom();
    let rect = view.rect(layout.rect);
    let round = 5.0 * zoom;
    let painter = ui.painter();
    let dark = ui.visuals().dark_mode;
    let faded = |c: Color32| if node.bypass { c.gamma_multiply(0.45) } else { c };
    painter.rect_filled(rect.translate(vec2(2.0, 3.0) * zoom), round, Color32::from_black_alpha(70));
    painter.rect_filled(rect, round, faded(ui.visuals().window_fill()));
    let family = node.kind().map_or("", |k| k.family.as_str());
    let head = view.rect(layout.head());
    let top = eframe::egui::CornerRadius { nw: round as u8, ne: round as u8, sw: 0, se: 0 };
    painter.rect_filled(head, top, faded(theme::family_color(family, dark)));
    if let Some(picture) = look.picture {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(picture, view.rect(layout.picture), whole, faded(Color32::WHITE));
    } else {
        painter.rect_filled(view.rect(layout.picture), 2.0, Color32::from_black_alpha(40));
    }
    if zoom >= TEXT {
        texts(ui, painter, view, layout, node, look);
    }
    state(ui, painter, view, layout, id, cx);
    pins(painter, view, layout, id, cx);
    let stroke = match (look.chosen, look.hovered) {
        (true, _) => Stroke::new(2.0, theme::CHOSEN),
        (false, true) => Stroke::new(1.5, ui.visuals().strong_text_color().gamma_multiply(0.6)),
        (false, false) => Stroke::new(1.0, Color32::from_black_alpha(120)),
    };
    painter.rect_stroke(rect, round, stroke, StrokeKind::Outside);
    if node.bypass {
        let across = Stroke::new(2.0 * zoom, ui.visuals().text_color().gamma_multiply(0.4));
        painter.line_segment([rect.left_top(), rect.right_bottom()], across);
    }
}

fn texts(ui: &Ui, painter: &Painter, view: &Viewport, layout: &Layout, node: &GraphNode, look: &NodeLook) {
    let zoom = view.zoom();
    let head = view.rect(layout.head());
    let inner = painter.with_clip_rect(head.shrink2(vec2(6.0 * zoom, 0.0)).intersect(painter.clip_rect()));
    let title = inner.text(
        head.left_center() + vec2(8.0 * zoom, 0.0),
        Align2::LEFT_CENTER,
        shown(&node.name),
        FontId::proportional(font_size(13.0, zoom)),
        Color32::WHITE,
    );
    let kind = node.kind.id();
    let base = node.name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
    if base != kind {
        let room = head.right() - title.right();
        let at = head.right_center() - vec2(if look.pinned { 22.0 } else { 8.0 } * zoom, 0.0);
        if room > 46.0 * zoom {
            let clip = Rect::from_min_max(pos2(title.right() + 8.0 * zoom, head.top()), head.max);
            let painter = painter.with_clip_rect(clip.intersect(painter.clip_rect()));
            let font = FontId::proportional(font_size(10.0, zoom));
            painter.text(at, Align2::RIGHT_CENTER, shown(kind), font, Color32::from_white_alpha(150));
        }
    }
    if look.pinned {
        let at = head.right_center() - vec2(7.0 * zoom, 0.0);
        let font = FontId::proportional(font_size(12.0, zoom));
        painter.text(at, Align2::RIGHT_CENTER, "📌", font, theme::CHOSEN);
    }
    let font = FontId::proportional(font_size(10.5, zoom));
    let color = ui.visuals().text_color();
    for (pins, side, align) in
        [(&layout.inputs, 9.0, Align2::LEFT_CENTER), (&layout.outputs, -9.0, Align2::RIGHT_CENTER)]
    {
        for (port, at) in pins {
            painter.text(view.pos(*at + vec2(side, 0.0)), align, &port.name, font.clone(), color);
        }
    }
}

fn pins(painter: &Painter, view: &Viewport, layout: &Layout, id: NodeId, cx: &CanvasContext<'_>) {
    let radius = 4.6 * view.zoom().max(0.25);
    let one = |(port, at): &Pin, filled: bool| {
        painter.add(theme::pin(port.wire, view.pos(*at), radius, filled));
    };
    for pin in &layout.inputs {
        one(pin, cx.graph().source(id, &pin.0.name).is_some());
    }
    for pin in &layout.outputs {
        one(pin, true);
    }
}

/// Paints the problem, the progress or the time of a node.
fn state(ui: &Ui, painter: &Painter, view: &Viewport, layout: &Layout, id: NodeId, cx: &CanvasContext<'_>) {
    let zoom = view.zoom();
    let corner = view.pos(layout.rect.right_bottom());
    let state = cx.board.nodes.get(&id);
    let fault = fault(id, state, cx);
    if let Some((message, error)) = &fault {
        badge(ui, painter, view.pos(layout.rect.right_top()), zoom, message, *error);
    }
    match state {
        Some(NodeState::Running(share)) => {
            ring(painter, view.pos(layout.picture.center()), 17.0 * zoom, *share);
        }
        Some(NodeState::Waiting) => ring(painter, view.pos(layout.picture.center()), 17.0 * zoom, 0.0),
        Some(NodeState::Done(seconds)) if zoom >= TEXT && cx.times => {
            let at = corner - vec2(7.0, 5.0) * zoom;
            let font = FontId::proportional(font_size(9.5, zoom));
            painter.text(at, Align2::RIGHT_BOTTOM, time(*seconds), font, ui.visuals().weak_text_color());
        }
        _ => (),
    }
    let range = cx.board.thumbnails.get(&id).and_then(|seen| seen.range);
    // From four ports on there is no room for the range.
    let range = range.filter(|_| zoom >= 0.6 && layout.inputs.len() <= 3);
    if let Some((low, high)) = range {
        let at = view.pos(layout.rect.left_bottom()) + vec2(7.0, -5.0) * zoom;
        let font = FontId::proportional(font_size(9.5, zoom));
        let text = format!("{} … {}", short(low), short(high));
        let room = view.rect(layout.rect);
        let painter = painter.with_clip_rect(room.intersect(painter.clip_rect()));
        painter.text(at, Align2::LEFT_BOTTOM, text, font, ui.visuals().weak_text_color());
    }
}

/// The message of a node's problem, and whether it is an error.
fn fault(id: NodeId, state: Option<&NodeState>, cx: &CanvasContext<'_>) -> Option<(String, bool)> {
    if let Some(NodeState::Failed(message)) = state {
        return Some((message.clone(), true));
    }
    let own = |p: &&Problem| p.blames() == Some(id);
    let worst = cx.document.problems().iter().filter(own).max_by_key(|p| p.severity)?;
    Some((worst.to_string(), worst.is_error()))
}

fn badge(ui: &Ui, painter: &Painter, at: Pos2, zoom: f32, message: &str, error: bool) {
    let radius = (8.0 * zoom).max(4.5);
    let color = if error { theme::ERROR } else { theme::WARNING };
    painter.circle(at, radius, color, Stroke::new(1.0, Color32::from_black_alpha(160)));
    painter.text(at, Align2::CENTER_CENTER, "!", FontId::proportional(radius * 1.6), Color32::WHITE);
    let over = ui.input(|i| i.pointer.hover_pos()).is_some_and(|p| p.distance(at) < radius + 3.0);
    if over {
        bubble(ui, at + vec2(12.0, 12.0), &shown(message), color);
    }
}

/// Paints a text in a bubble.
pub(super) fn bubble(ui: &Ui, at: Pos2, text: &str, color: Color32) {
    let layer = eframe::egui::LayerId::new(eframe::egui::Order::Tooltip, ui.id().with("bubble"));
    let painter = Painter::new(ui.ctx().clone(), layer, ui.ctx().content_rect());
    let galley =
        painter.layout(text.to_owned(), FontId::proportional(12.5), ui.visuals().strong_text_color(), 340.0);
    let rect = Rect::from_min_size(at, galley.size()).expand(6.0);
    let bounds = ui.ctx().content_rect();
    let by = vec2((bounds.right() - rect.right()).min(0.0), (bounds.bottom() - rect.bottom()).min(0.0));
    let rect = rect.translate(by);
    painter.rect_filled(rect, 4.0, ui.visuals().window_fill());
    painter.rect_stroke(rect, 4.0, Stroke::new(1.5, color), StrokeKind::Inside);
    painter.galley(rect.min + vec2(6.0, 6.0), galley, Color32::WHITE);
}

/// Paints the share of a node's work that is done.
fn ring(painter: &Painter, at: Pos2, radius: f32, share: f32) {
    painter.circle(
        at,
        radius,
        Color32::from_black_alpha(120),
        Stroke::new(3.0, Color32::from_white_alpha(60)),
    );
    let steps = 40;
    let angle = |k: usize| (k as f32 / steps as f32 * share - 0.25) * std::f32::consts::TAU;
    let point = |k: usize| at + vec2(libm::cosf(angle(k)), libm::sinf(angle(k))) * radius;
    painter.line((0..=steps).map(point).collect(), Stroke::new(3.0, theme::CHOSEN));
}

/// A short text for a time in seconds.
pub(crate) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 10.0 => format!("{s:.0} s"),
        s if s >= 1.0 => format!("{s:.1} s"),
        s if s >= 1e-3 => format!("{:.0} ms", s * 1e3),
        _ => "<1 ms".to_owned(),
    }
}

/// A short text for a number.
pub(crate) fn short(value: f32) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 1.0 => format!("{value:.1}"),
        v if v >= 0.01 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}
