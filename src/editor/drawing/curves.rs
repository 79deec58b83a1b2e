//! Curves under a hand: chosen, moved, changed by their grips.

use eframe::egui::{self, Id, PointerButton, Pos2, Response, Ui};

use super::grip::{Held, Part, Pull};
use super::menu::Spot;
use super::sheet::Sheet;
use super::{Drawing, Grab, Pad, Space, Tool, hold, paint};
use crate::kit::math::decade;
use crate::value::Curve;

/// Pixels within which a curve is hit.
const NEAR: f32 = 8.0;
/// Size of a grip, in pixels.
const GRIP: f32 = 15.0;

impl Drawing {
    pub(super) fn curving(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        pad: &mut Pad<'_>,
        step: f64,
    ) {
        let Some(known) = &self.known else { return };
        let down = ui.input(|i| i.pointer.any_down());
        // What is in the hand goes with the button, and with a document that others have changed.
        if !down || self.wrote.is_some_and(|state| state != pad.document.state()) {
            self.grab = None;
        }
        let lines: Vec<_> = known.curves.iter().map(|c| c.as_ref().map(|c| paint::line(c, space))).collect();
        let pointer = ui.input(|i| i.pointer.hover_pos()).filter(|_| ground.contains_pointer());
        let hit = pointer.and_then(|p| nearest(&lines, p));
        // A hand that passes over the curve while it turns the view goes on turning it.
        if !down {
            self.over = hit.is_some() && hit == self.curve && self.tool == Tool::Select;
        }
        paint::lines(ui, &lines, self.curve, hit.filter(|_| self.tool == Tool::Select));
        if let Some(spot) = ground.secondary_clicked().then_some(pointer).flatten() {
            self.menu = Spot::of(&known.sheet, &known.curves, hit.or(self.curve), spot, space);
        }
        self.grips(ui, space, pad);
        match self.tool {
            Tool::Draw => self.draw(ui, space, ground, pad, step),
            _ => self.on_ground(ui, space, ground, pad, hit),
        }
        if self.grab.is_some() && down {
            self.follow(ui, space, pad, step);
        }
        self.curve_menu(ground, pad);
    }

    /// Choosing a curve, taking it whole, new points by double-clicks.
    fn on_ground(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        pad: &mut Pad<'_>,
        hit: Option<usize>,
    ) {
        if ground.double_clicked() && hit.is_some() && hit == self.curve {
            if let (Some(at), Some(curve)) = (ground.interact_pointer_pos(), self.chosen_curve()) {
                let (u, shift) = (under(curve, at, space), ui.input(|i| i.modifiers.shift));
                if shift { self.add_point(pad, u) } else { self.add_anchor(pad, u) }
            }
        } else if ground.clicked() {
            self.choose(hit);
        }
        if ground.drag_started_by(PointerButton::Primary) && self.over && self.grab.is_none() {
            let press = ui.input(|i| i.pointer.press_origin());
            if let (Some(from), Some(curve)) = (press, self.chosen_curve()) {
                let u = under(curve, from, space);
                let at = curve.point(u);
                let z = curve.height(u).unwrap_or_else(|| space.height(at));
                self.take(pad, Part::Body, [at[0], at[1], z], from);
            }
        }
    }

    /// Chooses a curve; of another curve no part is chosen yet.
    pub(crate) fn choose(&mut self, curve: Option<usize>) {
        let stays = matches!(self.sheet(), Some(Sheet::Trail(_)));
        if curve != self.curve && !stays {
            (self.curve, self.point, self.anchor) = (curve, None, None);
        }
    }

    /// The chosen curve; none where it has a fault.
    pub(crate) fn chosen_curve(&self) -> Option<&Curve> {
        self.known.as_ref()?.curves.get(self.curve?)?.as_ref()
    }

    fn grips(&mut self, ui: &Ui, space: &dyn Space, pad: &mut Pad<'_>) {
        let (Some(known), Some(number)) = (&self.known, self.curve) else { return };
        let Some(curve) = self.chosen_curve().filter(|_| self.tool != Tool::Draw) else { return };
        let held = Held { sheet: &known.sheet, number, curve, point: self.point };
        let (grips, node) = (held.grips(space), known.node);
        let (mut taken, mut told) = (None, None);
        for grip in &grips {
            let Some(at) = space.screen(grip.at) else { continue };
            let pulled = self.grab.as_ref().filter(|g| g.part == grip.part && space.is_flat());
            let by = match (grip.part, pulled.zip(ui.input(|i| i.pointer.latest_pos()))) {
                // From above a height has no place of its own: its grip goes with the hand.
                (Part::Height(_), Some((grab, pointer))) => pointer.y - grab.from.y,
                _ => 0.0,
            };
            let at = at + egui::vec2(0.0, by - grip.lift);
            if !ui.clip_rect().contains(at) {
                continue;
            }
            let id = Id::new(("grip", node, number, grip.part));
            let response = hold(ui, at, GRIP, id, &grip.name);
            let hot = response.hovered() || response.dragged();
            paint::grip(ui, space, grip, at, hot, self.is_chosen(grip.part));
            if hot {
                told = Some((at, format!("{} {}", kind(grip.part), grip.value)));
            }
            let pulled = response.drag_started_by(PointerButton::Primary);
            if response.clicked() || response.secondary_clicked() || pulled {
                taken = Some((grip.part, grip.at, pulled));
            }
            response.context_menu(|ui| self.grip_menu(ui, pad, grip.part));
        }
        if let Some((part, at, pulled)) = taken {
            self.pick(part);
            if let Some(from) = ui.input(|i| i.pointer.press_origin()).filter(|_| pulled) {
                self.take(pad, part, at, from);
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

    /// Takes a part into the hand.
    fn take(&mut self, pad: &Pad<'_>, part: Part, at: [f64; 3], from: Pos2) {
        let (Some(curve), Some(sheet)) = (self.chosen_curve().cloned(), self.sheet().cloned()) else {
            return;
        };
        self.grab = Some(Grab { part, sheet, curve, at, from });
        self.wrote = Some(pad.document.state());
    }

    /// Moves the part in the hand to where the pointer is.
    fn follow(&mut self, ui: &Ui, space: &dyn Space, pad: &mut Pad<'_>, step: f64) {
        let (Some(grab), Some(number)) = (&self.grab, self.curve) else { return };
        let Some(pointer) = ui.input(|i| i.pointer.latest_pos()).filter(|p| *p != grab.from) else { return };
        let z = grab.at[2];
        let (Some(from), Some(to)) = (space.level(grab.from, z), space.level(pointer, z)) else { return };
        let by = [to[0] - from[0], to[1] - from[1]];
        let to = if grab.part == Part::Body { by } else { [grab.at[0] + by[0], grab.at[1] + by[1]] };
        let pixel = space.rise(grab.at);
        let rise = f64::from(grab.from.y - pointer.y) * pixel;
        // No finer than a hand can tell.
        let step = if matches!(grab.part, Part::Height(_)) { step.max(decade(pixel)) } else { step };
        let from = [grab.at[0], grab.at[1]];
        let pull = Pull { from, to, rise, paired: !ui.input(|i| i.modifiers.alt), step };
        let held = Held { sheet: &grab.sheet, number, curve: &grab.curve, point: self.point };
        let sheet = held.pulled(grab.part, &pull);
        let label = format!("Move {}", kind(grab.part));
        self.write(pad, &label, Some(&format!("{:?} {number}", grab.part)), &sheet);
        self.wrote = Some(pad.document.state());
    }
}

/// The share of a curve's length that is under the pointer.
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

/// The line that is nearest to the pointer, if one is near.
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
