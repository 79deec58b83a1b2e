//! The median over a disk.
//!
//! A window slides along each row; what it holds is counted by rank, in two levels, so that a step costs the rim of
//! the disk and not its area \[huang1979\]. The median of counted samples is exact.
//!
//! Wide disks are bounded, so that the time a sample does not grow without end. All is anchored at indices of the
//! lattice, so a tile and the whole give the same bits:
//! - above [`FINE`] cells the median is taken, exactly, on every second, third, … point of the lattice, and a
//!   Catmull-Rom spline, kept within the values it joins, runs between them;
//! - above [`DENSE`] cells the disk counts every second, third, … sample.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::kit::sample::catmull_rom;
use crate::value::{Field, Grid, fill};
use crate::work::{Cancelled, Work};

/// Widest radius, in cells, at which every point gets a median of its own.
pub const FINE: f64 = 32.0;
/// Widest radius, in cells, at which every sample of the disk is counted.
pub const DENSE: f64 = 128.0;
/// Ranks that one coarse counter sums.
const BIN: usize = 32;

/// How a median of some radius is taken.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Lattice steps between counted samples.
    stride: i64,
    /// Steps, in strides, between points with a median of their own.
    spacing: i64,
    /// Radius in strides.
    radius: f64,
}

impl Plan {
    fn new(cells: f64) -> Self {
        let stride = (cells / DENSE).ceil().max(1.0);
        let radius = cells / stride;
        Self { stride: stride as i64, spacing: (radius / FINE).ceil().max(1.0) as i64, radius }
    }

    /// Lattice steps between points with a median of their own.
    fn step(&self) -> i64 {
        self.stride * self.spacing
    }

    fn reach(&self) -> i64 {
        self.radius.floor() as i64
    }

    /// First and last point with a median of its own that a range of lattice indices needs, in steps.
    fn centers(&self, from: i64, end: i64) -> [i64; 2] {
        match self.step() {
            1 => [from, end - 1],
            step => [from.div_euclid(step) - 1, (end - 1).div_euclid(step) + 2],
        }
    }

    /// Points with a median of their own that are worked on at a time, along each axis.
    fn block(&self) -> i64 {
        (2 * self.reach()).max(64) / self.spacing
    }

    /// Counted samples along one axis of a block.
    fn extent(&self) -> usize {
        (self.block() * self.spacing + 2 * self.reach() + 1) as usize
    }
}

/// The window of the input that [`disk`] reads for a window of the output; the radius in metres.
pub fn footprint(window: Grid, radius: f64) -> Grid {
    let plan = Plan::new(radius / window.cell());
    let span = |from, end| {
        let [a, b] = plan.centers(from, end);
        let reach = plan.reach() * plan.stride;
        [a * plan.step() - reach, b * plan.step() + reach + 1]
    };
    let (cols, rows) = (span(window.col, window.col_end()), span(window.row, window.row_end()));
    Grid::between(window.lattice, [cols[0], rows[0]], [cols[1], rows[1]])
}

/// Bytes that [`disk`] needs beside input and output, at most; the radius in metres.
pub fn scratch(window: &Grid, radius: f64) -> u64 {
    let plan = Plan::new(radius / window.cell());
    let samples = (plan.extent() * plan.extent()) as u64;
    // Sort key, rank, value and count of each sample of a block, in every thread that has one.
    let threads = rayon::current_num_threads() as u64;
    let step = plan.step() as u64;
    let centers = (window.cols as u64 / step + 5) * (window.rows as u64 / step + 5);
    samples * 20 * threads + if step == 1 { 0 } else { centers * 4 } + (1 << 16)
}

/// Nanoseconds a sample on one core; the radius in metres.
pub fn nanoseconds(window: &Grid, radius: f64) -> f64 {
    let plan = Plan::new(radius / window.cell());
    if plan.reach() == 0 {
        return 1.0;
    }
    let share = plan.extent() as f64 / plan.block() as f64;
    let (rim, spacing) = (4.0 * plan.radius + 2.0, plan.spacing as f64);
    let each =
        (60.0 + share * share * 60.0 + rim * spacing * 2.5) / (plan.step() * plan.step()) as f64 + 15.0;
    // Wide disks leave the fast cache.
    each * (1.0 + plan.radius / 60.0).min(4.0)
}

