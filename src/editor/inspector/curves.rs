//! The panel of feature curves: the list of curves, and the attributes of the chosen constraint point.

use eframe::egui::{self, ComboBox, DragValue, RichText, ScrollArea, Ui, WidgetType};

use super::Panel;
use super::value::named;
use crate::editor::drawing::sheet::Sheet;
use crate::editor::drawing::{Drawing, DrawingContext, Tool};
use crate::graph::NodeId;
use crate::params::Param;
use crate::value::curves::{
    ConstraintPoint, Elevation, Envelope, Fault, MAX_ANGLE, MAX_EXTENT, MAX_HEIGHT, Noise, Rise, Slope,
};
use crate::value::{Curve, CurveSpec};

/// Shows the button of the tool that draws curves.
pub(super) fn tool(ui: &mut Ui, panel: &mut Panel<'_>, id: NodeId) {
    let (drawing, cx) = panel.drawing_context(id);
    drawing.read(&cx);
    draw_button(ui, drawing);
}

fn draw_button(ui: &mut Ui, drawing: &mut Drawing) {
    let draws = drawing.tool == Tool::Draw;
    let help = "Click for each point, or drag freely; double-click, Enter or Esc ends";
    if ui.selectable_label(draws, "✏ Draw on the terrain").on_hover_text(help).clicked() {
        if draws { drawing.end_tool() } else { drawing.begin_curve() }
    }
}

pub(super) fn panel(ui: &mut Ui, panel: &mut Panel<'_>, id: NodeId, param: &Param) {
    let (drawing, mut cx) = panel.drawing_context(id);
    drawing.read(&cx);
    let Some(Sheet::Curves(specs)) = drawing.sheet().cloned() else { return };
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("{} curves", specs.len())).strong()).on_hover_text(&param.doc);
        draw_button(ui, drawing);
    });
    let key = egui::Id::new("curve that was chosen");
    let last: Option<usize> = ui.data(|d| d.get_temp(key)).unwrap_or_default();
    let rows = ScrollArea::vertical().id_salt("curves").max_height(220.0).auto_shrink([false, true]);
    rows.show(ui, |ui| {
        for i in 0..specs.len() {
            let name = drawing.sheet().map(|s| s.name(i)).unwrap_or_default();
            let row = ui.selectable_label(drawing.curve == Some(i), name);
            if row.clicked() {
                drawing.choose(Some(i));
            } else if drawing.curve == Some(i) && drawing.curve != last {
                // The curve was chosen on the terrain.
                row.scroll_to_me(None);
            }
        }
    });
    ui.data_mut(|d| d.insert_temp(key, drawing.curve));
    let Some(spec) = drawing.curve.and_then(|i| specs.get(i)) else {
        ui.weak(match drawing.tool {
            Tool::Draw => {
                "Click for each point on the terrain, or drag freely. Double-click, Enter or Esc ends."
            }
            _ => "Click a curve on the terrain, or here, to change it.",
        });
        return;
    };
    ui.separator();
    whole(ui, drawing, &mut cx, spec);
    match drawing.chosen_curve().cloned().map_or_else(|| spec.build(), Ok) {
        Ok(curve) => points(ui, drawing, &mut cx, &curve),
        Err(fault) => _ = ui.colored_label(crate::editor::theme::ERROR, format!("The curve {fault}")),
    }
}

/// Shows the settings of the whole curve.
fn whole(ui: &mut Ui, drawing: &mut Drawing, cx: &mut DrawingContext<'_>, spec: &CurveSpec) {
    ui.horizontal(|ui| {
        let mut name = spec.name.clone();
        let edit =
            egui::TextEdit::singleline(&mut name).hint_text("Name").char_limit(64).desired_width(150.0);
        let edit = ui.add(edit);
        named(&edit, WidgetType::TextEdit, "curve name");
        if edit.changed() {
            drawing.change(cx, "Rename curve", "curve name", |s| {
                s.name = name;
                Ok(())
            });
        }
        if ui.button("Turn round").on_hover_text("Swaps start and end, left and right").clicked() {
            drawing.change(cx, "Turn curve round", "", |s| {
                *s = s.reversed();
                Ok(())
            });
        }
        if ui.button("🗑").on_hover_text("Deletes the curve").clicked() {
            drawing.remove_curve(cx);
        }
    });
    ui.horizontal(|ui| {
        ui.label("height goes");
        let text = |rise| match rise {
            Rise::Monotone => "without overshoot",
            Rise::Free => "as a free cubic",
        };
        let combo = ComboBox::from_id_salt("rise").selected_text(text(spec.rise)).show_ui(ui, |ui| {
            for rise in [Rise::Monotone, Rise::Free] {
                if ui.selectable_label(spec.rise == rise, text(rise)).clicked() {
                    drawing.change(cx, "Set rise", "", |s| {
                        s.rise = rise;
                        Ok(())
                    });
                }
            }
        });
        named(&combo.response, WidgetType::ComboBox, "rise");
    });
}

