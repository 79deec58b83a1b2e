//! Colours and shapes. Wires differ in the shape of their pins as well as in colour. Their colours are those of Okabe
//! and Ito, which colour-blind people can distinguish.

use eframe::egui::{self, Color32, Pos2, Shape, Stroke, vec2};

use crate::graph::NoteColor;
use crate::value::{Pin, WireType};

/// The colour of a type of wire.
pub(crate) fn wire_color(wire: WireType) -> Color32 {
    let [r, g, b] = wire.color();
    Color32::from_rgb(r, g, b)
}

/// The pin of a wire.
pub(crate) fn pin(wire: WireType, at: Pos2, radius: f32, filled: bool) -> Shape {
    let color = wire_color(wire);
    let corners = |n: usize, turn: f32| {
        let corner = |k: usize| {
            let angle = (k as f32 + turn) / n as f32 * std::f32::consts::TAU;
            at + vec2(libm::cosf(angle), libm::sinf(angle)) * (radius * 1.2)
        };
        (0..n).map(corner).collect::<Vec<_>>()
    };
    let fill = if filled { color } else { Color32::from_gray(24) };
    let stroke = Stroke::new((radius * 0.32).max(1.0), color);
    match wire.pin() {
        Pin::Circle => Shape::Circle(egui::epaint::CircleShape { center: at, radius, fill, stroke }),
        Pin::Polygon { corners: n, turn } => Shape::convex_polygon(corners(n.into(), turn), fill, stroke),
    }
}

/// The colour of a family of kinds, for the head of a node.
pub(crate) fn family_color(family: &str, dark: bool) -> Color32 {
    let [r, g, b] = match family {
        "generate" => [70, 110, 78],
        "files" => [96, 96, 104],
        "curves" => [42, 108, 108],
        "rivers" => [40, 88, 128],
        "erosion" => [124, 74, 58],
        "blend" => [128, 92, 48],
        "filter" => [62, 88, 132],
        "select" => [104, 74, 124],
        _ => [84, 84, 90],
    };
    // Titles are white in both themes.
    let lift = |c: u8| if dark { c } else { c.saturating_add(18) };
    Color32::from_rgb(lift(r), lift(g), lift(b))
}

/// The colour of a note.
pub(crate) fn note_color(color: NoteColor) -> Color32 {
    match color {
        NoteColor::Grey => Color32::from_rgb(120, 124, 132),
        NoteColor::Blue => Color32::from_rgb(70, 126, 190),
        NoteColor::Green => Color32::from_rgb(72, 148, 92),
        NoteColor::Yellow => Color32::from_rgb(192, 168, 60),
        NoteColor::Orange => Color32::from_rgb(204, 126, 50),
        NoteColor::Red => Color32::from_rgb(190, 78, 78),
        NoteColor::Violet => Color32::from_rgb(134, 96, 180),
    }
}

/// The colour of errors.
pub(crate) const ERROR: Color32 = Color32::from_rgb(222, 84, 70);
/// The colour of warnings.
pub(crate) const WARNING: Color32 = Color32::from_rgb(204, 132, 24);
/// The colour of what is chosen.
pub(crate) const CHOSEN: Color32 = Color32::from_rgb(255, 196, 84);

/// Sets the style of all windows.
pub(crate) fn apply(ctx: &egui::Context) {
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(6.0, 5.0);
        style.spacing.slider_width = 120.0;
        style.visuals.widgets.noninteractive.corner_radius = 4.into();
        style.interaction.tooltip_delay = 0.35;
    });
}
