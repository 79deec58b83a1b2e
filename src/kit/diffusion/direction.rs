//! Diffused directions.

use rayon::prelude::*;

/// Directions shorter than this after diffusion have cancelled, not faded: diffusion keeps the length of parallel
/// directions at 1.
const CANCELLED: f32 = 1e-3;

/// Gives directions whose components were diffused apart their unit length back \[hnaidi2010, 5.2\]; where they
/// cancelled, both components become 0 and guidance by them has no weight.
pub fn renormalise(x: &mut [f32], y: &mut [f32]) {
    x.par_iter_mut().zip(y).for_each(|(x, y)| {
        let length = (*x * *x + *y * *y).sqrt();
        let over = if length > CANCELLED && length.is_finite() { 1.0 / length } else { 0.0 };
        (*x, *y) = if over > 0.0 { (*x * over, *y * over) } else { (0.0, 0.0) };
    });
}

#[cfg(test)]
mod tests {
    use super::renormalise;

    #[test]
    fn unit_or_none() {
        let (mut x, mut y) = (vec![3.0, 1e-5, f32::NAN, -0.1], vec![4.0, 0.0, 1.0, 0.0]);
        renormalise(&mut x, &mut y);
        assert_eq!((x, y), (vec![0.6, 0.0, 0.0, -1.0], vec![0.8, 0.0, 0.0, 0.0]));
    }
}
