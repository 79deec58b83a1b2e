//! Where the samples of a field stand: a window of a lattice over the terrain.

use std::fmt;

/// An infinite square lattice of sample points.
///
/// Point `(c, r)` stands at `origin + span · (c, r) / intervals`, in metres, x to the east and y to the south.
/// The quotient is formed from the index in the whole lattice, never from a tile's corner, and as one division
/// of an exact product rather than as `cell · c`: so lattices of 512, 1008 or 1536 intervals over one span put
/// their common points at the same place to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Position of point (0, 0), in metres.
    pub origin: [f64; 2],
    /// Length that `intervals` steps cover, in metres.
    pub span: f64,
    /// Number of steps in `span`.
    pub intervals: u32,
}

impl Lattice {
    /// Distance between neighbours, in metres.
    pub fn cell(&self) -> f64 {
        self.span / f64::from(self.intervals)
    }

    /// East coordinate of a column, in metres.
    pub fn x(&self, col: i64) -> f64 {
        self.origin[0] + self.span * col as f64 / f64::from(self.intervals)
    }

    /// South coordinate of a row, in metres.
    pub fn y(&self, row: i64) -> f64 {
        self.origin[1] + self.span * row as f64 / f64::from(self.intervals)
    }

    /// The position of a world point in steps from the origin.
    #[inline]
    pub fn steps(&self, x: f64, y: f64) -> [f64; 2] {
        let per_metre = f64::from(self.intervals);
        [(x - self.origin[0]) * per_metre / self.span, (y - self.origin[1]) * per_metre / self.span]
    }

    /// The lattice with `factor` times as many points along each axis; every point of this one is in it.
    pub fn refined(&self, factor: u32) -> Self {
        Self { intervals: self.intervals.saturating_mul(factor.max(1)), ..*self }
    }
}

/// A window of a lattice: the columns and rows of a field.
#[derive(Clone, Copy, PartialEq)]
pub struct Grid {
    /// The lattice it is a window of.
    pub lattice: Lattice,
    /// First column.
    pub col: i64,
    /// First row.
    pub row: i64,
    /// Number of columns.
    pub cols: usize,
    /// Number of rows.
    pub rows: usize,
}

