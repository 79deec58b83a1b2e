//! The widget of a ramp of colours.

use eframe::egui::{self, Color32, Id, Mesh, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use serde_json::{Value as Json, json};

use super::value::{Edited, named};
use crate::kit::ramp::{Blend, Ramp, Stop};

/// Number of columns in which the ramp is drawn.
const COLUMNS: usize = 96;

/// Shows a band of colours above its stops. A double click on the band adds a stop, one on a stop removes it.
pub(super) fn edit(ui: &mut Ui, name: &str, value: &mut Json) -> Edited {
    let mut stops = read(value);
    let width = ui.available_width().min(260.0);
    let (rect, band) = ui.allocate_exact_size(vec2(width, 38.0), Sense::click());
    named(&band, egui::WidgetType::Other, name);
    let bar = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - 14.0)).shrink2(vec2(6.0, 0.0));
    paint(ui, bar, &stops);
    let mut edited = Edited::No;
    let mut removed = None;
    let chosen_id = ui.id().with((name, "chosen"));
    let mut chosen: usize = ui.data(|d| d.get_temp(chosen_id)).unwrap_or(0);
    for i in 0..stops.len() {
        let at = pos2(bar.left() + stops[i][0] as f32 * bar.width(), bar.bottom() + 7.0);
        let handle = Rect::from_center_size(at, vec2(12.0, 14.0));
        let response = ui.interact(handle, Id::new((name, ui.id(), i)), Sense::click_and_drag());
        named(&response, egui::WidgetType::Button, &format!("{name} stop {i}"));
        if response.clicked() || response.drag_started() {
            chosen = i;
        }
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let x = f64::from((pointer.x - bar.left()) / bar.width()).clamp(0.0, 1.0);
            let low = if i == 0 { 0.0 } else { stops[i - 1][0] };
            let high = stops.get(i + 1).map_or(1.0, |s| s[0]);
            stops[i][0] = round(x.clamp(low, high));
            edited = Edited::Going;
        }
        if response.drag_stopped() {
            edited = Edited::Done;
        }
        if response.double_clicked() && stops.len() > 1 {
            removed = Some(i);
        }
        let edge = if i == chosen { ui.visuals().strong_text_color() } else { Color32::DARK_GRAY };
        let points = vec![
            at + vec2(0.0, -7.0),
            at + vec2(6.0, 0.0),
            at + vec2(6.0, 6.0),
            at + vec2(-6.0, 6.0),
            at + vec2(-6.0, 0.0),
        ];
        ui.painter().add(Shape::convex_polygon(points, screen(stops[i]), Stroke::new(1.5, edge)));
    }
    if let Some(i) = removed {
        stops.remove(i);
        edited = Edited::Done;
    } else if let Some(at) = band.interact_pointer_pos().filter(|p| band.double_clicked() && bar.contains(*p))
    {
        let x = round(f64::from((at.x - bar.left()) / bar.width()).clamp(0.0, 1.0));
        let [r, g, b] = ramp(&stops).color(x as f32).map(|c| round(f64::from(c)));
        let i = stops.iter().position(|s| s[0] > x).unwrap_or(stops.len());
        if stops.len() < 64 {
            stops.insert(i, [x, r, g, b]);
            chosen = i;
            edited = Edited::Done;
        }
    }
    chosen = chosen.min(stops.len().saturating_sub(1));
    if let Some(stop) = stops.get_mut(chosen) {
        ui.horizontal(|ui| {
            let mut rgb = [stop[1] as f32, stop[2] as f32, stop[3] as f32];
            let mut bytes = rgb.map(|c| (c * 255.0 + 0.5) as u8);
            let picked = ui.color_edit_button_srgb(&mut bytes);
            named(&picked, egui::WidgetType::ColorButton, &format!("{name} colour"));
            if picked.changed() {
                rgb = bytes.map(|c| f32::from(c) / 255.0);
                *stop =
                    [stop[0], round(f64::from(rgb[0])), round(f64::from(rgb[1])), round(f64::from(rgb[2]))];
                edited = Edited::Going;
            }
            ui.weak(format!("stop at {:.3}", stop[0]));
        });
    }
    ui.data_mut(|d| d.insert_temp(chosen_id, chosen));
    band.on_hover_text("Drag stops; double-click the band to add one, a stop to remove it");
    if edited != Edited::No {
        *value = stops.iter().map(|s| Json::from(s.map(tidy).to_vec())).collect();
    }
    edited
}

fn paint(ui: &Ui, bar: Rect, stops: &[[f64; 4]]) {
    let ramp = ramp(stops);
    let mut mesh = Mesh::default();
    for k in 0..COLUMNS {
        let at = |k: usize| bar.left() + k as f32 / COLUMNS as f32 * bar.width();
        let [r, g, b] = ramp.color((k as f32 + 0.5) / COLUMNS as f32).map(|c| (c * 255.0 + 0.5) as u8);
        let column = Rect::from_min_max(pos2(at(k), bar.top()), pos2(at(k + 1), bar.bottom()));
        mesh.add_colored_rect(column, Color32::from_rgb(r, g, b));
    }
    ui.painter().add(Shape::mesh(mesh));
}

fn ramp(stops: &[[f64; 4]]) -> Ramp {
    let stop = |s: &[f64; 4]| Stop { at: s[0] as f32, color: [s[1] as f32, s[2] as f32, s[3] as f32] };
    Ramp::new(stops.iter().map(stop).collect(), Blend::Smooth)
}

fn screen(stop: [f64; 4]) -> Color32 {
    let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    Color32::from_rgb(byte(stop[1]), byte(stop[2]), byte(stop[3]))
}

fn read(value: &Json) -> Vec<[f64; 4]> {
    let stop = |s: &Json| {
        let part = |k: usize| s.get(k)?.as_f64();
        Some([part(0)?, part(1)?, part(2)?, part(3)?])
    };
    value.as_array().map(|items| items.iter().filter_map(stop).collect()).unwrap_or_default()
}

fn round(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0
}

fn tidy(v: f64) -> Json {
    if v == v.round() { json!(v as i64) } else { json!(v) }
}
