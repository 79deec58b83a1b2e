//! Flow of water: what drives it over an edge, what slows it, and what a cell has to give.
//!
//! # Theory
//! An edge between two cells is a pipe as wide as the side of an octagon, `(√2 − 1) Δx`, as deep as the water above the higher
//! bed, `h`, and `L` long. Its discharge per width `q` follows the local inertial equation of shallow water \[bates2010\],
//! which is the pipe of Weiss 2015 (11) with area, length and friction: with the drop `Δη` of the surface and `C = min(g h, c²)`
//! it would become `R = q + Δt C Δη / L`; Manning's friction, implicit, leaves `q' = 2 R / (1 + √(1 + 4 k |R|))` with
//! `k = Δt C n² h^(−10/3)`.
//!
//! # Differs from the papers
//! Friction acts on the vector of the flow, not on each pipe: `|R|²` is the mean of that of the two cells, where
//! `R = (√2 − 1)/2 · Σ R_e L_e e / Δx`. So water runs down the fall line whatever its direction on the grid. The celerity
//! cap `c` keeps deep water from dictating the step; steady flow is the same with it, since `k` has the same `C`.

use super::consts::Consts;
use crate::kit::simd::{larger, smaller};

/// The part of a depth that may leave a cell in a step: rounding takes no more than the rest.
const MOST: f32 = 0.999_999;

/// A side of an octagon of width 1.
pub(super) const SIDE: f32 = std::f32::consts::SQRT_2 - 1.0;

/// Rain falls on a row; returns the metres that came, summed over the row, as rounding let them: deep water far from its start
/// swallows a part of what falls. `before` is room for a row.
#[inline(always)]
pub(super) fn rain(dt: f32, rain: &[f32], water: &mut [f32], before: &mut [f32]) -> f64 {
    let n = water.len();
    let (rain, before) = (&rain[..n], &mut before[..n]);
    before.copy_from_slice(water);
    for i in 0..n {
        water[i] += rain[i] * dt;
    }
    difference(water, before)
}

/// Water of a row goes into the air, no more than there is; returns the metres that went, summed over the row. `before` is room
/// for a row.
#[inline(always)]
pub(super) fn evaporate(
    dt: f32,
    [height, filled]: [&[f32]; 2],
    rate: &[f32],
    water: &mut [f32],
    before: &mut [f32],
) -> f64 {
    let n = water.len();
    let (height, filled, rate, before) = (&height[..n], &filled[..n], &rate[..n], &mut before[..n]);
    before.copy_from_slice(water);
    for i in 0..n {
        let there = larger((filled[i] - height[i]) + water[i], 0.0);
        water[i] -= smaller(there, rate[i] * dt);
    }
    difference(before, water)
}

/// The sum of `a − b`. Few numbers are added as `f32`, so that rounding stays far below a millionth.
#[inline(always)]
pub(super) fn difference(a: &[f32], b: &[f32]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.chunks(128).zip(b.chunks(128)) {
        let mut lanes = [0.0f32; 16];
        let (a, b) = (a.chunks_exact(16), b.chunks_exact(16));
        let rest = a.remainder().iter().zip(b.remainder()).map(|(a, b)| f64::from(a - b)).sum::<f64>();
        for (a, b) in a.zip(b) {
            for k in 0..16 {
                lanes[k] += a[k] - b[k];
            }
        }
        sum += rest + lanes.iter().map(|&lane| f64::from(lane)).sum::<f64>();
    }
    sum
}

/// What follows from the state of a row: depth, change of the bed, change of the surface, load per water. `given` are input
/// height, surface at the start and loose ground at the start; `state` water, load, wear and loose ground.
#[inline(always)]
pub(super) fn start(
    [height, filled, before]: [&[f32]; 3],
    [water, load, wear, loose]: [&[f32]; 4],
    depth: &mut [f32],
    bed: &mut [f32],
    surface: &mut [f32],
    thick: &mut [f32],
) {
    let n = depth.len();
    let (height, filled, before) = (&height[..n], &filled[..n], &before[..n]);
    let (water, load, wear, loose) = (&water[..n], &load[..n], &wear[..n], &loose[..n]);
    let (bed, surface, thick) = (&mut bed[..n], &mut surface[..n], &mut thick[..n]);
    for i in 0..n {
        let d = larger((filled[i] - height[i]) + water[i], 0.0);
        let z = (loose[i] - before[i]) - wear[i];
        depth[i] = d;
        bed[i] = z;
        surface[i] = z + water[i];
        thick[i] = load[i] / larger(d, 1e-9);
    }
}

