//! From feature curves to the constraints that diffusion starts from \[hnaidi2010, 4.1; weiss2015, V-D\].
//!
//! # Theory
//! The curve becomes a polyline. On both sides of each segment lies a quadrangle: the plateau up to `r` from the
//! curve, where h, A and R are constant across, then the slope up to `r + a` (or `r + b`), where the norm of the
//! gradient is `tan θ · (1 − (d − r) / a)` at distance `d` and its direction `n` points away from the curve. A curve
//! with slopes and no elevation gives `(−n, −G)`: the same gradient, but heights flow towards the curve. Where strict
//! values of several curves, or of several passages of one, meet, they are averaged; what holds where slopes of different
//! curves meet is told in `meeting`.
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
//! - A cell right beside a curve, on its slope, would take its height from neighbours across the curve. Where there is no
//!   slope on that side these are free ground, which may be far lower right beside a crest, in another way in each row.
//!   There the cell has the height of the profile.
//!
//! # Differs from the paper
//! - Where slopes of different curves meet the paper leaves the cell open; here it has the height between theirs.
//! - The paper paints quadrangles over each other. Here a cell takes the gradient of the nearest foot among all
//!   quadrangles of a curve that hold it, so that a strip that folds at a sharp bend shows a clean crease; where two
//!   feet are equally near, what both say along their common direction.
//! - Outer sides of bends have round joins: no gaps. The ends of a curve are flat, as in the paper.
//! - A plateau thinner than a cell marks a connected line of cells (every column's, or every row's nearest cell), and
//!   so does a curve that has noise and no elevation.
//! - A cell on a curve without elevation has no side and so no gradient: it is left open.
//! - A slope is trusted less towards its outer side, where it has a height to start from, and around the ends of its
//!   curve the less the farther out: the gradient is the paper's, but the land beside may pull at it, so that no line
//!   shows where the strip stops.
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
//! cell size. Memory is bounded ([`BESIDE`]): where the parts of all rows are too many at once, rows are filled in turn.

mod cell;
mod cost;
mod meeting;
mod ribbon;
mod shape;
mod stock;
mod tile;

use std::sync::Arc;

use rayon::prelude::*;

pub use self::cost::seconds;
use self::stock::Stock;
use self::tile::{Band, Bins, Tiles};
use crate::value::curves::CurveError;
use crate::value::{Constraints, Curve, Curves, Grid, Planes};

/// How far the polyline may lie from the curve, in cells.
const TOLERANCE: f64 = 0.05;
/// What counts as touching, and as equally near, in cells: far above rounding, far below what shows.
const SLACK: f64 = 1e-6;
/// Most bytes that rasterising takes beside its planes, whatever the curves: parts, their tiles, a block of polylines
/// while it becomes parts, and two desks a thread.
pub const BESIDE: u64 = 64 << 20;

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
    let any = |f: fn(&Curve) -> bool| curves.iter().any(f);
    let n = grid.len();
    let sloped = |c: &&Curve| c.tracks().slope.is_some() && c.tracks().elevation.is_some();
    let meet = curves.iter().filter(sloped).nth(1).is_some()
        || any(|c| c.tracks().slope.is_some() && ribbon::has_edge(c));
    let mut planes = Planes {
        marks: vec![0; n],
        height: any(|c| c.tracks().elevation.is_some()).then(|| vec![0.0; n]),
        lean: any(ribbon::has_edge).then(|| vec![[0.0; 2]; n]),
        direction: any(|c| c.tracks().slope.is_some()).then(|| vec![[0.0; 2]; n]),
        steepness: any(|c| c.tracks().slope.is_some()).then(|| vec![0.0; n]),
        trust: any(|c| c.tracks().slope.is_some()).then(|| vec![0.0; n]),
        ground: meet.then(|| vec![0.0; n]),
        noise: any(|c| c.tracks().noise.is_some()).then(|| vec![[0.0; 2]; n]),
        envelope: any(|c| c.tracks().envelope.is_some()).then(|| vec![0.0; n]),
    };
    if n > 0 {
        let blocks = stock::blocks(curves, TOLERANCE * cell, stop)?;
        let (xs, ys) = (grid.xs(), (0..grid.rows).map(|j| grid.y(j)).collect::<Vec<_>>());
        let job = Job { blocks, grid, xs: &xs, ys: &ys, options, stop };
        job.fill(&mut Band::split(&mut planes, grid))?;
    }
    Ok(Constraints::new(*grid, planes))
}

/// All that filling bands reads.
struct Job<'a> {
    blocks: Vec<&'a [Arc<Curve>]>,
    grid: &'a Grid,
    xs: &'a [f64],
    ys: &'a [f64],
    options: &'a Options,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl Job<'_> {
    /// Fills bands; in two halves, one after the other, where the parts that touch them are too many at once. Each tile
    /// sees the same parts in the same order, so that the halves change no bit.
    fn fill(&self, bands: &mut [Band<'_>]) -> Result<(), CurveError> {
        match self.draw(bands) {
            Err(CurveError::TooMany { .. }) if bands.len() > 1 => {
                let (first, second) = bands.split_at_mut(bands.len() / 2);
                self.fill(first)?;
                self.fill(second)
            }
            done => done,
        }
    }

    /// Fills bands at once; nothing is drawn where it fails but by being stopped.
    fn draw(&self, bands: &mut [Band<'_>]) -> Result<(), CurveError> {
        let Self { grid, xs, ys, options, .. } = *self;
        let tiles = Tiles::of(bands, grid);
        let stock = Stock::new(&self.blocks, grid.cell(), &tiles.window(grid), self.stop)?;
        let ready = &stock.curves;
        let strips = ready.iter().map(|(r, _)| r.parts.iter().map(|p| &p.shape));
        let strips = Bins::new(grid, &tiles, strips, self.stop)?;
        let rims = Bins::new(grid, &tiles, ready.iter().map(|(_, r)| r.iter().map(|r| &r.shape)), self.stop)?;
        let per_cell = 1.0 / grid.cell();
        let stop = self.stop;
        let scene =
            tile::Scene { grid, per_cell, xs, ys, ready, strips: &strips, rims: &rims, options, stop };
        bands.par_iter_mut().try_for_each(|band| scene.band(band))
    }
}
