//! The door: what is solved, how well, and what comes out.

use std::fmt;

use rayon::prelude::*;

use crate::kit::diffusion::converged::{Prepared, converge, start};
use crate::kit::diffusion::paper::{Extent, cascade};
use crate::kit::diffusion::problem::{HUGE, Problem};
use crate::kit::diffusion::watch::{Cancelled, Watch};
use crate::kit::simd::Level;

/// How well a problem is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quality {
    /// The papers' cascade: `5 (l - i)` Jacobi sweeps on level `i` of `l`, 0 the coarsest \[hnaidi2010, 5.2\]. Fast,
    /// and not converged far from the constraints.
    Paper,
    /// Multigrid until the estimated error is below a share of the range.
    Converged {
        /// Largest estimated error, as a share of the range of constraints and field; 1e-5 is usual, and below
        /// 1e-7 is not reached.
        tolerance: f64,
        /// V-cycles after which the work ends whatever the error.
        cycles: usize,
    },
}

impl Quality {
    /// Multigrid down to 1e-5 of the range.
    pub const CONVERGED: Self = Self::Converged { tolerance: 1e-5, cycles: 200 };
}

/// A diffused field.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// One value for each cell, row by row, in the unit of the constraints.
    pub field: Vec<f32>,
    /// V-cycles done; 0 in `Paper` quality.
    pub cycles: usize,
    /// Estimated largest error after each step, as a share of the range; empty in `Paper` quality.
    pub history: Vec<f64>,
    /// Whether the tolerance was met; true in `Paper` quality, which has none.
    pub converged: bool,
}

impl Solution {
    /// Zeros.
    fn nothing(cells: usize) -> Self {
        Self { field: vec![0.0; cells], cycles: 0, history: Vec::new(), converged: true }
    }
}

/// Why there is no field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The work was asked to stop.
    Cancelled,
    /// An array of the problem has another length than the grid has cells.
    Length {
        /// Name of the array.
        array: &'static str,
        /// Its length.
        found: usize,
        /// Number of cells.
        expected: usize,
    },
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled => f.write_str("the work was asked to stop"),
            Self::Length { array, found, expected } => {
                write!(f, "`{array}` must have a value for each of {expected} cells, got {found}")
            }
        }
    }
}

impl std::error::Error for Error {}

/// Solves a diffusion problem.
///
/// The result is finite whatever the input, and the same to the bit for any number of threads and instruction set.
/// Without constraint, guidance and source it is zero. With guidance or source but no constraint, the border is held
/// at zero, since nothing else says how high the field lies. Where neither guides, no value leaves the range of the
/// constraints, and strict constraints are met to the bit.
///
/// # Errors
/// [`Error::Length`] when an array does not fit the grid; [`Error::Cancelled`] when the watch asks to stop.
pub fn solve(problem: &Problem<'_>, quality: Quality, watch: &dyn Watch) -> Result<Solution, Error> {
    solve_at(problem, quality, watch, Level::best())
}

pub(crate) fn solve_at(
    problem: &Problem<'_>,
    quality: Quality,
    watch: &dyn Watch,
    level: Level,
) -> Result<Solution, Error> {
    if let Some((array, found)) = problem.misfit() {
        return Err(Error::Length { array, found, expected: problem.len() });
    }
    watch.check()?;
    let (extent, guided) = survey(problem, level);
    let problem = Problem { guidance: problem.guidance.filter(|_| guided), ..*problem };
    let shaped = guided || problem.source.is_some_and(|s| s.iter().any(|&s| s != 0.0));
    match extent {
        Some((low, high)) => {
            let extent = Extent { low, high, bounded: !shaped };
            run(&problem, extent, quality, &mut None, watch, level)
        }
        None if shaped && problem.len() > 0 => anchored(&problem, quality, watch, level),
        None => Ok(Solution::nothing(problem.len())),
    }
}

/// Solves for several targets of the same constraints: `problem`'s own target is not read, and it must not have
/// guidance. Each solution is the same to the bit as by itself; what depends on the constraints alone is made once.
///
/// # Errors
/// As [`solve`].
pub fn solve_all(
    problem: &Problem<'_>,
    targets: &[&[f32]],
    quality: Quality,
    watch: &dyn Watch,
) -> Result<Vec<Solution>, Error> {
    let level = Level::best();
    let mut shared = None;
    let one = |(k, &target): (usize, &&[f32])| {
        let watch = Share { watch, part: k, of: targets.len() };
        let problem = Problem { target, ..*problem };
        if let Some((array, found)) = problem.misfit() {
            return Err(Error::Length { array, found, expected: problem.len() });
        }
        let unsound = |(&f, &t): (&f32, &f32)| f > 0.0 && t.is_nan() | (t.abs() >= HUGE);
        let plain = problem.guidance.is_none() && problem.source.is_none();
        if !plain || problem.fixed.par_iter().zip(target).any(unsound) {
            // Which constraints there are depends on the target.
            return solve_at(&problem, quality, &watch, level);
        }
        watch.check()?;
        match survey(&problem, level).0 {
            Some((low, high)) => {
                let extent = Extent { low, high, bounded: true };
                run(&problem, extent, quality, &mut shared, &watch, level)
            }
            None => Ok(Solution::nothing(problem.len())),
        }
    };
    targets.iter().enumerate().map(one).collect()
}

