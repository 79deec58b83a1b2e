//! The depressions of a surface: pits, basins, and the levels to which they fill.

use super::accumulate::each;
use super::descent;
use super::flats::{self, LOOK};
use super::neighbor::{LENGTH, NONE, opposite};
use super::passes::{self, Pass};
use super::surface::Surface;
use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// A cell from which no way leads down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pit {
    /// The cell.
    pub cell: u32,
    /// The level, in metres, at which its water leaves: the least height to climb on any way to an outlet.
    pub level: f32,
    /// The last cell of its basin on the way out over the lowest pass.
    pub gate: u32,
    /// The direction from there into the next basin; none where the gate lies on the border and is an outlet.
    pub out: u8,
}

/// What descends to where on a surface, and how high the water stands there.
#[derive(Clone, Debug)]
pub struct Depressions {
    /// The direction of the descent from each cell; none of outlets and pits.
    to: Vec<u8>,
    /// For each cell one more than the index of the pit that it descends to; 0 of what descends to an outlet.
    label: Vec<u32>,
    pits: Vec<Pit>,
}

impl Depressions {
    /// The depressions of a surface.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn find(surface: &Surface<'_>, work: &Work<'_>) -> Result<Self, Cancelled> {
        let mut to = descent::steepest(surface, &work.stage(0.0, 0.2))?;
        let pits = flats::drain(surface, &mut to, work)?;
        work.report(0.3);
        let label = labels(surface, &to, &pits, &work.stage(0.3, 0.6))?;
        let passes = passes::between(surface, &label, work)?;
        work.report(0.8);
        let tree = passes::lowest_tree(passes, pits.len(), work)?;
        work.report(0.9);
        let pits = outwards(surface, &label, &pits, &tree, work)?;
        work.step(1.0)?;
        Ok(Self { to, label, pits })
    }

    /// The pits, by the index of their cells.
    pub fn pits(&self) -> &[Pit] {
        &self.pits
    }

    /// The pit that a cell descends to; none where that is an outlet.
    #[inline]
    pub fn pit(&self, cell: usize) -> Option<&Pit> {
        self.label[cell].checked_sub(1).map(|pit| &self.pits[pit as usize])
    }

    /// The level of the water over a cell, or its height in metres where it is dry.
    #[inline]
    pub fn level(&self, surface: &Surface<'_>, cell: usize) -> f32 {
        let height = surface.raw()[cell];
        self.pit(cell).map_or(height, |pit| if pit.level > height { pit.level } else { height })
    }

    /// The surface with its depressions filled up to so many metres below their levels.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn filled_below(
        &self,
        surface: &Surface<'_>,
        depth: f32,
        work: &Work<'_>,
    ) -> Result<Vec<f32>, Cancelled> {
        let filled = |cell: usize| {
            let height = surface.raw()[cell];
            let level = self.pit(cell).map_or(height, |pit| pit.level - depth);
            if level > height { level } else { height }
        };
        each(surface.cells, filled, work)
    }

    /// The surface with every depression filled to the level at which it spills.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn filled(&self, surface: &Surface<'_>, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
        self.filled_below(surface, 0.0, work)
    }

    /// Sends the water of each pit over its pass: from the pit it climbs the descent from the gate backwards, and so keeps
    /// to the bottom of the valley.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn into_tree(self, surface: &Surface<'_>, work: &Work<'_>) -> Result<Tree, Cancelled> {
        let Self { mut to, pits, .. } = self;
        let mut steps = 0;
        for pit in pits {
            let (mut cell, mut out) = (pit.gate as usize, pit.out);
            loop {
                let down = std::mem::replace(&mut to[cell], out);
                if down == NONE {
                    break;
                }
                out = opposite(down);
                cell = surface.cells.step(cell, down);
                steps += 1;
                if steps % LOOK == 0 {
                    work.check()?;
                }
            }
        }
        Ok(Tree::new(surface.cells, surface.cell, to))
    }
}

