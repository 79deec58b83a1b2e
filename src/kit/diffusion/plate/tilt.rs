//! What known cells leave open: nothing, the tilt across a line, or all tilt.

/// A straight line of known cells through whole coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Line {
    at: (i64, i64),
    along: (i64, i64),
}

/// How the known cells lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    Nowhere,
    /// One cell.
    Lone(usize),
    /// All on a line, beside which the grid has cells: the farthest of them, and its distance in an unit that
    /// [`Layout::beside`] shares.
    Aligned(Across),
    /// All tilt is decided.
    Spread,
}

/// A function that is 0 on a line and rises evenly across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Across {
    line: Line,
    cols: usize,
    /// The cell where it is largest.
    pub(crate) far: usize,
}

impl Across {
    /// The value at a cell.
    pub(crate) fn at(&self, cell: usize) -> i64 {
        let Line { at, along } = self.line;
        let (x, y) = ((cell % self.cols) as i64 - at.0, (cell / self.cols) as i64 - at.1);
        x * along.1 - y * along.0
    }

    /// The change from a column or row to the next.
    pub(crate) fn slope(&self) -> (f64, f64) {
        (self.line.along.1 as f64, -self.line.along.0 as f64)
    }
}

/// How the known cells of a grid lie, in row order.
pub(crate) fn layout(cols: usize, rows: usize, known: impl Iterator<Item = usize>) -> Layout {
    let mut known = known;
    let Some(first) = known.next() else { return Layout::Nowhere };
    let Some(second) = known.next() else { return Layout::Lone(first) };
    let place = |cell: usize| ((cell % cols) as i64, (cell / cols) as i64);
    let ((x, y), (x2, y2)) = (place(first), place(second));
    let mut across = Across { line: Line { at: (x, y), along: (x2 - x, y2 - y) }, cols, far: first };
    if known.any(|cell| across.at(cell) != 0) {
        return Layout::Spread;
    }
    let corners = [0, cols - 1, (rows - 1) * cols, rows * cols - 1];
    across.far = corners.into_iter().max_by_key(|&c| across.at(c).abs()).unwrap_or(0);
    if across.at(across.far) == 0 { Layout::Spread } else { Layout::Aligned(across) }
}
