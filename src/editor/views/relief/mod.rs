//! The relief view: the terrain in perspective, drawn from its samples by the graphics device. It is draped with the
//! picture of the flat view or of the renderer.

mod device;
mod orbit;
mod pieces;
mod pipeline;
mod space;
mod texture;

use std::sync::Arc;

use eframe::egui::{self, Align2, Color32, FontId, PointerButton, Sense, Ui, vec2};
use eframe::egui_wgpu::Callback;
use eframe::wgpu::TextureFormat;
use glam::Vec3;

use device::{DrawnTerrain, Frame};
use orbit::Orbit;
use pieces::Sight;
use space::Deep;

use super::wipe::Wipe;
use crate::editor::board::{Board, Shown};
use crate::editor::drawing::{Drawing, DrawingContext};
use crate::editor::shade::Light;
use crate::render::Picture;
use crate::value::{Field, Quantity, Value};

/// The most samples along a side that every device accepts as a texture.
const MOST: usize = 8192;

/// The state of the relief view.
pub(crate) struct ReliefView {
    pub(crate) exaggeration: f32,
    pub(crate) water: bool,
    /// Pixels that a quad may cover before it is divided.
    pub(crate) coarseness: f32,
    /// Where the light comes from.
    pub(crate) light: Light,
    orbit: Orbit,
    /// Whether the view is fitted to the whole terrain in the next frame.
    fit: bool,
    /// The pixel format of the window; `None` where there is no device to draw with.
    format: Option<TextureFormat>,
}

impl ReliefView {
    pub(crate) fn new(format: Option<TextureFormat>) -> Self {
        let (orbit, light) = (Orbit::default(), Light::default());
        Self { exaggeration: 1.0, water: true, coarseness: 2.5, light, orbit, fit: true, format }
    }

