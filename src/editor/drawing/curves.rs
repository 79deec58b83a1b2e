//! Input on curves: choosing, moving, changing them by their grips.

use eframe::egui::{self, Id, PointerButton, Pos2, Response, Ui};

use super::grip::{EditedCurve, Part, Pull};
use super::menu::Spot;
use super::sheet::Sheet;
use super::{Drawing, DrawingContext, Grab, Space, Tool, grip_area, paint};
use crate::kit::math::decade;
use crate::value::Curve;

/// Distance within which the pointer is on a curve, in pixels.
const NEAR: f32 = 8.0;
/// Size of a grip, in pixels.
const GRIP: f32 = 15.0;

impl Drawing {
    pub(super) fn curving(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        cx: &mut DrawingContext<'_>,
        step: f64,
    ) {
        let Some(parsed) = &self.parsed else { return };
        let down = ui.input(|i| i.pointer.any_down());
        // A drag ends when the button is released, and when something else has changed the document.
        if !down || self.written_state.is_some_and(|state| state != cx.document.state()) {
            self.grab = None;
        }
        let lines: Vec<_> = parsed.curves.iter().map(|c| c.as_ref().map(|c| paint::line(c, space))).collect();
        let pointer = ui.input(|i| i.pointer.hover_pos()).filter(|_| ground.contains_pointer());
        let hit = pointer.and_then(|p| nearest(&lines, p));
        // The hover state is kept while a button is down, so that turning the view goes on when the pointer crosses the
        // curve.
        if !down {
            self.is_hovered = hit.is_some() && hit == self.curve && self.tool == Tool::Select;
        }
        paint::lines(ui, &lines, self.curve, hit.filter(|_| self.tool == Tool::Select));
        if let Some(spot) = ground.secondary_clicked().then_some(pointer).flatten() {
            self.menu = Spot::of(&parsed.sheet, &parsed.curves, hit.or(self.curve), spot, space);
        }
        self.grips(ui, space, cx);
        match self.tool {
            Tool::Draw => self.draw(ui, space, ground, cx, step),
            _ => self.on_ground(ui, space, ground, cx, hit),
        }
        if self.grab.is_some() && down {
            self.follow(ui, space, cx, step);
        }
        self.curve_menu(ground, cx);
    }

    /// Handles input on the ground and on curves: choosing one, dragging it whole, adding points by double-clicks.
    fn on_ground(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        cx: &mut DrawingContext<'_>,
        hit: Option<usize>,
    ) {
        if ground.double_clicked() && hit.is_some() && hit == self.curve {
            if let (Some(at), Some(curve)) = (ground.interact_pointer_pos(), self.chosen_curve()) {
                let (u, shift) = (under(curve, at, space), ui.input(|i| i.modifiers.shift));
                if shift { self.add_point(cx, u) } else { self.add_anchor(cx, u) }
            }
        } else if ground.clicked() {
            self.choose(hit);
        }
        if ground.drag_started_by(PointerButton::Primary) && self.is_hovered && self.grab.is_none() {
            let press = ui.input(|i| i.pointer.press_origin());
            if let (Some(from), Some(curve)) = (press, self.chosen_curve()) {
                let u = under(curve, from, space);
                let at = curve.point(u);
                let z = curve.height(u).unwrap_or_else(|| space.height(at));
                self.take(cx, Part::Body, [at[0], at[1], z], from);
            }
        }
    }

    /// Chooses a curve; where this is another one than before, none of its parts is chosen.
    pub(crate) fn choose(&mut self, curve: Option<usize>) {
        let stays = matches!(self.sheet(), Some(Sheet::Trail(_)));
        if curve != self.curve && !stays {
            (self.curve, self.point, self.anchor) = (curve, None, None);
        }
    }

    /// The chosen curve; `None` where it has a fault.
    pub(crate) fn chosen_curve(&self) -> Option<&Curve> {
        self.parsed.as_ref()?.curves.get(self.curve?)?.as_ref()
    }

    fn grips(&mut self, ui: &Ui, space: &dyn Space, cx: &mut DrawingContext<'_>) {
        let (Some(parsed), Some(number)) = (&self.parsed, self.curve) else { return };
        let Some(curve) = self.chosen_curve().filter(|_| self.tool != Tool::Draw) else { return };
        let edited = EditedCurve { sheet: &parsed.sheet, number, curve, point: self.point };
        let (grips, node) = (edited.grips(space), parsed.node);
        let (mut taken, mut told) = (None, None);
        for grip in &grips {
            let Some(at) = space.screen(grip.at) else { continue };
            let pulled = self.grab.as_ref().filter(|g| g.part == grip.part && space.is_flat());
            let by = match (grip.part, pulled.zip(ui.input(|i| i.pointer.latest_pos()))) {
                // Seen from above, a height does not move its point, so that its grip follows the pointer.
                (Part::Height(_), Some((grab, pointer))) => pointer.y - grab.from.y,
                _ => 0.0,
            };
            let at = at + egui::vec2(0.0, by - grip.lift);
            if !ui.clip_rect().contains(at) {
                continue;
            }
            let id = Id::new(("grip", node, number, grip.part));
            let response = grip_area(ui, at, GRIP, id, &grip.name);
            let hot = response.hovered() || response.dragged();
            paint::grip(ui, space, grip, at, hot, self.is_chosen(grip.part));
            if hot {
                told = Some((at, format!("{} {}", kind(grip.part), grip.value)));
            }
            let pulled = response.drag_started_by(PointerButton::Primary);
            if response.clicked() || response.secondary_clicked() || pulled {
                taken = Some((grip.part, grip.at, pulled));
            }
            response.context_menu(|ui| self.grip_menu(ui, cx, grip.part));
        }
        if let Some((part, at, pulled)) = taken {
            self.pick(part);
            if let Some(from) = ui.input(|i| i.pointer.press_origin()).filter(|_| pulled) {
                self.take(cx, part, at, from);
            }
        }
        if let Some((at, text)) = told {
            paint::tell(ui, at, &text);
        }
    }

