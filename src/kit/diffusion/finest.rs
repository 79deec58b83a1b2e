//! The finest level: from the problem to the planes of the multigrid and back, and the exact residual.
//!
//! A row of the matrix is the cell's equation times `4 / laplace`, so that cells without guidance pull at each other
//! by 1 and the matrix is symmetric wherever nothing guides. Strictly constrained cells are held at zero: the
//! multigrid solves for corrections.

use crate::kit::diffusion::level::{Level, Pull};
use crate::kit::diffusion::problem::{Equation, Problem, constraint};
use crate::kit::diffusion::split::{Deal, Merge, Plane, Split, bands, zeros};
use crate::kit::simd::{Kernel, Level as Simd};

/// Laplace weights that guided rows are divided by, at least.
const LEAST: f32 = 0.125;
/// Sums of weights nearer to the Laplace weight than this have no guidance in them.
const UNGUIDED: f32 = 1e-6;

/// What a cell's equation is multiplied by.
#[inline(always)]
fn scale(laplace: f32, sum: f32) -> f32 {
    let guided = sum - laplace > UNGUIDED;
    let by = if guided & (laplace < LEAST) { LEAST } else { laplace };
    if laplace > 0.0 { 4.0 / by } else { 0.0 }
}

/// Makes the finest level of a problem.
pub(crate) fn finest(problem: &Problem<'_>, simd: Simd) -> Level {
    let (cols, rows) = (problem.cols, problem.rows);
    let guided = problem.guidance.is_some();
    let mut w = zeros(cols, rows);
    let mut pulls: Vec<Split> = (0..if guided { 4 } else { 0 }).map(|_| zeros(cols, rows)).collect();
    let mut excess = guided.then(|| zeros(cols, rows));
    let mut planes: Vec<&mut Plane> =
        w.iter_mut().chain(pulls.iter_mut().flatten()).chain(excess.iter_mut().flatten()).collect();
    let stride = cols.div_ceil(2) + 2;
    bands(&mut planes, |first, pieces| {
        let mut equation = Equation::new(cols);
        // w, west, east, north, south, excess.
        let mut lines = vec![vec![0.0f32; cols]; if guided { 6 } else { 1 }];
        for k in 0..pieces[0].len() / stride {
            for half in 0..2 {
                let j = 2 * (first + k) + half;
                if j >= rows {
                    continue;
                }
                problem.equation(simd, j, 0, cols, 0.0, &mut equation);
                let across = usize::from(j > 0) + usize::from(j + 1 < rows);
                if guided {
                    guided_row(problem, &equation, j, &mut lines);
                } else {
                    simd.run(Diagonal { equation: &equation, across: across as f32, out: &mut lines[0] });
                }
                for (v, line) in lines.iter().enumerate() {
                    let span = k * stride + 1..(k + 1) * stride - 1;
                    let (left, right) = pieces.split_at_mut(4 * v + 2 * half + 1);
                    let even = &mut left[4 * v + 2 * half][span.clone()];
                    simd.run(Deal { line, even, odd: &mut right[0][span] });
                }
            }
        }
    });
    let pull = if guided { Pull::Each(pulls) } else { Pull::Unit };
    let mut level = Level::new(cols, rows, pull, w, excess);
    level.b = Split::default();
    level
}

/// One over the diagonal of a row without guidance; `across` is the number of neighbours above and below.
struct Diagonal<'a> {
    equation: &'a Equation,
    across: f32,
    out: &'a mut [f32],
}

impl Kernel for Diagonal<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let (fixed, laplace) = (&self.equation.fixed[..n], &self.equation.laplace[..n]);
        let out = &mut self.out[..n];
        for i in 0..n {
            out[i] = over_diagonal(fixed[i], laplace[i], self.across + 2.0);
        }
        // The two ends lack a neighbour.
        let ends = if n == 1 { self.across } else { self.across + 1.0 };
        for end in [0, n - 1] {
            self.out[end] = over_diagonal(fixed[end], laplace[end], ends);
        }
    }
}

/// One over what stands on the diagonal; 0 where the cell is held.
#[inline(always)]
fn over_diagonal(fixed: f32, laplace: f32, neighbours: f32) -> f32 {
    let diagonal = neighbours + 4.0 * fixed / laplace;
    if (laplace > 0.0) & (diagonal > 0.0) { 1.0 / diagonal } else { 0.0 }
}

