//! Voids: named by a number, and closed smoothly from their border inwards.

use rayon::prelude::*;

/// Sweeps over the voids of every level. The start from the coarser level is close: twenty-four sweeps that go a
/// good deal further than each neighbourhood asks bring it within half a percent of the membrane.
const SWEEPS: usize = 24;
/// How much further they go.
const OVERSHOOT: f32 = 1.85;
/// Plain sweeps after those, which smooth out the chequers that overshooting leaves.
const PLAIN: usize = 4;

/// Makes voids (NaN) of the samples that are some number, as `f32` holds it.
pub(super) fn strike(data: &mut [f32], code: Option<f64>) {
    let Some(code) = code.map(|c| c as f32) else { return };
    data.par_iter_mut().filter(|v| **v == code).for_each(|v| *v = f32::NAN);
}

/// Fills voids (NaN) with a membrane: a surface without bumps that hangs from the heights around, `Δh = 0` inside and
/// level at the border of the file.
///
/// The membrane is found from coarse to fine: samples are averaged by fours until no void is left, then each level
/// takes its voids from the coarser one by bilinear interpolation and relaxes them with red-black over-relaxed
/// sweeps. Known heights stay as they are; a filled one never leaves the range of those known. Returns
/// how many were filled, or `None` when there is nothing but voids.
pub fn fill_voids(cols: usize, rows: usize, data: &mut [f32]) -> Option<usize> {
    debug_assert_eq!(data.len(), cols * rows, "one sample per point");
    let count = data.iter().filter(|v| v.is_nan()).count();
    if count == 0 {
        return Some(0);
    }
    if count == data.len() {
        return None;
    }
    let mut levels = vec![pull(cols, rows, data)];
    while let Some(last) = levels.last()
        && last.data.iter().any(|v| v.is_nan())
    {
        let coarser = pull(last.cols, last.rows, &last.data);
        levels.push(coarser);
    }
    while let Some(coarse) = levels.pop() {
        match levels.last_mut() {
            Some(fine) => push(&coarse, fine.cols, fine.rows, &mut fine.data),
            None => push(&coarse, cols, rows, data),
        }
    }
    Some(count)
}

struct Level {
    cols: usize,
    rows: usize,
    data: Vec<f32>,
}

/// The level of half the size: means of what is known among four.
fn pull(cols: usize, rows: usize, data: &[f32]) -> Level {
    let (half, tall) = (cols.div_ceil(2), rows.div_ceil(2));
    let mut coarse = Vec::with_capacity(half * tall);
    for j in 0..tall {
        let upper = &data[2 * j * cols..][..cols];
        let lower = if 2 * j + 1 < rows { &data[(2 * j + 1) * cols..][..cols] } else { upper };
        let pairs = upper.chunks(2).zip(lower.chunks(2));
        coarse.extend(pairs.map(|(a, b)| {
            let known = a.iter().chain(b).filter(|v| !v.is_nan());
            let (sum, n) = known.fold((0.0, 0.0), |(sum, n), v| (sum + f64::from(*v), n + 1.0));
            (sum / n) as f32
        }));
    }
    Level { cols: half, rows: tall, data: coarse }
}

