//! Changes of the chosen curve: adding and removing points, setting values.

use super::grip::{Part, rounded};
use super::sheet::Sheet;
use super::{Drawing, DrawingContext};
use crate::value::CurveSpec;
use crate::value::curves::Fault;

impl Drawing {
    /// Changes the chosen curve as part of the gesture with this name.
    pub(crate) fn change(
        &mut self,
        cx: &mut DrawingContext<'_>,
        label: &str,
        gesture: &str,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) {
        let Some(number) = self.curve else { return };
        let gesture = format!("{gesture} of curve {number}");
        self.changed(cx, label, Some(&gesture), change);
    }

    /// Changes the chosen curve in one step; returns whether the change was accepted.
    pub(super) fn on_chosen(
        &mut self,
        cx: &mut DrawingContext<'_>,
        label: &str,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) -> bool {
        self.changed(cx, label, None, change)
    }

    fn changed(
        &mut self,
        cx: &mut DrawingContext<'_>,
        label: &str,
        gesture: Option<&str>,
        change: impl FnOnce(&mut CurveSpec) -> Result<(), Fault>,
    ) -> bool {
        let Some(mut sheet) = self.sheet().cloned() else { return false };
        let Sheet::Curves(specs) = &mut sheet else { return false };
        let Some(spec) = self.curve.and_then(|i| specs.get_mut(i)) else { return false };
        match change(spec).and_then(|()| spec.build().map(drop)) {
            Ok(()) => self.write(cx, label, gesture, &sheet),
            Err(fault) => {
                cx.notices.fail(format!("The curve {fault}"));
                false
            }
        }
    }

    pub(super) fn add_anchor(&mut self, cx: &mut DrawingContext<'_>, u: f64) {
        let mut at = None;
        let done = match self.sheet() {
            Some(Sheet::Trail(points)) => {
                let mut points = points.clone();
                at = self.add_to_trail(&mut points, u);
                at.is_some() && self.write(cx, "Add control point", None, &Sheet::Trail(points))
            }
            _ => self.on_chosen(cx, "Add control point", |spec| {
                at = Some(spec.insert_anchor(u)?);
                Ok(())
            }),
        };
        if done {
            (self.anchor, self.point) = (at, None);
        }
    }

    /// Adds a point at a share of the length and at the height of the curve there; returns its index.
    fn add_to_trail(&self, points: &mut Vec<Vec<f64>>, u: f64) -> Option<usize> {
        let places = points.iter().map(|p| Some([*p.first()?, *p.get(1)?])).collect::<Option<Vec<_>>>()?;
        let through = places.into_iter().flatten().collect();
        let mut line = CurveSpec { through, noise: vec![0.0, 0.0, 0.0], ..CurveSpec::default() };
        let at = line.insert_anchor(u).ok()?;
        let has_height = points.first()?.len() > 2;
        let height = self.chosen_curve()?.height(u).filter(|_| has_height).map(|z| rounded(z, 0.1));
        points.insert(at, line.anchors()[at].into_iter().chain(height).collect());
        Some(at)
    }

    pub(crate) fn add_point(&mut self, cx: &mut DrawingContext<'_>, u: f64) {
        let mut at = None;
        let done = self.on_chosen(cx, "Add constraint point", |spec| {
            at = Some(spec.insert_point(u)?);
            Ok(())
        });
        if done {
            (self.anchor, self.point) = (None, at);
        }
    }

    /// Removes the chosen part, or the chosen curve where no part is chosen; returns false where nothing is chosen.
    pub(super) fn remove_chosen(&mut self, cx: &mut DrawingContext<'_>) -> bool {
        let part = match (self.curve, self.anchor, self.point) {
            (None, _, _) => return false,
            (Some(_), Some(i), _) => Part::Anchor(i),
            (Some(_), None, Some(k)) => Part::Point(k),
            (Some(_), None, None) if matches!(self.sheet(), Some(Sheet::Trail(_))) => return false,
            (Some(_), None, None) => Part::Body,
        };
        self.remove_part(cx, part);
        true
    }

    pub(super) fn remove_part(&mut self, cx: &mut DrawingContext<'_>, part: Part) {
        let Some(sheet) = self.sheet().cloned() else { return };
        match (sheet, part) {
            (Sheet::Trail(points), Part::Anchor(i) | Part::Height(i)) => self.shorten(cx, points, i),
            (Sheet::Curves(_), Part::Anchor(i)) => self.remove_anchor(cx, i),
            (Sheet::Curves(_), Part::Point(k)) => self.remove_point(cx, k),
            (Sheet::Curves(mut specs), Part::Body) => {
                let Some(number) = self.curve.filter(|i| *i < specs.len()) else { return };
                specs.remove(number);
                if self.write(cx, "Delete curve", None, &Sheet::Curves(specs)) {
                    (self.curve, self.point, self.anchor) = (None, None, None);
                }
            }
            _ => (),
        }
    }

    fn remove_anchor(&mut self, cx: &mut DrawingContext<'_>, i: usize) {
        if self.on_chosen(cx, "Remove control point", |spec| spec.remove_anchor(i)) {
            self.anchor = None;
        }
    }

    fn shorten(&mut self, cx: &mut DrawingContext<'_>, mut points: Vec<Vec<f64>>, i: usize) {
        if points.len() <= 2 || i >= points.len() {
            cx.notices.fail("A curve keeps two control points");
            return;
        }
        points.remove(i);
        if self.write(cx, "Remove control point", None, &Sheet::Trail(points)) {
            self.anchor = None;
        }
    }

    /// Removes a constraint point of the chosen curve.
    pub(crate) fn remove_point(&mut self, cx: &mut DrawingContext<'_>, k: usize) {
        let Some(mut points) = self.chosen_curve().map(crate::value::Curve::points) else { return };
        if points.len() < 2 || k >= points.len() {
            cx.notices.fail("A curve keeps one constraint point: without any it says nothing");
            return;
        }
        points.remove(k);
        let done = self.on_chosen(cx, "Remove constraint point", |spec| {
            spec.set_points(&points);
            Ok(())
        });
        if done {
            self.point = None;
        }
    }

    /// Deletes the chosen curve.
    pub(crate) fn remove_curve(&mut self, cx: &mut DrawingContext<'_>) {
        self.remove_part(cx, Part::Body);
    }
}
