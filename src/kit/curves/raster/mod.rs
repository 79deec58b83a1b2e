//! From feature curves to the constraints that diffusion starts from \[hnaidi2010, 4.1; weiss2015, V-D\].
//!
//! # Theory
//! The curve becomes a polyline. On both sides of each segment lies a quadrangle: the plateau up to `r` from the
//! curve, where h, A and R are constant across, then the slope up to `r + a` (or `r + b`), where the norm of the
//! gradient is `tan θ · (1 − (d − r) / a)` at distance `d` and its direction `n` points away from the curve. A curve
//! with slopes and no elevation gives `(−n, −G)`: the same gradient, but heights flow towards the curve. Where strict
//! values of several curves, or of several passages of one, meet, they are averaged; where the gradients of different
//! curves meet, the cell is left open.
//!
//! # Between samples
//! A curve does not know the grid, and a cell that is on a wall or not would make a staircase of every wall. So the
//! raster says what holds at the sample itself:
//! - The steepness of a cell is the mean over the step from the neighbours that heights flow from, `|n_x|` and `|n_y|`
//!   cells away across the slope, part of which may be plateau: summed up over the steps it is the profile.
//! - A cell that a line thinner than a cell marks beside it has the height of the profile there.
//! - Where a plateau ends on free ground, each cell within a step of the edge leans on the neighbours beyond: it lies on
//!   the straight way between the edge, a gap g back, and them, a step ahead: `(1 − λ) h + λ H`, `λ = g / (g + step)`.
//!   So the two sides of a line are solved apart, and meet on it. The weights are positive: no value leaves the range.
//!
//! # Differs from the paper
//! - The paper paints quadrangles over each other. Here a cell takes the gradient of the nearest foot among all
//!   quadrangles of a curve that hold it, so that a strip that folds at a sharp bend shows a clean crease; where two
//!   feet are equally near, what both say along their common direction.
//! - Outer sides of bends have round joins: no gaps. The ends of a curve are flat, as in the paper.
//! - A plateau thinner than a cell marks a connected line of cells (every column's, or every row's nearest cell), and
//!   so does a curve that has noise and no elevation.
//! - A cell on a curve without elevation has no side and so no gradient: it is left open.
//! - On the low side of a cliff without elevation heights flow away from the curve, not towards it: one wall from the
//!   high ground down, where the paper's two halves would meet in a step on the curve.
//! - Weiss's envelope is 1 inside and 0 outside; here it may fade over a share of its width (`feather`). As in his
//!   program, widths count from the outer edge of the slopes, and the strip goes beyond the ends by their mean, here
//!   as a half ellipse.
//!
//! # Practice
//! Work is binned into tiles of 32 × 32 cells; a tile goes through the parts of each curve in order, touches only the
//! cells they cover, and sums curve by curve. So the result is the same to the bit for any number of threads and for
//! any window of the lattice. The polyline stays within 1/20 of a cell of the curve, so regions converge with the
//! cell size.

mod cell;
mod ribbon;
mod shape;
mod tile;

use rayon::prelude::*;

use self::ribbon::{Ribbon, Rim};
use self::tile::{Band, Bins};
use super::flatten::flatten;
use crate::value::curves::CurveError;
use crate::value::{Constraints, Curves, Grid, Planes};

/// How far the polyline may lie from the curve, in cells.
const TOLERANCE: f64 = 0.05;
/// What counts as touching, and as equally near, in cells: far above rounding, far below what shows.
const SLACK: f64 = 1e-6;
/// Most corners of all polylines together.
pub const MAX_CORNERS: usize = 1 << 20;
/// Most parts in all tiles together.
pub const MAX_BINNED: usize = 1 << 25;

/// How curves are rasterised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Share of the envelope's width over which its weight fades, from 0 to 1; 0 is Weiss's hard edge.
    pub feather: f64,
}

