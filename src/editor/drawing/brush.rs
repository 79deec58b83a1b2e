//! The brush: strokes painted onto the terrain.

use eframe::egui::{Color32, Key, PointerButton, Pos2, Response, Stroke as Line, Ui};

use super::grip::rounded;
use super::sheet::Sheet;
use super::{Drawing, DrawingContext, Space, Tool, Trace, pressed};
use crate::graph::{Graph, Source};
use crate::kit::math::decade;
use crate::kit::paint::{Stroke, thinned};
use crate::units::{Metres, Ratio};
use crate::value::curves::bezier::{norm, sub};

/// The deviation that thinning a stroke may cause, as a share of the radius.
const LOOSE: f64 = 0.04;
/// Corners of the ring that shows the brush.
const RING: u32 = 48;

impl Drawing {
    pub(super) fn brushing(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        cx: &mut DrawingContext<'_>,
        step: f64,
    ) {
        if self.tool != Tool::Brush {
            return;
        }
        if pressed(ui, &[Key::Escape]) {
            self.end_tool();
            return;
        }
        self.resize(ui);
        let here =
            ui.input(|i| i.pointer.hover_pos()).filter(|_| ground.contains_pointer() || self.trace.is_some());
        let here = here.and_then(|p| space.ground(p));
        if let Some(at) = here {
            ring(ui, space, at, self.brush.radius.0, self.erases(ui));
        }
        if ground.drag_started_by(PointerButton::Primary) || ground.clicked() {
            let press = ui.input(|i| i.pointer.press_origin()).or_else(|| ground.interact_pointer_pos());
            let from = press.and_then(|p| space.ground(p));
            let sheet = self.sheet().cloned();
            self.trace = from.zip(sheet).map(|(p, sheet)| Trace { sheet, points: vec![p], written: 0 });
        }
        self.trail_hand(ui, here, cx, step);
        if !ui.input(|i| i.pointer.primary_down()) {
            self.trace = None;
        }
    }

    fn erases(&self, ui: &Ui) -> bool {
        (self.brush.value.0 < 0.5) != ui.input(|i| i.modifiers.alt)
    }

    /// Adds the place under the pointer to the stroke and writes the stroke to the document.
    fn trail_hand(&mut self, ui: &Ui, here: Option<[f64; 2]>, cx: &mut DrawingContext<'_>, step: f64) {
        let erases = self.erases(ui);
        let Some(trace) = &mut self.trace else { return };
        let radius = self.brush.radius.0;
        if let (Some(p), Some(last)) = (here, trace.points.last())
            && norm(sub(p, *last)) > 0.05 * radius
        {
            trace.points.push(p);
        }
        if trace.written == trace.points.len() {
            return;
        }
        trace.written = trace.points.len();
        let own = self.brush.value.0;
        let value = if erases == (own < 0.5) { own } else { 1.0 - own };
        let path = thinned(&trace.points, LOOSE * radius);
        let path = path.iter().flat_map(|p| p.map(|x| rounded(x, step))).collect();
        let stroke = Stroke { path, value: Ratio(value), ..self.brush.clone() };
        let Sheet::Strokes(mut strokes) = trace.sheet.clone() else { return };
        strokes.push(stroke);
        let label = if erases { "Erase" } else { "Paint" };
        // The name of the gesture has the number of the stroke, so that each stroke is undone by itself.
        let gesture = format!("stroke {}", strokes.len());
        self.write(cx, label, Some(&gesture), &Sheet::Strokes(strokes));
    }

    /// Makes the brush smaller with `[` and larger with `]`.
    fn resize(&mut self, ui: &Ui) {
        let factor = match (pressed(ui, &[Key::OpenBracket]), pressed(ui, &[Key::CloseBracket])) {
            (true, _) => 0.8,
            (_, true) => 1.25,
            _ => return,
        };
        let radius = (self.brush.radius.0 * factor).clamp(0.01, 1e6);
        // The radius is rounded to two digits.
        let unit = 0.1 * decade(radius);
        self.brush.radius = Metres((radius / unit).round() * unit);
    }

    /// The mask that is being painted.
    pub(crate) fn painted(&self, graph: &Graph) -> Option<Source> {
        let node = self.parsed.as_ref()?.node;
        let is_mask = self.tool == Tool::Brush && matches!(self.sheet()?, Sheet::Strokes(_));
        let port = graph.get(node)?.kind()?.outputs.first()?;
        is_mask.then(|| Source { node, port: port.name.clone() })
    }

    /// Removes all strokes.
    pub(crate) fn clear(&mut self, cx: &mut DrawingContext<'_>) {
        self.read(cx);
        self.write(cx, "Clear painting", None, &Sheet::Strokes(Vec::new()));
    }
}

/// Paints the circle of the brush around a place.
fn ring(ui: &Ui, space: &dyn Space, at: [f64; 2], radius: f64, erases: bool) {
    let corner = |k: u32| {
        let a = f64::from(k) / f64::from(RING) * std::f64::consts::TAU;
        let p = [at[0] + radius * libm::cos(a), at[1] + radius * libm::sin(a)];
        space.screen([p[0], p[1], space.height(p)])
    };
    let line: Vec<Pos2> = (0..=RING).filter_map(corner).collect();
    let color = if erases { Color32::from_rgb(255, 150, 110) } else { Color32::WHITE };
    ui.painter().line(line.clone(), Line::new(3.0, Color32::from_black_alpha(150)));
    ui.painter().line(line, Line::new(1.5, color));
}
