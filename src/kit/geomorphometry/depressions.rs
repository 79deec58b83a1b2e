//! Pits, and what filling them raises.

use rayon::prelude::*;
use serde::Serialize;

use super::Land;
use super::sums::{percentiles, sums};
use crate::work::{Cancelled, Work};

/// Depth, in metres, from which a cell counts as filled.
const SHALLOWEST: f64 = 1e-3;

/// Where water cannot run off: land that was not shaped by water has much of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Depressions {
    /// Cells lower than all eight neighbours, for each 1000 cells of land.
    pub pits_per_1000: f64,
    /// Share of the land that filling raises by more than 1 mm.
    pub filled: f64,
    /// Share of the land that has no lower neighbour after filling: the same and all that is level.
    pub filled_or_level: f64,
    /// Mean depth of what is filled, in metres; 0 where nothing is.
    pub mean_depth: f64,
    /// 99th percentile of that depth, in metres.
    pub p99_depth: f64,
    /// Mean depth over all land, as a share of the relief; 0 of a plain.
    pub volume: f64,
}

/// Which cells have no lower neighbour once depressions are filled, or are filled themselves.
pub(super) struct Filled<'a> {
    pub(super) land: &'a Land,
    /// Heights with depressions filled, in metres.
    pub(super) level: &'a [f32],
    /// Whether water crosses a cell only because it was filled, or over level ground.
    pub(super) is_level: Vec<bool>,
}

impl<'a> Filled<'a> {
    pub(super) fn new(land: &'a Land, level: &'a [f32], work: &Work<'_>) -> Result<Self, Cancelled> {
        let cols = land.cols();
        let mut is_level = vec![false; level.len()];
        work.rows(&mut is_level, cols, 16, |j, out| {
            for (i, is_level) in out.iter_mut().enumerate().filter(|(i, _)| land.is_inland(*i, j)) {
                let here = level[j * cols + i];
                *is_level = !around(level, cols, i, j).any(|z| z < here);
            }
        })?;
        Ok(Self { land, level, is_level })
    }

    /// Depth of a cell below the level it is filled to, in metres.
    pub(super) fn depth(&self, cell: usize) -> f64 {
        f64::from(self.level[cell]) - f64::from(self.land.heights()[cell])
    }

    /// Whether a cell is filled.
    pub(super) fn is_filled(&self, cell: usize) -> bool {
        self.depth(cell) > SHALLOWEST
    }

    /// The figures of the whole.
    pub(super) fn figures(&self, relief: f64, work: &Work<'_>) -> Result<Depressions, Cancelled> {
        let land = self.land;
        let count = land.count() as f64;
        let filled = (0..self.level.len()).filter(|cell| self.is_filled(*cell));
        let mut depths: Vec<f32> = filled.map(|cell| self.depth(cell) as f32).collect();
        work.check()?;
        let [volume] = sums(&depths, |depth| [f64::from(*depth)]);
        let level = self.is_level.par_iter().filter(|is| **is).count() as f64;
        work.check()?;
        let pits: usize = (0..land.rows()).into_par_iter().map(|j| pits(land, j)).sum();
        Ok(Depressions {
            pits_per_1000: 1000.0 * pits as f64 / count,
            filled: depths.len() as f64 / count,
            filled_or_level: level / count,
            mean_depth: if depths.is_empty() { 0.0 } else { volume / depths.len() as f64 },
            p99_depth: percentiles(&mut depths, [0.99]).map_or(0.0, |[depth]| depth),
            volume: if relief > 0.0 { volume / (count * relief) } else { 0.0 },
        })
    }
}

/// Number of pits in a row.
fn pits(land: &Land, j: usize) -> usize {
    let heights = land.heights();
    let is_pit = |i: &usize| {
        land.is_inland(*i, j) && around(heights, land.cols(), *i, j).all(|z| z > heights[j * land.cols() + i])
    };
    (0..land.cols()).filter(is_pit).count()
}

/// The eight neighbours of a cell that has all of them.
fn around(heights: &[f32], cols: usize, i: usize, j: usize) -> impl Iterator<Item = f32> {
    let at = j * cols + i;
    let all =
        [at - cols - 1, at - cols, at - cols + 1, at - 1, at + 1, at + cols - 1, at + cols, at + cols + 1];
    all.into_iter().map(|k| heights[k])
}
