//! Levels as rows that a window reads whole.

use rayon::prelude::*;

use crate::error::Result;
use crate::value::{Field, Grid};
use crate::work::{Cancelled, Work};

/// Columns of the lines for a step of the base grid, as a fraction: those of the window where it is finer.
pub(super) fn columns_scale((base, window): (f64, f64)) -> (f64, f64) {
    if window < base { (1.0, 1.0) } else { (window, base) }
}

/// Rows of a level, each drawn out to the columns that windows read.
///
/// A window that takes every second, third, … column finds its columns side by side all the same: a row holds first the
/// columns whose index leaves no remainder, then those that leave 1, and so on.
#[derive(Debug)]
pub(super) struct Lines {
    data: Vec<f32>,
    /// Samples of a row with one remainder.
    part: usize,
    remainders: i64,
    /// First column over the number of remainders, and first row in steps of the level.
    first: [i64; 2],
    /// Base cells from one row to the next.
    pub(super) spacing: f64,
}

/// Where the columns of a window stand among those of the lines.
#[derive(Debug)]
pub(super) enum Columns {
    /// Each so many columns after the other, the first at that number times this.
    Every(i64, i64),
    /// Each on its own: a column of the base grid, and the share of one more.
    Each(Vec<(i64, f32)>),
}

impl Columns {
    pub(super) fn new(window: &Grid, scale: (f64, f64)) -> Self {
        let (base, own) = scale;
        match stride(scale) {
            Some(step) => Self::Every(step, window.col),
            None => {
                let column = |c: i64| {
                    let at = c as f64 * base / own;
                    (at.floor() as i64, (at - at.floor()) as f32)
                };
                Self::Each((window.col..window.col_end()).map(column).collect())
            }
        }
    }
}

/// Columns of the lines from one column of the window to the next, where that is a whole number.
pub(super) fn stride((base, window): (f64, f64)) -> Option<i64> {
    let step = if window < base { base / window } else { 1.0 };
    (step.fract() == 0.0).then_some(step as i64)
}

/// The columns of one remainder from one of them on, which may lie beside the lines.
#[derive(Clone, Copy)]
pub(super) struct Part {
    start: i64,
    offset: usize,
    len: usize,
}

impl Part {
    /// The samples of two rows from here on; none where the lines do not hold so many.
    #[inline(always)]
    pub(super) fn of<'a>(&self, rows: [&'a [f32]; 2], n: usize) -> Option<[&'a [f32]; 2]> {
        let inside = self.start >= 0 && self.start as usize + n <= self.len;
        inside.then(|| rows.map(|row| &row[self.offset + self.start as usize..][..n]))
    }

    /// One sample; beyond the lines their border value continues.
    #[inline(always)]
    pub(super) fn at(&self, row: &[f32], i: usize) -> f32 {
        let last = self.len as i64 - 1;
        row[self.offset + (self.start + i as i64).clamp(0, last) as usize]
    }
}

impl Lines {
    /// Draws the rows of a level out to some columns.
    pub(super) fn new(
        work: &Work<'_>,
        level: &Field,
        spacing: i64,
        (first, cols): (i64, usize),
        scale: (f64, f64),
    ) -> Result<Self> {
        let (num, den) = columns_scale(scale);
        let remainders = stride(scale).unwrap_or(1);
        let start = first.div_euclid(remainders);
        let part = ((first + cols as i64 - 1).div_euclid(remainders) + 1 - start) as usize;
        let grid = level.grid();
        let last = grid.cols as i64 - 1;
        let sample = |c: i64| {
            let at = c as f64 * den / num / spacing as f64;
            let index = |i: f64| (i as i64 - grid.col).clamp(0, last) as usize;
            (index(at.floor()), index(at.floor() + 1.0), (at - at.floor()) as f32)
        };
        let column = |remainder: i64, i: usize| (start + i as i64) * remainders + remainder;
        let samples: Vec<_> =
            (0..remainders).flat_map(|r| (0..part).map(move |i| sample(column(r, i)))).collect();
        let mut data = vec![0.0f32; samples.len() * grid.rows];
        data.par_chunks_mut(samples.len().max(1)).enumerate().try_for_each(|(j, out)| {
            work.check()?;
            let row = level.row(j);
            for (o, &(a, b, share)) in out.iter_mut().zip(&samples) {
                *o = row[a] + share * (row[b] - row[a]);
            }
            Ok::<(), Cancelled>(())
        })?;
        Ok(Self { data, part, remainders, first: [start, grid.row], spacing: spacing as f64 })
    }

    /// A row in steps of the level; beyond the first and last they continue.
    #[inline(always)]
    pub(super) fn row(&self, row: i64) -> &[f32] {
        let stride = self.part * self.remainders as usize;
        let last = (self.data.len() / stride) as i64 - 1;
        &self.data[(row - self.first[1]).clamp(0, last) as usize * stride..][..stride]
    }

    /// The columns of a remainder from the one on whose index over the number of remainders is `start`.
    #[inline(always)]
    pub(super) fn part(&self, start: i64, remainder: i64) -> Part {
        Part { start: start - self.first[0], offset: remainder as usize * self.part, len: self.part }
    }
}
