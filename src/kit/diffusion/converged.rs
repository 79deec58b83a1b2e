//! The solver that goes on until the error is small: multigrid, iterations, refinement.

use rayon::prelude::*;

use crate::kit::diffusion::cycle::Multigrid;
use crate::kit::diffusion::finest::{correct, finest, residual};
use crate::kit::diffusion::krylov::{Journal, bi_conjugate_gradients, conjugate_gradients};
use crate::kit::diffusion::paper::{Extent, cascade, finish_row};
use crate::kit::diffusion::problem::{Problem, constraint};
use crate::kit::diffusion::scratch::Scratch;
use crate::kit::diffusion::setup::coarsen;
use crate::kit::diffusion::split::{Split, measure, zeros};
use crate::kit::simd::Level as Simd;
use crate::work::{Cancelled, Work};

/// Rounds that do not lower the error by this factor end the work.
const STALL: f64 = 0.5;
/// Cells that one job takes.
const JOB: usize = 1 << 14;

/// A field with what was done for it.
pub(crate) struct Converged {
    pub(crate) field: Vec<f32>,
    pub(crate) cycles: usize,
    /// Estimated errors, in the unit of the field.
    pub(crate) history: Vec<f64>,
    pub(crate) range: f64,
    pub(crate) converged: bool,
}

/// What is made of a matrix once, for as many right sides as there are: all levels, and the vectors of the iterations.
pub(crate) struct Prepared {
    grid: Multigrid,
    r: Split,
    e: Split,
    p: Split,
}

impl Prepared {
    pub(crate) fn new(problem: &Problem<'_>, simd: Simd, work: &Work<'_>) -> Result<Self, Cancelled> {
        let (levels, coarsest) = coarsen(finest(problem, simd), simd, work)?;
        let vector = || zeros(problem.cols, problem.rows);
        Ok(Self { grid: Multigrid { levels, coarsest, simd }, r: vector(), e: vector(), p: vector() })
    }
}

/// Where the iterations start, less the offset.
pub(crate) fn start(
    problem: &Problem<'_>,
    extent: Extent,
    scratch: &mut Scratch,
    simd: Simd,
    work: &Work<'_>,
) -> Result<Vec<f32>, Cancelled> {
    let offset = extent.offset();
    let mut field = if problem.guidance.is_some() {
        // Where guidance leaves the height open, as in flow that comes from the border, this decides.
        let open = Extent { bounded: false, ..extent };
        let mut field = cascade(problem, open, scratch, simd, &work.quiet())?;
        // The levels need the room.
        scratch.clear();
        field.par_iter_mut().for_each(|v| *v -= offset);
        field
    } else {
        vec![0.0f32; problem.len()]
    };
    field.par_iter_mut().zip(problem.fixed).zip(problem.target).for_each(|((o, &f), &t)| {
        let (share, value) = constraint(f, t, offset);
        *o = if share == 1.0 { value } else { *o };
    });
    Ok(field)
}

/// Solves to an estimated error of `tolerance` of the range, from a field on.
///
/// Each round takes the exact residual of the field as it stands and iterates in `f32` for a correction; the work
/// ends when the first estimate of a round is small enough, so no rounding of the iterations goes unseen.
pub(crate) fn converge(
    problem: &Problem<'_>,
    extent: Extent,
    (tolerance, most): (f64, usize),
    prepared: &mut Prepared,
    mut field: Vec<f32>,
    work: &Work<'_>,
) -> Result<Converged, Cancelled> {
    let (cols, offset) = (problem.cols, extent.offset());
    let guided = problem.guidance.is_some();
    let band = JOB / cols + 1;
    let Prepared { grid, r, e, p } = prepared;
    let simd = grid.simd;
    work.report(0.2);
    let mut journal = Journal { work, cycles: 0, most, history: Vec::new(), done: 0.2 };
    let (mut last, mut left, mut best) = (f64::INFINITY, f64::INFINITY, None);
    let (range, converged) = loop {
        let range = spread(&field).max(f64::from(extent.high - extent.low));
        let goal = tolerance.max(0.0) * range;
        residual(problem, offset, &field, simd, r);
        // Where the height is all but open the estimate may err; the residual does not.
        let size = if guided { measure(simd, r, r).1 } else { 0.0 };
        let worse = guided && size > left;
        left = size;
        if journal.cycles >= most && !worse {
            break (range, false);
        }
        let error = if worse {
            f64::INFINITY
        } else if guided {
            bi_conjugate_gradients(grid, (&mut *r, &mut *e, &mut *p), goal, &mut journal)?
        } else {
            conjugate_gradients(grid, (&mut *r, &mut *e, &mut *p), goal, &mut journal)?
        };
        let better = error <= STALL * last;
        if !better && let Some(best) = best.take() {
            // The round before did harm, or as little good as rounding allows.
            if worse || error > last || error.is_nan() {
                field = best;
                break (range, last <= goal);
            }
        }
        if guided {
            best = Some(field.clone());
        }
        last = error;
        if error.is_finite() {
            correct(cols, e, simd, &mut field);
        }
        // The largest of some numbers says nothing of those that are none.
        if guided && !is_finite(&field) {
            field = best.take().unwrap_or(field);
            break (range, false);
        }
        if error <= goal || !better {
            break (range, error <= goal);
        }
    };
    let Journal { cycles, history, .. } = journal;
    field.par_chunks_mut(cols * band).enumerate().for_each(|(b, piece)| {
        finish_row(problem, extent, offset, b * band * cols, simd, piece);
    });
    Ok(Converged { field, cycles, history, range, converged })
}

fn is_finite(field: &[f32]) -> bool {
    field.par_chunks(JOB).all(|block| block.iter().fold(0.0, |sum, v| sum + 0.0 * v) == 0.0)
}

/// The largest minus the smallest value.
fn spread(field: &[f32]) -> f64 {
    let blocks = field
        .par_chunks(JOB)
        .map(|block| block.iter().fold((f32::MAX, f32::MIN), |(low, high), &v| (low.min(v), high.max(v))));
    let (low, high) = blocks.reduce(|| (f32::MAX, f32::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    f64::from(high) - f64::from(low)
}