/// The six lines of a guided row: `w`, the pulls from west, east, north and south, the excess.
fn guided_row(problem: &Problem<'_>, equation: &Equation, j: usize, lines: &mut [Vec<f32>]) {
    let [w, west, east, north, south, excess] = lines else { return };
    let (cols, rows) = (problem.cols, problem.rows);
    let free = |i: usize, j: usize| {
        let at = j * cols + i;
        constraint(problem.fixed[at], problem.target[at], 0.0).0 < 1.0
    };
    for (i, &laplace) in equation.laplace.iter().enumerate() {
        let pulls = [equation.west[i], equation.east[i], equation.north[i], equation.south[i]];
        let k = scale(laplace, (pulls[0] + pulls[1]) + (pulls[2] + pulls[3]));
        let other = [
            (i > 0).then(|| free(i - 1, j)),
            (i + 1 < cols).then(|| free(i + 1, j)),
            (j > 0).then(|| free(i, j - 1)),
            (j + 1 < rows).then(|| free(i, j + 1)),
        ];
        let (mut sum, mut held) = (0.0, k * equation.fixed[i]);
        let lines = [&mut *west, &mut *east, &mut *north, &mut *south];
        for ((line, pull), other) in lines.into_iter().zip(pulls).zip(other) {
            line[i] = if other == Some(true) { k * pull } else { 0.0 };
            sum += line[i];
            held += if other == Some(false) { k * pull } else { 0.0 };
        }
        let solved = laplace > 0.0;
        w[i] = if solved && sum + held > 0.0 { 1.0 / (sum + held) } else { 0.0 };
        excess[i] = if solved { held } else { 0.0 };
    }
}

/// Fills `out` with the residual of a field, summed in `f64` as differences, so that a constant field has none.
pub(crate) fn residual(problem: &Problem<'_>, offset: f32, field: &[f32], simd: Simd, out: &mut Split) {
    let (cols, rows) = (problem.cols, problem.rows);
    let stride = cols.div_ceil(2) + 2;
    let mut planes: Vec<&mut Plane> = out.iter_mut().collect();
    bands(&mut planes, |first, pieces| {
        let mut equation = Equation::new(cols);
        let (mut line, mut here) = (vec![0.0f32; cols], vec![0.0f32; cols + 2]);
        for k in 0..pieces[0].len() / stride {
            for half in 0..2 {
                let j = 2 * (first + k) + half;
                if j >= rows {
                    continue;
                }
                problem.equation(simd, j, 0, cols, offset, &mut equation);
                let row = |j: usize| &field[j * cols..(j + 1) * cols];
                // Beyond the border the field goes on.
                here[1..=cols].copy_from_slice(row(j));
                (here[0], here[cols + 1]) = (here[1], here[cols]);
                simd.run(Residual {
                    equation: &equation,
                    here: &here,
                    north: row(j.saturating_sub(1)),
                    south: row((j + 1).min(rows - 1)),
                    out: &mut line,
                });
                let span = k * stride + 1..(k + 1) * stride - 1;
                let (left, right) = pieces.split_at_mut(2 * half + 1);
                let even = &mut left[2 * half][span.clone()];
                simd.run(Deal { line: &line, even, odd: &mut right[0][span] });
            }
        }
    });
}

struct Residual<'a> {
    equation: &'a Equation,
    here: &'a [f32],
    north: &'a [f32],
    south: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Residual<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let e = self.equation;
        let (west, east, north, south) = (&e.west[..n], &e.east[..n], &e.north[..n], &e.south[..n]);
        let (add, fixed, laplace) = (&e.add[..n], &e.fixed[..n], &e.laplace[..n]);
        let (w, own, o) = (&self.here[..n], &self.here[1..=n], &self.here[2..n + 2]);
        let (u, d) = (&self.north[..n], &self.south[..n]);
        let out = &mut self.out[..n];
        for i in 0..n {
            let f = f64::from(own[i]);
            let across = pull(west[i], w[i], f) + pull(east[i], o[i], f);
            let along = pull(north[i], u[i], f) + pull(south[i], d[i], f);
            let rest = f64::from(add[i]) - f64::from(fixed[i]) * f;
            let k = scale(laplace[i], (west[i] + east[i]) + (north[i] + south[i]));
            out[i] = (f64::from(k) * (across + along + rest)) as f32;
        }
    }
}

/// What a neighbour adds to the residual.
#[inline(always)]
fn pull(weight: f32, other: f32, own: f64) -> f64 {
    f64::from(weight) * (f64::from(other) - own)
}

/// Adds a correction to a field.
pub(crate) fn correct(cols: usize, correction: &Split, simd: Simd, field: &mut [f32]) {
    use rayon::prelude::*;
    let band = (1 << 14) / cols + 1;
    field.par_chunks_mut(cols * band).enumerate().for_each(|(b, rows)| {
        let mut line = vec![0.0; cols];
        for (k, row) in rows.chunks_mut(cols).enumerate() {
            let j = b * band + k;
            let (half, at) = (2 * (j % 2), (j / 2) as isize);
            simd.run(Merge {
                even: correction[half].row(at, 0),
                odd: correction[half + 1].row(at, 0),
                line: &mut line,
            });
            row.iter_mut().zip(&line).for_each(|(o, &c)| *o += c);
        }
    });
}
