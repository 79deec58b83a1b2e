//! The open border: water and load leave, counted, and nothing shows where.
//!
//! The cells of the border are the outside. Water only goes into them, never out; each has the depth that its inner neighbour
//! has, so that the surface falls over the border as the ground does, or by a hundredth where the ground rises. Its ground rises
//! with that of its neighbour, and falls only where it would stand as a dam: rivers cut down to the border and not below it.

use super::site::{Site, State};
use crate::kit::erosion::lines::Lines;

/// Least slope of the water over an open border.
const LEAST: f32 = 0.01;

/// Whether land has cells that are not of its border: without them it has no open border.
pub(super) fn has_inside(site: &Site) -> bool {
    site.cols > 2 && site.rows > 2
}

/// Cells of the border have the flow of their inner neighbours, as far as friction is concerned.
pub(super) fn square(lines: &mut Lines, y: usize, [cols, rows]: [usize; 2]) {
    let row = lines.row_mut(y);
    row[0] = row[1];
    row[cols - 1] = row[cols - 2];
    if y == 1 {
        lines.copy(1, 0);
    }
    if y + 1 == rows {
        lines.copy(y - 1, y);
    }
}

/// Whether a cell is one of the border.
fn outside([i, j]: [usize; 2], [cols, rows]: [usize; 2]) -> bool {
    i == 0 || j == 0 || i + 1 == cols || j + 1 == rows
}

/// No water comes in over the edges of a row, and none runs along the border.
pub(super) fn flow(lines: &mut [Lines; 4], y: usize, size: [usize; 2]) {
    let [cols, rows] = size;
    let shut = |i: usize| {
        for (lines, [east, south]) in lines.iter_mut().zip([[1, 0], [0, 1], [1, 1], [-1, 1]]) {
            let flow = &mut lines.row_mut(y)[i];
            let there = [i.wrapping_add_signed(east), y.wrapping_add_signed(south)];
            *flow = match (outside([i, y], size), outside(there, size)) {
                (true, true) => 0.0,
                (true, false) => flow.min(0.0),
                (false, true) => flow.max(0.0),
                (false, false) => *flow,
            };
        }
    };
    if y == 0 || y + 2 >= rows {
        (0..cols).for_each(shut);
    } else {
        [0, 1, cols - 2, cols - 1].into_iter().for_each(shut);
    }
}

/// What left over the border in a step, in metres summed over cells; what came is below 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Left {
    pub(super) water: f64,
    /// Load, and ground that went with the valleys.
    pub(super) solid: f64,
}

/// Takes away what went into the border, and sets it up for the next step.
pub(super) fn clear(site: &Site, state: &mut State) -> Left {
    let Site { cols, rows, .. } = *site;
    let mut left = Left::default();
    for i in 0..cols {
        clear_cell(site, state, [i, 0], &mut left);
        clear_cell(site, state, [i, rows - 1], &mut left);
    }
    for j in 1..rows - 1 {
        clear_cell(site, state, [0, j], &mut left);
        clear_cell(site, state, [cols - 1, j], &mut left);
    }
    left
}

fn clear_cell(site: &Site, state: &mut State, [i, j]: [usize; 2], left: &mut Left) {
    let Site { cols, rows, .. } = *site;
    let (cell, inner) = (j * cols + i, j.clamp(1, rows - 2) * cols + i.clamp(1, cols - 2));
    left.solid += f64::from(state.load[cell]);
    state.load[cell] = 0.0;
    if site.mask.as_ref().is_none_or(|mask| mask[cell] > 0.0) {
        follow(site, state, [cell, inner], left);
    }
    let [here, beside] = [cell, inner].map(|cell| state.change(site, cell));
    let drop = (site.height[inner] - site.height[cell]) + (beside - here);
    let below = site.sea.map_or(0.0, |sea| (sea - site.height[cell]) - here);
    let depth = state.depth(site, inner) + (drop - drop.max(LEAST * site.cell as f32));
    let water = depth.max(below).max(0.0) - (site.filled[cell] - site.height[cell]);
    left.water += f64::from(state.water[cell]) - f64::from(water);
    state.water[cell] = water;
}

/// Ground of a cell of the border rises as that of its inner neighbour, and falls with it as far as it would be a dam: it holds
/// the level to which the rivers cut.
fn follow(site: &Site, state: &mut State, [cell, inner]: [usize; 2], left: &mut Left) {
    let solid = |state: &State| f64::from(state.loose[cell]) - f64::from(state.wear[cell]);
    let had = solid(state);
    let before = |cell: usize| site.before.as_ref().map_or(0.0, |before| before[cell]);
    let change = state.change(site, inner);
    let dam = (site.height[cell] - site.height[inner]) + LEAST * site.cell as f32 - change;
    let fallen = dam.min(-change).max(0.0);
    let loose = before(cell) + if change > 0.0 { state.loose[inner] - before(inner) } else { -fallen };
    state.loose[cell] = loose.max(0.0);
    // Where it has less loose ground than goes, rock goes for the rest.
    let wear = if change > 0.0 { state.wear[inner] } else { 0.0 };
    state.wear[cell] = wear + (-loose).max(0.0);
    left.solid += had - solid(state);
}
