//! Input on wires: highlighting, bends, menus.

use eframe::egui::{self, Color32, Id, PointerButton, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

use super::camera::Viewport;
use super::gesture::Gesture;
use super::layout::place;
use super::wire::{Course, nearest, shapes};
use super::{Canvas, CanvasContext};
use crate::editor::shown;
use crate::editor::theme;

/// Distance within which the pointer is on a wire, in points of the screen.
const NEAR: f32 = 7.0;

/// The wire at a place on the canvas, and the index of its piece there.
pub(super) fn under<'a>(
    courses: &'a [Course],
    view: &Viewport,
    at: egui::Pos2,
) -> Option<(&'a Course, usize)> {
    let near = |c: &'a Course| {
        let (away, piece) = nearest(&c.points, at)?;
        (away * view.zoom() < NEAR).then_some((away, c, piece))
    };
    let found = courses.iter().filter_map(near).min_by(|a, b| a.0.total_cmp(&b.0));
    found.map(|(_, course, piece)| (course, piece))
}

impl Canvas {
    pub(super) fn wires(
        &mut self,
        ui: &mut Ui,
        view: &Viewport,
        courses: &[Course],
        ground: &Response,
        cx: &mut CanvasContext<'_>,
    ) {
        let free = matches!(self.gesture, Gesture::None) && self.search.is_none();
        let hovered = if free && ground.hovered() { under(courses, view, self.pointer) } else { None };
        let painter = ui.painter();
        let seen = view.seen();
        for course in courses {
            let around = Rect::from_points(&course.points).expand(240.0);
            if !seen.intersects(around) || self.is_taken(course) {
                continue;
            }
            let over = hovered.is_some_and(|(c, _)| c.to == course.to && c.input == course.input);
            let of_chosen =
                self.chosen.nodes.contains(&course.to) || self.chosen.nodes.contains(&course.source.node);
            let width = if over || of_chosen { 3.0 } else { 2.0 } * view.zoom().sqrt();
            let color = theme::wire_color(course.wire);
            let color = if over || of_chosen { color } else { color.gamma_multiply(0.75) };
            let points = self.bent(course);
            painter.extend(shapes(&points, view, Stroke::new(width + 2.0, Color32::from_black_alpha(90))));
            painter.extend(shapes(&points, view, Stroke::new(width, color)));
        }
        if let Some((course, piece)) = hovered {
            self.hover(ui, course, piece, ground, cx);
        }
        if view.zoom() > 0.3 {
            for course in courses {
                self.bends(ui, view, course, cx);
            }
        }
    }

    /// Whether the end of a wire is being dragged away from its input.
    fn is_taken(&self, course: &Course) -> bool {
        matches!(&self.gesture, Gesture::Wire { taken: Some((node, input)), .. }
            if (*node, input) == (course.to, &course.input))
    }

    /// The points of a wire, with a bend that is being moved at the pointer.
    fn bent(&self, course: &Course) -> Vec<egui::Pos2> {
        let mut points = course.points.clone();
        if let Gesture::Bend { node, ref input, index } = self.gesture
            && (node, input) == (course.to, &course.input)
            && let Some(point) = points.get_mut(index + 1)
        {
            *point = self.snapped(self.pointer);
        }
        points
    }

    fn hover(&self, ui: &Ui, course: &Course, piece: usize, ground: &Response, cx: &mut CanvasContext<'_>) {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        let (from, to) = (cx.graph().source_text(&course.source), course.to);
        let name = cx.graph().node(to).name.clone();
        if ui.input(|i| i.modifiers.alt) && ground.clicked() {
            cx.edit("Cut wire", |g| g.disconnect(to, &course.input));
            return;
        }
        if ground.double_clicked() {
            let at = self.snapped(self.pointer);
            let mut bends = cx.graph().bends(to, &course.input).to_vec();
            bends.insert(piece.min(bends.len()), [f64::from(at.x), f64::from(at.y)]);
            cx.edit("Bend wire", |g| g.set_bends(to, &course.input, bends));
            return;
        }
        ground.clone().on_hover_ui_at_pointer(|ui| {
            ui.label(shown(&format!("{from} to {name}.{}", course.input)));
            ui.weak("Double-click adds a bend, Alt-click cuts the wire");
        });
    }

    fn bends(&mut self, ui: &Ui, view: &Viewport, course: &Course, cx: &mut CanvasContext<'_>) {
        let bends = cx.graph().bends(course.to, &course.input).to_vec();
        for (index, at) in bends.iter().enumerate() {
            let moving = matches!(self.gesture, Gesture::Bend { node, ref input, index: i }
                if (node, input, i) == (course.to, &course.input, index));
            let at = view.pos(if moving { self.snapped(self.pointer) } else { place(*at) });
            let rect = Rect::from_center_size(at, vec2(14.0, 14.0));
            let id = Id::new(("bend", course.to, &course.input, index));
            let response = ui.interact(rect, id, Sense::click_and_drag());
            let name = format!("bend {index} of {}.{}", cx.graph().node(course.to).name, course.input);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &name));
            let radius = if response.hovered() || moving { 5.5 } else { 4.0 };
            ui.painter().circle(
                at,
                radius,
                theme::wire_color(course.wire),
                Stroke::new(1.0, Color32::from_black_alpha(140)),
            );
            if response.drag_started_by(PointerButton::Primary) {
                self.gesture = Gesture::Bend { node: course.to, input: course.input.clone(), index };
            }
            if response.double_clicked() {
                let mut bends = bends.clone();
                bends.remove(index);
                cx.edit("Straighten wire", |g| g.set_bends(course.to, &course.input, bends));
            }
        }
    }

    /// Draws the wire that is being dragged, from a port to the pointer.
    pub(super) fn pulled(&self, ui: &Ui, view: &Viewport, from: egui::Pos2, forward: bool, color: Color32) {
        let at = self.pointer;
        let points = if forward { [from, at] } else { [at, from] };
        let points = points.map(|p| pos2(p.x, p.y));
        ui.painter().extend(shapes(&points, view, Stroke::new(2.5 * view.zoom().sqrt(), color)));
    }
}
