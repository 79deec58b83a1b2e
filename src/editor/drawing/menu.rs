//! The menus of curves.

use eframe::egui::{Pos2, Response, Ui};

use super::curves::under;
use super::grip::Part;
use super::sheet::Sheet;
use super::{Drawing, DrawingContext, Space};
use crate::value::Curve;
use crate::value::curves::edit::Form;

/// The place on a curve for which a menu was opened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    curve: usize,
    u: f64,
}

impl Spot {
    pub(super) fn of(
        sheet: &Sheet,
        curves: &[Option<Curve>],
        number: Option<usize>,
        pos: Pos2,
        space: &dyn Space,
    ) -> Option<Self> {
        let curve = number.filter(|i| *i < sheet.len())?;
        Some(Self { curve, u: under(curves.get(curve)?.as_ref()?, pos, space) })
    }
}

impl Drawing {
    /// The menu of the ground, with commands for the curve that is under the pointer or chosen.
    pub(super) fn curve_menu(&mut self, ground: &Response, cx: &mut DrawingContext<'_>) {
        ground.context_menu(|ui| {
            let one = |ui: &mut Ui, text: &str| ui.button(text).clicked();
            // The next key acts on what is chosen here.
            self.receives_keys = true;
            if one(ui, "Draw a curve") {
                self.begin_curve();
                ui.close();
            }
            let Some(spot) = self.menu else { return };
            self.choose(Some(spot.curve));
            ui.separator();
            let name = self.sheet().map(|s| s.name(spot.curve)).unwrap_or_default();
            ui.weak(name);
            if one(ui, "Add control point here") {
                self.add_anchor(cx, spot.u);
            }
            if !matches!(self.sheet(), Some(Sheet::Curves(_))) {
                return;
            }
            if one(ui, "Add constraint point here") {
                self.add_point(cx, spot.u);
            }
            if one(ui, "Cut here") {
                self.cut(cx, spot.u);
            }
            if one(ui, "Turn round") {
                self.on_chosen(cx, "Turn curve round", |spec| {
                    *spec = spec.reversed();
                    Ok(())
                });
            }
            ui.separator();
            self.forms(ui, cx);
            ui.separator();
            if one(ui, "Delete curve") {
                self.remove_part(cx, Part::Body);
            }
        });
    }

    fn forms(&mut self, ui: &mut Ui, cx: &mut DrawingContext<'_>) {
        let now = self.curve.and_then(|i| Some(self.sheet()?.spec(i)?.form()));
        let forms = [
            (Form::Bezier, "Bend by handles"),
            (Form::Through, "Smooth through its points"),
            (Form::Line, "Straight from point to point"),
        ];
        for (form, text) in forms {
            if ui.selectable_label(now == Some(form), text).clicked() && now != Some(form) {
                self.on_chosen(cx, text, |spec| {
                    *spec = spec.in_form(form)?;
                    Ok(())
                });
                ui.close();
            }
        }
    }

    fn cut(&mut self, cx: &mut DrawingContext<'_>, u: f64) {
        let (Some(mut sheet), Some(number)) = (self.sheet().cloned(), self.curve) else { return };
        let Sheet::Curves(specs) = &mut sheet else { return };
        match specs.get(number).map(|s| s.split(u)) {
            Some(Ok(halves)) => {
                specs.splice(number..=number, halves);
                if self.write(cx, "Cut curve", None, &sheet) {
                    (self.point, self.anchor) = (None, None);
                }
            }
            Some(Err(fault)) => cx.notices.fail(format!("The curve {fault}")),
            None => (),
        }
    }

    /// The menu of a part.
    pub(super) fn grip_menu(&mut self, ui: &mut Ui, cx: &mut DrawingContext<'_>, part: Part) {
        self.receives_keys = true;
        let trail = matches!(self.sheet(), Some(Sheet::Trail(_)));
        let removed = match part {
            Part::Height(i) if trail => Some(Part::Anchor(i)),
            Part::Height(k) => Some(Part::Point(k)),
            Part::Anchor(_) | Part::Point(_) => Some(part),
            _ => None,
        };
        if let Some(part) = removed
            && ui.button(format!("Remove {}", super::curves::kind(part))).clicked()
        {
            self.remove_part(cx, part);
        }
        if !trail && ui.button("Delete curve").clicked() {
            self.remove_part(cx, Part::Body);
        }
    }
}
