//! Values as integers of a range.

use rayon::prelude::*;

use super::error::WriteError;

/// Makes integers from 0 to `levels` of values in a range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantizer {
    range: [f64; 2],
    scale: f64,
    levels: f64,
}

impl Quantizer {
    pub(super) fn new(range: [f64; 2], levels: f64) -> Result<Self, WriteError> {
        let [lo, hi] = range;
        let scale = levels / (hi - lo);
        if !(lo < hi && scale.is_normal()) {
            return Err(WriteError::Range(range));
        }
        Ok(Self { range, scale, levels })
    }

    /// The integer nearest to a value, held in the range.
    pub(super) fn level(&self, v: f32) -> i32 {
        // Cutting off is rounding down for what is not negative, and faster than asking for it.
        self.raised(v).clamp(0.0, self.levels) as i32
    }

    /// Steps from the lower end, half a step more: its whole part is the nearest integer.
    fn raised(&self, v: f32) -> f64 {
        (f64::from(v) - self.range[0]) * self.scale + 0.5
    }

    /// Value of one step.
    pub(super) fn step(&self) -> f64 {
        (self.range[1] - self.range[0]) / self.levels
    }

    /// How many values have no integer of their own; voids are not counted.
    pub(super) fn clipped(&self, values: &[f32]) -> u64 {
        let outside = |v: &f32| {
            let n = self.raised(*v);
            u64::from(n < 0.0) + u64::from(n >= self.levels + 1.0)
        };
        values.par_chunks(1 << 16).map(|c| c.iter().map(outside).sum::<u64>()).sum()
    }

    /// Checks that all values lie in the range, or may be clipped; gives how many do not.
    pub(super) fn check(&self, values: &[f32], clip: bool) -> Result<u64, WriteError> {
        let count = self.clipped(values);
        if count == 0 || clip {
            return Ok(count);
        }
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let [min, max] = values.iter().fold(none, |[lo, hi], &v| [lo.min(v), hi.max(v)]);
        Err(WriteError::Clipped { count, of: values.len() as u64, range: self.range, min, max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_integer_comes_back() {
        for range in [[0.0, 65535.0], [-256.0, 1792.0], [0.0, 1.0], [-1e-3, 9e5]] {
            let q = Quantizer::new(range, 65535.0).expect("a range");
            for n in 0..=65535 {
                let v = (range[0] + f64::from(n) * q.step()) as f32;
                assert_eq!(q.level(v), n, "{n} of {range:?}");
            }
        }
    }

    #[test]
    fn what_rounds_into_the_range_is_not_clipped() {
        let q = Quantizer::new([0.0, 100.0], 100.0).expect("a range");
        assert_eq!(q.clipped(&[-0.4, 0.0, 100.0, 100.49, f32::NAN]), 0);
        assert_eq!(q.clipped(&[-0.6, 100.6, f32::INFINITY, f32::NEG_INFINITY]), 4);
        let error = q.check(&[1.0, -7.5], false).expect_err("one is outside");
        assert!(error.to_string().contains("1 of 2") && error.to_string().contains("-7.5"), "{error}");
        assert_eq!(q.check(&[1.0, -7.5], true).expect("allowed"), 1);
        for bad in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert!(Quantizer::new(bad, 255.0).is_err(), "{bad:?}");
        }
    }
}
