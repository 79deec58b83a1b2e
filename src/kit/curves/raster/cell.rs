//! What one curve, and then all curves together, say about one cell.

use super::ribbon::{Part, Ribbon};
use super::shape::{Kind, LEFT, RIGHT, Spot};
use crate::value::curves::bezier::{dot, left_of, norm};

/// Height, amplitude and roughness.
type Values = [f64; 3];

/// What the plateaus of one curve say about a cell, while its parts are gone through in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Strict {
    branch: Branch,
    /// Sums over the branches that are done and mark the cell, and their number.
    sum: Values,
    branches: f64,
    /// How many of these hold it on their plateaus.
    held: f32,
    edges: Edges,
}

/// One passage of the curve by a cell whose plateau holds the cell, or ends beside it.
#[derive(Clone, Copy, Debug, Default)]
struct Branch {
    /// Parts that are equally near, and the sum of what they say; 0 for no branch.
    ties: f64,
    distance: f64,
    sum: Values,
    /// How far beyond the edge of the plateau the cell lies, where the ground there is free; else 0.
    gap: f64,
    /// Sum of the directions away.
    away: [f64; 2],
    /// Whether it marks the cell as one of its plateau, or of its line.
    marks: bool,
    /// Length of the curve up to the last foot, and how far that was.
    arc: f64,
    last: f64,
}

/// The gradient of the nearest of the parts of one curve whose slopes hold a cell; of parts that are equally near
/// the sums. Small, since it is what filling a tile spends its time on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) distance: f64,
    direction: [f32; 2],
    steepness: f32,
    trust: f32,
    ties: f32,
    /// Number of the nearest part.
    pub(super) part: u32,
}

/// What the plateaus of all curves say about a cell: sums and how many.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    pub(super) height: f64,
    pub(super) noise: [f64; 2],
    pub(super) heights: f32,
    pub(super) noises: f32,
    /// How many of the heights are of plateaus that hold the cell.
    held: f32,
    edges: Edges,
}

/// The plateaus that end within a step of a cell, with free ground beyond: sums with weights one over the gap.
#[derive(Clone, Copy, Debug, Default)]
struct Edges {
    weight: f64,
    height: f64,
    away: [f64; 2],
    lean: [f64; 2],
}

impl Edges {
    fn is_some(&self) -> bool {
        self.weight > 0.0
    }

    /// Takes up an edge; the step to the neighbours along the direction away is `cell / (|n_x| + |n_y|)`.
    fn add(&mut self, height: f64, gap: f64, away: [f64; 2], cell: f64) {
        let weight = 1.0 / gap;
        let step = cell / (away[0].abs() + away[1].abs()).max(1.0);
        let share = gap / (gap + step);
        let [x, y] = away;
        let (away, lean) = ([x * weight, y * weight], [x * weight * share, y * weight * share]);
        self.join(&Self { weight, height: height * weight, away, lean });
    }

    fn join(&mut self, other: &Self) {
        self.weight += other.weight;
        self.height += other.height;
        for k in 0..2 {
            self.away[k] += other.away[k];
            self.lean[k] += other.lean[k];
        }
    }

    /// The height, linear between edges on two sides, and the lean, where all are on one side.
    fn mean(&self) -> (f64, [f64; 2]) {
        let one_side = norm(self.away) > 0.5 * self.weight;
        let lean = if one_side { self.lean.map(|x| x / self.weight) } else { [0.0; 2] };
        (self.height / self.weight, lean)
    }
}

/// How much longer than the farther of two distances the way between two feet may be for both to be one branch: a
/// half circle has π.
const WINDING: f64 = 4.0;

/// Over how long a way to the end of a curve trust in its slope fades, as a share of the distance from its plateau.
const ENDS: f64 = 1.0;
/// Over which share of a slope, beside free ground, trust in it fades.
const SIDES: f64 = 0.2;

/// What a part of a curve is to a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// It does not reach it.
    Beyond,
    /// The cell lies on its plateau.
    Plateau,
    /// The cell lies within a step of the edge of its plateau, on free ground.
    Edge,
    /// The cell lies on its slope.
    Slope,
    /// The cell lies on the line of a curve without elevation and beside it, too.
    Both,
}

impl Part {
    /// The spot of a cell that is right beside a segment, beyond its plateau and on its slope; the short way for what
    /// `locate` and `reach` find for it, too.
    #[inline(always)]
    pub(super) fn plain_slope(&self, at: [f64; 2], slack: f64) -> Option<Spot> {
        let shape = &self.shape;
        if shape.kind != Kind::Segment {
            return None;
        }
        let n = left_of(shape.heading);
        let (along, aside) = (dot(shape.heading, at), dot(n, at));
        let share = along * shape.per_length;
        let distance = aside.abs();
        let left = aside >= 0.0;
        let side = if left { LEFT } else { RIGHT };
        let radius = self.radius.at(share);
        let extent = self.extent[side].at(share);
        let inside = along >= 0.0 && share <= 1.0;
        let beyond = distance > radius.max(self.thin) + slack;
        // Where it touches the edge the long way decides.
        if !(inside && beyond && extent > slack && distance - radius <= extent) {
            return None;
        }
        let away = if left { n } else { [-n[0], -n[1]] };
        Some(Spot { share, distance, side, away, at_corner: false })
    }
}

