//! Lakes: what stands in the depressions of a surface.

use super::accumulate::each;
use super::depressions::Depressions;
use super::descent::band;
use super::flats::LOOK;
use super::surface::Surface;
use crate::work::{Cancelled, Work};

/// What is too little water to be a lake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Puddles {
    /// Least area of a lake, in square metres.
    pub area: f64,
    /// Least depth at its deepest place, in metres.
    pub depth: f64,
}

/// A lake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lake {
    /// Height of its water, in metres.
    pub level: f32,
    /// Number of its cells.
    pub cells: u32,
    /// Depth at its deepest place, in metres.
    pub depth: f32,
}

/// The lakes of a surface: connected cells that lie below the level of their depression.
///
/// Cells that touch, and both lie below their levels, have one level, though their pits may be several: the pass between
/// them is under water.
#[derive(Clone, Debug)]
pub struct Lakes {
    /// For each cell one more than the index of its lake, 0 off the lakes.
    pub label: Vec<u32>,
    /// The lakes, by the index of their first cell.
    pub lakes: Vec<Lake>,
}

impl Lakes {
    /// The lakes of a surface that are no puddles.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn find(
        surface: &Surface<'_>,
        depressions: &Depressions,
        puddles: Puddles,
        work: &Work<'_>,
    ) -> Result<Self, Cancelled> {
        /// Water that belongs to no lake yet, and to none at all.
        const OPEN: u32 = u32::MAX;
        let wet = |cell: usize| depressions.level(surface, cell) > surface.raw()[cell];
        let n = surface.cells.len();
        let open = |cell: usize| if wet(cell) { OPEN } else { 0 };
        let mut label = each(surface.cells, open, &work.stage(0.0, 0.1))?;
        let (mut lakes, mut shore) = (Vec::new(), Vec::new());
        let mut steps = 0;
        for first in 0..n {
            if first % LOOK == 0 {
                work.step(0.1 + 0.9 * first as f32 / n as f32)?;
            }
            if label[first] != OPEN {
                continue;
            }
            let level = depressions.level(surface, first);
            let name = lakes.len() as u32 + 1;
            let mut lake = Lake { level, cells: 0, depth: 0.0 };
            shore.clear();
            shore.push(first as u32);
            label[first] = name;
            while let Some(&cell) = shore.get(lake.cells as usize) {
                lake.cells += 1;
                lake.depth = lake.depth.max(level - surface.at(cell as usize));
                for (_, i) in surface.cells.around(cell as usize) {
                    if label[i] == OPEN {
                        label[i] = name;
                        shore.push(i as u32);
                    }
                }
                steps += 1;
                if steps % LOOK == 0 {
                    work.check()?;
                }
            }
            let area = f64::from(lake.cells) * surface.cell * surface.cell;
            if area < puddles.area || f64::from(lake.depth) < puddles.depth {
                shore.iter().for_each(|&cell| label[cell as usize] = 0);
            } else {
                lakes.push(lake);
            }
        }
        Ok(Self { label, lakes })
    }

    /// The lake of a label.
    pub fn lake(&self, label: u32) -> Option<&Lake> {
        self.lakes.get(label.checked_sub(1)? as usize)
    }

    /// Labels that reach so many cells beyond the lakes, each that of the nearest lake, of two as near that of the first
    /// neighbour.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn widened(&self, surface: &Surface<'_>, by: usize, work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
        let cols = surface.cells.cols;
        let mut label = self.label.clone();
        for _ in 0..by {
            let before = label.clone();
            work.rows(&mut label, cols, band(cols), |j, row| {
                for (i, label) in row.iter_mut().enumerate().filter(|(_, label)| **label == 0) {
                    let mut around = surface.cells.around(j * cols + i).map(|(_, i)| before[i]);
                    *label = around.find(|&label| label != 0).unwrap_or(0);
                }
            })?;
        }
        Ok(label)
    }

    /// Labels that reach over the shores: of the cells of a widened label those whose ground rises out of the water and
    /// that touch no dry ground below it, so that no water shows behind a dam.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn with_shores(
        &self,
        surface: &Surface<'_>,
        widened: &[u32],
        work: &Work<'_>,
    ) -> Result<Vec<u32>, Cancelled> {
        let cols = surface.cells.cols;
        let mut label = self.label.clone();
        work.rows(&mut label, cols, band(cols), |j, row| {
            for (i, label) in row.iter_mut().enumerate().filter(|(_, label)| **label == 0) {
                let cell = j * cols + i;
                let Some(lake) = self.lake(widened[cell]) else { continue };
                let low = |cell: usize| self.label[cell] == 0 && surface.at(cell) < lake.level;
                if !low(cell) && !surface.cells.around(cell).any(|(_, i)| low(i)) {
                    *label = widened[cell];
                }
            }
        })?;
        Ok(label)
    }
}
