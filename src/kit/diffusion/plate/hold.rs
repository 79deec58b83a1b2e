//! The springs at known cells, on every level.

use rayon::prelude::*;

use crate::kit::diffusion::plate::axis::Axis;

/// Strength of a spring at a known cell: half of what stands on the diagonal of the bending.
pub(crate) const SPRING: f32 = 10.0;

/// The cells that a cell is tied to by springs: itself, east, south, south-east, south-west. The other four are read
/// at their cells.
const TIES: [(isize, isize); 5] = [(0, 0), (1, 0), (0, 1), (1, 1), (-1, 1)];

/// The matrix of the springs.
#[derive(Debug)]
pub(crate) enum Hold {
    /// Each known cell by itself.
    Own(Vec<f32>),
    /// Neighbours as well, in the order of [`TIES`].
    Nine([Vec<f32>; 5]),
}

impl Hold {
    /// What stands on the diagonal.
    pub(crate) fn own(&self) -> &[f32] {
        match self {
            Self::Own(own) | Self::Nine([own, ..]) => own,
        }
    }

    /// The product with bilinear interpolation on both sides.
    pub(crate) fn halved(&self, x: &Axis, y: &Axis) -> Self {
        let (cols, rows) = (x.halved().cells(), y.halved().cells());
        let mut out: [Vec<f32>; 5] = std::array::from_fn(|_| vec![0.0; cols * rows]);
        let [a, b, c, d, e] = out.each_mut().map(|v| v.par_chunks_mut(cols));
        a.zip(b).zip(c.zip(d)).zip(e).enumerate().for_each(|(j, (((a, b), (c, d)), e))| {
            let mut sums = vec![[0.0f64; 5]; cols];
            for (fine, share) in y.around(j) {
                self.gather(x, y, (fine, share), j, &mut sums);
            }
            for (i, sum) in sums.iter().enumerate() {
                [a[i], b[i], c[i], d[i], e[i]] = sum.map(|s| s as f32);
            }
        });
        Self::Nine(out)
    }

    /// Adds what the cells of a fine row give to the coarse row `j`, which has `share` in it.
    fn gather(&self, x: &Axis, y: &Axis, (fine, share): (usize, f64), j: usize, sums: &mut [[f64; 5]]) {
        let cols = x.cells();
        for i in 0..cols {
            if self.own()[fine * cols + i] == 0.0 {
                continue;
            }
            self.ties(cols, y.cells(), i, fine, |(i2, j2), pull| {
                for (to, row) in y.between(j2).into_iter().filter(|t| t.1 > 0.0) {
                    for (to_x, col) in x.between(i2).into_iter().filter(|t| t.1 > 0.0) {
                        for (c, own) in x.between(i).into_iter().filter(|t| t.1 > 0.0) {
                            let (dx, dy) = (to_x as isize - c as isize, to as isize - j as isize);
                            if let Some(k) = TIES.iter().position(|&t| t == (dx, dy)) {
                                sums[c][k] += f64::from(pull) * (own * share) * (col * row);
                            }
                        }
                    }
                }
            });
        }
    }

    /// Calls `f` with each cell that a cell is tied to, and how strongly.
    fn ties(&self, cols: usize, rows: usize, i: usize, j: usize, mut f: impl FnMut((usize, usize), f32)) {
        let at = j * cols + i;
        let nine = match self {
            Self::Own(own) => return f((i, j), own[at]),
            Self::Nine(nine) => nine,
        };
        for ((dx, dy), pulls) in TIES.into_iter().zip(nine) {
            let inside = |x: isize, y: isize| x >= 0 && x < cols as isize && y >= 0 && y < rows as isize;
            let (x, y) = (i as isize + dx, j as isize + dy);
            if inside(x, y) {
                f((x as usize, y as usize), pulls[at]);
            }
            let (x, y) = (i as isize - dx, j as isize - dy);
            if (dx, dy) != (0, 0) && inside(x, y) {
                let (x, y) = (x as usize, y as usize);
                f((x, y), pulls[y * cols + x]);
            }
        }
    }

    /// Takes the springs' part of row `j` of the product with `u` off `out`.
    #[inline(always)]
    pub(crate) fn subtract(&self, u: &[f64], j: usize, out: &mut [f64]) {
        let n = out.len();
        let row = |v: usize| v * n..(v + 1) * n;
        let here = &u[row(j)];
        let nine = match self {
            Self::Own(own) => return take(&own[row(j)], here, out),
            Self::Nine(nine) => nine.each_ref(),
        };
        let [own, east, south, south_east, south_west] = nine;
        take(&own[row(j)], here, out);
        let tie = &east[row(j)][..n - 1];
        take(tie, &here[1..], &mut out[..n - 1]);
        take(tie, &here[..n - 1], &mut out[1..]);
        if let Some(below) = u.get(row(j + 1)) {
            take(&south[row(j)], below, out);
            take(&south_east[row(j)][..n - 1], &below[1..], &mut out[..n - 1]);
            take(&south_west[row(j)][1..], &below[..n - 1], &mut out[1..]);
        }
        if j > 0 {
            let above = &u[row(j - 1)];
            take(&south[row(j - 1)], above, out);
            take(&south_east[row(j - 1)][..n - 1], &above[..n - 1], &mut out[1..]);
            take(&south_west[row(j - 1)][1..], &above[1..], &mut out[..n - 1]);
        }
    }
}

/// `out -= a u`.
#[inline(always)]
fn take(a: &[f32], u: &[f64], out: &mut [f64]) {
    for ((o, &a), &u) in out.iter_mut().zip(a).zip(u) {
        *o -= f64::from(a) * u;
    }
}