/// For each cell one more than the index of its pit, 0 of what descends to an outlet.
fn labels(surface: &Surface<'_>, to: &[u8], pits: &[u32], work: &Work<'_>) -> Result<Vec<u32>, Cancelled> {
    const UNKNOWN: u32 = u32::MAX;
    let cells = surface.cells;
    let mut label = vec![UNKNOWN; cells.len()];
    for (pit, name) in pits.iter().zip(1..) {
        label[*pit as usize] = name;
    }
    for first in 0..cells.len() {
        if first % LOOK == 0 {
            work.step(first as f32 / cells.len() as f32)?;
        }
        // Down to what is known, and once more to tell it to all on the way.
        let mut end = first;
        while label[end] == UNKNOWN && to[end] != NONE {
            end = cells.step(end, to[end]);
        }
        let name = if label[end] == UNKNOWN { 0 } else { label[end] };
        let mut cell = first;
        while label[cell] == UNKNOWN {
            label[cell] = name;
            if to[cell] != NONE {
                cell = cells.step(cell, to[cell]);
            }
        }
    }
    Ok(label)
}

/// Levels and gates of pits, found from the outside along the tree of lowest passes.
fn outwards(
    surface: &Surface<'_>,
    label: &[u32],
    cells: &[u32],
    tree: &[Pass],
    work: &Work<'_>,
) -> Result<Vec<Pit>, Cancelled> {
    let neighbors = Adjacency::new(cells.len() + 1, tree);
    let unset = |&cell: &u32| Pit { cell, level: f32::INFINITY, gate: cell, out: NONE };
    let mut pits: Vec<Pit> = cells.iter().map(unset).collect();
    let mut queue = vec![(0u32, f32::NEG_INFINITY)];
    let mut next = 0;
    while let Some(&(basin, level)) = queue.get(next) {
        next += 1;
        if next % LOOK == 0 {
            work.check()?;
        }
        for pass in neighbors.of(basin).iter().map(|&pass| tree[pass as usize]) {
            let other = pass.basins[usize::from(pass.basins[0] == basin)];
            let Some(pit) = other.checked_sub(1).map(|pit| &mut pits[pit as usize]) else { continue };
            // The pass that was come by leads back.
            if pit.level < f32::INFINITY {
                continue;
            }
            pit.level = level.max(pass.height());
            let (gate, out) = gate(surface, label, pass, other, basin);
            (pit.gate, pit.out) = (gate as u32, out);
            queue.push((other, pit.level));
        }
    }
    debug_assert!(pits.iter().all(|pit| pit.level.is_finite()), "the border lets all water out");
    Ok(pits)
}

/// The last cell of a basin on the way over a pass into another, and the direction into that one. Of the two cells of the
/// pass the higher stays; the other is the one that descends most steeply from it, so that the way is straight.
fn gate(surface: &Surface<'_>, label: &[u32], pass: Pass, from: u32, into: u32) -> (usize, u8) {
    let (cell, k) = pass.place();
    if k == NONE {
        return (cell, NONE);
    }
    let next = surface.cells.step(cell, k);
    let top = if surface.at(next) > surface.at(cell) { next } else { cell };
    let side = if label[top] == from { into } else { from };
    let mut best = (f64::NEG_INFINITY, (k, next));
    for (k, i) in surface.cells.around(top).filter(|&(_, i)| label[i] == side) {
        let descent = (f64::from(surface.at(top)) - f64::from(surface.at(i))) / LENGTH[usize::from(k)];
        if descent > best.0 {
            best = (descent, (k, i));
        }
    }
    let (k, i) = best.1;
    if side == into { (top, k) } else { (i, opposite(k)) }
}

/// The passes at each basin.
struct Adjacency {
    start: Vec<u32>,
    passes: Vec<u32>,
}

impl Adjacency {
    fn new(count: usize, tree: &[Pass]) -> Self {
        let mut start = vec![0u32; count + 1];
        let ends =
            || tree.iter().zip(0u32..).flat_map(|(pass, n)| pass.basins.map(|basin| (basin as usize, n)));
        ends().for_each(|(basin, _)| start[basin + 1] += 1);
        (0..count).for_each(|basin| start[basin + 1] += start[basin]);
        let mut free = start.clone();
        let mut passes = vec![0; 2 * tree.len()];
        for (basin, n) in ends() {
            passes[free[basin] as usize] = n;
            free[basin] += 1;
        }
        Self { start, passes }
    }

    fn of(&self, basin: u32) -> &[u32] {
        let basin = basin as usize;
        &self.passes[self.start[basin] as usize..self.start[basin + 1] as usize]
    }
}
