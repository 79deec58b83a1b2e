//! The tool that draws new curves: a click for each point, or a line with the button down.

use eframe::egui::{Key, PointerButton, Pos2, Response, Ui};

use super::grip::rounded;
use super::sheet::Sheet;
use super::{Drawing, Pad, Space, Tool, Trace, paint, pressed};
use crate::kit::paint::thinned;
use crate::value::CurveSpec;
use crate::value::curves::bezier::{norm, sub};

/// Pixels that a freely drawn line may be off its points.
const LOOSE: f64 = 3.0;
/// Relief in metres below which the ground is a plain, and the length of a new curve that it rises by on one: a curve at
/// the height of a plain would change nothing.
const PLAIN: f64 = 1.0;
const RISE: f64 = 0.1;

impl Drawing {
    /// Begins to draw.
    pub(crate) fn begin(&mut self) {
        self.tool = Tool::Draw;
        (self.start, self.anchor) = (None, None);
    }

    pub(super) fn draw(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        pad: &mut Pad<'_>,
        step: f64,
    ) {
        if pressed(ui, &[Key::Enter, Key::Escape]) {
            self.rest();
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
        let of_curve =
            self.curve.filter(|_| self.anchor.is_some()).and_then(|i| Some(self.sheet()?.places(i)));
        paint::marks(ui, space, self.start.into_iter().chain(of_curve.into_iter().flatten()));
    }

    /// A click: the first begins, the second makes the curve, others go on. A curve that is all that its node has goes on
    /// at once.
    fn click(&mut self, pad: &mut Pad<'_>, p: [f64; 2], space: &dyn Space) {
        match (self.start.take(), self.sheet()) {
            (Some(start), _) if start != p => self.add_curve(pad, &[start, p], space),
            (None, Some(Sheet::Trail(_))) => self.go_on(pad, p, space),
            (None, Some(Sheet::Curves(_))) if self.anchor.is_some() => self.go_on(pad, p, space),
            _ => self.start = Some(p),
        }
    }

    /// Goes on from the end of the chosen curve.
    fn go_on(&mut self, pad: &mut Pad<'_>, p: [f64; 2], space: &dyn Space) {
        let (Some(mut sheet), Some(i)) = (self.sheet().cloned(), self.curve) else { return };
        let anchors = match &mut sheet {
            Sheet::Curves(specs) => {
                let Some(spec) = specs.get_mut(i) else { return };
                if let Err(fault) = spec.extend(p) {
                    pad.notices.fail(format!("The curve {fault}"));
                    return;
                }
                spec.anchors().len()
            }
            Sheet::Trail(points) => {
                points.push(trail_point(points, p, space));
                points.len()
            }
            Sheet::Lines(_) | Sheet::Strokes(_) => return,
        };
        if self.write(pad, "Add control point", None, &sheet) {
            self.anchor = anchors.checked_sub(1);
        }
    }

    fn last_anchor(&self) -> Option<[f64; 2]> {
        match self.sheet()? {
            Sheet::Curves(specs) => specs.get(self.curve?)?.anchors().last().copied(),
            Sheet::Trail(points) => points.last().and_then(|p| Some([*p.first()?, *p.get(1)?])),
            Sheet::Lines(_) | Sheet::Strokes(_) => None,
        }
    }

    /// A new curve at the heights of the ground it is drawn on, on a plain above it; of a node that has one curve, its new course.
    fn add_curve(&mut self, pad: &mut Pad<'_>, points: &[[f64; 2]], space: &dyn Space) {
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
            Sheet::Lines(lines) => {
                lines.push([first[0], first[1], last[0], last[1]]);
                if self.write(pad, "Draw line", None, &sheet) {
                    let number = sheet.len().checked_sub(1);
                    (self.curve, self.point, self.anchor) = (number, None, None);
                }
                return;
            }
            Sheet::Strokes(_) => return,
        };
        if self.write(pad, "Draw curve", None, &sheet) {
            (self.curve, self.point, self.anchor) = (Some(number), None, Some(points.len() - 1));
        }
    }
}

/// A point of a line whose kind has heights or has none, as the points before it.
fn trail_point(points: &[Vec<f64>], p: [f64; 2], space: &dyn Space) -> Vec<f64> {
    let has_height = points.first().is_none_or(|q| q.len() > 2);
    p.into_iter().chain(has_height.then(|| space.height(p).round())).collect()
}
