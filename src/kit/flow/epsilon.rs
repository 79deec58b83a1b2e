//! Filling with a slope.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::descent::steepest;
use super::flats::LOOK;
use super::passes::{ordered, unordered};
use super::surface::Surface;
use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// The lowest surface over the ground on which every cell of land off the border stands `rise` metres higher than one of
/// its neighbours, or the least that two heights can differ by: every depression filled, with a slope towards where it
/// spills \[barnes2014\].
///
/// Ground that descends to an outlet at such a slope by itself stays as it is; the rest is reached from there in the order
/// of height.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn fill(surface: &Surface<'_>, rise: f64, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
    let rise = rise as f32;
    let above = |height: f32| (height + rise).max(height.next_up());
    let mut settled = settled(surface, above, work)?;
    let mut height: Vec<f32> = surface.raw().to_vec();
    let mut queue = Queue::default();
    for cell in 0..height.len() {
        if cell % LOOK == 0 {
            work.step(0.4 + 0.2 * cell as f32 / height.len() as f32)?;
        }
        if settled[cell] && surface.cells.around(cell).any(|(_, i)| !settled[i]) {
            queue.heap.push(Reverse(key(surface.at(cell), cell)));
        }
    }
    let mut steps = 0;
    while let Some((level, cell)) = queue.pop() {
        steps += 1;
        if steps % LOOK == 0 {
            work.step(0.6 + 0.4 * steps as f32 / height.len() as f32)?;
        }
        let least = above(level);
        for (_, i) in surface.cells.around(cell) {
            if settled[i] {
                continue;
            }
            settled[i] = true;
            if height[i] >= least {
                queue.heap.push(Reverse(key(height[i], i)));
            } else {
                height[i] = least;
                queue.raised.push_back(key(least, i));
            }
        }
    }
    Ok(height)
}

/// Cells that keep their height: outlets, and what descends to them steeply enough.
fn settled(
    surface: &Surface<'_>,
    above: impl Fn(f32) -> f32,
    work: &Work<'_>,
) -> Result<Vec<bool>, Cancelled> {
    let to = steepest(surface, &work.stage(0.0, 0.1))?;
    let outlet = |cell: usize| !surface.is_land(cell) || surface.cells.on_border(cell);
    let tree = Tree::new(surface.cells, surface.cell, to);
    let rises = |cell: usize, down: bool| {
        let enough = || tree.receiver(cell).is_some_and(|to| surface.at(cell) >= above(surface.at(to)));
        down && enough() || outlet(cell)
    };
    tree.upwards(outlet, rises, &work.stage(0.1, 0.4))
}

/// Cells whose neighbours are still to be reached, by height. Raised cells come in the order of height by themselves.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Reverse<u64>>,
    raised: VecDeque<u64>,
}

impl Queue {
    fn pop(&mut self) -> Option<(f32, usize)> {
        let next = match (self.heap.peek(), self.raised.front()) {
            (Some(Reverse(a)), Some(b)) if a < b => self.heap.pop().map(|Reverse(a)| a),
            (_, Some(_)) => self.raised.pop_front(),
            _ => self.heap.pop().map(|Reverse(a)| a),
        }?;
        Some((unordered((next >> 32) as u32), next as u32 as usize))
    }
}

fn key(height: f32, cell: usize) -> u64 {
    u64::from(ordered(height)) << 32 | cell as u64
}
