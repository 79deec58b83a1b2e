//! Rows of a grid in bands, which threads sweep side by side.
//!
//! A sweep changes a state in place while its rows still need what their neighbours were. So each band has copies of the rows
//! before and after it, taken before the sweep, and works those out again as far as its own rows depend on them. Bands go in
//! any order, and the result has the same bits whatever the bands are.

use rayon::prelude::*;

/// Most rows of a band: work of one thread, which others may take over.
const TALLEST: usize = 128;

/// Fewest cells of a band: below that waking a thread takes longer than the sweep.
const FEWEST: usize = 1 << 13;

/// The bands of a grid whose state is `N` numbers a cell, with room for what each band works on.
#[derive(Debug)]
pub(super) struct Bands<const N: usize, H> {
    cols: usize,
    /// Rows beyond a band that its own rows depend on.
    reach: usize,
    rooms: Vec<Room<H>>,
}

#[derive(Debug)]
struct Room<H> {
    rows: [usize; 2],
    halo: [Vec<f32>; 2],
    held: H,
}

impl<const N: usize, H: Send> Bands<N, H> {
    /// Bands of so many columns and rows; `held` makes what each band works on.
    pub(super) fn new(cols: usize, rows: usize, reach: usize, held: impl Fn() -> H) -> Self {
        let threads = rayon::current_num_threads();
        let count = threads * rows.div_ceil(threads * TALLEST).max(1);
        // Bands shorter than twice their reach would work out more rows than their own.
        let tall = rows.div_ceil(count).max(2 * reach + 2).max(FEWEST / cols.max(1));
        let room = |from: usize| {
            let to = (from + tall).min(rows);
            let copies = |count: usize| vec![0.0; count * N * cols];
            let halo = [copies(from.min(reach)), copies((rows - to).min(reach))];
            Room { rows: [from, to], halo, held: held() }
        };
        Self { cols, reach, rooms: (0..rows).step_by(tall).map(room).collect() }
    }

    /// What the bands work on, from the first row to the last.
    pub(super) fn held(&self) -> impl Iterator<Item = &H> {
        self.rooms.iter().map(|room| &room.held)
    }

    /// Sweeps all bands.
    pub(super) fn sweep(
        &mut self,
        mut state: [&mut [f32]; N],
        pass: impl Fn(Band<'_, N>, &mut H) + Send + Sync,
    ) {
        let (cols, reach) = (self.cols, self.reach);
        for Room { rows: [from, to], halo, .. } in &mut self.rooms {
            for (halo, first) in halo.iter_mut().zip([from.saturating_sub(reach), *to]) {
                for (k, row) in halo.chunks_exact_mut(cols.max(1)).enumerate() {
                    row.copy_from_slice(&state[k % N][(first + k / N) * cols..][..cols]);
                }
            }
        }
        let bands: Vec<_> = (self.rooms.iter_mut())
            .map(|Room { rows, halo, held }| {
                let count = (rows[1] - rows[0]) * cols;
                let state = state.each_mut().map(|rest| {
                    let (rows, after) = std::mem::take(rest).split_at_mut(count);
                    *rest = after;
                    rows
                });
                (Band { cols, reach, rows: *rows, state, halo }, held)
            })
            .collect();
        if let [_] = bands[..] {
            bands.into_iter().for_each(|(band, held)| pass(band, held));
            return;
        }
        bands.into_par_iter().with_max_len(1).for_each(|(band, held)| pass(band, held));
    }
}

/// The rows of a state that a sweep of one band goes through.
pub(super) struct Band<'a, const N: usize> {
    cols: usize,
    reach: usize,
    /// First row of the band, and one past its last.
    pub(super) rows: [usize; 2],
    state: [&'a mut [f32]; N],
    /// Copies of the rows before and after it, `reach` or as many as there are; row by row, all quantities.
    halo: &'a mut [Vec<f32>; 2],
}

impl<const N: usize> Band<'_, N> {
    /// Whether a row is one of the band, not a copy.
    #[inline(always)]
    pub(super) fn owns(&self, y: usize) -> bool {
        (self.rows[0]..self.rows[1]).contains(&y)
    }

    /// A row of the state, in the band or beside it.
    #[inline(always)]
    pub(super) fn row(&mut self, y: usize) -> [&mut [f32]; N] {
        let (cols, [from, to]) = (self.cols, self.rows);
        if self.owns(y) {
            return self.state.each_mut().map(|rows| &mut rows[(y - from) * cols..][..cols]);
        }
        let (beside, y) = if y < from { (0, y - from.saturating_sub(self.reach)) } else { (1, y - to) };
        let mut rest = &mut self.halo[beside][y * N * cols..][..N * cols];
        std::array::from_fn(|_| {
            let (row, after) = std::mem::take(&mut rest).split_at_mut(cols);
            rest = after;
            row
        })
    }
}
