//! One level of the multigrid: its equations, and sweeps over them.

use crate::kit::diffusion::split::{Combine, Dot, Plane, Split, neighbour, reduce, zeros};
use crate::kit::simd::{Kernel, Level as Simd};

/// The eight neighbours, the four nearest first.
pub(crate) const DIRECTIONS: [(isize, isize); 8] =
    [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
/// The direction back.
pub(crate) const BACK: [usize; 8] = [1, 0, 3, 2, 7, 6, 5, 4];
/// Where a symmetric level keeps each direction; the others are read at the neighbour.
pub(crate) const KEPT: [Option<usize>; 8] = [None, Some(0), None, Some(1), None, None, Some(2), Some(3)];
/// The order in which a sweep visits the planes: red (both even, both odd), then black. The sweep after the coarse
/// correction goes the other way round, so that the cycle is symmetric.
pub(crate) const ORDER: [usize; 4] = [0, 3, 1, 2];

/// How much each neighbour pulls at a cell. A cell that is held pulls and is pulled by 0.
#[derive(Debug)]
pub(crate) enum Pull {
    /// By 1 between free cells.
    Unit,
    /// One vector for each of the first four or all eight directions.
    Each(Vec<Split>),
    /// The same both ways: the four directions of [`KEPT`].
    Symmetric(Vec<Split>),
}

/// The equation `u / w - Σ pull · neighbour = b` of every cell, with `u`, `w` zero where it is held.
#[derive(Debug)]
pub(crate) struct Level {
    pub(crate) cols: usize,
    pub(crate) rows: usize,
    pub(crate) pull: Pull,
    pub(crate) w: Split,
    /// What stands on the diagonal beside the pulls: needed until the next level is made.
    pub(crate) excess: Option<Split>,
    /// Weights of the interpolation: x-edges from west and east, y-edges from north and south, centres from
    /// north-west, north-east, south-west, south-east.
    pub(crate) up: Vec<Plane>,
    /// Weights of the restriction where they are not those of the interpolation.
    pub(crate) down: Option<Vec<Plane>>,
    pub(crate) b: Split,
    pub(crate) u: Split,
}

/// What a sweep makes of the sum of the neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Make {
    /// The value that solves the cell's equation.
    Relaxed,
    /// The sum, on free cells.
    Sum,
    /// The equation's left side.
    Applied,
}

impl Level {
    pub(crate) fn new(cols: usize, rows: usize, pull: Pull, w: Split, excess: Option<Split>) -> Self {
        let (b, u) = (zeros(cols, rows), zeros(cols, rows));
        Self { cols, rows, pull, w, excess, up: Vec::new(), down: None, b, u }
    }

    /// Number of neighbours that pull.
    pub(crate) fn directions(&self) -> usize {
        match &self.pull {
            Pull::Unit => 4,
            Pull::Each(a) => a.len(),
            Pull::Symmetric(_) => 8,
        }
    }

    /// The pulls in direction `d` on row `j` of a plane, moved by `shift`; none where all are 1.
    #[inline(always)]
    pub(crate) fn pulls(&self, d: usize, plane: usize, j: isize) -> &[f32] {
        match &self.pull {
            Pull::Unit => &[],
            Pull::Each(a) => a[d][plane].row(j, 0),
            Pull::Symmetric(a) => match KEPT[d] {
                Some(k) => a[k][plane].row(j, 0),
                None => {
                    let (q, dj, di) = neighbour(plane, DIRECTIONS[d].0, DIRECTIONS[d].1);
                    // KEPT has an entry for one of each pair of directions.
                    a[KEPT[BACK[d]].unwrap_or(0)][q].row(j + dj, di)
                }
            },
        }
    }

