//! Many positions at once, block by block in local arrays, to the same bits as one by one.
//!
//! A block whose sixteen samples a position all lie in the window is gathered, four samples in a row at a time, and
//! the splines run over all its positions together. Any other block is read position by position. The sums are those of
//! [`Sampler::bicubic`] in the same order.

use super::{Interpolation, Sampler, catmull_rom, fit};
use crate::kit::math::nearest_whole;
use crate::kit::simd::Kernel;
use crate::value::Quantity;

/// Positions that are worked on together: their samples fit the fastest memory with what surrounds them.
const BLOCK: usize = 32;

/// Columns and rows of the positions of a block.
type Places = [[f64; BLOCK]; 2];

/// The values of a row, at positions that are made block by block.
pub(super) struct SampleRow<'a, P> {
    pub(super) sampler: Sampler<'a>,
    pub(super) method: Interpolation,
    pub(super) quantity: Quantity,
    pub(super) places: P,
    pub(super) out: &'a mut [f32],
}

impl<P: Fn(usize, [&mut [f64]; 2])> Kernel for SampleRow<'_, P> {
    #[inline(always)]
    fn run(self) {
        let Self { sampler, method, quantity, places, out } = self;
        let (mut at, mut values) = ([[0.0; BLOCK]; 2], [0.0; BLOCK]);
        for (block, out) in out.chunks_mut(BLOCK).enumerate() {
            let [cols, rows] = &mut at;
            places(block * BLOCK, [&mut cols[..out.len()], &mut rows[..out.len()]]);
            // The last position stands for those that a short block lacks.
            for places in [cols, rows] {
                let last = places[out.len() - 1];
                places[out.len()..].fill(last);
            }
            match method {
                Interpolation::Cubic => sampler.cubic_block(&at, &mut values),
                other => sampler.each(other, &at, &mut values),
            }
            let fits = method != Interpolation::Nearest;
            for (o, &value) in out.iter_mut().zip(&values) {
                *o = if fits { fit(quantity, value) } else { value };
            }
        }
    }
}

/// Where the four samples around each position of a block begin along an axis, and the shares of the way to the next.
struct Starts {
    first: [u32; BLOCK],
    share: [f32; BLOCK],
    /// Whether the window holds all four of every position.
    inside: bool,
}

impl Sampler<'_> {
    /// The values of a block, one by one.
    #[inline(never)]
    fn each(&self, method: Interpolation, [cols, rows]: &Places, out: &mut [f32; BLOCK]) {
        for ((o, &u), &v) in out.iter_mut().zip(cols).zip(rows) {
            *o = self.value(method, [u, v]);
        }
    }

    /// The values of a block by the Catmull-Rom spline.
    #[inline(always)]
    fn cubic_block(&self, at: &Places, out: &mut [f32; BLOCK]) {
        let (col, row) = (self.starts(&at[0], 0), self.starts(&at[1], 1));
        if !(col.inside && row.inside) {
            return self.each(Interpolation::Cubic, at, out);
        }
        let mut lines = [[[0.0; 4]; BLOCK]; 4];
        self.gather(&col.first, &row.first, &mut lines);
        let mut shares = [[0.0; 4]; BLOCK];
        for (four, &share) in shares.iter_mut().zip(&row.share) {
            *four = [share; 4];
        }
        let mut across = [[0.0; 4]; BLOCK];
        let [a, b, c, d] = &lines;
        let down =
            a.as_flattened().iter().zip(b.as_flattened()).zip(c.as_flattened().iter().zip(d.as_flattened()));
        for ((o, &t), ((&a, &b), (&c, &d))) in
            across.as_flattened_mut().iter_mut().zip(shares.as_flattened()).zip(down)
        {
            *o = catmull_rom([a, b, c, d], t);
        }
        for ((o, &p), &s) in out.iter_mut().zip(&across).zip(&col.share) {
            *o = catmull_rom(p, s);
        }
    }

    /// Copies the samples around positions that have all of them in the window: of each of four lines, four.
    #[inline(always)]
    fn gather(&self, cols: &[u32; BLOCK], rows: &[u32; BLOCK], lines: &mut [[[f32; 4]; BLOCK]; 4]) {
        // All four are as long as each other, so that one check of bounds does for them.
        let (wide, len) = (self.cols, self.data.len() - 3 * self.cols);
        let from = |k: usize| &self.data[k * wide..][..len];
        let sources = [from(0), from(1), from(2), from(3)];
        for (l, (&col, &row)) in cols.iter().zip(rows).enumerate() {
            let start = row as usize * wide + col as usize;
            for (line, source) in lines.iter_mut().zip(sources) {
                let p = &source[start..][..4];
                line[l] = [p[0], p[1], p[2], p[3]];
            }
        }
    }

    /// As [`cell`](Self::cell) for a block; nothing but plain arithmetic, which vectorises.
    #[inline(always)]
    fn starts(&self, at: &[f64; BLOCK], axis: usize) -> Starts {
        // Adding 2⁵² leaves a whole number in the low bits of the sum.
        const LOW_BITS: f64 = 4_503_599_627_370_496.0;
        let (low, high) = (self.first[axis] as f64 - 2.0, self.last[axis] as f64 + 2.0);
        let mut starts = Starts { first: [0; BLOCK], share: [0.0; BLOCK], inside: false };
        for ((first, share), &at) in starts.first.iter_mut().zip(&mut starts.share).zip(at) {
            // What is not a number becomes `low`, which is outside.
            let at = if at > low { at } else { low };
            let at = if at < high { at } else { high };
            let near = nearest_whole(at);
            let before = if near > at { near - 1.0 } else { near };
            *share = (at - before) as f32;
            // The four begin one before; a column before the first becomes a very large number.
            *first = (((before - low) + LOW_BITS).to_bits() as u32).wrapping_sub(3);
        }
        let count = self.last[axis] - self.first[axis] - 2;
        // Where `nearest_whole` could not tell indices apart, every position counts as outside.
        let small = low > -MOST && high < MOST && count < i64::from(u32::MAX / 2);
        let count = if small { count.max(0) as u32 } else { 0 };
        starts.inside = !starts.first.iter().fold(false, |any, &first| any | (first >= count));
        starts
    }
}

/// Indices of a lattice that are whole numbers with room to spare in an f64.
const MOST: f64 = 1e15;
