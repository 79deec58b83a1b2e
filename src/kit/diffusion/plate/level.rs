//! One level of the plate: its equations, products with them, and the smoother.

use rayon::prelude::*;

use crate::kit::diffusion::plate::axis::Axis;
use crate::kit::diffusion::plate::hold::Hold;
use crate::kit::simd::{Kernel, Level as Simd};

/// No eigenvalue of `D⁻¹ A` is larger: both bending and springs are sums of squares of at most four cells.
const LARGEST: f64 = 4.0;
/// Cells below which one thread does the work.
const ALONE: usize = 1 << 13;
/// Cells that one job takes.
const JOB: usize = 1 << 14;

/// The equations `(K + λ C) u = b` on a grid.
#[derive(Debug)]
pub(crate) struct Level {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) hold: Hold,
    /// One over the diagonal and over [`LARGEST`].
    over: Vec<f32>,
    /// Right side; empty on the finest level, which is handed one.
    pub(crate) b: Vec<f64>,
    pub(crate) u: Vec<f64>,
    /// Residual.
    pub(crate) r: Vec<f64>,
    /// The last step of the smoother.
    step: Vec<f64>,
}

impl Level {
    pub(crate) fn new(x: Axis, y: Axis, hold: Hold, finest: bool) -> Self {
        let n = x.cells() * y.cells();
        let zeros = || vec![0.0f64; n];
        let b = if finest { Vec::new() } else { zeros() };
        let mut out = Self { x, y, hold, over: vec![0.0; n], b, u: zeros(), r: zeros(), step: zeros() };
        let mut over = std::mem::take(&mut out.over);
        each_row(out.x.cells(), &mut over, |j, row| {
            for (i, o) in row.iter_mut().enumerate() {
                let diagonal = out.diagonal(i, j);
                *o = if diagonal > 0.0 { (1.0 / (LARGEST * diagonal)) as f32 } else { 0.0 };
            }
        });
        out.over = over;
        out
    }

    pub(crate) fn halved(&self) -> Self {
        Self::new(self.x.halved(), self.y.halved(), self.hold.halved(&self.x, &self.y), false)
    }

    /// What second differences along x, both axes and y are multiplied by: a sum over cells stands for an integral.
    fn stiffness(&self) -> [f64; 3] {
        let (hx, hy) = (self.x.cell, self.y.cell);
        [hy / (hx * hx * hx), 2.0 / (hx * hy), hx / (hy * hy * hy)]
    }

    fn diagonal(&self, i: usize, j: usize) -> f64 {
        let [a, b, c] = self.stiffness();
        let bend =
            a * self.x.bend[i][2] + c * self.y.bend[j][2] + b * self.x.slope[i][1] * self.y.slope[j][1];
        bend + f64::from(self.hold.own()[j * self.x.cells() + i])
    }

    /// Takes row `j` of the product with `u` off `out`.
    pub(crate) fn subtract_row(&self, simd: Simd, u: &[f64], j: usize, out: &mut [f64]) {
        let (cols, rows) = (self.x.cells(), self.y.cells());
        let near: [&[f64]; 5] = std::array::from_fn(|k| {
            let row = (j + k).saturating_sub(2).min(rows - 1);
            &u[row * cols..(row + 1) * cols]
        });
        let (stiffness, across) = (self.stiffness(), (&self.y.bend[j], &self.y.slope[j]));
        for i in (0..cols).filter(|&i| i < 2 || i + 2 >= cols) {
            out[i] -= bend_at(stiffness, (&self.x.bend[i], &self.x.slope[i]), across, &near, i);
        }
        if cols > 4 {
            let [a, b, c] = stiffness;
            let (bend, slope) = (across.0.map(|v| v * c), across.1.map(|v| v * b));
            simd.run(Inside {
                near,
                // North, here and south: the cell, and those beside it.
                own: [bend[1] + 2.0 * slope[0], bend[2] + 2.0 * slope[1] + 6.0 * a, bend[3] + 2.0 * slope[2]],
                beside: [-slope[0], -slope[1] - 4.0 * a, -slope[2]],
                far: [bend[0], a, bend[4]],
                out: &mut out[2..cols - 2],
            });
        }
        simd.run(Springs { hold: &self.hold, u, j, out });
    }

    /// Takes the product with `u` off `out`.
    pub(crate) fn subtract(&self, simd: Simd, u: &[f64], out: &mut [f64]) {
        each_row(self.x.cells(), out, |j, row| self.subtract_row(simd, u, j, row));
    }

    /// Makes `r` the residual of `u` for the right side `b`.
    pub(crate) fn start(&mut self, simd: Simd, b: &[f64]) {
        let (u, mut r) = (std::mem::take(&mut self.u), std::mem::take(&mut self.r));
        r.copy_from_slice(b);
        self.subtract(simd, &u, &mut r);
        (self.u, self.r) = (u, r);
    }

