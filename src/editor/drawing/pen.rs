//! The tool that draws new curves, by a click for each point or by a line with the button down.

use eframe::egui::{Key, PointerButton, Pos2, Response, Ui};

use super::grip::rounded;
use super::sheet::Sheet;
use super::{Drawing, DrawingContext, Space, Tool, Trace, paint, pressed};
use crate::kit::paint::thinned;
use crate::value::CurveSpec;
use crate::value::curves::bezier::{norm, sub};

/// The deviation that thinning a freely drawn line may cause, in pixels.
const LOOSE: f64 = 3.0;
/// Relief in metres below which the ground is a plain, and the height of a new curve on a plain as a share of its
/// length. A curve at the height of the plain would change nothing.
const PLAIN: f64 = 1.0;
const RISE: f64 = 0.1;

impl Drawing {
    /// Starts a new curve.
    pub(crate) fn begin_curve(&mut self) {
        self.tool = Tool::Draw;
        (self.start, self.anchor) = (None, None);
    }

    pub(super) fn draw(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        cx: &mut DrawingContext<'_>,
        step: f64,
    ) {
        if pressed(ui, &[Key::Enter, Key::Escape]) {
            self.end_tool();
            return;
        }
        let place = |pos: Pos2| space.ground(pos).map(|p| p.map(|x| rounded(x, step)));
        let here = ui.input(|i| i.pointer.hover_pos()).and_then(place);
        if ground.drag_started_by(PointerButton::Primary) {
            let from = ui.input(|i| i.pointer.press_origin()).and_then(place);
            let sheet = self.sheet().cloned();
            self.trace = from.zip(sheet).map(|(p, sheet)| Trace { sheet, points: vec![p], written: 0 });
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
                self.add_curve(cx, &points, space);
                self.start = None;
            }
            return;
        }
        if ground.double_clicked() {
            self.end_tool();
        } else if let Some(p) = ground.interact_pointer_pos().filter(|_| ground.clicked()).and_then(place) {
            self.click(cx, p, space);
        }
        let end = self.start.or_else(|| self.anchor.and_then(|_| self.last_anchor()));
        if let (Some(from), Some(to)) = (end, here) {
            paint::path(ui, space, &[from, to]);
        }
        let of_curve =
            self.curve.filter(|_| self.anchor.is_some()).and_then(|i| Some(self.sheet()?.places(i)));
        paint::marks(ui, space, self.start.into_iter().chain(of_curve.into_iter().flatten()));
    }

    /// Handles a click: the first sets the start, the second adds the curve, later ones extend it. The curve of a node
    /// that has exactly one is extended from the first click on.
    fn click(&mut self, cx: &mut DrawingContext<'_>, p: [f64; 2], space: &dyn Space) {
        match (self.start.take(), self.sheet()) {
            (Some(start), _) if start != p => self.add_curve(cx, &[start, p], space),
            (None, Some(Sheet::Trail(_))) => self.go_on(cx, p, space),
            (None, Some(Sheet::Curves(_))) if self.anchor.is_some() => self.go_on(cx, p, space),
            _ => self.start = Some(p),
        }
    }

    /// Extends the chosen curve at its end.
    fn go_on(&mut self, cx: &mut DrawingContext<'_>, p: [f64; 2], space: &dyn Space) {
        let (Some(mut sheet), Some(i)) = (self.sheet().cloned(), self.curve) else { return };
        let anchors = match &mut sheet {
            Sheet::Curves(specs) => {
                let Some(spec) = specs.get_mut(i) else { return };
                if let Err(fault) = spec.extend(p) {
                    cx.notices.fail(format!("The curve {fault}"));
                    return;
                }
                spec.anchors().len()
            }
            Sheet::Trail(points) => {
                points.push(trail_point(points, p, space));
                points.len()
            }
            Sheet::Strokes(_) => return,
        };
        if self.write(cx, "Add control point", None, &sheet) {
            self.anchor = anchors.checked_sub(1);
        }
    }

    fn last_anchor(&self) -> Option<[f64; 2]> {
        match self.sheet()? {
            Sheet::Curves(specs) => specs.get(self.curve?)?.anchors().last().copied(),
            Sheet::Trail(points) => points.last().and_then(|p| Some([*p.first()?, *p.get(1)?])),
            Sheet::Strokes(_) => None,
        }
    }

    /// Adds a curve at the heights of the ground, or above the ground where this is a plain. On a node that has exactly
    /// one curve, replaces the course of that.
    fn add_curve(&mut self, cx: &mut DrawingContext<'_>, points: &[[f64; 2]], space: &dyn Space) {
        let Some(mut sheet) = self.sheet().cloned() else { return };
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
        let number = match &mut sheet {
            Sheet::Curves(specs) => {
                let long: f64 = points.windows(2).map(|w| norm(sub(w[1], w[0]))).sum();
                let rise = if space.relief() < PLAIN { RISE * long } else { 0.0 };
                let [from, to] = [first, last].map(|p| (space.height(*p) + rise).round());
                specs.push(CurveSpec {
                    through: points.iter().flatten().copied().collect(),
                    height: vec![0.0, from, 0.0, 1.0, to, 0.0],
                    ..CurveSpec::default()
                });
                specs.len() - 1
            }
            Sheet::Trail(old) => {
                *old = points.iter().map(|p| trail_point(old, *p, space)).collect();
                0
            }
            Sheet::Strokes(_) => return,
        };
        if self.write(cx, "Draw curve", None, &sheet) {
            (self.curve, self.point, self.anchor) = (Some(number), None, Some(points.len() - 1));
        }
    }
}

/// A point of a line, with a height where the points before it have heights.
fn trail_point(points: &[Vec<f64>], p: [f64; 2], space: &dyn Space) -> Vec<f64> {
    let has_height = points.first().is_none_or(|q| q.len() > 2);
    p.into_iter().chain(has_height.then(|| space.height(p).round())).collect()
}
