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

/// A border: `a x + b y + c ≥ 0` for one of two lines, relative to the start of the shape.
#[derive(Clone, Copy, Debug)]
struct Border {
    lines: [Line; 2],
    /// Whether a scan line crosses both lines in the same direction, so that it says where the border is.
    crosses: bool,
}

/// `a x + b y + c`, ready for scan lines along one of the axes.
#[derive(Clone, Copy, Debug)]
struct Line {
    normal: Point,
    c: f64,
    /// A scan line at `v` across the axis crosses it at `slope · v + at` along it.
    slope: f64,
    at: f64,
}

impl Line {
    fn new(axis: usize, normal: Point, c: f64) -> Self {
        let (along, across) = (normal[axis], normal[1 - axis]);
        Self { normal, c, slope: -across / along, at: -c / along }
    }

    /// Whether it is too near to the direction of a scan line to say where it crosses.
    fn is_flat(&self, axis: usize) -> bool {
        self.normal[axis].abs() <= 1e-7 * self.normal[1 - axis].abs() || self.normal[axis] == 0.0
    }

    fn at(&self, p: Point) -> f64 {
        dot(self.normal, p) + self.c
    }
}

impl Border {
    fn new(axis: usize, normal: Point, c: f64) -> Self {
        Self::either(axis, [Line::new(axis, normal, c); 2])
    }

    /// What is on the inner side of one of two lines at least.
    fn either(axis: usize, lines: [Line; 2]) -> Self {
        let [p, q] = lines;
        let same = (p.normal[axis] > 0.0) == (q.normal[axis] > 0.0);
        Self { lines, crosses: !p.is_flat(axis) && !q.is_flat(axis) && same }
    }

    /// No border at all.
    fn none() -> Self {
        Self::new(0, [0.0; 2], 1.0)
    }
}

/// A part of the ground, convex but for a round edge.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) kind: Kind,
    /// The axis that scan lines go along: that of its longer side, so that there are few. 0 for rows, 1 for columns.
    pub(super) axis: usize,
    /// Start of the segment, or the corner.
    pub(super) from: Point,
    /// Heading of the segment; at a corner that of the segment before.
    pub(super) heading: Point,
    /// Heading of the segment after a corner.
    next: Point,
    pub(super) length: f64,
    /// One over the length.
    pub(super) per_length: f64,
    borders: [Border; 4],
    /// At the start and end of a segment, what it has of the sector beyond.
    bends: [Bend; 2],
    /// Radius that contains a sector.
    reach: f64,
    /// Bounds relative to `from`.
    pub(super) min: Point,
    pub(super) max: Point,
    /// What counts as touching, in metres.
    slack: f64,
}

/// Half of the narrow sector beyond an end of a segment, at the outside of the bend there. The other half belongs to
/// the neighbour, which saves going through many thin sectors of their own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bend {
    /// 1 where the outside is the left, −1 where it is the right, 0 where there is no bend.
    out: f64,
    /// Tangent of half the turn.
    tan: f64,
}

/// Sharpest turn, as a tangent of its half, that is shared by its neighbours: 12°.
const GENTLE: f64 = 0.105;

impl Bend {
    /// The bend between two headings; `None` where it is so sharp that it needs a sector of its own.
    pub(super) fn between(t: Point, next: Point) -> Option<Self> {
        let (turn, cos) = (dot(left_of(t), next), dot(t, next));
        let tan = turn.abs() / (1.0 + cos);
        let gentle = cos > 0.0 && tan <= GENTLE;
        gentle.then_some(Self { out: if turn > 0.0 { -1.0 } else { 1.0 }, tan })
    }
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
    /// Whether its foot is a corner, seen from the outside of the bend.
    pub(super) at_corner: bool,
}

impl Shape {
    /// The ground beside a segment; its widths at start and end on the left and right, and the bends there.
    pub(super) fn segment(
        from: Point,
        to: Point,
        widths: [[f64; 2]; 2],
        bends: [Bend; 2],
        slack: f64,
    ) -> Option<Self> {
        let along = sub(to, from);
        let length = norm(along);
        if length <= 0.0 {
            return None;
        }
        let t = times(along, 1.0 / length);
        let n = left_of(t);
        let [[l0, l1], [r0, r1]] = widths;
        let longer = if length > l0.max(l1) + r0.max(r1) { t } else { n };
        let axis = usize::from(longer[1].abs() > longer[0].abs());
        let (l, r) = ((l1 - l0) / length, (r1 - r0) / length);
        // How far the half sectors lean out.
        let lean = |b: &Bend| b.tan * if b.out > 0.0 { l0.max(l1) } else { r0.max(r1) };
        let lean = [lean(&bends[0]), lean(&bends[1])];
        let most = lean[0].max(lean[1]);
        let end = |k: usize, sign: f64, c: f64| {
            let b = bends[k];
            let lean = b.tan * b.out;
            let square = Line::new(axis, times(t, sign), c);
            let leaning = Line::new(axis, [sign * t[0] + lean * n[0], sign * t[1] + lean * n[1]], c);
            Border::either(axis, [square, if b.tan > 0.0 { leaning } else { square }])
        };
        let wide = |tilt: f64, out: f64| [tilt * t[0] + out * n[0], tilt * t[1] + out * n[1]];
        let borders = [
            end(0, 1.0, slack),
            end(1, -1.0, length + slack),
            Border::new(axis, wide(l, -1.0), l0 + slack + l.abs() * (slack + most)),
            Border::new(axis, wide(r, 1.0), r0 + slack + r.abs() * (slack + most)),
        ];
        let corner = |base: Point, ahead: f64, aside: f64| add(base, add(times(t, ahead), times(n, aside)));
        let (left, right) = (
            |b: &Bend, x: f64| if b.out > 0.0 { x } else { 0.0 },
            |b: &Bend, x: f64| {
                if b.out < 0.0 { x } else { 0.0 }
            },
        );
        let corners = [
            corner([0.0; 2], -left(&bends[0], lean[0]), l0 + slack),
            corner([0.0; 2], -right(&bends[0], lean[0]), -r0 - slack),
            corner(along, left(&bends[1], lean[1]), l1 + slack),
            corner(along, right(&bends[1], lean[1]), -r1 - slack),
        ];
        let (min, max) = bounds(&corners, slack);
        let reach = f64::INFINITY;
        let kind = Kind::Segment;
        Some(Self {
            kind,
            axis,
            from,
            heading: t,
            next: t,
            length,
            per_length: 1.0 / length,
            bends,
            borders,
            reach,
            min,
            max,
            slack,
        })
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
        // The middle of the sector points along the difference of the headings.
        let middle = sub(t, next);
        let axis = usize::from(middle[1].abs() > middle[0].abs());
        let borders = [
            Border::new(axis, t, slack),
            Border::new(axis, times(next, -1.0), slack),
            Border::none(),
            Border::none(),
        ];
        let bends = [Bend::default(); 2];
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
        Some(Self {
            kind,
            axis,
            from: at,
            heading: t,
            next,
            length: 0.0,
            per_length: 0.0,
            bends,
            borders,
            reach,
            min,
            max,
            slack,
        })
    }

