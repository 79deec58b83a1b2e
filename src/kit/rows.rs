//! Working through fields row by row where they lie, without cutting windows out of larger ones first.

use crate::kit::simd::{Kernel, Level};
use crate::value::{Field, Grid, Quantity, Row, fill};
use crate::work::{Cancelled, Work};

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

/// Applies a function to every sample on a grid.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn map(
    work: &Work<'_>,
    grid: &Grid,
    field: &Field,
    quantity: Quantity,
    f: impl Fn(f32) -> f32 + Sync,
) -> Result<Field, Cancelled> {
    let rows = Rows::of(field, grid);
    fill(work, *grid, quantity, |row: Row, out| {
        Level::best().run(Mapped { out, from: rows.at(row.row), f: &f });
    })
}

/// A field of a function of the index of each sample, row by row from 0.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn by_index(
    work: &Work<'_>,
    grid: &Grid,
    quantity: Quantity,
    f: impl Fn(usize) -> f32 + Sync,
) -> Result<Field, Cancelled> {
    fill(work, *grid, quantity, |row: Row, out| {
        out.iter_mut().zip(row.j * grid.cols..).for_each(|(o, i)| *o = f(i));
    })
}

/// Applies a function to every pair of samples on a grid.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn zip(
    work: &Work<'_>,
    grid: &Grid,
    [a, b]: [&Field; 2],
    quantity: Quantity,
    f: impl Fn(f32, f32) -> f32 + Sync,
) -> Result<Field, Cancelled> {
    let (a, b) = (Rows::of(a, grid), Rows::of(b, grid));
    fill(work, *grid, quantity, |row: Row, out| {
        Level::best().run(Zipped { out, from: [a.at(row.row), b.at(row.row)], f: &f });
    })
}

/// A function applied to a row.
struct Mapped<'a, F> {
    out: &'a mut [f32],
    from: &'a [f32],
    f: &'a F,
}

impl<F: Fn(f32) -> f32> Kernel for Mapped<'_, F> {
    #[inline(always)]
    fn run(self) {
        for (o, &x) in self.out.iter_mut().zip(self.from) {
            *o = (self.f)(x);
        }
    }
}

/// A function applied to two rows.
struct Zipped<'a, F> {
    out: &'a mut [f32],
    from: [&'a [f32]; 2],
    f: &'a F,
}

impl<F: Fn(f32, f32) -> f32> Kernel for Zipped<'_, F> {
    #[inline(always)]
    fn run(self) {
        let [a, b] = self.from;
        for ((o, &a), &b) in self.out.iter_mut().zip(a).zip(b) {
            *o = (self.f)(a, b);
        }
    }
}

/// From `a` to `b` by a share; 0 and 1 give them to the bit.
#[inline(always)]
pub fn lerp(a: f32, b: f32, share: f32) -> f32 {
    if share == 1.0 { b } else { a + (b - a) * share }
}
