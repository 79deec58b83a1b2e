//! Slopes that are too steep give way: one step of slippage on rock and loose ground.
//!
//! Ground moves as `dh/dt = ∇·(κ ∇h)`, with `κ = max(0, 1 − T / |∇h|)`: nothing moves below the angle of repose, of tangent
//! `T`, and what is steeper eases towards it. `|∇h|` is that of the gradient, across an edge and along it, so that a pile
//! becomes a round cone; pairs of cells that each compare their own two heights make pyramids.
//!
//! Loose ground goes first, by its own angle, as far as there is some. Rock gives way where the ground is steeper than rock
//! stands; what falls is loose from then on.

use crate::kit::flow::neighbor::Cells;
use crate::work::{Cancelled, Work};

/// Share of the ground in excess that moves in a step between two cells: four neighbours, and half of it for safety.
const PACE: f32 = 0.125;

/// Tangents of angles of repose: one for all cells, or one for each.
#[derive(Clone, Copy, Debug)]
pub enum Repose<'a> {
    /// The same everywhere.
    Even(f32),
    /// Of each cell.
    Each(&'a [f32]),
}

impl Repose<'_> {
    fn at(self, cell: usize) -> f32 {
        match self {
            Self::Even(tangent) => tangent,
            Self::Each(tangents) => tangents[cell],
        }
    }
}

/// What slippage is told of a grid.
#[derive(Clone, Copy, Debug)]
pub struct Slopes<'a> {
    /// Columns and rows.
    pub cells: Cells,
    /// Distance between neighbours, in metres.
    pub cell: f64,
    /// Heights before anything moved, in metres.
    pub start: &'a [f32],
    /// The angle of repose of rock.
    pub rock: Repose<'a>,
    /// The angle of repose of loose ground.
    pub loose: Repose<'a>,
    /// Factor on all that moves, 0 to 1; between two cells the smaller counts.
    pub mask: Option<&'a [f32]>,
}

/// Ground as it changes, apart from where it started, so that small changes of high land are not lost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// Rock that went, in metres.
    pub wear: Vec<f32>,
    /// Loose ground, in metres.
    pub loose: Vec<f32>,
}

/// What crosses the edges to the east and to the south of each cell in a step, in metres of ground; away from the cell above 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Moves {
    loose: [f32; 2],
    rock: [f32; 2],
}

/// The parts of a step that are kept from one to the next, so that no memory is asked for anew.
#[derive(Clone, Debug, Default)]
pub struct Slippage {
    height: Vec<f32>,
    moves: Vec<Moves>,
    /// The share of the loose ground that is asked for which is there.
    supply: Vec<f32>,
}

impl Slippage {
    /// Lets ground slip once. `before` is loose ground that `start` already has in it.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn step(
        &mut self,
        slopes: &Slopes<'_>,
        before: &[f32],
        ground: &mut Ground,
        work: &Work<'_>,
    ) -> Result<(), Cancelled> {
        let Cells { cols, rows } = slopes.cells;
        let (n, band) = (slopes.cells.len(), (1 << 14) / cols.max(1) + 1);
        self.height.resize(n, 0.0);
        self.moves.resize(n, Moves::default());
        self.supply.resize(n, 0.0);
        let Ground { wear, loose } = ground;
        let (w, l) = (&*wear, &*loose);
        work.rows(&mut self.height, cols, band, |j, out| {
            for (out, k) in out.iter_mut().zip(j * cols..) {
                *out = slopes.start[k] + ((l[k] - before[k]) - w[k]);
            }
        })?;
        let height = &self.height;
        work.rows(&mut self.moves, cols, band, |j, out| {
            for (i, out) in out.iter_mut().enumerate() {
                *out = slopes.moves(height, [i, j]);
            }
        })?;
        let moves = &self.moves;
        work.rows(&mut self.supply, cols, band, |j, out| {
            for (i, out) in out.iter_mut().enumerate() {
                let asked =
                    around(moves, [i, j], [cols, rows], |m| m.loose).iter().fold(0.0, |s, m| s + m.max(0.0));
                let there = l[j * cols + i];
                *out = if asked > there { there / asked } else { 1.0 };
            }
        })?;
        let supply = &self.supply;
        let neighbours = |at: usize| [at + 1, at.wrapping_sub(1), at + cols, at.wrapping_sub(cols)];
        work.rows(loose, cols, band, |j, out| {
            for (i, out) in out.iter_mut().enumerate() {
                let at = j * cols + i;
                let [of_loose, of_rock] = [
                    around(moves, [i, j], [cols, rows], |m| m.loose),
                    around(moves, [i, j], [cols, rows], |m| m.rock),
                ];
                let mut change = 0.0;
                for ((&l, &r), other) in of_loose.iter().zip(&of_rock).zip(neighbours(at)) {
                    if l > 0.0 {
                        change -= l * supply[at];
                    } else if l < 0.0 {
                        change -= l * supply[other];
                    }
                    if r < 0.0 {
                        change -= r * (1.0 - supply[other]);
                    }
                }
                *out = (*out + change).max(0.0);
            }
        })?;
        work.rows(wear, cols, band, |j, out| {
            for (i, out) in out.iter_mut().enumerate() {
                // Rock takes part as far as no loose ground lies on it.
                let bare = 1.0 - supply[j * cols + i];
                let of_rock = around(moves, [i, j], [cols, rows], |m| m.rock);
                *out += bare * of_rock.iter().fold(0.0, |sum, m| sum + m.max(0.0));
            }
        })
    }
}

