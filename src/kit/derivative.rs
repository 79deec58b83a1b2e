//! Derivatives of a field at a scale in metres.
//!
//! The gradient at a point is the difference of the field at `±s` along each axis over `2s`, with the scale `s` in
//! metres \[zevenbergen1987\]. Where `±s` falls between samples, the field is read by Catmull-Rom interpolation; where
//! `s` is a whole number of cells, it is the sample itself. So a slope says the same at every size of a build: on a
//! window whose cell is larger than the scale, [`footprint`] asks for a refined lattice, and [`Derivative`] reads it
//! at every k-th sample.
//!
//! No lattice finer than the base grid is asked for unless the window has one: the scale that takes effect is the
//! larger of the scale and the cell of the lattice that was read.

use super::math::{DEGREES, atan2, compass, within};
use super::shifted::Shifted;
use crate::cost::{Cost, Reach};
use crate::error::Result;
use crate::units::Metres;
use crate::value::{Field, Grid};

/// Steeper than any ground, and small enough that products of six such numbers are finite.
const STEEPEST: f32 = 1e6;

/// The window of the input that derivatives on a window need, at a scale of one's own or at the base cell.
pub fn footprint(window: &Grid, scale: Option<Metres>, base_cell: f64) -> Grid {
    let scale = scale.map_or(base_cell, |m| m.0);
    let fine = window.refined(refinement(window.cell(), scale, base_cell));
    let reach = taps(scale / fine.cell()).iter().map(|t| t.0).max();
    fine.grow_cells(reach.unwrap_or(0))
}

/// How many times finer than the window's lattice the one to read is: fine enough for the scale, yet no finer than
/// the base grid.
pub fn refinement(cell: f64, scale: f64, base_cell: f64) -> u32 {
    let wanted = (cell / scale - 1e-9).ceil();
    let allowed = (cell / base_cell + 1e-9).floor();
    wanted.min(allowed).max(1.0) as u32
}

/// The distances in cells and the weights of the samples that make up the value `ratio` cells away, with a ratio
/// below 1 raised to 1.
fn taps(ratio: f64) -> Vec<(i64, f32)> {
    let ratio = ratio.max(1.0);
    let whole = ratio.round();
    // A quotient such as 0.3 / 0.1 may miss the whole number it stands for.
    if (ratio - whole).abs() <= 1e-9 * whole {
        return vec![(whole as i64, 1.0)];
    }
    let n = ratio.floor();
    let f = ratio - n;
    let weights = [
        -0.5 * f + f * f - 0.5 * f * f * f,
        1.0 - 2.5 * f * f + 1.5 * f * f * f,
        0.5 * f + 2.0 * f * f - 1.5 * f * f * f,
        -0.5 * f * f + 0.5 * f * f * f,
    ];
    (-1..).map(|m| n as i64 + m).zip(weights.map(|w| w as f32)).collect()
}

/// Derivatives of a field on a window, row by row.
#[derive(Clone, Debug)]
pub struct Derivative<'a> {
    rows: Shifted<'a>,
    taps: Vec<(i64, f32)>,
    scale: f64,
}

/// First derivatives along a row, in metres per metre: positive where the field rises to the east, to the south.
#[derive(Clone, Debug)]
pub struct Gradient {
    /// Along x, to the east.
    pub x: Vec<f32>,
    /// Along y, to the south.
    pub y: Vec<f32>,
}

/// Second derivatives along a row, in 1/m.
#[derive(Clone, Debug)]
pub struct Second {
    /// Twice along x.
    pub xx: Vec<f32>,
    /// Along x and y.
    pub xy: Vec<f32>,
    /// Twice along y.
    pub yy: Vec<f32>,
}

impl<'a> Derivative<'a> {
    /// Derivatives at a scale in metres of the field of input `port`, which covers [`footprint`].
    ///
    /// # Errors
    /// When the field stands on a lattice that does not hold the window's samples.
    pub fn new(port: &'static str, field: &'a Field, window: &Grid, scale: f64) -> Result<Self> {
        let rows = Shifted::new(port, field, window)?;
        Ok(Self { rows, taps: taps(scale / rows.cell()), scale: scale.max(rows.cell()) })
    }