    /// Chooses a part.
    fn pick(&mut self, part: Part) {
        match part {
            Part::Anchor(i) => (self.anchor, self.point) = (Some(i), None),
            Part::Point(k) | Part::Height(k) => (self.anchor, self.point) = (None, Some(k)),
            _ => (),
        }
    }

    fn is_chosen(&self, part: Part) -> bool {
        match part {
            Part::Anchor(i) => self.anchor == Some(i),
            Part::Point(k) => self.point == Some(k),
            _ => false,
        }
    }

    /// Starts to drag a part.
    fn take(&mut self, cx: &DrawingContext<'_>, part: Part, at: [f64; 3], from: Pos2) {
        let (Some(curve), Some(sheet)) = (self.chosen_curve().cloned(), self.sheet().cloned()) else {
            return;
        };
        self.grab = Some(Grab { part, sheet, curve, at, from });
        self.written_state = Some(cx.document.state());
    }

    /// Moves the dragged part to the pointer.
    fn follow(&mut self, ui: &Ui, space: &dyn Space, cx: &mut DrawingContext<'_>, step: f64) {
        let (Some(grab), Some(number)) = (&self.grab, self.curve) else { return };
        let Some(pointer) = ui.input(|i| i.pointer.latest_pos()).filter(|p| *p != grab.from) else { return };
        let z = grab.at[2];
        let (Some(from), Some(to)) = (space.level(grab.from, z), space.level(pointer, z)) else { return };
        let by = [to[0] - from[0], to[1] - from[1]];
        let to = if grab.part == Part::Body { by } else { [grab.at[0] + by[0], grab.at[1] + by[1]] };
        let pixel = space.rise(grab.at);
        let rise = f64::from(grab.from.y - pointer.y) * pixel;
        // Heights are rounded no finer than a pixel.
        let step = if matches!(grab.part, Part::Height(_)) { step.max(decade(pixel)) } else { step };
        let from = [grab.at[0], grab.at[1]];
        let pull = Pull { from, to, rise, paired: !ui.input(|i| i.modifiers.alt), step };
        let edited = EditedCurve { sheet: &grab.sheet, number, curve: &grab.curve, point: self.point };
        let sheet = edited.pulled(grab.part, &pull);
        let label = format!("Move {}", kind(grab.part));
        self.write(cx, &label, Some(&format!("{:?} {number}", grab.part)), &sheet);
        self.written_state = Some(cx.document.state());
    }
}

/// The share of a curve's length that is nearest to a point of the screen.
pub(super) fn under(curve: &Curve, pos: Pos2, space: &dyn Space) -> f64 {
    let far = |u: f64| {
        let at = curve.point(u);
        let z = curve.height(u).unwrap_or_else(|| space.height(at));
        space.screen([at[0], at[1], z]).map_or(f32::MAX, |p| p.distance(pos))
    };
    let nearest =
        |us: &mut dyn Iterator<Item = f64>| us.min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(0.0);
    let coarse = nearest(&mut (0..=400).map(|k| f64::from(k) / 400.0));
    let around = (-20..=20).map(|k| (coarse + f64::from(k) / 8000.0).clamp(0.0, 1.0));
    nearest(&mut around.into_iter())
}

/// The index of the line at a point of the screen, if there is one.
fn nearest(lines: &[Option<paint::Line>], pos: Pos2) -> Option<usize> {
    let far = |line: &paint::Line| {
        let seen = line.windows(2).filter(|w| w[0].seen && w[1].seen);
        seen.map(|w| from_segment(pos, w[0].at, w[1].at)).fold(f32::MAX, f32::min)
    };
    let all = lines.iter().enumerate().filter_map(|(i, line)| Some((i, far(line.as_ref()?))));
    all.filter(|(_, d)| *d < NEAR).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

fn from_segment(p: Pos2, a: Pos2, b: Pos2) -> f32 {
    let along = b - a;
    let t =
        if along.length_sq() > 0.0 { ((p - a).dot(along) / along.length_sq()).clamp(0.0, 1.0) } else { 0.0 };
    (a + along * t).distance(p)
}

pub(super) fn kind(part: Part) -> &'static str {
    match part {
        Part::Anchor(_) => "control point",
        Part::Handle(_) => "handle",
        Part::Point(_) => "constraint point",
        Part::Height(_) => "height",
        Part::Plateau(_) => "plateau",
        Part::Extent(..) => "extent",
        Part::Angle(..) => "angle",
        Part::Body => "curve",
    }
}
