//! How rough land is at every wavelength.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use serde::Serialize;

use super::Land;
use super::line::Line;
use super::rectangle::Rectangle;
use super::sums::plus;
use crate::work::{Cancelled, Work};

/// Shortest side, in cells, of a rectangle whose spectrum says something.
const SHORTEST: usize = 64;
/// Rings of wavenumbers, of equal ratio.
const RINGS: usize = 32;
/// Fewest wavenumbers of a ring that counts.
const FEWEST: f64 = 8.0;
/// Fewest rings that a line is fitted through.
const FEWEST_RINGS: usize = 4;
/// Columns that one task transforms, so that it reads whole cache lines.
const STRIP: usize = 8;

/// The power spectrum of the largest rectangle of land.
///
/// A plane is taken off, a Hann window is put over the rest, and the power `P` of its Fourier transform is averaged over
/// rings of wavenumbers `k`. `β` is the exponent of `P ~ k^−β`, fitted to the rings of a range of wavelengths. A profile
/// of the same land has `β − 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spectrum {
    /// Columns and rows of the rectangle.
    pub window: [usize; 2],
    /// β over wavelengths from 4 cells to a quarter of the shorter side.
    pub beta: f64,
    /// Coefficient of determination of that line.
    pub beta_r2: f64,
    /// Hurst exponent of a fractional Brownian surface with that β, `(β − 2) / 2`.
    pub hurst: f64,
    /// β over wavelengths from 3 to 12 cells.
    pub beta_fine: Option<f64>,
    /// β over wavelengths from 12 cells to a quarter of the shorter side.
    pub beta_coarse: Option<f64>,
    /// Power below 2.6 cells over what the line through 4 to 10 cells says: far below 1 where land was smoothed or
    /// enlarged.
    pub finest_power: Option<f64>,
    /// Power of waves that run north to south, 3 to 16 cells long, over the power of all directions: 1 where land has no
    /// direction, above 3 where it has stripes or steps from west to east.
    pub stripes_east_west: Option<f64>,
    /// The same of waves that run east to west: stripes from north to south.
    pub stripes_north_south: Option<f64>,
}

impl Spectrum {
    /// The spectrum of some land; none where no rectangle of 64 × 64 cells is all land, or all is a plane.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn of(land: &Land, work: &Work<'_>) -> Result<Option<Self>, Cancelled> {
        let window = Rectangle::largest(land);
        work.check()?;
        let [cols, rows] = window.size();
        if cols.min(rows) < SHORTEST {
            return Ok(None);
        }
        let plane = Plane::through(land, &window);
        if plane.is_all(land, &window) {
            return Ok(None);
        }
        work.check()?;
        let power = Power::of(land, &window, &plane, work)?;
        let shortest = cols.min(rows) as f64;
        let rings = power.rings();
        let Some(line) = fit(&rings, 4.0, shortest / 4.0) else { return Ok(None) };
        let beta = |line: Line| -line.slope;
        Ok(Some(Self {
            window: [cols, rows],
            beta: beta(line),
            beta_r2: line.r2,
            hurst: (beta(line) - 2.0) / 2.0,
            beta_fine: fit(&rings, 3.0, 12.0).map(beta),
            beta_coarse: fit(&rings, 12.0, shortest / 4.0).map(beta),
            finest_power: fit(&rings, 4.0, 10.0).and_then(|line| finest(&rings, line)),
            stripes_east_west: power.stripes(&rings, &power.north),
            stripes_north_south: power.stripes(&rings, &power.east),
        }))
    }
}

/// A ring of wavenumbers, as logarithms of the wavenumber in cycles a cell and of the mean power.
type Ring = [f64; 2];

/// The line through the rings of wavelengths from `low` to `high` cells.
fn fit(rings: &[Ring], low: f64, high: f64) -> Option<Line> {
    let [from, to] = [high, low].map(|length| -libm::log(length));
    let inside: Vec<Ring> = rings.iter().copied().filter(|[k, _]| (from..=to).contains(k)).collect();
    if inside.len() < FEWEST_RINGS { None } else { Line::even(inside) }
}

/// The power of the finest rings over what a line says.
fn finest(rings: &[Ring], line: Line) -> Option<f64> {
    let finest = rings.iter().filter(|[k, _]| *k > -libm::log(2.6));
    let over: Vec<f64> = finest.map(|[k, p]| p - (line.intercept + line.slope * k)).collect();
    (!over.is_empty()).then(|| libm::exp(over.iter().sum::<f64>() / over.len() as f64))
}

