//! The parts of the ground beside a polyline: a quadrangle along each segment, a sector at the outside of each bend.

use crate::value::curves::bezier::{Point, add, dot, left_of, norm, sub, times};

/// What a part of the ground is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Beside a segment: every point whose foot lies on it.
    Segment,
    /// Beyond a corner: every point nearer to the corner than to both segments; on the side of this number.
    Sector(usize),
    /// Beyond a corner where the line turns right back.
    Cusp,
    /// The cells nearest to a point.
    Dot,
}

/// Number of the left side.
pub(super) const LEFT: usize = 0;
/// Number of the right side.
pub(super) const RIGHT: usize = 1;

/// A straight border, `a x + b y + c ≥ 0`, relative to the start of the shape.
#[derive(Clone, Copy, Debug, Default)]
struct Border {
    a: f64,
    b: f64,
    c: f64,
    /// Where it crosses a row y is `slope · y + at`.
    slope: f64,
    at: f64,
    /// Whether it is too near to a row's direction to say where it crosses.
    flat: bool,
}

impl Border {
    fn new(a: f64, b: f64, c: f64) -> Self {
        let flat = a.abs() <= 1e-7 * b.abs() || a == 0.0;
        let (slope, at) = if flat { (0.0, 0.0) } else { (-b / a, -c / a) };
        Self { a, b, c, slope, at, flat }
    }

    fn at(&self, [x, y]: Point) -> f64 {
        self.a * x + self.b * y + self.c
    }
}

/// A part of the ground, convex but for a round edge.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) kind: Kind,
    /// Start of the segment, or the corner.
    pub(super) from: Point,
    /// Heading of the segment; at a corner that of the segment before.
    pub(super) heading: Point,
    /// Heading of the segment after a corner.
    next: Point,
    pub(super) length: f64,
    /// One over the length.
    per_length: f64,
    borders: [Border; 4],
    /// Radius that contains a sector.
    reach: f64,
    /// Bounds relative to `from`.
    pub(super) min: Point,
    pub(super) max: Point,
    /// What counts as touching, in metres.
    slack: f64,
}

/// Where a point stands on a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Share of the segment at its foot.
    pub(super) share: f64,
    /// Distance from the curve, in metres.
    pub(super) distance: f64,
    pub(super) side: usize,
    /// Direction away from the curve; zero on it.
    pub(super) away: Point,
}

impl Shape {
    /// The ground beside a segment; its widths at start and end on the left and right.
    pub(super) fn segment(from: Point, to: Point, widths: [[f64; 2]; 2], slack: f64) -> Option<Self> {
        let along = sub(to, from);
        let length = norm(along);
        if length <= 0.0 {
            return None;
        }
        let t = times(along, 1.0 / length);
        let n = left_of(t);
        let [[l0, l1], [r0, r1]] = widths;
        let (l, r) = ((l1 - l0) / length, (r1 - r0) / length);
        let borders = [
            Border::new(t[0], t[1], slack),
            Border::new(-t[0], -t[1], length + slack),
            Border::new(l * t[0] - n[0], l * t[1] - n[1], l0 + slack * (1.0 + l.abs())),
            Border::new(r * t[0] + n[0], r * t[1] + n[1], r0 + slack * (1.0 + r.abs())),
        ];
        let corners = [
            times(n, l0 + slack),
            times(n, -r0 - slack),
            add(along, times(n, l1 + slack)),
            add(along, times(n, -r1 - slack)),
        ];
        let (min, max) = bounds(&corners, slack);
        let reach = f64::INFINITY;
        let kind = Kind::Segment;
        Some(Self { kind, from, heading: t, next: t, length, per_length: 1.0 / length, borders, reach, min, max, slack })
    }

    /// The ground beyond a corner between two headings; `reach` is its radius on the left and right. `None` where the
    /// line goes straight on.
    pub(super) fn sector(at: Point, t: Point, next: Point, reach: [f64; 2], slack: f64) -> Option<Self> {
        let (turn, cos) = (dot(left_of(t), next), dot(t, next));
        let kind = match () {
            () if turn.abs() > 1e-9 => Kind::Sector(if turn > 0.0 { RIGHT } else { LEFT }),
            () if cos > 0.0 => return None,
            () => Kind::Cusp,
        };
        let reach = slack
            + match kind {
                Kind::Sector(side) => reach[side],
                _ => reach[LEFT].max(reach[RIGHT]),
            };
        let borders = [
            Border::new(t[0], t[1], slack),
            Border::new(-next[0], -next[1], slack),
            Border::default_open(),
            Border::default_open(),
        ];
        let (min, max) = match kind {
            Kind::Sector(side) if cos > 0.0 => {
                let out = if side == LEFT { 1.0 } else { -1.0 };
                let (a, b) = (times(left_of(t), out), times(left_of(next), out));
                // Where the tangents of the arc at its ends meet.
                let peak = times(add(a, b), 1.0 / (1.0 + cos));
                bounds(&[[0.0; 2], times(a, reach), times(b, reach), times(peak, reach)], slack)
            }
            _ => ([-reach; 2], [reach; 2]),
        };
        Some(Self { kind, from: at, heading: t, next, length: 0.0, per_length: 0.0, borders, reach, min, max, slack })
    }