/// The median over a disk around each point of `window`; the radius in metres, the rim included.
///
/// # Errors
/// [`Error::Cancelled`] when the work was asked to stop; [`Error::Input`] when the input has no sample.
pub fn disk(work: &Work<'_>, input: &Field, window: Grid, radius: f64) -> Result<Field> {
    let plan = Plan::new(radius / window.cell());
    if window.is_empty() || plan.reach() == 0 {
        return Ok(input.crop(&window));
    }
    if input.grid().is_empty() {
        return Err(Error::Input { port: "field".into(), message: "has no samples".into() });
    }
    let cols = plan.centers(window.col, window.col_end());
    let rows = plan.centers(window.row, window.row_end());
    if plan.step() == 1 {
        let data = medians(work, input, &plan, cols, rows)?;
        return Ok(Field::new(window, input.quantity(), data));
    }
    let coarse = medians(&work.stage(0.0, 0.9), input, &plan, cols, rows)?;
    between(&work.stage(0.9, 1.0), &coarse, &plan, [cols[0], rows[0]], window, input)
}

/// The medians at all centres, row by row.
fn medians(work: &Work<'_>, input: &Field, plan: &Plan, cols: [i64; 2], rows: [i64; 2]) -> Result<Vec<f32>> {
    let (width, height) = ((cols[1] - cols[0] + 1) as usize, (rows[1] - rows[0] + 1) as usize);
    let block = plan.block() as usize;
    let mut out = vec![0.0; width * height];
    let done = std::sync::atomic::AtomicUsize::new(0);
    out.par_chunks_mut(width * block).enumerate().try_for_each(|(b, band)| {
        let mut counter = Counter::new(*plan);
        for start in (0..width).step_by(block) {
            work.check()?;
            let n = block.min(width - start);
            let first = [cols[0] + start as i64, rows[0] + (b * block) as i64];
            counter.load(input, first);
            for (j, row) in band.chunks_mut(width).enumerate() {
                counter.row(j, &mut row[start..start + n]);
            }
        }
        let finished = done.fetch_add(band.len(), std::sync::atomic::Ordering::Relaxed) + band.len();
        work.report(finished as f32 / (width * height) as f32);
        Ok::<(), Cancelled>(())
    })?;
    Ok(out)
}

/// Counts the samples of a sliding disk by their rank in a block.
struct Counter {
    plan: Plan,
    extent: usize,
    /// Half the width of the disk, for each of its rows.
    halves: Vec<usize>,
    ranks: Vec<u32>,
    values: Vec<f32>,
    keys: Vec<u64>,
    fine: Vec<u16>,
    coarse: Vec<u32>,
    /// The coarse counter that holds the median, and how many samples lie below it.
    bin: usize,
    below: u32,
}

impl Counter {
    fn new(plan: Plan) -> Self {
        let (extent, reach) = (plan.extent(), plan.reach());
        // A hair more than the square, so that a rim point at 3, 4 of a radius of 5 is in whatever the rounding.
        let square = plan.radius * plan.radius * (1.0 + 1e-12);
        let half = |dy: i64| libm::sqrt(square - (dy * dy) as f64).floor() as usize;
        Self {
            plan,
            extent,
            halves: (-reach..=reach).map(half).collect(),
            ranks: vec![0; extent * extent],
            values: Vec::new(),
            keys: Vec::with_capacity(extent * extent),
            fine: Vec::new(),
            coarse: Vec::new(),
            bin: 0,
            below: 0,
        }
    }

    /// Reads and ranks the samples around a block whose first centre is `first`.
    fn load(&mut self, input: &Field, first: [i64; 2]) {
        let reach = self.plan.reach();
        let [col, row] = first.map(|c| (c * self.plan.spacing - reach) * self.plan.stride);
        let last = input.grid().cols as i64 - 1;
        let columns: Vec<usize> = (0..self.extent as i64)
            .map(|i| (col + i * self.plan.stride - input.grid().col).clamp(0, last) as usize)
            .collect();
        self.keys.clear();
        for j in 0..self.extent {
            let line = input.row(input.clamped_row(row + j as i64 * self.plan.stride));
            let place = (j * self.extent) as u64;
            let key = |(i, &c): (usize, &usize)| u64::from(ordered(line[c])) << 32 | (place + i as u64);
            self.keys.extend(columns.iter().enumerate().map(key));
        }
        self.keys.sort_unstable();
        self.values.clear();
        let mut previous = None;
        for key in &self.keys {
            let (value, place) = ((key >> 32) as u32, (key & 0xffff_ffff) as usize);
            if previous != Some(value) {
                self.values.push(from_ordered(value));
                previous = Some(value);
            }
            self.ranks[place] = self.values.len() as u32 - 1;
        }
    }

