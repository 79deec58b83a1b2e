//! What is asked of the solver, and the equation of each cell.

use rayon::prelude::*;

use crate::kit::simd::{Kernel, Level, larger, smaller};

/// Constraints beyond this size count as absent; it leaves room for sums in `f32`.
pub(crate) const HUGE: f32 = 1e30;
/// Fixed weights below this, and Laplace weights below this where nothing guides, count as zero: `4 + 4 · 2⁻²⁰`
/// is about the smallest step from 4 that an `f32` holds.
pub(crate) const FAINT: f32 = 1.0 / 1_048_576.0;
/// What guidance may take of what the constraint leaves, at most, so that no cell hangs on guidance alone: closed
/// loops of guidance have no solution.
const GUIDED: f32 = 1.0 - 1.0 / 256.0;
/// Directions shorter than this have no direction.
const SHORT: f32 = 1e-6;

/// A slope that guides the field along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Guidance<'a> {
    /// Share of the guided value in the new value of each cell, 0 to 1; what `fixed` leaves at most.
    pub weight: &'a [f32],
    /// Direction in which the field is guided, along the columns; need not be of unit length. Where both components
    /// are below 1e-6, the guidance has no weight.
    pub x: &'a [f32],
    /// Direction along the rows.
    pub y: &'a [f32],
    /// Tangent of the angle by which the field rises in that direction; negative where it falls.
    pub slope: &'a [f32],
    /// Distance between neighbouring cells, in the unit of the field.
    pub cell: f32,
}

/// A diffusion problem on `cols × rows` cells, row by row.
///
/// The new value of a cell is `laplace · mean + gradient · guided + fixed · target`, where `laplace` is what the
/// two other weights leave of 1. Weights outside 0 to 1 are clamped; `fixed` goes before `gradient`, and at least
/// 1/256 of what `fixed` leaves goes to `laplace`. A cell whose target, direction or slope is not a number, or
/// beyond 1e30, has no constraint, or no guidance.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Cells along x.
    pub cols: usize,
    /// Cells along y.
    pub rows: usize,
    /// Share of the target in the new value of each cell, 0 to 1; 1 is a strict constraint.
    pub fixed: &'a [f32],
    /// Constraint value where `fixed` is above 0; ignored elsewhere.
    pub target: &'a [f32],
    /// Slopes that the field follows.
    pub guidance: Option<Guidance<'a>>,
    /// Right side of the Laplace equation: what the field stands above the mean of its four neighbours, that is
    /// `-cell² ΔF / 4`.
    pub source: Option<&'a [f32]>,
}

/// The rows of coefficients that [`Problem::equation`] fills: the new value is the sum of the four coefficients
/// times the neighbours, plus `add`. A neighbour beyond the border is the cell itself.
#[derive(Debug, Default)]
pub(crate) struct Equation {
    pub(crate) west: Vec<f32>,
    pub(crate) east: Vec<f32>,
    pub(crate) north: Vec<f32>,
    pub(crate) south: Vec<f32>,
    pub(crate) add: Vec<f32>,
    /// Share of the constraint.
    pub(crate) fixed: Vec<f32>,
    /// Constraint, less the offset; 0 where there is none.
    pub(crate) target: Vec<f32>,
    /// Share of the mean.
    pub(crate) laplace: Vec<f32>,
}

impl Equation {
    pub(crate) fn new(n: usize) -> Self {
        let row = || vec![0.0; n];
        Self {
            west: row(),
            east: row(),
            north: row(),
            south: row(),
            add: row(),
            fixed: row(),
            target: row(),
            laplace: row(),
        }
    }
}

