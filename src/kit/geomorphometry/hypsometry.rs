//! How heights are spread between the lowest and the highest.

use serde::Serialize;

use super::Land;
use super::sums::{Moments, percentiles, sums};

/// Heights as a whole, in metres, and how they are spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hypsometry {
    /// Lowest height of land, in metres.
    pub lowest: f64,
    /// Highest height, in metres.
    pub highest: f64,
    /// Difference between the two, in metres.
    pub relief: f64,
    /// Mean height, in metres.
    pub mean: f64,
    /// Standard deviation of the heights, in metres.
    pub deviation: f64,
    /// Skewness of the heights: above 0 where few stand out upwards.
    pub skewness: f64,
    /// Hypsometric integral \[strahler1952\], `(mean − lowest) / relief`, 0 to 1; 0 of a plain.
    pub integral: f64,
    /// The same between the 0.5 and the 99.5 percentile, with heights beyond them cut off.
    pub robust_integral: f64,
}

impl Hypsometry {
    /// The figures of some land; none where there is no land.
    pub fn of(land: &Land) -> Option<Self> {
        let mut heights: Vec<f32> = land.heights().iter().copied().filter(|z| z.is_finite()).collect();
        let Moments { count, mean, deviation, skewness } = Moments::of(&heights)?;
        let [lowest, low, high, highest] = percentiles(&mut heights, [0.0, 0.005, 0.995, 1.0])?;
        let [cut] =
            sums(land.heights(), |z| [if z.is_finite() { f64::from(*z).clamp(low, high) } else { 0.0 }]);
        let share =
            |mean: f64, low: f64, high: f64| if high > low { (mean - low) / (high - low) } else { 0.0 };
        Some(Self {
            lowest,
            highest,
            relief: highest - lowest,
            mean,
            deviation,
            skewness,
            integral: share(mean, lowest, highest),
            robust_integral: share(cut / count as f64, low, high),
        })
    }
}