    /// The medians of one row of centres.
    fn row(&mut self, j: usize, out: &mut [f32]) {
        self.fine.clear();
        self.fine.resize(self.values.len().next_multiple_of(BIN), 0);
        self.coarse.clear();
        self.coarse.resize(self.fine.len() / BIN, 0);
        (self.bin, self.below) = (0, 0);
        let (reach, top) = (self.plan.reach() as usize, j * self.plan.spacing as usize);
        let mut count = 0;
        for k in 0..self.halves.len() {
            let (line, half) = ((top + k) * self.extent, self.halves[k]);
            for x in reach - half..=reach + half {
                self.add(line + x);
            }
            count += 2 * half as u32 + 1;
        }
        let mut center = reach;
        for (i, o) in out.iter_mut().enumerate() {
            while center < reach + i * self.plan.spacing as usize {
                for k in 0..self.halves.len() {
                    let (line, half) = ((top + k) * self.extent, self.halves[k]);
                    self.remove(line + center - half);
                    self.add(line + center + half + 1);
                }
                center += 1;
            }
            *o = self.middle(count / 2);
        }
    }

    fn add(&mut self, place: usize) {
        let rank = self.ranks[place] as usize;
        self.fine[rank] += 1;
        self.coarse[rank / BIN] += 1;
        self.below += u32::from(rank / BIN < self.bin);
    }

    fn remove(&mut self, place: usize) {
        let rank = self.ranks[place] as usize;
        self.fine[rank] -= 1;
        self.coarse[rank / BIN] -= 1;
        self.below -= u32::from(rank / BIN < self.bin);
    }

    /// The value below which `rest` samples lie.
    fn middle(&mut self, rest: u32) -> f32 {
        while self.below > rest {
            self.bin -= 1;
            self.below -= self.coarse[self.bin];
        }
        while self.below + self.coarse[self.bin] <= rest {
            self.below += self.coarse[self.bin];
            self.bin += 1;
        }
        let mut below = self.below;
        let start = self.bin * BIN;
        let within = self.fine[start..start + BIN].iter().position(|&n| {
            below += u32::from(n);
            below > rest
        });
        self.values[start + within.unwrap_or(0)]
    }
}

/// Bits whose order is that of the numbers; both zeros are one.
fn ordered(value: f32) -> u32 {
    let bits = (value + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn from_ordered(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & !(1 << 31) } else { !bits })
}

/// Runs a spline between medians that stand on every `step`-th point of the lattice.
fn between(
    work: &Work<'_>,
    coarse: &[f32],
    plan: &Plan,
    first: [i64; 2],
    window: Grid,
    input: &Field,
) -> Result<Field> {
    let step = plan.step();
    let width = {
        let [a, b] = plan.centers(window.col, window.col_end());
        (b - a + 1) as usize
    };
    let place = |at: i64, first: i64| {
        let before = at.div_euclid(step);
        ((before - 1 - first) as usize, (at - before * step) as f32 / step as f32)
    };
    Ok(fill(work, window, input.quantity(), |row, out| {
        let (j, t) = place(row.row, first[1]);
        let lines: [&[f32]; 4] = [0, 1, 2, 3].map(|k| &coarse[(j + k) * width..][..width]);
        for (i, o) in out.iter_mut().enumerate() {
            let (x, s) = place(window.col + i as i64, first[0]);
            let rows = lines.map(|l| [l[x], l[x + 1], l[x + 2], l[x + 3]]);
            let value = catmull_rom(rows.map(|p| catmull_rom(p, s)), t);
            let all = rows.as_flattened();
            let (lo, hi) = all.iter().fold((f32::MAX, f32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
            *o = value.max(lo).min(hi);
        }
    })?)
}