    /// The cells within half a cell of a point, along both axes.
    pub(super) fn dot(at: Point, half: f64, slack: f64) -> Self {
        let (min, max) = ([-half - slack; 2], [half + slack; 2]);
        let borders = [Border::none(); 4];
        let reach = f64::INFINITY;
        let heading = [1.0, 0.0];
        let (kind, length, bends) = (Kind::Dot, 0.0, [Bend::default(); 2]);
        Self {
            kind,
            axis: 0,
            from: at,
            heading,
            next: heading,
            length,
            per_length: 0.0,
            bends,
            borders,
            reach,
            min,
            max,
            slack,
        }
    }

    /// Whether a rectangle, relative to the start, may hold a point of it.
    pub(super) fn touches(&self, min: Point, max: Point) -> bool {
        if (0..2).any(|k| min[k] > self.max[k] || max[k] < self.min[k]) {
            return false;
        }
        // A border shuts the rectangle out when its best corner is outside.
        let holds = |line: &Line| {
            line.at(std::array::from_fn(|k| if line.normal[k] > 0.0 { max[k] } else { min[k] })) >= 0.0
        };
        self.borders.iter().all(|b| b.lines.iter().any(holds))
    }

    /// The range along the axis, relative to the start, that a scan line at `v` has in it, a hair too wide at most.
    #[inline]
    pub(super) fn span(&self, v: f64) -> Option<[f64; 2]> {
        let u = self.axis;
        let [mut low, mut high] = [self.min[u], self.max[u]];
        if self.reach < f64::INFINITY {
            let square = self.reach * self.reach - v * v;
            let half = if square > 0.0 { square.sqrt() } else { 0.0 };
            low = low.max(-half);
            high = high.min(half);
        }
        for b in &self.borders {
            let [p, q] = &b.lines;
            if b.crosses {
                let (p_at, q_at) = (p.slope * v + p.at, q.slope * v + q.at);
                if p.normal[u] > 0.0 {
                    low = low.max(p_at.min(q_at));
                } else {
                    high = high.min(p_at.max(q_at));
                }
            } else {
                let point = |along: f64| if u == 0 { [along, v] } else { [v, along] };
                let outside = |along: f64| p.at(point(along)) < 0.0 && q.at(point(along)) < 0.0;
                if outside(self.min[u]) && outside(self.max[u]) {
                    return None;
                }
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
                let (side, away) = if aside >= 0.0 { (LEFT, n) } else { (RIGHT, [-n[0], -n[1]]) };
                let distance = aside.abs();
                let over = if along < 0.0 { -along } else { along - self.length };
                if over <= self.slack {
                    let share = (along * self.per_length).clamp(0.0, 1.0);
                    return Some(Spot { share, distance, side, away, at_corner: false });
                }
                let first = along < 0.0;
                let bend = &self.bends[usize::from(!first)];
                if aside * bend.out <= 0.0 || over > distance * bend.tan + self.slack {
                    return None;
                }
                // The foot is the corner.
                let ahead = if first { -over } else { over };
                let distance = (over * over + aside * aside).sqrt();
                let away = times(add(times(self.heading, ahead), times(n, aside)), 1.0 / distance);
                Some(Spot { share: if first { 0.0 } else { 1.0 }, distance, side, away, at_corner: true })
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
                Some(Spot { share: 0.0, distance, side, away, at_corner: true })
            }
            Kind::Dot => {
                let inside =
                    p[0] >= self.min[0] && p[0] <= self.max[0] && p[1] >= self.min[1] && p[1] <= self.max[1];
                let (distance, at_corner) = (norm(p), false);
                let away = if distance > 0.0 { times(p, 1.0 / distance) } else { [0.0; 2] };
                inside.then_some(Spot { share: 0.0, distance, side: LEFT, away, at_corner })
            }
        }
    }
}

fn bounds(points: &[Point], slack: f64) -> (Point, Point) {
    let mut both = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        both.0 = [both.0[0].min(p[0] - slack), both.0[1].min(p[1] - slack)];
        both.1 = [both.1[0].max(p[0] + slack), both.1[1].max(p[1] + slack)];
    }
    both
}
