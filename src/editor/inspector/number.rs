//! Widgets of numbers: sliders over the usual range, fields in which any allowed number can be typed, seeds with dice.

use eframe::egui::{self, DragValue, Slider, SliderClamping, Ui};
use serde_json::Value as Json;

use super::value::{Edited, Field, named};
use crate::kit::hash;
use crate::params::Shape;

/// The width of a range above which there is a slider only where the parameter has a soft range.
const WIDE: f64 = 1.0e5;

struct Range {
    min: f64,
    max: f64,
    integer: bool,
}

fn range(shape: &Shape) -> Range {
    match shape {
        Shape::Number { min, max, integer } => Range { min: *min, max: *max, integer: *integer },
        _ => Range { min: f64::MIN, max: f64::MAX, integer: false },
    }
}

/// A number as JSON; whole numbers have no decimal point.
fn written(value: f64, range: &Range) -> Json {
    let value = value.clamp(range.min, range.max);
    if range.integer || (value.fract() == 0.0 && value.abs() < 1e15) {
        return Json::from(value.round() as i64);
    }
    // A slider gives more digits than the user can choose, so that the number is rounded to six.
    let digits = 5 - libm::log10(value.abs()).floor() as i32;
    let scale = libm::pow(10.0, f64::from(digits.clamp(0, 9)));
    Json::from((value * scale).round() / scale)
}

fn suffix(unit: Option<&str>) -> String {
    match unit {
        None | Some("1") => String::new(),
        Some("deg") => "°".to_owned(),
        Some(unit) => format!(" {unit}"),
    }
}

/// Shows a slider over the soft range, or over the whole range where there is no soft one and the whole is not too
/// wide.
pub(super) fn edit(ui: &mut Ui, field: &Field<'_>, value: &mut Json) -> Edited {
    let range = range(field.shape);
    let usual = field.soft.or_else(|| (range.max - range.min <= WIDE).then_some([range.min, range.max]));
    let Some([low, high]) = usual else { return bare(ui, field, value) };
    let mut number = value.as_f64().unwrap_or_default();
    let wide = low > 0.0 && high / low > 500.0;
    let room = (ui.available_width() - 78.0).clamp(40.0, 220.0);
    ui.spacing_mut().slider_width = room;
    let slider = Slider::new(&mut number, low..=high)
        .clamping(SliderClamping::Never)
        .logarithmic(wide)
        .smart_aim(true)
        .max_decimals(if range.integer { 0 } else { 4 })
        .integer_if(range.integer)
        // A typed number takes effect when the field is left, not at every digit.
        .update_while_editing(false)
        .suffix(suffix(field.unit));
    let moved = ui.add(slider);
    let hint = format!("{} to {}{}", range.min, range.max, suffix(field.unit));
    let moved = moved.on_hover_text(format!("{hint}; click the number to type"));
    named(&moved, egui::WidgetType::Slider, field.name);
    // A field that was opened and left unchanged reports a change, too.
    if moved.changed() && Some(number) != value.as_f64() {
        *value = written(number, &range);
    }
    Edited::of(&moved)
}

trait IntegerIf {
    fn integer_if(self, integer: bool) -> Self;
}

impl IntegerIf for Slider<'_> {
    fn integer_if(self, integer: bool) -> Self {
        if integer { self.integer() } else { self }
    }
}

/// Shows a number without a slider.
pub(super) fn bare(ui: &mut Ui, field: &Field<'_>, value: &mut Json) -> Edited {
    let range = range(field.shape);
    let mut number = value.as_f64().unwrap_or_default();
    let span = field.soft.map_or(range.max - range.min, |[a, b]| b - a);
    let speed =
        if range.integer { 0.2 } else { (number.abs() * 0.01).max(span.min(1000.0) * 0.002).max(1e-4) };
    let drag = DragValue::new(&mut number)
        .range(range.min..=range.max)
        .speed(speed)
        .update_while_editing(false)
        .max_decimals(if range.integer { 0 } else { 5 })
        .suffix(suffix(field.unit));
    let moved = ui.add(drag);
    named(&moved, egui::WidgetType::DragValue, field.name);
    // A field that was opened and left unchanged reports a change, too.
    if moved.changed() && Some(number) != value.as_f64() {
        *value = written(number, &range);
    }
    Edited::of(&moved)
}

/// Shows a seed, with buttons for a random one and for the one before.
pub(super) fn seed(ui: &mut Ui, field: &Field<'_>, value: &mut Json) -> Edited {
    let row = ui.horizontal(|ui| {
        let mut edited = bare(ui, field, value);
        if ui.button("🎲").on_hover_text("Another seed").clicked() {
            let old = value.as_u64().unwrap_or_default();
            *value = Json::from(1 + hash::nth(hash::mix(old), 1) % 999_999);
            edited = Edited::Done;
        }
        let back = ui.add_enabled(field.previous.is_some(), egui::Button::new("⟲"));
        if back.on_hover_text("The seed before").clicked()
            && let Some(previous) = field.previous
        {
            *value = previous.clone();
            edited = Edited::Done;
        }
        edited
    });
    row.inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_short_and_in_range() {
        let range = |min, max, integer| Range { min, max, integer };
        assert_eq!(written(0.1 + 0.2, &range(0.0, 1.0, false)), Json::from(0.3));
        assert_eq!(written(1.5, &range(0.0, 1.0, false)), Json::from(1));
        assert_eq!(written(7.4, &range(1.0, 16.0, true)), Json::from(7));
        assert_eq!(written(1234.56789, &range(0.0, 1e4, false)), Json::from(1234.57));
    }
}
