//! Setting a block of one field into another without a seam.
//!
//! # Theory
//! The blend `T` of a reference `R` into a source `S` has the gradient of `k R` inside a region and the values of `S` all
//! around it: `ΔT = div (k ∇R)` inside, `T = S` outside \[perez2003\]. With `m = T − k R` that is the membrane
//! `Δm = 0` inside, `m = S − k R` outside, which needs no divergence: where `S = k R` there is nothing to solve, and `T`
//! is `k R` to the bit. [`Gradients::Mixed`] takes of each difference between two neighbours the larger, that of `S` or
//! that of `k R`, as \[perez2003\] (12) does; then `Δm = div (v − k ∇R)`, the backward divergence of forward differences `v`.
//!
//! # Differs from the paper
//! \[zhang2016\] (6) and (7) have the sign of the right side reversed, and (8) takes the divergence of central differences:
//! with it a field blended into itself does not come out as it was. The paper blends a rectangle; a region here has any
//! shape and number of pieces, and its edge on the border of the field is free.

use crate::kit::diffusion::{Error, Problem, Quality, solve};
use crate::work::Work;

/// Which differences between neighbours a blend follows inside its region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gradients {
    /// Those of the reference.
    #[default]
    Reference,
    /// Of source and reference the larger.
    Mixed,
}

/// What is blended, on `cols × rows` samples, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Blend<'a> {
    /// Samples along x.
    pub cols: usize,
    /// Samples along y.
    pub rows: usize,
    /// What surrounds the region.
    pub source: &'a [f32],
    /// What is set into it.
    pub reference: &'a [f32],
    /// The region: where it is above 0.
    pub mask: &'a [f32],
    /// Factor `k` on the differences of the reference.
    pub gain: f32,
    /// Which differences count.
    pub gradients: Gradients,
}

/// What a blend gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Blended {
    /// `T`: the source to the bit outside the region.
    pub field: Vec<f32>,
    /// Whether the region left nothing of the source: then nothing says how high the reference lies, and `T` is `k R`.
    pub covers_all: bool,
}

impl Blend<'_> {
    /// Blends to an error of a hundred-thousandth of the range of `S − k R` around the region.
    ///
    /// # Errors
    /// [`Error::Length`] when an array does not fit the grid; [`Error::Cancelled`] when the work was asked to stop.
    pub fn run(&self, work: &Work<'_>) -> Result<Blended, Error> {
        self.check()?;
        let mut field = self.source.to_vec();
        let Some(window) = self.window() else {
            return Ok(Blended { field, covers_all: false });
        };
        if self.mask.iter().all(|&m| m > 0.0) {
            field.iter_mut().zip(self.reference).for_each(|(t, r)| *t = self.gain * r);
            return Ok(Blended { field, covers_all: true });
        }
        let membrane = self.membrane(window, work)?;
        for (j, m) in membrane.chunks_exact(window.cols()).enumerate() {
            let span = self.span(window, window.top + j);
            let parts = self.mask[span.clone()].iter().zip(&self.reference[span.clone()]).zip(m);
            for (t, ((&mask, r), m)) in field[span].iter_mut().zip(parts) {
                if mask > 0.0 {
                    *t = self.gain * r + m;
                }
            }
        }
        Ok(Blended { field, covers_all: false })
    }

    fn check(&self) -> Result<(), Error> {
        let expected = self.cols.saturating_mul(self.rows);
        let arrays = [("source", self.source), ("reference", self.reference), ("mask", self.mask)];
        let misfit = arrays.into_iter().find(|(_, a)| a.len() != expected);
        misfit.map_or(Ok(()), |(array, a)| Err(Error::Length { array, found: a.len(), expected }))
    }

    /// The smallest window around the region and the samples beside it; none where there is no region.
    fn window(&self) -> Option<Window> {
        let mut found: Option<Window> = None;
        for (j, row) in self.mask.chunks_exact(self.cols.max(1)).enumerate() {
            let Some(first) = row.iter().position(|&m| m > 0.0) else { continue };
            let last = row.iter().rposition(|&m| m > 0.0).unwrap_or(first);
            let here = Window { left: first, right: last + 1, top: j, bottom: j + 1 };
            found = Some(found.map_or(here, |all| all.with(here)));
        }
        found.map(|w| Window {
            left: w.left.saturating_sub(1),
            right: (w.right + 1).min(self.cols),
            top: w.top.saturating_sub(1),
            bottom: (w.bottom + 1).min(self.rows),
        })
    }

    /// The samples of a row that stand in a window.
    fn span(&self, window: Window, row: usize) -> std::ops::Range<usize> {
        row * self.cols + window.left..row * self.cols + window.right
    }

    /// `m` on a window.
    fn membrane(&self, window: Window, work: &Work<'_>) -> Result<Vec<f32>, Error> {
        let (cols, rows) = (window.cols(), window.rows());
        let (mut fixed, mut target) = (Vec::with_capacity(cols * rows), Vec::with_capacity(cols * rows));
        for span in (window.top..window.bottom).map(|row| self.span(window, row)) {
            fixed.extend(self.mask[span.clone()].iter().map(|&m| if m > 0.0 { 0.0 } else { 1.0 }));
            let both = self.source[span.clone()].iter().zip(&self.reference[span]);
            target.extend(both.map(|(s, r)| s - self.gain * r));
        }
        let source = match self.gradients {
            Gradients::Reference => None,
            Gradients::Mixed => Some(self.divergence(window, work)?),
        };
        let problem =
            Problem { cols, rows, fixed: &fixed, target: &target, guidance: None, source: source.as_deref() };
        Ok(solve(&problem, Quality::CONVERGED, work)?.field)
    }

    /// What `m` stands above the mean of its neighbours: minus a quarter of the divergence of `v − k ∇R`, where `v` is the
    /// larger of the differences of `S` and `k R` between two neighbours. Differences beyond the border are none.
    fn divergence(&self, window: Window, work: &Work<'_>) -> Result<Vec<f32>, Error> {
        let mut out = vec![0.0; window.cols() * window.rows()];
        let band = (1 << 14) / window.cols() + 1;
        work.quiet().rows(&mut out, window.cols(), band, |j, out| {
            let row = window.top + j;
            for (i, o) in out.iter_mut().enumerate() {
                let (col, at) = (window.left + i, row * self.cols + window.left + i);
                let mut sum = 0.0;
                if col > 0 {
                    sum += self.gained(at, at - 1);
                }
                if col + 1 < self.cols {
                    sum += self.gained(at, at + 1);
                }
                if row > 0 {
                    sum += self.gained(at, at - self.cols);
                }
                if row + 1 < self.rows {
                    sum += self.gained(at, at + self.cols);
                }
                *o = -0.25 * sum;
            }
        })?;
        Ok(out)
    }

    /// What the larger difference from one sample to another exceeds that of the reference by.
    fn gained(&self, from: usize, to: usize) -> f32 {
        let source = self.source[to] - self.source[from];
        let reference = self.gain * (self.reference[to] - self.reference[from]);
        if source.abs() > reference.abs() { source - reference } else { 0.0 }
    }
}

/// Columns and rows from the first to the last, which is not in it.
#[derive(Clone, Copy)]
struct Window {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Window {
    fn cols(self) -> usize {
        self.right - self.left
    }

    fn rows(self) -> usize {
        self.bottom - self.top
    }

    fn with(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }
}
