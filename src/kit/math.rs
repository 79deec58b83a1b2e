//! Functions of single numbers that give the same bits on every machine and vectorise.

/// Radians to degrees.
pub const DEGREES: f32 = 180.0 / std::f32::consts::PI;

/// The whole number nearest to one below 2⁵¹ in size, of two as near the even one; vectorises on every machine, as
/// `round` and `floor` do not.
#[inline(always)]
pub fn nearest_whole(x: f64) -> f64 {
    // A sum with 1.5 · 2⁵² has no bits for fractions.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    (x + ROUND) - ROUND
}

/// The largest power of ten that is not over a positive number.
pub fn decade(x: f64) -> f64 {
    libm::pow(10.0, libm::floor(libm::log10(x.max(1e-300))))
}

/// The angle of a direction in radians, from −π to π, 0 for (0, 0); error below 3e-7.
///
/// Cephes' polynomial for the arc tangent up to π/8 \[moshier1989\], with every other angle folded onto it. Both
/// arguments must be finite.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = (ax.min(ay), ax.max(ay));
    // Above π/8 the angle is π/4 plus that of (small − large) / (small + large).
    let folded = small > 0.414_213_57 * large;
    let (top, bottom) = if folded { (small - large, small + large) } else { (small, large) };
    // Division by a number that is not 0 keeps (0, 0) at 0; no other pair has a bottom this small.
    let t = top / bottom.max(f32::MIN_POSITIVE);
    let z = t * t;
    let series = ((0.080_537_446 * z - 0.138_776_86) * z + 0.199_777_11) * z - 0.333_329_5;
    let eighth = series * z * t + t + if folded { FRAC_PI_4 } else { 0.0 };
    let quarter = if ay > ax { FRAC_PI_2 - eighth } else { eighth };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

/// The compass direction of a vector in degrees: 0 north, 90 east, below 360; 0 for (0, 0).
#[inline]
pub fn compass(east: f32, north: f32) -> f32 {
    let angle = atan2(east, north) * DEGREES;
    let turned = if angle < 0.0 { angle + 360.0 } else { angle };
    // A tiny negative angle rounds up to 360.
    if turned >= 360.0 { 0.0 } else { turned }
}

/// Rises from 0 at `u = 0` to 1 at `u = 1` without kinks: `3u² − 2u³`, clipped.
#[inline]
pub fn smooth(u: f32) -> f32 {
    let u = u.clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// The number within `±limit`; NaN becomes a limit too.
#[inline]
#[allow(clippy::manual_clamp, reason = "`clamp` keeps NaN, and a field must be finite")]
pub fn within(x: f32, limit: f32) -> f32 {
    x.max(-limit).min(limit)
}

/// A range of a quantity that is chosen whole, and how far beyond it the choice fades out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    low: f32,
    high: f32,
    per_soft: f32,
}

impl Band {
    /// From `low` to `high`, both included, fading over `soft` beyond either; all in the quantity's unit.
    pub fn new(low: f64, high: f64, soft: f64) -> Self {
        // A soft edge of 0 becomes one too thin for any f32 to stand in.
        Self { low: low as f32, high: high as f32, per_soft: 1.0 / soft.max(1e-30) as f32 }
    }

    /// How far `x` is chosen, from 0 to 1.
    #[inline]
    pub fn weight(&self, x: f32) -> f32 {
        let outside = (self.low - x).max(x - self.high).max(0.0);
        1.0 - smooth(outside * self.per_soft)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_agree_with_libm() {
        let steps = || (-60..=60).map(|i| i as f32 * 0.37 * if i % 7 == 0 { 1e6 } else { 1.0 });
        for (y, x) in steps().flat_map(|y| steps().map(move |x| (y, x))) {
            let want = libm::atan2(f64::from(y), f64::from(x));
            // At π the sign of a zero decides in libm; here a zero has no sign.
            let error = (f64::from(atan2(y, x)) - want).abs();
            assert!(
                error < 3e-7 || y == 0.0 && (error - std::f64::consts::TAU).abs() < 3e-7,
                "{y} {x}: {error}"
            );
        }
    }

    #[test]
    fn compass_names_the_winds() {
        for (east, north, want) in
            [(0.0, 1.0, 0.0), (1.0, 0.0, 90.0), (0.0, -1.0, 180.0), (-1.0, 0.0, 270.0), (-1.0, 1.0, 315.0)]
        {
            assert!((compass(east, north) - want).abs() < 3e-5, "{east} {north}");
        }
        assert_eq!(compass(0.0, 0.0), 0.0);
        assert_eq!(compass(-1e-30, 1.0), 0.0);
    }

    #[test]
    fn nearest_whole_rounds_to_even() {
        for (x, want) in
            [(0.49, 0.0), (0.5, 0.0), (1.5, 2.0), (-2.5, -2.0), (-2.51, -3.0), (1e12 + 0.75, 1e12 + 1.0)]
        {
            assert_eq!(nearest_whole(x), want, "{x}");
        }
    }

    #[test]
    fn within_is_finite() {
        let found = [2.0, -2.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN].map(|x| within(x, 5.0));
        assert_eq!(found, [2.0, -2.0, 5.0, -5.0, -5.0]);
    }

    #[test]
    fn a_band_is_whole_inside_and_fades_beyond() {
        let band = Band::new(10.0, 20.0, 4.0);
        for (x, want) in
            [(5.0, 0.0), (6.0, 0.0), (8.0, 0.5), (10.0, 1.0), (20.0, 1.0), (22.0, 0.5), (24.0, 0.0)]
        {
            assert_eq!(band.weight(x), want, "{x}");
        }
        let hard = Band::new(10.0, 20.0, 0.0);
        assert_eq!([9.999_999, 10.0, 20.0, 20.000_002].map(|x| hard.weight(x)), [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(hard.weight(f32::MAX), 0.0);
    }
}
