//! What water and ground exchange in a cell, and what arrives there.
//!
//! # Theory
//! Water carries at most `s* = K_c Σ w q Δη / (L Δx)` metres of solid, over the edges where it leaves: stream power, that is
//! capacity times speed times slope of Weiss 2015 (18), times depth. Of what is missing or too much a step exchanges the part
//! `x / (1 + x)`, with `x = u Δt / d` and `u` the erodibility as a speed or the settling speed. Loose ground goes first, rock
//! for the rest of the step.
//!
//! # Differs from the paper
//! A step takes at most half of the height above the lowest receiver and lays down at most half of the depth, so that
//! neither pits nor needles grow. Rock hardens as `2^(−wear / f)` rather than without bound (24). In the sea, load sinks
//! and fills it to its level, where the paper drops a whole load into the first cell.
//!
//! Load is changed by what rounding lets the ground take or give, so that no solid is lost in the `f32` of deep cuts.

use super::consts::Consts;
use super::water::difference;
use crate::kit::simd::{exp2, larger, smaller};

/// The part of a height above the receiver that a step takes at most, and of a depth that it lays down at most.
const HALF: f32 = 0.5;

/// Metres that load may fill the sea beyond half of its depth in a step, so that the shore comes to its level.
const SHOAL: f32 = 0.01;

/// Metres that a step may lay down in any depth: what dries up leaves its load.
const FILM: f32 = 1e-4;

/// A quantity on the edges of a row's cells: its own to the east, south, south-east and south-west, and those of the row above;
/// each row with a sample before its first and after its last. What leaves the cell of its own edges is above 0.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) own: [&'a [f32]; 4],
    pub(super) above: [&'a [f32]; 4],
}

/// The same as the eight neighbours of each cell: those of its own edges, and those opposite to them.
struct Eight<'a> {
    own: [&'a [f32]; 4],
    other: [&'a [f32]; 4],
}

impl<'a> Around<'a> {
    #[inline(always)]
    fn eight(self, n: usize) -> Eight<'a> {
        let [_, south, across, down] = self.above;
        Eight {
            own: self.own.map(|row| &row[1..][..n]),
            other: [&self.own[0][..n], &south[1..][..n], &across[..n], &down[2..][..n]],
        }
    }
}

impl Eight<'_> {
    /// What leaves a cell less what comes.
    #[inline(always)]
    fn net(&self, i: usize) -> f32 {
        let [a, b] = [&self.own, &self.other];
        ((a[0][i] - b[0][i]) + (a[1][i] - b[1][i])) + ((a[2][i] - b[2][i]) + (a[3][i] - b[3][i]))
    }

    /// The sum over edges where water leaves, along the axes and along the diagonals.
    #[inline(always)]
    fn leaving(&self, i: usize) -> [f32; 2] {
        let [a, b] = [&self.own, &self.other];
        let pair = |k: usize| larger(a[k][i], 0.0) + larger(-b[k][i], 0.0);
        [pair(0) + pair(1), pair(2) + pair(3)]
    }

    /// The largest over edges where water leaves.
    #[inline(always)]
    fn most(&self, i: usize) -> f32 {
        let [a, b] = [&self.own, &self.other];
        let pair = |k: usize| larger(a[k][i], -b[k][i]);
        larger(larger(larger(pair(0), pair(1)), larger(pair(2), pair(3))), 0.0)
    }
}

/// What the edges of a row's cells carry.
#[derive(Clone, Copy)]
pub(super) struct Edges<'a> {
    pub(super) flow: Around<'a>,
    pub(super) load: Around<'a>,
    pub(super) power: Around<'a>,
    pub(super) fall: Around<'a>,
}

/// What is given on a row: input height and the surface over it, loose ground at the start, factors on the erodibility of rock
/// and on every exchange.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) height: &'a [f32],
    pub(super) filled: &'a [f32],
    pub(super) before: &'a [f32],
    pub(super) soft: &'a [f32],
    pub(super) mask: &'a [f32],
}