impl Ribbon {
    /// What a part is to a cell at a spot.
    #[inline(always)]
    pub(super) fn reach(&self, part: &Part, spot: &Spot, slack: f64) -> Reach {
        let d = spot.distance;
        let radius = part.radius.at(spot.share);
        let dot = part.shape.kind == Kind::Dot;
        // From a corner the nearest cell of a column or row may be farther than from a line.
        let most = spot.away[0].abs().max(spot.away[1].abs());
        let thin = if spot.at_corner { 0.5 * part.cell / most } else { part.thin };
        let flat = self.is_strict() && (d <= radius.max(thin) + slack || dot);
        if flat && (self.has_height || dot) {
            return Reach::Plateau;
        }
        let extent = part.extent[spot.side].at(spot.share);
        if self.has_edge && extent <= slack && d - radius <= part.cell * most {
            return Reach::Edge;
        }
        // On the very line it is not said on which side a cell is.
        let slope = self.has_slope && extent > slack && d - radius <= extent + slack && d > slack;
        match (flat, slope) {
            (false, false) => Reach::Beyond,
            (true, false) => Reach::Plateau,
            (false, true) => Reach::Slope,
            (true, true) => Reach::Both,
        }
    }

    /// Whether heights flow away from the curve at a spot. Without an elevation they flow towards it, but on the low
    /// side of a cliff: there they go on, so that the wall is one.
    #[inline(always)]
    fn flows_away(&self, part: &Part, spot: &Spot) -> bool {
        self.has_height || part.falls_across(spot.side, spot.share)
    }
}

impl Part {
    /// How far the slope at a spot is followed: less towards its side where heights flow out, and towards the ends of the
    /// curve the less the farther out, so that no line shows where it stops.
    #[inline(always)]
    pub(super) fn trust(&self, spot: &Spot, ribbon: &Ribbon) -> f64 {
        let smooth = |t: f64| if t >= 1.0 { 1.0 } else { t * t * (3.0 - 2.0 * t) };
        let x = (spot.distance - self.radius.at(spot.share)).max(0.0);
        let arc = self.arc + spot.share * self.shape.length;
        let end = arc.min(ribbon.length - arc).max(0.0);
        let along = if end < ENDS * x { smooth(end / (ENDS * x)) } else { 1.0 };
        let left = (1.0 - x / self.extent[spot.side].at(spot.share)).max(0.0);
        let across = if ribbon.has_height && left < SIDES { smooth(left / SIDES) } else { 1.0 };
        along * across
    }

    /// Mean steepness away from the curve over the step to a spot from the neighbours that heights flow from: across a
    /// step of `cell · |n|` along each axis the ground rises by just what the profile does, wherever the plateau ends
    /// between samples.
    #[inline(always)]
    pub(super) fn steepness(&self, spot: &Spot, flows_away: bool) -> f64 {
        let n = spot.away.map(f64::abs);
        let (side, share) = (spot.side, spot.share);
        let extent = self.extent[side].at(share);
        let x = spot.distance - self.radius.at(share);
        let most = self.cell * n[0].max(n[1]);
        let whole = if flows_away { x >= most && x <= extent } else { x >= 0.0 && x + most <= extent };
        if whole {
            let half = 0.5 * self.cell * (n[0] * n[0] * n[0] + n[1] * n[1] * n[1]);
            let middle = if flows_away { x - half } else { x + half };
            return self.steepness[side].at(share) * (1.0 - middle / extent);
        }
        let here = self.rise(side, share, spot.distance);
        let step = |n: f64| {
            if flows_away {
                let from = spot.distance - self.cell * n;
                let (side, from) = if from < 0.0 { (1 - side, -from) } else { (side, from) };
                n * (here - self.rise(side, share, from))
            } else {
                n * (self.rise(side, share, spot.distance + self.cell * n) - here)
            }
        };
        (step(n[0]) + step(n[1])) / self.cell
    }
}

impl Nearest {
    /// No part yet.
    pub(super) const NOTHING: Self =
        Self { distance: f64::INFINITY, direction: [0.0; 2], steepness: 0.0, trust: 0.0, ties: 0.0, part: 0 };

    /// Whether there is a part.
    #[inline(always)]
    pub(super) fn is_some(&self) -> bool {
        self.ties > 0.0
    }

