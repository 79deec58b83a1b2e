//! What one curve, and then all curves together, say about one cell.

use super::ribbon::{Part, Ribbon};
use super::shape::{Kind, Spot};
use crate::value::curves::bezier::{Point, norm};

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

/// Number of no part.
const NONE: u32 = u32::MAX;

/// The nearest of the parts of one curve whose slopes hold a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    distance: f64,
    part: u32,
    /// The last one that is as near.
    tie: u32,
}

/// What all curves say about a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outcome {
    pub(super) height: f64,
    pub(super) noise: [f64; 2],
    pub(super) heights: f32,
    pub(super) noises: f32,
    pub(super) direction: [f32; 2],
    pub(super) steepness: f32,
    /// Curves whose slopes reach here.
    pub(super) slopes: u32,
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

impl Ribbon {
    /// What a part is to a cell at a spot.
    #[inline(always)]
    pub(super) fn reach(&self, part: &Part, spot: &Spot, slack: f64) -> Reach {
        let d = spot.distance;
        let radius = part.radius.at(spot.share);
        let dot = part.shape.kind == Kind::Dot;
        let flat = self.is_strict() && (d <= radius.max(part.thin) + slack || dot);
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

    /// Direction away from the curve and steepness where one or two parts are nearest: of two what both say along
    /// their common direction. `None` where they contradict each other.
    pub(super) fn gradient(&self, nearest: &Nearest, at: impl Fn(&Part) -> Point) -> Option<(Point, f64)> {
        let one = |number: u32| {
            let part = &self.parts[number as usize];
            let spot = part.shape.locate(at(part))?;
            let extent = part.extent[spot.side].at(spot.share);
            let fade = 1.0 - (spot.distance - part.radius.at(spot.share)) / extent;
            Some((spot.away, part.steepness[spot.side].at(spot.share) * fade.clamp(0.0, 1.0)))
        };
        let (away, steepness) = one(nearest.part)?;
        if nearest.tie == NONE {
            return Some((away, steepness));
        }
        let (other, also) = one(nearest.tie)?;
        let sum = [away[0] + other[0], away[1] + other[1]];
        let length = norm(sum);
        (length > 1e-9).then(|| (sum.map(|x| x / length), 0.25 * length * (steepness + also)))
    }
}

impl Nearest {
    /// No part yet.
    pub(super) const NOTHING: Self = Self { distance: f64::INFINITY, part: NONE, tie: NONE };

    /// Whether there is a part.
    #[inline(always)]
    pub(super) fn is_some(&self) -> bool {
        self.part != NONE
    }

    /// Takes up a part at a distance.
    #[inline(always)]
    pub(super) fn meet(&mut self, distance: f64, part: u32, slack: f64) {
        if distance < self.distance - slack {
            *self = Self { distance, part, tie: NONE };
        } else if distance <= self.distance + slack {
            self.distance = self.distance.min(distance);
            self.tie = part;
        }
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
        self.slopes == 0 && self.heights == 0.0 && self.noises == 0.0
    }

    /// Takes up the gradient of a curve; without an elevation the curve gives no height that could flow away from it,
    /// and both direction and steepness are turned round.
    pub(super) fn slope(&mut self, ribbon: &Ribbon, gradient: Option<(Point, f64)>) {
        self.slopes += 1;
        let (direction, steepness) = gradient.unwrap_or(([0.0; 2], 0.0));
        let sign = if ribbon.has_height { 1.0 } else { -1.0 };
        self.direction = direction.map(|x| (sign * x) as f32);
        self.steepness = (sign * steepness) as f32;
    }
}
