//! Small charts below the views.

use eframe::egui::{Align2, FontId, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};

use crate::editor::canvas::short;
use crate::editor::theme;
use crate::value::Field;

/// Columns of a histogram.
const BINS: usize = 96;

/// Paints a text in the place of a chart.
pub(crate) fn hint(ui: &mut Ui, size: Vec2, text: &str) {
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let color = ui.visuals().weak_text_color();
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(12.0), color);
}

/// Paints the values along a line over its length in metres.
pub(crate) fn profile(ui: &mut Ui, size: Vec2, values: &[f32], length: f64, unit: &str) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let (low, high) = values.iter().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let area = rect.shrink2(vec2(8.0, 18.0));
    let span = (high - low).max(1e-6);
    let last = values.len().saturating_sub(1).max(1) as f32;
    let at = |k: usize| {
        let t = k as f32 / last;
        pos2(area.left() + t * area.width(), area.bottom() - (values[k] - low) / span * area.height())
    };
    painter.line((0..values.len()).map(at).collect(), Stroke::new(1.5, theme::CHOSEN));
    let color = ui.visuals().weak_text_color();
    let font = FontId::proportional(11.0);
    let label = |p, align, text: String| _ = painter.text(p, align, text, font.clone(), color);
    label(rect.left_top() + vec2(8.0, 3.0), Align2::LEFT_TOP, format!("{} {unit}", short(high)));
    label(rect.left_bottom() + vec2(8.0, -3.0), Align2::LEFT_BOTTOM, format!("{} {unit}", short(low)));
    label(rect.right_bottom() + vec2(-8.0, -3.0), Align2::RIGHT_BOTTOM, format!("{length:.0} m"));
    if let Some(p) = response.hover_pos() {
        let k = (((p.x - area.left()) / area.width()).clamp(0.0, 1.0) * last).round() as usize;
        painter.vline(at(k).x, area.y_range(), Stroke::new(1.0, color));
        let far = length * f64::from(k as f32 / last);
        let text = format!("{far:.0} m: {} {unit}", short(values[k]));
        label(rect.right_top() + vec2(-8.0, 3.0), Align2::RIGHT_TOP, text);
    }
}

/// Paints a histogram of the values of a field.
pub(crate) fn histogram(ui: &mut Ui, size: Vec2, field: &Field) {
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let Some((low, high)) = field.range().filter(|(a, b)| b > a) else { return };
    let mut bins = [0u32; BINS];
    // Every n-th sample is enough for the shape of the histogram.
    let step = (field.data().len() / 100_000).max(1);
    for v in field.data().iter().step_by(step) {
        let t = ((v - low) / (high - low)).clamp(0.0, 1.0);
        bins[((t * BINS as f32) as usize).min(BINS - 1)] += 1;
    }
    let most = bins.iter().copied().max().unwrap_or(1).max(1) as f32;
    let area = rect.shrink2(vec2(8.0, 18.0));
    let wide = area.width() / BINS as f32;
    for (k, n) in bins.iter().enumerate() {
        let x = area.left() + k as f32 * wide;
        let top = area.bottom() - *n as f32 / most * area.height();
        let bar = Rect::from_min_max(pos2(x, top), pos2(x + wide * 0.9, area.bottom()));
        painter.rect_filled(bar, 0.0, ui.visuals().selection.bg_fill);
    }
    let (color, font) = (ui.visuals().weak_text_color(), FontId::proportional(11.0));
    painter.text(rect.left_bottom() + vec2(8.0, -3.0), Align2::LEFT_BOTTOM, short(low), font.clone(), color);
    painter.text(rect.right_bottom() + vec2(-8.0, -3.0), Align2::RIGHT_BOTTOM, short(high), font, color);
}
