//! The views of the terrain: the map from above and the relief in perspective.

pub(crate) mod chart;
pub(crate) mod map;
pub(crate) mod relief;
mod space;
pub(crate) mod wipe;

use eframe::egui::{Color32, FontId, Rect, Ui, vec2};

use super::board::Board;

/// Paints over a view that it shows an older state, and why.
fn stale(ui: &Ui, screen: Rect, board: &Board) {
    let Some((_, why)) = &board.failure else { return };
    let text = format!("This is not up to date: {why}");
    let room = (screen.width() - 40.0).max(80.0);
    // The colour is lighter than that of other errors, so that it is legible on the dark ground.
    let color = Color32::from_rgb(255, 150, 136);
    let galley = ui.painter().layout(text, FontId::proportional(13.0), color, room);
    let rect = Rect::from_min_size(screen.left_top() + vec2(14.0, 12.0), galley.size());
    ui.painter().rect_filled(rect.expand(5.0), 4.0, Color32::from_black_alpha(190));
    ui.painter().galley(rect.min, galley, color);
}
