//! What lies far from the samples of a window: a field of the base grid, smoothed and thinned level by level.
//!
//! Level `m` is the field smoothed by the binomial kernels ¼, ½, ¼ with holes of 1, 2 … 2^(m−1) base cells, one after
//! the other; from the third on, a level keeps every second sample of the one below. So all levels together take
//! little more than the base grid under the window and its surroundings, whatever the size of the build, and since
//! the samples are anchored at the indices of the base grid, builds of every size and tiles read the same numbers.
//! Between the samples of a level its values lie on straight lines in both directions.
//!
//! A window reads whole rows at a time. For this a level is kept as *lines*: its own rows, each drawn out to the
//! columns of the build where that is finer than the base grid, and to those of the base grid where it is not.

mod lines;

use self::lines::{Columns, Lines, columns_scale, stride};
use super::morphology;
use crate::error::{Error, Result};
use crate::value::{Field, Grid, Lattice, Raster};
use crate::work::Work;

/// The part of each level that a window needs, before anything is read.
#[derive(Clone, Debug)]
pub struct Extents {
    /// Windows on the lattices of the levels; the first is that of the field itself.
    levels: Vec<Grid>,
    /// First column and number of columns of the lines of each level; none of a level that is not looked at.
    lines: Vec<Option<(i64, usize)>>,
}

/// The levels of a field around a window.
#[derive(Debug)]
pub struct Far {
    lines: Vec<Option<Lines>>,
    columns: Columns,
    /// Samples in a row of the window.
    cols: usize,
    /// Steps of the base grid for steps of the window's lattice.
    scale: (f64, f64),
}

/// A place beside a sample, on a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    level: usize,
    /// Whole columns of the lines, and the share of one more.
    east: (i64, f32),
    /// Rows of the base grid.
    south: f64,
}