/// The two cells of each edge of a row: a quantity of the first cells, and of the second.
pub(super) type Pair<'a> = [&'a [f32]; 2];

/// What the ends of edges are like: input height, input surface, change of the bed, change of the surface, depth.
pub(super) struct Ends<'a> {
    pub(super) height: Pair<'a>,
    pub(super) filled: Pair<'a>,
    pub(super) bed: Pair<'a>,
    pub(super) surface: Pair<'a>,
    pub(super) depth: Pair<'a>,
}

/// Drives the water of edges: `drop` gets the drop of the surface, `deep` the wetted depth, `flow` what would flow without
/// friction. `before` is the flow of the last step, `per` is `Δt / L`.
#[inline(always)]
pub(super) fn drive(
    c: &Consts,
    per: f32,
    before: &[f32],
    ends: &Ends<'_>,
    flow: &mut [f32],
    deep: &mut [f32],
    drop: &mut [f32],
) {
    let n = flow.len();
    let [b0, b1] = [&ends.height[0][..n], &ends.height[1][..n]];
    let [e0, e1] = [&ends.filled[0][..n], &ends.filled[1][..n]];
    let [z0, z1] = [&ends.bed[0][..n], &ends.bed[1][..n]];
    let [x0, x1] = [&ends.surface[0][..n], &ends.surface[1][..n]];
    let [d0, d1] = [&ends.depth[0][..n], &ends.depth[1][..n]];
    let (before, deep, drop) = (&before[..n], &mut deep[..n], &mut drop[..n]);
    for i in 0..n {
        // Differences of heights are taken before changes are added: a height in thousands of metres has no bits for films.
        let bed = (b0[i] - b1[i]) + (z0[i] - z1[i]);
        let fall = (e0[i] - e1[i]) + (x0[i] - x1[i]);
        let h = larger(d0[i] + smaller(bed, 0.0), d1[i] - larger(bed, 0.0));
        let wet = h > c.thinnest;
        let h = larger(h, c.thinnest);
        let celerity = smaller(c.celerity, c.gravity * h);
        let r = before[i] + per * celerity * fall;
        flow[i] = if wet { r } else { 0.0 };
        deep[i] = h;
        drop[i] = fall;
    }
}

/// Squares of the flow vectors of the cells of a row: `own` are the flows over their edges to the east, south, south-east and
/// south-west, `above` those of the row above; each with a sample before and after the row.
#[inline(always)]
pub(super) fn square(own: [&[f32]; 4], above: [&[f32]; 4], out: &mut [f32]) {
    let n = out.len();
    let [e, s, d, u] = own.map(|row| &row[1..][..n]);
    let (west, north) = (&own[0][..n], &above[1][1..][..n]);
    let (north_west, north_east) = (&above[2][..n], &above[3][2..][..n]);
    for i in 0..n {
        let (across, down) = (d[i] + north_west[i], u[i] + north_east[i]);
        let x = (e[i] + west[i]) + (across - down);
        let y = (s[i] + north[i]) + (across + down);
        out[i] = (x * x + y * y) * (0.25 * SIDE * SIDE);
    }
}

