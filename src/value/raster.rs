//! Samples on a grid: fields, vectors and colours.

use std::sync::Arc;

use super::{Grid, Quantity};

/// One sample of a raster: some `f32` components.
pub trait Sample: Copy + Default + PartialEq + Send + Sync + bytemuck::Pod {
    /// Name of the wire type, as ports and messages call it.
    const NAME: &'static str;
    /// Number of components.
    const CHANNELS: usize;
}

impl Sample for f32 {
    const NAME: &'static str = "field";
    const CHANNELS: usize = 1;
}

impl Sample for [f32; 2] {
    const NAME: &'static str = "vectors";
    const CHANNELS: usize = 2;
}

impl Sample for [f32; 3] {
    const NAME: &'static str = "colors";
    const CHANNELS: usize = 3;
}

/// One sample per grid point, row by row from the north-west; cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    grid: Grid,
    quantity: Quantity,
    data: Arc<Vec<T>>,
}

/// One `f32` per grid point.
pub type Field = Raster<f32>;
/// Two `f32` per grid point.
pub type Vectors = Raster<[f32; 2]>;
/// Red, green and blue per grid point.
pub type Colors = Raster<[f32; 3]>;

impl<T: Sample> Raster<T> {
    /// Wraps samples in row order.
    ///
    /// # Panics
    /// When there is not one sample per grid point: that is a bug of the caller.
    pub fn new(grid: Grid, quantity: Quantity, data: Vec<T>) -> Self {
        assert_eq!(data.len(), grid.len(), "one sample per grid point");
        Self { grid, quantity, data: Arc::new(data) }
    }

    /// The same sample everywhere.
    pub fn constant(grid: Grid, quantity: Quantity, sample: T) -> Self {
        Self::new(grid, quantity, vec![sample; grid.len()])
    }

    /// Fills a raster point by point on one thread; nodes use `Context::fill`.
    pub fn from_fn(grid: Grid, quantity: Quantity, f: impl Fn(f64, f64) -> T) -> Self {
        let (xs, f) = (grid.xs(), &f);
        let data = (0..grid.rows).flat_map(|j| {
            let y = grid.y(j);
            xs.iter().map(move |&x| f(x, y))
        });
        Self::new(grid, quantity, data.collect())
    }

    /// Where the samples stand.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What the numbers mean.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The same samples under another meaning.
    pub fn with_quantity(mut self, quantity: Quantity) -> Self {
        self.quantity = quantity;
        self
    }

    /// All samples, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// The samples of the `j`-th row of the window.
    pub fn row(&self, j: usize) -> &[T] {
        &self.data[j * self.grid.cols..][..self.grid.cols]
    }

    /// The sample at a lattice column and row; beyond the window its border value continues.
    pub fn at(&self, col: i64, row: i64) -> T {
        let i = (col - self.grid.col).clamp(0, self.grid.cols as i64 - 1) as usize;
        self.row(self.clamped_row(row))[i]
    }

    /// The index of the window's row that stands for a lattice row; beyond the window the border row continues.
    pub fn clamped_row(&self, row: i64) -> usize {
        (row - self.grid.row).clamp(0, self.grid.rows as i64 - 1) as usize
    }

    /// The samples on another window of the same lattice; beyond this window its border value continues.
    pub fn crop(&self, grid: &Grid) -> Self {
        if *grid == self.grid {
            return self.clone();
        }
        debug_assert_eq!(grid.lattice, self.grid.lattice, "a crop stays on the lattice");
        let mut data = Vec::with_capacity(grid.len());
        let inside = self.grid.col <= grid.col && grid.col_end() <= self.grid.col_end();
        for r in grid.row..grid.row_end() {
            let row = self.row(self.clamped_row(r));
            if inside {
                data.extend_from_slice(&row[(grid.col - self.grid.col) as usize..][..grid.cols]);
            } else {
                let last = self.grid.cols as i64 - 1;
                data.extend(
                    (grid.col..grid.col_end()).map(|c| row[(c - self.grid.col).clamp(0, last) as usize]),
                );
            }
        }
        Self::new(*grid, self.quantity, data)
    }

    /// Bytes of the samples.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.data.as_slice()) as u64
    }
}

impl Field {
    /// Lowest and highest sample; `None` when there is none.
    pub fn range(&self) -> Option<(f32, f32)> {
        use rayon::prelude::*;
        let fold = |(lo, hi): (f32, f32), &x: &f32| (lo.min(x), hi.max(x));
        let none = (f32::INFINITY, f32::NEG_INFINITY);
        let (lo, hi) = (self.data.par_chunks(1 << 16).map(|c| c.iter().fold(none, fold)))
            .reduce(|| none, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        (lo <= hi).then_some((lo, hi))
    }
}
