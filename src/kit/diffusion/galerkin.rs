//! The Galerkin product: restriction times equations times interpolation, a row of coarse points at a time.
//!
//! Only what coarse points pull at each other is summed, and what the product makes of a field of ones, which is the
//! excess of the diagonal. The diagonal follows from both, so that rows that should sum to zero do so in `f32`.

use crate::kit::diffusion::level::{DIRECTIONS, KEPT, Level};
use crate::kit::diffusion::setup::Equations;
use crate::kit::diffusion::split::{Split, neighbour, zeros};
use crate::kit::simd::{Kernel, Level as Simd};

/// What the interpolation makes of a coarse field of ones: 1 but near held cells.
pub(crate) fn reach(level: &Level) -> Split {
    let mut out = zeros(level.cols, level.rows);
    for (plane, out) in out.iter_mut().enumerate() {
        out.each_row(|j, row| {
            let j = j as isize;
            match plane {
                0 => row
                    .iter_mut()
                    .zip(level.w[0].row(j, 0))
                    .for_each(|(o, &w)| *o = if w > 0.0 { 1.0 } else { 0.0 }),
                1 | 2 => {
                    let (a, b) = (level.up[2 * plane - 2].row(j, 0), level.up[2 * plane - 1].row(j, 0));
                    row.iter_mut().zip(a).zip(b).for_each(|((o, a), b)| *o = a + b);
                }
                _ => {
                    let [a, b, c, d] = [4, 5, 6, 7].map(|k| level.up[k].row(j, 0));
                    for (i, o) in row.iter_mut().enumerate() {
                        *o = (a[i] + b[i]) + (c[i] + d[i]);
                    }
                }
            }
        });
    }
    out
}

/// One row of the Galerkin product at a time.
pub(crate) struct Product<'a> {
    level: &'a Level,
    ones: &'a Split,
    symmetric: bool,
    simd: Simd,
    equations: Equations,
    mask: Vec<f32>,
    /// The pulls that are kept, then the excess.
    pub(crate) sums: Vec<Vec<f32>>,
}

impl<'a> Product<'a> {
    pub(crate) fn new(level: &'a Level, ones: &'a Split, symmetric: bool, simd: Simd) -> Self {
        let cols = level.w[0].cols;
        let kept = if symmetric { 4 } else { 8 };
        Self {
            level,
            ones,
            symmetric,
            simd,
            equations: Equations::new(cols),
            mask: vec![0.0; cols],
            sums: vec![vec![0.0; cols]; kept + 1],
        }
    }

    /// Fills the sums of coarse row `j`.
    pub(crate) fn row(&mut self, j: isize) {
        let Self { level, ones, symmetric, simd, equations, mask, sums } = self;
        let n = mask.len();
        let kept = sums.len() - 1;
        sums.iter_mut().for_each(|s| s.fill(0.0));
        mask.iter_mut().zip(level.w[0].row(j, 0)).for_each(|(o, &w)| *o = if w > 0.0 { 1.0 } else { 0.0 });
        let down = level.down.as_ref().unwrap_or(&level.up);
        for (plane, dy) in [(2, -1), (3, -1), (0, 0), (1, 0), (2, 1), (3, 1)] {
            let row = j + (dy >> 1);
            if row < 0 {
                continue;
            }
            equations.load(level, plane, row, false, *simd);
            // What the equations make of the interpolated ones, as differences.
            let own = ones[plane].row(row, 0);
            let excess = &mut equations.excess[1..=n];
            excess.iter_mut().zip(own).for_each(|(s, v)| *s *= v);
            for (d, &(ex, ey)) in DIRECTIONS.iter().enumerate().take(level.directions()) {
                let (q, dj, di) = neighbour(plane, ex, ey);
                let pull = &equations.pull[d][1..=n];
                simd.run(AddDifference { a: pull, b: own, c: ones[q].row(row + dj, di), out: excess });
            }
            let columns: &[isize] = if plane & 1 == 0 { &[0] } else { &[-1, 1] };
            for &dx in columns {
                let side = dx >> 1;
                // The weight with which the coarse point takes the cell's equation.
                let taken = match (dx, dy) {
                    (0, 0) => None,
                    (1, 0) => Some(0),
                    (-1, 0) => Some(1),
                    (0, 1) => Some(2),
                    (0, -1) => Some(3),
                    (1, 1) => Some(4),
                    (-1, 1) => Some(5),
                    (1, -1) => Some(6),
                    _ => Some(7),
                };
                let weight = taken.map_or(&mask[..], |k| down[k].row(row, side));
                let at = (1 + side) as usize..(1 + side) as usize + n;
                simd.run(Add { a: weight, b: &equations.excess[at.clone()], out: &mut sums[kept] });
                for (d, &(ex, ey)) in DIRECTIONS.iter().enumerate().take(level.directions()) {
                    let terms = Terms { weight, pull: &equations.pull[d][at.clone()], sign: 1.0 };
                    spread(level, *simd, *symmetric, j, (dx + ex, dy + ey), terms, sums);
                }
                // The cell itself pulls with minus its diagonal.
                let terms = Terms { weight, pull: &equations.diagonal[at], sign: -1.0 };
                spread(level, *simd, *symmetric, j, (dx, dy), terms, sums);
            }
        }
    }
}

