//! Notes: frames and comments behind the nodes, and input on them.

use eframe::egui::{self, FontId, Id, PointerButton, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, vec2};

use super::camera::Viewport;
use super::gesture::Gesture;
use super::layout::{Layout, NOTE_HEAD, note_rect};
use super::{Canvas, CanvasContext, Chosen};
use crate::editor::{shown, theme};
use crate::graph::Note;
use crate::text::printable_lines;

impl Canvas {
    pub(super) fn notes(&mut self, ui: &mut Ui, view: &Viewport, cx: &mut CanvasContext<'_>) {
        let notes: Vec<(String, Note)> =
            cx.graph().notes().map(|(name, note)| (name.to_owned(), note.clone())).collect();
        for (name, note) in &notes {
            let rect = self.where_is(name, note);
            if !view.seen().intersects(rect) {
                continue;
            }
            paint(ui, view, rect, note, self.chosen.notes.contains(name));
            self.note(ui, view, name, rect, cx);
        }
    }

    /// The rectangle of a note, which may be being moved or resized.
    fn where_is(&self, name: &str, note: &Note) -> Rect {
        let rect = note_rect(note);
        match &self.gesture {
            Gesture::Resize { name: own, size } if own == name => Rect::from_min_size(rect.min, *size),
            gesture if gesture.moves_note(name) => rect.translate(gesture.shift()),
            _ => rect,
        }
    }

    fn note(&mut self, ui: &Ui, view: &Viewport, name: &str, rect: Rect, cx: &CanvasContext<'_>) {
        let title = Rect::from_min_size(rect.min, vec2(rect.width(), NOTE_HEAD.min(rect.height())));
        let head = ui.interact(view.rect(title), Id::new(("note", name)), Sense::click_and_drag());
        let label = format!("note {name}");
        head.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &label));
        let adds = ui.input(|i| i.modifiers.shift || i.modifiers.command);
        if head.clicked() || head.drag_started() && !self.chosen.notes.contains(name) {
            if !adds {
                self.chosen = Chosen::default();
            }
            self.chosen.notes.insert(name.to_owned());
        }
        if head.drag_started_by(PointerButton::Primary) {
            let from = ui.input(|i| i.pointer.press_origin()).map_or(self.pointer, |p| view.world(p));
            // A frame takes the nodes and notes inside it along, unless Alt is down.
            if !ui.input(|i| i.modifiers.alt) {
                let inside =
                    |id: &crate::graph::NodeId| rect.contains_rect(Layout::of(cx.graph().node(*id)).rect);
                self.chosen.nodes.extend(cx.graph().nodes().filter(inside));
            }
            self.grab(from, rect.min);
        }
        let corner = Rect::from_center_size(view.pos(rect.max), vec2(18.0, 18.0));
        let corner = ui.interact(corner, Id::new(("note corner", name)), Sense::drag());
        if corner.hovered() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeNwSe);
        }
        if corner.drag_started_by(PointerButton::Primary) {
            self.gesture = Gesture::Resize { name: name.to_owned(), size: rect.size() };
        }
    }
}

fn paint(ui: &Ui, view: &Viewport, rect: Rect, note: &Note, chosen: bool) {
    let zoom = view.zoom();
    let color = theme::note_color(note.color);
    let on_screen = view.rect(rect);
    let painter = ui.painter().with_clip_rect(on_screen.intersect(ui.clip_rect()).expand(2.0));
    painter.rect_filled(on_screen, 6.0 * zoom, color.gamma_multiply(0.16));
    let title = Rect::from_min_size(on_screen.min, vec2(on_screen.width(), NOTE_HEAD * zoom));
    painter.rect_filled(title, 6.0 * zoom, color.gamma_multiply(0.55));
    let edge = if chosen { Stroke::new(2.0, theme::CHOSEN) } else { Stroke::new(1.0, color) };
    painter.rect_stroke(on_screen, 6.0 * zoom, edge, StrokeKind::Inside);
    if zoom < 0.2 {
        return;
    }
    let text = |at: Pos2, size: f32, text: &str, width: f32, strong: bool| {
        let color = if strong { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
        let font = FontId::proportional(super::paint::font_size(size, zoom));
        let galley = painter.layout(text.to_owned(), font, color, width.max(10.0));
        painter.galley(at, galley, color);
    };
    let cx = 7.0 * zoom;
    let width = on_screen.width() - 2.0 * cx;
    text(title.left_center() + vec2(cx, -8.0 * zoom), 13.5, &shown(&note.title), f32::INFINITY, true);
    text(title.left_bottom() + vec2(cx, cx), 12.0, &printable_lines(&note.text), width, false);
    let grip = view.pos(rect.max) - vec2(4.0, 4.0);
    let corners = vec![grip, grip - vec2(8.0, 0.0), grip - vec2(0.0, 8.0)];
    painter.add(egui::Shape::convex_polygon(corners, color, Stroke::NONE));
}
