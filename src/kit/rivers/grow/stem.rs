//! Main stems: where the longest river of a network runs if nothing is in its way.

use super::{Growth, Line, beyond};
use crate::kit::predicates::Point;

/// The main stem of a line: a chain of links that ends at its tip, an exterior link.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stem {
    /// Depth of the network; 0 for none.
    pub depth: u32,
    /// The exterior link at its upper end.
    pub tip: u32,
    /// Length of the first link, in metres.
    first: f64,
    /// How many times shorter links are in each step.
    shrink: f64,
    /// Direction of the first link, in radians.
    direction: f64,
    /// The branch angle to the side that it turns to first, in radians.
    turn: f64,
    /// The upper end of the first link.
    pub first_end: Point,
}

impl Stem {
    /// The stem of a line that turns to a side first, and then to alternating ones.
    ///
    /// With a first link of length 1 to the east its end would be at some place; it is turned and scaled so that the end is
    /// that of the line.
    pub(super) fn new(growth: &Growth<'_>, line: &Line, depth: u32, side: f64) -> Self {
        let shrink = growth.branching.shrink();
        let mut stem = Self {
            depth,
            tip: 0,
            first: 1.0,
            shrink,
            direction: 0.0,
            turn: side * growth.angle,
            first_end: line.to,
        };
        let mut end = [0.0; 2];
        for step in 2..=depth {
            end = beyond(end, stem.heading(step - 1), stem.divided_length(growth, step));
        }
        end = beyond(end, stem.heading(depth), stem.length(depth));
        let wanted = [line.to[0] - line.from[0], line.to[1] - line.from[1]];
        stem.first = line.length() / libm::hypot(end[0], end[1]).max(1e-9);
        stem.direction = libm::atan2(wanted[1], wanted[0]) - libm::atan2(end[1], end[0]);
        // A stem of one link ends where the line does, to the bit.
        if depth > 1 {
            stem.first_end = beyond(line.from, stem.direction, stem.first);
        }
        stem
    }

    /// Length of the links that sprout in a step, in metres: equation (2).
    pub(super) fn length(&self, step: u32) -> f64 {
        (1..step).fold(self.first, |length, _| length / self.shrink)
    }

    /// Length of an exterior link that a step divides: that of all the pieces of its generator, if it is shorter.
    pub(super) fn divided_length(&self, growth: &Growth<'_>, step: u32) -> f64 {
        self.length(step - 1).max(growth.branching.exterior() * self.length(step))
    }

    /// Direction of the tip that sprouts in a step, in radians.
    pub(super) fn heading(&self, step: u32) -> f64 {
        self.direction + if step.is_multiple_of(2) { self.turn } else { 0.0 }
    }

    /// The side to which the tip turns in a step: 1 to growing angles, -1 to falling ones.
    pub(super) fn side(&self, step: u32) -> f64 {
        let side = if self.turn < 0.0 { -1.0 } else { 1.0 };
        if step.is_multiple_of(2) { side } else { -side }
    }
}
