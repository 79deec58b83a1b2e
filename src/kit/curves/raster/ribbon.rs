//! A curve made ready for the raster: its parts of the ground with the values that hold there.

use super::shape::{Bend, Kind, LEFT, RIGHT, Shape};
use super::stock::{MAX_PARTS, Window};
use crate::kit::curves::flatten::Vertex;
use crate::value::Curve;
use crate::value::curves::bezier::{Point, norm, sub, times};
use crate::value::curves::{Track, hermite_value};

/// A value that goes linearly along a segment: at its start, and its change up to the end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Linear {
    pub(super) start: f64,
    change: f64,
}

impl Linear {
    fn new([start, end]: [f64; 2]) -> Self {
        Self { start, change: end - start }
    }

    #[inline]
    pub(super) fn at(self, share: f64) -> f64 {
        self.start + self.change * share
    }
}

/// The tangent of an angle that goes linearly along a segment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Steepness {
    angle: Linear,
    start: f64,
}

impl Steepness {
    fn new(degrees: [f64; 2]) -> Self {
        let angle = Linear::new(degrees.map(f64::to_radians));
        Self { angle, start: libm::tan(angle.start) }
    }

    #[inline]
    pub(super) fn at(self, share: f64) -> f64 {
        let x = self.angle.change * share;
        if x == 0.0 {
            return self.start;
        }
        if x.abs() > 0.1 {
            return libm::tan(self.angle.start + x);
        }
        // tan(α + x) by the sum of tangents, tan x by its series: 2e-11 off at 0.1.
        let y = x * x;
        let t = x * (1.0 + y * (1.0 / 3.0 + y * (2.0 / 15.0 + y * (17.0 / 315.0))));
        (self.start + t) / (1.0 - self.start * t)
    }
}

/// One part of the ground beside a curve.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) shape: Shape,
    /// Length of the curve up to its start, in metres.
    pub(super) arc: f64,
    /// Half the width of the thinnest line of cells that holds together, in metres.
    pub(super) thin: f64,
    /// A cell, in metres.
    pub(super) cell: f64,
    pub(super) radius: Linear,
    pub(super) extent: [Linear; 2],
    pub(super) steepness: [Steepness; 2],
    height: [f64; 2],
    height_slope: [f64; 2],
    pub(super) noise: [Linear; 2],
}

impl Part {
    #[inline]
    pub(super) fn height(&self, share: f64) -> f64 {
        hermite_value(self.height, self.height_slope, share)
    }

    /// What the ground rises from the curve to a distance on a side; beyond the slope no further.
    pub(super) fn rise(&self, side: usize, share: f64, distance: f64) -> f64 {
        let extent = self.extent[side].at(share);
        if extent <= 0.0 {
            return 0.0;
        }
        let x = (distance - self.radius.at(share)).clamp(0.0, extent);
        self.steepness[side].at(share) * x * (1.0 - 0.5 * x / extent)
    }

    /// How high the ground is at a distance from the curve on a side.
    pub(super) fn ground(&self, side: usize, share: f64, distance: f64) -> f64 {
        self.height(share) + self.rise(side, share, distance)
    }

    /// Whether the ground falls on a side, and rises or stays level on the other: the low side of a cliff.
    pub(super) fn falls_across(&self, side: usize, share: f64) -> bool {
        let angle = |side: usize| self.steepness[side].angle.at(share);
        let (here, there) = (angle(side), angle(1 - side));
        (here < 0.0 && there >= 0.0) || (here == 0.0 && there > 0.0)
    }
}

/// A curve made ready.
#[derive(Clone, Debug)]
pub(super) struct Ribbon {
    pub(super) parts: Vec<Part>,
    pub(super) has_height: bool,
    /// Whether its plateau has an edge with free ground beyond it somewhere.
    pub(super) has_edge: bool,
    pub(super) has_slope: bool,
    pub(super) has_noise: bool,
    /// A cell, in metres.
    pub(super) cell: f64,
    /// Length of the curve, in metres; without end where it is closed.
    pub(super) length: f64,
}

/// What holds at a corner of the polyline.
#[derive(Clone, Copy, Debug, Default)]
struct Station {
    radius: f64,
    slope: [f64; 4],
    noise: [f64; 2],
}

