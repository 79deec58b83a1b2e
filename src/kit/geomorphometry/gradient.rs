//! How steep land is, and which way it faces.

use rayon::prelude::*;
use serde::Serialize;

use super::Land;
use super::sums::{Moments, percentiles, plus, sums};
use crate::work::{Cancelled, Work};

/// Heights whose steps tell the step in which all heights are given.
const SAMPLED: usize = 200_000;
/// Fewest cells whose directions say something.
const FEWEST: f64 = 1000.0;

/// Slope in degrees by \[horn1981\], over the eight neighbours of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// Mean.
    pub mean: f64,
    /// 5th percentile.
    pub p5: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Share of the cells that are steeper than 35°.
    pub steeper_than_35: f64,
    /// Share of the cells that are flatter than 0.5°.
    pub flatter_than_half: f64,
}

/// Harmonics of the direction `φ` in which land falls, counter-clockwise from the east, weighted by the slope.
///
/// Only cells count that are steeper than four steps of height in a cell, because the direction of a gentler slope is
/// that of its rounding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aspect {
    /// `|⟨exp(iφ)⟩|`: how far the land as a whole falls one way.
    pub m1: f64,
    /// `|⟨exp(2iφ)⟩|`: the grain of the rock.
    pub m2: f64,
    /// `⟨cos 4φ⟩`: above 0 where slopes face along the axes of the grid, below 0 along its diagonals.
    pub m4: f64,
    /// `⟨cos 8φ⟩`: above 0 where slopes are drawn to multiples of 45°, the mark of a grid.
    pub m8: f64,
    /// Share of the sloping cells that count.
    pub used: f64,
    /// Step in which heights are given, in metres: the least difference among the first 200,000.
    pub step: f64,
}

/// The figures of slope and direction; none of land that is nowhere three cells wide, and no direction where fewer than
/// 1000 cells are steep enough.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub(super) fn measure(land: &Land, work: &Work<'_>) -> Result<(Option<Slope>, Option<Aspect>), Cancelled> {
    let step = step(land);
    let least = (4.0 * step / land.cell()).max(1e-4);
    let rows: Vec<usize> = (0..land.rows()).collect();
    let of_row = |j: &usize| -> Result<Row, Cancelled> {
        if j.is_multiple_of(64) {
            work.step(*j as f32 / land.rows() as f32)?;
        }
        Ok(Row::of(land, *j, least))
    };
    let rows: Vec<Row> = rows.par_iter().map(of_row).collect::<Result<_, Cancelled>>()?;
    let harmonics = rows.iter().fold(Harmonics::default(), |sums, row| sums.and(&row.harmonics));
    let mut degrees: Vec<f32> = rows.into_iter().flat_map(|row| row.degrees).collect();
    work.check()?;
    let aspect = aspect(&harmonics, degrees.len(), step);
    Ok((slope(&mut degrees), aspect))
}

fn slope(degrees: &mut [f32]) -> Option<Slope> {
    let Moments { count, mean, .. } = Moments::of(degrees)?;
    let share = |is: fn(f32) -> bool| sums(degrees, |d| [f64::from(u8::from(is(*d)))])[0] / count as f64;
    let (steeper_than_35, flatter_than_half) = (share(|d| d > 35.0), share(|d| d < 0.5));
    let [p5, p50, p95, p99] = percentiles(degrees, [0.05, 0.5, 0.95, 0.99])?;
    Some(Slope { mean, p5, p50, p95, p99, steeper_than_35, flatter_than_half })
}

fn aspect(harmonics: &Harmonics, of: usize, step: f64) -> Option<Aspect> {
    let Harmonics { count, weight, east, north, fourth, eighth } = harmonics;
    let length = |k: usize| libm::hypot(east[k], north[k]) / weight;
    let used = count / of as f64;
    let [m1, m2] = [length(0), length(1)];
    (*count >= FEWEST).then(|| Aspect { m1, m2, m4: fourth / weight, m8: eighth / weight, used, step })
}

/// Sums of powers of the unit vectors in which cells fall, weighted by their slope.
#[derive(Clone, Copy, Debug, Default)]
struct Harmonics {
    count: f64,
    weight: f64,
    /// East parts of the first and the second power.
    east: [f64; 2],
    /// North parts of the same.
    north: [f64; 2],
    /// East part of the fourth power.
    fourth: f64,
    /// East part of the eighth power.
    eighth: f64,
}

impl Harmonics {
    /// Adds a cell that falls by `slope` towards a unit vector.
    fn add(&mut self, slope: f64, [e, n]: [f64; 2]) {
        // The square of a complex number of length 1 has twice its angle.
        let twice = |[e, n]: [f64; 2]| [e * e - n * n, 2.0 * e * n];
        let second = twice([e, n]);
        let fourth = twice(second);
        self.count += 1.0;
        self.weight += slope;
        self.east = plus(self.east, [slope * e, slope * second[0]]);
        self.north = plus(self.north, [slope * n, slope * second[1]]);
        self.fourth += slope * fourth[0];
        self.eighth += slope * twice(fourth)[0];
    }

    fn and(self, next: &Self) -> Self {
        Self {
            count: self.count + next.count,
            weight: self.weight + next.weight,
            east: plus(self.east, next.east),
            north: plus(self.north, next.north),
            fourth: self.fourth + next.fourth,
            eighth: self.eighth + next.eighth,
        }
    }
}

/// What one row has.
struct Row {
    /// Slopes in degrees.
    degrees: Vec<f32>,
    harmonics: Harmonics,
}

impl Row {
    fn of(land: &Land, j: usize, least: f64) -> Self {
        let mut row = Self { degrees: Vec::new(), harmonics: Harmonics::default() };
        for i in (0..land.cols()).filter(|i| land.is_inland(*i, j)) {
            let [x, y] = horn(land, i, j);
            let slope = libm::hypot(x, y);
            row.degrees.push(libm::atan(slope).to_degrees() as f32);
            if slope > least {
                // Rows run to the south: what rises to the south falls to the north.
                row.harmonics.add(slope, [-x / slope, y / slope]);
            }
        }
        row
    }
}

/// The gradient of a cell that has all neighbours, towards the east and the south, in metres per metre.
fn horn(land: &Land, i: usize, j: usize) -> [f64; 2] {
    let [north, here, south] = [j - 1, j, j + 1].map(|j| {
        let row = land.row(j);
        [row[i - 1], row[i], row[i + 1]].map(f64::from)
    });
    let per_metre = 1.0 / (8.0 * land.cell());
    let east = (north[2] - north[0]) + 2.0 * (here[2] - here[0]) + (south[2] - south[0]);
    let down = (south[0] - north[0]) + 2.0 * (south[1] - north[1]) + (south[2] - north[2]);
    [east * per_metre, down * per_metre]
}

/// The step in which heights are given, in metres; 0 where all are the same.
fn step(land: &Land) -> f64 {
    let finite = land.heights().iter().copied().filter(|z| z.is_finite());
    let mut heights: Vec<f32> = finite.take(SAMPLED).collect();
    heights.sort_unstable_by(f32::total_cmp);
    let steps = heights.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0]));
    let least = steps.filter(|step| *step > 1e-6).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}