impl Problem<'_> {
    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.cols.saturating_mul(self.rows)
    }

    /// The name of the first array whose length is not the number of cells, with that length.
    pub(crate) fn misfit(&self) -> Option<(&'static str, usize)> {
        let mut arrays = vec![("fixed", self.fixed), ("target", self.target)];
        if let Some(g) = self.guidance {
            arrays.extend([("weight", g.weight), ("x", g.x), ("y", g.y), ("slope", g.slope)]);
        }
        arrays.extend(self.source.map(|s| ("source", s)));
        arrays.iter().find(|(_, a)| a.len() != self.len()).map(|(name, a)| (*name, a.len()))
    }

    /// Fills the first cells of `out` with the equations of row `j` from column `from` on. `offset` is taken off
    /// the constraints.
    pub(crate) fn equation(
        &self,
        level: Level,
        j: usize,
        from: usize,
        n: usize,
        offset: f32,
        out: &mut Equation,
    ) {
        let at = j * self.cols + from;
        let span = at..at + n;
        let plain = Plain {
            fixed: &self.fixed[span.clone()],
            target: &self.target[span.clone()],
            source: self.source.map(|s| &s[span.clone()]),
            offset,
            out,
        };
        match self.guidance {
            None => level.run(plain),
            Some(g) => level.run(Guided {
                plain,
                weight: &g.weight[span.clone()],
                x: &g.x[span.clone()],
                y: &g.y[span.clone()],
                slope: &g.slope[span],
                cell: if g.cell.is_finite() { g.cell } else { 0.0 },
                from: from as u32,
                cols: self.cols as u32,
                north: j > 0,
                south: j + 1 < self.rows,
            }),
        }
    }

    /// The largest weight of the guidance.
    pub(crate) fn strongest_guidance(&self) -> f32 {
        let most = |weights: &[f32]| weights.iter().fold(0.0, |a, &w| larger(a, smaller(w, 1.0)));
        let weights = self.guidance.map_or(&[][..], |g| g.weight);
        weights.par_chunks(1 << 16).map(most).reduce(|| 0.0, larger)
    }

    /// The least and the largest constraint in a row, and whether guidance has any weight there.
    pub(crate) fn survey(&self, level: Level, j: usize) -> (f32, f32, bool) {
        let span = j * self.cols..(j + 1) * self.cols;
        let mut found = (HUGE, -HUGE);
        level.run(Survey {
            fixed: &self.fixed[span.clone()],
            target: &self.target[span.clone()],
            found: &mut found,
        });
        let guided = self.guidance.is_some_and(|g| g.weight[span].iter().any(|&w| w > 0.0));
        (found.0, found.1, guided)
    }
}

/// A constraint's share and value: both 0 where there is none.
#[inline(always)]
pub(crate) fn constraint(fixed: f32, target: f32, offset: f32) -> (f32, f32) {
    let sound = target.abs() < HUGE;
    let share = if sound & (fixed > FAINT) { fixed } else { 0.0 };
    let share = if share < 1.0 - FAINT { share } else { 1.0 };
    (if sound { share } else { 0.0 }, if sound & (share > 0.0) { target - offset } else { 0.0 })
}

/// A source, or 0 where it is not a number.
#[inline(always)]
fn clean(source: f32) -> f32 {
    if source.abs() < HUGE { source } else { 0.0 }
}

struct Survey<'a> {
    fixed: &'a [f32],
    target: &'a [f32],
    found: &'a mut (f32, f32),
}

impl Kernel for Survey<'_> {
    #[inline(always)]
    fn run(self) {
        const LANES: usize = 16;
        let (mut low, mut high) = ([HUGE; LANES], [-HUGE; LANES]);
        let mut step = |k: usize, f: f32, t: f32| {
            let is = (t.abs() < HUGE) & (f > FAINT);
            low[k] = smaller(low[k], if is { t } else { HUGE });
            high[k] = larger(high[k], if is { t } else { -HUGE });
        };
        let (f, t) = (self.fixed.chunks_exact(LANES), self.target.chunks_exact(LANES));
        for (k, (&f, &t)) in f.remainder().iter().zip(t.remainder()).enumerate() {
            step(k, f, t);
        }
        for (f, t) in f.zip(t) {
            for k in 0..LANES {
                step(k, f[k], t[k]);
            }
        }
        let fold = |v: [f32; LANES], f: fn(f32, f32) -> f32| v.into_iter().reduce(f).unwrap_or(0.0);
        *self.found = (fold(low, smaller), fold(high, larger));
    }
}

struct Plain<'a> {
    fixed: &'a [f32],
    target: &'a [f32],
    source: Option<&'a [f32]>,
    offset: f32,
    out: &'a mut Equation,
}

