//! Curves under a hand: chosen, moved, drawn, changed by their grips.

use eframe::egui::{self, Id, Key, PointerButton, Pos2, Response, Ui};

use super::grip::{Grip, Held, Part, Pull, rounded};
use super::menu::Spot;
use super::sheet::Sheet;
use super::{Drawing, Grab, Pad, Space, Tool, Trace, ended, hold, paint};
use crate::kit::paint::thinned;
use crate::value::curves::Fault;
use crate::value::{Curve, CurveSpec};

/// Pixels within which a curve is hit.
const NEAR: f32 = 8.0;
/// Pixels that a freely drawn line may be off its points.
const LOOSE: f64 = 3.0;
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
        let lines: Vec<_> = known.curves.iter().map(|c| c.as_ref().map(|c| paint::line(c, space))).collect();
        let pointer = ui.input(|i| i.pointer.hover_pos()).filter(|_| ground.contains_pointer());
        let hit = pointer.and_then(|p| nearest(&lines, p));
        self.over = hit.is_some() && hit == self.curve && self.tool == Tool::Select;
        paint::lines(ui, &lines, self.curve, hit.filter(|_| self.tool == Tool::Select));
        if let Some(spot) = ground.secondary_clicked().then_some(pointer).flatten() {
            self.menu = Spot::of(&known.sheet, &known.curves, hit.or(self.curve), spot, space);
        }
        self.grips(ui, space, pad, step);
        match self.tool {
            Tool::Draw => self.draw(ui, space, ground, pad, step),
            _ => self.on_ground(ui, space, ground, pad, hit, step),
        }
        self.curve_menu(ground, pad);
    }

    /// Choosing a curve, moving it whole, new points by double-clicks.
    fn on_ground(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        pad: &mut Pad<'_>,
        hit: Option<usize>,
        step: f64,
    ) {
        let pointer = ground.interact_pointer_pos();
        if ground.double_clicked() && hit.is_some() && hit == self.curve {
            if let (Some(at), Some(curve)) = (pointer, self.chosen_curve()) {
                let (u, shift) = (under(&curve, at, space), ui.input(|i| i.modifiers.shift));
                if shift { self.add_point(pad, u) } else { self.add_anchor(pad, u) }
            }
        } else if ground.clicked() {
            self.choose(hit);
        }
        if ground.drag_started_by(PointerButton::Primary) && self.over && self.grab.is_none() {
            let press = ui.input(|i| i.pointer.press_origin());
            if let (Some(from), Some(curve)) = (press, self.chosen_curve()) {
                let at = curve.point(under(&curve, from, space));
                let z = curve.height(0.5).unwrap_or_else(|| space.height(at));
                self.take(Part::Body, [at[0], at[1], z], from);
            }
        }
        if matches!(&self.grab, Some(Grab { part: Part::Body, .. })) {
            self.follow(ui, space, pad, step);
            if !ui.input(|i| i.pointer.any_down()) {
                self.grab = None;
            }
        }
    }

    /// Chooses a curve; of another curve no part is chosen yet.
    pub(crate) fn choose(&mut self, curve: Option<usize>) {
        let stays = self.known.as_ref().is_some_and(|k| matches!(k.sheet, Sheet::Trail(_)));
        if curve != self.curve && !stays {
            (self.curve, self.point, self.anchor) = (curve, None, None);
        }
    }

    fn chosen_curve(&self) -> Option<Curve> {
        self.known.as_ref()?.curves.get(self.curve?)?.clone()
    }

    fn grips(&mut self, ui: &Ui, space: &dyn Space, pad: &mut Pad<'_>, step: f64) {
        let (Some(known), Some(number)) = (&self.known, self.curve) else { return };
        let Some(curve) = known.curves.get(number).and_then(Option::as_ref) else { return };
        let held = Held { sheet: &known.sheet, number, curve, point: self.point };
        let (grips, node) = (held.grips(space), known.node);
        let drawing = self.tool == Tool::Draw;
        let mut taken = None;
        let mut told = None;
        for grip in &grips {
            let Some(at) = space.screen(grip.at) else { continue };
            let at = at - egui::vec2(0.0, grip.lift);
            if !ui.clip_rect().contains(at) || drawing {
                continue;
            }
            let id = Id::new(("grip", node.index(), number, grip.part));
            let response = hold(ui, at, GRIP, id, &grip.name);
            paint::grip(
                ui,
                space,
                grip,
                at,
                response.hovered() || response.dragged(),
                self.is_chosen(grip.part),
            );
            if response.hovered() || response.dragged() {
                told = Some((at, format!("{} {}", kind_of(grip), grip.value)));
            }
            if response.clicked() || response.drag_started_by(PointerButton::Primary) {
                taken = Some((grip.part, grip.at, response.dragged()));
            }
            if response.secondary_clicked() {
                taken = Some((grip.part, grip.at, false));
                self.menu = None;
            }
            response.context_menu(|ui| self.grip_menu(ui, pad, grip.part));
        }
        if let Some((part, at, dragged)) = taken {
            self.pick(part);
            if let Some(from) = ui.input(|i| i.pointer.press_origin()).filter(|_| dragged) {
                self.take(part, at, from);
            }
        }
        if let Some((at, text)) = told {
            paint::tell(ui, at, &text);
        }
        if matches!(&self.grab, Some(g) if g.part != Part::Body) {
            self.follow(ui, space, pad, step);
            if !ui.input(|i| i.pointer.any_down()) {
                self.grab = None;
            }
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
    fn take(&mut self, part: Part, at: [f64; 3], from: Pos2) {
        let Some(curve) = self.chosen_curve() else { return };
        let Some(sheet) = self.sheet().cloned() else { return };
        self.grab = Some(Grab { part, sheet, curve, at, from });
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
        let step = if matches!(grab.part, Part::Height(_)) { step.max(power_of_ten(pixel)) } else { step };
        let from = [grab.at[0], grab.at[1]];
        let pull = Pull { from, to, rise, paired: !ui.input(|i| i.modifiers.alt), step };
        let held = Held { sheet: &grab.sheet, number, curve: &grab.curve, point: self.point };
        let sheet = held.pulled(grab.part, &pull);
        let label = format!("Move {}", kind(grab.part));
        self.write(pad, &label, Some(&format!("{:?} {number}", grab.part)), &sheet);
    }

    /// New curves: a click for each point, or a line with the button down.
    fn draw(&mut self, ui: &Ui, space: &dyn Space, ground: &Response, pad: &mut Pad<'_>, step: f64) {
        if ended(ui, &[Key::Enter, Key::Escape]) {
            self.rest();
            return;
        }
        let place = |pos: Pos2| space.ground(pos).map(|p| p.map(|x| rounded(x, step)));
        let here = ui.input(|i| i.pointer.hover_pos()).and_then(place);
        if ground.drag_started_by(PointerButton::Primary) {
            let from = ui.input(|i| i.pointer.press_origin()).and_then(place);
            let sheet = self.sheet().cloned();
            self.trace = from.zip(sheet).map(|(p, sheet)| Trace { sheet, points: vec![p] });
        }
        if let (Some(trace), Some(p)) = (&mut self.trace, here) {
            if trace.points.last() != Some(&p) {
                trace.points.push(p);
            }
            paint::path(ui, space, &trace.points);
        }
        if ground.drag_stopped()
            && let Some(trace) = self.trace.take()
        {
            let height = |p: &[f64; 2]| [p[0], p[1], space.height(*p)];
            let loose = trace.points.first().map_or(1.0, |p| space.across(height(p))) * LOOSE;
            let points = thinned(&trace.points, loose);
            if points.len() > 1 {
                self.add_curve(pad, &points, space);
                self.start = None;
            }
            return;
        }
        if ground.double_clicked() {
            self.rest();
        } else if let Some(p) = ground.interact_pointer_pos().filter(|_| ground.clicked()).and_then(place) {
            self.click(pad, p, space);
        }
        let end = self.start.or_else(|| self.anchor.and_then(|_| self.last_anchor()));
        if let (Some(from), Some(to)) = (end, here) {
            paint::path(ui, space, &[from, to]);
        }
    }

    /// A click of the tool that draws: the first begins, the second makes the curve, others go on.
    fn click(&mut self, pad: &mut Pad<'_>, p: [f64; 2], space: &dyn Space) {
        match (self.start.take(), self.anchor, self.curve) {
            (Some(start), _, _) if start != p => self.add_curve(pad, &[start, p], space),
            (None, Some(_), Some(i)) => {
                let Some(mut sheet) = self.sheet().cloned() else { return };
                match &mut sheet {
                    Sheet::Curves(specs) => {
                        let Some(spec) = specs.get_mut(i) else { return };
                        if let Err(fault) = spec.extend(p) {
                            pad.notices.fail(format!("The curve {fault}"));
                            return;
                        }
                        self.anchor = spec.anchors().len().checked_sub(1);
                    }
                    Sheet::Trail(points) => {
                        points.push(trail_point(points, p, space));
                        self.anchor = points.len().checked_sub(1);
                    }
                    Sheet::Strokes(_) => return,
                }
                self.write(pad, "Add control point", None, &sheet);
            }
            (_, _, _) if matches!(self.sheet(), Some(Sheet::Trail(_))) => {
                self.anchor = Some(0);
                self.click(pad, p, space);
            }
            _ => self.start = Some(p),
        }
    }

    fn last_anchor(&self) -> Option<[f64; 2]> {
        let i = self.curve?;
        match self.sheet()? {
            Sheet::Curves(specs) => specs.get(i)?.anchors().last().copied(),
            Sheet::Trail(points) => points.last().map(|p| [p[0], p[1]]),
            Sheet::Strokes(_) => None,
        }
    }

    /// A new curve at the heights of the ground it is drawn on; of a node that has one curve, its new course.
    fn add_curve(&mut self, pad: &mut Pad<'_>, points: &[[f64; 2]], space: &dyn Space) {
        let Some(mut sheet) = self.sheet().cloned() else { return };
        match &mut sheet {
            Sheet::Curves(specs) => {
                let (first, last) = (points[0], points[points.len() - 1]);
                let [from, to] = [first, last].map(|p| space.height(p).round());
                specs.push(CurveSpec {
                    through: points.iter().flatten().copied().collect(),
                    height: vec![0.0, from, 0.0, 1.0, to, 0.0],
                    ..CurveSpec::default()
                });
                self.curve = Some(specs.len() - 1);
            }
            Sheet::Trail(old) => *old = points.iter().map(|p| trail_point(old, *p, space)).collect(),
            Sheet::Strokes(_) => return,
        }
        (self.point, self.anchor) = (None, Some(points.len() - 1));
        self.write(pad, "Draw curve", None, &sheet);
    }

    /// Begins to draw.
    pub(crate) fn begin(&mut self) {
        self.tool = Tool::Draw;
        (self.start, self.anchor) = (None, None);
    }

    /// Deletes the chosen curve.
    pub(crate) fn remove_curve(&mut self, pad: &mut Pad<'_>) {
        self.remove_part(pad, Part::Body);
    }

    /// Removes a constraint point of the chosen curve.
    pub(crate) fn remove_point(&mut self, pad: &mut Pad<'_>, k: usize) {
        self.remove_part(pad, Part::Point(k));
    }

    /// Changes the chosen curve as a gesture of a name.
    pub(crate) fn change(
        &mut self,
        pad: &mut Pad<'_>,
        label: &str,
        gesture: &str,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) {
        let Some(number) = self.curve else { return };
        let gesture = format!("{gesture} of curve {number}");
        self.changed(pad, label, Some(&gesture), change);
    }

    /// Changes the chosen curve at once.
    pub(super) fn on_chosen(
        &mut self,
        pad: &mut Pad<'_>,
        label: &str,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) {
        self.changed(pad, label, None, change);
    }

    fn changed(
        &mut self,
        pad: &mut Pad<'_>,
        label: &str,
        gesture: Option<&str>,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) {
        let Some(mut sheet) = self.sheet().cloned() else { return };
        let Sheet::Curves(specs) = &mut sheet else { return };
        let Some(spec) = self.curve.and_then(|i| specs.get_mut(i)) else { return };
        match change(spec) {
            Ok(()) => self.write(pad, label, gesture, &sheet),
            Err(fault) => pad.notices.fail(format!("The curve {fault}")),
        }
    }

    pub(super) fn add_anchor(&mut self, pad: &mut Pad<'_>, u: f64) {
        let mut at = None;
        if let (Some(Sheet::Trail(points)), Some(curve)) = (self.sheet(), self.chosen_curve()) {
            let mut points = points.clone();
            let (piece, _) = curve.place(u);
            let p = curve.point(u).map(|x| rounded(x, 0.1));
            let z = curve.height(u).map(|z| rounded(z, 0.1));
            let new = p.into_iter().chain(z).collect();
            points.insert((piece + 1).min(points.len()), new);
            (self.anchor, self.point) = (Some(piece + 1), None);
            self.write(pad, "Add control point", None, &Sheet::Trail(points));
            return;
        }
        self.on_chosen(pad, "Add control point", |spec| {
            at = Some(spec.insert_anchor(u)?);
            Ok(())
        });
        if at.is_some() {
            (self.anchor, self.point) = (at, None);
        }
    }

    pub(crate) fn add_point(&mut self, pad: &mut Pad<'_>, u: f64) {
        let mut at = None;
        self.on_chosen(pad, "Add constraint point", |spec| {
            at = Some(spec.insert_point(u)?);
            Ok(())
        });
        if at.is_some() {
            (self.anchor, self.point) = (None, at);
        }
    }

    /// Removes the chosen part, or the whole curve where none is chosen.
    pub(super) fn remove_chosen(&mut self, pad: &mut Pad<'_>) -> bool {
        match (self.curve, self.anchor, self.point) {
            (Some(_), Some(i), _) => self.remove_part(pad, Part::Anchor(i)),
            (Some(_), None, Some(k)) => self.remove_part(pad, Part::Point(k)),
            (Some(_), None, None) => self.remove_part(pad, Part::Body),
            (None, _, _) => return false,
        }
        true
    }

    pub(super) fn remove_part(&mut self, pad: &mut Pad<'_>, part: Part) {
        let (Some(mut sheet), Some(number)) = (self.sheet().cloned(), self.curve) else { return };
        if let Sheet::Trail(points) = &mut sheet {
            if let Part::Anchor(i) | Part::Height(i) = part
                && points.len() > 2
                && i < points.len()
            {
                points.remove(i);
                self.anchor = None;
                self.write(pad, "Remove control point", None, &sheet);
            }
            return;
        }
        match part {
            Part::Anchor(i) => {
                self.on_chosen(pad, "Remove control point", |spec| spec.remove_anchor(i));
                self.anchor = None;
            }
            Part::Point(k) | Part::Height(k) => {
                let Some(curve) = self.chosen_curve() else { return };
                let mut points = curve.points();
                if points.len() < 2 || k >= points.len() {
                    pad.notices.fail("A curve keeps one constraint point: without any it says nothing");
                    return;
                }
                points.remove(k);
                self.on_chosen(pad, "Remove constraint point", |spec| {
                    spec.set_points(&points);
                    Ok(())
                });
                self.point = None;
            }
            Part::Body => {
                if let Sheet::Curves(specs) = &mut sheet
                    && number < specs.len()
                {
                    specs.remove(number);
                    (self.curve, self.point, self.anchor) = (None, None, None);
                    self.write(pad, "Delete curve", None, &sheet);
                }
            }
            _ => (),
        }
    }
}

/// A point of a line whose kind has heights or has none, as the points before it.
fn trail_point(points: &[Vec<f64>], p: [f64; 2], space: &dyn Space) -> Vec<f64> {
    let has_height = points.first().is_none_or(|q| q.len() > 2);
    p.into_iter().chain(has_height.then(|| space.height(p).round())).collect()
}

/// The power of ten that is not over a number.
fn power_of_ten(x: f64) -> f64 {
    libm::pow(10.0, libm::floor(libm::log10(x.max(1e-6))))
}

/// The share of a curve's length that is under the pointer.
pub(super) fn under(curve: &Curve, pos: Pos2, space: &dyn Space) -> f64 {
    let far = |u: f64| {
        let at = curve.point(u);
        let z = curve.height(u).unwrap_or_else(|| space.height(at));
        space.screen([at[0], at[1], z]).map_or(f32::MAX, |p| p.distance(pos))
    };
    let at = |k: i32| f64::from(k) / 400.0;
    (0..=400).map(at).min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(0.0)
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

fn kind_of(grip: &Grip) -> &'static str {
    kind(grip.part)
}
