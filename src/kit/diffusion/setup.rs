//! Coarse levels by Galerkin products with interpolation that follows the equations \[dendy1982\].
//!
//! A coarse point is the cell whose column and row are even. A cell between two coarse points takes them in the
//! proportion in which its equation pulls, once the neighbours to its sides are lumped into itself; a cell between
//! four takes its own equation. Held cells neither give nor take, so nothing leaks through a line of them however
//! coarse the level.

use crate::kit::diffusion::dense::Dense;
use crate::kit::diffusion::galerkin::{Product, reach};
use crate::kit::diffusion::level::{BACK, DIRECTIONS, Level, Pull};
use crate::kit::diffusion::split::{Deal, Plane, Split, bands, neighbour, zeros};
use crate::kit::simd::{Kernel, Level as Simd, larger};
use crate::work::{Cancelled, Work};

/// Cells up to which a level is solved by its inverse.
const DENSE: usize = 64;
/// Denominators below this share of the diagonal count as zero.
const TINY: f32 = 1e-6;

/// Makes all coarse levels of a finest one.
pub(crate) fn coarsen(finest: Level, simd: Simd, work: &Work<'_>) -> Result<(Vec<Level>, Dense), Cancelled> {
    let mut levels = vec![finest];
    loop {
        work.check()?;
        let Some(last) = levels.last_mut() else { break };
        if last.cols * last.rows <= DENSE {
            last.excess = None;
            break;
        }
        let next = coarser(last, simd);
        levels.push(next);
    }
    let dense = levels.last().map(Dense::new).unwrap_or_default();
    Ok((levels, dense))
}

/// The equations of one row of a plane, with a zero before and after.
pub(crate) struct Equations {
    /// Pulls of the neighbours, or at them when transposed.
    pub(crate) pull: [Vec<f32>; 8],
    pub(crate) diagonal: Vec<f32>,
    pub(crate) excess: Vec<f32>,
}

impl Equations {
    pub(crate) fn new(cols: usize) -> Self {
        let row = || vec![0.0; cols + 2];
        Self { pull: std::array::from_fn(|_| row()), diagonal: row(), excess: row() }
    }

    pub(crate) fn load(&mut self, level: &Level, plane: usize, j: isize, transposed: bool, simd: Simd) {
        let n = level.w[0].cols;
        let w = level.w[plane].row(j, 0);
        for (d, &(dx, dy)) in DIRECTIONS.iter().enumerate().take(level.directions()) {
            let (q, dj, di) = neighbour(plane, dx, dy);
            let out = &mut self.pull[d][1..=n];
            match &level.pull {
                Pull::Unit => {
                    // Rows -1 and `rows` are all held.
                    simd.run(Both { a: w, b: level.w[q].row(j + dj, di), out });
                }
                Pull::Each(a) if transposed => out.copy_from_slice(a[BACK[d]][q].row(j + dj, di)),
                _ => out.copy_from_slice(level.pulls(d, plane, j)),
            }
        }
        let Self { pull, diagonal, excess } = self;
        diagonal[1..=n].iter_mut().zip(w).for_each(|(o, &w)| *o = if w > 0.0 { 1.0 / w } else { 0.0 });
        match &level.excess {
            Some(s) => excess[1..=n].copy_from_slice(s[plane].row(j, 0)),
            None => {
                excess.copy_from_slice(diagonal);
                for pull in &pull[..4] {
                    excess.iter_mut().zip(pull).for_each(|(o, a)| *o -= a);
                }
            }
        }
    }
}

/// 1 where both are above 0.
struct Both<'a> {
    a: &'a [f32],
    b: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Both<'_> {
    #[inline(always)]
    fn run(self) {
        for ((o, &a), &b) in self.out.iter_mut().zip(self.a).zip(self.b) {
            *o = if (a > 0.0) & (b > 0.0) { 1.0 } else { 0.0 };
        }
    }
}