impl Kernel for Plain<'_> {
    #[inline(always)]
    fn run(self) {
        let n = self.fixed.len();
        let target = &self.target[..n];
        let (west, east) = (&mut self.out.west[..n], &mut self.out.east[..n]);
        let (north, south) = (&mut self.out.north[..n], &mut self.out.south[..n]);
        let (fixed, held) = (&mut self.out.fixed[..n], &mut self.out.target[..n]);
        let (add, laplace) = (&mut self.out.add[..n], &mut self.out.laplace[..n]);
        for i in 0..n {
            let (f, e) = constraint(self.fixed[i], target[i], self.offset);
            let l = 1.0 - f;
            let quarter = 0.25 * l;
            (west[i], east[i], north[i], south[i]) = (quarter, quarter, quarter, quarter);
            (fixed[i], held[i], add[i], laplace[i]) = (f, e, f * e, l);
        }
        if let Some(source) = self.source {
            for (i, &s) in source[..n].iter().enumerate() {
                add[i] += laplace[i] * clean(s);
            }
        }
    }
}

struct Guided<'a> {
    plain: Plain<'a>,
    weight: &'a [f32],
    x: &'a [f32],
    y: &'a [f32],
    slope: &'a [f32],
    cell: f32,
    from: u32,
    cols: u32,
    north: bool,
    south: bool,
}

impl Kernel for Guided<'_> {
    #[inline(always)]
    fn run(self) {
        let plain = self.plain;
        let n = plain.fixed.len();
        let (weight, x, y, slope) = (&self.weight[..n], &self.x[..n], &self.y[..n], &self.slope[..n]);
        let target = &plain.target[..n];
        let (west, east) = (&mut plain.out.west[..n], &mut plain.out.east[..n]);
        let (north, south) = (&mut plain.out.north[..n], &mut plain.out.south[..n]);
        let (fixed, held) = (&mut plain.out.fixed[..n], &mut plain.out.target[..n]);
        let (add, laplace) = (&mut plain.out.add[..n], &mut plain.out.laplace[..n]);
        for i in 0..n {
            let (f, e) = constraint(plain.fixed[i], target[i], plain.offset);
            let length2 = x[i] * x[i] + y[i] * y[i];
            let rise = slope[i] * self.cell;
            let sound = (length2 > SHORT * SHORT) & (length2 < HUGE) & (rise.abs() < HUGE * 1e-6);
            let (vx, vy, rise) = (
                if sound { x[i] } else { 1.0 },
                if sound { y[i] } else { 0.0 },
                if sound { rise } else { 0.0 },
            );
            let inverse = 1.0 / (vx * vx + vy * vy).sqrt();
            let (ax, ay) = (vx.abs() * inverse, vy.abs() * inverse);
            let most = (1.0 - f) * GUIDED;
            let b = smaller(larger(weight[i], 0.0), most);
            let share = (if sound { b } else { 0.0 }) / (ax + ay);
            // The part whose neighbour lies beyond the border goes to the mean.
            let at = self.from + i as u32;
            let has_x = ((vx > 0.0) & (at > 0)) | ((vx < 0.0) & (at + 1 < self.cols));
            let has_y = ((vy > 0.0) & self.north) | ((vy < 0.0) & self.south);
            let bx = if has_x { share * ax } else { 0.0 };
            let by = if has_y { share * ay } else { 0.0 };
            let l = larger(1.0 - f - (bx + by), 0.0);
            let quarter = 0.25 * l;
            west[i] = quarter + if vx > 0.0 { bx } else { 0.0 };
            east[i] = quarter + if vx < 0.0 { bx } else { 0.0 };
            north[i] = quarter + if vy > 0.0 { by } else { 0.0 };
            south[i] = quarter + if vy < 0.0 { by } else { 0.0 };
            (fixed[i], held[i], laplace[i]) = (f, e, l);
            add[i] = f * e + rise * (bx * ax + by * ay);
        }
        if let Some(source) = plain.source {
            for (i, &s) in source[..n].iter().enumerate() {
                add[i] += laplace[i] * clean(s);
            }
        }
    }
}