/// The least and the largest constraint, none where there are none, and whether guidance has weight.
fn survey(problem: &Problem<'_>, level: Level) -> (Option<(f32, f32)>, bool) {
    let (low, high, guided) = (0..problem.rows)
        .into_par_iter()
        .map(|j| problem.survey(level, j))
        .reduce(|| (HUGE, -HUGE, false), |a, b| (a.0.min(b.0), a.1.max(b.1), a.2 || b.2));
    ((low <= high).then_some((low, high)), guided)
}

/// Solves with the border held at zero.
fn anchored(
    problem: &Problem<'_>,
    quality: Quality,
    watch: &dyn Watch,
    level: Level,
) -> Result<Solution, Error> {
    let (cols, rows) = (problem.cols, problem.rows);
    let border = |k: usize| {
        let (i, j) = (k % cols, k / cols);
        i == 0 || j == 0 || i + 1 == cols || j + 1 == rows
    };
    let fixed: Vec<f32> = (0..problem.len()).map(|k| if border(k) { 1.0 } else { 0.0 }).collect();
    let target = vec![0.0; problem.len()];
    let anchored = Problem { fixed: &fixed, target: &target, ..*problem };
    let extent = Extent { low: 0.0, high: 0.0, bounded: false };
    run(&anchored, extent, quality, &mut None, watch, level)
}

/// Solves what has constraints; `prepared` is what was made for the same matrix before.
fn run(
    problem: &Problem<'_>,
    extent: Extent,
    quality: Quality,
    prepared: &mut Option<Prepared>,
    watch: &dyn Watch,
    level: Level,
) -> Result<Solution, Error> {
    let solution = match quality {
        Quality::Paper => {
            let field = cascade(problem, extent, level, watch)?;
            Solution { field, cycles: 0, history: Vec::new(), converged: true }
        }
        Quality::Converged { tolerance, cycles } => {
            let field = start(problem, extent, level, watch)?;
            watch.progress(0.1);
            let prepared = match prepared {
                Some(prepared) => prepared,
                None => prepared.insert(Prepared::new(problem, level, watch)?),
            };
            let found = converge(problem, extent, (tolerance, cycles), prepared, field, watch)?;
            let scale = if found.range > 0.0 { 1.0 / found.range } else { 1.0 };
            let history: Vec<f64> = found.history.iter().map(|e| e * scale).collect();
            Solution { field: found.field, cycles: found.cycles, history, converged: found.converged }
        }
    };
    watch.progress(1.0);
    Ok(solution)
}

/// The part of the work that one of several solutions is.
struct Share<'a> {
    watch: &'a dyn Watch,
    part: usize,
    of: usize,
}

impl Watch for Share<'_> {
    fn cancelled(&self) -> bool {
        self.watch.cancelled()
    }

    fn progress(&self, done: f32) {
        self.watch.progress((self.part as f32 + done) / self.of as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::diffusion::watch::Silent;

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let (cols, rows) = (131, 94);
        let n = cols * rows;
        let map = |f: &dyn Fn(usize) -> f32| (0..n).map(f).collect::<Vec<f32>>();
        let fixed = map(&|k| if k % 211 == 5 { 1.0 } else { 0.0 });
        let target = map(&|k| (k * 7919 % 1000) as f32);
        let weight = map(&|k| if k % 211 < 60 { 0.5 } else { 0.0 });
        let slope = map(&|k| (k % 7) as f32 * 0.1);
        let guidance = crate::kit::diffusion::Guidance {
            weight: &weight,
            x: &slope,
            y: &weight,
            slope: &slope,
            cell: 3.0,
        };
        for guidance in [None, Some(guidance)] {
            let problem = Problem { cols, rows, fixed: &fixed, target: &target, guidance, source: None };
            for quality in [Quality::Paper, Quality::CONVERGED] {
                let run = |level| solve_at(&problem, quality, &Silent, level).expect("solves");
                let base = run(Level::BASELINE);
                for level in Level::available() {
                    let other = run(level);
                    assert!(
                        base.field.iter().zip(&other.field).all(|(a, b)| a.to_bits() == b.to_bits()),
                        "{level:?}"
                    );
                    assert_eq!(base.history, other.history);
                }
            }
        }
    }
}
