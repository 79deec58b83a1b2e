//! Numbers that mark voids in many files, and of which the file says nothing: an extreme far from all others.

use rayon::prelude::*;

/// How far such a number must be from all others, in metres.
const FAR: f32 = 500.0;
/// No height of the Earth is so far from the sea, up or down, and stands alone.
const FARTHEST_HEIGHT: f32 = 9000.0;

/// A number that looks like a mark of voids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Suspect {
    pub(super) code: f32,
    /// How many samples are exactly this.
    pub(super) count: u64,
    /// Whether it is above all others.
    above: bool,
}

/// The lowest number of some, and what is next to it.
#[derive(Clone, Copy, Debug)]
struct Lowest {
    value: f32,
    count: u64,
    next: f32,
}

impl Lowest {
    const NONE: Self = Self { value: f32::INFINITY, count: 0, next: f32::INFINITY };

    /// With another number; a void changes nothing.
    fn with(self, v: f32) -> Self {
        if v > self.value {
            Self { next: self.next.min(v), ..self }
        } else if v == self.value {
            Self { count: self.count + 1, ..self }
        } else if v < self.value {
            Self { value: v, count: 1, next: self.value }
        } else {
            self
        }
    }

    fn and(self, other: Self) -> Self {
        let (low, high) = if other.value < self.value { (other, self) } else { (self, other) };
        if low.value == high.value {
            Self { count: low.count + high.count, next: low.next.min(high.next), ..low }
        } else {
            Self { next: low.next.min(high.value), ..low }
        }
    }

    /// Whether it stands apart from others that go up to some number.
    fn is_apart(self, highest: f32, metres: bool) -> bool {
        let (gap, spread) = (self.next - self.value, highest - self.next);
        if gap.is_nan() || gap <= FAR || !self.next.is_finite() {
            return false;
        }
        // The unit of plain numbers is not known: only what lies farther off than all others are wide tells.
        // Nor does a gap tell much where the others are no heights of the Earth: those of a coarse ramp are as wide.
        let others = self.next.abs() <= FARTHEST_HEIGHT && highest.abs() <= FARTHEST_HEIGHT;
        let several = self.count > 1 && spread > 0.0;
        let far = self.value.abs() > FARTHEST_HEIGHT;
        (spread > 0.0 && gap > spread) || (metres && others && (several || far))
    }
}

/// The lowest and the highest number, where they look like marks of voids.
pub(super) fn suspects(data: &[f32], metres: bool) -> Vec<Suspect> {
    let both = |[low, high]: [Lowest; 2], v: &f32| [low.with(*v), high.with(-*v)];
    let start = || [Lowest::NONE; 2];
    let [low, high] =
        data.par_chunks(1 << 16).map(|chunk| chunk.iter().fold(start(), both)).reduce(start, |a, b| {
            let ([a, b], [c, d]) = (a, b);
            [a.and(c), b.and(d)]
        });
    let low_ends = if high.is_apart(-low.value, metres) { -high.next } else { -high.value };
    let high_ends = if low.is_apart(low_ends, metres) { -low.next } else { -low.value };
    let below = low.is_apart(low_ends, metres);
    let below = below.then_some(Suspect { code: low.value, count: low.count, above: false });
    let above = high.is_apart(high_ends, metres);
    let above = above.then_some(Suspect { code: -high.value, count: high.count, above: true });
    below.into_iter().chain(above).collect()
}

impl Suspect {
    /// What a person should know; `plain` is whether the number is the one that the file holds.
    pub(super) fn note(&self, plain: bool) -> String {
        let Self { code, count, above } = *self;
        let code = if code.abs() < 1e15 { code.to_string() } else { format!("{code:e}") };
        let samples = if count == 1 { "one sample is".into() } else { format!("{count} samples are") };
        let side = if above { "above" } else { "below" };
        let nodata = if plain { code.clone() } else { "with the number of the file".into() };
        format!("{samples} {code}, far {side} all others: `nodata` {nodata} would make voids of them")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(data: &[f32], metres: bool) -> Vec<f32> {
        suspects(data, metres).iter().map(|s| s.code).collect()
    }

    /// A hillside of 283 to 984 m with a hole of some number in it.
    fn with_hole(code: f32) -> Vec<f32> {
        let mut data: Vec<f32> = (0..1000).map(|k| 283.0 + 0.7 * k as f32).collect();
        data[400..420].fill(code);
        data
    }

    #[test]
    fn numbers_of_all_kinds_are_found() {
        for code in [
            1e20, 1e10, -1e10, -99999.9, -9999.9, -9999.0, -9998.0, -999.0, 9999.0, 32767.0, -32768.0,
            65535.0, 99999.0,
        ] {
            assert_eq!(codes(&with_hole(code), true), [code], "{code}");
            let found = suspects(&with_hole(code), true);
            let note = found[0].note(true);
            assert!(note.starts_with("20 samples are") && note.contains("would make voids"), "{note}");
        }
        let mut both = with_hole(-9999.0);
        both[7] = 1e10;
        assert_eq!(codes(&both, true), [-9999.0, 1e10]);
    }

    #[test]
    fn heights_are_none() {
        assert!(codes(&with_hole(f32::NAN), true).is_empty());
        assert!(codes(&with_hole(600.0), true).is_empty());
        assert!(codes(&[], true).is_empty() && codes(&[f32::NAN; 3], true).is_empty());
        assert!(codes(&[5.0; 100], true).is_empty());
        // A black and white mask, and the Earth from its deepest trench to its highest mountain.
        assert!(codes(&[0.0, 65535.0, 0.0, 65535.0], false).is_empty());
        let earth: Vec<f32> = (-10_935..8849).map(|z| z as f32).collect();
        assert!(codes(&earth, true).is_empty());
        // One summit that stands apart by less than the others are wide.
        let summit: Vec<f32> = (0..3000).map(|z| z as f32).chain([3600.0]).collect();
        assert!(codes(&summit, true).is_empty());
        // Even ramps far above all mountains, with each number once and with each many times.
        let ramp: Vec<f32> = (0..210).map(|k| 100_000.0 + 1000.0 * k as f32).collect();
        assert!(codes(&ramp, true).is_empty());
        let coarse: Vec<f32> = (0..400).map(|k| 100_000.0 + 10_000.0 * (k % 20) as f32).collect();
        assert!(codes(&coarse, true).is_empty());
    }
}
