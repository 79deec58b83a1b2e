//! Exact Euclidean distances to a set of samples, within a limit.
//!
//! Two passes over whole numbers \[meijster2000\]: first the distance along each column, then, along each row, the
//! lower envelope of the parabolas that these distances raise. Squared distances in cells are integers, so a result
//! does not depend on the window it was computed on.

use rayon::prelude::*;

use crate::error::Result;
use crate::value::{Field, Grid, Quantity, fill};
use crate::work::{Cancelled, Work};

/// Columns that one task sweeps: a few cache lines of every row.
const STRIP: usize = 64;

/// Cells that a limit in metres spans.
pub fn reach(limit: f64, cell: f64) -> i64 {
    // A quotient such as 0.3 / 0.1 may fall just short of the whole number it stands for.
    (limit / cell + 1e-9).floor().clamp(0.0, 1e9) as i64
}

/// Bytes of scratch memory of [`to_set`].
pub fn scratch(grid: &Grid, limit: f64) -> u64 {
    let cols = (grid.cols as u64).saturating_add(2 * reach(limit, grid.cell()) as u64);
    let strips = cols.div_ceil(STRIP as u64).saturating_mul(STRIP as u64);
    // Beside the columns' distances, every thread holds a row of them with its parabolas.
    strips.saturating_mul(4 * grid.rows as u64 + 20 * rayon::current_num_threads() as u64)
}

/// Distance in metres from each sample of a window to the nearest sample of a field that is in a set; `limit` where
/// none is nearer. Beyond the field its border value continues.
///
/// # Errors
/// When the work was asked to stop.
pub fn to_set(
    work: &Work<'_>,
    field: &Field,
    grid: &Grid,
    limit: f64,
    set: impl Fn(f32) -> bool + Sync,
) -> Result<Field> {
    let reach = reach(limit, grid.cell());
    let columns = Columns::sweep(&work.stage(0.0, 0.3), field, grid, reach, set)?;
    let cell = grid.cell();
    Ok(fill(&work.stage(0.3, 1.0), *grid, Quantity::Length, |row, out| {
        let mut line = Vec::new();
        columns.row(row.j, &mut line);
        let metres = |squared: i64| ((squared as f64).sqrt() * cell).min(limit) as f32;
        lower_envelope(&line, reach, out, |squared| squared.map_or(limit as f32, metres));
    })?)
}

/// For each sample, the distance in cells to the nearest one of the set in its own column.
struct Columns {
    /// Strip by strip; in a strip row by row, [`STRIP`] columns each.
    cells: Vec<u32>,
    rows: usize,
    cols: usize,
}

impl Columns {
    fn sweep(
        work: &Work<'_>,
        field: &Field,
        grid: &Grid,
        reach: i64,
        set: impl Fn(f32) -> bool + Sync,
    ) -> Result<Self> {
        let cols = grid.cols + 2 * reach as usize;
        let mut cells = vec![0; cols.div_ceil(STRIP) * STRIP * grid.rows];
        cells.par_chunks_mut(STRIP * grid.rows.max(1)).enumerate().try_for_each(|(s, strip)| {
            work.check()?;
            sweep_strip(field, grid, reach, grid.col - reach + (s * STRIP) as i64, strip, &set);
            Ok::<(), Cancelled>(())
        })?;
        work.report(1.0);
        Ok(Self { cells, rows: grid.rows, cols })
    }

    fn row(&self, j: usize, line: &mut Vec<u32>) {
        let strips = self.cells.chunks_exact(STRIP * self.rows);
        line.extend(strips.flat_map(|s| &s[j * STRIP..][..STRIP]).take(self.cols));
    }
}

/// Sweeps a strip of columns down and up, carrying the distance to the last sample of the set.
fn sweep_strip(
    field: &Field,
    grid: &Grid,
    reach: i64,
    first_col: i64,
    strip: &mut [u32],
    set: impl Fn(f32) -> bool,
) {
    let none = reach as u32 + 1;
    let last = field.grid().cols as i64 - 1;
    let columns: [usize; STRIP] =
        std::array::from_fn(|c| (first_col + c as i64 - field.grid().col).clamp(0, last) as usize);
    let whole = columns[STRIP - 1] - columns[0] == STRIP - 1;
    let step = |row: i64, far: &mut [u32; STRIP]| {
        let source = field.row(field.clamped_row(row));
        let mut values = [0.0; STRIP];
        if whole {
            values.copy_from_slice(&source[columns[0]..][..STRIP]);
        } else {
            values = columns.map(|c| source[c]);
        }
        for (d, v) in far.iter_mut().zip(values) {
            *d = if set(v) { 0 } else { (*d + 1).min(none) };
        }
    };
    let mut far = [none; STRIP];
    for row in grid.row - reach..grid.row_end() {
        step(row, &mut far);
        if row >= grid.row {
            strip[(row - grid.row) as usize * STRIP..][..STRIP].copy_from_slice(&far);
        }
    }
    far = [none; STRIP];
    for row in (grid.row..grid.row_end() + reach).rev() {
        step(row, &mut far);
        if row < grid.row_end() {
            let kept = &mut strip[(row - grid.row) as usize * STRIP..][..STRIP];
            for (k, d) in kept.iter_mut().zip(far) {
                *k = (*k).min(d);
            }
        }
    }
}

/// The lowest of the parabolas `(x − i)² + line[i]²` at every `x` of the middle of a line, which has `reach` more
/// samples on either side; `None` where no parabola is. Values above `reach` raise none.
fn lower_envelope(line: &[u32], reach: i64, out: &mut [f32], value: impl Fn(Option<i64>) -> f32) {
    let square = |i: i64| i64::from(line[i as usize]) * i64::from(line[i as usize]);
    let height = |x: i64, i: i64| (x - i) * (x - i) + square(i);
    // The parabolas that are lowest somewhere, each with the first place where it is.
    let mut lowest: Vec<(i64, i64)> = Vec::with_capacity(line.len());
    for i in (0..line.len() as i64).filter(|&i| i64::from(line[i as usize]) <= reach) {
        while lowest.last().is_some_and(|&(from, site)| height(from, site) > height(from, i)) {
            lowest.pop();
        }
        // The last place where the parabola before is still as low, plus one.
        let from = lowest.last().map_or(0, |&(_, site)| {
            1 + (i * i - site * site + square(i) - square(site)).div_euclid(2 * (i - site))
        });
        if from < line.len() as i64 {
            lowest.push((from, i));
        }
    }
    let mut next = 0;
    for (x, out) in (reach..).zip(out) {
        while lowest.get(next).is_some_and(|&(from, _)| from <= x) {
            next += 1;
        }
        *out = value(lowest[..next].last().map(|&(_, site)| height(x, site)));
    }
}
