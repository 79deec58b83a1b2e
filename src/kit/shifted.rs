//! Rows of a field as a window sees them, some samples aside: what a stencil reads.

use std::borrow::Cow;

use crate::error::{Error, Result};
use crate::value::{Field, Grid};

/// A field under a window of the same lattice, or of a coarser one whose every sample is one of the field's.
#[derive(Clone, Copy, Debug)]
pub struct Shifted<'a> {
    field: &'a Field,
    /// Column and row of the field's lattice under the window's first sample.
    first: [i64; 2],
    /// Samples of the field from one sample of the window to the next.
    step: i64,
    cols: usize,
}

impl<'a> Shifted<'a> {
    /// Looks at the field of input `port` through a window.
    ///
    /// # Errors
    /// When the field is empty, or the window's samples are not among those of its lattice.
    pub fn new(port: &'static str, field: &'a Field, window: &Grid) -> Result<Self> {
        let (fine, coarse) = (field.grid().lattice, window.lattice);
        let step = fine.intervals / coarse.intervals.max(1);
        if step == 0 || coarse.refined(step) != fine || field.grid().is_empty() {
            let message =
                format!("stands on {:?}, which does not hold the samples of {window:?}", field.grid());
            return Err(Error::Input { port: port.into(), message });
        }
        let step = i64::from(step);
        Ok(Self { field, first: [window.col * step, window.row * step], step, cols: window.cols })
    }

    /// The samples that lie `[columns, rows]` of the field's lattice aside of the window's `j`-th row; beyond the
    /// field its border value continues.
    pub fn line(&self, j: usize, [dcol, drow]: [i64; 2]) -> Cow<'a, [f32]> {
        let row = self.field.clamped_row(self.first[1] + j as i64 * self.step + drow);
        let source = self.field.row(row);
        let (start, last) = (self.first[0] + dcol - self.field.grid().col, source.len() as i64 - 1);
        if self.step == 1 && start >= 0 && start + self.cols as i64 - 1 <= last {
            return Cow::Borrowed(&source[start as usize..][..self.cols]);
        }
        let sample = |i| source[(start + i as i64 * self.step).clamp(0, last) as usize];
        Cow::Owned((0..self.cols).map(sample).collect())
    }

    /// Distance between samples of the field, in metres.
    pub fn cell(&self) -> f64 {
        self.field.grid().cell()
    }

    /// Samples in a row of the window.
    pub fn cols(&self) -> usize {
        self.cols
    }
}
