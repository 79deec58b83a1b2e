//! Numbers about a whole field: range, quantiles, histogram.

use rayon::prelude::*;

use crate::value::Field;

/// Lowest and highest value, after leaving out the share `clip` of all samples at either end; 0 and 0 of nothing.
pub fn range(field: &Field, clip: f64) -> [f64; 2] {
    let skip = (clip.clamp(0.0, 0.5) * field.data().len() as f64).floor() as usize;
    let n = field.data().len();
    if skip == 0 || n == 0 {
        let (lo, hi) = field.range().unwrap_or((0.0, 0.0));
        return [f64::from(lo), f64::from(hi)];
    }
    let mut sorted = field.data().to_vec();
    let skip = skip.min((n - 1) / 2);
    let (_, &mut lo, above) = sorted.select_nth_unstable_by(skip, f32::total_cmp);
    let wanted = n - 1 - 2 * skip;
    let hi = match wanted.checked_sub(1) {
        Some(i) => *above.select_nth_unstable_by(i, f32::total_cmp).1,
        None => lo,
    };
    [f64::from(lo), f64::from(hi)]
}

/// How many samples fall into each of some equal bins from `lo` to `hi`; what lies beyond counts to the end bins.
pub fn histogram(field: &Field, [lo, hi]: [f64; 2], bins: usize) -> Vec<u64> {
    let (last, scale) = (bins.max(1) - 1, bins as f64 / (hi - lo).max(f64::MIN_POSITIVE));
    let count = |chunk: &[f32]| {
        let mut counts = vec![0u64; last + 1];
        for &x in chunk {
            counts[(((f64::from(x) - lo) * scale) as usize).min(last)] += 1;
        }
        counts
    };
    // Whole numbers add up to the same in any order.
    field.data().par_chunks(1 << 20).map(count).reduce(
        || vec![0; last + 1],
        |mut a, b| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        },
    )
}
