//! Water that goes to several neighbours at once: D-infinity and MFD.

use super::accumulate::donors;
use super::descent::band;
use super::flats::LOOK;
use super::neighbor::{EAST, LENGTH, NONE, SOUTH, unit};
use super::surface::{Surface, solid};
use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// How the water of a cell is divided over its lower neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// D-infinity \[tarboton1997\]: along the steepest of the eight triangular facets around the cell, over the two
    /// neighbours on either side of that direction, by its angle to them.
    Infinity,
    /// MFD: over all lower neighbours, by a power of their slope \[freeman1991, holmgren1994\].
    Slopes {
        /// The power: 1.1 is Freeman's; the higher, the more goes the steepest way.
        exponent: f64,
    },
}

/// How the water of each cell is divided over its neighbours.
///
/// The rule holds on dry ground that has a lower neighbour, on the surface with its depressions filled. Elsewhere, in lakes
/// and on flats, all water takes the way of the tree. So heights never rise along a way, and ways that stay level are those
/// of the tree: no way comes back to where it began.
#[derive(Clone, Debug)]
pub struct Spread<'a> {
    surface: Surface<'a>,
    tree: &'a Tree,
    filled: &'a [f32],
    rule: Rule,
}

impl<'a> Spread<'a> {
    /// The division of water over a surface, of which the tree and the filled heights are given.
    ///
    /// # Panics
    /// When tree or heights are of another grid.
    pub fn new(surface: Surface<'a>, tree: &'a Tree, filled: &'a [f32], rule: Rule) -> Self {
        assert_eq!((tree.cells, filled.len()), (surface.cells, surface.cells.len()), "one grid");
        Self { surface, tree, filled, rule }
    }

    /// The share of each neighbour in the water of a cell; all 0 of outlets.
    pub fn shares(&self, cell: usize) -> [f64; 8] {
        self.divide(cell).0
    }

    /// The direction in which the water of a cell goes on the whole, as a unit vector to the east and south; 0 and 0 of
    /// outlets.
    pub fn direction(&self, cell: usize) -> [f64; 2] {
        self.divide(cell).1
    }

    /// One receiver for each cell, drawn from its shares by a number in \[0, 1) that `chance` gives \[fairfield1991\]. Over
    /// many cells the ways run where the water does, while those of steepest descent keep to eight directions.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn draw(&self, chance: impl Fn(usize) -> f64 + Sync, work: &Work<'_>) -> Result<Tree, Cancelled> {
        let cols = self.surface.cells.cols;
        let mut to = vec![NONE; self.surface.cells.len()];
        work.rows(&mut to, cols, band(cols), |j, row| {
            for (out, cell) in row.iter_mut().zip(j * cols..) {
                let (shares, mut left) = (along(self.rule, self.shares(cell)), chance(cell));
                for k in (0..8u8).filter(|&k| shares[usize::from(k)] > 0.0) {
                    // The last share takes what rounding leaves.
                    *out = k;
                    left -= shares[usize::from(k)];
                    if left < 0.0 {
                        break;
                    }
                }
            }
        })?;
        Ok(Tree::new(self.surface.cells, self.tree.cell, to))
    }

    fn divide(&self, cell: usize) -> ([f64; 8], [f64; 2]) {
        let k = self.tree.directions()[cell];
        if k == NONE {
            return ([0.0; 8], [0.0; 2]);
        }
        let divided = self.is_dry(cell).then(|| {
            let (here, around) = self.heights(cell);
            match self.rule {
                Rule::Infinity => steepest_facet(here, &around),
                Rule::Slopes { exponent } => by_slope(here, &around, exponent),
            }
        });
        divided.flatten().unwrap_or_else(|| {
            let mut shares = [0.0; 8];
            shares[usize::from(k)] = 1.0;
            (shares, unit(k))
        })
    }

    /// The neighbours that get water of a cell, one bit each. Slopes tell them without their powers, which take longest.
    fn receivers(&self, cell: usize) -> u8 {
        let k = self.tree.directions()[cell];
        if k != NONE && matches!(self.rule, Rule::Slopes { .. }) && self.is_dry(cell) {
            let (here, around) = self.heights(cell);
            let lower = bits(|k| around[k] < here);
            return if lower == 0 { 1 << k } else { lower };
        }
        let shares = self.shares(cell);
        bits(|k| shares[k] > 0.0)
    }

    /// Whether filling leaves a cell as it is.
    fn is_dry(&self, cell: usize) -> bool {
        self.filled[cell] <= self.surface.at(cell)
    }

    /// The filled heights of a cell and of its neighbours.
    fn heights(&self, cell: usize) -> (f64, [f64; 8]) {
        (f64::from(solid(self.filled[cell])), self.heights_around(cell))
    }

    /// Filled heights of the neighbours; infinite beyond the border.
    fn heights_around(&self, cell: usize) -> [f64; 8] {
        let mut around = [f64::INFINITY; 8];
        for (k, i) in self.surface.cells.around(cell) {
            around[usize::from(k)] = f64::from(solid(self.filled[i]));
        }
        around
    }

    /// Sums of amounts: of each cell its own and its shares of those of the cells above.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn accumulate(&self, mut amount: Vec<f64>, work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
        let cols = self.surface.cells.cols;
        let mut receivers = vec![0u8; amount.len()];
        work.stage(0.0, 0.4).rows(&mut receivers, cols, band(cols), |j, row| {
            for (i, out) in row.iter_mut().enumerate() {
                *out = self.receivers(j * cols + i);
            }
        })?;
        let mut missing = donors(self.surface.cells, |cell| receivers[cell], &work.stage(0.4, 0.5))?;
        let (n, mut steps, mut ready) = (amount.len(), 0, Vec::new());
        for first in 0..n {
            if missing[first] == 0 {
                ready.push(first as u32);
            }
            while let Some(cell) = ready.pop().map(|cell| cell as usize) {
                // Its water goes on once.
                missing[cell] = u8::MAX;
                steps += 1;
                if steps % LOOK == 0 {
                    work.step(0.5 + 0.5 * steps as f32 / n as f32)?;
                }
                let sum = amount[cell];
                // A share may be too small for a number: its cell still has one donor less to come.
                for (k, share) in
                    (0..8u8).zip(self.shares(cell)).filter(|&(k, _)| receivers[cell] >> k & 1 == 1)
                {
                    let down = self.surface.cells.step(cell, k);
                    amount[down] += sum * share;
                    missing[down] -= 1;
                    if missing[down] == 0 && down < first {
                        ready.push(down as u32);
                    }
                }
            }
        }
        Ok(amount)
    }
}

