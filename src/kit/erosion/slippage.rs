//! Slopes that are too steep give way: one step of slippage on rock and loose ground.
//!
//! Ground moves as `dh/dt = ∇·(κ ∇h)`, with `κ = max(0, 1 − T / |∇h|)`: nothing moves below the angle of repose, of tangent
//! `T`, and what is steeper eases towards it. `|∇h|` is that of the gradient, across an edge and along it, so that a pile
//! becomes a round cone; pairs of cells that each compare their own two heights make pyramids.
//!
//! Loose ground goes first, by its own angle, as far as there is some. Rock gives way where the ground is steeper than rock
//! stands; what falls is loose from then on.
//!
//! A step is one sweep over the rows, and its sums are taken in pairs that change places when the land is mirrored or turned
//! by a quarter, so that the result does as well, to the bit.

use super::band::{Band, Bands};
use super::lines::Lines;
use crate::kit::flow::neighbor::Cells;
use crate::kit::simd::{Kernel, Level, larger, smaller};
use crate::work::{Cancelled, Work};

/// Largest share of the ground in excess that may move in a step between two cells: four neighbours, and half of it for
/// safety.
pub const PACE: f32 = 0.125;

/// Rows beyond a band that its own rows depend on.
const REACH: usize = 2;

/// Quantities of the ground: wear and loose ground.
const GROUND: usize = 2;

/// Tangents of angles of repose: one for all cells, or one for each.
#[derive(Clone, Copy, Debug)]
pub enum Repose<'a> {
    /// The same everywhere.
    Even(f32),
    /// Of each cell.
    Each(&'a [f32]),
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
    /// Loose ground that `start` has in it, in metres; none without it.
    pub before: Option<&'a [f32]>,
    /// The angle of repose of rock.
    pub rock: Repose<'a>,
    /// The angle of repose of loose ground.
    pub loose: Repose<'a>,
    /// Factor on all that moves, 0 to 1; between two cells the smaller counts.
    pub mask: Option<&'a [f32]>,
    /// Whether the cells of the border are the outside: then nothing moves between them and the land.
    pub open: bool,
    /// Share of the ground in excess that moves in a step between two cells, up to [`PACE`].
    pub pace: f32,
}

/// The parts of a step that are kept from one to the next, so that no memory is asked for anew.
#[derive(Debug)]
pub struct Slippage {
    bands: Bands<GROUND, Held>,
    level: Level,
}

/// The rows that a sweep has in hand. Heights have a row before the first and one after the last, and stand one place on.
#[derive(Debug)]
struct Held {
    /// Height and its change, tangents of repose and mask.
    height: Lines,
    change: Lines,
    rock: Lines,
    rubble: Lines,
    mask: Lines,
    /// Share of the loose ground asked for that is there.
    supply: Lines,
    /// Loose ground and rock that cross the edges to the east and to the south, in metres; away from the cell above 0.
    loose_over: [Lines; 2],
    rock_over: [Lines; 2],
    none: Vec<f32>,
}

impl Held {
    fn new(cols: usize) -> Self {
        let lines = || Lines::new(cols);
        Self {
            height: lines(),
            change: lines(),
            rock: lines(),
            rubble: lines(),
            mask: lines(),
            supply: lines(),
            loose_over: [lines(), lines()],
            rock_over: [lines(), lines()],
            none: vec![0.0; cols + 2],
        }
    }
}

impl Slippage {
    /// Room for steps on so many cells.
    pub fn new(cells: Cells) -> Self {
        Self {
            bands: Bands::new(cells.cols, cells.rows, REACH, || Held::new(cells.cols)),
            level: Level::best(),
        }
    }

