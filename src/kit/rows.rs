//! Working through fields row by row where they lie, without cutting windows out of larger ones first.

use crate::node::{Context, Result, Row};
use crate::value::{Field, Grid, Quantity};

/// The part of a field that stands on a window, read in place where the field covers the window.
#[derive(Clone, Debug)]
pub struct Rows {
    field: Field,
    skip: usize,
    cols: usize,
}

impl Rows {
    /// The part of a field on a window; beyond the field its border value continues.
    pub fn of(field: &Field, window: &Grid) -> Self {
        let whole = *field.grid();
        if whole.contains(window) && !window.is_empty() {
            let skip = (window.col - whole.col) as usize;
            return Self { field: field.clone(), skip, cols: window.cols };
        }
        Self { field: field.crop(window), skip: 0, cols: window.cols }
    }

    /// The samples of a lattice row.
    pub fn at(&self, row: i64) -> &[f32] {
        &self.field.row(self.field.clamped_row(row))[self.skip..][..self.cols]
    }
}

/// Applies a function to every sample on the context's grid.
///
/// # Errors
/// [`crate::node::Error::Cancelled`] when the work was asked to stop.
pub fn map(
    cx: &Context<'_>,
    field: &Field,
    quantity: Quantity,
    f: impl Fn(f32) -> f32 + Sync,
) -> Result<Field> {
    let rows = Rows::of(field, &cx.grid);
    cx.fill(quantity, |row: Row, out| {
        for (o, &x) in out.iter_mut().zip(rows.at(row.row)) {
            *o = f(x);
        }
    })
}

/// Applies a function to every pair of samples on the context's grid.
///
/// # Errors
/// [`crate::node::Error::Cancelled`] when the work was asked to stop.
pub fn zip(
    cx: &Context<'_>,
    [a, b]: [&Field; 2],
    quantity: Quantity,
    f: impl Fn(f32, f32) -> f32 + Sync,
) -> Result<Field> {
    let (a, b) = (Rows::of(a, &cx.grid), Rows::of(b, &cx.grid));
    cx.fill(quantity, |row: Row, out| {
        for ((o, &a), &b) in out.iter_mut().zip(a.at(row.row)).zip(b.at(row.row)) {
            *o = f(a, b);
        }
    })
}

/// From `a` to `b` by a share; 0 and 1 give them to the bit.
#[inline]
pub fn lerp(a: f32, b: f32, share: f32) -> f32 {
    if share == 1.0 { b } else { a + (b - a) * share }
}
