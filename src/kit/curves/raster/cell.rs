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
    /// Sums over the branches that are done, and their number.
    sum: Values,
    branches: f64,
}

/// One passage of the curve by a cell whose plateau holds the cell.
#[derive(Clone, Copy, Debug, Default)]
struct Branch {
    /// Parts that are equally near, and the sum of what they say; 0 for no branch.
    ties: f64,
    distance: f64,
    sum: Values,
    /// Length of the curve up to the last foot, and how far that was.
    arc: f64,
    last: f64,
}

/// The gradient of the nearest of the parts of one curve whose slopes hold a cell; of parts that are equally near
/// the sums. Small, since it is what filling a tile spends its time on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    distance: f64,
    away: [f32; 2],
    steepness: f32,
    ties: f32,
}

/// What the plateaus of all curves say about a cell: sums and how many.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    pub(super) height: f64,
    pub(super) noise: [f64; 2],
    pub(super) heights: f32,
    pub(super) noises: f32,
}

/// How much longer than the farther of two distances the way between two feet may be for both to be one branch: a
/// half circle has π.
const WINDING: f64 = 4.0;

/// What a part of a curve is to a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// It does not reach it.
    Beyond,
    /// The cell lies on its plateau.
    Plateau,
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
        let thin =
            if spot.at_corner { part.half / spot.away[0].abs().max(spot.away[1].abs()) } else { part.thin };
        let flat = self.is_strict() && (d <= radius.max(thin) + slack || dot);
        if flat && (self.has_height || dot) {
            return Reach::Plateau;
        }
        let extent = part.extent[spot.side].at(spot.share);
        // On the very line it is not said on which side a cell is.
        let slope = self.has_slope && extent > slack && d - radius <= extent + slack && d > slack;
        match (flat, slope) {
            (false, false) => Reach::Beyond,
            (true, false) => Reach::Plateau,
            (false, true) => Reach::Slope,
            (true, true) => Reach::Both,
        }
    }

    /// Steepness at a spot on the slope of a part.
    #[inline(always)]
    pub(super) fn steepness(part: &Part, spot: &Spot) -> f64 {
        let fade = 1.0 - (spot.distance - part.radius.at(spot.share)) / part.extent[spot.side].at(spot.share);
        part.steepness[spot.side].at(spot.share) * fade.clamp(0.0, 1.0)
    }
}

impl Nearest {
    /// No part yet.
    pub(super) const NOTHING: Self =
        Self { distance: f64::INFINITY, away: [0.0; 2], steepness: 0.0, ties: 0.0 };

    /// Whether there is a part.
    #[inline(always)]
    pub(super) fn is_some(&self) -> bool {
        self.ties > 0.0
    }

    /// Takes up what a part says at a spot.
    #[inline(always)]
    pub(super) fn meet(&mut self, part: &Part, spot: &Spot, slack: f64) {
        if spot.distance > self.distance + slack {
            return;
        }
        let steepness = Ribbon::steepness(part, spot) as f32;
        let away = spot.away.map(|x| x as f32);
        if spot.distance < self.distance - slack {
            *self = Self { distance: spot.distance, away, steepness, ties: 1.0 };
        } else {
            self.distance = self.distance.min(spot.distance);
            self.away = [self.away[0] + away[0], self.away[1] + away[1]];
            self.steepness += steepness;
            self.ties += 1.0;
        }
    }

    /// Direction and steepness, both times `sign`, of the equally near parts together: what each says along their
    /// common direction; `None` where they contradict each other.
    #[inline]
    pub(super) fn mean(&self, sign: f32) -> Option<([f32; 2], f32)> {
        if self.ties == 1.0 {
            return Some((self.away.map(|x| sign * x), sign * self.steepness));
        }
        let length = norm(self.away.map(f64::from)) as f32;
        let share = length / self.ties;
        let steepness = sign * self.steepness / self.ties * share;
        (share > 1e-6).then(|| (self.away.map(|x| sign * x / length), steepness))
    }
}

impl Strict {
    /// Whether a plateau holds the cell.
    pub(super) fn is_some(&self) -> bool {
        self.branches + self.branch.ties > 0.0
    }

    /// Takes up a part whose plateau holds the cell.
    pub(super) fn meet(&mut self, part: &Part, spot: &Spot, slack: f64) {
        let s = spot.share;
        let values = [part.height(s), part.noise[0].at(s), part.noise[1].at(s)];
        let arc = part.arc + s * part.shape.length;
        let near = WINDING * self.branch.last.max(spot.distance) + 2.0 * part.thin;
        if self.branch.ties > 0.0 && arc - self.branch.arc > near {
            self.close_branch();
        }
        let b = &mut self.branch;
        (b.arc, b.last) = (arc, spot.distance);
        if b.ties == 0.0 || spot.distance < b.distance - slack {
            (b.ties, b.distance, b.sum) = (1.0, spot.distance, values);
        } else if spot.distance <= b.distance + slack {
            b.ties += 1.0;
            b.distance = b.distance.min(spot.distance);
            (0..3).for_each(|k| b.sum[k] += values[k]);
        }
    }

    fn close_branch(&mut self) {
        let b = self.branch;
        if b.ties > 0.0 {
            (0..3).for_each(|k| self.sum[k] += b.sum[k] / b.ties);
            self.branches += 1.0;
        }
        self.branch = Branch::default();
    }

    /// Hands over what the curve says, all its parts being done.
    pub(super) fn finish(&mut self, ribbon: &Ribbon, out: &mut Outcome) {
        self.close_branch();
        if ribbon.has_height {
            out.height += self.sum[0];
            out.heights += self.branches as f32;
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
        self.heights == 0.0 && self.noises == 0.0
    }
}
