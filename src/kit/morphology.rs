//! Grey-scale dilation and erosion by a disk, and a soft edge.
//!
//! A disk is a stack of chords. The largest value under a chord is the larger of two overlapping runs whose length
//! is a power of two, and these runs are found for a whole row by doubling \[urbach2008\]; so a sample costs a few
//! operations for each row of the disk, and the result is exact.

use rayon::prelude::*;

use super::math::within;
use super::shifted::Shifted;
use crate::error::Result;
use crate::value::{Field, Grid, Raster, fill};
use crate::work::{Cancelled, Work};

/// Rows that one task fills: enough to share the runs of a row, few enough to spread and to stop soon.
const BAND: usize = 32;

/// Which of two values stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The larger: dilation.
    Largest,
    /// The smaller: erosion.
    Smallest,
}

impl Keep {
    /// The other.
    pub fn other(self) -> Self {
        match self {
            Self::Largest => Self::Smallest,
            Self::Smallest => Self::Largest,
        }
    }
}

/// Cells that a radius in metres spans.
pub fn reach(radius: f64, cell: f64) -> i64 {
    // A quotient such as 0.3 / 0.1 may fall just short of the whole number it stands for.
    (radius / cell + 1e-9).floor().clamp(0.0, 1e9) as i64
}

/// Bytes of scratch memory of [`disk`] beside its result.
pub fn scratch(grid: &Grid, radius: f64) -> u64 {
    let reach = reach(radius, grid.cell()) as u64;
    let runs = u64::from((2 * reach + 1).ilog2()) + 2;
    let tasks = (rayon::current_num_threads() as u64).min(grid.rows.div_ceil(BAND) as u64);
    (4 * runs * tasks).saturating_mul(grid.cols as u64 + 2 * reach)
}

/// The largest or smallest value within `radius` metres of every sample of a window, by input `port`, which covers
/// the window grown by [`reach`].
///
/// # Errors
/// When the field stands on another lattice, or the work was asked to stop.
pub fn disk(
    work: &Work<'_>,
    port: &'static str,
    field: &Field,
    grid: &Grid,
    radius: f64,
    keep: Keep,
) -> Result<Field> {
    match keep {
        Keep::Largest => sweep(work, port, field, grid, radius, |a, b| if a > b { a } else { b }),
        Keep::Smallest => sweep(work, port, field, grid, radius, |a, b| if a < b { a } else { b }),
    }
}

/// Half the length of the disk's chord `0, 1, … reach` rows from its centre, in cells.
fn chords(radius: f64, cell: f64) -> Vec<usize> {
    let cells = radius / cell + 1e-9;
    let reach = reach(radius, cell);
    let half = |d: i64| (cells * cells - (d * d) as f64).max(0.0).sqrt().floor() as usize;
    (0..=reach).map(|d| half(d).min(reach as usize)).collect()
}

fn sweep(
    work: &Work<'_>,
    port: &'static str,
    field: &Field,
    grid: &Grid,
    radius: f64,
    pick: impl Fn(f32, f32) -> f32 + Copy + Sync,
) -> Result<Field> {
    let chords = chords(radius, grid.cell());
    let reach = chords.len() as i64 - 1;
    let wide = Grid { col: grid.col - reach, cols: grid.cols + 2 * reach as usize, ..*grid };
    let rows = Shifted::new(port, field, &wide)?;
    let mut data = vec![0.0; grid.len()];
    let done = std::sync::atomic::AtomicUsize::new(0);
    data.par_chunks_mut((BAND * grid.cols).max(1)).enumerate().try_for_each(|(b, band)| {
        let first = (b * BAND) as i64;
        let count = (band.len() / grid.cols) as i64;
        let mut runs = Vec::new();
        for source in -reach..count + reach {
            work.check()?;
            doubled_runs(&rows.line(0, [0, first + source]), 2 * chords[0] + 1, pick, &mut runs);
            for target in (source - reach).max(0)..(source + reach + 1).min(count) {
                let out = &mut band[target as usize * grid.cols..][..grid.cols];
                let away = target.abs_diff(source) as usize;
                // The band's first source row that reaches a target starts it.
                let start = source == target - reach;
                under_chord(out, &runs, chords[0], chords[away], start, pick);
            }
        }
        let finished = done.fetch_add(count as usize, std::sync::atomic::Ordering::Relaxed) + count as usize;
        work.report(finished as f32 / grid.rows as f32);
        Ok::<(), Cancelled>(())
    })?;
    Ok(Raster::new(*grid, field.quantity(), data))
}

