//! The flat view: a picture of the values from above, with a read-out, a profile and contour lines.

use eframe::egui::{
    self, Align2, Color32, FontId, PointerButton, Pos2, Rect, Sense, Stroke, TextureHandle, TextureOptions,
    Ui, Vec2, pos2, vec2,
};

use super::chart;
use super::space::Flat;
use super::wipe::Wipe;
use crate::editor::board::{Board, Shown};
use crate::editor::canvas::camera::{Camera, Viewport};
use crate::editor::drawing::{Drawing, DrawingContext};
use crate::editor::shade::Look;
use crate::editor::{image_of, theme};
use crate::value::{Bounds, Field, Grid, Quantity, Sketch, Value};

/// The most samples of a finer part.
const MOST: usize = 4 << 20;

/// The state of the flat view.
pub(crate) struct MapView {
    pub(crate) look: Look,
    /// Whether the profile and the histogram are shown.
    pub(crate) charts: bool,
    /// Samples along the longer side; `None` for as many as the view can show.
    pub(crate) samples: Option<u32>,
    camera: Option<Camera>,
    texture: Option<(u64, TextureHandle)>,
    /// The texture of the value in comparison.
    other: Option<(u64, TextureHandle)>,
    /// The texture of the finer part.
    fine: Option<(u64, TextureHandle)>,
    /// The part that the user has zoomed in to: a window of a finer lattice.
    closer: Option<Grid>,
    /// The ends of the line of the profile, in metres.
    profile: Option<[[f64; 2]; 2]>,
    drawing: bool,
}

impl MapView {
    pub(crate) fn new(look: Look, charts: bool) -> Self {
        Self {
            look,
            charts,
            samples: None,
            camera: None,
            texture: None,
            other: None,
            fine: None,
            closer: None,
            profile: None,
            drawing: false,
        }
    }

    /// Fits the view to the whole terrain.
    pub(crate) fn show_all(&mut self) {
        self.camera = None;
    }

    /// Samples along the longer side for a view of this size in pixels.
    pub(crate) fn wanted(&self, pixels: Vec2) -> u32 {
        if let Some(samples) = self.samples {
            return samples;
        }
        let long = pixels.x.min(pixels.y).max(64.0);
        let fit = [129, 257, 513, 1025].into_iter().find(|n| *n as f32 >= 0.8 * long);
        fit.unwrap_or(1025)
    }

    /// The part that the user has zoomed in to so far that the samples of the whole are larger than pixels.
    pub(crate) fn closer(&self) -> Option<Grid> {
        self.closer
    }

