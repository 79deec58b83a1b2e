//! The widget of a curve through points.

use eframe::egui::{self, Color32, Id, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, pos2, vec2};
use serde_json::{Value as Json, json};

use super::value::{Edited, named};
use crate::kit::curve::Monotone;

/// Width and height of the area in which a point can be dragged, in points of the screen.
const HANDLE: f32 = 12.0;
/// The least distance between two points along the horizontal axis.
const APART: f64 = 0.001;

/// Shows the points in a square, where they can be dragged. A double click adds a point or removes one.
pub(super) fn edit(ui: &mut Ui, name: &str, value: &mut Json) -> Edited {
    let mut points = read(value);
    let width = ui.available_width().min(240.0);
    let (rect, ground) = ui.allocate_exact_size(vec2(width, width * 0.7), Sense::click());
    named(&ground, egui::WidgetType::Other, name);
    let area = rect.shrink(6.0);
    let on_screen = |[x, y]: [f64; 2]| {
        pos2(area.left() + x as f32 * area.width(), area.bottom() - y as f32 * area.height())
    };
    let value_at = |p: Pos2| {
        let x = f64::from((p.x - area.left()) / area.width()).clamp(0.0, 1.0);
        let y = f64::from((area.bottom() - p.y) / area.height()).clamp(0.0, 1.0);
        [round(x), round(y)]
    };
    paint(ui, rect, area, &points, on_screen);
    let mut edited = Edited::No;
    let mut removed = None;
    for i in 0..points.len() {
        let handle = Rect::from_center_size(on_screen(points[i]), vec2(HANDLE, HANDLE));
        let response = ui.interact(handle, Id::new((name, ui.id(), i)), Sense::click_and_drag());
        named(&response, egui::WidgetType::Button, &format!("{name} point {i}"));
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let [x, y] = value_at(at);
            let low = if i == 0 { 0.0 } else { points[i - 1][0] + APART };
            let high = points.get(i + 1).map_or(1.0, |p| p[0] - APART);
            points[i] = [x.clamp(low.min(high), high), y];
            edited = Edited::Going;
        }
        if response.drag_stopped() {
            edited = Edited::Done;
        }
        if response.double_clicked() && points.len() > 2 {
            removed = Some(i);
        }
        let color = if response.hovered() { ui.visuals().strong_text_color() } else { Color32::WHITE };
        ui.painter().circle(handle.center(), 4.0, color, Stroke::new(1.0, Color32::BLACK));
    }
    if let Some(i) = removed {
        points.remove(i);
        edited = Edited::Done;
    } else if let Some(at) = ground.interact_pointer_pos().filter(|_| ground.double_clicked()) {
        let [x, y] = value_at(at);
        if points.len() < 32 && points.iter().all(|p| (p[0] - x).abs() > APART) {
            points.push([x, y]);
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            edited = Edited::Done;
        }
    }
    ground.on_hover_text("Drag points; double-click adds one or removes one");
    if edited != Edited::No {
        *value = points.iter().map(|p| json!([tidy(p[0]), tidy(p[1])])).collect();
    }
    edited
}

fn paint(ui: &Ui, rect: Rect, area: Rect, points: &[[f64; 2]], on_screen: impl Fn([f64; 2]) -> Pos2) {
    let painter = ui.painter();
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let faint = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.3));
    for k in 0..=4 {
        let t = k as f32 / 4.0;
        painter.vline(area.left() + t * area.width(), area.y_range(), faint);
        painter.hline(area.x_range(), area.top() + t * area.height(), faint);
    }
    painter.rect_stroke(rect, 3.0, faint, StrokeKind::Inside);
    let Some(curve) = Monotone::through(points) else { return };
    let steps = 96;
    let line = (0..=steps).map(|k| {
        let x = f64::from(k) / f64::from(steps);
        on_screen([x, curve.at(x).clamp(0.0, 1.0)])
    });
    painter.line(line.collect(), Stroke::new(2.0, ui.visuals().selection.stroke.color));
}

fn read(value: &Json) -> Vec<[f64; 2]> {
    let point = |p: &Json| Some([p.get(0)?.as_f64()?, p.get(1)?.as_f64()?]);
    value.as_array().map(|items| items.iter().filter_map(point).collect()).unwrap_or_default()
}

fn round(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0
}

/// A number as JSON; whole numbers have no decimal point.
fn tidy(v: f64) -> Json {
    if v == v.round() { Json::from(v as i64) } else { Json::from(v) }
}
