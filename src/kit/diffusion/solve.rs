//! The door: what is solved, how well, and what comes out.

use std::fmt;

use crate::kit::diffusion::problem::Problem;
use crate::kit::diffusion::solver::Solver;
use crate::work::{Cancelled, Work};

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
    pub(crate) fn nothing(cells: usize) -> Self {
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
/// [`Error::Length`] when an array does not fit the grid; [`Error::Cancelled`] when the work was asked to stop.
pub fn solve(problem: &Problem<'_>, quality: Quality, work: &Work<'_>) -> Result<Solution, Error> {
    Solver::new(quality).solve(problem, work)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::simd::Level;
    use crate::work::Work;

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
                let run =
                    |level| Solver::at(quality, level).solve(&problem, &Work::default()).expect("solves");
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
