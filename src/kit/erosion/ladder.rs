//! The levels of cells on which erosion runs, from coarse to fine.
//!
//! Level `k` has cells of (longer side) / (64 · 2ᵏ), whatever the base grid. The first is level 0, or a finer one where the
//! features are small; the last is the base grid itself, even where it lies between two levels. A side that a cell does not
//! divide is covered by one cell more, so that a level may reach beyond the terrain by less than a cell.
//!
//! What a level reads is sampled at its points, not averaged around them. Bases that have those points in common, such as
//! 513 and 1025, so start their coarse levels from the same bits.

use crate::kit::rows::Rows;
use crate::kit::sample::{Interpolation, Sampler, fit};
use crate::value::{Field, Grid, Lattice, Quantity};
use crate::work::{Cancelled, Work};

/// Cells along the longer side of level 0.
pub const COARSEST: u32 = 64;

/// Cells of the first level across the widest feature.
pub const CELLS_ACROSS: f64 = 8.0;

/// One of the grids that erosion goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Where its points stand: the north-west corner is that of the base grid.
    pub grid: Grid,
    /// Cells along the longer side of the terrain.
    across: u32,
}

/// The levels that erosion goes through on its way to a base grid, the coarsest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    levels: Vec<Level>,
}

impl Ladder {
    /// The ladder up to a base grid, which must have a sample.
    ///
    /// `feature` is the width of the widest valleys, in metres: the first level is the coarsest whose cells are at most an
    /// eighth of that, but never coarser than level 0. An infinite width starts at level 0.
    pub fn new(base: &Grid, feature: f64) -> Self {
        let last = Level::of(base);
        let mut levels = Vec::new();
        let mut across = COARSEST;
        // The product and the comparison are of the world alone, so that every base begins at the same level.
        while across < last.across {
            if last.span() <= feature / CELLS_ACROSS * f64::from(across) || feature.is_nan() {
                levels.push(last.coarsened(across));
            }
            across = across.saturating_mul(2);
        }
        levels.push(last);
        Self { levels }
    }

    /// The levels, the coarsest first; at least one.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Samples of all levels.
    pub fn len(&self) -> usize {
        self.levels.iter().map(|level| level.grid.len()).sum()
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Level {
    /// The level that a whole grid is by itself.
    pub fn of(grid: &Grid) -> Self {
        let across = grid.cols.max(grid.rows).saturating_sub(1);
        Self { grid: *grid, across: u32::try_from(across).unwrap_or(u32::MAX) }
    }

    /// Cells along the longer side of the terrain.
    pub fn across(&self) -> u32 {
        self.across
    }

    /// The longer side of the terrain, in metres.
    pub fn span(&self) -> f64 {
        let lattice = self.grid.lattice;
        lattice.span * (f64::from(self.across) / f64::from(lattice.intervals))
    }

    /// Area of a cell, in square metres.
    pub fn cell_area(&self) -> f64 {
        self.grid.cell() * self.grid.cell()
    }

    /// The level with so many cells along the same longer side, fewer than here.
    fn coarsened(&self, across: u32) -> Self {
        let origin = [self.grid.x(0), self.grid.y(0)];
        let lattice = Lattice { origin, span: self.span(), intervals: across };
        // In whole numbers, so that no rounding takes a cell from a side or gives it one too many.
        let covering = |count: usize| {
            let (cells, fine) = (count.saturating_sub(1) as u64, u64::from(self.across));
            (cells * u64::from(across)).div_ceil(fine) as usize + 1
        };
        let (cols, rows) = (covering(self.grid.cols), covering(self.grid.rows));
        Self { grid: Grid { lattice, col: 0, row: 0, cols, rows }, across }
    }

    /// Where the `i`-th column or row of this level stands on another level of the same terrain, in steps from its first.
    /// Points that both levels have are at whole steps, exactly.
    pub fn steps_on(&self, other: &Self, i: usize) -> f64 {
        if self.across == 0 {
            return 0.0;
        }
        // Both numbers are whole and below 2⁵³: the quotient is the nearest there is, and exact where it is whole.
        (i as f64 * f64::from(other.across)) / f64::from(self.across)
    }

    /// A field of the base grid at the points of this level, row by row: its own samples where points meet, a smooth curve
    /// through them between. Beyond the terrain its border value continues. Labels and directions are those of the
    /// nearest sample.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn sample(&self, field: &Field, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
        let Grid { cols, rows, .. } = self.grid;
        let from = Self::of(field.grid());
        if from.across == self.across {
            // The same points: whatever is asked of the grid beyond the field is its border.
            let window = Grid { cols, rows, ..*field.grid() };
            let lines = Rows::of(field, &window);
            return self.fill(work, |j, out| out.copy_from_slice(lines.at(window.row + j as i64)));
        }
        let Some(sampler) = Sampler::new(field) else { return Ok(vec![0.0; self.grid.len()]) };
        let quantity = field.quantity();
        let method = method(quantity);
        let (first, last) = (field.grid(), [field.grid().col_end() - 1, field.grid().row_end() - 1]);
        self.fill(work, |j, out| {
            let v = (first.row as f64 + self.steps_on(&from, j)).min(last[1] as f64);
            for (i, out) in out.iter_mut().enumerate() {
                let u = (first.col as f64 + self.steps_on(&from, i)).min(last[0] as f64);
                *out = fit(quantity, sampler.value(method, [u, v]));
            }
        })
    }

    /// A value for each point, rows in parallel; `row` is given the number of the row.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn fill(
        &self,
        work: &Work<'_>,
        row: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Result<Vec<f32>, Cancelled> {
        let cols = self.grid.cols;
        let mut data = vec![0.0; self.grid.len()];
        work.rows(&mut data, cols, (1 << 14) / cols.max(1) + 1, row)?;
        Ok(data)
    }
}

/// How a field is read between its samples: nothing that cannot be negative swings below 0.
fn method(quantity: Quantity) -> Interpolation {
    match quantity {
        Quantity::Label | Quantity::Direction => Interpolation::Nearest,
        Quantity::Elevation | Quantity::Mask => Interpolation::Cubic,
        _ => Interpolation::Linear,
    }
}
