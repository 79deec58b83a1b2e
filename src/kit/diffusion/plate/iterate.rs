//! Conjugate gradients on the free cells of a plate.

use rayon::prelude::*;

use crate::kit::diffusion::plate::cycle::Multigrid;
use crate::kit::diffusion::plate::hold::SPRING;
use crate::kit::diffusion::plate::level::{each_row, each_row_of_two};
use crate::kit::diffusion::plate::solve::Plate;
use crate::kit::diffusion::plate::tilt::Across;
use crate::kit::diffusion::solve::Solution;
use crate::kit::simd::{Kernel, Level as Simd};
use crate::work::{Cancelled, Work};

/// The estimated error over the largest element of the preconditioned residual: what exact solves ask for.
const SAFETY: f64 = 4.0;
/// Lanes of a sum: fixed order, whatever the instruction set.
const LANES: usize = 8;

/// The state of the iterations. Which cells are held is written in the springs of the finest level.
pub(crate) struct Bending {
    grid: Multigrid,
    simd: Simd,
    cols: usize,
    /// The field.
    pub(crate) x: Vec<f64>,
    /// Residual, 0 on held cells.
    r: Vec<f64>,
    /// Direction, 0 on held cells.
    p: Vec<f64>,
}

impl Bending {
    /// Takes `middle` off the known values. The cell far `across` a line of known ones is held as well: that decides
    /// the tilt, and bends nothing whatever its value.
    pub(crate) fn new(
        plate: &Plate<'_>,
        across: Option<Across>,
        middle: f64,
        simd: Simd,
        work: &Work<'_>,
    ) -> Result<Self, Cancelled> {
        let cells = 0..plate.cols * plate.rows;
        let held = |k: usize| plate.knows(k) || across.is_some_and(|a| a.far == k);
        let springs = cells.clone().map(|k| if held(k) { SPRING } else { 0.0 }).collect();
        let value = |k: usize| if plate.knows(k) { f64::from(plate.value[k]) - middle } else { 0.0 };
        let x: Vec<f64> = cells.map(value).collect();
        let grid = Multigrid::new(plate.cols, plate.rows, springs, simd, work)?;
        work.report(0.1);
        let (r, p) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        Ok(Self { grid, simd, cols: plate.cols, x, r, p })
    }

    /// Iterates until the estimated error is `tolerance` of the range, or `most` V-cycles are done.
    pub(crate) fn iterate(
        &mut self,
        tolerance: f64,
        most: usize,
        work: &Work<'_>,
    ) -> Result<Solution, Cancelled> {
        let (mut before, mut done, mut history) = (0.0, 0.1f32, Vec::new());
        self.grid.levels[0].subtract(self.simd, &self.x, &mut self.r);
        let held = self.grid.levels[0].hold.own();
        self.r.par_iter_mut().zip(held).for_each(|(r, &h)| *r = if h > 0.0 { 0.0 } else { *r });
        loop {
            work.check()?;
            self.grid.cycle(&self.r);
            let found = self.measure();
            let error = SAFETY * found.error / found.range().max(f64::MIN_POSITIVE);
            history.push(error);
            done += (0.95 - done) * 0.12;
            work.report(done);
            let converged = error <= tolerance;
            if converged || history.len() >= most || !found.product.is_finite() || found.product <= 0.0 {
                return Ok(Solution { field: Vec::new(), cycles: history.len(), history, converged });
            }
            self.turn(if before > 0.0 { found.product / before } else { 0.0 });
            before = found.product;
            let bent = self.apply();
            self.advance(found.product / bent);
        }
    }

    /// What the preconditioned residual tells.
    fn measure(&self) -> Found {
        let level = &self.grid.levels[0];
        let rows: Vec<Found> = (0..self.r.len() / self.cols)
            .into_par_iter()
            .map(|j| {
                let span = j * self.cols..(j + 1) * self.cols;
                let mut found = Found::default();
                let row = [&level.u, &self.r, &self.x].map(|v| &v[span.clone()]);
                self.simd.run(Measure { row, held: &level.hold.own()[span.clone()], found: &mut found });
                found
            })
            .collect();
        let start = Found { product: 0.0, error: 0.0, low: f64::MAX, high: f64::MIN };
        rows.iter().fold(start, Found::and)
    }

    /// Makes the next direction of the preconditioned residual and the last direction.
    fn turn(&mut self, beta: f64) {
        let (cols, level) = (self.cols, &self.grid.levels[0]);
        each_row(cols, &mut self.p, |j, p| {
            let span = j * cols..(j + 1) * cols;
            self.simd.run(Turn { held: &level.hold.own()[span.clone()], z: &level.u[span], beta, p });
        });
    }