    /// The scale that took effect, in metres.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The gradient along the window's `j`-th row, each component within ±1e6.
    pub fn gradient(&self, j: usize) -> Gradient {
        let per_metre = (0.5 / self.scale) as f32;
        let along = |axis: [i64; 2]| {
            let mut sum = vec![0.0f32; self.rows.cols()];
            for &(d, weight) in &self.taps {
                let ahead = self.rows.line(j, [d * axis[0], d * axis[1]]);
                let behind = self.rows.line(j, [-d * axis[0], -d * axis[1]]);
                for ((s, a), b) in sum.iter_mut().zip(&*ahead).zip(&*behind) {
                    *s += weight * (a - b);
                }
            }
            bounded(sum, per_metre)
        };
        Gradient { x: along([1, 0]), y: along([0, 1]) }
    }

    /// The second derivatives along the window's `j`-th row, each within ±1e6.
    pub fn second(&self, j: usize) -> Second {
        let per_area = (1.0 / (self.scale * self.scale)) as f32;
        let here = self.rows.line(j, [0, 0]);
        let twice = |axis: [i64; 2]| {
            let mut sum = vec![0.0f32; self.rows.cols()];
            for &(d, weight) in &self.taps {
                let ahead = self.rows.line(j, [d * axis[0], d * axis[1]]);
                let behind = self.rows.line(j, [-d * axis[0], -d * axis[1]]);
                for (((s, a), b), h) in sum.iter_mut().zip(&*ahead).zip(&*behind).zip(&*here) {
                    *s += weight * ((a - h) + (b - h));
                }
            }
            bounded(sum, per_area)
        };
        Second { xx: twice([1, 0]), xy: self.mixed(j), yy: twice([0, 1]) }
    }

    fn mixed(&self, j: usize) -> Vec<f32> {
        let mut sum = vec![0.0f32; self.rows.cols()];
        for &(v, across) in &self.taps {
            for &(u, along) in &self.taps {
                let weight = across * along;
                let [se, sw] = [u, -u].map(|u| self.rows.line(j, [u, v]));
                let [ne, nw] = [u, -u].map(|u| self.rows.line(j, [u, -v]));
                let corners = se.iter().zip(&*sw).zip(ne.iter().zip(&*nw));
                for (s, ((se, sw), (ne, nw))) in sum.iter_mut().zip(corners) {
                    *s += weight * ((se - sw) - (ne - nw));
                }
            }
        }
        bounded(sum, (0.25 / (self.scale * self.scale)) as f32)
    }
}

/// Scales, and keeps even the differences of huge heights finite.
fn bounded(mut values: Vec<f32>, factor: f32) -> Vec<f32> {
    for v in &mut values {
        *v = within(*v * factor, STEEPEST);
    }
    values
}

/// The inclination of a gradient in degrees, 0 flat, below 90.
#[inline]
pub fn slope(x: f32, y: f32) -> f32 {
    atan2((x * x + y * y).sqrt(), 1.0) * DEGREES
}

/// The compass direction in which a gradient falls, in degrees: 0 north, 90 east; 0 where it is flat.
#[inline]
pub fn aspect(x: f32, y: f32) -> f32 {
    compass(-x, y)
}

/// The reach of a kind that takes derivatives at a scale; the base cell counts as some cells, [`footprint`] says
/// how many.
pub fn reach(scale: Option<Metres>) -> Reach {
    Reach::local(scale.map_or(0.0, |m| m.0)).plus_cells(2)
}

/// The cost of a kind that takes derivatives: nanoseconds a sample, and rows of numbers that each thread holds.
pub fn cost(grid: &Grid, nanoseconds: f64, lines: u64) -> Cost {
    let bytes = 4 * lines * grid.cols as u64 * rayon::current_num_threads() as u64;
    Cost { bytes, ..Cost::per_sample(grid, nanoseconds) }
}