    /// Finds the part that the user has zoomed in to, while neither button nor wheel is used.
    fn look_closer(&mut self, ui: &Ui, view: &Viewport, shown: &Shown) {
        let moving = ui.input(|i| i.pointer.any_down() || i.smooth_scroll_delta() != Vec2::ZERO);
        if moving {
            return;
        }
        let whole = shown.value.grid().filter(|_| !shown.is_draft);
        self.closer = whole.and_then(|whole| {
            let pixels = f64::from(view.zoom() * ui.pixels_per_point());
            let pixel = 1.0 / (unit(&shown.bounds) * pixels);
            let factor = [2, 4, 8, 16].into_iter().rfind(|f| whole.cell() / f64::from(*f) >= 0.9 * pixel)?;
            let fine = whole.refined(factor);
            let corners = [view.screen.min, view.screen.max].map(|p| to_metres(view.world(p), shown));
            let seen = Grid::covering(fine.lattice, Bounds { min: corners[0], max: corners[1] });
            // The window is rounded outwards to blocks of 64 samples, so that small movements need no evaluation.
            let [col, row] = [seen.col, seen.row].map(|v| v.div_euclid(64) * 64);
            let [end_col, end_row] = [seen.col_end(), seen.row_end()].map(|v| (v.div_euclid(64) + 1) * 64);
            let window = Grid::between(fine.lattice, [col, row], [end_col, end_row]).intersection(&fine);
            (window.cols > 1 && window.rows > 1 && window.len() <= MOST).then_some(window)
        });
    }

    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        board: &Board,
        wipe: &mut Wipe,
        drawing: &mut Drawing,
        cx: &mut DrawingContext<'_>,
    ) {
        let (screen, ground) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        ground.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, "map view"));
        ui.painter().rect_filled(screen, 0.0, ui.visuals().extreme_bg_color);
        self.texture(ui, board);
        let bounds = cx.document.graph().terrain().bounds();
        let view = self.travel(ui, screen, &ground, &bounds, drawing.takes_primary_button());
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(screen));
        ui.set_clip_rect(screen.intersect(ui.clip_rect()));
        let shown = board.shown.as_ref();
        match shown {
            None => {
                self.closer = None;
                self.empty(&ui, screen, board);
            }
            Some(shown) => {
                self.look_closer(&ui, &view, shown);
                self.pictures(&ui, &view, board, shown, &bounds, wipe);
                self.profile(&ui, &view, &ground, shown, drawing.takes_primary_button());
            }
        }
        let is_raster = shown.is_some_and(|s| s.value.grid().is_some());
        if board.against.is_some() && is_raster {
            wipe.show(&ui, screen);
        }
        let height = shown.and_then(|s| elevation(&s.value));
        drawing.show(&ui, &Flat { view, bounds, height }, &ground, cx);
        let Some(shown) = shown else { return };
        let pointer = ui.input(|i| i.pointer.hover_pos()).filter(|p| ground.hovered() && screen.contains(*p));
        let inside = |d: &&Shown| pointer.is_none_or(|p| view.rect(extent(d, &bounds)).contains(p));
        let beyond = |_: &&Shown| pointer.is_some_and(|p| p.x > wipe.line(screen));
        let finer = board.detail.as_ref().filter(inside);
        let read = board.against.as_ref().filter(beyond).or(finer).unwrap_or(shown);
        self.read_out(&ui, &view, screen, pointer, read);
        super::stale(&ui, screen, board);
    }

    /// Paints the picture of the value, its finer part, and the value in comparison.
    fn pictures(&self, ui: &Ui, view: &Viewport, board: &Board, shown: &Shown, bounds: &Bounds, wipe: &Wipe) {
        let painter = ui.painter();
        let Some((_, texture)) = &self.texture else { return };
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        // Lines are drawn as lines and not as a picture.
        if let Value::Object(object) = &shown.value
            && let Sketch::Lines(lines) = object.sketch()
        {
            painter.rect_filled(view.rect(unit_rect(bounds)), 0.0, Color32::from_gray(32));
            let space = Flat { view: *view, bounds: *bounds, height: None };
            crate::editor::drawing::plain_lines(ui, &space, &lines, shown.value.wire_type());
            return;
        }
        painter.image(texture.id(), view.rect(extent(shown, bounds)), whole, Color32::WHITE);
        if let (Some((_, texture)), Some(detail)) = (&self.fine, &board.detail) {
            painter.image(texture.id(), view.rect(extent(detail, bounds)), whole, Color32::WHITE);
        }
        if let (Some((_, texture)), Some(other)) = (&self.other, &board.against) {
            let painter = painter.with_clip_rect(wipe.right(ui.clip_rect()));
            painter.image(texture.id(), view.rect(extent(other, bounds)), whole, Color32::WHITE);
        }
    }

    fn empty(&self, ui: &Ui, screen: Rect, board: &Board) {
        let text = match (&board.failure, board.is_busy) {
            (Some((_, why)), _) => why.clone(),
            (None, true) => "Working…".to_owned(),
            (None, false) => "Select a node to see its terrain.".to_owned(),
        };
        let color = if board.failure.is_some() { theme::ERROR } else { ui.visuals().weak_text_color() };
        let galley = ui.painter().layout(text, FontId::proportional(14.0), color, screen.width() * 0.8);
        ui.painter().galley(screen.center() - galley.size() * 0.5, galley, color);
    }

    fn texture(&mut self, ui: &Ui, board: &Board) {
        let Some(shown) = &board.shown else {
            (self.texture, self.other) = (None, None);
            return;
        };
        if self.texture.as_ref().is_none_or(|(n, _)| *n != shown.id) {
            let magnification =
                if shown.is_draft { egui::TextureFilter::Linear } else { egui::TextureFilter::Nearest };
            let options = TextureOptions { magnification, ..TextureOptions::LINEAR };
            let load = |name: &str, shown: &Shown| {
                (shown.id, ui.ctx().load_texture(name, image_of(&shown.picture), options))
            };
            self.texture = Some(load("map view", shown));
            self.other = board.against.as_ref().map(|other| load("map comparison", other));
        }
        match &board.detail {
            None => self.fine = None,
            Some(detail) if self.fine.as_ref().is_none_or(|(n, _)| *n != detail.id) => {
                let options = TextureOptions::LINEAR;
                let texture = ui.ctx().load_texture("map detail", image_of(&detail.picture), options);
                self.fine = Some((detail.id, texture));
            }
            Some(_) => (),
        }
    }

    /// Pans and zooms. The camera's unit is a thousandth of the longer side of the terrain.
    fn travel(
        &mut self,
        ui: &Ui,
        screen: Rect,
        ground: &egui::Response,
        bounds: &Bounds,
        drawing: bool,
    ) -> Viewport {
        let whole = unit_rect(bounds);
        let room = (screen.size() - vec2(16.0, 16.0)).max(vec2(40.0, 40.0));
        let zoom = (room.x / whole.width()).min(room.y / whole.height());
        let all = Camera { middle: whole.center().to_vec2(), zoom };
        let mut camera = self.camera.unwrap_or(all);
        let at = ui.input(|i| i.pointer.hover_pos()).filter(|_| ground.hovered());
        if let Some(at) = at {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            let factor = pinch * libm::expf(scroll * 0.004);
            if factor != 1.0 {
                let fixed = Viewport { camera, screen }.world(at).to_vec2();
                let zoom = (camera.zoom * factor).clamp(0.05, 200.0);
                camera.middle = fixed + (camera.middle - fixed) * (camera.zoom / zoom);
                camera.zoom = zoom;
            }
        }
        let pans = [PointerButton::Middle, PointerButton::Secondary];
        let shift = ui.input(|i| i.modifiers.shift);
        let hand = ground.dragged_by(PointerButton::Primary) && !self.drawing && !drawing && !shift;
        if hand || pans.iter().any(|b| ground.dragged_by(*b)) {
            camera.middle -= ground.drag_delta() / camera.zoom;
        }
        if ground.double_clicked() && !drawing {
            camera = all;
        }
        // Until the user pans or zooms, the view stays fitted to the terrain when the window is resized.
        self.camera = (camera != all).then_some(camera);
        Viewport { camera, screen }
    }

    /// Handles Shift-drag, which draws the line of the profile, and paints the line.
    fn profile(&mut self, ui: &Ui, view: &Viewport, ground: &egui::Response, shown: &Shown, drawing: bool) {
        let metres = |p: Pos2| to_metres(view.world(p), shown);
        let shift = ui.input(|i| i.modifiers.shift);
        if ground.drag_started_by(PointerButton::Primary) && shift && !drawing {
            let from = ui.input(|i| i.pointer.press_origin()).map(metres);
            self.profile = from.map(|p| [p, p]);
            self.drawing = true;
            self.charts = true;
        }
        if let (true, Some(at), Some(line)) = (self.drawing, ground.interact_pointer_pos(), &mut self.profile)
        {
            line[1] = metres(at);
        }
        if ground.drag_stopped() {
            self.drawing = false;
        }
        if let Some(line) = self.profile.filter(|_| self.charts) {
            let ends = line.map(|p| view.pos(from_metres(p, shown)));
            ui.painter().line_segment(ends, Stroke::new(4.0, Color32::from_black_alpha(160)));
            ui.painter().line_segment(ends, Stroke::new(2.0, theme::CHOSEN));
        }
    }

    fn read_out(&self, ui: &Ui, view: &Viewport, screen: Rect, pointer: Option<Pos2>, shown: &Shown) {
        let mut parts = Vec::new();
        if let Some(pointer) = pointer {
            let at = to_metres(view.world(pointer), shown);
            let b = &shown.bounds;
            if (0..2).all(|k| (b.min[k]..=b.max[k]).contains(&at[k])) {
                parts.push(format!("x {:.0} m  y {:.0} m", at[0], at[1]));
                parts.extend(value_at(&shown.value, at));
            }
        }
        if shown.is_draft {
            parts.push("draft".to_owned());
        } else if let Some(cell) = shown.effective_cell {
            parts.push(format!("detail to {cell:.1} m"));
        }
        let text = parts.join("   ");
        let font = FontId::monospace(12.0);
        let galley = ui.painter().layout_no_wrap(text, font, Color32::WHITE);
        let at = Align2::LEFT_BOTTOM.anchor_size(screen.left_bottom() + vec2(10.0, -10.0), galley.size());
        ui.painter().rect_filled(at.expand(5.0), 4.0, Color32::from_black_alpha(150));
        ui.painter().galley(at.min, galley, Color32::WHITE);
    }

    /// Shows the profile along the drawn line and the histogram of all values.
    pub(crate) fn charts(&self, ui: &mut Ui, board: &Board) {
        let Some(Value::Field(field)) = board.shown.as_ref().map(|s| &s.value) else {
            ui.weak("Charts show fields.");
            return;
        };
        let Vec2 { x: width, y: height } = ui.available_size();
        ui.horizontal(|ui| {
            let size = vec2(0.6 * width - 8.0, height);
            match self.profile {
                Some(line) => {
                    chart::profile(ui, size, &along(field, line), length(line), field.quantity().unit())
                }
                None => chart::hint(ui, size, "Shift-drag over the map for a profile"),
            }
            chart::histogram(ui, vec2(0.4 * width - 8.0, height), field);
        });
    }
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    (x * x + y * y).sqrt()
}

