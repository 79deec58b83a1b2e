//! The V-cycle over all levels of the plate, the preconditioner of the iterations.

use crate::kit::diffusion::dense::invert;
use crate::kit::diffusion::plate::axis::Axis;
use crate::kit::diffusion::plate::hold::Hold;
use crate::kit::diffusion::plate::level::{Level, each_row};
use crate::kit::simd::Level as Simd;
use crate::work::{Cancelled, Work};

/// Steps of the smoother on the finest level, before the coarse correction and after it.
const STEPS: usize = 3;
/// By how much more coarse levels are smoothed, at most.
const MORE: usize = 16;
/// Cells up to which a level is solved by its inverse.
const DENSE: usize = 64;

/// All levels, the finest first, and the inverse of the coarsest, row by row.
pub(crate) struct Multigrid {
    pub(crate) levels: Vec<Level>,
    inverse: Vec<f64>,
    simd: Simd,
}

impl Multigrid {
    /// Makes all levels; `springs` are those of the known cells.
    pub(crate) fn new(
        cols: usize,
        rows: usize,
        springs: Vec<f32>,
        simd: Simd,
        work: &Work<'_>,
    ) -> Result<Self, Cancelled> {
        let (x, y) = (Axis::new(cols, 1.0), Axis::new(rows, 1.0));
        let mut last = Level::new(x, y, Hold::Own(springs), true);
        let mut levels = Vec::new();
        while last.u.len() > DENSE && (last.x.halves() || last.y.halves()) {
            work.check()?;
            let next = last.halved();
            levels.push(std::mem::replace(&mut last, next));
        }
        let inverse = inverse(&last, simd);
        levels.push(last);
        Ok(Self { levels, inverse, simd })
    }

    /// Fills the finest level's `u` with an approximate solution for the right side `b`. Linear, symmetric and
    /// positive.
    pub(crate) fn cycle(&mut self, b: &[f64]) {
        let mut levels = std::mem::take(&mut self.levels);
        self.descend(&mut levels, 0, Some(b));
        self.levels = levels;
    }

    fn descend(&self, levels: &mut [Level], depth: usize, finest: Option<&[f64]>) {
        let Some((level, below)) = levels.split_first_mut() else { return };
        let own = std::mem::take(&mut level.b);
        let b = finest.unwrap_or(&own);
        if let Some(next) = below.first_mut() {
            let steps = STEPS * MORE.min(1 << depth.min(16));
            level.u.fill(0.0);
            level.r.copy_from_slice(b);
            level.smooth(self.simd, steps, true);
            restrict(level, next);
            self.descend(below, depth + 1, None);
            prolong(&below[0], level);
            level.start(self.simd, b);
            level.smooth(self.simd, steps, false);
        } else {
            let rows = self.inverse.chunks_exact(b.len().max(1));
            level
                .u
                .iter_mut()
                .zip(rows)
                .for_each(|(u, row)| *u = row.iter().zip(b).map(|(a, b)| a * b).sum());
        }
        level.b = own;
    }
}

/// The right side of the next level: the residual, weighted as by bilinear interpolation.
fn restrict(level: &Level, next: &mut Level) {
    let (cols, coarse) = (level.x.cells(), next.x.cells());
    each_row(coarse, &mut next.b, |j, out| {
        let mut sum = vec![0.0; cols];
        for (row, share) in level.y.around(j) {
            let row = &level.r[row * cols..(row + 1) * cols];
            sum.iter_mut().zip(row).for_each(|(s, r)| *s += share * r);
        }
        for (i, o) in out.iter_mut().enumerate() {
            *o = level.x.around(i).map(|(i, share)| share * sum[i]).sum();
        }
    });
}

/// Adds the solution of the next level, interpolated bilinearly.
fn prolong(next: &Level, level: &mut Level) {
    let (cols, coarse) = (level.x.cells(), next.x.cells());
    let Level { x, y, u, .. } = level;
    each_row(cols, u, |j, out| {
        let [(a, share), (b, rest)] = y.between(j);
        let row = |j: usize| &next.u[j * coarse..(j + 1) * coarse];
        let rows = row(a).iter().zip(row(if rest > 0.0 { b } else { a }));
        let line: Vec<f64> = rows.map(|(a, b)| share * a + rest * b).collect();
        for (i, o) in out.iter_mut().enumerate() {
            let [(a, share), (b, rest)] = x.between(i);
            *o += share * line[a] + if rest > 0.0 { rest * line[b] } else { 0.0 };
        }
    });
}

/// The inverse of a level's equations.
fn inverse(level: &Level, simd: Simd) -> Vec<f64> {
    let (cols, n) = (level.x.cells(), level.u.len());
    let (mut a, mut one) = (vec![0.0; n * n], vec![0.0; n]);
    for k in 0..n {
        one[k] = 1.0;
        for (j, row) in a[k * n..(k + 1) * n].chunks_mut(cols).enumerate() {
            level.subtract_row(simd, &one, j, row);
        }
        one[k] = 0.0;
    }
    a.iter_mut().for_each(|v| *v = -*v);
    invert(a, n)
}