/// The constraints that some curves put on the samples of a grid.
///
/// `stop` is asked now and then whether to give up.
///
/// # Errors
/// When there is too much to do, or the work was asked to stop.
pub fn rasterise(
    curves: &Curves,
    grid: &Grid,
    options: &Options,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Constraints, CurveError> {
    if !(0.0..=1.0).contains(&options.feather) {
        let message = format!("must be a number from 0 to 1, got {}", options.feather);
        return Err(CurveError::Parameter { name: "feather", message });
    }
    let cell = grid.cell();
    if !(cell.is_finite() && cell > 0.0) {
        return Err(CurveError::Parameter { name: "cell", message: format!("must be above 0, got {cell}") });
    }
    let ready = prepare(curves, cell, stop)?;
    let strips = Bins::new(grid, ready.iter().map(|(r, _)| r.parts.iter().map(|p| &p.shape)))?;
    let rims = Bins::new(grid, ready.iter().map(|(_, r)| r.iter().map(|r| &r.shape)))?;
    let any = |f: fn(&Ribbon) -> bool| ready.iter().any(|(r, _)| f(r));
    let n = grid.len();
    let mut planes = Planes {
        marks: vec![0; n],
        height: any(|r| r.has_height).then(|| vec![0.0; n]),
        lean: any(|r| r.has_edge).then(|| vec![[0.0; 2]; n]),
        direction: any(|r| r.has_slope).then(|| vec![[0.0; 2]; n]),
        steepness: any(|r| r.has_slope).then(|| vec![0.0; n]),
        noise: any(|r| r.has_noise).then(|| vec![[0.0; 2]; n]),
        envelope: ready.iter().any(|(_, r)| !r.is_empty()).then(|| vec![0.0; n]),
    };
    if n > 0 {
        let xs = grid.xs();
        let ys: Vec<f64> = (0..grid.rows).map(|j| grid.y(j)).collect();
        let scene = tile::Scene {
            grid,
            per_cell: 1.0 / cell,
            xs: &xs,
            ys: &ys,
            ready: &ready,
            strips: &strips,
            rims: &rims,
            options,
        };
        let done = Band::split(&mut planes, grid).into_par_iter().try_for_each(|mut band| {
            if stop() {
                return None;
            }
            scene.band(&mut band);
            Some(())
        });
        done.ok_or(CurveError::Cancelled)?;
    }
    Ok(Constraints::new(*grid, planes))
}

/// Every curve flattened, with the ground beside it and its envelope.
fn prepare(
    curves: &Curves,
    cell: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<(Ribbon, Vec<Rim>)>, CurveError> {
    let too_many = || CurveError::TooMany {
        what: "corners of curves",
        most: MAX_CORNERS as u64,
        found: MAX_CORNERS as u64 + 1,
    };
    let mut ready = Vec::with_capacity(curves.len());
    let mut corners = 0;
    // In blocks, so that too many are noticed before all of them are in memory.
    for block in curves.shared().chunks(256) {
        if stop() {
            return Err(CurveError::Cancelled);
        }
        let lines: Vec<_> =
            block.par_iter().with_min_len(4).map(|c| flatten(c, TOLERANCE * cell, MAX_CORNERS)).collect();
        let lines = lines.into_iter().collect::<Option<Vec<_>>>().ok_or_else(too_many)?;
        corners += lines.iter().map(Vec::len).sum::<usize>();
        if corners > MAX_CORNERS {
            return Err(too_many());
        }
        let both = block.par_iter().zip(lines).with_min_len(4);
        ready.par_extend(both.map(|(c, line)| (Ribbon::new(c, &line, cell), Rim::all(c, &line, cell))));
    }
    Ok(ready)
}

/// What rasterising costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Bytes of planes and of what lies beside them, at most.
    pub bytes: u64,
    /// Cells covered, counted once for each curve, at most about.
    pub cells: f64,
}

/// An estimate of what rasterising costs, made without doing it.
pub fn estimate(curves: &Curves, grid: &Grid) -> Work {
    let cell = grid.cell();
    let (mut cells, mut corners) = (0.0, 0.0);
    for c in curves.iter() {
        let t = c.tracks();
        let widest2 = |t: &Option<_>, k: usize| -> f64 {
            let keys = Option::iter(t).flat_map(crate::value::curves::Track::<2>::keys);
            keys.map(|(_, v)| v[k]).fold(0.0, f64::max)
        };
        let slope = t.slope.iter().flat_map(|t| t.keys()).map(|(_, v)| v[0] + v[1]).fold(0.0, f64::max);
        let strip = 2.0 * widest2(&t.elevation, 1) + slope + 2.0 * cell;
        let rim = if t.envelope.is_some() {
            strip + widest2(&t.envelope, 0) + widest2(&t.envelope, 1)
        } else {
            0.0
        };
        let whole = grid.len() as f64;
        let covered = |width: f64| (width * (c.length() + width) / (cell * cell)).min(whole);
        cells += covered(strip) + covered(rim);
        corners += (12.0 * c.pieces() as f64 + c.length() / cell).min(MAX_CORNERS as f64);
    }
    // 37 bytes a cell of planes; about 1.5 kB a corner with its parts, sector and rim; the bins.
    let bytes = 37.0 * grid.len() as f64 + 2200.0 * corners.min(MAX_CORNERS as f64) + cells / 8.0;
    Work { bytes: bytes as u64 + (1 << 20), cells }
}
