//! Filling a raster row by row.

use super::{Grid, Quantity, Raster, Sample};
use crate::work::{Cancelled, Work};

/// A row that [`fill`] asks for.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index in the window, from 0.
    pub j: usize,
    /// Row of the lattice.
    pub row: i64,
    /// South coordinate, in metres.
    pub y: f64,
}

/// Fills a raster on a grid, rows in parallel, with progress and cancellation.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn fill<T: Sample>(
    work: &Work<'_>,
    grid: Grid,
    quantity: Quantity,
    f: impl Fn(Row, &mut [T]) + Sync,
) -> Result<Raster<T>, Cancelled> {
    let mut data = vec![T::default(); grid.len()];
    // Bands of about 16 k samples: large enough to hide the scheduling, small enough to stop soon.
    let band = (1 << 14) / grid.cols.max(1) + 1;
    work.rows(&mut data, grid.cols, band, |j, row| {
        f(Row { j, row: grid.row + j as i64, y: grid.y(j) }, row);
    })?;
    Ok(Raster::new(grid, quantity, data))
}
