//! The V-cycle over all levels, the preconditioner of the iterations.

use crate::kit::diffusion::dense::Dense;
use crate::kit::diffusion::level::{Level, Make, ORDER};
use crate::kit::diffusion::split::{Deal, Merge, Plane, Split, bands};
use crate::kit::simd::{Kernel, Level as Simd};

/// All levels, the finest first, and the inverse of the coarsest.
#[derive(Debug)]
pub(crate) struct Multigrid {
    pub(crate) levels: Vec<Level>,
    pub(crate) coarsest: Dense,
    pub(crate) simd: Simd,
}

impl Multigrid {
    /// Fills the finest level's `u` with an approximate solution for the right side `b`, by one V-cycle from zero
    /// with one Gauss-Seidel sweep before and one after the correction. Linear, and symmetric where the equations
    /// are.
    pub(crate) fn cycle(&mut self, b: &Split) {
        let mut levels = std::mem::take(&mut self.levels);
        self.descend(&mut levels, Some(b));
        self.levels = levels;
    }

    fn descend(&self, levels: &mut [Level], finest: Option<&Split>) {
        let Some((level, below)) = levels.split_first_mut() else { return };
        let mut u = std::mem::take(&mut level.u);
        let own = std::mem::take(&mut level.b);
        let b = finest.unwrap_or(&own);
        if let Some(next) = below.first_mut() {
            self.smooth_down(level, b, &mut u);
            restrict(self.simd, level, &u, next);
            self.descend(below, None);
            prolong(self.simd, level, &below[0], &mut u);
            for plane in ORDER.into_iter().rev() {
                level.relax(self.simd, plane, [true; 4], b, &mut u);
            }
        } else {
            self.coarsest.solve(level, b, &mut u);
        }
        level.u = u;
        level.b = own;
    }

    /// The first sweep, from zero: each plane sees only those before it.
    fn smooth_down(&self, level: &Level, b: &Split, u: &mut Split) {
        let mut seen = [false; 4];
        for plane in ORDER {
            level.relax(self.simd, plane, seen, b, u);
            seen[plane] = true;
        }
    }
}

/// The planes that come after one in [`ORDER`]: only they keep the sweep from zero from having solved its equation.
fn after(plane: usize) -> [bool; 4] {
    let mut later = [false; 4];
    for &q in ORDER.iter().skip_while(|&&q| q != plane).skip(1) {
        later[q] = true;
    }
    later
}

/// The next level's right side: the residual after the first sweep, weighted by the restriction.
fn restrict(simd: Simd, level: &Level, u: &Split, next: &mut Level) {
    let nine = level.directions() == 8;
    let down = level.down.as_ref().unwrap_or(&level.up);
    let (cols, rows) = (next.cols, next.rows);
    let mut planes: Vec<&mut Plane> = next.b.iter_mut().collect();
    bands(&mut planes, |first, pieces| {
        let stride = cols.div_ceil(2) + 2;
        let line = || vec![0.0f32; cols + 2];
        let (mut corner, mut above, mut here, mut edge) = (line(), line(), line(), line());
        let residual = |plane: usize, j: usize, out: &mut Vec<f32>| {
            level.row(simd, Make::Sum, plane, j, after(plane), (u, u), &mut out[1..=cols]);
        };
        if first > 0 {
            residual(3, 2 * first - 1, &mut here);
        }
        for k in 0..pieces[0].len() / stride {
            for half in 0..2 {
                let j = 2 * (first + k) + half;
                if j >= rows {
                    continue;
                }
                std::mem::swap(&mut above, &mut here);
                residual(3, j, &mut here);
                residual(0, j, &mut corner);
                if nine {
                    residual(1, j, &mut edge);
                }
                simd.run(Gather {
                    line: &mut corner[1..=cols],
                    corner_rows: [&above, &here],
                    edge: nine.then_some(&edge),
                    weights: [0, 1, 4, 5].map(|w| down[w].padded(j as isize)),
                    weights_above: [6, 7].map(|w| down[w].padded(j as isize - 1)),
                });
                let (left, right) = pieces.split_at_mut(2 * half + 1);
                let span = k * stride + 1..(k + 1) * stride - 1;
                simd.run(Deal {
                    line: &corner[1..=cols],
                    even: &mut left[2 * half][span.clone()],
                    odd: &mut right[0][span],
                });
            }
        }
    });
}