impl Grid {
    /// The grid of what has none: one place, the same for every terrain.
    pub const NOWHERE: Self = Self {
        lattice: Lattice { origin: [0.0, 0.0], span: 1.0, intervals: 1 },
        col: 0,
        row: 0,
        cols: 1,
        rows: 1,
    };

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.cols.saturating_mul(self.rows)
    }

    /// Column and row of the window whose sample stands nearest to a place of the world.
    pub fn nearest(&self, at: [f64; 2]) -> [usize; 2] {
        let [u, v] = self.lattice.steps(at[0], at[1]);
        let index = |steps: f64, first: i64, count: usize| {
            (steps - first as f64).round().clamp(0.0, count.saturating_sub(1) as f64) as usize
        };
        [index(u, self.col, self.cols), index(v, self.row, self.rows)]
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.cols == 0 || self.rows == 0
    }

    /// Distance between neighbours, in metres.
    pub fn cell(&self) -> f64 {
        self.lattice.cell()
    }

    /// East coordinate of the `i`-th column of the window, in metres.
    pub fn x(&self, i: usize) -> f64 {
        self.lattice.x(self.col + i as i64)
    }

    /// South coordinate of the `j`-th row of the window, in metres.
    pub fn y(&self, j: usize) -> f64 {
        self.lattice.y(self.row + j as i64)
    }

    /// East coordinates of all columns, in metres.
    pub fn xs(&self) -> Vec<f64> {
        (0..self.cols).map(|i| self.x(i)).collect()
    }

    /// One past the last column.
    pub fn col_end(&self) -> i64 {
        self.col + self.cols as i64
    }

    /// One past the last row.
    pub fn row_end(&self) -> i64 {
        self.row + self.rows as i64
    }

    /// Whether every sample of `other` is one of this window's.
    pub fn contains(&self, other: &Self) -> bool {
        self.lattice == other.lattice
            && (other.is_empty()
                || (self.col <= other.col
                    && self.row <= other.row
                    && self.col_end() >= other.col_end()
                    && self.row_end() >= other.row_end()))
    }

    /// The window from one corner (included) to the other (excluded); empty when they cross.
    pub fn between(lattice: Lattice, [col, row]: [i64; 2], [col_end, row_end]: [i64; 2]) -> Self {
        let cols = usize::try_from(col_end - col).unwrap_or(0);
        let rows = usize::try_from(row_end - row).unwrap_or(0);
        Self { lattice, col, row, cols, rows }
    }

    /// The smallest window that covers a rectangle of the world given in metres.
    pub fn covering(lattice: Lattice, bounds: Bounds) -> Self {
        let [c0, r0] = lattice.steps(bounds.min[0], bounds.min[1]);
        let [c1, r1] = lattice.steps(bounds.max[0], bounds.max[1]);
        let start = [c0.floor() as i64, r0.floor() as i64];
        Self::between(
            lattice,
            start,
            [(c1.ceil() as i64).saturating_add(1), (r1.ceil() as i64).saturating_add(1)],
        )
    }

    /// The smallest window that holds both, which must be of one lattice.
    pub fn union(&self, other: &Self) -> Self {
        debug_assert_eq!(self.lattice, other.lattice, "windows of different lattices have no union");
        let start = [self.col.min(other.col), self.row.min(other.row)];
        Self::between(
            self.lattice,
            start,
            [self.col_end().max(other.col_end()), self.row_end().max(other.row_end())],
        )
    }

    /// The samples that are in both, which must be of one lattice.
    pub fn intersection(&self, other: &Self) -> Self {
        debug_assert_eq!(self.lattice, other.lattice, "windows of different lattices have no intersection");
        let start = [self.col.max(other.col), self.row.max(other.row)];
        Self::between(
            self.lattice,
            start,
            [self.col_end().min(other.col_end()), self.row_end().min(other.row_end())],
        )
    }

    /// The window with `n` more cells on every side.
    pub fn grow_cells(&self, n: i64) -> Self {
        Self::between(self.lattice, [self.col - n, self.row - n], [self.col_end() + n, self.row_end() + n])
    }

    /// The window grown on every side by at least `metres`.
    pub fn grow_metres(&self, metres: f64) -> Self {
        // A product such as 3 · cell may land a hair above the whole number it stands for.
        let cells = (metres / self.cell() - 1e-9).ceil().max(0.0);
        self.grow_cells(cells as i64)
    }

    /// The window of the refined lattice that spans the same rectangle.
    pub fn refined(&self, factor: u32) -> Self {
        let f = i64::from(factor.max(1));
        let end = [(self.col_end() - 1) * f + 1, (self.row_end() - 1) * f + 1];
        Self::between(self.lattice.refined(factor), [self.col * f, self.row * f], end)
    }

    /// The rectangle from the first to the last sample, in metres.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            min: [self.lattice.x(self.col), self.lattice.y(self.row)],
            max: [self.lattice.x(self.col_end() - 1), self.lattice.y(self.row_end() - 1)],
        }
    }
}

impl fmt::Debug for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { col, row, cols, rows, .. } = self;
        write!(f, "{cols} x {rows} at ({col}, {row}), cell {} m", self.cell())
    }
}

/// A rectangle of the world, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// North-west corner.
    pub min: [f64; 2],
    /// South-east corner.
    pub max: [f64; 2],
}

impl Bounds {
    /// The rectangle grown by some metres on every side.
    pub fn grown(&self, metres: f64) -> Self {
        Self {
            min: [self.min[0] - metres, self.min[1] - metres],
            max: [self.max[0] + metres, self.max[1] + metres],
        }
    }

    /// The rectangle a hair smaller, so that an edge that rounding pushed past a grid line falls back onto it.
    pub(crate) fn shrunk_by_rounding(&self) -> Self {
        self.grown(-1e-9 * self.width().max(self.depth()))
    }

    /// The smallest rectangle around some points; `None` when there is none.
    pub fn around(points: impl IntoIterator<Item = [f64; 2]>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Self { min: first, max: first }, |b, p| Self {
            min: [b.min[0].min(p[0]), b.min[1].min(p[1])],
            max: [b.max[0].max(p[0]), b.max[1].max(p[1])],
        }))
    }

    /// East-west extent, in metres.
    pub fn width(&self) -> f64 {
        self.max[0] - self.min[0]
    }

    /// North-south extent, in metres.
    pub fn depth(&self) -> f64 {
        self.max[1] - self.min[1]
    }
}
