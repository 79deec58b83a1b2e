//! One axis of a plate's grid: its differences, and how it is halved.

/// The first and second differences along an axis, squared: rows of banded matrices.
#[derive(Debug)]
pub(crate) struct Axis {
    /// What second differences make of the cells from two before to two after.
    pub(crate) bend: Vec<[f64; 5]>,
    /// What first differences make of the cell before, the cell and the cell after.
    pub(crate) slope: Vec<[f64; 3]>,
    /// Distance between cells, in cells of the finest level.
    pub(crate) cell: f64,
}

impl Axis {
    pub(crate) fn new(cells: usize, cell: f64) -> Self {
        let mut out = Self { bend: vec![[0.0; 5]; cells], slope: vec![[0.0; 3]; cells], cell };
        let second = [1.0, -2.0, 1.0];
        for first in 0..cells.saturating_sub(2) {
            for (i, a) in second.into_iter().enumerate() {
                for (k, b) in second.into_iter().enumerate() {
                    out.bend[first + i][2 + k - i] += a * b;
                }
            }
        }
        for first in 0..cells.saturating_sub(1) {
            for (cell, pulls) in [(first, [0.0, 1.0, -1.0]), (first + 1, [-1.0, 1.0, 0.0])] {
                out.slope[cell].iter_mut().zip(pulls).for_each(|(o, p)| *o += p);
            }
        }
        out
    }

    pub(crate) fn cells(&self) -> usize {
        self.bend.len()
    }

    /// The axis with every second cell, and one beyond the end where the number is even, so that each cell lies on or
    /// between two coarse ones. Two cells stay as they are.
    pub(crate) fn halved(&self) -> Self {
        if self.halves() {
            Self::new(self.cells() / 2 + 1, self.cell * 2.0)
        } else {
            Self::new(self.cells(), self.cell)
        }
    }

    pub(crate) fn halves(&self) -> bool {
        self.cells() > 2
    }

    /// The fine cells that a coarse one touches, with its share in each.
    pub(crate) fn around(&self, coarse: usize) -> impl Iterator<Item = (usize, f64)> {
        let touched: &[(isize, f64)] =
            if self.halves() { &[(-1, 0.5), (0, 1.0), (1, 0.5)] } else { &[(0, 1.0)] };
        let at = (if self.halves() { 2 * coarse } else { coarse }) as isize;
        let cells = self.cells() as isize;
        let placed = touched.iter().map(move |&(d, share)| (at + d, share));
        placed.filter(move |&(i, _)| i >= 0 && i < cells).map(|(i, share)| (i as usize, share))
    }

    /// The one or two coarse cells that a fine one lies on or between, with their shares.
    pub(crate) fn between(&self, fine: usize) -> [(usize, f64); 2] {
        match (self.halves(), fine % 2) {
            (false, _) => [(fine, 1.0), (fine, 0.0)],
            (true, 0) => [(fine / 2, 1.0), (fine / 2, 0.0)],
            (true, _) => [(fine / 2, 0.5), (fine / 2 + 1, 0.5)],
        }
    }
}
