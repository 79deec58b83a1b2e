//! What a hand does to a curve: control points, handles, constraint points. What it does not touch stays where it is.

use super::bezier::{Cubic, Point, add, sub};
use super::{ConstraintPoint, Curve, CurveSpec, Fault, Slope};

/// Least difference of two shares of the length: they are written with four digits.
const SHARE: f64 = 1e-4;

/// In which form a curve says where it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Cubic pieces with handles.
    Bezier,
    /// A smooth line through points.
    Through,
    /// Straight pieces.
    Line,
}

impl CurveSpec {
    /// In which form it says where it goes.
    pub fn form(&self) -> Form {
        match (self.bezier.is_empty(), self.line.is_empty()) {
            (false, _) => Form::Bezier,
            (true, false) => Form::Line,
            (true, true) => Form::Through,
        }
    }

    fn list(&self) -> &[Point] {
        let list = match self.form() {
            Form::Bezier => &self.bezier,
            Form::Through => &self.through,
            Form::Line => &self.line,
        };
        list.as_chunks::<2>().0
    }

    fn list_mut(&mut self) -> &mut Vec<f64> {
        match self.form() {
            Form::Bezier => &mut self.bezier,
            Form::Through => &mut self.through,
            Form::Line => &mut self.line,
        }
    }

    fn set_list(&mut self, points: &[Point]) {
        *self.list_mut() = points.iter().flatten().copied().collect();
    }

    /// Numbers of list entries from one anchor to the next.
    fn stride(&self) -> usize {
        if self.form() == Form::Bezier { 3 } else { 1 }
    }

    /// The control points that the curve goes through, in order.
    pub fn anchors(&self) -> Vec<Point> {
        self.list().iter().step_by(self.stride()).copied().collect()
    }

    /// The handles of Bézier pieces: for each its number in the list, its anchor's and its place.
    pub fn handles(&self) -> Vec<(usize, usize, Point)> {
        if self.form() != Form::Bezier {
            return Vec::new();
        }
        let inner = self.list().iter().enumerate().filter(|(k, _)| k % 3 != 0);
        inner.map(|(k, at)| (k, (k + 1) / 3, *at)).collect()
    }

    fn is_closed(&self) -> bool {
        let list = self.list();
        list.len() > 2 && list.first() == list.last()
    }

    /// Moves a control point; its handles go with it, and both ends of a closed curve are one.
    pub fn move_anchor(&mut self, i: usize, to: Point) {
        let (closed, stride) = (self.is_closed(), self.stride());
        let mut list = self.list().to_vec();
        let Some(last) = list.len().checked_sub(1) else { return };
        let at = i * stride;
        if at > last {
            return;
        }
        let by = sub(to, list[at]);
        let mut shift = |k: usize| {
            let from = if stride == 3 { k.saturating_sub(1) } else { k };
            let end = if stride == 3 { (k + 1).min(last) } else { k };
            list[from..=end].iter_mut().for_each(|p| *p = add(*p, by));
        };
        shift(at);
        if closed && (at == 0 || at == last) {
            shift(last - at);
        }
        self.set_list(&list);
    }

    /// Moves a handle, by its number in the list; with `paired` the handle on the other side of the anchor turns with it.
    pub fn move_handle(&mut self, k: usize, to: Point, paired: bool) {
        let mut list = self.list().to_vec();
        if self.form() != Form::Bezier || k >= list.len() || k.is_multiple_of(3) {
            return;
        }
        list[k] = to;
        let (anchor, other) = if k % 3 == 1 { (k - 1, k.checked_sub(2)) } else { (k + 1, Some(k + 2)) };
        if let Some(other) = other.filter(|o| paired && *o < list.len()) {
            let out = sub(list[anchor], to);
            let length = super::bezier::norm(out);
            let own = super::bezier::norm(sub(list[other], list[anchor]));
            if length > 0.0 {
                list[other] = add(list[anchor], super::bezier::times(out, own / length)).map(rounded);
            }
        }
        self.set_list(&list);
    }

    /// Moves the whole curve.
    pub fn shift(&mut self, by: Point) {
        let moved: Vec<Point> = self.list().iter().map(|p| add(*p, by).map(rounded)).collect();
        self.set_list(&moved);
    }

