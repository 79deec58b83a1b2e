//! The colours of a row: the pieces of all places of a block are found together, without a choice of ways.

use super::{PIECE, Ramp, STEPS, Step};
use crate::kit::simd::{Kernel, Level, smaller};

/// Places that are worked on together.
const BLOCK: usize = 64;

impl Ramp {
    /// The colours of a row, each what [`color`](Self::color) gives.
    ///
    /// `places` writes the places on the ramp from an index of `out` on, as many as its slice holds.
    pub fn row(&self, places: impl Fn(usize, &mut [f32]), out: &mut [[f32; 3]]) {
        self.row_on(Level::best(), places, out);
    }

    /// As [`row`](Self::row) on a given instruction set; the bits do not change.
    pub fn row_on(&self, level: Level, places: impl Fn(usize, &mut [f32]), out: &mut [[f32; 3]]) {
        level.run(RowKernel { ramp: self, places, out });
    }
}

/// A row of colours.
struct RowKernel<'a, P> {
    ramp: &'a Ramp,
    places: P,
    out: &'a mut [[f32; 3]],
}

impl<P: Fn(usize, &mut [f32])> Kernel for RowKernel<'_, P> {
    #[inline(always)]
    fn run(self) {
        let Self { ramp, places, out } = self;
        let (mut at, mut steps) = ([0.0; BLOCK], [0; BLOCK]);
        for (block, out) in out.chunks_mut(BLOCK).enumerate() {
            places(block * BLOCK, &mut at[..out.len()]);
            ramp.find(&mut at, &mut steps);
            for ((o, &step), &share) in out.iter_mut().zip(&steps).zip(&at) {
                let Step { color, rise } = &ramp.table[step as usize];
                *o = [color[0] + rise[0] * share, color[1] + rise[1] * share, color[2] + rise[2] * share];
            }
        }
    }
}

impl Ramp {
    /// The steps of the table at places on the ramp, which become the shares of the way through them.
    #[inline(always)]
    pub(super) fn find<const N: usize>(&self, at: &mut [f32; N], steps: &mut [u32; N]) {
        // Adding 2²³ rounds to a whole number and leaves it in the low bits of the sum.
        const ROUND: f32 = 8_388_608.0;
        for t in at.iter_mut() {
            *t = if *t > 0.0 { smaller(*t, 1.0) } else { 0.0 };
        }
        // Pieces rise: the last that begins at or before a place is its own.
        let mut begun = [0u32; N];
        for &(start, _) in &self.pieces {
            for (count, &t) in begun.iter_mut().zip(at.iter()) {
                *count += u32::from(start <= t);
            }
        }
        for (t, &count) in at.iter_mut().zip(&begun) {
            let (start, per_width) = self.pieces[count.max(1) as usize - 1];
            *t = (*t - start) * per_width;
        }
        for ((u, step), &count) in at.iter_mut().zip(steps).zip(&begun) {
            let along = *u * STEPS as f32;
            let near = (along + ROUND) - ROUND;
            let whole = if near > along { near - 1.0 } else { near };
            let within = count > 0 && *u < 1.0;
            // At the end of a piece the next begins, or the colour of the last stop stands.
            let next = count * PIECE as u32;
            let own = next.wrapping_sub(PIECE as u32).wrapping_add((whole + ROUND).to_bits() & 0xFF);
            *step = if within { own } else { next };
            *u = if within { along - whole } else { 0.0 };
        }
    }
}
