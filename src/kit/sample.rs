//! Reading a field between its samples.

mod bulk;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::bulk::SampleRow;
use crate::kit::simd::Level;
use crate::value::{Field, Quantity};

/// How a field is read between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The nearest sample: keeps every value as it is, shows steps.
    Nearest,
    /// Straight between the four samples around: never beyond their range, shows creases.
    Linear,
    /// A smooth surface through the samples; it may swing a little beyond them.
    #[default]
    Cubic,
}

impl Interpolation {
    /// Nanoseconds a sample on one core, from memory that lies in order.
    pub fn nanoseconds(self) -> f64 {
        match self {
            Self::Nearest => 24.0,
            Self::Linear => 47.0,
            Self::Cubic => 12.0,
        }
    }
}

/// Reads a field at positions in lattice steps; beyond the window its border value continues.
///
/// A position is a column and row of the field's lattice with a fraction. The value depends on the position and
/// the samples around it alone, not on the window. Every method gives a sample's own value at its place, and the
/// value of a flat field to the bit. A `Sampler` is cheap: make one per run.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'a> {
    data: &'a [f32],
    cols: usize,
    first: [i64; 2],
    last: [i64; 2],
    level: Level,
}

impl<'a> Sampler<'a> {
    /// Reads a field; `None` when it has no sample.
    pub fn new(field: &'a Field) -> Option<Self> {
        let g = field.grid();
        let last = [g.col_end() - 1, g.row_end() - 1];
        let level = Level::best();
        (!g.is_empty()).then(|| Self { data: field.data(), cols: g.cols, first: [g.col, g.row], last, level })
    }

    /// The same on a given instruction set; the bits do not change.
    pub fn on(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// The value by a chosen method.
    pub fn value(&self, method: Interpolation, steps: [f64; 2]) -> f32 {
        match method {
            Interpolation::Nearest => self.nearest(steps),
            Interpolation::Linear => self.bilinear(steps),
            Interpolation::Cubic => self.bicubic(steps),
        }
    }

    /// The values of a field of `quantity` at many positions: each brought back to what such a field may hold.
    ///
    /// `places` writes the columns and rows of the positions from an index of `out` on, as many as its slices hold.
    pub fn row(
        &self,
        method: Interpolation,
        quantity: Quantity,
        places: impl Fn(usize, [&mut [f64]; 2]),
        out: &mut [f32],
    ) {
        self.level.run(SampleRow { sampler: *self, method, quantity, places, out });
    }

    /// The nearest sample; of two as near the one to the south or east.
    #[inline(always)]
    pub fn nearest(&self, [u, v]: [f64; 2]) -> f32 {
        self.data[self.line((v + 0.5).floor() as i64) + self.place((u + 0.5).floor() as i64)]
    }

    /// Straight in both directions between the four samples around.
    #[inline(always)]
    pub fn bilinear(&self, [u, v]: [f64; 2]) -> f32 {
        let ((i, s), (j, t)) = (self.cell(u, 0), self.cell(v, 1));
        let (a, b) = (self.place(i), self.place(i + 1));
        let along = |line: usize| {
            let (a, b) = (self.data[line + a], self.data[line + b]);
            a + (b - a) * s
        };
        let (top, bottom) = (along(self.line(j)), along(self.line(j + 1)));
        top + (bottom - top) * t
    }

    /// Catmull-Rom spline through the sixteen samples around \[catmull1974\].
    #[inline(always)]
    pub fn bicubic(&self, [u, v]: [f64; 2]) -> f32 {
        let ((i, s), (j, t)) = (self.cell(u, 0), self.cell(v, 1));
        let inside = |k: i64, axis: usize| k > self.first[axis] && k + 2 <= self.last[axis];
        if inside(i, 0) && inside(j, 1) {
            let start = (j - 1 - self.first[1]) as usize * self.cols + (i - 1 - self.first[0]) as usize;
            let lines = [0, 1, 2, 3].map(|k| {
                let p = &self.data[start + k * self.cols..][..4];
                [p[0], p[1], p[2], p[3]]
            });
            return bicubic(lines, s, t);
        }
        let x = [-1, 0, 1, 2].map(|k| self.place(i + k));
        let lines = [-1, 0, 1, 2].map(|k| {
            let line = self.line(j + k);
            x.map(|x| self.data[line + x])
        });
        bicubic(lines, s, t)
    }

    /// The sample before a position, and how far behind it the position lies, from 0 to 1.
    #[inline(always)]
    fn cell(&self, at: f64, axis: usize) -> (i64, f32) {
        // Beyond the window all is constant along this axis: one step beyond says as much as a million.
        let at = at.clamp(self.first[axis] as f64 - 2.0, self.last[axis] as f64 + 2.0);
        let before = at.floor();
        (before as i64, (at - before) as f32)
    }

    #[inline(always)]
    fn place(&self, col: i64) -> usize {
        (col.clamp(self.first[0], self.last[0]) - self.first[0]) as usize
    }

    #[inline(always)]
    fn line(&self, row: i64) -> usize {
        (row.clamp(self.first[1], self.last[1]) - self.first[1]) as usize * self.cols
    }
}

/// The Catmull-Rom spline between `p[1]` and `p[2]`; written in differences, so that equal points give their value.
#[inline(always)]
pub fn catmull_rom(p: [f32; 4], t: f32) -> f32 {
    let (a, b, c) = (p[0] - p[1], p[2] - p[1], p[3] - p[1]);
    p[1] + 0.5 * t * ((b - a) + t * ((2.0 * a + 4.0 * b - c) + t * (c - a - 3.0 * b)))
}

/// Splines down four columns, and one across what they give.
#[inline(always)]
fn bicubic(lines: [[f32; 4]; 4], s: f32, t: f32) -> f32 {
    let mut across = [0.0; 4];
    for (k, v) in across.iter_mut().enumerate() {
        *v = catmull_rom([lines[0][k], lines[1][k], lines[2][k], lines[3][k]], t);
    }
    catmull_rom(across, s)
}

/// The method that suits what the numbers mean: labels and compass directions are never averaged.
pub fn method_for(quantity: Quantity, wanted: Interpolation) -> Interpolation {
    match quantity {
        Quantity::Label | Quantity::Direction => Interpolation::Nearest,
        _ => wanted,
    }
}

/// Brings a computed value back to what a field may hold: finite, and 0 to 1 for a mask.
#[allow(clippy::manual_clamp, reason = "`max` and `min` take the other side of a NaN, `clamp` hands it on")]
#[inline(always)]
pub fn fit(quantity: Quantity, value: f32) -> f32 {
    if quantity == Quantity::Mask { value.max(0.0).min(1.0) } else { finite(value) }
}

/// The nearest finite value; nothing that is not a number passes.
#[allow(clippy::manual_clamp, reason = "`max` and `min` take the other side of a NaN, `clamp` hands it on")]
#[inline(always)]
pub fn finite(value: f32) -> f32 {
    value.max(-LARGEST).min(LARGEST)
}

/// The largest size of a result: a little below that of `f32`, so that a sum of results rounds to no infinity soon.
pub const LARGEST: f32 = 3.0e38;