    /// Puts a control point at a share of the length and returns its number. A Bézier curve keeps its course, others
    /// hardly change it.
    ///
    /// # Errors
    /// When the curve has a fault or would have too many points.
    pub fn insert_anchor(&mut self, u: f64) -> Result<usize, Fault> {
        let curve = self.build()?;
        let (piece, t) = curve.place(u);
        let mut list = self.list().to_vec();
        if self.form() == Form::Bezier {
            let [a, b] = curve.piece(piece).split(t);
            let new = [a.0[1], a.0[2], a.0[3], b.0[1], b.0[2]].map(|p| p.map(rounded));
            list.splice(3 * piece + 1..3 * piece + 3, new);
        } else {
            list.insert(self.number_before(piece) + 1, curve.point(u).map(rounded));
        }
        let mut next = self.clone();
        next.set_list(&list);
        next.build()?;
        *self = next;
        Ok(if self.form() == Form::Bezier { piece + 1 } else { self.number_before(piece) + 1 })
    }

    /// The number of the list's point at which a piece starts; points that repeat the one before make no piece.
    fn number_before(&self, piece: usize) -> usize {
        let list = self.list();
        let starts = (0..list.len()).filter(|&i| i + 1 < list.len() && list[i] != list[i + 1]);
        starts.take(piece + 1).last().unwrap_or(0)
    }

    /// Takes a control point away.
    ///
    /// # Errors
    /// When there are only two.
    pub fn remove_anchor(&mut self, i: usize) -> Result<(), Fault> {
        let count = self.anchors().len();
        if count <= 2 || i >= count {
            return Err(Fault::new("must keep two control points; remove the whole curve instead"));
        }
        let mut list = self.list().to_vec();
        if self.form() == Form::Bezier {
            // The handles that face the neighbours stay.
            let from = if i == 0 { 0 } else { (3 * i - 1).min(list.len() - 3) };
            list.drain(from..from + 3);
        } else {
            list.remove(i);
        }
        let mut next = self.clone();
        next.set_list(&list);
        next.build()?;
        *self = next;
        Ok(())
    }

    /// Goes on from the end to a point.
    ///
    /// # Errors
    /// When the curve would have too many points.
    pub fn extend(&mut self, to: Point) -> Result<(), Fault> {
        let mut next = self.clone();
        match (self.form(), self.list().last()) {
            (Form::Bezier, Some(&end)) => {
                let [_, a, b, to] = Cubic::straight(end, to).0;
                next.bezier.extend([a.map(rounded), b.map(rounded), to].concat());
            }
            _ => next.list_mut().extend(to),
        }
        next.build()?;
        *self = next;
        Ok(())
    }

    /// Cuts the curve in two; what holds at the cut is written down on both sides. Between the cut and its neighbours
    /// the height may go another way, since its cubic has lost the points beyond.
    ///
    /// # Errors
    /// When the curve has a fault or the cut is at an end.
    pub fn split(&self, u: f64) -> Result<[Self; 2], Fault> {
        if !(SHARE..=1.0 - SHARE).contains(&u) {
            return Err(Fault::new("cannot be cut at its end"));
        }
        let curve = self.build()?;
        let mut whole = self.clone();
        let at = whole.insert_anchor(u)? * whole.stride();
        let list = whole.list().to_vec();
        let mut halves = [whole.clone(), whole];
        halves[0].set_list(&list[..=at]);
        halves[1].set_list(&list[at..]);
        let here = ConstraintPoint { u, ..curve.attributes(u) };
        for (half, spec) in halves.iter_mut().enumerate() {
            let mut points = curve.points();
            points.retain(|p| if half == 0 { p.u < u } else { p.u > u });
            points.insert(if half == 0 { points.len() } else { 0 }, here);
            for p in &mut points {
                let own = if half == 0 { p.u / u } else { (p.u - u) / (1.0 - u) };
                p.u = share(own);
            }
            spec.set_points(&points);
            spec.build()?;
        }
        Ok(halves)
    }