/// The values of a field along a line.
fn along(field: &Field, [a, b]: [[f64; 2]; 2]) -> Vec<f32> {
    let steps = 400;
    let at = |k: i32| {
        let t = f64::from(k) / f64::from(steps);
        sample(field, [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t])
    };
    (0..=steps).map(at).collect()
}

/// The interpolated value of a field at a place; beyond the border, the value at the border.
pub(super) fn sample(field: &Field, at: [f64; 2]) -> f32 {
    let grid = field.grid();
    let [u, v] = grid.lattice.steps(at[0], at[1]);
    let split = |w: f64, first: i64, n: usize| {
        let w = (w - first as f64).clamp(0.0, (n - 1) as f64);
        let i = (w as usize).min(n.saturating_sub(2));
        (i, (w - i as f64) as f32, (i + 1).min(n - 1))
    };
    let (i, s, i1) = split(u, grid.col, grid.cols);
    let (j, t, j1) = split(v, grid.row, grid.rows);
    let (a, b) = (field.row(j), field.row(j1));
    let top = a[i] + (a[i1] - a[i]) * s;
    let bottom = b[i] + (b[i1] - b[i]) * s;
    top + (bottom - top) * t
}

/// The heights of a value, where it is an elevation.
fn elevation(value: &Value) -> Option<&Field> {
    match value {
        Value::Field(field) if field.quantity() == Quantity::Elevation => Some(field),
        _ => None,
    }
}