/// For each power of two up to `longest`, the picked value of the run of that length that starts at each sample.
fn doubled_runs(line: &[f32], longest: usize, pick: impl Fn(f32, f32) -> f32, runs: &mut Vec<Vec<f32>>) {
    let levels = longest.ilog2() as usize + 1;
    runs.resize_with(levels, Vec::new);
    runs[0].clear();
    runs[0].extend_from_slice(line);
    for level in 1..levels {
        let (below, above) = runs.split_at_mut(level);
        let (shorter, half) = (&below[level - 1], 1 << (level - 1));
        above[0].clear();
        above[0].extend(shorter.iter().zip(&shorter[half..]).map(|(&a, &b)| pick(a, b)));
    }
}

/// Picks the values under a chord of half-length `half` into a row; the runs start `reach` samples before it.
fn under_chord(
    out: &mut [f32],
    runs: &[Vec<f32>],
    reach: usize,
    half: usize,
    start: bool,
    pick: impl Fn(f32, f32) -> f32,
) {
    let length = 2 * half + 1;
    let level = length.ilog2() as usize;
    let left = &runs[level][reach - half..][..out.len()];
    let right = &runs[level][reach + half + 1 - (1 << level)..][..out.len()];
    for ((o, &a), &b) in out.iter_mut().zip(left).zip(right) {
        let under = pick(a, b);
        *o = if start { under } else { pick(*o, under) };
    }
}

/// Blends every sample with its surroundings up to `width` metres away, by the bump `(1 − (d / width)²)²` along
/// each axis: a step becomes a soft edge, a plain keeps every bit.
///
/// # Errors
/// When the field stands on another lattice, or the work was asked to stop.
pub fn soften(work: &Work<'_>, port: &'static str, field: &Field, grid: &Grid, width: f64) -> Result<Field> {
    blend(work, port, field, grid, &bump(width, grid.cell()))
}

/// Blends every sample with others along each axis: each pair of a distance in cells and a weight adds the weighted
/// differences to the two samples that far away. A plain keeps every bit.
///
/// # Errors
/// When the field stands on another lattice, or the work was asked to stop.
pub fn blend(
    work: &Work<'_>,
    port: &'static str,
    field: &Field,
    grid: &Grid,
    weights: &[(i64, f32)],
) -> Result<Field> {
    let Some(reach) = weights.iter().map(|w| w.0).max() else { return Ok(field.crop(grid)) };
    let tall = Grid { row: grid.row - reach, rows: grid.rows + 2 * reach as usize, ..*grid };
    let along = |work: &Work<'_>, field: &Field, grid: Grid, axis: [i64; 2]| -> Result<Field> {
        let rows = Shifted::new(port, field, &grid)?;
        Ok(fill(work, grid, field.quantity(), |row, out| {
            let here = rows.line(row.j, [0, 0]);
            out.copy_from_slice(&here);
            for &(d, weight) in weights {
                let ahead = rows.line(row.j, [d * axis[0], d * axis[1]]);
                let behind = rows.line(row.j, [-d * axis[0], -d * axis[1]]);
                for (((o, a), b), h) in out.iter_mut().zip(&*ahead).zip(&*behind).zip(&*here) {
                    *o += weight * ((a - h) + (b - h));
                }
            }
            // Differences of huge numbers may leave the range of f32.
            out.iter_mut().for_each(|o| *o = within(*o, f32::MAX));
        })?)
    };
    let rows = along(&work.stage(0.0, 0.5), field, tall, [1, 0])?;
    along(&work.stage(0.5, 1.0), &rows, *grid, [0, 1])
}

/// Weights of the bump 1, 2, … cells away, for a sum of 1 with the middle.
fn bump(width: f64, cell: f64) -> Vec<(i64, f32)> {
    let raw = |d: i64| {
        let u = d as f64 * cell / width;
        (1.0 - u * u).max(0.0) * (1.0 - u * u).max(0.0)
    };
    let sides: Vec<_> = (1..=reach(width, cell)).map(|d| (d, raw(d))).collect();
    let sum = 1.0 + 2.0 * sides.iter().map(|s| s.1).sum::<f64>();
    sides.into_iter().map(|(d, w)| (d, (w / sum) as f32)).collect()
}