/// A segment of the polyline with the corners it goes between.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) from: Vertex,
    pub(super) to: Vertex,
    pub(super) heading: Point,
}

/// The segments of a polyline, those without length left out.
pub(super) fn legs(line: &[Vertex]) -> Vec<Leg> {
    let mut legs: Vec<Leg> = Vec::with_capacity(line.len());
    let mut from = line[0];
    for &to in &line[1..] {
        let along = sub(to.at, from.at);
        let length = norm(along);
        if length > 0.0 {
            legs.push(Leg { from, to, heading: times(along, 1.0 / length) });
            from = to;
        }
    }
    legs
}

/// The bends before, between and after segments; `None` where one is so sharp that it needs a sector of its own.
fn joins(legs: &[Leg], closed: bool) -> Vec<Option<Bend>> {
    let straight = Some(Bend::default());
    let around = match (legs.first(), legs.last()) {
        (Some(first), Some(last)) if closed => Bend::between(last.heading, first.heading),
        _ => straight,
    };
    let between = legs.windows(2).map(|w| Bend::between(w[0].heading, w[1].heading));
    std::iter::once(around).chain(between).chain(std::iter::once(around)).collect()
}

/// Whether the plateau of a curve has an edge with free ground beyond it somewhere: no slope, or none of any extent.
pub(super) fn has_edge(curve: &Curve) -> bool {
    let bare = |t: &Track<4>| t.keys().iter().any(|(_, [left, right, ..])| *left <= 0.0 || *right <= 0.0);
    curve.tracks().elevation.is_some() && curve.tracks().slope.as_ref().is_none_or(bare)
}

/// The axis that a heading follows most, and its direction along it.
fn course([x, y]: Point) -> (bool, bool) {
    let flat = x.abs() >= y.abs();
    (flat, if flat { x > 0.0 } else { y > 0.0 })
}

impl Ribbon {
    /// Whether it marks cells with values.
    #[inline]
    pub(super) fn is_strict(&self) -> bool {
        self.has_height || self.has_noise
    }

    /// The parts of a curve that a window sees; those beyond the most at once are left out.
    pub(super) fn new(curve: &Curve, line: &[Vertex], cell: f64, window: &Window) -> Self {
        let t = curve.tracks();
        let mut ribbon = Self {
            parts: Vec::new(),
            has_height: t.elevation.is_some(),
            has_edge: has_edge(curve),
            has_slope: t.slope.is_some(),
            has_noise: t.noise.is_some(),
            cell,
            length: if curve.is_closed() { f64::INFINITY } else { curve.length() },
        };
        if !(ribbon.has_height || ribbon.has_slope || ribbon.has_noise) {
            return ribbon;
        }
        let legs = legs(line);
        let strict = ribbon.is_strict();
        // Half the diagonal of a cell; beside a height, the step in which its edge is seen.
        let least = if ribbon.has_height { cell } else { 0.708 * cell };
        let least = if strict { least } else { 0.0 };
        let builder = Builder { curve, cell, slack: super::SLACK * cell, least };
        let (Some(first), Some(last)) = (legs.first(), legs.last()) else { return ribbon };
        let closed = curve.is_closed();
        let parts = &mut ribbon.parts;
        let mut take = |part: Option<Part>| {
            if parts.len() <= MAX_PARTS {
                parts.extend(part.filter(|p| window.meets(&p.shape)));
            }
        };
        if strict && !closed {
            take(builder.dot(&first.from));
        }
        let joins = joins(&legs, closed);
        for (i, leg) in legs.iter().enumerate() {
            take(builder.segment(leg, [joins[i], joins[i + 1]].map(Option::unwrap_or_default)));
            let next = legs.get(i + 1).or(closed.then_some(first));
            if let Some(next) = next {
                if joins[i + 1].is_none() {
                    take(builder.sector(leg, next));
                }
                if strict && (joins[i + 1].is_none() || course(leg.heading) != course(next.heading)) {
                    take(builder.dot(&leg.to));
                }
            }
        }
        if strict && !closed {
            take(builder.dot(&last.to));
        }
        ribbon.parts.shrink_to_fit();
        ribbon
    }
}

