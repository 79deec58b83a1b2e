//! The parts of curves that touch some rows of a grid, no more of them at once than memory is stated for.

use std::sync::Arc;

use rayon::prelude::*;

use super::TOLERANCE;
use super::ribbon::{Ribbon, Rim};
use super::shape::Shape;
use crate::kit::curves::flatten::{corners, flatten};
use crate::value::curves::CurveError;
use crate::value::curves::bezier::Point;
use crate::value::{Curve, Curves};

/// Most corners of all polylines together, so that the work ends.
const MAX_CORNERS: usize = 1 << 20;
/// Most corners of the polyline of a curve: it is in memory as a whole, 9 MiB with what is made of it.
const CURVE_CORNERS: usize = 1 << 16;
/// Corners of curves that become parts side by side.
const BLOCK_CORNERS: usize = 1 << 12;
/// Most parts at once, 700 bytes each.
pub(super) const MAX_PARTS: usize = 1 << 14;

/// The part of the plane that is filled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) min: Point,
    pub(super) max: Point,
}

impl Window {
    /// Whether a shape may touch it.
    pub(super) fn meets(&self, shape: &Shape) -> bool {
        (0..2).all(|k| {
            shape.from[k] + shape.max[k] >= self.min[k] && shape.from[k] + shape.min[k] <= self.max[k]
        })
    }
}

/// Curves in order, cut where their polylines together have enough corners.
///
/// # Errors
/// When a curve, or all together, have too many corners.
pub(super) fn blocks<'a>(
    curves: &'a Curves,
    tolerance: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<&'a [Arc<Curve>]>, CurveError> {
    let count = |c: &Arc<Curve>| {
        if stop() {
            return Err(CurveError::Cancelled);
        }
        corners(c, tolerance, CURVE_CORNERS)
            .ok_or_else(|| too_many("corners of a curve on this grid", CURVE_CORNERS, CURVE_CORNERS + 1))
    };
    let all = curves.shared();
    let counts: Vec<_> = all.par_iter().with_min_len(4).map(count).collect::<Result<_, _>>()?;
    let total: usize = counts.iter().sum();
    if total > MAX_CORNERS {
        return Err(too_many("corners of curves on this grid", MAX_CORNERS, total));
    }
    let (mut blocks, mut start, mut sum) = (Vec::new(), 0, 0);
    for (i, n) in counts.into_iter().enumerate() {
        if sum + n > BLOCK_CORNERS && i > start {
            blocks.push(&all[start..i]);
            (start, sum) = (i, 0);
        }
        sum += n;
    }
    blocks.push(&all[start..]);
    Ok(blocks)
}

fn too_many(what: &'static str, most: usize, found: usize) -> CurveError {
    CurveError::TooMany { what, most: most as u64, found: found as u64 }
}

/// Curves flattened, with the ground beside them and their envelopes, as far as a window sees them.
#[derive(Debug, Default)]
pub(super) struct Stock {
    pub(super) curves: Vec<(Ribbon, Vec<Rim>)>,
}

impl Stock {
    /// The parts that a window sees.
    ///
    /// # Errors
    /// When there are too many, or the work was asked to stop.
    pub(super) fn new(
        blocks: &[&[Arc<Curve>]],
        cell: f64,
        window: &Window,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, CurveError> {
        let mut stock = Self::default();
        let mut parts = 0;
        for block in blocks {
            if stop() {
                return Err(CurveError::Cancelled);
            }
            let one = |c: &Arc<Curve>| {
                let line = flatten(c, TOLERANCE * cell, CURVE_CORNERS)?;
                Some((Ribbon::new(c, &line, cell, window), Rim::all(c, &line, cell, window)))
            };
            let made: Vec<_> = block.par_iter().with_min_len(4).filter_map(one).collect();
            for (ribbon, rims) in made {
                parts += ribbon.parts.len() + rims.len();
                if parts > MAX_PARTS {
                    return Err(too_many("parts of curves beside 32 rows of the grid", MAX_PARTS, parts));
                }
                if ribbon.parts.len() + rims.len() > 0 {
                    stock.curves.push((ribbon, rims));
                }
            }
        }
        Ok(stock)
    }
}