fn value_at(value: &Value, at: [f64; 2]) -> Option<String> {
    let unit = |u: &str| if u == "1" { String::new() } else { format!(" {u}") };
    match value {
        Value::Field(f) => {
            let digits = if f.quantity().unit() == "m" { 1 } else { 3 };
            Some(format!("{:.digits$}{}", sample(f, at), unit(f.quantity().unit())))
        }
        Value::Vectors(v) => {
            let [i, j] = v.grid().nearest(at);
            let [x, y] = v.row(j)[i];
            Some(format!("({x:.3}, {y:.3})"))
        }
        Value::Colors(c) => {
            let [i, j] = c.grid().nearest(at);
            let [r, g, b] = c.row(j)[i].map(|c| (c * 255.0).round() as u8);
            Some(format!("#{r:02x}{g:02x}{b:02x}"))
        }
        Value::Object(object) => object.say(at),
    }
}

/// The terrain in units of a thousandth of its longer side.
fn unit_rect(bounds: &Bounds) -> Rect {
    let scale = unit(bounds);
    Rect::from_min_size(
        pos2(0.0, 0.0),
        vec2((bounds.width() * scale) as f32, (bounds.depth() * scale) as f32),
    )
}

pub(super) fn unit(bounds: &Bounds) -> f64 {
    1000.0 / bounds.width().max(bounds.depth()).max(1e-9)
}

/// The area of a picture: half a cell beyond the outermost samples.
fn extent(shown: &Shown, terrain: &Bounds) -> Rect {
    let Some(grid) = shown.value.grid() else { return unit_rect(terrain) };
    let (b, half) = (grid.bounds(), 0.5 * grid.cell());
    let scale = unit(terrain);
    let at =
        |x: f64, y: f64| pos2(((x - terrain.min[0]) * scale) as f32, ((y - terrain.min[1]) * scale) as f32);
    Rect::from_min_max(at(b.min[0] - half, b.min[1] - half), at(b.max[0] + half, b.max[1] + half))
}

fn to_metres(at: Pos2, shown: &Shown) -> [f64; 2] {
    let bounds = &shown.bounds;
    let scale = unit(bounds);
    [bounds.min[0] + f64::from(at.x) / scale, bounds.min[1] + f64::from(at.y) / scale]
}

fn from_metres(at: [f64; 2], shown: &Shown) -> Pos2 {
    let bounds = &shown.bounds;
    let scale = unit(bounds);
    pos2(((at[0] - bounds.min[0]) * scale) as f32, ((at[1] - bounds.min[1]) * scale) as f32)
}