    /// The curve from its end to its start: left is right; constraint points keep their places to a ten-thousandth of the
    /// length.
    pub fn reversed(&self) -> Self {
        let mut next = self.clone();
        let list: Vec<Point> = self.list().iter().rev().copied().collect();
        next.set_list(&list);
        let Ok(curve) = self.build() else { return next };
        let turned = curve.points().into_iter().rev().map(|p| ConstraintPoint {
            u: share(1.0 - p.u),
            slope: p.slope.map(|s| Slope {
                left_extent: s.right_extent,
                right_extent: s.left_extent,
                left_angle: s.right_angle,
                right_angle: s.left_angle,
            }),
            envelope: p.envelope.map(|e| super::Envelope { left: e.right, right: e.left }),
            ..p
        });
        next.set_points(&turned.collect::<Vec<_>>());
        next
    }

    /// The curve in another form: handles to bend it by, a smooth line through its control points, or straight pieces.
    ///
    /// # Errors
    /// When the curve has a fault.
    pub fn in_form(&self, form: Form) -> Result<Self, Fault> {
        let knots = self.build()?.knots().to_vec();
        let mut next = Self { bezier: Vec::new(), through: Vec::new(), line: Vec::new(), ..self.clone() };
        let flat = |points: &[Point]| points.iter().flat_map(|p| p.map(rounded)).collect::<Vec<_>>();
        match form {
            Form::Bezier => next.bezier = flat(&knots),
            Form::Through => next.through = flat(&self.anchors()),
            Form::Line => next.line = flat(&self.anchors()),
        }
        next.build()?;
        Ok(next)
    }

    /// Writes the constraint points, in the order of `u`.
    pub fn set_points(&mut self, points: &[ConstraintPoint]) {
        let flat = |of: fn(&ConstraintPoint) -> Vec<f64>| points.iter().flat_map(of).collect::<Vec<_>>();
        self.height = flat(|p| p.elevation.map_or(Vec::new(), |e| vec![p.u, e.height, e.radius]));
        self.slope = flat(|p| {
            p.slope
                .map_or(Vec::new(), |s| vec![p.u, s.left_extent, s.right_extent, s.left_angle, s.right_angle])
        });
        self.noise = flat(|p| p.noise.map_or(Vec::new(), |n| vec![p.u, n.amplitude, n.roughness]));
        self.envelope = flat(|p| p.envelope.map_or(Vec::new(), |e| vec![p.u, e.left, e.right]));
    }

    /// Puts a constraint point at a share of the length, with all that holds there, and returns its number.
    ///
    /// # Errors
    /// When the curve has a fault or a point there already.
    pub fn insert_point(&mut self, u: f64) -> Result<usize, Fault> {
        let (curve, u) = (self.build()?, share(u));
        let mut points = curve.points();
        if points.iter().any(|p| (p.u - u).abs() < SHARE) {
            return Err(Fault::new("has a constraint point there already"));
        }
        let at = points.partition_point(|p| p.u < u);
        let new = ConstraintPoint { u, ..curve.attributes(u) };
        // What the eye reads has no more digits than it needs.
        let elevation =
            new.elevation.map(|e| super::Elevation { height: tenth(e.height), radius: tenth(e.radius) });
        points.insert(at, ConstraintPoint { elevation, ..new });
        self.set_points(&points);
        Ok(at)
    }
}

/// A place as files write it: to a millimetre.
fn rounded(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

fn tenth(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

/// A share of the length as files write it.
pub fn share(u: f64) -> f64 {
    (u.clamp(0.0, 1.0) * 10_000.0).round() / 10_000.0
}

impl Curve {
    /// The share of the length at which the curve comes nearest to a place, and how far it is from there, in metres.
    pub fn nearest(&self, to: Point) -> (f64, f64) {
        let far = |u: f64| super::bezier::norm(sub(self.point(u), to));
        let steps = (16 * self.pieces()).clamp(32, 4096);
        let at = |k: usize| k as f64 / steps as f64;
        let best = (0..=steps).map(|k| (at(k), far(at(k)))).min_by(|a, b| a.1.total_cmp(&b.1));
        let (mut u, _) = best.unwrap_or((0.0, 0.0));
        let mut step = 0.5 / steps as f64;
        for _ in 0..24 {
            let near = [(u - step).max(0.0), u, (u + step).min(1.0)];
            u = near.into_iter().min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(u);
            step *= 0.6;
        }
        (u, far(u))
    }
}
