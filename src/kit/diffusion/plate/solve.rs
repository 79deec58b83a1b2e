//! The door: known cells in, the least-bent field out.

use rayon::prelude::*;

use crate::kit::diffusion::plate::iterate::Bending;
use crate::kit::diffusion::plate::tilt::{Across, Layout, layout};
use crate::kit::diffusion::problem::HUGE;
use crate::kit::diffusion::solve::{Error, Solution};
use crate::kit::simd::Level as Simd;
use crate::work::Work;

/// A field on `cols × rows` cells, row by row, of which some cells are known.
#[derive(Clone, Copy, Debug)]
pub struct Plate<'a> {
    /// Cells along x.
    pub cols: usize,
    /// Cells along y.
    pub rows: usize,
    /// Above 0 where the value is known.
    pub known: &'a [f32],
    /// The values; one that is not a number, or beyond 1e30, is not known.
    pub value: &'a [f32],
}

impl Plate<'_> {
    /// The usual tolerance of [`bend`].
    pub const TOLERANCE: f64 = 1e-5;
    /// V-cycles that are enough for any plate that was tried, ten times over.
    pub const CYCLES: usize = 250;

    pub(crate) fn knows(&self, cell: usize) -> bool {
        self.known[cell] > 0.0 && self.value[cell].abs() < HUGE
    }
}

/// Fills in the cells that are not known so that the whole is bent as little as can be, to an estimated error of
/// `tolerance` of the range, or as near as a number of V-`cycles` allows. Known cells stay as they are, to the bit.
///
/// The result is finite whatever the input, and the same to the bit for any number of threads and instruction set.
///
/// # Errors
/// [`Error::Length`] when an array does not fit the grid; [`Error::Cancelled`] when the work was asked to stop.
pub fn bend(plate: &Plate<'_>, tolerance: f64, cycles: usize, work: &Work<'_>) -> Result<Solution, Error> {
    bend_at(plate, tolerance, cycles, work, Simd::best())
}

pub(crate) fn bend_at(
    plate: &Plate<'_>,
    tolerance: f64,
    cycles: usize,
    work: &Work<'_>,
    simd: Simd,
) -> Result<Solution, Error> {
    let cells = plate.cols.saturating_mul(plate.rows);
    for (array, found) in [("known", plate.known.len()), ("value", plate.value.len())] {
        if found != cells {
            return Err(Error::Length { array, found, expected: cells });
        }
    }
    work.check()?;
    let even =
        |value: f32| Solution { field: vec![value; cells], cycles: 0, history: Vec::new(), converged: true };
    let known = (0..cells).filter(|&k| plate.knows(k));
    let across = match layout(plate.cols, plate.rows, known) {
        Layout::Nowhere => return Ok(even(0.0)),
        Layout::Lone(cell) => return Ok(even(plate.value[cell])),
        Layout::Aligned(across) => Some(across),
        Layout::Spread => None,
    };
    let (low, high) = extent(plate);
    let middle = 0.5 * (low + high);
    let mut bending = Bending::new(plate, across, middle, simd, work)?;
    let mut solution = bending.iterate(tolerance.max(0.0), cycles, work)?;
    if let Some(across) = across {
        level_out(&mut bending.x, plate.cols, across);
    }
    solution.field = vec![0.0; cells];
    let free = |k: usize| ((bending.x[k] + middle) as f32).clamp(-f32::MAX, f32::MAX);
    let value = |k: usize| if plate.knows(k) { plate.value[k] } else { free(k) };
    solution.field.par_iter_mut().enumerate().for_each(|(k, o)| *o = value(k));
    work.report(1.0);
    Ok(solution)
}

/// The least and the largest known value.
fn extent(plate: &Plate<'_>) -> (f64, f64) {
    let known = (0..plate.known.len()).filter(|&k| plate.knows(k)).map(|k| f64::from(plate.value[k]));
    known.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
}

/// Takes the mean tilt across a line off a field.
fn level_out(x: &mut [f64], cols: usize, across: Across) {
    let rows = x.len() / cols;
    let (dx, dy) = across.slope();
    // Sums of differences along an axis are differences of its ends.
    let over_cols: f64 = x.chunks(cols).map(|row| row[cols - 1] - row[0]).sum();
    let over_rows: f64 = (0..cols).map(|i| x[(rows - 1) * cols + i] - x[i]).sum();
    // An axis of one cell has no tilt.
    let mean = |sum: f64, pairs: usize| sum / pairs.max(1) as f64;
    let (mean_x, mean_y) = (mean(over_cols, (cols - 1) * rows), mean(over_rows, (rows - 1) * cols));
    let tilt = (dx * mean_x + dy * mean_y) / (dx * dx + dy * dy);
    x.par_iter_mut().enumerate().for_each(|(k, v)| *v -= tilt * across.at(k) as f64);
}
