//! The eight neighbours of a cell, numbered in the order of their indices: north-west, north, north-east, west, east,
//! south-west, south, south-east.
//!
//! ```text
//! 0 1 2
//! 3 . 4      the opposite of k is 7 - k
//! 5 6 7
//! ```

/// The direction of a cell whose water goes to no neighbour.
pub const NONE: u8 = 8;

/// Steps to the east of each neighbour.
pub const EAST: [i32; 8] = [-1, 0, 1, -1, 1, -1, 0, 1];

/// Steps to the south of each neighbour.
pub const SOUTH: [i32; 8] = [-1, -1, -1, 0, 0, 1, 1, 1];

/// Distance to each neighbour, in cells.
pub const LENGTH: [f64; 8] = [
    std::f64::consts::SQRT_2,
    1.0,
    std::f64::consts::SQRT_2,
    1.0,
    1.0,
    std::f64::consts::SQRT_2,
    1.0,
    std::f64::consts::SQRT_2,
];

/// The direction back from a neighbour.
pub const fn opposite(k: u8) -> u8 {
    7 - k
}

/// The unit vector towards a neighbour, to the east and south; 0 and 0 of no direction.
pub fn unit(k: u8) -> [f64; 2] {
    match usize::from(k) {
        k @ 0..8 => [f64::from(EAST[k]) / LENGTH[k], f64::from(SOUTH[k]) / LENGTH[k]],
        _ => [0.0; 2],
    }
}

/// The cells of a grid as indices, row by row, and the steps between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Number of columns.
    pub cols: usize,
    /// Number of rows.
    pub rows: usize,
}

impl Cells {
    /// Number of cells.
    pub fn len(self) -> usize {
        self.cols * self.rows
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The index of the neighbour that lies in a direction from a cell, which must be there.
    #[inline(always)]
    pub fn step(self, cell: usize, k: u8) -> usize {
        let offset = SOUTH[usize::from(k)] as isize * self.cols as isize + EAST[usize::from(k)] as isize;
        cell.wrapping_add_signed(offset)
    }

    /// The neighbours of a cell that are there, with their directions, by index.
    #[inline]
    pub fn around(self, cell: usize) -> impl Iterator<Item = (u8, usize)> {
        let (col, row) = (cell % self.cols, cell / self.cols);
        let (west, east) = (col == 0, col + 1 == self.cols);
        let (north, south) = (row == 0, row + 1 == self.rows);
        (0..8u8)
            .filter(move |&k| {
                let (dx, dy) = (EAST[usize::from(k)], SOUTH[usize::from(k)]);
                !(dx < 0 && west || dx > 0 && east || dy < 0 && north || dy > 0 && south)
            })
            .map(move |k| (k, self.step(cell, k)))
    }

    /// Whether a cell lies on the border of the grid.
    #[inline]
    pub fn on_border(self, cell: usize) -> bool {
        let (col, row) = (cell % self.cols, cell / self.cols);
        col == 0 || row == 0 || col + 1 == self.cols || row + 1 == self.rows
    }
}
