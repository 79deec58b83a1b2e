//! Painting of curves and their grips: light lines on dark ones, so that they are visible on any ground.

use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, vec2};

use super::Space;
use super::grip::{Grip, Part};
use crate::editor::theme;
use crate::value::{Curve, Curves, Object as _, SketchLine, SketchPoint, WireType};

const DARK: Color32 = Color32::from_black_alpha(170);

/// A point of a curve on the screen.
#[derive(Clone, Copy)]
pub(super) struct Dot {
    pub(super) at: Pos2,
    /// Whether the ground does not hide the point.
    pub(super) seen: bool,
}

/// A curve on the screen.
pub(super) type Line = Vec<Dot>;

/// The points of a curve on the screen, without those behind the eye.
pub(super) fn line(curve: &Curve, space: &dyn Space) -> Line {
    seen(&curve.sketch(), space)
}

/// The points of a line of the world on the screen; points without a height lie on the ground.
fn seen(line: &SketchLine, space: &dyn Space) -> Line {
    let dot = |(at, height): &SketchPoint| {
        let at = [at[0], at[1], height.unwrap_or_else(|| space.height(*at))];
        space.screen(at).map(|p| Dot { at: p, seen: !space.hides(at) })
    };
    line.iter().filter_map(dot).collect()
}

/// Paints all curves; the chosen one and the one under the pointer stand out.
pub(super) fn lines(ui: &Ui, lines: &[Option<Line>], chosen: Option<usize>, hit: Option<usize>) {
    draw(ui, lines, theme::wire_color(WireType::Object(Curves::TYPE)), (chosen, hit));
}

fn draw(ui: &Ui, lines: &[Option<Line>], usual: Color32, (chosen, hit): (Option<usize>, Option<usize>)) {
    for (i, line) in lines.iter().enumerate() {
        let Some(line) = line else { continue };
        let (width, color) = match (chosen == Some(i), hit == Some(i)) {
            (true, _) => (2.5, theme::CHOSEN),
            (false, true) => (2.5, Color32::WHITE),
            (false, false) => (1.5, usual),
        };
        for part in line.chunk_by(|a, b| a.seen == b.seen) {
            let points: Vec<Pos2> = part.iter().map(|d| d.at).collect();
            if part[0].seen {
                stroke(ui, &points, width, color);
            } else {
                ui.painter().line(points, Stroke::new(1.0, color.gamma_multiply(0.25)));
            }
        }
    }
}

/// Paints the lines of a value that is not edited.
pub(crate) fn plain(ui: &Ui, space: &dyn Space, lines: &[SketchLine], wire: WireType) {
    let all: Vec<_> = lines.iter().map(|line| Some(seen(line, space))).collect();
    draw(ui, &all, theme::wire_color(wire), (None, None));
}

fn stroke(ui: &Ui, line: &[Pos2], width: f32, color: Color32) {
    ui.painter().line(line.to_vec(), Stroke::new(width + 2.0, DARK));
    ui.painter().line(line.to_vec(), Stroke::new(width, color));
}

/// Paints a line that is being drawn through places of the ground.
pub(super) fn path(ui: &Ui, space: &dyn Space, points: &[[f64; 2]]) {
    let seen: Vec<Pos2> =
        points.iter().filter_map(|p| space.screen([p[0], p[1], space.height(*p)])).collect();
    stroke(ui, &seen, 2.0, theme::CHOSEN);
}

/// Paints the points of a curve that is being drawn.
pub(super) fn marks(ui: &Ui, space: &dyn Space, places: impl Iterator<Item = [f64; 2]>) {
    for at in places.filter_map(|p| space.screen([p[0], p[1], space.height(p)])) {
        let square = Rect::from_center_size(at, vec2(9.0, 9.0));
        ui.painter().rect(square, 0.0, Color32::WHITE, Stroke::new(1.5, Color32::BLACK), StrokeKind::Middle);
    }
}

/// Paints a grip: squares for control points, circles for handles, diamonds for constraint points, pins for heights,
/// bars for widths, triangles for angles.
pub(super) fn grip(ui: &Ui, space: &dyn Space, grip: &Grip, at: Pos2, hot: bool, chosen: bool) {
    let painter = ui.painter();
    let color = match grip.part {
        Part::Anchor(_) | Part::Handle(_) | Part::Body => Color32::WHITE,
        Part::Point(_) | Part::Height(_) => theme::CHOSEN,
        Part::Plateau(_) => Color32::from_rgb(120, 200, 255),
        Part::Extent(..) | Part::Angle(..) => Color32::from_rgb(255, 150, 110),
    };
    if let Some(from) = grip.joined.and_then(|p| space.screen(p)) {
        painter.line_segment([from, at], Stroke::new(3.0, DARK));
        painter.line_segment([from, at], Stroke::new(1.2, color));
    }
    let size = if hot || chosen { 6.5 } else { 5.0 };
    let edge =
        Stroke::new(if chosen { 2.5 } else { 1.5 }, if chosen { theme::CHOSEN } else { Color32::BLACK });
    let fill = if chosen { Color32::WHITE } else { color };
    let corners = |shape: &[[f32; 2]]| {
        let points = shape.iter().map(|[x, y]| at + vec2(*x, *y) * size).collect();
        Shape::convex_polygon(points, fill, edge)
    };
    let shape = match grip.part {
        Part::Anchor(_) | Part::Body => {
            corners(&[[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]])
        }
        Part::Handle(_) | Part::Height(_) => {
            painter.circle(at, size * 0.85, fill, edge);
            return;
        }
        Part::Point(_) => corners(&[[0.0, -1.2], [1.2, 0.0], [0.0, 1.2], [-1.2, 0.0]]),
        Part::Plateau(_) | Part::Extent(..) => corners(&[[-0.5, -1.1], [0.5, -1.1], [0.5, 1.1], [-0.5, 1.1]]),
        Part::Angle(..) => corners(&[[0.0, -1.1], [1.1, 0.9], [-1.1, 0.9]]),
    };
    painter.add(shape);
}

/// Paints the hint of a tool at the top of the view.
pub(super) fn hint(ui: &Ui, text: &str) {
    if text.is_empty() {
        return;
    }
    let galley = ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(12.5), Color32::WHITE);
    let rect = Align2::CENTER_TOP.anchor_size(ui.clip_rect().center_top() + vec2(0.0, 8.0), galley.size());
    ui.painter().rect_filled(rect.expand(5.0), 4.0, Color32::from_black_alpha(170));
    ui.painter().galley(rect.min, galley, Color32::WHITE);
}

/// Paints the name and the value of a grip beside it.
pub(super) fn tell(ui: &Ui, at: Pos2, text: &str) {
    let galley =
        ui.painter().layout_no_wrap(text.trim().to_owned(), FontId::proportional(12.5), Color32::WHITE);
    let rect = Align2::LEFT_BOTTOM.anchor_size(at + vec2(12.0, -10.0), galley.size());
    ui.painter().rect_filled(rect.expand(4.0), 4.0, Color32::from_black_alpha(190));
    ui.painter().galley(rect.min, galley, Color32::WHITE);
}