struct Builder<'a> {
    curve: &'a Curve,
    cell: f64,
    slack: f64,
    /// Least width of a part beside its plateau, so that it holds the thinnest line and what lies at its edge.
    least: f64,
}

impl Builder<'_> {
    fn station(&self, u: f64) -> Station {
        let t = self.curve.tracks();
        Station {
            radius: t.elevation.as_ref().map_or(0.0, |t| t.at(u)[1]),
            slope: t.slope.as_ref().map_or([0.0; 4], |t| t.at(u)),
            noise: t.noise.as_ref().map_or([0.0; 2], |t| t.at(u)),
        }
    }

    /// Half the width at which a line of this heading takes at least one cell of every column, or of every row: half a
    /// cell, and a little more, since at a gentle bend the nearest cell of a column may lose its foot to the neighbour.
    fn thin(&self, [x, y]: Point) -> f64 {
        0.53 * self.cell * x.abs().max(y.abs())
    }

    fn part(&self, shape: Shape, thin: f64, from: &Vertex, to: &Vertex) -> Part {
        let (a, b) = (self.station(from.u), self.station(to.u));
        let pair = |f: fn(&Station) -> f64| Linear::new([f(&a), f(&b)]);
        let (mut height, mut height_slope) = ([0.0; 2], [0.0; 2]);
        if let Some(profile) = self.curve.profile() {
            let (low, high) = (profile.at(from.u, false), profile.at(to.u, true));
            let width = to.u - from.u;
            height = [low[0], high[0]];
            height_slope = [low[1] * width, high[1] * width];
        }
        Part {
            shape,
            arc: from.arc,
            thin,
            cell: self.cell,
            radius: pair(|s| s.radius),
            extent: [pair(|s| s.slope[0]), pair(|s| s.slope[1])],
            steepness: [Steepness::new([a.slope[2], b.slope[2]]), Steepness::new([a.slope[3], b.slope[3]])],
            height,
            height_slope,
            noise: [pair(|s| s.noise[0]), pair(|s| s.noise[1])],
        }
    }

    fn segment(&self, leg: &Leg, bends: [Bend; 2]) -> Option<Part> {
        let thin = self.thin(leg.heading);
        let (a, b) = (self.station(leg.from.u), self.station(leg.to.u));
        let width = |side: usize| [a, b].map(|s| s.radius + s.slope[side].max(self.least));
        let shape = Shape::segment(leg.from.at, leg.to.at, [width(LEFT), width(RIGHT)], bends, self.slack)?;
        Some(self.part(shape, thin, &leg.from, &leg.to))
    }

    fn sector(&self, leg: &Leg, next: &Leg) -> Option<Part> {
        let thin = self.thin(leg.heading).max(self.thin(next.heading));
        let s = self.station(leg.to.u);
        let reach = [LEFT, RIGHT].map(|side| s.radius + s.slope[side].max(self.least));
        let shape = Shape::sector(leg.to.at, leg.heading, next.heading, reach, self.slack)?;
        Some(self.part(shape, thin, &leg.to, &leg.to))
    }

    /// The cells nearest to a corner; `None` where the plateau holds them anyhow.
    fn dot(&self, at: &Vertex) -> Option<Part> {
        (self.station(at.u).radius < self.cell).then(|| {
            let shape = Shape::dot(at.at, 0.5 * self.cell, self.slack);
            // Every cell that the shape locates counts.
            self.part(shape, self.cell, at, at)
        })
    }
}

/// One part of the smoothed strip around a curve.
#[derive(Clone, Debug)]
pub(super) struct Rim {
    pub(super) shape: Shape,
    /// Distance of its edge from the curve.
    pub(super) reach: [Linear; 2],
    /// How much of that lies beyond the slope.
    width: [Linear; 2],
    /// Length of the half ellipse beyond an end; 0 elsewhere.
    cap: f64,
}

