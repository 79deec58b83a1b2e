//! Sums, moments and percentiles that are the same for any number of threads.

use rayon::prelude::*;

/// Values that one task sums up.
const BLOCK: usize = 1 << 16;

/// The sums of some functions of each value: block by block at the same time, and the blocks in their order.
pub(super) fn sums<T: Sync, const N: usize>(values: &[T], f: impl Fn(&T) -> [f64; N] + Sync) -> [f64; N] {
    let of_block = |block: &[T]| block.iter().fold([0.0; N], |sums, value| plus(sums, f(value)));
    let blocks: Vec<[f64; N]> = values.par_chunks(BLOCK).map(of_block).collect();
    blocks.into_iter().fold([0.0; N], plus)
}

/// The sum of two lists, number by number.
pub(super) fn plus<const N: usize>(mut a: [f64; N], b: [f64; N]) -> [f64; N] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

/// Mean, deviation and skewness of the finite among some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moments {
    pub(super) count: usize,
    pub(super) mean: f64,
    /// Standard deviation of the values themselves, not of a population behind them.
    pub(super) deviation: f64,
    /// Third central moment over the third power of the deviation; 0 where all values are the same.
    pub(super) skewness: f64,
}

impl Moments {
    /// The moments of the finite among some values; none where there is none.
    pub(super) fn of(values: &[f32]) -> Option<Self> {
        let finite =
            |z: &f32, f: fn(f64) -> [f64; 2]| if z.is_finite() { f(f64::from(*z)) } else { [0.0; 2] };
        let [count, sum] = sums(values, |z| finite(z, |z| [1.0, z]));
        let mean = sum / count;
        let [second, third] = sums(values, |z| {
            let d = if z.is_finite() { f64::from(*z) - mean } else { 0.0 };
            [d * d, d * d * d]
        });
        let deviation = (second / count).sqrt();
        let skewness =
            if deviation > 0.0 { third / count / (deviation * deviation * deviation) } else { 0.0 };
        (count > 0.0).then_some(Self { count: count as usize, mean, deviation, skewness })
    }
}

/// Percentiles, given as rising shares from 0 to 1, by straight lines between the values next to the rank; the order of
/// the values is lost. None where there is no value.
pub(super) fn percentiles<const N: usize>(values: &mut [f32], shares: [f64; N]) -> Option<[f64; N]> {
    let last = values.len().checked_sub(1)?;
    // What is below the rank that was found last needs no further look.
    let mut from = 0;
    Some(shares.map(|share| {
        let rank = share.clamp(0.0, 1.0) * last as f64;
        let k = (rank as usize).max(from);
        let (_, &mut low, above) = values[from..].select_nth_unstable_by(k - from, f32::total_cmp);
        let high = above.iter().copied().min_by(f32::total_cmp).unwrap_or(low);
        from = k;
        f64::from(low) + (rank - k as f64).max(0.0) * (f64::from(high) - f64::from(low))
    }))
}