/// The shares in which steps must be drawn to run in the direction that shares of water say. Those of D-infinity go by the
/// angle between a side and a corner; a step to a corner is longer, so that it must be drawn less often.
fn along(rule: Rule, shares: [f64; 8]) -> [f64; 8] {
    if rule != Rule::Infinity {
        return shares;
    }
    let corner: f64 = [0, 2, 5, 7].iter().map(|&k| shares[k]).sum();
    let often = libm::tan(corner * std::f64::consts::FRAC_PI_4);
    let mut drawn = shares;
    for (k, share) in drawn.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
        *share = if [0, 2, 5, 7].contains(&k) { often } else { 1.0 - often };
    }
    drawn
}

/// The neighbours that a test picks, one bit each.
fn bits(picks: impl Fn(usize) -> bool) -> u8 {
    (0..8).filter(|&k| picks(k)).fold(0, |set, k| set | 1 << k)
}

type Divided = ([f64; 8], [f64; 2]);

/// Shares by the angle of the steepest facet; none where nothing descends.
fn steepest_facet(here: f64, around: &[f64; 8]) -> Option<Divided> {
    /// Facets as the neighbour that shares a side with the cell and the one at its corner.
    const FACETS: [(usize, usize); 8] = [(1, 0), (1, 2), (3, 0), (3, 5), (4, 2), (4, 7), (6, 5), (6, 7)];
    let mut best = (0.0, None);
    for (side, corner) in FACETS {
        let [straight, across] = [here - around[side], around[side] - around[corner]];
        if !straight.is_finite() || !across.is_finite() {
            continue;
        }
        // Beyond either side of the facet the descent is along that side.
        let (slope, part) = if across <= 0.0 {
            (straight, Part::Side)
        } else if across >= straight {
            ((here - around[corner]) / std::f64::consts::SQRT_2, Part::Corner)
        } else {
            (libm::sqrt(straight * straight + across * across), Part::Between(straight, across))
        };
        if slope > best.0 {
            best = (slope, Some((side, corner, part)));
        }
    }
    let (side, corner, part) = best.1?;
    let mut shares = [0.0; 8];
    let direction = match part {
        Part::Side => {
            shares[side] = 1.0;
            unit(side as u8)
        }
        Part::Corner => {
            shares[corner] = 1.0;
            unit(corner as u8)
        }
        Part::Between(straight, across) => {
            let share = libm::atan2(across, straight) / std::f64::consts::FRAC_PI_4;
            (shares[side], shares[corner]) = (1.0 - share, share);
            let toward = |step: [i32; 8]| {
                let (side, corner) = (f64::from(step[side]), f64::from(step[corner]));
                (straight * side + across * (corner - side)) / best.0
            };
            [toward(EAST), toward(SOUTH)]
        }
    };
    Some((shares, direction))
}

/// Where in a facet the steepest descent lies.
#[derive(Clone, Copy)]
enum Part {
    Side,
    Corner,
    /// The descent towards the side, and that across from there to the corner.
    Between(f64, f64),
}

/// Shares by a power of the slope; none where nothing descends.
fn by_slope(here: f64, around: &[f64; 8], exponent: f64) -> Option<Divided> {
    let slopes: [f64; 8] = std::array::from_fn(|k| ((here - around[k]) / LENGTH[k]).max(0.0));
    let steepest = slopes.iter().fold(0.0f64, |most, &slope| most.max(slope));
    if steepest <= 0.0 {
        return None;
    }
    let weights = slopes.map(|slope| if slope > 0.0 { libm::pow(slope / steepest, exponent) } else { 0.0 });
    let sum: f64 = weights.iter().sum();
    let shares = weights.map(|weight| weight / sum);
    let mut mean = [0.0; 2];
    for (k, share) in (0..8u8).zip(shares) {
        let [east, south] = unit(k);
        mean = [mean[0] + share * east, mean[1] + share * south];
    }
    let length = libm::sqrt(mean[0] * mean[0] + mean[1] * mean[1]);
    // Water that parts evenly to all sides has no direction.
    let direction = if length > 1e-12 { mean.map(|x| x / length) } else { [0.0; 2] };
    Some((shares, direction))
}