    /// Fits the view to the whole terrain in its initial direction.
    pub(crate) fn reset(&mut self) {
        self.fit = true;
    }

    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        board: &Board,
        wipe: &mut Wipe,
        drawing: &mut Drawing,
        cx: &mut DrawingContext<'_>,
    ) {
        let (rect, ground) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ground.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, "relief view"));
        let background = if ui.visuals().dark_mode {
            Color32::from_rgb(30, 35, 42)
        } else {
            Color32::from_rgb(196, 206, 216)
        };
        ui.painter().rect_filled(rect, 0.0, background);
        drawing.read(cx);
        self.steer(ui, &ground, drawing.takes_primary_button());
        let shown = board.shown.as_ref();
        let lit = board.lit_now_or_before();
        let main = shown.and_then(|s| terrain(s, lit.map(|l| (&l.picture, l.number))));
        let (Some(main), Some(format)) = (main, self.format) else {
            let text = match (shown, self.format) {
                (_, None) => "There is no graphics device to draw with.",
                (None, _) => "Select a node to see its terrain.",
                (Some(_), _) => {
                    "This is no height: see it in the map, or pin the height and look from there."
                }
            };
            let (font, color) = (FontId::proportional(14.0), ui.visuals().weak_text_color());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, color);
            return;
        };
        let against = board
            .against
            .as_ref()
            .and_then(|s| terrain(s, lit.and_then(|l| Some((l.against.as_ref()?, l.number)))));
        let heights = [Some(&main), against.as_ref()].into_iter().flatten().filter_map(|t| t.height.range());
        let range = heights.fold([f32::MAX, f32::MIN], |[a, b], (low, high)| [a.min(low), b.max(high)]);
        let sight = self.sight(&main.height, range, rect.size(), ui.pixels_per_point());
        let size = rect.size() * ui.pixels_per_point();
        let pixels = [size.x, size.y].map(|v| (v.round() as u32).clamp(1, 8192));
        let background = [background.r(), background.g(), background.b()].map(|c| f32::from(c) / 255.0);
        let sea = cx.document.graph().terrain().sea_level.map(|level| level as f32);
        let water = sea.filter(|sea| self.water && *sea > range[0]);
        let height = main.height.clone();
        let draw = |terrain: DrawnTerrain, slot: usize, clip: egui::Rect| {
            let exaggeration = self.exaggeration;
            let frame =
                Frame { terrain, sight, exaggeration, range, slot, water, background, pixels, format };
            let painter = ui.painter().with_clip_rect(clip.intersect(ui.clip_rect()));
            painter.add(Callback::new_paint_callback(rect, frame));
        };
        let compared = against.is_some();
        draw(main, 0, if compared { wipe.left(rect) } else { rect });
        if let Some(against) = against {
            draw(against, 1, wipe.right(rect));
        }
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(rect));
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        if compared {
            wipe.show(&ui, rect);
        }
        let space = Deep {
            to_screen: sight.to_screen,
            eye: sight.eye,
            screen: rect,
            height: &height,
            exaggeration: f64::from(self.exaggeration),
            range: range.map(f64::from),
        };
        drawing.show(&ui, &space, &ground, cx);
        super::stale(&ui, rect, board);
        if shown.is_some_and(|s| s.is_draft) {
            let at = rect.left_bottom() + vec2(12.0, -10.0);
            ui.painter().text(at, Align2::LEFT_BOTTOM, "draft", FontId::monospace(12.0), Color32::WHITE);
        }
    }

    /// Orbits, pans, zooms and flies.
    fn steer(&mut self, ui: &Ui, ground: &egui::Response, drawing: bool) {
        let size = ground.rect.size().max(vec2(1.0, 1.0));
        let by = ground.drag_delta();
        let shift = ui.input(|i| i.modifiers.shift);
        let primary = ground.dragged_by(PointerButton::Primary);
        if primary && drawing {
            // The button acts on the drawing.
        } else if primary && !shift {
            self.orbit.turn(by.x / size.x * 240.0, by.y / size.y * 140.0);
        } else if ground.dragged() {
            self.orbit.pan(by.x / size.y, by.y / size.y);
        }
        if ground.double_clicked() && !drawing {
            self.reset();
        }
        if !ground.hovered() && !ground.dragged() {
            return;
        }
        let (scroll, pinch, dt) =
            ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta(), i.stable_dt.min(0.1)));
        let factor = pinch * libm::expf(scroll * 0.003);
        if factor != 1.0 {
            self.orbit.zoom(factor);
        }
        let flying = (ground.dragged() && !drawing) || ground.has_focus();
        let key = |k: egui::Key| ui.input(|i| i.key_down(k)) && flying;
        let axis = |more, less| f32::from(u8::from(key(more))) - f32::from(u8::from(key(less)));
        use egui::Key::{A, D, E, Q, S, W};
        let (ahead, right, up) = (axis(W, S), axis(D, A), axis(E, Q));
        if (ahead, right, up) != (0.0, 0.0, 0.0) {
            self.orbit.fly(ahead * dt, right * dt, up * dt);
            ui.ctx().request_repaint();
        }
    }

    fn sight(&mut self, height: &Field, [low, high]: [f32; 2], size: egui::Vec2, points: f32) -> Sight {
        let grid = height.grid();
        let cell = grid.cell() as f32;
        let half = |n: usize| 0.5 * (n - 1) as f32 * cell;
        let corner = [-half(grid.cols), -half(grid.rows)];
        let unit = (2.0 * half(grid.cols.max(grid.rows))).max(1e-3);
        let reach = 0.5 * (high - low) * self.exaggeration;
        if std::mem::take(&mut self.fit) {
            // The block extends below the lowest ground.
            let half = Vec3::new(-corner[0], -corner[1], reach.max(0.0)) / unit + Vec3::new(0.0, 0.0, 0.04);
            self.orbit = Orbit::default().fitted(half, size.x / size.y.max(1.0));
        }
        let to_screen = self.orbit.projection(size.x / size.y.max(1.0), unit);
        let eye: Vec3 = self.orbit.eye() * unit;
        Sight {
            to_screen,
            eye,
            cols: grid.cols as u32,
            rows: grid.rows as u32,
            corner,
            cell,
            heights: [-reach, reach],
            pixels: size.y * points,
            coarseness: self.coarseness,
        }
    }
}

/// The terrain to draw for a value, with its best picture; `None` where the value is no height.
fn terrain(shown: &Shown, lit: Option<(&Arc<Picture>, u64)>) -> Option<DrawnTerrain> {
    let Value::Field(height) = &shown.value else { return None };
    let grid = height.grid();
    let fits = (2..=MOST).contains(&grid.cols) && (2..=MOST).contains(&grid.rows);
    if !fits || !matches!(height.quantity(), Quantity::Elevation | Quantity::Length) {
        return None;
    }
    let (picture, picture_id) = lit.unwrap_or((&shown.picture, 0));
    let picture = Arc::clone(picture);
    Some(DrawnTerrain { id: shown.id, height: height.clone(), picture_id, picture })
}
