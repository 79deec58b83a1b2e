//! Ways across level ground.
//!
//! A flat that has an exit, a cell of the same height with a lower neighbour or on the border, drains to its nearest exit,
//! counted in steps over neighbours \[barnes2014flats\]. A flat without one is a pit: it drains to the first of its cells.
//! Each way is found by a search in breadth from the cells it ends at, in the order of their indices.

use rayon::prelude::*;

use super::descent::band;
use super::neighbor::{NONE, opposite};
use super::surface::Surface;
use crate::work::{Cancelled, Work};

/// Cells between two looks at whether to stop.
pub(super) const LOOK: usize = 1 << 16;

/// Gives directions to cells that have none because they are level with what lies around them. Cells that have none
/// afterwards are outlets or pits; the pits are returned, by index.
pub(super) fn drain(surface: &Surface<'_>, to: &mut [u8], work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
    let mut open = open_cells(surface, to, work)?;
    let mut queue = exits(surface, to, &open, work)?;
    spread(surface, to, &mut queue, work)?;
    open.retain(|&cell| to[cell as usize] == NONE);
    let mut pits = Vec::new();
    for (n, &pit) in open.iter().enumerate() {
        if n % LOOK == 0 {
            work.check()?;
        }
        // Cells of a flat that was reached from its first cell have directions by now.
        if to[pit as usize] == NONE {
            pits.push(pit);
            queue.clear();
            queue.push(pit);
            spread(surface, to, &mut queue, work)?;
            // The search comes back to where it began.
            to[pit as usize] = NONE;
        }
    }
    Ok(pits)
}

/// Land off the border that has no lower neighbour, by index.
fn open_cells(surface: &Surface<'_>, to: &[u8], work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
    let (cells, cols) = (surface.cells, surface.cells.cols.max(1));
    let bands = to.par_chunks(cols * band(cols)).enumerate().map(|(b, rows)| {
        work.check()?;
        let first = b * cols * band(cols);
        let open = |&i: &usize| rows[i - first] == NONE && surface.is_land(i) && !cells.on_border(i);
        Ok((first..first + rows.len()).filter(open).map(|i| i as u32).collect())
    });
    Ok(bands.collect::<Result<Vec<Vec<u32>>, Cancelled>>()?.concat())
}

/// Sends open cells beside an exit of their height to it, and returns them.
fn exits(surface: &Surface<'_>, to: &mut [u8], open: &[u32], work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
    let cells = surface.cells;
    let found = open.par_chunks(LOOK).map(|open| {
        work.check()?;
        let exit = |&cell: &u32| {
            let height = surface.at(cell as usize);
            let mut around = cells.around(cell as usize);
            let leads_out = |i: usize| surface.at(i) == height && (to[i] != NONE || cells.on_border(i));
            around.find(|&(_, i)| leads_out(i)).map(|(k, _)| (cell, k))
        };
        Ok(open.iter().filter_map(exit).collect())
    });
    let found = found.collect::<Result<Vec<Vec<_>>, Cancelled>>()?;
    Ok(found
        .into_iter()
        .flatten()
        .map(|(cell, k)| {
            to[cell as usize] = k;
            cell
        })
        .collect())
}

/// Sends cells that are level with those of a queue towards them, in breadth.
fn spread(
    surface: &Surface<'_>,
    to: &mut [u8],
    queue: &mut Vec<u32>,
    work: &Work<'_>,
) -> Result<(), Cancelled> {
    let mut next = 0;
    while let Some(&cell) = queue.get(next) {
        next += 1;
        if next % LOOK == 0 {
            work.check()?;
        }
        let cell = cell as usize;
        let height = surface.at(cell);
        for (k, i) in surface.cells.around(cell) {
            if to[i] == NONE && surface.at(i) == height && !surface.cells.on_border(i) {
                to[i] = opposite(k);
                queue.push(i as u32);
            }
        }
    }
    Ok(())
}
