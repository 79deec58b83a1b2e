//! The largest rectangle without a void.

use super::Land;

/// Columns and rows of a part of some land: first, and one past the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub(super) cols: [usize; 2],
    pub(super) rows: [usize; 2],
}

impl Rectangle {
    pub(super) fn size(&self) -> [usize; 2] {
        [self.cols, self.rows].map(|[from, to]| to - from)
    }

    fn area(&self) -> usize {
        let [cols, rows] = self.size();
        cols * rows
    }

    /// The largest rectangle of land; of several, the one that ends first, row by row.
    ///
    /// Row by row, each column holds how much land lies above it without a gap. A stack of columns of rising heights
    /// finds the largest rectangle below such a skyline in one pass.
    pub(super) fn largest(land: &Land) -> Self {
        let mut above = vec![0usize; land.cols() + 1];
        let mut stack: Vec<(usize, usize)> = Vec::new();
        let mut best = Self::default();
        for j in 0..land.rows() {
            for (depth, z) in above.iter_mut().zip(land.row(j)) {
                *depth = if z.is_finite() { *depth + 1 } else { 0 };
            }
            // The last column is always 0 deep, so that the stack is empty after it.
            for (i, &depth) in above.iter().enumerate() {
                let mut first = i;
                while let Some(&(start, deeper)) = stack.last().filter(|(_, d)| *d >= depth) {
                    stack.pop();
                    first = start;
                    let found = Self { cols: [start, i], rows: [j + 1 - deeper, j + 1] };
                    if found.area() > best.area() {
                        best = found;
                    }
                }
                stack.push((first, depth));
            }
            stack.clear();
        }
        best
    }
}
