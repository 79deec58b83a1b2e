//! The channels of a tree: which cells are rivers, and how they hang together.

use super::flats::LOOK;
use super::neighbor::opposite;
use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// A cell of a river.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamCell {
    /// The cell.
    pub cell: u32,
    /// The place in the list of the one downstream; none of a mouth.
    pub down: Option<u32>,
}

/// The cells of rivers, downstream first: of each mouth, by index, all that drains to it, in breadth.
///
/// A river must not end before an outlet: `is_river` holds of a receiver where it holds of a cell. An outlet belongs to a
/// river where a cell of one drains to it, though it may be no river by itself, such as the sea. A lone outlet is none.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn trace(
    tree: &Tree,
    is_river: impl Fn(usize) -> bool,
    work: &Work<'_>,
) -> Result<Vec<StreamCell>, Cancelled> {
    let (to, n) = (tree.directions(), tree.cells.len());
    let donors = |cell: usize| {
        let drains = |&(k, i): &(u8, usize)| to[i] == opposite(k) && is_river(i);
        tree.cells.around(cell).filter(drains)
    };
    let mut stream: Vec<StreamCell> = Vec::new();
    let mut next = 0;
    for first in 0..n {
        if first % LOOK == 0 {
            work.step(first as f32 / n as f32)?;
        }
        if tree.receiver(first).is_some() || donors(first).next().is_none() {
            continue;
        }
        stream.push(StreamCell { cell: first as u32, down: None });
        while let Some(&StreamCell { cell, .. }) = stream.get(next) {
            let down = Some(next as u32);
            next += 1;
            if next % LOOK == 0 {
                work.check()?;
            }
            let above = donors(cell as usize).map(|(_, i)| StreamCell { cell: i as u32, down });
            stream.extend(above);
        }
    }
    Ok(stream)
}