    /// Fills row `j` of a plane from the neighbours in the planes that `from` names.
    #[allow(
        clippy::too_many_arguments,
        reason = "what, where, from what, to what; a struct would only rename them"
    )]
    pub(crate) fn row(
        &self,
        simd: Simd,
        make: Make,
        plane: usize,
        j: usize,
        from: [bool; 4],
        (b, u): (&Split, &Split),
        out: &mut [f32],
    ) {
        let j = j as isize;
        let w = self.w[plane].row(j, 0);
        let mut terms: [(&[f32], &[f32]); 8] = [(&[], &[]); 8];
        let mut n = 0;
        for (d, &(dx, dy)) in DIRECTIONS.iter().enumerate().take(self.directions()) {
            let (q, dj, di) = neighbour(plane, dx, dy);
            if from[q] {
                terms[n] = (self.pulls(d, plane, j), u[q].row(j + dj, di));
                n += 1;
            }
        }
        // The planes come in pairs of directions, so the number is even.
        let row = Row { make, w, b: b[plane].row(j, 0), own: u[plane].get_row(j), out };
        match (matches!(self.pull, Pull::Unit), n) {
            (_, 0) => simd.run(Terms::<0, true> { row, terms: [(&[], &[]); 0] }),
            (true, 2) => simd.run(Terms::<2, true> { row, terms: first(&terms) }),
            (true, _) => simd.run(Terms::<4, true> { row, terms: first(&terms) }),
            (false, 2) => simd.run(Terms::<2, false> { row, terms: first(&terms) }),
            (false, 4) => simd.run(Terms::<4, false> { row, terms: first(&terms) }),
            (false, 6) => simd.run(Terms::<6, false> { row, terms: first(&terms) }),
            (false, _) => simd.run(Terms::<8, false> { row, terms }),
        }
    }

    /// Relaxes a plane of `u` once.
    pub(crate) fn relax(&self, simd: Simd, plane: usize, from: [bool; 4], b: &Split, u: &mut Split) {
        let mut out = std::mem::take(&mut u[plane]);
        let read = &*u;
        out.each_row(|j, row| self.row(simd, Make::Relaxed, plane, j, from, (b, read), row));
        u[plane] = out;
    }

    /// `u · A u`.
    pub(crate) fn energy(&self, simd: Simd, u: &Split) -> f64 {
        let rows = reduce(u, |plane, j| {
            let own = u[plane].row(j, 0);
            let mut row = vec![0.0; own.len()];
            self.row(simd, Make::Applied, plane, j as usize, [true; 4], (u, u), &mut row);
            let mut sum = 0.0;
            simd.run(Dot { a: own, b: &row, sum: &mut sum });
            sum
        });
        rows.iter().sum()
    }

    /// `out += a A u`.
    pub(crate) fn add_applied(&self, simd: Simd, a: f32, u: &Split, out: &mut Split) {
        for (plane, out) in out.iter_mut().enumerate() {
            out.each_row(|j, out| {
                let mut row = vec![0.0; out.len()];
                self.row(simd, Make::Applied, plane, j, [true; 4], (u, u), &mut row);
                simd.run(Combine { a, x: &row, b: 1.0, y: out });
            });
        }
    }

    /// `out = A u`.
    pub(crate) fn apply(&self, simd: Simd, u: &Split, out: &mut Split) {
        for (plane, out) in out.iter_mut().enumerate() {
            out.each_row(|j, row| self.row(simd, Make::Applied, plane, j, [true; 4], (u, u), row));
        }
    }
}

impl Plane {
    /// Row `j`, or nothing while the plane is being written.
    fn get_row(&self, j: isize) -> &[f32] {
        if self.cols == 0 { &[] } else { self.row(j, 0) }
    }
}

fn first<'a, const N: usize>(terms: &[(&'a [f32], &'a [f32]); 8]) -> [(&'a [f32], &'a [f32]); N] {
    std::array::from_fn(|k| terms[k])
}

struct Row<'a> {
    make: Make,
    w: &'a [f32],
    b: &'a [f32],
    own: &'a [f32],
    out: &'a mut [f32],
}

struct Terms<'a, const N: usize, const UNIT: bool> {
    row: Row<'a>,
    terms: [(&'a [f32], &'a [f32]); N],
}

impl<const N: usize, const UNIT: bool> Kernel for Terms<'_, N, UNIT> {
    #[inline(always)]
    fn run(self) {
        let Row { make, w, b, own, out } = self.row;
        let n = out.len();
        let w = &w[..n];
        let terms = self.terms.map(|(a, u)| (if UNIT { a } else { &a[..n] }, &u[..n]));
        match make {
            Make::Relaxed => {
                let b = &b[..n];
                for i in 0..n {
                    out[i] = w[i] * (b[i] + total::<N, UNIT>(&terms, i));
                }
            }
            Make::Sum => {
                for i in 0..n {
                    let sum = total::<N, UNIT>(&terms, i);
                    out[i] = if w[i] > 0.0 { sum } else { 0.0 };
                }
            }
            Make::Applied => {
                let own = &own[..n];
                for i in 0..n {
                    let left = own[i] / w[i] - total::<N, UNIT>(&terms, i);
                    out[i] = if w[i] > 0.0 { left } else { 0.0 };
                }
            }
        }
    }
}

/// The sum of what the neighbours of cell `i` pull.
#[inline(always)]
fn total<const N: usize, const UNIT: bool>(terms: &[(&[f32], &[f32]); N], i: usize) -> f32 {
    let mut sum = 0.0;
    for (a, u) in terms {
        sum += if UNIT { u[i] } else { a[i] * u[i] };
    }
    sum
}
