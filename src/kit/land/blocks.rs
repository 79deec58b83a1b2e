//! Lines by the blocks of a grid that they come near, so that a sample looks at few of many.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::line::WideLine;
use crate::value::Grid;
use crate::work::{Cancelled, Work};

/// Samples along a side of a block.
const SIDE: usize = 64;

/// The numbers of the lines that come near each block of a grid, in rising order.
pub(super) struct Blocks<'a> {
    grid: Grid,
    lines: &'a [WideLine],
    /// Blocks in a row of them.
    across: usize,
    /// Where the lines of each block start, and where the last end.
    starts: Vec<usize>,
    numbers: Vec<u32>,
}

/// A part of a grid, in columns and rows of it.
pub(super) struct Part {
    pub cols: Range<usize>,
    pub rows: Range<usize>,
}

impl<'a> Blocks<'a> {
    /// Sorts lines that each reach some metres around their line. Lines with a number that is not finite are left out.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub(super) fn new(
        work: &Work<'_>,
        grid: Grid,
        lines: &'a [WideLine],
        reach: impl Fn(&WideLine) -> f64,
    ) -> Result<Self, Cancelled> {
        let (across, down) = (grid.cols.div_ceil(SIDE), grid.rows.div_ceil(SIDE));
        let mut starts = vec![0; across * down + 1];
        let each = |f: &mut dyn FnMut(u32, usize)| {
            for (number, wide) in lines.iter().enumerate() {
                if number % (1 << 16) == 0 {
                    work.check()?;
                }
                let Some(part) = near(&grid, wide, reach(wide)) else { continue };
                for row in part.rows.start / SIDE..part.rows.end.div_ceil(SIDE) {
                    for col in part.cols.start / SIDE..part.cols.end.div_ceil(SIDE) {
                        f(number as u32, row * across + col);
                    }
                }
            }
            Ok::<(), Cancelled>(())
        };
        each(&mut |_, block| starts[block + 1] += 1)?;
        for block in 0..across * down {
            starts[block + 1] += starts[block];
        }
        let mut numbers = vec![0; starts[across * down]];
        let mut next = starts.clone();
        each(&mut |number, block| {
            numbers[next[block]] = number;
            next[block] += 1;
        })?;
        Ok(Self { grid, lines, across, starts, numbers })
    }

    /// Bytes that the sorted lines take at most, for lines that reach so many metres.
    pub(super) fn bytes(grid: &Grid, lines: &[WideLine], reach: impl Fn(&WideLine) -> f64) -> u64 {
        let blocks = |r: &Range<usize>| (r.end.div_ceil(SIDE) - r.start / SIDE) as u64;
        let parts = lines.iter().filter_map(|wide| near(grid, wide, reach(wide)));
        let entries: u64 = parts.map(|part| blocks(&part.cols) * blocks(&part.rows)).sum();
        let all = grid.cols.div_ceil(SIDE) * grid.rows.div_ceil(SIDE);
        4 * entries + 16 * (all as u64 + 1)
    }

    /// Fills samples block by block, rows of blocks in parallel; `f` is given the part that a block is, its lines in order,
    /// and the rows of the block with those left and right of it.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub(super) fn fill<T: Send>(
        &self,
        work: &Work<'_>,
        data: &mut [T],
        f: impl Fn(&Part, &mut dyn Iterator<Item = &'a WideLine>, &mut [T]) + Sync,
    ) -> Result<(), Cancelled> {
        let (cols, rows) = (self.grid.cols, self.grid.rows);
        let (count, done) = (self.starts.len() - 1, AtomicUsize::new(0));
        data.par_chunks_mut((cols * SIDE).max(1)).enumerate().try_for_each(|(down, band)| {
            for across in 0..self.across {
                work.check()?;
                let block = down * self.across + across;
                let part = Part {
                    cols: across * SIDE..((across + 1) * SIDE).min(cols),
                    rows: down * SIDE..((down + 1) * SIDE).min(rows),
                };
                let numbers = &self.numbers[self.starts[block]..self.starts[block + 1]];
                f(&part, &mut numbers.iter().map(|&n| &self.lines[n as usize]), band);
            }
            let finished = done.fetch_add(self.across, Ordering::Relaxed) + self.across;
            work.report(finished as f32 / count.max(1) as f32);
            Ok(())
        })
    }
}

/// The samples of a grid in the rectangle around a line, grown by some metres; none where it lies outside.
pub(super) fn near(grid: &Grid, wide: &WideLine, reach: f64) -> Option<Part> {
    if !wide.line.is_finite() {
        return None;
    }
    let [a, b] = wide.line.ends;
    let low = grid.lattice.steps(a[0].min(b[0]) - reach, a[1].min(b[1]) - reach);
    let high = grid.lattice.steps(a[0].max(b[0]) + reach, a[1].max(b[1]) + reach);
    let range = |axis: usize, first: i64, count: usize| {
        let place = |steps: f64| (steps - first as f64).clamp(-1.0, count as f64);
        // A sample that rounding puts on the wrong side is none of those that count.
        let from = place(low[axis].floor()).max(0.0) as usize;
        let to = (place(high[axis].ceil()) + 1.0).clamp(0.0, count as f64) as usize;
        (from < to).then_some(from..to)
    };
    Some(Part { cols: range(0, grid.col, grid.cols)?, rows: range(1, grid.row, grid.rows)? })
}

impl Part {
    /// What is in both.
    pub(super) fn and(&self, other: &Self) -> Self {
        let both = |a: &Range<usize>, b: &Range<usize>| a.start.max(b.start)..a.end.min(b.end);
        Self { cols: both(&self.cols, &other.cols), rows: both(&self.rows, &other.rows) }
    }
}

/// A line as samples see it: one at a time, from the lower end.
pub(super) struct Course {
    from: [f64; 2],
    direction: [f64; 2],
    pub length: f64,
}

/// How a place lies to a line.
#[derive(Clone, Copy)]
pub(super) struct Sight {
    /// Metres along the line through the line, from its lower end.
    pub along: f64,
    /// Squared metres from that line.
    pub aside2: f64,
    /// Metres from the line's nearest point.
    pub distance: f64,
}

impl Course {
    pub(super) fn new(wide: &WideLine) -> Self {
        let [from, to] = wide.line.ends;
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(x, y);
        let direction = if length > 0.0 { [x / length, y / length] } else { [0.0; 2] };
        Self { from, direction, length }
    }

    pub(super) fn sight(&self, [x, y]: [f64; 2]) -> Sight {
        let [x, y] = [x - self.from[0], y - self.from[1]];
        let [dx, dy] = self.direction;
        let (along, across) = (x * dx + y * dy, x * dy - y * dx);
        // A line without length has no direction: all that is not along it is aside.
        let aside2 = if self.length > 0.0 { across * across } else { x * x + y * y };
        let beyond = along - along.clamp(0.0, self.length);
        Sight { along, aside2, distance: (aside2 + beyond * beyond).sqrt() }
    }
}