/// What a row of a window sees at a place: each sample lies between four, the two of `near` and the two of `far`, each
/// pair one above the other. All slices are as long as the row.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// The samples above and below on one side.
    pub near: [&'a [f32]; 2],
    /// The samples above and below on the other side; not to be read where `along` is 0.
    pub far: [&'a [f32]; 2],
    /// How far the place lies toward the far side.
    pub along: f32,
    /// How far it lies toward the samples below; where 0, these are not to be read.
    pub down: f32,
}

/// Base cells between the samples of a level.
fn spacing(level: usize) -> i64 {
    1 << level.saturating_sub(2)
}

/// The lattice of a level: every sample of it is one of the base grid's lattice.
fn lattice(base: Lattice, level: usize) -> Lattice {
    Lattice { span: base.span * spacing(level) as f64, ..base }
}

/// Samples of the level below from one to the next of this level, and from the middle of the kernel to its ends.
fn steps(level: usize) -> (i64, i64) {
    let below = spacing(level - 1);
    (spacing(level) / below, (1 << (level - 1)) / below)
}

/// Steps of the base grid for a step of a window's lattice, as a fraction.
fn scale(window: &Grid, base: Lattice) -> (f64, f64) {
    (f64::from(base.intervals), f64::from(window.lattice.intervals))
}

impl Extents {
    /// What a window needs that looks `margins[level]` base cells to every side on each level, where 0 is not to look
    /// at it.
    pub fn new(window: &Grid, base: Lattice, margins: &[f64]) -> Self {
        let (num, den) = scale(window, base);
        let own = |level: usize, margin: f64| {
            let spacing = spacing(level) as f64;
            // One more on both sides than straight lines need, against rounding.
            let before = |i: i64| ((i as f64 * num / den - margin) / spacing).floor() as i64 - 1;
            let after = |i: i64| ((i as f64 * num / den + margin) / spacing).ceil() as i64 + 2;
            let start = [before(window.col), before(window.row)];
            let end = [after(window.col_end() - 1), after(window.row_end() - 1)];
            Grid::between(lattice(base, level), start, end)
        };
        let mut levels: Vec<Grid> = margins.iter().enumerate().map(|(l, m)| own(l, *m)).collect();
        for level in (1..levels.len()).rev() {
            levels[level - 1] = levels[level - 1].union(&source(&levels[level], level));
        }
        let column = |c: i64| if den < num { c as f64 * num / den } else { c as f64 };
        let (wide, narrow) = columns_scale((num, den));
        let part = |margin: &f64| {
            let reach = margin * wide / narrow;
            let first = (column(window.col) - reach).floor() as i64 - 1;
            let last = (column(window.col_end() - 1) + reach).ceil() as i64 + 1;
            (*margin > 0.0).then_some((first, (last + 1 - first) as usize))
        };
        let lines = margins.iter().map(part).collect();
        Self { levels, lines }
    }

    /// The window of the field itself; none where nothing is looked at.
    pub fn field(&self) -> Option<Grid> {
        self.levels.first().copied()
    }

    /// Leaves out what lies so far beyond the window of the field that its border values alone stand there.
    pub fn within(mut self, field: &Grid) -> Self {
        for (level, window) in self.levels.iter_mut().enumerate() {
            let (spacing, reach) = (spacing(level), if level == 0 { 0 } else { 1_i64 << level });
            let low = |first: i64| (first - reach).div_euclid(spacing) - i64::from(level > 0);
            let high = |end: i64| -(-(end - 1 + reach)).div_euclid(spacing) + 1 + i64::from(level > 0);
            let clamp = |start: i64, end: i64, low: i64, high: i64| {
                let start = start.clamp(low, high - 1);
                (start, end.clamp(start + 1, high))
            };
            let (col, col_end) = clamp(window.col, window.col_end(), low(field.col), high(field.col_end()));
            let (row, row_end) = clamp(window.row, window.row_end(), low(field.row), high(field.row_end()));
            *window = Grid::between(window.lattice, [col, row], [col_end, row_end]);
        }
        self
    }

    /// The lines of each level as first column and count, no farther than its samples reach.
    fn lines(&self, scale: (f64, f64)) -> impl Iterator<Item = Option<(i64, usize)>> {
        let (num, den) = columns_scale(scale);
        self.lines.iter().zip(&self.levels).enumerate().map(move |(level, (lines, grid))| {
            let (first, count) = (*lines)?;
            let at = |sample: i64| (sample * spacing(level)) as f64 * num / den;
            let low = at(grid.col).floor() as i64;
            let high = at(grid.col_end() - 1).ceil() as i64;
            let start = first.clamp(low, high);
            let end = (first + count as i64).clamp(start + 1, high + 1);
            Some((start, (end - start) as usize))
        })
    }

    /// Bytes of scratch memory of [`Far::new`], and of what it gives.
    pub fn bytes(&self, window: &Grid, base: Lattice) -> u64 {
        let scale = scale(window, base);
        // Rows begin and end at whole numbers of strides.
        let beside = 2 * stride(scale).unwrap_or(1) as u64;
        let columns = |part: Option<(i64, usize)>| part.map_or(0, |(_, count)| count as u64 + beside);
        let rows = |(part, grid): (_, &Grid)| columns(part) * grid.rows as u64;
        let lines: u64 = self.lines(scale).zip(&self.levels).map(rows).sum();
        // Where each column stands among the samples of a level.
        let places = 6 * self.lines(scale).map(columns).max().unwrap_or(0);
        // A level is smoothed on the lattice of the one below in two passes, then thinned.
        let worst = (1..self.levels.len()).map(|level| {
            let below = &self.levels[level - 1];
            let fine = smoothed(&self.levels[level], level);
            (below.len() + 2 * fine.grow_cells(steps(level).1).len() + self.levels[level].len()) as u64
        });
        4 * (lines + places + worst.max().unwrap_or(0))
    }

    /// Samples that [`Far::new`] computes.
    pub fn work(&self, window: &Grid, base: Lattice) -> u64 {
        let lines = self.lines(scale(window, base)).zip(&self.levels);
        let lines: u64 = lines.map(|(l, grid)| l.map_or(0, |l| l.1 as u64 * grid.rows as u64)).sum();
        let smooth = (1..self.levels.len()).map(|l| 2 * smoothed(&self.levels[l], l).len() as u64);
        lines + smooth.sum::<u64>()
    }
}

/// The window of the level below whose samples those of a window of a level are, with those between them.
fn smoothed(grid: &Grid, level: usize) -> Grid {
    let (factor, _) = steps(level);
    let start = [grid.col * factor, grid.row * factor];
    let end = [(grid.col_end() - 1) * factor + 1, (grid.row_end() - 1) * factor + 1];
    Grid::between(Lattice { span: grid.lattice.span / factor as f64, ..grid.lattice }, start, end)
}

/// The window of the level below that a window of a level is made from.
fn source(grid: &Grid, level: usize) -> Grid {
    smoothed(grid, level).grow_cells(steps(level).1)
}

impl Far {
    /// Smooths a field of the base grid, input `port`, for a window; see [`Extents`].
    ///
    /// # Errors
    /// When the field does not stand on the base grid, or the work was asked to stop.
    pub fn new(
        work: &Work<'_>,
        port: &'static str,
        field: Field,
        window: &Grid,
        base: Lattice,
        extents: &Extents,
    ) -> Result<Self> {
        if field.grid().lattice != base || field.grid().is_empty() {
            let message = format!("stands on {:?}, not on the base grid", field.grid());
            return Err(Error::Input { port: port.into(), message });
        }
        let extents = extents.clone().within(field.grid());
        let scale = scale(window, base);
        let parts = extents.lines(scale).collect::<Vec<_>>();
        let (mut lines, mut level_field) = (Vec::new(), field);
        let count = parts.len() as f32;
        for (level, part) in parts.into_iter().enumerate() {
            let work = work.stage(level as f32 / count, (level + 1) as f32 / count);
            if level > 0 {
                level_field = smooth(&work, port, &level_field, &extents.levels[level], level)?;
            }
            let drawn = part.map(|part| Lines::new(&work, &level_field, spacing(level), part, scale));
            lines.push(drawn.transpose()?);
        }
        Ok(Self { lines, columns: Columns::new(window, scale), cols: window.cols, scale })
    }

    /// The place that lies some base cells to the east and south, on a level.
    pub fn place(&self, level: usize, [east, south]: [f64; 2]) -> Place {
        let (num, den) = columns_scale(self.scale);
        let east = east * num / den;
        let nearest = east.round();
        // A product such as 5 · 2.2 may land a hair beside the whole number it stands for.
        let whole =
            if (east - nearest).abs() <= 1e-9 * nearest.abs().max(1.0) { nearest } else { east.floor() };
        Place { level, east: (whole as i64, (east - whole).max(0.0) as f32), south }
    }

    /// What the samples of a row of the window's lattice see at a place. `scratch` may be filled.
    #[inline(always)]
    pub fn sight<'a>(&'a self, row: i64, place: &Place, scratch: &'a mut Vec<f32>) -> Sight<'a> {
        let Some(lines) = &self.lines[place.level] else { return Sight::nothing() };
        let at = (row as f64 * self.scale.0 / self.scale.1 + place.south) / lines.spacing;
        let above = at.floor();
        let (down, rows) = ((at - above) as f32, [above as i64, above as i64 + 1].map(|row| lines.row(row)));
        let ((whole, along), n) = (place.east, self.cols);
        match &self.columns {
            Columns::Every(step, first) => {
                let (near, far) = (lines.part(first + whole.div_euclid(*step), whole.rem_euclid(*step)), {
                    let next = whole + 1;
                    lines.part(first + next.div_euclid(*step), next.rem_euclid(*step))
                });
                let (Some(near), Some(far)) = (near.of(rows, n), far.of(rows, n)) else {
                    return beyond(scratch, n, |side, i| {
                        let part = [near, far][side / 2];
                        part.at(rows[side % 2], i)
                    })
                    .with(along, down);
                };
                Sight { near, far, along, down }
            }
            Columns::Each(columns) => {
                let value = |i: usize| {
                    let (column, share) = columns[i];
                    let share = share + along;
                    let (column, share) =
                        if share < 1.0 { (column + whole, share) } else { (column + whole + 1, share - 1.0) };
                    let [near, far] = [column, column + 1].map(|column| {
                        let [top, bottom] = rows.map(|row| lines.part(column, 0).at(row, 0));
                        top + down * (bottom - top)
                    });
                    near + share * (far - near)
                };
                scratch.clear();
                scratch.extend((0..n).map(value));
                let values: &[f32] = scratch;
                Sight { near: [values; 2], far: [values; 2], along: 0.0, down: 0.0 }
            }
        }
    }
}

impl<'a> Sight<'a> {
    /// No sample at all.
    fn nothing() -> Self {
        Self { near: [&[]; 2], far: [&[]; 2], along: 0.0, down: 0.0 }
    }

    fn with(self, along: f32, down: f32) -> Self {
        Self { along, down, ..self }
    }
}

/// The four sides of a sight one by one, where the lines do not reach so far: their border values continue.
#[inline(never)]
fn beyond(scratch: &mut Vec<f32>, n: usize, value: impl Fn(usize, usize) -> f32) -> Sight<'_> {
    scratch.clear();
    scratch.extend((0..4 * n).map(|k| value(k / n, k % n)));
    let side = |k: usize| &scratch[k * n..][..n];
    Sight { near: [side(0), side(1)], far: [side(2), side(3)], along: 0.0, down: 0.0 }
}

/// A level from the one below.
fn smooth(work: &Work<'_>, port: &'static str, below: &Field, grid: &Grid, level: usize) -> Result<Field> {
    let (factor, step) = steps(level);
    let fine = morphology::blend(work, port, below, &smoothed(grid, level), &[(step, 0.25)])?;
    if factor == 1 {
        return Ok(fine);
    }
    let factor = factor as usize;
    let rows = (0..grid.rows).map(|j| fine.row(j * factor));
    let data = rows.flat_map(|row| row.iter().step_by(factor).copied()).collect();
    Ok(Raster::new(*grid, fine.quantity(), data))
}
