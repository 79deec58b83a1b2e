//! Thin plates: the least-bent field through known samples.
//!
//! # Theory
//! The field is known on some cells and elsewhere as it makes the bending energy `Σ u_xx² + 2 u_xy² + u_yy²` least, in
//! second differences wherever the grid has them \[szeliski1990\]. That is the 13-point biharmonic equation with a
//! natural border: an even slope costs nothing and goes on to the border and beyond all constraints.
//!
//! Conjugate gradients on the free cells, preconditioned by a multigrid of the plate that hangs from springs instead:
//! `K + λ C`, with `K` the bending, and `C` one at known cells. With `λ` near the size of `K` the spring plate, seen
//! from the free cells, is equivalent to the held one with a bound that no layout of the known cells can break:
//! whatever value a spring gives way to costs about what cutting it off would. On coarse levels `K` is bending on the
//! coarse grid, of known shape, and `C` the Galerkin product with bilinear interpolation, which knows of every known
//! cell; `D⁻¹ (K + λ C)` has no eigenvalue above 4, since both are sums of squares of at most four cells each. That
//! lets Chebyshev polynomials of the fourth kind \[lottes2023\] smooth without a guess. Bilinear interpolation of a
//! bent field has kinks, so levels are smoothed the more the coarser they are, twice as often each \[bramble1987\].
//!
//! All is held in `f64`: the equations of a wide plate have the condition of its width to the fourth power.
//!
//! # Limits
//! Known cells that lie on one straight line leave the tilt across it open: the plate then has no mean tilt across
//! it. One known cell gives a constant, none gives 0. Values lie beyond those of the known cells where the plate swings.
//! Memory beside the input is about 20 `f32` grids.

mod axis;
mod cycle;
mod hold;
mod iterate;
mod level;
mod solve;
mod tilt;

pub use solve::{Plate, bend};
