//! Iterations that the V-cycle preconditions: conjugate gradients, and `BiCGStab` where guidance spoils the symmetry.

use crate::kit::diffusion::cycle::Multigrid;
use crate::kit::diffusion::split::{Split, advance, combine, dot, measure, zeros};
use crate::work::{Cancelled, Work};

/// The estimated error over the largest element of the preconditioned residual. A V-cycle finds well over half of
/// the error, so this is on the safe side.
const SAFETY: f64 = 2.0;

/// By how much one round of iterations lowers the error, at most: what `f32` holds for sure.
const ROUND: f64 = 2e-3;

/// Factors of this size are no steps but the breakdown of the iteration.
const BROKEN: f64 = 1e12;

/// When to stop, and what happened so far.
pub(crate) struct Journal<'a> {
    pub(crate) work: &'a Work<'a>,
    /// V-cycles done.
    pub(crate) cycles: usize,
    /// V-cycles allowed.
    pub(crate) most: usize,
    /// Estimated errors, one for each iteration, in the unit of the field.
    pub(crate) history: Vec<f64>,
    /// The finished share of the work, as far as told.
    pub(crate) done: f32,
}

impl Journal<'_> {
    /// Runs a V-cycle; gives the product of its result with the residual, and the estimated error.
    fn precondition(&mut self, grid: &mut Multigrid, r: &Split) -> Result<(f64, f64), Cancelled> {
        self.work.check()?;
        grid.cycle(r);
        self.cycles += 1;
        let (product, most) = measure(grid.simd, r, &grid.levels[0].u);
        // Ten digits or so lie between the first error and the last.
        self.done += (0.95 - self.done) * 0.15;
        self.work.report(self.done);
        Ok((product, SAFETY * most))
    }

    fn spent(&self) -> bool {
        self.cycles >= self.most
    }
}

/// Fills `e` with a correction for the residual `r` whose estimated error is below `goal`, or as near as the cycles
/// allow. `r` is used up, and `p` is for the direction. Gives the estimated error at the start.
pub(crate) fn conjugate_gradients(
    grid: &mut Multigrid,
    (r, e, p): (&mut Split, &mut Split, &mut Split),
    goal: f64,
    journal: &mut Journal<'_>,
) -> Result<f64, Cancelled> {
    let simd = grid.simd;
    clear(e);
    clear(p);
    let (mut start, mut before, mut alpha) = (None, 0.0, 0.0f32);
    loop {
        let (product, error) = journal.precondition(grid, r)?;
        journal.history.push(error);
        let start = *start.get_or_insert(error);
        let level = &grid.levels[0];
        let beta = if before > 0.0 { product / before } else { 0.0 };
        before = product;
        advance(simd, alpha, e, &level.u, beta as f32, p);
        if error <= goal.max(ROUND * start) || journal.spent() {
            combine(simd, 1.0, &level.u, 1.0, e);
            return Ok(start);
        }
        alpha = (product / level.energy(simd, p)) as f32;
        if !(alpha.is_finite() && alpha > 0.0) {
            return Ok(start);
        }
        level.add_applied(simd, -alpha, p, r);
    }
}

/// The same without symmetry.
pub(crate) fn bi_conjugate_gradients(
    grid: &mut Multigrid,
    (r, e, p): (&mut Split, &mut Split, &mut Split),
    goal: f64,
    journal: &mut Journal<'_>,
) -> Result<f64, Cancelled> {
    let simd = grid.simd;
    let (cols, rows) = (grid.levels[0].cols, grid.levels[0].rows);
    let (mut v, mut t) = (zeros(cols, rows), zeros(cols, rows));
    let shadow = r.clone();
    clear(e);
    clear(p);
    let mut start = None;
    let (mut before, mut alpha, mut omega) = (1.0, 1.0, 1.0);
    loop {
        let product = dot(simd, &shadow, r);
        let beta = if start.is_none() { 0.0 } else { product / before * (alpha / omega) };
        before = product;
        if let Some(start) = start.filter(|_| is_broken(beta)) {
            // The residual has nothing left of the shadow: what was found so far stands, and another round starts anew.
            return Ok(start);
        }
        combine(simd, -omega as f32, &v, 1.0, p);
        combine(simd, 1.0, r, beta as f32, p);
        let (_, error) = journal.precondition(grid, p)?;
        let level = &grid.levels[0];
        if start.is_none() {
            // Later on this is no longer an estimate of the error, only of a direction.
            journal.history.push(error);
        }
        let first = start.is_none();
        let start = *start.get_or_insert(error);
        if first && error <= goal {
            combine(simd, 1.0, &level.u, 1.0, e);
            return Ok(start);
        }
        level.apply(simd, &level.u, &mut v);
        alpha = product / dot(simd, &shadow, &v);
        if !(alpha.is_finite() && error.is_finite()) {
            return Ok(start);
        }
        combine(simd, alpha as f32, &level.u, 1.0, e);
        combine(simd, -alpha as f32, &v, 1.0, r);
        let (_, error) = journal.precondition(grid, r)?;
        journal.history.push(error);
        let level = &grid.levels[0];
        level.apply(simd, &level.u, &mut t);
        omega = dot(simd, &t, r) / dot(simd, &t, &t);
        let broken = is_broken(omega) || omega == 0.0;
        if error <= goal.max(ROUND * start) || journal.spent() || broken {
            if error.is_finite() {
                combine(simd, 1.0, &level.u, 1.0, e);
            }
            return Ok(start);
        }
        combine(simd, omega as f32, &level.u, 1.0, e);
        combine(simd, -omega as f32, &t, 1.0, r);
    }
}

/// Whether a factor is too large for a step, or none.
fn is_broken(factor: f64) -> bool {
    !factor.is_finite() || factor.abs() >= BROKEN
}

fn clear(e: &mut Split) {
    for plane in e {
        plane.each_row(|_, row| row.fill(0.0));
    }
}
