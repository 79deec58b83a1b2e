//! Vectors of a grid kept in four planes by the parity of column and row.
//!
//! Cell (i, j) lies in plane `(i & 1) + 2 (j & 1)` at (i / 2, j / 2). Cells of one colour of a Gauss-Seidel sweep,
//! and the cells that a coarse level keeps, then lie side by side, and one plane can be written while the others are
//! read. All planes have the size of the even one; cells that an odd one lacks are held at zero.

use rayon::prelude::*;

use crate::kit::simd::{Kernel, Level, larger};

/// Cells below which a plane is worked on by one thread.
const ALONE: usize = 1 << 13;
/// Cells that one job takes.
const JOB: usize = 1 << 14;
/// Lanes of a sum: blocks of fixed size in fixed order, whatever the instruction set.
const LANES: usize = 16;

/// A plane with one line of zeros all around.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plane {
    pub(crate) cols: usize,
    pub(crate) rows: usize,
    data: Vec<f32>,
}

impl Plane {
    pub(crate) fn new(cols: usize, rows: usize) -> Self {
        Self { cols, rows, data: vec![0.0; (cols + 2) * (rows + 2)] }
    }

    pub(crate) fn stride(&self) -> usize {
        self.cols + 2
    }

    /// Row `j`, from -1 to `rows`, moved by `shift` columns, from -1 to 1.
    #[inline(always)]
    pub(crate) fn row(&self, j: isize, shift: isize) -> &[f32] {
        let at = ((j + 1) * self.stride() as isize + 1 + shift) as usize;
        &self.data[at..at + self.cols]
    }

    /// Row `j` with the zero before and the zero after it.
    pub(crate) fn padded(&self, j: isize) -> &[f32] {
        let at = (j + 1) as usize * self.stride();
        &self.data[at..at + self.stride()]
    }

    pub(crate) fn row_mut(&mut self, j: usize) -> &mut [f32] {
        let at = (j + 1) * self.stride() + 1;
        &mut self.data[at..at + self.cols]
    }

    /// Calls `f` with each row and its number.
    pub(crate) fn each_row(&mut self, f: impl Fn(usize, &mut [f32]) + Sync) {
        let cols = self.cols;
        bands(&mut [self], |first, pieces| {
            for (k, row) in pieces[0].chunks_exact_mut(cols + 2).enumerate() {
                f(first + k, &mut row[1..=cols]);
            }
        });
    }
}

/// Calls `f` with bands of rows of several planes of one size: the number of the first row, and the band's rows in
/// each plane, [`Plane::stride`] apart.
pub(crate) fn bands(planes: &mut [&mut Plane], f: impl Fn(usize, &mut [&mut [f32]]) + Sync) {
    let Some(first) = planes.first() else { return };
    let (stride, cells) = (first.stride(), first.cols * first.rows);
    let band = if cells < ALONE { first.rows.max(1) } else { JOB / stride + 1 };
    let mut jobs: Vec<Vec<&mut [f32]>> = Vec::new();
    for plane in planes {
        let end = plane.data.len() - stride;
        for (b, piece) in plane.data[stride..end].chunks_mut(stride * band).enumerate() {
            if b == jobs.len() {
                jobs.push(Vec::new());
            }
            jobs[b].push(piece);
        }
    }
    if cells < ALONE {
        jobs.iter_mut().enumerate().for_each(|(b, pieces)| f(b * band, pieces));
    } else {
        jobs.par_iter_mut().enumerate().for_each(|(b, pieces)| f(b * band, pieces));
    }
}

/// A vector in four planes.
pub(crate) type Split = [Plane; 4];

/// A vector of zeros for a grid.
pub(crate) fn zeros(cols: usize, rows: usize) -> Split {
    std::array::from_fn(|_| Plane::new(cols.div_ceil(2), rows.div_ceil(2)))
}

/// Number of a plane, row and column shift of the neighbour in direction (`dx`, `dy`) of the cells of a plane.
#[inline(always)]
pub(crate) fn neighbour(plane: usize, dx: isize, dy: isize) -> (usize, isize, isize) {
    let (x, y) = ((plane & 1) as isize + dx, (plane >> 1) as isize + dy);
    ((x & 1) as usize + 2 * (y & 1) as usize, y >> 1, x >> 1)
}

/// `a · b` in `f64`.
pub(crate) fn dot(level: Level, a: &Split, b: &Split) -> f64 {
    let rows = reduce(a, |p, j| {
        let mut sum = 0.0;
        level.run(Dot { a: a[p].row(j, 0), b: b[p].row(j, 0), sum: &mut sum });
        sum
    });
    rows.iter().sum()
}

/// `a · b`, and the largest size of an element of `b`.
pub(crate) fn measure(level: Level, a: &Split, b: &Split) -> (f64, f64) {
    let rows = reduce(b, |p, j| {
        let (mut sum, mut found) = (0.0, 0.0);
        let b = b[p].row(j, 0);
        level.run(Dot { a: a[p].row(j, 0), b, sum: &mut sum });
        level.run(Largest { a: b, found: &mut found });
        (sum, f64::from(found))
    });
    rows.iter().fold((0.0, 0.0), |(sum, most): (f64, f64), r| (sum + r.0, most.max(r.1)))
}

