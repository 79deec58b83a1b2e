//! Where the water of each cell goes: to one neighbour, on and on to an outlet (D8).

use super::Depressions;
use super::flats::LOOK;
use super::neighbor::{Cells, LENGTH, NONE};
use super::surface::Surface;
use crate::work::{Cancelled, Work};

/// A direction for each cell, along which it reaches an outlet \[ocallaghan1984\].
///
/// A cell drains to the neighbour of steepest descent; a pit drains over its lowest pass, along the bottom of the valley
/// ([`Depressions::into_tree`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Columns and rows.
    pub cells: Cells,
    /// Distance between neighbours, in metres.
    pub cell: f64,
    to: Vec<u8>,
}

impl Tree {
    /// The ways of water over a surface.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn of(surface: &Surface<'_>, work: &Work<'_>) -> Result<Self, Cancelled> {
        Depressions::find(surface, work)?.into_tree(surface, work)
    }

    /// A tree of directions, in which no way comes back to where it began.
    pub(super) fn new(cells: Cells, cell: f64, to: Vec<u8>) -> Self {
        Self { cells, cell, to }
    }

    /// The direction from each cell, as in [`neighbor`](super::neighbor); none of outlets.
    pub fn directions(&self) -> &[u8] {
        &self.to
    }

    /// The neighbour that a cell drains to; none of outlets.
    #[inline(always)]
    pub fn receiver(&self, cell: usize) -> Option<usize> {
        (self.to[cell] != NONE).then(|| self.cells.step(cell, self.to[cell]))
    }

    /// Distance to the receiver, in metres; 0 of outlets.
    #[inline]
    pub fn length(&self, cell: usize) -> f64 {
        LENGTH.get(usize::from(self.to[cell])).map_or(0.0, |length| length * self.cell)
    }

    /// Values carried from the outlets upwards: `root` gives that of an outlet, and `rise` that of a cell from the cell
    /// and the value of its receiver.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn upwards<T: Copy + Default>(
        &self,
        root: impl Fn(usize) -> T,
        rise: impl Fn(usize, T) -> T,
        work: &Work<'_>,
    ) -> Result<Vec<T>, Cancelled> {
        let n = self.cells.len();
        let mut values = vec![T::default(); n];
        let mut known = vec![false; n];
        let mut way = Vec::new();
        let mut steps = 0;
        for first in 0..n {
            let mut cell = first;
            while !known[cell] {
                way.push(cell as u32);
                let Some(down) = self.receiver(cell) else { break };
                cell = down;
            }
            while let Some(cell) = way.pop().map(|cell| cell as usize) {
                values[cell] = match self.receiver(cell) {
                    Some(down) => rise(cell, values[down]),
                    None => root(cell),
                };
                known[cell] = true;
                steps += 1;
                if steps % LOOK == 0 {
                    work.step(steps as f32 / n as f32)?;
                }
            }
        }
        Ok(values)
    }

    /// Distance from each cell along its way to the outlet, in metres.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn distance(&self, work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
        self.upwards(|_| 0.0, |cell, down: f64| down + self.length(cell), work)
    }

    /// The outlet of each cell, as an index.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn outlets(&self, work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
        self.upwards(|cell| cell as u32, |_, outlet| outlet, work)
    }

    /// Basins of cells of land that drain to the same outlet, numbered from 1 by the index of the outlet; 0 of all other
    /// cells, and no number without land.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn basins(&self, land: impl Fn(usize) -> bool, work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
        let mut basin = self.outlets(&work.stage(0.0, 0.8))?;
        let n = basin.len();
        // First which outlets have land, then their numbers, at the place of the outlet.
        let mut number = vec![0u32; n];
        for (cell, &outlet) in basin.iter().enumerate() {
            if cell % LOOK == 0 {
                work.step(0.8 + 0.1 * cell as f32 / n as f32)?;
            }
            number[outlet as usize] |= u32::from(land(cell));
        }
        let mut count = 0;
        for number in number.iter_mut().filter(|number| **number != 0) {
            count += 1;
            *number = count;
        }
        for (cell, basin) in basin.iter_mut().enumerate() {
            if cell % LOOK == 0 {
                work.step(0.9 + 0.1 * cell as f32 / n as f32)?;
            }
            *basin = if land(cell) { number[*basin as usize] } else { 0 };
        }
        Ok(basin)
    }
}
