//! Grips, the parts of a curve that can be dragged: control points and handles, constraint points, and the height,
//! plateau, extents and angles of the chosen constraint point.

use eframe::egui::Pos2;

use super::Space;
use super::sheet::Sheet;
use crate::nodes::curves::short::CurveSide;
use crate::value::curves::bezier::shares;
use crate::value::curves::bezier::{Point, add, dot, left_of, sub, times};
use crate::value::curves::edit::share;
use crate::value::curves::{ConstraintPoint, MAX_ANGLE, MAX_EXTENT, MAX_HEIGHT};
use crate::value::{Curve, CurveSpec};

/// Pixels by which the grip of a height stands above its point.
const STEM: f32 = 34.0;
/// Pixels by which a constraint point stands above a control point at the same place.
const LIFT: f32 = 15.0;
/// The least distance of grips beside a point from it and from each other, in pixels.
const APART: f64 = 12.0;
/// The place of the grip of an angle on its slope, as a share of the extent, and the rise of the ground there, as a
/// share of extent times tangent. Steepness fades linearly over the extent, so that the rise is `s − s²/2`.
const ON_SLOPE: [f64; 2] = [0.5, 0.375];

/// A part of a curve that can be dragged, with its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    Anchor(usize),
    /// A handle, with its index among the knots.
    Handle(usize),
    Point(usize),
    Height(usize),
    Plateau(usize),
    Extent(usize, CurveSide),
    Angle(usize, CurveSide),
    /// The whole curve.
    Body,
}

/// A part with its place and its label.
#[derive(Clone, Debug)]
pub(crate) struct Grip {
    pub(crate) part: Part,
    pub(crate) at: [f64; 3],
    /// Pixels by which the grip stands above its place.
    pub(crate) lift: f32,
    /// A place that a line joins to the grip.
    pub(crate) joined: Option<[f64; 3]>,
    /// The name, for the label and for assistive technology.
    pub(crate) name: String,
    /// The text of the value, empty where there is none.
    pub(crate) value: String,
}

/// A curve of a drawing, and which of its points is chosen.
pub(crate) struct EditedCurve<'a> {
    pub(crate) sheet: &'a Sheet,
    pub(crate) number: usize,
    pub(crate) curve: &'a Curve,
    /// The chosen constraint point.
    pub(crate) point: Option<usize>,
}

/// The movement of a part in a drag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    /// The place of the part before the drag.
    pub(crate) from: Point,
    /// The place under the pointer, at the height of the part.
    pub(crate) to: Point,
    /// Movement upwards, in metres.
    pub(crate) rise: f64,
    /// Whether the handle on the other side of the control point turns too.
    pub(crate) paired: bool,
    /// The step to which coordinates are rounded, in metres.
    pub(crate) step: f64,
}

