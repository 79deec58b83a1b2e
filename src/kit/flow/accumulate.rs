//! Sums over all that drains through each cell.

use std::ops::AddAssign;

use super::descent::band;
use super::flats::LOOK;
use super::neighbor::Cells;
use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// Values carried from the sources downwards: `meet` is given a cell with its final value, and the value of the receiver so
/// far, which it changes. Cells pass their value on as soon as all that they receive themselves has come \[braun2013\],
/// in an order that hangs on the tree alone.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn downwards<T: Copy>(
    tree: &Tree,
    mut values: Vec<T>,
    meet: impl Fn(usize, T, &mut T),
    work: &Work<'_>,
) -> Result<Vec<T>, Cancelled> {
    /// A cell whose value has gone on.
    const DONE: u8 = u8::MAX;
    let to = tree.directions();
    let set = |cell: usize| (1u16 << to[cell]) as u8;
    let mut missing = donors(tree.cells, set, &work.stage(0.0, 0.2))?;
    let (n, mut steps) = (values.len(), 0);
    for first in 0..n {
        let mut cell = first;
        while missing[cell] == 0 {
            missing[cell] = DONE;
            steps += 1;
            if steps % LOOK == 0 {
                work.step(0.2 + 0.8 * steps as f32 / n as f32)?;
            }
            let Some(down) = tree.receiver(cell) else { break };
            let value = values[cell];
            meet(cell, value, &mut values[down]);
            missing[down] -= 1;
            cell = down;
        }
    }
    Ok(values)
}

/// Sums along a tree: of each cell its own amount and those of all cells whose way leads through it.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn along<T: Copy + AddAssign>(tree: &Tree, amount: Vec<T>, work: &Work<'_>) -> Result<Vec<T>, Cancelled> {
    downwards(tree, amount, |_, sum, down| *down += sum, work)
}

/// Number of cells that drain through each cell, itself included; only cells of `land` count.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn count(
    tree: &Tree,
    land: impl Fn(usize) -> bool + Sync,
    work: &Work<'_>,
) -> Result<Vec<u32>, Cancelled> {
    let ones = each(tree.cells, |cell| u32::from(land(cell)), &work.stage(0.0, 0.1))?;
    along(tree, ones, &work.stage(0.1, 1.0))
}

/// A value for each cell.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn each<T: Send + Clone + Default>(
    cells: Cells,
    value: impl Fn(usize) -> T + Sync,
    work: &Work<'_>,
) -> Result<Vec<T>, Cancelled> {
    let mut values = vec![T::default(); cells.len()];
    work.rows(&mut values, cells.cols, band(cells.cols), |j, row| {
        row.iter_mut().zip(j * cells.cols..).for_each(|(out, cell)| *out = value(cell));
    })?;
    Ok(values)
}

/// Number of neighbours that drain to each cell. `receivers` says where a cell drains to, as a set: bit `k` for direction
/// `k`.
pub(super) fn donors(
    cells: Cells,
    receivers: impl Fn(usize) -> u8 + Sync,
    work: &Work<'_>,
) -> Result<Vec<u8>, Cancelled> {
    let Cells { cols, rows } = cells;
    let mut count = vec![0u8; cells.len()];
    work.rows(&mut count, cols, band(cols), |j, out| {
        // The neighbour in direction k drains here in direction 7 - k. A row is read with a cell more on either side.
        let mut line = vec![0; cols + 2];
        for (row, here) in [(j.checked_sub(1), [7, 6, 5]), (Some(j), [4, 8, 3]), (Some(j + 1), [2, 1, 0])] {
            let Some(row) = row.filter(|&row| row < rows) else { continue };
            line[1..=cols].iter_mut().zip(row * cols..).for_each(|(set, cell)| *set = receivers(cell));
            let around = line.iter().zip(&line[1..]).zip(&line[2..]);
            let drains = |set: u8, k: u32| (u16::from(set) >> k) as u8 & 1;
            for (out, ((&west, &middle), &east)) in out.iter_mut().zip(around) {
                *out += drains(west, here[0]) + drains(middle, here[1]) + drains(east, here[2]);
            }
        }
    })?;
    Ok(count)
}