impl Rim {
    /// The parts of a curve's envelope that a window sees; those beyond the most at once are left out.
    pub(super) fn all(curve: &Curve, line: &[Vertex], cell: f64, window: &Window) -> Vec<Self> {
        let t = curve.tracks();
        let Some(envelope) = &t.envelope else { return Vec::new() };
        let slack = super::SLACK * cell;
        let widths = |u: f64| envelope.at(u);
        let reach = |u: f64, side: usize| {
            let radius = t.elevation.as_ref().map_or(0.0, |t| t.at(u)[1]);
            radius + t.slope.as_ref().map_or(0.0, |t| t.at(u)[side]) + widths(u)[side]
        };
        let rim = |shape: Shape, [a, b]: [f64; 2], cap: f64| Self {
            shape,
            reach: [LEFT, RIGHT].map(|k| Linear::new([reach(a, k), reach(b, k)])),
            width: [LEFT, RIGHT].map(|k| Linear::new([widths(a)[k], widths(b)[k]])),
            cap,
        };
        let legs = legs(line);
        let (Some(first), Some(last)) = (legs.first(), legs.last()) else { return Vec::new() };
        let closed = curve.is_closed();
        let mut rims: Vec<Self> = Vec::new();
        let mut take = |rim: Option<Self>| {
            if rims.len() <= MAX_PARTS {
                rims.extend(rim.filter(|r| window.meets(&r.shape)));
            }
        };
        let joins = joins(&legs, closed);
        for (i, leg) in legs.iter().enumerate() {
            let (a, b) = (leg.from.u, leg.to.u);
            let sides = [LEFT, RIGHT].map(|k| [reach(a, k), reach(b, k)]);
            let bends = [joins[i], joins[i + 1]].map(Option::unwrap_or_default);
            let shape = Shape::segment(leg.from.at, leg.to.at, sides, bends, slack);
            take(shape.map(|s| rim(s, [a, b], 0.0)));
            let next = legs.get(i + 1).or(closed.then_some(first));
            if let (Some(next), None) = (next, joins[i + 1]) {
                let around = [LEFT, RIGHT].map(|k| reach(b, k));
                let shape = Shape::sector(leg.to.at, leg.heading, next.heading, around, slack);
                take(shape.map(|s| rim(s, [b, b], 0.0)));
            }
        }
        if !closed {
            let ends = [(&first.from, times(first.heading, -1.0), true), (&last.to, last.heading, false)];
            for (end, out, swapped) in ends {
                let length = 0.5 * (widths(end.u)[LEFT] + widths(end.u)[RIGHT]);
                let tip = [end.at[0] + out[0] * length, end.at[1] + out[1] * length];
                // Looking out of the start, left and right change places.
                let side = |k: usize| if swapped { 1 - k } else { k };
                let sides = [LEFT, RIGHT].map(|k| [reach(end.u, side(k)); 2]);
                let Some(shape) = Shape::segment(end.at, tip, sides, Default::default(), slack) else {
                    continue;
                };
                let mut cap = rim(shape, [end.u, end.u], length);
                if swapped {
                    cap.reach.swap(LEFT, RIGHT);
                    cap.width.swap(LEFT, RIGHT);
                }
                take(Some(cap));
            }
        }
        rims.shrink_to_fit();
        rims
    }

    /// How deep a point lies in the smoothed strip: 0 outside and on its edge, 1 from `feather` of the strip's width
    /// inwards; without a feather 1 right from the edge.
    pub(super) fn weight(&self, p: Point, feather: f64, slack: f64) -> f64 {
        let Some(spot) = self.shape.locate(p) else { return 0.0 };
        let (reach, width) = (self.reach[spot.side].at(spot.share), self.width[spot.side].at(spot.share));
        let (depth, width) = if self.cap > 0.0 && self.shape.kind == Kind::Segment {
            let along = spot.share;
            let aside = if reach > 0.0 { spot.distance / reach } else { 0.0 };
            let radius = (along * along + aside * aside).sqrt();
            // Along the ray from the end of the curve.
            let metres = (along * self.cap) * (along * self.cap) + spot.distance * spot.distance;
            let metres = metres.sqrt();
            let to_edge = if radius > 0.0 { metres / radius } else { self.cap };
            let turn = if radius > 0.0 { along * along / (radius * radius) } else { 0.0 };
            (to_edge * (1.0 - radius), width + (self.cap - width) * turn)
        } else {
            (reach - spot.distance, width)
        };
        if depth < -slack {
            return 0.0;
        }
        let feathered = feather * width;
        if feathered <= 0.0 || depth >= feathered {
            return 1.0;
        }
        let x = (depth / feathered).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}
