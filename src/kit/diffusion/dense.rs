//! The coarsest level, solved by its inverse.

use crate::kit::diffusion::level::{DIRECTIONS, Level, Pull};
use crate::kit::diffusion::split::Split;

/// The inverse of a small matrix, row by row.
#[derive(Debug, Default)]
pub(crate) struct Dense {
    inverse: Vec<f64>,
}

impl Dense {
    /// Inverts the matrix of a level. Equations that others make superfluous are dropped, their unknowns are 0.
    pub(crate) fn new(level: &Level) -> Self {
        let (cols, rows) = (level.cols, level.rows);
        let n = cols * rows;
        let mut a = vec![0.0f64; n * n];
        for k in 0..n {
            let (i, j) = (k % cols, k / cols);
            let plane = (i & 1) + 2 * (j & 1);
            let w = level.w[plane].row((j / 2) as isize, 0)[i / 2];
            if w <= 0.0 {
                continue;
            }
            a[k * n + k] = 1.0 / f64::from(w);
            for (d, &(dx, dy)) in DIRECTIONS.iter().enumerate().take(level.directions()) {
                let (x, y) = (i as isize + dx, j as isize + dy);
                if x < 0 || y < 0 || x >= cols as isize || y >= rows as isize {
                    continue;
                }
                let (x, y) = (x as usize, y as usize);
                let other = level.w[(x & 1) + 2 * (y & 1)].row((y / 2) as isize, 0)[x / 2];
                let pull = match &level.pull {
                    Pull::Unit => 1.0,
                    _ => level.pulls(d, plane, (j / 2) as isize)[i / 2],
                };
                if other > 0.0 {
                    a[k * n + y * cols + x] -= f64::from(pull);
                }
            }
        }
        Self { inverse: invert(a, n) }
    }

    /// Fills `u` with the solution for the right side `b`.
    pub(crate) fn solve(&self, level: &Level, b: &Split, u: &mut Split) {
        let (cols, n) = (level.cols, level.cols * level.rows);
        let right: Vec<f64> = (0..n)
            .map(|k| {
                let (i, j) = (k % cols, k / cols);
                f64::from(b[(i & 1) + 2 * (j & 1)].row((j / 2) as isize, 0)[i / 2])
            })
            .collect();
        for (k, row) in self.inverse.chunks_exact(n.max(1)).enumerate() {
            let (i, j) = (k % cols, k / cols);
            let sum: f64 = row.iter().zip(&right).map(|(a, b)| a * b).sum();
            u[(i & 1) + 2 * (j & 1)].row_mut(j / 2)[i / 2] = sum as f32;
        }
    }
}

/// Gauss-Jordan elimination on the diagonal: the equations are dominated by it.
pub(crate) fn invert(mut a: Vec<f64>, n: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; n * n];
    for k in 0..n {
        inverse[k * n + k] = 1.0;
    }
    let scale = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot.abs() <= scale * 1e-13 {
            for other in 0..n {
                (a[k * n + other], a[other * n + k], inverse[k * n + other]) = (0.0, 0.0, 0.0);
            }
            continue;
        }
        for c in 0..n {
            a[k * n + c] /= pivot;
            inverse[k * n + c] /= pivot;
        }
        for r in (0..n).filter(|&r| r != k) {
            let factor = a[r * n + k];
            if factor != 0.0 {
                for c in 0..n {
                    a[r * n + c] -= factor * a[k * n + c];
                    inverse[r * n + c] -= factor * inverse[k * n + c];
                }
            }
        }
    }
    inverse
}
