//! Where links lie, so that those near a place are found without looking at all.

use crate::kit::predicates::Point;
use crate::value::Bounds;

/// No further entry.
const END: u32 = u32::MAX;
/// Most cells of a grid.
const MAX_CELLS: usize = 1 << 24;

/// Links by the squares that they lie in. A link that moves is put in again; where it was it stays, so whoever asks looks
/// at the place that it has now.
#[derive(Clone, Debug)]
pub struct LinkGrid {
    min: Point,
    per_cell: f64,
    cols: usize,
    rows: usize,
    heads: Vec<u32>,
    /// A link, and the next entry of the cell.
    entries: Vec<[u32; 2]>,
}

impl LinkGrid {
    /// No links, in squares of about a size, on a rectangle; in larger ones where so many links need no more. What lies
    /// outside is put into the squares on its border.
    pub fn new(bounds: Bounds, cell: f64, links: usize) -> Self {
        let (width, depth) = (bounds.width().max(1e-6), bounds.depth().max(1e-6));
        let most = (16 * links + 1024).min(MAX_CELLS) as f64;
        // Of a strip a square may not be smaller than its share of the length.
        let cell = cell.max(libm::sqrt(width * depth / most)).max(width.max(depth) / most);
        let [cols, rows] = [width, depth].map(|extent| (libm::ceil(extent / cell) as usize).max(1));
        let heads = vec![END; cols * rows];
        Self { min: bounds.min, per_cell: 1.0 / cell, cols, rows, heads, entries: Vec::new() }
    }

    /// The column of x or the row of y.
    fn index(&self, axis: usize, at: f64) -> usize {
        let last = [self.cols, self.rows][axis] - 1;
        // Below zero and beyond the last square the cast and `min` stop it.
        (((at - self.min[axis]) * self.per_cell) as usize).min(last)
    }

    /// Puts a link in.
    pub fn put(&mut self, link: u32, [a, b]: [Point; 2]) {
        let [top, bottom] = [a[1].min(b[1]), a[1].max(b[1])];
        let [first, last] = [self.index(1, top), self.index(1, bottom)];
        for row in first..=last {
            let [from, to] = self.columns_in_row(row, first == last, [a, b]);
            for cell in row * self.cols + from..=row * self.cols + to {
                self.entries.push([link, self.heads[cell]]);
                self.heads[cell] = self.entries.len() as u32 - 1;
            }
        }
    }

    /// The first and last column of a link in a row of squares.
    fn columns_in_row(&self, row: usize, is_only: bool, [a, b]: [Point; 2]) -> [usize; 2] {
        let [mut left, mut right] = [a[0].min(b[0]), a[0].max(b[0])];
        if !is_only {
            // A hair more than the row, since rounding may put its border on either side. Rows at the border reach on.
            let edge = |row: f64| self.min[1] + row / self.per_cell;
            let over = if row == 0 { f64::NEG_INFINITY } else { edge(row as f64 - 1e-6) };
            let under = if row + 1 == self.rows { f64::INFINITY } else { edge(row as f64 + 1.0 + 1e-6) };
            let x_at = |y: f64| a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0);
            let [from, to] = [x_at(over.max(a[1].min(b[1]))), x_at(under.min(a[1].max(b[1])))];
            (left, right) = (left.max(from.min(to)), right.min(from.max(to)));
        }
        [self.index(0, left), self.index(0, right)]
    }

    /// Collects the links whose squares a rectangle touches, each once, in the order of their numbers.
    pub fn collect(&self, around: Bounds, links: &mut Vec<u32>) {
        links.clear();
        let [left, right] = [around.min[0], around.max[0]].map(|x| self.index(0, x));
        let [top, bottom] = [around.min[1], around.max[1]].map(|y| self.index(1, y));
        for row in top..=bottom {
            for cell in row * self.cols + left..=row * self.cols + right {
                let mut entry = self.heads[cell];
                while entry != END {
                    let [link, next] = self.entries[entry as usize];
                    links.push(link);
                    entry = next;
                }
            }
        }
        links.sort_unstable();
        links.dedup();
    }
}