/// What leaves a cell over its four edges, east, west, south, north; what comes is below 0.
#[inline]
fn around(
    moves: &[Moves],
    [i, j]: [usize; 2],
    [cols, rows]: [usize; 2],
    of: impl Fn(&Moves) -> [f32; 2],
) -> [f32; 4] {
    let at = j * cols + i;
    [
        if i + 1 < cols { of(&moves[at])[0] } else { 0.0 },
        if i > 0 { -of(&moves[at - 1])[0] } else { 0.0 },
        if j + 1 < rows { of(&moves[at])[1] } else { 0.0 },
        if j > 0 { -of(&moves[at - cols])[1] } else { 0.0 },
    ]
}

impl Slopes<'_> {
    /// What moves from a cell to its neighbours in the east and south.
    fn moves(&self, height: &[f32], [i, j]: [usize; 2]) -> Moves {
        let Cells { cols, rows } = self.cells;
        let at = j * cols + i;
        let mut moves = Moves::default();
        let clamped = |i: usize, j: usize| height[j * cols + i];
        let [west, north] = [i.saturating_sub(1), j.saturating_sub(1)];
        let [east, south] = [(i + 1).min(cols - 1), (j + 1).min(rows - 1)];
        if i + 1 < cols {
            // Along the edge: the mean of the differences on either side of it, over two cells but at the border.
            let span = (south - north).max(1) as f32;
            let along = 0.5
                * ((clamped(i, south) - clamped(i, north)) + (clamped(east, south) - clamped(east, north)));
            (moves.loose[0], moves.rock[0]) = self.across([at, at + 1], height, along / span);
        }
        if j + 1 < rows {
            let span = (east - west).max(1) as f32;
            let along =
                0.5 * ((clamped(east, j) - clamped(west, j)) + (clamped(east, south) - clamped(west, south)));
            (moves.loose[1], moves.rock[1]) = self.across([at, at + cols], height, along / span);
        }
        moves
    }

    /// What moves between two cells, loose and rock, from the first to the second above 0. `along` is the difference of
    /// heights over a cell along their edge.
    fn across(&self, [a, b]: [usize; 2], height: &[f32], along: f32) -> (f32, f32) {
        let drop = height[a] - height[b];
        let steep = (drop * drop + along * along).sqrt();
        let cell = self.cell as f32;
        let share = self.mask.map_or(1.0, |mask| mask[a].min(mask[b]).clamp(0.0, 1.0));
        let giver = if drop > 0.0 { a } else { b };
        let over = |repose: Repose<'_>| {
            let still = repose.at(giver).max(0.0) * cell;
            if steep > still && share > 0.0 { PACE * share * drop * (1.0 - still / steep) } else { 0.0 }
        };
        (over(self.loose), over(self.rock))
    }
}
