//! Straight pieces of rivers and ridges, and the cells that they cross.

use crate::value::Grid;

/// A straight piece of a river or ridge: its height falls or rises evenly from end to end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its ends, in metres, x east and y south.
    pub ends: [[f64; 2]; 2],
    /// The heights of its ends, in metres.
    pub heights: [f64; 2],
}

/// A piece of a river or ridge as it is carved and drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideLine {
    /// Where it lies. Of a river the lower end stands first.
    pub line: Line,
    /// Its width, in metres.
    pub width: f64,
    /// Strahler order, from 1.
    pub order: u8,
}

impl Line {
    /// Whether all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.ends.iter().flatten().chain(&self.heights).all(|x| x.is_finite())
    }

    /// Calls `f` with the index and the height of every sample of a grid that the line crosses, by Bresenham's rule between
    /// the samples nearest to its ends: of each column of a flat line, or row of a steep one, the nearest sample
    /// \[bresenham1965\]. Lines that share an end share its sample, so a chain of them has no gap.
    pub(super) fn walk(&self, grid: &Grid, mut f: impl FnMut(usize, f32)) {
        let Some(Clipped { ends: [a, b], shares: [from, to] }) = self.clipped(grid) else { return };
        let nearest = |p: [f64; 2]| p.map(|x| x.round() as i64);
        let ([i, j], [i_end, j_end]) = (nearest(a), nearest(b));
        let (di, dj) = (i_end - i, j_end - j);
        let steps = di.abs().max(dj.abs());
        let (cols, rows) = (grid.cols as i64, grid.rows as i64);
        let [low, high] = self.heights;
        let mut put = |i: i64, j: i64, share: f64| {
            if (0..cols).contains(&i) && (0..rows).contains(&j) {
                f((j * cols + i) as usize, (low + share * (high - low)) as f32);
            }
        };
        if steps == 0 {
            // Both ends count, so that the lowest and the highest of a sample do not hang on the direction.
            put(i, j, from);
            put(i, j, to);
            return;
        }
        let (mut x, mut y) = (Coordinate::new(i, di, steps), Coordinate::new(j, dj, steps));
        for step in 0..=steps {
            let share = from + (to - from) * (step as f64 / steps as f64);
            put(x.next(), y.next(), share);
        }
    }

    /// The part of the line within two cells of a grid, in steps from its first sample; none where there is none. An end
    /// that lies there stays as it is.
    fn clipped(&self, grid: &Grid) -> Option<Clipped> {
        if !self.is_finite() {
            return None;
        }
        let first = [grid.col as f64, grid.row as f64];
        let place = |[x, y]: [f64; 2]| {
            let [u, v] = grid.lattice.steps(x, y);
            [u - first[0], v - first[1]]
        };
        let [a, b] = self.ends.map(place);
        if a.iter().chain(&b).any(|x| !x.is_finite()) {
            return None;
        }
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (axis, count) in [grid.cols, grid.rows].into_iter().enumerate() {
            let (start, step) = (a[axis], b[axis] - a[axis]);
            let sides = [-2.0, count as f64 + 1.0];
            if step == 0.0 {
                if !(sides[0]..=sides[1]).contains(&start) {
                    return None;
                }
                continue;
            }
            let [s, t] = sides.map(|side| (side - start) / step);
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        }
        // Ends that lie very far off leave few digits to what is near.
        let most = [grid.cols, grid.rows].map(|count| count as f64 + 1.0);
        let at = |share: f64| {
            [0, 1].map(|axis: usize| (a[axis] + share * (b[axis] - a[axis])).clamp(-2.0, most[axis]))
        };
        let ends = [if from == 0.0 { a } else { at(from) }, if to == 1.0 { b } else { at(to) }];
        (from <= to).then_some(Clipped { ends, shares: [from, to] })
    }
}

/// One coordinate of a walk of so many steps: the whole number nearest to `start + step · d / steps`, the larger of two,
/// without a division for a step.
struct Coordinate {
    at: i64,
    /// The numerator that `at` leaves over `2 · steps`.
    rest: i64,
    step: i64,
    whole: i64,
}

impl Coordinate {
    /// A coordinate from `start` to `start + d`, with `d` at most `steps` from 0.
    fn new(start: i64, d: i64, steps: i64) -> Self {
        Self { at: start, rest: steps, step: 2 * d, whole: 2 * steps }
    }

    /// The coordinate, and on to the next step.
    fn next(&mut self) -> i64 {
        let at = self.at;
        self.rest += self.step;
        if self.rest >= self.whole {
            (self.at, self.rest) = (self.at + 1, self.rest - self.whole);
        } else if self.rest < 0 {
            (self.at, self.rest) = (self.at - 1, self.rest + self.whole);
        }
        at
    }
}

/// A part of a line: its ends in steps of a grid, and where on the line they are, from 0 to 1.
struct Clipped {
    ends: [[f64; 2]; 2],
    shares: [f64; 2],
}