/// What is kept of the power of all waves.
struct Power {
    size: [usize; 2],
    /// Number of wavenumbers and sum of their powers, of each ring.
    rings: [[f64; 2]; RINGS],
    /// Wavenumbers and powers of the waves that run nearly north to south.
    north: Vec<[f64; 2]>,
    /// Those of the waves that run nearly east to west.
    east: Vec<[f64; 2]>,
}

impl Power {
    fn of(land: &Land, window: &Rectangle, plane: &Plane, work: &Work<'_>) -> Result<Self, Cancelled> {
        let [cols, rows] = window.size();
        let mut planner = FftPlanner::<f64>::new();
        let along = planner.plan_fft_forward(cols);
        let waves = transform_rows(land, window, plane, &along, &work.stage(0.0, 0.5))?;
        let half = cols / 2 + 1;
        let down = planner.plan_fft_forward(rows);
        let strips: Vec<usize> = (0..half).step_by(STRIP).collect();
        let share = ((cols * rows) as f64).recip();
        let edges = edges(cols.min(rows));
        let done = AtomicUsize::new(0);
        let strip = |&first: &usize| -> Result<Strip, Cancelled> {
            let mut scratch = vec![Complex64::default(); down.get_inplace_scratch_len()];
            let mut column = vec![Complex64::default(); rows];
            let mut found = Strip::default();
            for u in first..(first + STRIP).min(half) {
                work.check()?;
                column.iter_mut().zip(waves.iter().skip(u).step_by(half)).for_each(|(c, w)| *c = *w);
                down.process_with_scratch(&mut column, &mut scratch);
                found.add([u, cols], &column, share, &edges);
            }
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            work.report(0.5 + 0.5 * done as f32 / strips.len() as f32);
            Ok(found)
        };
        let strips: Vec<Strip> = strips.par_iter().map(strip).collect::<Result<_, Cancelled>>()?;
        let all = strips.into_iter().fold(Strip::default(), Strip::and);
        Ok(Self { size: [cols, rows], rings: all.rings, north: all.north, east: all.east })
    }

    /// The rings that count.
    fn rings(&self) -> Vec<Ring> {
        let edges = edges(self.size[0].min(self.size[1]));
        let ring = |(edge, [count, sum]): (&[f64], [f64; 2])| {
            let middle = (edge[0] * edge[1]).sqrt();
            (count >= FEWEST && sum > 0.0).then(|| [libm::log(middle), libm::log(sum / count)])
        };
        edges.windows(2).zip(self.rings).filter_map(ring).collect()
    }

    /// The mean power of waves, each over the power of its ring.
    fn stripes(&self, rings: &[Ring], waves: &[[f64; 2]]) -> Option<f64> {
        let over = |[k, power]: &[f64; 2]| power / libm::exp(interpolated(rings, libm::log(*k)));
        (!waves.is_empty()).then(|| waves.iter().map(over).sum::<f64>() / waves.len() as f64)
    }
}

/// What one task finds in its columns of the transform.
#[derive(Default)]
struct Strip {
    rings: [[f64; 2]; RINGS],
    north: Vec<[f64; 2]>,
    east: Vec<[f64; 2]>,
}

impl Strip {
    /// Adds the waves of one column `u` of a transform of `cols` columns.
    fn add(&mut self, [u, cols]: [usize; 2], column: &[Complex64], share: f64, edges: &[f64]) {
        /// Wavenumbers whose waves are 3 to 16 cells long.
        const STRIPES: [f64; 2] = [1.0 / 16.0, 1.0 / 3.0];
        let are_stripes = |k: f64| k > STRIPES[0] && k < STRIPES[1];
        let rows = column.len();
        let x = u as f64 / cols as f64;
        for (v, wave) in column.iter().enumerate() {
            let signed = if v < rows.div_ceil(2) { v as f64 } else { v as f64 - rows as f64 };
            let y = signed / rows as f64;
            let (k, power) = (libm::hypot(y, x), wave.norm_sqr() * share);
            let ring = edges.partition_point(|edge| *edge <= k);
            if let Some([count, sum]) = ring.checked_sub(1).and_then(|ring| self.rings.get_mut(ring)) {
                *count += 1.0;
                *sum += power;
            }
            if u < 2 && are_stripes(y.abs()) {
                self.north.push([k, power]);
            }
            if (v < 2 || v + 1 == rows) && are_stripes(x) {
                self.east.push([k, power]);
            }
        }
    }

    fn and(mut self, mut next: Self) -> Self {
        self.rings.iter_mut().zip(next.rings).for_each(|(a, b)| *a = plus(*a, b));
        self.north.append(&mut next.north);
        self.east.append(&mut next.east);
        self
    }
}