/// Slows the water of edges by friction. `squares` are those of the flow vectors of their two cells.
#[inline(always)]
pub(super) fn slow(c: &Consts, squares: Pair<'_>, deep: &[f32], flow: &mut [f32]) {
    let n = flow.len();
    let (a, b, deep) = (&squares[0][..n], &squares[1][..n], &deep[..n]);
    for i in 0..n {
        let (r, h) = (flow[i], deep[i]);
        let size = larger(0.5 * (a[i] + b[i]), r * r).sqrt();
        let power = ten_thirds(h);
        let k = c.friction * smaller(c.celerity, c.gravity * h);
        let root = (power * (power + 4.0 * k * size)).sqrt();
        // No water is faster than the cap; the bound hangs on the vector, so that it turns no flow.
        let divisor = larger(0.5 * (power + root) * h, size * power * c.per_fastest);
        flow[i] = if size > 1e-15 { r * (power * h) / divisor } else { 0.0 };
    }
}

/// `h` to the power of 10/3, within 3e-5 relative, for numbers from 1e-6 to 1e6: the same bits everywhere, without a division.
#[inline(always)]
pub(super) fn ten_thirds(h: f32) -> f32 {
    // A third of the exponent, by shifts; the constant makes it a guess of the inverse cube root within 4 %.
    let x = h.to_bits();
    let third = (x >> 2) + (x >> 4);
    let third = third + (third >> 4);
    let third = third + (third >> 8);
    let r = f32::from_bits(0x54a2_0000_u32.wrapping_sub(third));
    // Newton's method for 1 / r³ = h.
    let r = r * (4.0 / 3.0 - (1.0 / 3.0) * (h * r) * (r * r));
    let r = r * (4.0 / 3.0 - (1.0 / 3.0) * (h * r) * (r * r));
    let r = h * r;
    (h * h) * (r * r)
}

/// The part of what cells would lose that they have to give. `depth` is what they have.
#[inline(always)]
pub(super) fn limit(c: &Consts, own: [&[f32]; 4], above: [&[f32]; 4], depth: &[f32], out: &mut [f32]) {
    let n = out.len();
    let [e, s, d, u] = own.map(|row| &row[1..][..n]);
    let (west, north) = (&own[0][..n], &above[1][1..][..n]);
    let (north_west, north_east) = (&above[2][..n], &above[3][2..][..n]);
    let depth = &depth[..n];
    let (gone, come) = (|q: f32| larger(q, 0.0), |q: f32| larger(-q, 0.0));
    for i in 0..n {
        let straight = (gone(e[i]) + come(west[i])) + (gone(s[i]) + come(north[i]));
        let across = (gone(d[i]) + come(north_west[i])) + (gone(u[i]) + come(north_east[i]));
        let wanted = c.share * (straight + across);
        out[i] = smaller(1.0, depth[i] * MOST / larger(wanted, 1e-30));
    }
}

/// Lets edges have what their upper cell can give: `flow` is cut, `load` gets the load that goes with it. `drop` of the surface
/// is turned into flow times drop where it runs down, `deep` into the fall of the bed, both with the sign of the flow. `cells`
/// are limits, load per water and depth of the two cells.
#[inline(always)]
pub(super) fn share(
    cells: [Pair<'_>; 3],
    flow: &mut [f32],
    load: &mut [f32],
    drop: &mut [f32],
    deep: &mut [f32],
) {
    let n = flow.len();
    let [can, thick, depth] = cells;
    let (k0, k1) = (&can[0][..n], &can[1][..n]);
    let (c0, c1) = (&thick[0][..n], &thick[1][..n]);
    let (d0, d1) = (&depth[0][..n], &depth[1][..n]);
    let (load, drop, deep) = (&mut load[..n], &mut drop[..n], &mut deep[..n]);
    for i in 0..n {
        // Sums of what goes one way and the other, of which one is 0, where a choice would make a branch.
        let (ahead, back) = (larger(flow[i], 0.0) * k0[i], smaller(flow[i], 0.0) * k1[i]);
        let fell = drop[i];
        let bed = fell - (d0[i] - d1[i]);
        flow[i] = ahead + back;
        load[i] = ahead * c0[i] + back * c1[i];
        drop[i] = ahead * larger(fell, 0.0) - back * smaller(fell, 0.0);
        let fall = if ahead > 0.0 { larger(bed, 0.0) } else { 0.0 };
        deep[i] = if back < 0.0 { smaller(bed, 0.0) } else { fall };
    }
}