/// Moves water and load, and exchanges load with the ground. `SEA`: there is a sea; `HARD`: rock hardens. The state is water,
/// load, wear and loose ground.
#[inline(always)]
pub(super) fn exchange<const SEA: bool, const HARD: bool>(
    c: &Consts,
    given: Given<'_>,
    edges: Edges<'_>,
    water: &mut [f32],
    load: &mut [f32],
    wear: &mut [f32],
    loose: &mut [f32],
) {
    let n = water.len();
    let (load, wear, loose) = (&mut load[..n], &mut wear[..n], &mut loose[..n]);
    let (height, filled, before) = (&given.height[..n], &given.filled[..n], &given.before[..n]);
    let (soft, mask) = (&given.soft[..n], &given.mask[..n]);
    let (flow, carried) = (edges.flow.eight(n), edges.load.eight(n));
    let (power, fall) = (edges.power.eight(n), edges.fall.eight(n));
    for i in 0..n {
        let start = filled[i] - height[i];
        let wet = larger(water[i] - c.share * flow.net(i), -start);
        let (l, w) = (loose[i], wear[i]);
        let s = larger(load[i] - c.share * carried.net(i), 0.0);
        let depth = larger(start + wet, 0.0);
        let change = (l - before[i]) - w;
        let below = c.sea - (height[i] + change);
        let in_sea = SEA && below > 0.0;
        let h = larger(depth, c.thinnest);
        let [straight, across] = power.leaving(i);
        let capacity = c.power[0] * straight + c.power[1] * across;
        let capacity = if depth > c.thinnest && !in_sea { capacity } else { 0.0 };
        let excess = capacity - s;
        let (up, down) = (larger(excess, 0.0), larger(-excess, 0.0));
        let speed = if excess > 0.0 { c.loose } else { c.settling };
        let part = mask[i] * (speed / (h + speed));
        let room = HALF * fall.most(i);
        let wanted = smaller(up * part, room);
        let take = smaller(wanted, l);
        let rest = (wanted - take) / larger(wanted, 1e-30);
        let hard = if HARD { exp2(-w * c.per_hardening) } else { 1.0 };
        let rock = c.rock * soft[i] * hard;
        let rest = if c.loose > 0.0 { rest } else { 1.0 };
        let worn = smaller(rest * (mask[i] * (up - take) * (rock / (h + rock))), room - take);
        let worn = smaller(larger(worn, 0.0), larger(c.most_wear - w, 0.0));
        let space = if in_sea { HALF * below + SHOAL } else { larger(HALF * depth, FILM) };
        let laid = smaller(smaller(down * part, space), larger(c.most_deposit - change, 0.0));
        let (new_l, new_w) = (l + (laid - take), w + worn);
        let left = s + ((new_w - w) - (new_l - l));
        // Rounding of deep ground may ask for more load than there is: then nothing is exchanged.
        let (new_l, new_w, left) = if left < 0.0 { (l, w, s) } else { (new_l, new_w, left) };
        loose[i] = new_l;
        wear[i] = new_w;
        load[i] = if left > 1e-20 { left } else { 0.0 };
        water[i] = wet;
    }
}

/// Water of the sea falls or rises to its level; returns the metres that the sea took, summed over the row. `before` is room for
/// a row.
#[inline(always)]
pub(super) fn drown(
    c: &Consts,
    given: Given<'_>,
    [wear, loose]: [&[f32]; 2],
    water: &mut [f32],
    before: &mut [f32],
) -> f64 {
    let n = water.len();
    let (height, filled, was_loose) = (&given.height[..n], &given.filled[..n], &given.before[..n]);
    let (wear, loose, before) = (&wear[..n], &loose[..n], &mut before[..n]);
    before.copy_from_slice(water);
    for i in 0..n {
        let change = (loose[i] - was_loose[i]) - wear[i];
        let start = filled[i] - height[i];
        let depth = larger(start + water[i], 0.0);
        let over = (filled[i] - c.sea) + (water[i] + change);
        let x = c.sea_rate * depth;
        let gone = larger(over * (x / (1.0 + x)), -depth);
        let gone = if height[i] + change < c.sea { gone } else { 0.0 };
        water[i] = larger(water[i] - gone, -start);
    }
    difference(before, water)
}