    /// The same, compiled for an instruction set.
    #[must_use]
    pub fn on(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Lets ground slip once. `wear` is the rock that has gone and `loose` the loose ground, in metres.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    ///
    /// # Panics
    /// When there is not one value per cell of the slopes, or the room was made for other cells.
    pub fn step(
        &mut self,
        slopes: &Slopes<'_>,
        [wear, loose]: [&mut [f32]; 2],
        work: &Work<'_>,
    ) -> Result<(), Cancelled> {
        work.check()?;
        if !slopes.cells.is_empty() {
            let level = self.level;
            self.bands.sweep([wear, loose], |band, held| level.run(Sweep { slopes: *slopes, band, held }));
        }
        Ok(())
    }
}

/// A step of a band.
struct Sweep<'a> {
    slopes: Slopes<'a>,
    band: Band<'a, GROUND>,
    held: &'a mut Held,
}

impl Kernel for Sweep<'_> {
    #[inline(always)]
    fn run(mut self) {
        let ([from, to], rows) = (self.band.rows, self.slopes.cells.rows);
        let first = from.saturating_sub(REACH);
        // Row t is begun; edges follow it by a row, and what crosses them by two.
        for t in first..to + REACH {
            if t < rows {
                self.begin(t);
            }
            if t == rows {
                extend(&mut self.held.height, [rows + 1, rows, rows.saturating_sub(1).max(1)]);
            }
            if t == 1 || rows == 1 {
                extend(&mut self.held.height, [0, 1, 2.min(rows)]);
            }
            if let Some(y) = t.checked_sub(1).filter(|y| (first..rows).contains(y)) {
                self.ask(y);
                self.supply(y);
            }
            if let Some(y) = t.checked_sub(2).filter(|&y| y + 1 >= from && (first..rows).contains(&y)) {
                self.give(y);
                if y >= from {
                    self.finish(y);
                }
            }
        }
    }
}

/// Continues heights in a straight line to a row beyond the first or last, from that and the one beside it.
#[inline(always)]
fn extend(lines: &mut Lines, [beyond, last, beside]: [usize; 3]) {
    lines.copy(beside, beyond);
    let (cols, last) = (lines.wide(last).len(), last);
    for i in 0..cols {
        let value = 2.0 * lines.wide(last)[i] - lines.wide(beyond)[i];
        lines.wide_mut(beyond)[i] = value;
    }
}

