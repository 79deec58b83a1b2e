//! Branches take the best place that is clear.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Map, Role, beyond};
use crate::kit::predicates::Point;
use crate::kit::rivers::gap::Room;

/// A branch that the rules ask for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sprout {
    /// The vertex that it joins.
    pub foot: u32,
    /// Its own angle, in radians.
    pub angle: f64,
    /// Its line.
    pub line: u32,
    /// Whether it goes on as a main stem.
    pub is_stem: bool,
}

/// How far a branch is bent, in degrees, the own angle first.
const BENDS: [f64; 13] = [0.0, -15.0, 15.0, -30.0, 30.0, -45.0, 45.0, -7.5, 7.5, -22.5, 22.5, -37.5, 37.5];
/// Shares of its length that a branch tries.
const LENGTHS: [f64; 4] = [1.0, 0.85, 0.7, 0.55];
/// Standard deviation of the angle of a branch, in radians.
const JITTER: f64 = 0.08;
/// How far a place counts as clear, in link lengths.
const CLEAR: f64 = 0.8;
/// How far the end of a branch keeps from the border, in link lengths.
const BORDER: f64 = 0.4;
/// The least angle between links at a vertex, in radians: 15°.
const LEAST_ANGLE: f64 = PI / 12.0;
/// What a place is worth less, in link lengths of room, for a right angle of bending, and for each share of the length that
/// is missing. Of those tried these leave out fewest branches: 1.6 % with φ 2, 2.4 % and 2.6 % with φ 3 and 4 at depth 6.
/// Twice as much leaves out half as many again.
const LOSS: f64 = 0.4;

impl Map<'_> {
    /// Adds a branch where there is room.
    pub(super) fn sprout(&mut self, sprout: Sprout, step: u32) {
        self.grown.asked += 1;
        let jitter = JITTER * self.chance.bell();
        let length = self.stems[sprout.line as usize].length(step);
        let foot = self.grown.at[sprout.foot as usize];
        let others =
            self.segments_near(&[foot], length * (1.0 + CLEAR), |map, other| map.is_at(other, sprout.foot));
        let own = beyond(foot, sprout.angle, length);
        let keep = self.growth.clearance * length;
        let tip = if sprout.is_stem
            && self.is_inside(own, 0.0)
            && Room::just(keep).of(foot, own, &others).is_some()
        {
            Some(own)
        } else {
            self.best_tip(&Sprout { angle: sprout.angle + jitter, ..sprout }, length, &others)
        };
        let Some(tip) = tip else {
            self.grown.left_out += 1;
            return;
        };
        let vertex = self.add(tip, Some(sprout.foot), Role::Exterior, sprout.line);
        self.grid.put(vertex, [tip, foot]);
        if sprout.is_stem {
            self.stems[sprout.line as usize].tip = vertex;
        }
    }

    /// The end of a branch with the most room, least bent and least shortened; none where no place is clear.
    fn best_tip(&mut self, sprout: &Sprout, length: f64, others: &[[Point; 2]]) -> Option<Point> {
        let foot = self.grown.at[sprout.foot as usize];
        let joined = self.angles_at(sprout.foot, length);
        let mut best: Option<(f64, Point)> = None;
        for bend in BENDS.map(f64::to_radians) {
            let angle = sprout.angle + bend;
            // A branch angle below the least one is the artist's word.
            let least = LEAST_ANGLE.min(0.6 * self.growth.angle);
            if joined.iter().any(|&other| between(angle, other) < least) {
                continue;
            }
            for share in LENGTHS {
                let loss = LOSS * (bend.abs() / FRAC_PI_2 + 1.0 - share);
                if best.is_some_and(|(value, _)| CLEAR - loss <= value) {
                    continue;
                }
                let tip = beyond(foot, angle, share * length);
                let middle = [0, 1].map(|i| (foot[i] + tip[i]) / 2.0);
                if !self.is_inside(tip, BORDER * length) || !(self.growth.is_land)(middle) {
                    continue;
                }
                let needed = self.growth.clearance * length * (0.5 + 0.5 * share);
                // A place that is worth no more than the best so far is of no use.
                let useful = best.map_or(0.0, |(most, _)| (most + loss) * length);
                let room = Room { least: needed.max(useful), most: CLEAR * length };
                let Some(clear) = room.of(foot, tip, others) else { continue };
                let value = clear / length - loss;
                if best.is_none_or(|(most, _)| value > most) {
                    best = Some((value, tip));
                }
            }
        }
        best.map(|(_, tip)| tip)
    }

    /// The directions in which links leave a vertex, in radians.
    fn angles_at(&mut self, vertex: u32, length: f64) -> Vec<f64> {
        let at = self.grown.at[vertex as usize];
        let joined = self.segments_near(&[at], 1e-6 * length, |map, other| !map.is_at(other, vertex));
        let angle = |segment: &[Point; 2]| {
            let [to, from] = *segment;
            let end = if from == at { to } else { from };
            libm::atan2(end[1] - at[1], end[0] - at[0])
        };
        joined.iter().map(angle).collect()
    }
}

/// The angle between two directions, from 0 to π.
fn between(a: f64, b: f64) -> f64 {
    let turn = (a - b).abs() % TAU;
    turn.min(TAU - turn)
}