/// Adds the weighted residuals of edges and centres to those of a row of coarse points.
struct Gather<'a> {
    line: &'a mut [f32],
    /// Centres above and below the row, with a zero before and after.
    corner_rows: [&'a [f32]; 2],
    edge: Option<&'a Vec<f32>>,
    /// Edge to west and east, centre below to north-west and north-east.
    weights: [&'a [f32]; 4],
    /// Centre above to south-west and south-east.
    weights_above: [&'a [f32]; 2],
}

impl Kernel for Gather<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.line.len();
        let line = &mut self.line[..n];
        let [above, here] = self.corner_rows;
        let (a0, a1) = (&above[..n], &above[1..=n]);
        let (h0, h1) = (&here[..n], &here[1..=n]);
        let [west, east, nw, ne] = self.weights;
        let [sw, se] = self.weights_above;
        let (nw, ne, sw, se) = (&nw[1..=n], &ne[..n], &sw[1..=n], &se[..n]);
        for i in 0..n {
            line[i] += (nw[i] * h1[i] + ne[i] * h0[i]) + (sw[i] * a1[i] + se[i] * a0[i]);
        }
        if let Some(edge) = self.edge {
            let (e0, e1) = (&edge[..n], &edge[1..=n]);
            let (west, east) = (&west[1..=n], &east[..n]);
            for i in 0..n {
                line[i] += west[i] * e1[i] + east[i] * e0[i];
            }
        }
    }
}

/// Adds the interpolated coarse solution to the planes that the next sweep reads before it writes them.
fn prolong(simd: Simd, level: &Level, next: &Level, u: &mut Split) {
    let cols = next.cols;
    let fetch = |j: usize, line: &mut Vec<f32>| {
        let span = &mut line[..cols];
        let (half, row) = (2 * (j % 2), (j / 2) as isize);
        if j < next.rows {
            simd.run(Merge { even: next.u[half].row(row, 0), odd: next.u[half + 1].row(row, 0), line: span });
        } else {
            span.fill(0.0);
        }
    };
    let nine = level.directions() == 8;
    let [corner, edge, _, centre] = u;
    let mut planes = vec![corner, centre];
    if nine {
        planes.push(edge);
    }
    bands(&mut planes, |first, pieces| {
        let (mut here, mut below) = (vec![0.0; cols + 1], vec![0.0; cols + 1]);
        fetch(first, &mut below);
        for k in 0..pieces[0].len() / (cols + 2) {
            let j = first + k;
            std::mem::swap(&mut here, &mut below);
            fetch(j + 1, &mut below);
            let span = k * (cols + 2) + 1..(k + 1) * (cols + 2) - 1;
            let weights = |w: usize| level.up[w].row(j as isize, 0);
            simd.run(Scatter {
                terms: [
                    (weights(4), &here[..cols]),
                    (weights(5), &here[1..]),
                    (weights(6), &below[..cols]),
                    (weights(7), &below[1..]),
                ],
                out: &mut pieces[1][span.clone()],
            });
            if nine {
                let terms = [(weights(0), &here[..cols]), (weights(1), &here[1..])];
                simd.run(Scatter { terms, out: &mut pieces[2][span.clone()] });
            }
            for (o, &e) in pieces[0][span].iter_mut().zip(&here) {
                *o += e;
            }
        }
    });
}

struct Scatter<'a, const N: usize> {
    terms: [(&'a [f32], &'a [f32]); N],
    out: &'a mut [f32],
}

impl<const N: usize> Kernel for Scatter<'_, N> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let out = &mut self.out[..n];
        let terms = self.terms.map(|(w, e)| (&w[..n], &e[..n]));
        for i in 0..n {
            let mut sum = 0.0;
            for (w, e) in terms {
                sum += w[i] * e[i];
            }
            out[i] += sum;
        }
    }
}