impl Sweep<'_> {
    /// Height of a row and all that edges need of it.
    #[inline(always)]
    fn begin(&mut self, y: usize) {
        let (slopes, held) = (self.slopes, &mut *self.held);
        let cols = slopes.cells.cols;
        let span = y * cols..(y + 1) * cols;
        let [wear, loose] = self.band.row(y);
        let before = slopes.before.map_or(&held.none[..cols], |before| &before[span.clone()]);
        let start = &slopes.start[span.clone()];
        let change = held.change.row_mut(y);
        for i in 0..cols {
            change[i] = (loose[i] - before[i]) - wear[i];
        }
        let row = held.height.wide_mut(y + 1);
        let inner = &mut row[1..=cols];
        for i in 0..cols {
            inner[i] = start[i] + change[i];
        }
        let beside = 1.min(cols - 1);
        row[0] = 2.0 * row[1] - row[1 + beside];
        row[cols + 1] = 2.0 * row[cols] - row[cols - beside];
        let cell = slopes.cell as f32;
        for (repose, lines) in [(slopes.rock, &mut held.rock), (slopes.loose, &mut held.rubble)] {
            let row = lines.row_mut(y);
            match repose {
                Repose::Even(tangent) => row.fill(larger(tangent, 0.0) * cell),
                Repose::Each(tangents) => {
                    let tangents = &tangents[span.clone()];
                    for i in 0..cols {
                        row[i] = larger(tangents[i], 0.0) * cell;
                    }
                }
            }
        }
        let row = held.mask.row_mut(y);
        match slopes.mask {
            Some(mask) => {
                let mask = &mask[span];
                for i in 0..cols {
                    row[i] = slopes.pace * smaller(larger(mask[i], 0.0), 1.0);
                }
            }
            None => row.fill(slopes.pace),
        }
        if slopes.open {
            if y == 0 || y + 1 == slopes.cells.rows {
                row.fill(0.0);
            }
            (row[0], row[cols - 1]) = (0.0, 0.0);
        }
    }

    /// What would cross the edges of a row.
    #[inline(always)]
    fn ask(&mut self, y: usize) {
        let (slopes, held) = (self.slopes, &mut *self.held);
        let Cells { cols, rows } = slopes.cells;
        let start = |y: usize| &slopes.start[y * cols..][..cols];
        let (height, last) = (&held.height, cols - 1);
        let [east, south] = &mut held.loose_over;
        let [rock_east, rock_south] = &mut held.rock_over;
        let (north, below) = (height.row(y), height.row(y + 2));
        across(
            &Ends {
                start: [&start(y)[..last], &start(y)[1..]],
                change: [&held.change.row(y)[..last], &held.change.row(y)[1..]],
                rock: [&held.rock.row(y)[..last], &held.rock.row(y)[1..]],
                rubble: [&held.rubble.row(y)[..last], &held.rubble.row(y)[1..]],
                mask: [&held.mask.row(y)[..last], &held.mask.row(y)[1..]],
                before: [&north[..last], &north[1..]],
                after: [&below[..last], &below[1..]],
            },
            &mut east.row_mut(y)[..last],
            &mut rock_east.row_mut(y)[..last],
        );
        if y + 1 >= rows {
            south.row_mut(y).fill(0.0);
            rock_south.row_mut(y).fill(0.0);
            return;
        }
        let (here, next) = (height.wide(y + 1), height.wide(y + 2));
        across(
            &Ends {
                start: [start(y), start(y + 1)],
                change: [held.change.row(y), held.change.row(y + 1)],
                rock: [held.rock.row(y), held.rock.row(y + 1)],
                rubble: [held.rubble.row(y), held.rubble.row(y + 1)],
                mask: [held.mask.row(y), held.mask.row(y + 1)],
                before: [&here[..cols], &next[..cols]],
                after: [&here[2..], &next[2..]],
            },
            south.row_mut(y),
            rock_south.row_mut(y),
        );
    }

    /// The share of the loose ground asked of a row that is there.
    #[inline(always)]
    fn supply(&mut self, y: usize) {
        let held = &mut *self.held;
        let cols = self.slopes.cells.cols;
        let [_, loose] = self.band.row(y);
        let Four { own: [e, s], other: [w, n] } = four(&held.loose_over, &held.none, y);
        let supply = held.supply.row_mut(y);
        let out = |q: f32| larger(q, 0.0);
        for i in 0..cols {
            let asked = (out(e[i]) + out(-w[i])) + (out(s[i]) + out(-n[i]));
            supply[i] = smaller(1.0, loose[i] / larger(asked, 1e-30));
        }
    }

    /// What crosses the edges of a row.
    #[inline(always)]
    fn give(&mut self, y: usize) {
        let held = &mut *self.held;
        let Cells { cols, rows } = self.slopes.cells;
        let ([east, south], [rock_east, rock_south]) = (&mut held.loose_over, &mut held.rock_over);
        let (here, last) = (held.supply.row(y), cols - 1);
        share([&here[..last], &here[1..]], &mut east.row_mut(y)[..last], &mut rock_east.row_mut(y)[..last]);
        if y + 1 < rows {
            share([here, held.supply.row(y + 1)], south.row_mut(y), rock_south.row_mut(y));
        }
    }

    /// The ground of a row after the step.
    #[inline(always)]
    fn finish(&mut self, y: usize) {
        let held = &*self.held;
        let cols = self.slopes.cells.cols;
        let [wear, loose] = self.band.row(y);
        let Four { own: [e, s], other: [w, n] } = four(&held.loose_over, &held.none, y);
        let Four { own: [re, rs], other: [rw, rn] } = four(&held.rock_over, &held.none, y);
        let out = |q: f32| larger(q, 0.0);
        for i in 0..cols {
            let net = (e[i] - w[i]) + (s[i] - n[i]);
            let fell = (out(-re[i]) + out(rw[i])) + (out(-rs[i]) + out(rn[i]));
            let gone = (out(re[i]) + out(-rw[i])) + (out(rs[i]) + out(-rn[i]));
            loose[i] = larger(loose[i] - (net - fell), 0.0);
            wear[i] += gone;
        }
    }
}