    /// Makes the finest level's `r` minus the product with the direction; gives the direction's energy.
    fn apply(&mut self) -> f64 {
        let (simd, cols, p) = (self.simd, self.cols, &self.p);
        let level = &mut self.grid.levels[0];
        let mut product = std::mem::take(&mut level.r);
        product.fill(0.0);
        level.subtract(simd, p, &mut product);
        let rows = product.par_chunks(cols).zip(p.par_chunks(cols));
        let rows: Vec<f64> = rows
            .map(|(a, b)| {
                let mut sum = 0.0;
                simd.run(Dot { a, b, sum: &mut sum });
                sum
            })
            .collect();
        level.r = product;
        -rows.iter().sum::<f64>()
    }

    /// Goes along the direction.
    fn advance(&mut self, alpha: f64) {
        let (simd, cols, p, level) = (self.simd, self.cols, &self.p, &self.grid.levels[0]);
        each_row_of_two(cols, &mut self.x, &mut self.r, |j, x, r| {
            let span = j * cols..(j + 1) * cols;
            let held = &level.hold.own()[span.clone()];
            simd.run(Advance { alpha, held, p: &p[span.clone()], product: &level.r[span], x, r });
        });
    }
}

/// What is found in a row or in all.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Residual times preconditioned residual.
    product: f64,
    /// The largest preconditioned residual.
    error: f64,
    low: f64,
    high: f64,
}

impl Found {
    fn and(self, other: &Self) -> Self {
        Self {
            product: self.product + other.product,
            error: self.error.max(other.error),
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn range(&self) -> f64 {
        self.high - self.low
    }
}

/// The larger of two numbers in one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

struct Measure<'a> {
    /// Preconditioned residual, residual and field.
    row: [&'a [f64]; 3],
    held: &'a [f32],
    found: &'a mut Found,
}

impl Kernel for Measure<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.held.len();
        let [z, r, x] = self.row.map(|v| &v[..n]);
        let held = self.held;
        let (mut product, mut error) = ([0.0f64; LANES], [0.0f64; LANES]);
        let (mut low, mut high) = ([f64::MAX; LANES], [f64::MIN; LANES]);
        let mut step = |k: usize, i: usize| {
            product[k] += r[i] * z[i];
            error[k] = larger(error[k], if held[i] > 0.0 { 0.0 } else { z[i].abs() });
            low[k] = -larger(-low[k], -x[i]);
            high[k] = larger(high[k], x[i]);
        };
        for block in 0..n / LANES {
            for k in 0..LANES {
                step(k, block * LANES + k);
            }
        }
        for i in n / LANES * LANES..n {
            step(i % LANES, i);
        }
        *self.found = Found {
            product: product.iter().sum(),
            error: error.into_iter().fold(0.0, larger),
            low: low.into_iter().fold(f64::MAX, f64::min),
            high: high.into_iter().fold(f64::MIN, larger),
        };
    }
}

struct Turn<'a> {
    held: &'a [f32],
    z: &'a [f64],
    beta: f64,
    p: &'a mut [f64],
}

impl Kernel for Turn<'_> {
    #[inline(always)]
    fn run(self) {
        for ((p, &z), &held) in self.p.iter_mut().zip(self.z).zip(self.held) {
            let next = z + self.beta * *p;
            *p = if held > 0.0 { 0.0 } else { next };
        }
    }
}

struct Dot<'a> {
    a: &'a [f64],
    b: &'a [f64],
    sum: &'a mut f64,
}

impl Kernel for Dot<'_> {
    #[inline(always)]
    fn run(self) {
        let mut sums = [0.0f64; LANES];
        let (a, b) = (self.a.chunks_exact(LANES), self.b.chunks_exact(LANES));
        for (k, (a, b)) in a.remainder().iter().zip(b.remainder()).enumerate() {
            sums[k] += a * b;
        }
        for (a, b) in a.zip(b) {
            for k in 0..LANES {
                sums[k] += a[k] * b[k];
            }
        }
        *self.sum = sums.iter().sum();
    }
}

struct Advance<'a> {
    alpha: f64,
    held: &'a [f32],
    p: &'a [f64],
    /// Minus the product with the direction.
    product: &'a [f64],
    x: &'a mut [f64],
    r: &'a mut [f64],
}

impl Kernel for Advance<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.x.len();
        let (held, p, product) = (&self.held[..n], &self.p[..n], &self.product[..n]);
        let (x, r) = (&mut self.x[..n], &mut self.r[..n]);
        for i in 0..n {
            x[i] += self.alpha * p[i];
            let next = r[i] + self.alpha * product[i];
            r[i] = if held[i] > 0.0 { 0.0 } else { next };
        }
    }
}