/// The borders of the rings: of equal ratio, from two waves along the shorter side to two cells a wave.
fn edges(shortest: usize) -> Vec<f64> {
    let (low, high) = (2.0 / shortest as f64, 0.5);
    let step = libm::log(high / low) / RINGS as f64;
    let inner = (1..RINGS).map(|i| low * libm::exp(step * i as f64));
    std::iter::once(low).chain(inner).chain([high]).collect()
}

/// The value at `x` on the lines between some points of rising `x`; that of the nearest point beyond them.
fn interpolated(points: &[[f64; 2]], x: f64) -> f64 {
    match points.partition_point(|p| p[0] <= x) {
        0 => points.first().map_or(0.0, |p| p[1]),
        n if n == points.len() => points[n - 1][1],
        n => {
            let [[x0, y0], [x1, y1]] = [points[n - 1], points[n]];
            y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        }
    }
}

/// The Fourier transform of each row of a window, without its plane, under a Hann window; half of it, as the other half
/// is its mirror.
fn transform_rows(
    land: &Land,
    window: &Rectangle,
    plane: &Plane,
    along: &Arc<dyn Fft<f64>>,
    work: &Work<'_>,
) -> Result<Vec<Complex64>, Cancelled> {
    let [cols, rows] = window.size();
    let (across, deep) = (hann(cols), hann(rows));
    let mut waves = vec![Complex64::default(); (cols / 2 + 1) * rows];
    work.rows(&mut waves, cols / 2 + 1, 16, |j, out| {
        let mut scratch = vec![Complex64::default(); along.get_inplace_scratch_len()];
        let heights = &land.row(window.rows[0] + j)[window.cols[0]..window.cols[1]];
        let weighted = |(i, z): (usize, &f32)| (f64::from(*z) - plane.at(i, j)) * across[i] * deep[j];
        let mut row: Vec<Complex64> = heights.iter().enumerate().map(weighted).map(Complex64::from).collect();
        along.process_with_scratch(&mut row, &mut scratch);
        out.copy_from_slice(&row[..cols / 2 + 1]);
    })?;
    Ok(waves)
}

/// The symmetric Hann window.
fn hann(n: usize) -> Vec<f64> {
    let turn = std::f64::consts::TAU / n.saturating_sub(1).max(1) as f64;
    (0..n).map(|i| 0.5 - 0.5 * libm::cos(turn * i as f64)).collect()
}

/// A plane over a window.
struct Plane {
    middle: [f64; 2],
    mean: f64,
    rise: [f64; 2],
}

impl Plane {
    /// The plane with the least sum of squared differences. On a full rectangle the two axes are independent.
    fn through(land: &Land, window: &Rectangle) -> Self {
        let [cols, rows] = window.size();
        let middle = [cols, rows].map(|n| (n - 1) as f64 / 2.0);
        let of_row = |j: usize| {
            let row = &land.row(window.rows[0] + j)[window.cols[0]..window.cols[1]];
            row.iter().enumerate().fold([0.0; 2], |sums, (i, &z)| {
                let z = f64::from(z);
                plus(sums, [z, z * (i as f64 - middle[0])])
            })
        };
        let sums: Vec<[f64; 2]> = (0..rows).into_par_iter().map(of_row).collect();
        let [z, xz, yz] = sums
            .iter()
            .enumerate()
            .fold([0.0; 3], |sums, (j, &[z, xz])| plus(sums, [z, xz, z * (j as f64 - middle[1])]));
        // The sum of (i − middle)² over n numbers is n (n² − 1) / 12.
        let spread = |n: usize, times: usize| times as f64 * n as f64 * ((n * n) as f64 - 1.0) / 12.0;
        Self {
            middle,
            mean: z / (cols * rows) as f64,
            rise: [xz / spread(cols, rows), yz / spread(rows, cols)],
        }
    }

    /// Whether no height is farther from the plane than the rounding of heights is.
    fn is_all(&self, land: &Land, window: &Rectangle) -> bool {
        const ROUNDING: f64 = 1e-6;
        (0..window.size()[1]).into_par_iter().all(|j| {
            let row = &land.row(window.rows[0] + j)[window.cols[0]..window.cols[1]];
            row.iter().enumerate().all(|(i, &z)| {
                let z = f64::from(z);
                (z - self.at(i, j)).abs() <= ROUNDING * z.abs().max(self.mean.abs())
            })
        })
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.mean + self.rise[0] * (i as f64 - self.middle[0]) + self.rise[1] * (j as f64 - self.middle[1])
    }
}