/// What `f` finds in each row of each plane, in order.
pub(crate) fn reduce<T: Send>(a: &Split, f: impl Fn(usize, isize) -> T + Sync) -> Vec<T> {
    let rows = a[0].rows;
    let one = |k: usize| f(k / rows.max(1), (k % rows.max(1)) as isize);
    let grain = JOB / a[0].stride() + 1;
    if a[0].cols * rows < ALONE {
        (0..4 * rows).map(one).collect()
    } else {
        (0..4 * rows).into_par_iter().with_min_len(grain).map(one).collect()
    }
}

/// `y = a x + b y`.
pub(crate) fn combine(level: Level, a: f32, x: &Split, b: f32, y: &mut Split) {
    for (x, y) in x.iter().zip(y) {
        y.each_row(|j, y| level.run(Combine { a, x: x.row(j as isize, 0), b, y }));
    }
}

/// The sum of products, in fixed blocks.
pub(crate) struct Dot<'a> {
    pub(crate) a: &'a [f32],
    pub(crate) b: &'a [f32],
    pub(crate) sum: &'a mut f64,
}

impl Kernel for Dot<'_> {
    #[inline(always)]
    fn run(self) {
        let mut sums = [0.0f64; LANES];
        let (a, b) = (self.a.chunks_exact(LANES), self.b.chunks_exact(LANES));
        for (k, (&a, &b)) in a.remainder().iter().zip(b.remainder()).enumerate() {
            sums[k] += f64::from(a) * f64::from(b);
        }
        for (a, b) in a.zip(b) {
            for k in 0..LANES {
                sums[k] += f64::from(a[k]) * f64::from(b[k]);
            }
        }
        *self.sum = sums.iter().sum();
    }
}

struct Largest<'a> {
    a: &'a [f32],
    found: &'a mut f32,
}

impl Kernel for Largest<'_> {
    #[inline(always)]
    fn run(self) {
        let mut most = [0.0f32; LANES];
        let a = self.a.chunks_exact(LANES);
        for (k, &a) in a.remainder().iter().enumerate() {
            most[k] = larger(most[k], a.abs());
        }
        for a in a {
            for k in 0..LANES {
                most[k] = larger(most[k], a[k].abs());
            }
        }
        *self.found = most.into_iter().fold(0.0, larger);
    }
}

/// `e += alpha p`, then `p = z + beta p`.
pub(crate) fn advance(level: Level, alpha: f32, e: &mut Split, z: &Split, beta: f32, p: &mut Split) {
    for ((e, z), p) in e.iter_mut().zip(z).zip(p) {
        let stride = e.stride();
        bands(&mut [e, p], |first, pieces| {
            let [e, p] = pieces else { return };
            for (k, (e, p)) in e.chunks_exact_mut(stride).zip(p.chunks_exact_mut(stride)).enumerate() {
                let z = z.row((first + k) as isize, 0);
                let n = z.len();
                level.run(Advance { alpha, e: &mut e[1..=n], z, beta, p: &mut p[1..=n] });
            }
        });
    }
}

struct Advance<'a> {
    alpha: f32,
    e: &'a mut [f32],
    z: &'a [f32],
    beta: f32,
    p: &'a mut [f32],
}

impl Kernel for Advance<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.z.len();
        let (e, z, p) = (&mut self.e[..n], &self.z[..n], &mut self.p[..n]);
        for i in 0..n {
            e[i] += self.alpha * p[i];
            p[i] = z[i] + self.beta * p[i];
        }
    }
}

/// `y = a x + b y` on a row.
pub(crate) struct Combine<'a> {
    pub(crate) a: f32,
    pub(crate) x: &'a [f32],
    pub(crate) b: f32,
    pub(crate) y: &'a mut [f32],
}

impl Kernel for Combine<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.y.len();
        let (x, y) = (&self.x[..n], &mut self.y[..n]);
        for i in 0..n {
            y[i] = self.a * x[i] + self.b * y[i];
        }
    }
}

/// Two planes' rows from a row of a grid.
pub(crate) struct Deal<'a> {
    pub(crate) line: &'a [f32],
    pub(crate) even: &'a mut [f32],
    pub(crate) odd: &'a mut [f32],
}

impl Kernel for Deal<'_> {
    #[inline(always)]
    fn run(self) {
        let pairs = self.line.len() / 2;
        let (even, odd) = (&mut self.even[..self.line.len() - pairs], &mut self.odd[..pairs]);
        for (k, pair) in self.line.chunks_exact(2).enumerate() {
            even[k] = pair[0];
            odd[k] = pair[1];
        }
        if even.len() > pairs {
            even[pairs] = self.line[2 * pairs];
        }
    }
}

/// A row of a grid from two planes' rows.
pub(crate) struct Merge<'a> {
    pub(crate) even: &'a [f32],
    pub(crate) odd: &'a [f32],
    pub(crate) line: &'a mut [f32],
}

impl Kernel for Merge<'_> {
    #[inline(always)]
    fn run(self) {
        let pairs = self.line.len() / 2;
        let (even, odd) = (&self.even[..self.line.len() - pairs], &self.odd[..pairs]);
        if even.len() > pairs {
            self.line[2 * pairs] = even[pairs];
        }
        for (k, pair) in self.line.chunks_exact_mut(2).enumerate() {
            pair[0] = even[k];
            pair[1] = odd[k];
        }
    }
}