impl EditedCurve<'_> {
    /// The height of the curve, or of the ground where the curve sets none.
    fn level(&self, at: Point, u: f64, space: &dyn Space) -> f64 {
        self.curve.height(u).unwrap_or_else(|| space.height(at))
    }

    /// All grips, in the order in which they are drawn.
    pub(crate) fn grips(&self, space: &dyn Space) -> Vec<Grip> {
        let mut all = Vec::new();
        match self.sheet {
            Sheet::Trail(points) => self.trail(points, space, &mut all),
            Sheet::Curves(specs) => {
                if let Some(spec) = specs.get(self.number) {
                    self.line(spec, space, &mut all);
                    self.constraints(space, &mut all);
                }
            }
            Sheet::Strokes(_) => (),
        }
        all
    }

    fn trail(&self, points: &[Vec<f64>], space: &dyn Space, all: &mut Vec<Grip>) {
        for (i, p) in points.iter().enumerate() {
            let at = [p[0], p[1]];
            let z = p.get(2).copied().unwrap_or_else(|| space.height(at));
            all.push(grip(Part::Anchor(i), [at[0], at[1], z], format!("control point {i}")));
            if p.len() > 2 {
                all.push(stem(Part::Height(i), [at[0], at[1], z], format!("height {i}"), z));
            }
        }
    }

    fn line(&self, spec: &CurveSpec, space: &dyn Space, all: &mut Vec<Grip>) {
        let anchors = spec.anchors();
        let shares = shares(self.curve.knots());
        // A point that repeats the one before has no piece of its own, and then the numbers differ.
        let fits = shares.len() == anchors.len();
        let level = |i: usize| {
            let u = if fits { shares[i] } else { self.curve.nearest(anchors[i]).0 };
            self.level(anchors[i], u, space)
        };
        let levels: Vec<f64> = (0..anchors.len()).map(level).collect();
        for (k, anchor, at) in spec.handles() {
            let (z, from) = (levels[anchor], anchors[anchor]);
            let handle = grip(Part::Handle(k), [at[0], at[1], z], format!("handle {k}"));
            all.push(Grip { joined: Some([from[0], from[1], z]), ..handle });
        }
        for (i, (at, z)) in anchors.iter().zip(&levels).enumerate() {
            all.push(grip(Part::Anchor(i), [at[0], at[1], *z], format!("control point {i}")));
        }
    }

    fn constraints(&self, space: &dyn Space, all: &mut Vec<Grip>) {
        let anchors = all.iter().filter(|g| matches!(g.part, Part::Anchor(_)));
        let anchors: Vec<Pos2> = anchors.filter_map(|g| space.screen(g.at)).collect();
        for (k, point) in self.curve.points().iter().enumerate() {
            let at = self.curve.point(point.u);
            let z = self.level(at, point.u, space);
            let foot = [at[0], at[1], z];
            if self.point == Some(k) {
                self.sides(k, foot, space, all);
            }
            let value = format!("at {:.3} of the length", point.u);
            // A constraint point stands above a control point at the same place, as at both ends of a curve, so that
            // both can be dragged.
            let covers = |at: Pos2| anchors.iter().any(|a| a.distance(at) < LIFT);
            let lift = if space.screen(foot).is_some_and(covers) { LIFT } else { 0.0 };
            let name = format!("constraint point {k}");
            all.push(Grip { value, lift, ..grip(Part::Point(k), foot, name) });
            if self.curve.tracks().elevation.is_some() {
                all.push(stem(Part::Height(k), foot, format!("height {k}"), z));
            }
        }
    }

    /// Plateau, extents and angles of the chosen constraint point.
    fn sides(&self, k: usize, foot: [f64; 3], space: &dyn Space, all: &mut Vec<Grip>) {
        let Some(here) = self.attributes(k) else { return };
        let left = left_of(self.curve.heading(here.u));
        let beside = |metres: f64, z: f64| {
            let p = add([foot[0], foot[1]], times(left, metres));
            [p[0], p[1], z]
        };
        let radius = here.elevation.map_or(0.0, |e| e.radius);
        let apart = APART * space.across(foot);
        let edge_at = radius.max(1.7 * apart);
        for side in [CurveSide::Left, CurveSide::Right] {
            let (name, sign) = named(side);
            let Some((extent, angle)) = here.slope.map(|s| on_side(s, side)) else { continue };
            let tangent = libm::tan(angle.to_radians());
            let edge = beside(sign * radius, foot[2]);
            let end_at = (radius + extent).max(edge_at + 2.0 * apart);
            let half = (radius + ON_SLOPE[0] * extent).max(edge_at + apart);
            let on_slope = beside(sign * half, foot[2] + ON_SLOPE[1] * extent * tangent);
            let end = beside(sign * end_at, foot[2] + 0.5 * extent * tangent);
            let value = format!("{extent:.0} m");
            let extent_grip = grip(Part::Extent(k, side), end, format!("extent {name} {k}"));
            all.push(Grip { joined: Some(on_slope), value, ..extent_grip });
            if extent > 0.0 {
                let angle_grip = grip(Part::Angle(k, side), on_slope, format!("angle {name} {k}"));
                all.push(Grip { joined: Some(edge), value: format!("{angle:.1}°"), ..angle_grip });
            }
        }
        if here.elevation.is_some() {
            // The grip is on the side that is lower on the screen, because the pin of the height is on the other.
            let sides = [edge_at, -edge_at].map(|across| beside(across, foot[2]));
            let low = |at: [f64; 3]| space.screen(at).map_or(f32::MIN, |p| p.y);
            let [at, opposite] = if low(sides[0]) >= low(sides[1]) { sides } else { [sides[1], sides[0]] };
            let grip = grip(Part::Plateau(k), at, format!("plateau {k}"));
            all.push(Grip { joined: Some(opposite), value: format!("{radius:.0} m"), ..grip });
        }
    }

    /// The attributes of the curve at a constraint point.
    fn attributes(&self, k: usize) -> Option<ConstraintPoint> {
        let u = self.curve.points().get(k)?.u;
        let mut here = self.curve.attributes(u);
        here.u = u;
        Some(here)
    }

    /// The drawing after a part was moved.
    pub(crate) fn pulled(&self, part: Part, pull: &Pull) -> Sheet {
        match self.sheet {
            Sheet::Trail(points) => {
                let mut points = points.clone();
                pull_trail(&mut points, part, pull);
                Sheet::Trail(points)
            }
            Sheet::Curves(specs) => {
                let mut specs = specs.clone();
                if let Some(spec) = specs.get_mut(self.number) {
                    self.pull_spec(spec, part, pull);
                }
                Sheet::Curves(specs)
            }
            strokes @ Sheet::Strokes(_) => strokes.clone(),
        }
    }

    fn pull_spec(&self, spec: &mut CurveSpec, part: Part, pull: &Pull) {
        let to = pull.to.map(|x| rounded(x, pull.step));
        match part {
            Part::Anchor(i) => spec.move_anchor(i, to),
            Part::Handle(k) => spec.move_handle(k, to, pull.paired),
            // For the whole curve, `to` is the movement.
            Part::Body => spec.shift(to),
            Part::Point(k) => self.slide(spec, k, pull.to),
            Part::Height(k) => self.change(spec, k, |p| {
                if let Some(e) = &mut p.elevation {
                    e.height = rounded(e.height + pull.rise, pull.step).clamp(-MAX_HEIGHT, MAX_HEIGHT);
                }
            }),
            Part::Plateau(k) => {
                // Outwards is larger, on either side of the curve.
                let [from, to] = [pull.from, pull.to].map(|p| self.across(k, p).abs());
                let across = to - from;
                self.change(spec, k, |p| {
                    if let Some(e) = &mut p.elevation {
                        e.radius = rounded(e.radius + across, pull.step).clamp(0.0, MAX_EXTENT);
                    }
                });
            }
            Part::Extent(k, side) => {
                let across = (self.across(k, pull.to) - self.across(k, pull.from)) * named(side).1;
                self.change(spec, k, |p| {
                    let Some(slope) = &mut p.slope else { return };
                    let extent = match side {
                        CurveSide::Left => &mut slope.left_extent,
                        CurveSide::Right => &mut slope.right_extent,
                    };
                    *extent = rounded(*extent + across, pull.step).clamp(0.0, MAX_EXTENT);
                });
            }
            Part::Angle(k, side) => self.change(spec, k, |p| {
                let Some(slope) = &mut p.slope else { return };
                let (extent, angle) = on_side(*slope, side);
                let tangent = libm::tan(angle.to_radians()) + pull.rise / (ON_SLOPE[1] * extent).max(1e-6);
                let angle = rounded(libm::atan(tangent).to_degrees(), 0.5).clamp(-MAX_ANGLE, MAX_ANGLE);
                match side {
                    CurveSide::Left => slope.left_angle = angle,
                    CurveSide::Right => slope.right_angle = angle,
                }
            }),
        }
    }

    /// The distance of a place to the left of a constraint point, in metres; negative to the right.
    fn across(&self, k: usize, at: Point) -> f64 {
        let u = self.curve.points().get(k).map_or(0.0, |p| p.u);
        dot(sub(at, self.curve.point(u)), left_of(self.curve.heading(u)))
    }

    /// Changes the attributes at a constraint point. A group that the point did not set, but the change alters, is set
    /// in full, starting from the interpolated values.
    fn change(&self, spec: &mut CurveSpec, k: usize, change: impl FnOnce(&mut ConstraintPoint)) {
        let mut points = self.curve.points();
        let (Some(here), Some(point)) = (self.attributes(k), points.get_mut(k)) else { return };
        let mut new = here;
        change(&mut new);
        if new.elevation != here.elevation {
            point.elevation = new.elevation;
        }
        if new.slope != here.slope {
            point.slope = new.slope;
        }
        spec.set_points(&points);
    }

    /// Moves a constraint point along the curve, between its neighbours.
    fn slide(&self, spec: &mut CurveSpec, k: usize, to: Point) {
        let mut points = self.curve.points();
        let least = if k == 0 { 0.0 } else { points[k - 1].u + 0.001 };
        let most = points.get(k + 1).map_or(1.0, |p| p.u - 0.001);
        if let Some(point) = points.get_mut(k).filter(|_| least <= most) {
            point.u = share(self.curve.nearest(to).0.clamp(least, most));
            spec.set_points(&points);
        }
    }
}