/// Fills the voids of a level from the coarser one and smooths them.
fn push(coarse: &Level, cols: usize, rows: usize, data: &mut [f32]) {
    let voids: Vec<usize> = (0..data.len()).filter(|&k| data[k].is_nan()).collect();
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    let (lo, hi) = coarse.data.iter().chain(data.iter()).fold(none, |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    // A sample lies a quarter of a coarse step from the middle of its four.
    let near = |i: usize, n: usize| {
        let k = i / 2;
        (k, if i.is_multiple_of(2) { k.saturating_sub(1) } else { (k + 1).min(n - 1) })
    };
    for &k in &voids {
        let ((i, i2), (j, j2)) = (near(k % cols, coarse.cols), near(k / cols, coarse.rows));
        let at = |i: usize, j: usize| coarse.data[j * coarse.cols + i];
        let line = |j: usize| 0.75 * at(i, j) + 0.25 * at(i2, j);
        data[k] = 0.75 * line(j) + 0.25 * line(j2);
    }
    let red = |k: &&usize| (*k % cols + *k / cols).is_multiple_of(2);
    let (red, black): (Vec<&usize>, Vec<&usize>) = voids.iter().partition(red);
    for factor in [OVERSHOOT; SWEEPS].into_iter().chain([1.0; PLAIN]) {
        for &&k in red.iter().chain(&black) {
            data[k] += factor * (relaxed(cols, rows, data, k) - data[k]);
        }
    }
    // A membrane lies between the heights it hangs from; overshooting may leave it by a hair.
    for k in voids {
        data[k] = data[k].clamp(lo, hi);
    }
}

/// The mean of the neighbours there are.
fn relaxed(cols: usize, rows: usize, data: &[f32], k: usize) -> f32 {
    let (i, j) = (k % cols, k / cols);
    let (mut sum, mut n) = (0.0, 0.0);
    let mut add = |there: bool, k: usize| {
        if there {
            sum += data[k];
            n += 1.0;
        }
    };
    add(i > 0, k.wrapping_sub(1));
    add(i + 1 < cols, k + 1);
    add(j > 0, k.wrapping_sub(cols));
    add(j + 1 < rows, k + cols);
    // A lone sample has no neighbour, and is no void.
    if n > 0.0 { sum / n } else { data[k] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(cols: usize, rows: usize) -> Vec<f32> {
        (0..cols * rows).map(|k| 500.0 + 3.0 * (k % cols) as f32 - 2.0 * (k / cols) as f32).collect()
    }

    /// A plane is harmonic: the membrane over a hole in it is the plane.
    #[test]
    fn a_hole_in_a_plane_is_filled_with_the_plane() {
        let (cols, rows) = (120, 90);
        let want = plane(cols, rows);
        for radius in [1.5, 4.0, 20.0, 38.0] {
            let hole = |k: usize| {
                let (x, y) = ((k % cols) as f32 - 61.0, (k / cols) as f32 - 44.0);
                x * x + y * y < radius * radius
            };
            let mut got: Vec<f32> =
                want.iter().enumerate().map(|(k, v)| if hole(k) { f32::NAN } else { *v }).collect();
            let holes = (0..got.len()).filter(|k| hole(*k)).count();
            assert_eq!(fill_voids(cols, rows, &mut got), Some(holes));
            let relief = 2.0 * radius * 3.6;
            let worst = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.01 * relief, "radius {radius}: off by {worst} of {relief}");
        }
    }

    /// Against the same equations relaxed until nothing moves.
    #[test]
    fn a_ring_is_filled_with_the_membrane() {
        let n = 81;
        let radius = |k: usize| libm::hypotf((k % n) as f32 - 40.0, (k / n) as f32 - 40.0);
        let start: Vec<f32> = (0..n * n)
            .map(|k| match radius(k) {
                r if r > 5.0 && r < 38.0 => f32::NAN,
                r => (r - 5.0).clamp(0.0, 50.0) * 2.0 + (k % n) as f32,
            })
            .collect();
        let mut got = start.clone();
        fill_voids(n, n, &mut got).expect("something is known");
        let mut want = got.clone();
        for _ in 0..6000 {
            for k in (0..n * n).filter(|k| start[*k].is_nan()) {
                want[k] = relaxed(n, n, &want, k);
            }
        }
        let worst = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 0.01 * 180.0, "off by {worst} m of 180 m");
    }

    #[test]
    fn stays_in_range_and_keeps_what_is_known() {
        for (cols, rows) in [(1, 2), (2, 1), (7, 5), (64, 33)] {
            let known: Vec<f32> = (0..cols * rows)
                .map(|k| {
                    let r = crate::kit::hash::unit(5, k as u64) as f32;
                    if r < 0.7 && k > 0 { f32::NAN } else { r * 100.0 }
                })
                .collect();
            let mut filled = known.clone();
            fill_voids(cols, rows, &mut filled).expect("the first sample is known");
            for (a, b) in known.iter().zip(&filled) {
                assert!(if a.is_nan() { (0.0..=100.0).contains(b) } else { a == b });
            }
        }
        assert_eq!(fill_voids(3, 1, &mut [f32::NAN; 3]), None);
    }
}
