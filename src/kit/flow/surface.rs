//! The ground that water flows over.

use super::neighbor::Cells;
use crate::value::Field;

/// The height of what is no number: lower than any land.
const VOID: f32 = f32::MIN;

/// Heights on a grid, and the level of the sea.
///
/// A cell is *land* where its height is finite and above the sea. All else takes in water and gives none.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Columns and rows.
    pub cells: Cells,
    /// Distance between neighbours, in metres.
    pub cell: f64,
    height: &'a [f32],
    sea: f32,
}

impl<'a> Surface<'a> {
    /// A surface of heights in metres, row by row; without a sea where there is none.
    ///
    /// # Panics
    /// When there is not one height per cell, or there are more than 2²⁸ + 2¹⁶ cells: that is a bug of the caller.
    pub fn new(cols: usize, rows: usize, cell: f64, height: &'a [f32], sea: Option<f64>) -> Self {
        let cells = Cells { cols, rows };
        assert_eq!(height.len(), cells.len(), "one height per cell");
        assert!(height.len() <= (1 << 28) + (1 << 16), "a base grid has at most 16385² cells");
        let sea = sea.filter(|level| !level.is_nan()).map_or(VOID, |level| (level as f32).max(VOID));
        Self { cells, cell, height, sea }
    }

    /// The surface of a field of heights.
    pub fn of(field: &'a Field, sea: Option<f64>) -> Self {
        let grid = field.grid();
        Self::new(grid.cols, grid.rows, grid.cell(), field.data(), sea)
    }

    /// The heights as they were given.
    pub fn raw(&self) -> &'a [f32] {
        self.height
    }

    /// The same grid and sea with other heights.
    ///
    /// # Panics
    /// When there is not one height per cell.
    pub fn with_height(self, height: &[f32]) -> Surface<'_> {
        assert_eq!(height.len(), self.cells.len(), "one height per cell");
        Surface { cells: self.cells, cell: self.cell, height, sea: self.sea }
    }

    /// The height of a cell; of what is no number one below all land.
    #[inline(always)]
    pub fn at(&self, cell: usize) -> f32 {
        solid(self.height[cell])
    }

    /// Whether a cell has a height.
    pub fn is_known(&self, cell: usize) -> bool {
        self.at(cell) > VOID
    }

    /// The highest level that is not land, in metres.
    pub fn sea(&self) -> f32 {
        self.sea
    }

    /// Whether a cell is land.
    #[inline(always)]
    pub fn is_land(&self, cell: usize) -> bool {
        self.at(cell) > self.sea
    }

    /// The heights of a row.
    pub(super) fn row(&self, j: usize) -> &'a [f32] {
        &self.height[j * self.cells.cols..][..self.cells.cols]
    }
}

/// A height, or one below all land where there is none.
#[inline(always)]
pub(super) fn solid(height: f32) -> f32 {
    if height.abs() <= f32::MAX { height } else { VOID }
}