/// Makes the transfers of a level and the level below it.
fn coarser(level: &mut Level, simd: Simd) -> Level {
    level.up = transfer(level, false, simd);
    if matches!(level.pull, Pull::Each(_)) {
        level.down = Some(transfer(level, true, simd));
    }
    let (cols, rows) = (level.w[0].cols, level.w[0].rows);
    let symmetric = !matches!(level.pull, Pull::Each(_));
    let ones = reach(level);
    let mut pull: Vec<Split> = (0..if symmetric { 4 } else { 8 }).map(|_| zeros(cols, rows)).collect();
    let mut excess = zeros(cols, rows);
    let mut planes: Vec<&mut Plane> = pull.iter_mut().flatten().chain(&mut excess).collect();
    bands(&mut planes, |first, pieces| {
        let mut product = Product::new(level, &ones, symmetric, simd);
        let stride = cols.div_ceil(2) + 2;
        for k in 0..pieces[0].len() / stride {
            for half in 0..2 {
                let j = 2 * (first + k) + half;
                if j >= rows {
                    continue;
                }
                product.row(j as isize);
                if !symmetric {
                    // A pull below 0 comes of flow across the grid. Dropping it, with the sum of the row as it was,
                    // is a little diffusion, and without it coarse levels of strong flow are unstable.
                    product.sums[..8].iter_mut().flatten().for_each(|a| *a = larger(*a, 0.0));
                }
                for (v, line) in product.sums.iter().enumerate() {
                    let span = k * stride + 1..(k + 1) * stride - 1;
                    let (left, right) = pieces.split_at_mut(4 * v + 2 * half + 1);
                    let even = &mut left[4 * v + 2 * half][span.clone()];
                    simd.run(Deal { line, even, odd: &mut right[0][span] });
                }
            }
        }
    });
    level.excess = None;
    let pull = if symmetric { Pull::Symmetric(pull) } else { Pull::Each(pull) };
    let mut next = Level::new(cols, rows, pull, Default::default(), Some(excess));
    next.w = inverse(&next, simd);
    next
}

/// One over the diagonal of a level, from its pulls and excess.
fn inverse(level: &Level, simd: Simd) -> Split {
    let mut w = zeros(level.cols, level.rows);
    let Some(excess) = &level.excess else { return w };
    for (plane, w) in w.iter_mut().enumerate() {
        w.each_row(|j, out| {
            let pulls: [&[f32]; 8] = std::array::from_fn(|d| level.pulls(d, plane, j as isize));
            simd.run(Inverse { excess: excess[plane].row(j as isize, 0), pulls, out });
        });
    }
    w
}

struct Inverse<'a> {
    excess: &'a [f32],
    pulls: [&'a [f32]; 8],
    out: &'a mut [f32],
}

impl Kernel for Inverse<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out.len();
        let out = &mut self.out[..n];
        let (excess, pulls) = (&self.excess[..n], self.pulls.map(|p| &p[..n]));
        for i in 0..n {
            let (mut sum, mut size) = (excess[i], excess[i].abs());
            for p in pulls {
                sum += p[i];
                size += p[i].abs();
            }
            out[i] = if sum > 1e-6 * size { 1.0 / sum } else { 0.0 };
        }
    }
}

