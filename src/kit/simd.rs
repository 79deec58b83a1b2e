//! One source, several instruction sets, the same bits.
//!
//! A kernel is written once, as plain loops over slices of `f32` and `u32` without branches, and compiled for each
//! [`Level`]; the compiler turns the loops into vector code. Rust never reorders or contracts floating-point
//! arithmetic, and addition, multiplication, square root and conversion round the same in every lane width, so all
//! levels give the same bits; the tests hold them to it.
//!
//! This is done by hand rather than by a crate because tests must be able to force a level (`multiversion` hides its
//! choice) and because kernels that the compiler vectorises need no vector types (`pulp`, `wide`, `fearless_simd`).

use std::fmt;
use std::sync::OnceLock;

/// Work that can be compiled for several instruction sets.
///
/// `run` and all it calls inside its loops must be `#[inline(always)]`: what is not inlined is compiled for the
/// baseline, which is as right and several times slower.
pub trait Kernel {
    /// Does the work.
    fn run(self);
}

/// An instruction set that this machine has: a value of this type is the proof.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Level(Set);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Set {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// What every machine of the target has: SSE2 on x86-64, NEON on 64-bit ARM.
    pub const BASELINE: Self = Self(Set::Baseline);

    /// All that this machine has, the narrowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut, reason = "other targets have the baseline alone")]
        let mut levels = vec![Self::BASELINE];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                levels.push(Self(Set::Avx2));
            }
            if has_avx512() {
                levels.push(Self(Set::Avx512));
            }
        }
        levels
    }

    /// The widest that this machine has, or the one that the environment variable `OROGRAPH_SIMD` names
    /// (`baseline`, `avx2`, `avx512`) when the machine has it.
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| {
            let levels = Self::available();
            let wanted = std::env::var("OROGRAPH_SIMD").unwrap_or_default();
            let named = levels.iter().find(|l| l.name() == wanted);
            *named.or(levels.last()).unwrap_or(&Self::BASELINE)
        })
    }

    /// What `OROGRAPH_SIMD` says and this machine does not know, with the names that it does.
    pub fn unknown() -> Option<String> {
        let wanted = std::env::var_os("OROGRAPH_SIMD").filter(|w| !w.is_empty())?;
        let names: Vec<_> = Self::available().into_iter().map(Self::name).collect();
        let known = names.iter().any(|name| wanted == **name);
        (!known).then(|| {
            let (wanted, names) = (wanted.to_string_lossy(), names.join(", "));
            format!("OROGRAPH_SIMD must be one of {names} on this machine, got `{wanted}`; it is ignored")
        })
    }

    /// The name for reports and for `OROGRAPH_SIMD`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
        }
    }

    /// Runs a kernel compiled for this level.
    #[allow(
        unsafe_code,
        reason = "a function with target features may only be called where the machine has them"
    )]
    pub fn run<K: Kernel>(self, kernel: K) {
        match self.0 {
            Set::Baseline => kernel.run(),
            // SAFETY: `Set` is private and `available` makes the value only when the machine has AVX2.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { run_avx2(kernel) },
            // SAFETY: as above, for the four AVX-512 extensions.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { run_avx512(kernel) },
        }
    }
}

impl fmt::Debug for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Whether the machine has the extensions that [`run_avx512`] is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn run_avx512<K: Kernel>(kernel: K) {
    kernel.run();
}

/// The smaller of two numbers in one vector instruction; `f32::min` also asks for NaN, which costs two more. The
/// second when one is NaN.
#[inline(always)]
pub fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers, as [`smaller`].
#[inline(always)]
pub fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Two to the power of `x`, within 3e-7 of the true value relative, for `x` from −126 to 126 and clamped beyond:
/// a polynomial that vectorises, the same bits everywhere.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    // Adding 1.5 · 2²³ rounds to a whole number and leaves it in the low bits of the sum.
    const ROUND: f32 = 12_582_912.0;
    // ln(2)ᵏ / k!
    const C: [f32; 7] = [
        1.0,
        std::f32::consts::LN_2,
        0.240_226_5,
        0.055_504_11,
        0.009_618_129,
        0.001_333_355_8,
        0.000_154_035_3,
    ];
    let x = x.clamp(-126.0, 126.0);
    let rounded = x + ROUND;
    let f = x - (rounded - ROUND);
    let fraction = ((((((C[6] * f + C[5]) * f + C[4]) * f + C[3]) * f + C[2]) * f + C[1]) * f) + C[0];
    let exponent = f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23));
    fraction * exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp2_is_near_the_truth() {
        for i in -125_900..=125_900 {
            let x = i as f32 * 1e-3;
            let (ours, truth) = (f64::from(exp2(x)), libm::exp2(f64::from(x)));
            assert!((ours / truth - 1.0).abs() < 3e-7, "exp2({x}) = {ours}, should be {truth}");
        }
        assert_eq!(exp2(0.0), 1.0);
        assert_eq!(exp2(-3.0), 0.125);
        assert!(exp2(1e30).is_finite() && exp2(-1e30) > 0.0);
    }

    #[test]
    fn the_best_level_is_one_that_the_machine_has() {
        assert!(Level::available().contains(&Level::best()));
        assert_eq!(Level::available()[0], Level::BASELINE);
    }
}