    /// Takes up what a part says at a spot.
    #[inline(always)]
    pub(super) fn meet(&mut self, ribbon: &Ribbon, number: u32, spot: &Spot, slack: f64) {
        if spot.distance > self.distance + slack {
            return;
        }
        let part = &ribbon.parts[number as usize];
        let flows_away = ribbon.flows_away(part, spot);
        // Both are turned round where heights flow towards the curve.
        let sign = if flows_away { 1.0 } else { -1.0 };
        let steepness = (sign * part.steepness(spot, flows_away)) as f32;
        let trust = part.trust(spot, ribbon) as f32;
        let direction = spot.away.map(|x| (sign * x) as f32);
        if spot.distance < self.distance - slack {
            *self = Self { distance: spot.distance, direction, steepness, trust, ties: 1.0, part: number };
        } else {
            self.distance = self.distance.min(spot.distance);
            self.direction = [self.direction[0] + direction[0], self.direction[1] + direction[1]];
            self.steepness += steepness;
            self.trust += trust;
            self.ties += 1.0;
        }
    }

    /// Direction and steepness of the equally near parts together: what each says along their common direction; `None`
    /// where they contradict each other.
    #[inline]
    pub(super) fn mean(&self) -> Option<([f32; 2], f32, f32)> {
        if self.ties == 1.0 {
            return Some((self.direction, self.steepness, self.trust));
        }
        let length = norm(self.direction.map(f64::from)) as f32;
        let share = length / self.ties;
        let steepness = self.steepness / self.ties * share;
        (share > 1e-6).then(|| (self.direction.map(|x| x / length), steepness, self.trust / self.ties))
    }
}

impl Strict {
    /// Whether a plateau holds the cell or ends beside it.
    pub(super) fn is_some(&self) -> bool {
        self.branches + self.branch.ties > 0.0 || self.edges.is_some()
    }

    /// Takes up a part whose plateau holds the cell, or ends beside it.
    pub(super) fn meet(&mut self, ribbon: &Ribbon, part: &Part, spot: &Spot, marks: bool, slack: f64) {
        let s = spot.share;
        let arc = part.arc + s * part.shape.length;
        let near = WINDING * self.branch.last.max(spot.distance) + 2.0 * part.thin;
        if self.branch.ties > 0.0 && arc - self.branch.arc > near {
            self.close_branch(ribbon);
        }
        // A corner has no side: what lies beside it knows better.
        let is_dot = part.shape.kind == Kind::Dot;
        let distance = if is_dot { spot.distance + 1e-3 * part.cell } else { spot.distance };
        let free = ribbon.has_edge && part.extent[spot.side].at(s) <= slack;
        let gap = if free { spot.distance - part.radius.at(s) } else { 0.0 };
        let rise = if is_dot || !ribbon.has_slope { 0.0 } else { part.rise(spot.side, s, spot.distance) };
        let values = [part.height(s) + rise, part.noise[0].at(s), part.noise[1].at(s)];
        let b = &mut self.branch;
        (b.arc, b.last) = (arc, spot.distance);
        b.marks |= marks;
        if b.ties == 0.0 || distance < b.distance - slack {
            (b.ties, b.distance, b.sum, b.gap, b.away) = (1.0, distance, values, gap, spot.away);
        } else if distance <= b.distance + slack {
            b.ties += 1.0;
            b.distance = b.distance.min(distance);
            b.gap = b.gap.min(gap);
            (0..3).for_each(|k| b.sum[k] += values[k]);
            (0..2).for_each(|k| b.away[k] += spot.away[k]);
        }
    }

    fn close_branch(&mut self, ribbon: &Ribbon) {
        let b = std::mem::take(&mut self.branch);
        if b.ties == 0.0 {
            return;
        }
        let values = b.sum.map(|x| x / b.ties);
        let free = b.gap > super::SLACK * ribbon.cell;
        if b.marks {
            (0..3).for_each(|k| self.sum[k] += values[k]);
            self.branches += 1.0;
            self.held += f32::from(u8::from(!free));
        }
        if free {
            let length = norm(b.away);
            let away = b.away.map(|x| if length > 0.0 { x / length } else { 0.0 });
            self.edges.add(values[0], b.gap, away, ribbon.cell);
        }
    }

    /// Hands over what the curve says, all its parts being done.
    pub(super) fn finish(&mut self, ribbon: &Ribbon, out: &mut Outcome) {
        self.close_branch(ribbon);
        if ribbon.has_height {
            out.height += self.sum[0];
            out.heights += self.branches as f32;
            out.held += self.held;
            out.edges.join(&self.edges);
        }
        if ribbon.has_noise {
            out.noise[0] += self.sum[1];
            out.noise[1] += self.sum[2];
            out.noises += self.branches as f32;
        }
    }
}

impl Outcome {
    /// Whether no curve has said anything yet.
    pub(super) fn is_new(&self) -> bool {
        self.heights == 0.0 && self.noises == 0.0 && !self.edges.is_some()
    }

    /// The height and the lean of the cell. Plateaus that hold it are averaged; between the edges of several the height
    /// goes linearly.
    pub(super) fn height(&self) -> Option<(f64, [f64; 2])> {
        let edges = &self.edges;
        if self.held > 0.0 || !edges.is_some() {
            return (self.heights > 0.0).then(|| (self.height / f64::from(self.heights), [0.0; 2]));
        }
        Some(edges.mean())
    }
}