fn pull_trail(points: &mut [Vec<f64>], part: Part, pull: &Pull) {
    match part {
        Part::Anchor(i) => {
            if let Some(p) = points.get_mut(i) {
                (p[0], p[1]) = (rounded(pull.to[0], pull.step), rounded(pull.to[1], pull.step));
            }
        }
        Part::Height(i) => {
            if let Some(z) = points.get_mut(i).and_then(|p| p.get_mut(2)) {
                *z = rounded(*z + pull.rise, pull.step);
            }
        }
        Part::Body => points.iter_mut().for_each(|p| {
            p.iter_mut().zip(pull.to).for_each(|(x, by)| *x = rounded(*x + by, pull.step));
        }),
        _ => (),
    }
}

fn on_side(slope: crate::value::curves::Slope, side: CurveSide) -> (f64, f64) {
    match side {
        CurveSide::Left => (slope.left_extent, slope.left_angle),
        CurveSide::Right => (slope.right_extent, slope.right_angle),
    }
}

fn named(side: CurveSide) -> (&'static str, f64) {
    match side {
        CurveSide::Left => ("left", 1.0),
        CurveSide::Right => ("right", -1.0),
    }
}

fn grip(part: Part, at: [f64; 3], name: String) -> Grip {
    Grip { part, at, lift: 0.0, joined: None, name, value: String::new() }
}

fn stem(part: Part, at: [f64; 3], name: String, height: f64) -> Grip {
    Grip { part, at, lift: STEM, joined: Some(at), name, value: format!("{height:.0} m") }
}

pub(super) fn rounded(x: f64, step: f64) -> f64 {
    // Multiplying by the reciprocal of the step, a whole number, keeps 0.1 at 0.1.
    let per = (1.0 / step).round().max(1.0);
    if step >= 1.0 { (x / step).round() * step } else { (x * per).round() / per }
}
