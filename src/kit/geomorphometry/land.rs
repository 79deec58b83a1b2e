//! Heights of land to measure.

use rayon::prelude::*;

/// Heights beyond this, either way, are marks of voids and no heights.
const HIGHEST: f32 = 1e30;

/// Heights on square cells, of which some are no land.
#[derive(Clone, Debug, PartialEq)]
pub struct Land {
    cols: usize,
    rows: usize,
    cell: f64,
    heights: Vec<f32>,
}

impl Land {
    /// Heights in metres, row by row from the north-west, on square cells of `cell` metres. What is not finite, or
    /// beyond 1e30, is a void.
    ///
    /// # Panics
    /// When there is not one height per cell: that is a bug of the caller.
    pub fn new(cols: usize, rows: usize, cell: f64, mut heights: Vec<f32>) -> Self {
        assert_eq!(heights.len(), cols * rows, "one height per cell");
        // A comparison with NaN is false.
        heights.par_iter_mut().filter(|z| z.abs().partial_cmp(&HIGHEST).is_none_or(|o| o.is_gt())).for_each(
            |z| {
                *z = f32::NAN;
            },
        );
        Self { cols, rows, cell, heights }
    }

    /// The same land without the cells at or below the level of the sea, in metres.
    #[must_use]
    pub fn above_sea(mut self, level: f64) -> Self {
        self.heights.par_iter_mut().filter(|z| f64::from(**z) <= level).for_each(|z| *z = f32::NAN);
        self
    }

    /// The means of blocks of `side` × `side` cells. A block with less than half its cells on land is a void, and rows
    /// and columns that fill no block are left out.
    #[must_use]
    pub fn averaged(self, side: usize) -> Self {
        let side = side.max(1);
        if side == 1 {
            return self;
        }
        let (cols, rows) = (self.cols / side, self.rows / side);
        let mut heights = vec![f32::NAN; cols * rows];
        heights.par_chunks_mut(cols.max(1)).enumerate().for_each(|(j, means)| {
            let band = &self.heights[j * side * self.cols..][..side * self.cols];
            for (i, mean) in means.iter_mut().enumerate() {
                let block = band.chunks_exact(self.cols).flat_map(|row| &row[i * side..][..side]);
                let land = block
                    .filter(|z| z.is_finite())
                    .fold((0usize, 0.0), |(n, sum), &z| (n + 1, sum + f64::from(z)));
                if 2 * land.0 >= side * side {
                    *mean = (land.1 / land.0 as f64) as f32;
                }
            }
        });
        Self { cols, rows, cell: self.cell * side as f64, heights }
    }

    /// The side, in cells, of the blocks whose means lie about `target` metres apart; 1 where blocks of two would
    /// already be farther off than the cells are. Of two that are equally near the even one is taken.
    pub fn block(&self, target: f64) -> usize {
        // Between 1 and 2 the middle of the ratios is √2.
        let ratio = target / self.cell;
        if ratio > 1.4 { (ratio.round_ties_even() as usize).max(2) } else { 1 }
    }

    /// Cells in a row.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Side of a cell in metres.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// All heights in metres, row by row; NaN where there is no land.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Number of cells that are land.
    pub fn count(&self) -> usize {
        self.heights.par_iter().filter(|z| z.is_finite()).count()
    }

    /// The heights of one row.
    pub(super) fn row(&self, j: usize) -> &[f32] {
        &self.heights[j * self.cols..][..self.cols]
    }

    /// Whether a cell and its eight neighbours are all there and all land.
    pub(super) fn is_inland(&self, i: usize, j: usize) -> bool {
        let inside = i > 0 && j > 0 && i + 1 < self.cols && j + 1 < self.rows;
        inside && (j - 1..=j + 1).all(|j| self.row(j)[i - 1..=i + 1].iter().all(|z| z.is_finite()))
    }
}