/// A weight and a pull, the product of which is handed to coarse points.
#[derive(Clone, Copy)]
struct Terms<'a> {
    weight: &'a [f32],
    pull: &'a [f32],
    sign: f32,
}

/// Adds what is weighted to the coarse points around the cell at (`x`, `y`) from the coarse point of row `j`.
fn spread(
    level: &Level,
    simd: Simd,
    symmetric: bool,
    j: isize,
    (x, y): (isize, isize),
    terms: Terms<'_>,
    sums: &mut [Vec<f32>],
) {
    let plane = (x & 1) as usize + 2 * (y & 1) as usize;
    let (i, row) = (x >> 1, j + (y >> 1));
    let targets: &[(usize, isize, isize)] = match plane {
        0 => &[(8, 0, 0)],
        1 => &[(0, 0, 0), (1, 1, 0)],
        2 => &[(2, 0, 0), (3, 0, 1)],
        _ => &[(4, 0, 0), (5, 1, 0), (6, 0, 1), (7, 1, 1)],
    };
    for &(weight, dx, dy) in targets {
        let coarse = (i + dx, (y >> 1) + dy);
        let Some(direction) = DIRECTIONS.iter().position(|&d| d == coarse) else { continue };
        let slot = if symmetric { KEPT[direction] } else { Some(direction) };
        let Some(slot) = slot else { continue };
        if weight == 8 {
            simd.run(AddWhere { terms, w: level.w[0].row(row, i), out: &mut sums[slot] });
        } else {
            simd.run(AddProduct { terms, up: level.up[weight].row(row, i), out: &mut sums[slot] });
        }
    }
}

struct Add<'a> {
    a: &'a [f32],
    b: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Add<'_> {
    #[inline(always)]
    fn run(self) {
        for ((o, &a), &b) in self.out.iter_mut().zip(self.a).zip(self.b) {
            *o += a * b;
        }
    }
}

struct AddProduct<'a> {
    terms: Terms<'a>,
    up: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for AddProduct<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let Terms { weight, pull, sign } = self.terms;
        let (weight, pull, up, out) = (&weight[..n], &pull[..n], &self.up[..n], &mut self.out[..n]);
        for i in 0..n {
            out[i] += sign * weight[i] * pull[i] * up[i];
        }
    }
}

struct AddWhere<'a> {
    terms: Terms<'a>,
    w: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for AddWhere<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let Terms { weight, pull, sign } = self.terms;
        let (weight, pull, w, out) = (&weight[..n], &pull[..n], &self.w[..n], &mut self.out[..n]);
        for i in 0..n {
            let term = sign * weight[i] * pull[i];
            out[i] += if w[i] > 0.0 { term } else { 0.0 };
        }
    }
}

struct AddDifference<'a> {
    a: &'a [f32],
    b: &'a [f32],
    c: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for AddDifference<'_> {
    #[inline(always)]
    fn run(self) {
        for (((o, &a), &b), &c) in self.out.iter_mut().zip(self.a).zip(self.b).zip(self.c) {
            *o += a * (b - c);
        }
    }
}
