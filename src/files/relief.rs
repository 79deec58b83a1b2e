//! A height file as a surface: voids closed, a spline through its samples, a value at any place.

use super::error::ReadError;
use super::height::Limits;
use super::input::{Companion, Input};
use super::place::Placement;
use super::placing::{Placed, SNAP};
use super::reading::Reading;
use super::voids::fill_voids;
use crate::kit::spline::{Spline, Taps};
use crate::units::Metres;
use crate::work::Work;

/// How voids are closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closing {
    /// With a membrane from their border inwards; see [`fill_voids`].
    Smooth,
    /// With one height, in the numbers of the file.
    Level(f32),
}

/// How a surface is made of a file.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// What lies beside it.
    pub companions: &'a [Companion<'a>],
    /// What a person says of it.
    pub reading: &'a Reading,
    /// How voids are closed.
    pub closing: Closing,
    /// Whether a spline goes through the samples, or planes.
    pub cubic: bool,
}

impl Request<'_> {
    /// What tells it from another request for the same file.
    pub fn identity(&self) -> Vec<u8> {
        let level = match self.closing {
            Closing::Smooth => None,
            Closing::Level(height) => Some(height.to_bits()),
        };
        let beside: Vec<_> = self.companions.iter().map(|c| (c.name, blake3::hash(c.bytes))).collect();
        format!("{beside:?} {:?} {level:?} {}", self.reading, self.cubic).into_bytes()
    }
}

/// The heights of a file as a surface.
#[derive(Debug)]
pub struct Relief {
    /// Samples in a row.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Where the samples lie.
    pub placement: Placement,
    /// Whether the file says what its numbers are in metres.
    pub metres: bool,
    /// What a person should know about the reading.
    pub notes: Vec<String>,
    heights: Vec<f32>,
    /// Which samples were void; empty when none was.
    voids: Vec<bool>,
    spline: Option<Spline>,
}

/// Columns of a window that stands upright on the file, prepared once for all rows.
#[derive(Debug)]
pub struct Columns {
    positions: Vec<f64>,
    taps: Taps,
    /// Columns that stand on a column of the file, and on which.
    exact: Vec<(usize, usize)>,
}

impl Relief {
    /// Reads a file and prepares its surface.
    ///
    /// # Errors
    /// When the file cannot be read, or holds nothing but voids.
    pub fn new(
        request: &Request<'_>,
        bytes: &[u8],
        limits: &Limits,
        work: Work<'_>,
    ) -> Result<Self, ReadError> {
        let Request { name, companions, reading, closing, cubic } = *request;
        let file = Input { name, bytes: &bytes, companions, reading, limits, work }.read()?;
        let (cols, rows, mut heights) = (file.cols, file.rows, file.data);
        let any = heights.iter().any(|v| v.is_nan());
        let voids = if any { heights.iter().map(|v| v.is_nan()).collect() } else { Vec::new() };
        match closing {
            Closing::Level(height) => {
                heights.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = height);
            }
            Closing::Smooth => {
                let all = || super::Fault::Damaged("nothing but voids".into()).of(name);
                fill_voids(cols, rows, &mut heights).ok_or_else(all)?;
            }
        }
        let spline = cubic.then(|| Spline::fit(cols, rows, &heights));
        let (metres, notes) = (file.metres, file.origin.notes);
        Ok(Self { cols, rows, placement: file.placement, metres, notes, heights, voids, spline })
    }

    /// Bytes that reading a file of a size takes at the peak: samples, marks of voids, coefficients, and what the
    /// readers hold beside them.
    pub fn bytes(cols: u64, rows: u64, cubic: bool) -> u64 {
        cols.saturating_mul(rows).saturating_mul(if cubic { 17 } else { 13 })
    }

    /// Bytes that the surface holds.
    pub fn held_bytes(&self) -> u64 {
        let spline = if self.spline.is_some() { size_of_val(&self.heights[..]) } else { 0 };
        (size_of_val(&self.heights[..]) + self.voids.len() + spline) as u64
    }

    /// Whether some sample was void.
    pub fn has_voids(&self) -> bool {
        !self.voids.is_empty()
    }

    /// Whether the sample nearest to a position, in steps from the north-west one, was void.
    pub fn is_void(&self, u: f64, v: f64) -> bool {
        let near = |p: f64, n: usize| p.round().clamp(0.0, (n - 1) as f64) as usize;
        self.has_voids()
            && self.placed(None).contains(u, v)
            && self.voids[near(v, self.rows) * self.cols + near(u, self.cols)]
    }

    /// What is to be placed on a terrain, with a distance between its samples by a person's word.
    pub fn placed(&self, cell: Option<Metres>) -> Placed {
        Placed { cols: self.cols, rows: self.rows, placement: self.placement, cell }
    }

    /// The height at a position in steps from the north-west sample; beyond the border its value continues.
    pub fn height(&self, u: f64, v: f64) -> f32 {
        let (u, v) = (held(u, self.cols), held(v, self.rows));
        if let (Some(i), Some(j)) = (whole(u), whole(v)) {
            return self.heights[j * self.cols + i];
        }
        match &self.spline {
            Some(spline) => spline.value(u, v),
            None => {
                let ((j0, j1), t) = ends(v, self.rows);
                let line = |j: usize| lerp(&self.heights[j * self.cols..][..self.cols], u);
                line(j0) + (line(j1) - line(j0)) * t
            }
        }
    }

    /// Prepares the columns of a window at positions in steps from the westernmost sample.
    pub fn columns(&self, positions: impl Iterator<Item = f64>) -> Columns {
        let positions: Vec<f64> = positions.map(|p| held(p, self.cols)).collect();
        let exact = positions.iter().enumerate().filter_map(|(k, p)| Some((k, whole(*p)?))).collect();
        let taps = self.spline.as_ref().map_or_else(Taps::default, |s| s.taps(positions.iter().copied()));
        Columns { positions, taps, exact }
    }

    /// The heights of some columns at one position down the rows, as [`height`](Self::height) gives them up to
    /// rounding.
    pub fn row(&self, columns: &Columns, v: f64, out: &mut [f32]) {
        let v = held(v, self.rows);
        match &self.spline {
            Some(spline) => spline.row(v, &columns.taps, out),
            None => {
                let ((j0, j1), t) = ends(v, self.rows);
                let [upper, lower] = [j0, j1].map(|j| &self.heights[j * self.cols..][..self.cols]);
                for (o, u) in out.iter_mut().zip(&columns.positions) {
                    let (a, b) = (lerp(upper, *u), lerp(lower, *u));
                    *o = a + (b - a) * t;
                }
            }
        }
        if let Some(j) = whole(v) {
            for &(k, i) in &columns.exact {
                out[k] = self.heights[j * self.cols + i];
            }
        }
    }
}

/// A position held between the first and the last of `n` samples, and put onto a sample that is all but there.
fn held(p: f64, n: usize) -> f64 {
    let p = if p.is_finite() { p.clamp(0.0, (n - 1) as f64) } else { 0.0 };
    if (p - p.round()).abs() <= SNAP { p.round() } else { p }
}

/// The sample that a position stands on.
fn whole(p: f64) -> Option<usize> {
    (p == p.floor()).then_some(p as usize)
}

/// The samples around a held position, and the share of the second.
fn ends(p: f64, n: usize) -> ((usize, usize), f32) {
    let i = p.floor() as usize;
    ((i, (i + 1).min(n - 1)), (p - p.floor()) as f32)
}

fn lerp(line: &[f32], u: f64) -> f32 {
    let ((i, k), t) = ends(u, line.len());
    line[i] + (line[k] - line[i]) * t
}