/// Shows the constraint points and the attributes of the chosen one.
fn points(ui: &mut Ui, drawing: &mut Drawing, cx: &mut DrawingContext<'_>, curve: &Curve) {
    let points = curve.points();
    ui.horizontal_wrapped(|ui| {
        ui.label("Constraint points");
        for (k, point) in points.iter().enumerate() {
            let text = format!("at {:.2}", point.u);
            if ui.selectable_label(drawing.point == Some(k), text).clicked() {
                drawing.point = Some(k);
            }
        }
        if ui.small_button("➕").on_hover_text("In the middle of the widest gap").clicked() {
            drawing.add_point(cx, widest_gap(&points));
        }
    });
    let Some((k, point)) = drawing.point.and_then(|k| Some((k, *points.get(k)?))) else {
        ui.weak("Shift-double-click on the curve adds one; choose one to set what holds there.");
        return;
    };
    let mut next = point;
    let here = curve.attributes(point.u);
    groups(ui, &mut next, &here);
    if next != point {
        let mut all = points;
        all[k] = next;
        drawing.change(cx, "Set constraint point", &format!("point {k}"), |spec| {
            let mut changed = spec.clone();
            changed.set_points(&all);
            changed.build()?;
            *spec = changed;
            Ok::<(), Fault>(())
        });
    }
    if points_removable(curve) && ui.button("Remove this point").clicked() {
        drawing.remove_point(cx, k);
    }
}

fn points_removable(curve: &Curve) -> bool {
    curve.points().len() > 1
}

fn widest_gap(points: &[ConstraintPoint]) -> f64 {
    let us: Vec<f64> = std::iter::once(0.0).chain(points.iter().map(|p| p.u)).chain([1.0]).collect();
    let gaps = us.windows(2).map(|w| (w[1] - w[0], 0.5 * (w[0] + w[1])));
    gaps.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.5, |(_, middle)| middle)
}

/// The first value of a group that the curve does not set yet.
const SLOPE: Slope = Slope { left_extent: 300.0, right_extent: 300.0, left_angle: -30.0, right_angle: -30.0 };
const NOISE: Noise = Noise { amplitude: 20.0, roughness: 0.4 };
const ENVELOPE: Envelope = Envelope { left: 300.0, right: 300.0 };

fn groups(ui: &mut Ui, point: &mut ConstraintPoint, here: &ConstraintPoint) {
    let metres = |min: f64, max: f64| (min..=max, " m", 1.0);
    let first = here.elevation.unwrap_or(Elevation { height: 0.0, radius: 0.0 });
    group(ui, "Height and plateau", &mut point.elevation, first, |ui, e| {
        number(ui, "height", &mut e.height, metres(-MAX_HEIGHT, MAX_HEIGHT));
        number(ui, "plateau radius", &mut e.radius, metres(0.0, MAX_EXTENT));
    });
    group(ui, "Slopes", &mut point.slope, here.slope.unwrap_or(SLOPE), |ui, s| {
        let degrees = || (-MAX_ANGLE..=MAX_ANGLE, "°", 0.25);
        number(ui, "left extent", &mut s.left_extent, metres(0.0, MAX_EXTENT));
        number(ui, "left angle", &mut s.left_angle, degrees());
        number(ui, "right extent", &mut s.right_extent, metres(0.0, MAX_EXTENT));
        number(ui, "right angle", &mut s.right_angle, degrees());
    });
    group(ui, "Noise", &mut point.noise, here.noise.unwrap_or(NOISE), |ui, n| {
        number(ui, "amplitude", &mut n.amplitude, metres(0.0, MAX_HEIGHT));
        number(ui, "roughness", &mut n.roughness, (0.0..=1.0, "", 0.005));
    });
    group(ui, "Smoothed strip", &mut point.envelope, here.envelope.unwrap_or(ENVELOPE), |ui, e| {
        number(ui, "left width", &mut e.left, metres(0.0, MAX_EXTENT));
        number(ui, "right width", &mut e.right, metres(0.0, MAX_EXTENT));
    });
}

/// Shows the check box of a group of attributes that the point may set.
fn group<T: Copy>(
    ui: &mut Ui,
    title: &str,
    value: &mut Option<T>,
    first: T,
    edit: impl FnOnce(&mut Ui, &mut T),
) {
    let mut on = value.is_some();
    if ui
        .checkbox(&mut on, title)
        .on_hover_text("Whether this point says it. What one point alone says holds along the whole curve")
        .changed()
    {
        *value = on.then_some(first);
    }
    if let Some(value) = value {
        ui.indent(title, |ui| edit(ui, value));
    }
}

fn number(
    ui: &mut Ui,
    name: &str,
    value: &mut f64,
    (range, unit, speed): (std::ops::RangeInclusive<f64>, &str, f64),
) {
    ui.horizontal(|ui| {
        ui.add_sized([96.0, 18.0], egui::Label::new(name).truncate());
        let drag = DragValue::new(value).range(range).speed(speed).max_decimals(3).suffix(unit);
        let moved = ui.add(drag);
        named(&moved, WidgetType::DragValue, name);
    });
}