    /// Smooths `u`, whose residual is `r`, by a Chebyshev polynomial of the fourth kind \[lottes2023\]. The residual
    /// is kept up to date but for the last step where it is not `wanted`.
    pub(crate) fn smooth(&mut self, simd: Simd, degree: usize, wanted: bool) {
        let cols = self.x.cells();
        let (mut u, mut r, mut step) =
            (std::mem::take(&mut self.u), std::mem::take(&mut self.r), std::mem::take(&mut self.step));
        for k in 1..=degree {
            let k = k as f64;
            let again = (2.0 * k - 3.0) / (2.0 * k + 1.0);
            let again = if k == 1.0 { 0.0 } else { again };
            let fresh = (8.0 * k - 4.0) / (2.0 * k + 1.0);
            each_row_of_two(cols, &mut u, &mut step, |j, u, step| {
                let span = j * cols..(j + 1) * cols;
                simd.run(Step { again, fresh, over: &self.over[span.clone()], r: &r[span], u, step });
            });
            if wanted || k < degree as f64 {
                self.subtract(simd, &step, &mut r);
            }
        }
        (self.u, self.r, self.step) = (u, r, step);
    }
}

/// One row of the bending at a cell near the border.
fn bend_at(
    [a, b, c]: [f64; 3],
    (bend_x, slope_x): (&[f64; 5], &[f64; 3]),
    (bend_y, slope_y): (&[f64; 5], &[f64; 3]),
    near: &[&[f64]; 5],
    i: usize,
) -> f64 {
    let last = near[2].len() - 1;
    // Beyond the border the weights are 0.
    let at = |row: usize, shift: usize| near[row][(i + shift).saturating_sub(2).min(last)];
    let mut sum = 0.0;
    for k in 0..5 {
        sum += a * bend_x[k] * at(2, k) + c * bend_y[k] * at(k, 2);
    }
    for (dy, pull) in slope_y.iter().enumerate() {
        let row = slope_x.iter().enumerate().map(|(dx, p)| p * at(dy + 1, dx + 1)).sum::<f64>();
        sum += b * pull * row;
    }
    sum
}

/// The bending of a row, but for the two cells at each end.
struct Inside<'a> {
    near: [&'a [f64]; 5],
    own: [f64; 3],
    beside: [f64; 3],
    far: [f64; 3],
    out: &'a mut [f64],
}

impl Kernel for Inside<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let [far_north, north, here, south, far_south] = self.near.map(|row| &row[..n + 4]);
        let (own, beside, far) = (self.own, self.beside, self.far);
        let out = &mut self.out[..n];
        for i in 0..n {
            let row = |r: &[f64], k: usize| own[k] * r[i + 2] + beside[k] * (r[i + 1] + r[i + 3]);
            let nearest = (row(north, 0) + row(south, 2)) + row(here, 1);
            let along = far[1] * (here[i] + here[i + 4]);
            let across = far[0] * far_north[i + 2] + far[2] * far_south[i + 2];
            out[i] -= nearest + (along + across);
        }
    }
}

struct Springs<'a> {
    hold: &'a Hold,
    u: &'a [f64],
    j: usize,
    out: &'a mut [f64],
}

impl Kernel for Springs<'_> {
    #[inline(always)]
    fn run(self) {
        self.hold.subtract(self.u, self.j, self.out);
    }
}

/// A step of the smoother.
struct Step<'a> {
    again: f64,
    fresh: f64,
    over: &'a [f32],
    r: &'a [f64],
    u: &'a mut [f64],
    step: &'a mut [f64],
}

impl Kernel for Step<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.u.len();
        let (over, r) = (&self.over[..n], &self.r[..n]);
        let (u, step) = (&mut self.u[..n], &mut self.step[..n]);
        for i in 0..n {
            step[i] = self.again * step[i] + self.fresh * (f64::from(over[i]) * r[i]);
            u[i] += step[i];
        }
    }
}

/// Calls `f` with each row of a grid and its number.
pub(crate) fn each_row<T: Send>(cols: usize, out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
    let band = JOB / cols + 1;
    let work = |(b, rows): (usize, &mut [T])| {
        rows.chunks_mut(cols).enumerate().for_each(|(k, row)| f(b * band + k, row));
    };
    if out.len() < ALONE {
        out.chunks_mut(cols * band).enumerate().for_each(work);
    } else {
        out.par_chunks_mut(cols * band).enumerate().for_each(work);
    }
}

/// The same with the rows of two grids of one size.
pub(crate) fn each_row_of_two<T: Send>(
    cols: usize,
    a: &mut [T],
    b: &mut [T],
    f: impl Fn(usize, &mut [T], &mut [T]) + Sync,
) {
    let band = JOB / cols + 1;
    let work = |(at, (a, b)): (usize, (&mut [T], &mut [T]))| {
        let rows = a.chunks_mut(cols).zip(b.chunks_mut(cols));
        rows.enumerate().for_each(|(k, (a, b))| f(at * band + k, a, b));
    };
    if a.len() < ALONE {
        a.chunks_mut(cols * band).zip(b.chunks_mut(cols * band)).enumerate().for_each(work);
    } else {
        a.par_chunks_mut(cols * band).zip(b.par_chunks_mut(cols * band)).enumerate().for_each(work);
    }
}
