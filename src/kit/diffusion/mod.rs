//! Diffusion of constraints over a grid: Laplace, guided by slopes, soft or strict, to any accuracy.
//!
//! # Theory
//! The new value of a cell is a weighted mean of three \[hnaidi2010, 5.2\]:
//! ```text
//! F = laplace · (F_W + F_E + F_N + F_S) / 4  +  gradient · (F_upwind + G)  +  fixed · target
//! F_upwind + G = (|n_x| (F_x + cell tan θ |n_x|) + |n_y| (F_y + cell tan θ |n_y|)) / (|n_x| + |n_y|)
//! ```
//! with `n` the unit direction of the guidance, θ the angle at which the field rises along it, and `F_x`, `F_y` the
//! neighbours against the direction along each axis; together `G = cell tan θ / (|n_x| + |n_y|)`. The border is
//! natural: beyond it the field goes on as in the border cell, and the part of the guidance whose neighbour lies
//! there goes to `laplace`. A source adds to the mean: `ΔF = -4 source / cell²`.
//!
//! [`Quality::Paper`] halves the problem until one cell is left, and goes from there to the finest level with
//! `5 (l - i)` Jacobi sweeps on level `i` of `l`. The paper numbers its `l` levels from 0, the coarsest, to `l - 1`,
//! the finest, so the finest has 5 sweeps and the coarsest `5 l`. A coarse cell has twice the mean share of its cells
//! (which keeps lines thin), and at least half that of a lone point. About 9 sweeps' worth of work a cell in all, done on tiles that lie in the fast cache.
//!
//! [`Quality::Converged`] solves the equations themselves. Galerkin multigrid with interpolation that follows the
//! equations (black box multigrid \[dendy1982\]): it vanishes on fixed cells and stops at lines of them, so thin
//! lines and single points hold on every level, where rediscretised or averaged constraints stall. One V-cycle with
//! a red-black (coarse: four-colour) Gauss-Seidel sweep before and after is the preconditioner of conjugate
//! gradients, or of `BiCGStab` where guidance makes the matrix unsymmetric. There restriction follows the transposed
//! equations \[dendy1983\], and negative couplings of coarse levels are dropped, which keeps them stable in strong
//! flow. All is held in `f32`; rounds of refinement take the residual in `f64`, as sums of differences, so that the
//! accuracy is that of the field's own digits.
//!
//! # Differs from the paper
//! - The papers' weights `n_x²`, `n_y²` with `G = tan θ` yield a slope of `tan θ / (|n_x|³ + |n_y|³)`, 41 % too steep
//!   at 45°; those above are exact in every direction. `G` is a height difference, so it goes with the cell of the
//!   level, and with tan, not sin as in \[weiss2015, V\].
//! - At least 1/256 of what `fixed` leaves goes to `laplace`: closed loops of guidance alone have no solution.
//! - Fixed cells start each level at their target instead of the interpolated value.
//! - Slopes without any fixed cell would leave the height open: then the border is held at zero.
//!
//! # Limits
//! Guidance that flows from the border, or from a divide between two flows, across many cells to the next fixed one
//! leaves the height there all but open (5⁻ⁿ for n cells at equal weights). In `Converged` quality the work then ends
//! when it no longer gains; the field is the best that was found, no worse than the papers', and
//! [`Solution::converged`] is false.
//!
//! The result has the same bits for any number of threads and any instruction set.

mod converged;
mod cycle;
mod dense;
mod direction;
mod finest;
mod galerkin;
mod krylov;
mod level;
mod paper;
mod plate;
mod problem;
mod pyramid;
mod scratch;
mod setup;
mod solve;
mod solver;
mod split;

pub use crate::work::Cancelled;
pub use direction::renormalise;
pub use paper::scratch;
pub use plate::{Plate, bend};
pub use problem::{Guidance, Problem};
pub use solve::{Error, Quality, Solution, solve};
pub use solver::Solver;
