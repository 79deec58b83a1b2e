//! The turned lattices that noise hangs on, their hash, and Perlin noise on one.

use crate::kit::hash;

/// Columns are padded to a whole number of the widest vectors, so that kernels have no remainder loop.
const LANES: usize = 16;
/// Bits of the fraction of a position.
const FRACTION: u32 = 31;
/// Odd multipliers that spread the cell's column and row over 32 bits, from xxHash.
const SPREAD: [u32; 2] = [0x9e37_79b1, 0x85eb_ca77];

/// A square lattice over the world, turned and shifted by hash.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Cells per metre along the two axes of the lattice, for a metre to the east.
    east: [f64; 2],
    /// Position of the world's origin, in fixed point.
    start: [u64; 2],
}

impl Turned {
    /// A lattice with cells of `size` metres; angle and offset come from the seed.
    pub fn new(size: f64, seed: u64) -> Self {
        let angle = hash::unit(seed, 0) * std::f64::consts::TAU;
        let (sin, cos) = libm::sincos(angle);
        Self { east: [cos / size, sin / size], start: [hash::nth(seed, 1), hash::nth(seed, 2)] }
    }

    /// What the columns at some x (in metres) contribute to positions.
    pub fn columns(&self, xs: &[f64]) -> Columns {
        let [u, v] = self.east;
        Columns {
            u: Axis::new(xs.iter().map(|x| fixed(x * u))),
            v: Axis::new(xs.iter().map(|x| fixed(x * v))),
        }
    }

    /// What the row at y (in metres) contributes to positions.
    pub fn row(&self, y: f64) -> [Place; 2] {
        let [u, v] = self.east;
        let [u0, v0] = self.start;
        [Place::of(u0.wrapping_add(fixed(-y * v))), Place::of(v0.wrapping_add(fixed(y * u)))]
    }

    /// The cell that a world point lies in and its position there, 0 to 1.
    pub fn locate(&self, x: f64, y: f64) -> ([u32; 2], [f32; 2]) {
        let [u, v] = self.row(y);
        let (ui, uf) = u.plus(Place::of(fixed(x * self.east[0])));
        let (vi, vf) = v.plus(Place::of(fixed(x * self.east[1])));
        ([ui, vi], [uf, vf])
    }
}

/// A number of cells in fixed point, modulo 2³² cells.
fn fixed(cells: f64) -> u64 {
    const PERIOD: f64 = 4_294_967_296.0;
    const UNIT: f64 = (1u64 << FRACTION) as f64;
    // Every step but the last rounding is exact: the period is a power of two.
    let wrapped = cells - (cells / PERIOD).floor() * PERIOD;
    (wrapped * UNIT).round_ties_even() as u64
}

/// A fixed-point position in two words.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    cell: u32,
    fraction: u32,
}

impl Place {
    fn of(fixed: u64) -> Self {
        Self { cell: (fixed >> FRACTION) as u32, fraction: fixed as u32 & ((1 << FRACTION) - 1) }
    }

    /// The cell that two parts add up to, and the position in it from 0 to 1.
    #[inline(always)]
    pub fn plus(self, other: Self) -> (u32, f32) {
        // Two fractions of 31 bits add without overflow; bit 31 is the carry.
        let sum = self.fraction + other.fraction;
        let cell = self.cell.wrapping_add(other.cell).wrapping_add(sum >> FRACTION);
        let fraction = sum & ((1 << FRACTION) - 1);
        (cell, fraction as i32 as f32 * (1.0 / (1u32 << FRACTION) as f32))
    }
}

/// The parts of positions that come from the columns, along both axes of a lattice.
#[derive(Clone, Debug)]
pub struct Columns {
    u: Axis,
    v: Axis,
}

#[derive(Clone, Debug)]
struct Axis {
    cells: Vec<u32>,
    fractions: Vec<u32>,
}

impl Axis {
    fn new(positions: impl ExactSizeIterator<Item = u64>) -> Self {
        let padded = positions.len().next_multiple_of(LANES);
        let (mut cells, mut fractions) = (Vec::with_capacity(padded), Vec::with_capacity(padded));
        for place in positions.map(Place::of) {
            cells.push(place.cell);
            fractions.push(place.fraction);
        }
        cells.resize(padded, 0);
        fractions.resize(padded, 0);
        Self { cells, fractions }
    }
}

impl Columns {
    /// Bytes that the parts of some columns take.
    pub fn bytes(columns: usize) -> u64 {
        16 * columns.next_multiple_of(LANES) as u64
    }

