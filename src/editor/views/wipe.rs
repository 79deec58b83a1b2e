//! The line between two compared terrains, which can be dragged across the view.

use eframe::egui::{
    self, Align2, Color32, CursorIcon, FontId, Id, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2,
};

/// The state of the comparison. The place of the line is a share of the width of the view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wipe {
    share: f32,
    /// Whether two values are compared.
    pub(crate) is_on: bool,
    /// The names of the values on the left and on the right.
    pub(crate) names: [String; 2],
}

impl Default for Wipe {
    fn default() -> Self {
        Self { share: 0.5, is_on: false, names: Default::default() }
    }
}

impl Wipe {
    /// The horizontal position of the line on the screen.
    pub(crate) fn line(&self, screen: Rect) -> f32 {
        screen.left() + self.share * screen.width()
    }

    pub(crate) fn left(&self, screen: Rect) -> Rect {
        Rect::from_min_max(screen.min, pos2(self.line(screen), screen.bottom()))
    }

    pub(crate) fn right(&self, screen: Rect) -> Rect {
        Rect::from_min_max(pos2(self.line(screen), screen.top()), screen.max)
    }

    /// Shows the line, which can be dragged, and the names on both sides of it.
    pub(crate) fn show(&mut self, ui: &Ui, screen: Rect) {
        let x = self.line(screen);
        let grip = Rect::from_center_size(pos2(x, screen.center().y), vec2(12.0, screen.height()));
        let response = ui.interact(grip, Id::new("wipe"), Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Slider, true, "wipe"));
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.share = ((at.x - screen.left()) / screen.width().max(1.0)).clamp(0.02, 0.98);
        }
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        let x = self.line(screen);
        let painter = ui.painter();
        painter.vline(x, screen.y_range(), Stroke::new(4.0, Color32::from_black_alpha(140)));
        painter.vline(x, screen.y_range(), Stroke::new(1.5, Color32::WHITE));
        let sides = [(Align2::RIGHT_TOP, -12.0), (Align2::LEFT_TOP, 12.0)];
        for ((align, by), name) in sides.into_iter().zip(&self.names) {
            let galley = painter.layout_no_wrap(name.clone(), FontId::proportional(13.0), Color32::WHITE);
            let rect = align.anchor_size(pos2(x + by, screen.top() + 10.0), galley.size());
            painter.rect_filled(rect.expand(4.0), 4.0, Color32::from_black_alpha(150));
            painter.galley(rect.min, galley, Color32::WHITE);
        }
        let middle = pos2(x, screen.center().y);
        painter.circle(middle, 9.0, Color32::WHITE, Stroke::new(1.5, Color32::BLACK));
        for side in [-1.0, 1.0] {
            let tip: Pos2 = middle + vec2(6.0 * side, 0.0);
            let back: [Vec2; 2] = [vec2(-3.5 * side, -3.5), vec2(-3.5 * side, 3.5)];
            let corners = vec![tip, tip + back[0], tip + back[1]];
            painter.add(egui::Shape::convex_polygon(corners, Color32::BLACK, Stroke::NONE));
        }
    }
}