/// The eight planes of weights of an interpolation; transposed, those of the restriction.
fn transfer(level: &Level, transposed: bool, simd: Simd) -> Vec<Plane> {
    let (cols, rows) = (level.w[0].cols, level.w[0].rows);
    let mut out: Vec<Plane> = (0..8).map(|_| Plane::new(cols, rows)).collect();
    let (edges, centres) = out.split_at_mut(4);
    let mut planes: Vec<&mut Plane> = edges.iter_mut().collect();
    bands(&mut planes, |first, pieces| {
        let mut e = Equations::new(cols);
        for k in 0..pieces[0].len() / (cols + 2) {
            let span = k * (cols + 2)..(k + 1) * (cols + 2);
            for (half, plane) in [(0, 1), (1, 2)] {
                e.load(level, plane, (first + k) as isize, transposed, simd);
                let (left, right) = pieces.split_at_mut(2 * half + 1);
                simd.run(Edge {
                    e: &e,
                    along: half == 0,
                    out: [&mut left[2 * half][span.clone()], &mut right[0][span.clone()]],
                });
            }
        }
    });
    let edges = &*edges;
    let mut planes: Vec<&mut Plane> = centres.iter_mut().collect();
    bands(&mut planes, |first, pieces| {
        let mut e = Equations::new(cols);
        for k in 0..pieces[0].len() / (cols + 2) {
            let span = k * (cols + 2)..(k + 1) * (cols + 2);
            let j = (first + k) as isize;
            e.load(level, 3, j, transposed, simd);
            let mut pieces = pieces.iter_mut();
            let mut next = || pieces.next().map_or(&mut [][..], |p| &mut p[span.clone()]);
            simd.run(Centre {
                e: &e,
                north: [edges[0].padded(j), edges[1].padded(j)],
                south: [edges[0].padded(j + 1), edges[1].padded(j + 1)],
                sides: [edges[2].padded(j), edges[3].padded(j)],
                out: [next(), next(), next(), next()],
            });
        }
    });
    out
}

/// Weights of cells between two coarse points.
struct Edge<'a> {
    e: &'a Equations,
    /// Whether the coarse points stand west and east, not north and south.
    along: bool,
    out: [&'a mut [f32]; 2],
}

impl Kernel for Edge<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out[0].len();
        // West, east, north, south, north-west, north-east, south-west, south-east.
        let (one, two, sides) =
            if self.along { ([0, 4, 6], [1, 5, 7], [2, 3]) } else { ([2, 4, 5], [3, 6, 7], [0, 1]) };
        let pull = self.e.pull.each_ref().map(|p| &p[..n]);
        let diagonal = &self.e.diagonal[..n];
        let [first, second] = self.out.map(|o| &mut o[..n]);
        for i in 0..n {
            let a = pull[one[0]][i] + pull[one[1]][i] + pull[one[2]][i];
            let b = pull[two[0]][i] + pull[two[1]][i] + pull[two[2]][i];
            let beside = pull[sides[0]][i] + pull[sides[1]][i];
            let whole = larger(diagonal[i], a + b + beside);
            let rest = whole - beside;
            let inverse = if rest > TINY * whole { 1.0 / rest } else { 0.0 };
            (first[i], second[i]) = (a * inverse, b * inverse);
        }
    }
}

/// Weights of cells between four coarse points.
struct Centre<'a> {
    e: &'a Equations,
    north: [&'a [f32]; 2],
    south: [&'a [f32]; 2],
    /// Of the edge to the west; that to the east is one further.
    sides: [&'a [f32]; 2],
    out: [&'a mut [f32]; 4],
}

impl Kernel for Centre<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.out[0].len() - 1;
        let [w, e, u, d, nw, ne, sw, se] = self.e.pull.each_ref().map(|p| &p[..n]);
        let diagonal = &self.e.diagonal[..n];
        let ([north_w, north_e], [south_w, south_e]) =
            (self.north.map(|r| &r[..n]), self.south.map(|r| &r[..n]));
        let (west, east) = (self.sides.map(|r| &r[..n]), self.sides.map(|r| &r[1..=n]));
        let [out_nw, out_ne, out_sw, out_se] = self.out.map(|o| &mut o[..n]);
        for i in 0..n {
            let sum = ((w[i] + e[i]) + (u[i] + d[i])) + ((nw[i] + ne[i]) + (sw[i] + se[i]));
            let whole = larger(diagonal[i], sum);
            let inverse = if whole > 0.0 { 1.0 / whole } else { 0.0 };
            out_nw[i] = (nw[i] + u[i] * north_w[i] + w[i] * west[0][i]) * inverse;
            out_ne[i] = (ne[i] + u[i] * north_e[i] + e[i] * east[0][i]) * inverse;
            out_sw[i] = (sw[i] + d[i] * south_w[i] + w[i] * west[1][i]) * inverse;
            out_se[i] = (se[i] + d[i] * south_e[i] + e[i] * east[1][i]) * inverse;
        }
    }
}