    /// Some of the columns, from `start` on: a multiple of the lanes, at most `most`.
    #[inline(always)]
    pub(super) fn block(&self, start: usize, most: usize) -> Block<'_> {
        let end = self.u.cells.len().min(start + most);
        Block {
            u: (&self.u.cells[start..end], &self.u.fractions[start..end]),
            v: (&self.v.cells[start..end], &self.v.fractions[start..end]),
        }
    }
}

/// Some neighbouring columns.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    u: (&'a [u32], &'a [u32]),
    v: (&'a [u32], &'a [u32]),
}

impl<'a> Block<'a> {
    /// The cells and positions of all columns on a row.
    #[inline(always)]
    pub(super) fn on(self, [u, v]: [Place; 2]) -> impl Iterator<Item = ([u32; 2], [f32; 2])> + use<'a> {
        let places = self.u.0.iter().zip(self.u.1).zip(self.v.0.iter().zip(self.v.1));
        places.map(
            #[inline(always)]
            move |((&uc, &uf), (&vc, &vf))| {
                let (ui, ux) = u.plus(Place { cell: uc, fraction: uf });
                let (vi, vx) = v.plus(Place { cell: vc, fraction: vf });
                ([ui, vi], [ux, vx])
            },
        )
    }
}

/// The two words that [`scramble`] takes together, for the column and the row of a cell.
#[inline(always)]
pub fn spread([col, row]: [u32; 2]) -> [u32; 2] {
    [col.wrapping_mul(SPREAD[0]), row.wrapping_mul(SPREAD[1])]
}

/// The word for a cell that lies some columns (axis 0) or rows (axis 1) further.
#[inline(always)]
pub const fn step(word: u32, axis: usize, cells: i32) -> u32 {
    word.wrapping_add(SPREAD[axis].wrapping_mul(cells as u32))
}

/// A hash of a cell: the upper half of its bits is good, the lower is not.
///
/// Found by search: over a million cells at several places, autocorrelations of the bits in use at all lags, spectrum
/// peaks and four-point products of rectangles stay within what chance allows; the tests repeat a part of it.
#[inline(always)]
pub fn scramble(col: u32, row: u32) -> u32 {
    let h = col ^ row;
    (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d)
}

/// A random slope: its direction is spread over the circle, its length is within 5 % of 1, its components have mean
/// 0, the same variance of 0.4857 and no correlation. Sine and cosine of the half circle are replaced by
/// polynomials, and a bit chooses the half.
#[inline(always)]
pub fn slope(hash: u32) -> [f32; 2] {
    let t = (hash << 1) as i32 as f32 * (1.0 / (1u32 << 31) as f32);
    let square = t * t;
    let half = LIFT - LIFT * square;
    [t * (1.5 - 0.5 * square), f32::from_bits(half.to_bits() ^ (hash & (1 << 31)))]
}

/// √(E[(1.5 t − 0.5 t³)²] / E[(1 − t²)²]) for t from −1 to 1: gives both components of a slope one variance.
const LIFT: f32 = 0.954_313_5;
/// One over the largest sum that four slopes can give, 0.70372 in the middle of a cell, rounded down.
const NORMAL: f32 = 1.421;

/// Perlin's gradient noise at a position (0 to 1) in a cell, from −1 to 1.
#[inline(always)]
pub fn perlin(cell: [u32; 2], [x, y]: [f32; 2]) -> f32 {
    let [x0, y0] = spread(cell);
    let (x1, y1) = (step(x0, 0, 1), step(y0, 1, 1));
    let (bx, by) = (x - 1.0, y - 1.0);
    let (fx, fy) = (fade(x), fade(y));
    let north = blend(corner(x0, y0, x, y), corner(x1, y0, bx, y), fx);
    let south = blend(corner(x0, y1, x, by), corner(x1, y1, bx, by), fx);
    blend(north, south, fy) * NORMAL
}

/// The height at some cells from a corner on the plane of the corner's slope.
#[inline(always)]
fn corner(col: u32, row: u32, x: f32, y: f32) -> f32 {
    let [gx, gy] = slope(scramble(col, row));
    gx * x + gy * y
}

/// The quintic `6 t⁵ − 15 t⁴ + 10 t³`, from 0 to 1, whose first two derivatives vanish at both ends \[perlin2002\]; written
/// around the middle, where its terms are small and their rounding does not show.
#[inline(always)]
fn fade(t: f32) -> f32 {
    let s = t - 0.5;
    let square = s * s;
    0.5 + s * (1.875 + square * (6.0 * square - 5.0))
}

#[inline(always)]
fn blend(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}