    /// The cells within half a cell of a point, along both axes.
    pub(super) fn dot(at: Point, half: f64, slack: f64) -> Self {
        let (min, max) = ([-half - slack; 2], [half + slack; 2]);
        let borders = [Border::default_open(); 4];
        let reach = f64::INFINITY;
        let heading = [1.0, 0.0];
        let (kind, length) = (Kind::Dot, 0.0);
        Self { kind, from: at, heading, next: heading, length, per_length: 0.0, borders, reach, min, max, slack }
    }

    /// Whether a rectangle, relative to the start, may hold a point of it.
    pub(super) fn touches(&self, min: Point, max: Point) -> bool {
        if (0..2).any(|k| min[k] > self.max[k] || max[k] < self.min[k]) {
            return false;
        }
        // A border shuts the rectangle out when its best corner is outside.
        self.borders.iter().all(|b| {
            let best = [if b.a > 0.0 { max[0] } else { min[0] }, if b.b > 0.0 { max[1] } else { min[1] }];
            b.at(best) >= 0.0
        })
    }

    /// The range of x, relative to the start, that a row at `y` has in it, a hair too wide at most.
    pub(super) fn span(&self, y: f64) -> Option<[f64; 2]> {
        let [mut low, mut high] = [self.min[0], self.max[0]];
        if self.reach < f64::INFINITY {
            let square = self.reach * self.reach - y * y;
            let half = if square > 0.0 { square.sqrt() } else { 0.0 };
            low = low.max(-half);
            high = high.min(half);
        }
        for b in &self.borders {
            if b.flat {
                if b.at([self.min[0], y]) < 0.0 && b.at([self.max[0], y]) < 0.0 {
                    return None;
                }
            } else if b.a > 0.0 {
                low = low.max(b.slope * y + b.at);
            } else {
                high = high.min(b.slope * y + b.at);
            }
        }
        let pad = self.slack;
        (low <= high + 2.0 * pad).then_some([low - pad, high + pad])
    }

    /// Where a point, relative to the start, stands; `None` when its foot is not here.
    #[inline]
    pub(super) fn locate(&self, p: Point) -> Option<Spot> {
        let along = dot(self.heading, p);
        let n = left_of(self.heading);
        let aside = dot(n, p);
        match self.kind {
            Kind::Segment => {
                if along < -self.slack || along > self.length + self.slack {
                    return None;
                }
                let share = (along * self.per_length).clamp(0.0, 1.0);
                let (side, away) = if aside >= 0.0 { (LEFT, n) } else { (RIGHT, [-n[0], -n[1]]) };
                Some(Spot { share, distance: aside.abs(), side, away })
            }
            Kind::Sector(_) | Kind::Cusp => {
                if along < -self.slack || dot(self.next, p) > self.slack {
                    return None;
                }
                let distance = norm(p);
                let away = if distance > 0.0 { times(p, 1.0 / distance) } else { [0.0; 2] };
                let side = match self.kind {
                    Kind::Sector(side) => side,
                    _ if aside >= 0.0 => LEFT,
                    _ => RIGHT,
                };
                Some(Spot { share: 0.0, distance, side, away })
            }
            Kind::Dot => {
                let inside = p[0] >= self.min[0]
                    && p[0] <= self.max[0]
                    && p[1] >= self.min[1]
                    && p[1] <= self.max[1];
                inside.then(|| Spot { share: 0.0, distance: norm(p), side: LEFT, away: [0.0; 2] })
            }
        }
    }
}

impl Border {
    /// No border at all.
    fn default_open() -> Self {
        Self::new(0.0, 0.0, 1.0)
    }
}

fn bounds(points: &[Point], slack: f64) -> (Point, Point) {
    let mut both = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for k in 0..2 {
            both.0[k] = both.0[k].min(p[k] - slack);
            both.1[k] = both.1[k].max(p[k] + slack);
        }
    }
    both
}