/// What the ends of edges are like: height at the start and its change, metres that rock and loose ground stand over a cell, and
/// mask of the two cells; and heights before and after each, along the edge.
struct Ends<'a> {
    start: [&'a [f32]; 2],
    change: [&'a [f32]; 2],
    rock: [&'a [f32]; 2],
    rubble: [&'a [f32]; 2],
    mask: [&'a [f32]; 2],
    before: [&'a [f32]; 2],
    after: [&'a [f32]; 2],
}

/// What would move over edges, loose ground and rock, from the first cell to the second above 0.
#[inline(always)]
fn across(ends: &Ends<'_>, loose: &mut [f32], rock: &mut [f32]) {
    let n = loose.len();
    let [a0, b0] = [&ends.start[0][..n], &ends.start[1][..n]];
    let [a1, b1] = [&ends.change[0][..n], &ends.change[1][..n]];
    let [a2, b2] = [&ends.rock[0][..n], &ends.rock[1][..n]];
    let [a3, b3] = [&ends.rubble[0][..n], &ends.rubble[1][..n]];
    let [a4, b4] = [&ends.mask[0][..n], &ends.mask[1][..n]];
    let [p0, p1] = [&ends.before[0][..n], &ends.before[1][..n]];
    let [q0, q1] = [&ends.after[0][..n], &ends.after[1][..n]];
    let rock = &mut rock[..n];
    for i in 0..n {
        let drop = (a0[i] - b0[i]) + (a1[i] - b1[i]);
        // Along the edge: the mean of the differences over two cells on either side of it.
        let along = 0.25 * ((q0[i] - p0[i]) + (q1[i] - p1[i]));
        let flatness = 1.0 / larger((drop * drop + along * along).sqrt(), 1e-20);
        let moves = smaller(a4[i], b4[i]) * drop;
        let (stands, lies) = if drop > 0.0 { (a2[i], a3[i]) } else { (b2[i], b3[i]) };
        loose[i] = moves * larger(1.0 - lies * flatness, 0.0);
        rock[i] = moves * larger(1.0 - stands * flatness, 0.0);
    }
}

/// Lets edges have what their upper cell can give: loose ground as far as there is some, and rock for the rest.
#[inline(always)]
fn share(supply: [&[f32]; 2], loose: &mut [f32], rock: &mut [f32]) {
    let n = loose.len();
    let (k0, k1) = (&supply[0][..n], &supply[1][..n]);
    let rock = &mut rock[..n];
    for i in 0..n {
        loose[i] = larger(loose[i], 0.0) * k0[i] + smaller(loose[i], 0.0) * k1[i];
        rock[i] = larger(rock[i], 0.0) * (1.0 - k0[i]) + smaller(rock[i], 0.0) * (1.0 - k1[i]);
    }
}

/// A quantity on the edges of a row's cells: their own to the east and south, and those of their neighbours in the west and
/// north.
struct Four<'a> {
    own: [&'a [f32]; 2],
    other: [&'a [f32]; 2],
}

#[inline(always)]
fn four<'a>([east, south]: &'a [Lines; 2], none: &'a [f32], y: usize) -> Four<'a> {
    let cols = none.len() - 2;
    let north = y.checked_sub(1).map_or(&none[..cols], |above| south.row(above));
    Four { own: [east.row(y), south.row(y)], other: [&east.wide(y)[..cols], north] }
}
