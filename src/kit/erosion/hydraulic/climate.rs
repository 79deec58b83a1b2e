//! What falls on a level and what goes into the air: rain in showers, sources, evaporation.

use super::Settings;
use crate::kit::erosion::ladder::Level;
use crate::kit::hash;
use crate::value::Field;
use crate::work::{Cancelled, Work};

/// Metres a second in a millimetre an hour.
const MM_PER_HOUR: f64 = 1.0 / 3.6e6;

/// Temperature in °C at which evaporation is that of the settings.
const WARM: f64 = 30.0;

/// What waters a level, before showers.
#[derive(Debug)]
pub(super) struct Climate<'a> {
    settings: &'a Settings,
    level: &'a Level,
    /// Even rain, in m/s.
    rain: Vec<f32>,
    /// Water from sources, in m/s; none without them.
    sources: Option<Vec<f32>>,
}

impl<'a> Climate<'a> {
    pub(super) fn new(
        settings: &'a Settings,
        level: &'a Level,
        moisture: Option<&Field>,
        sources: Option<&Field>,
        work: &Work<'_>,
    ) -> Result<Self, Cancelled> {
        let even = settings.rain * MM_PER_HOUR;
        let rain = match moisture {
            Some(moisture) => {
                let share = |m: f32| (even * f64::from(m.clamp(0.0, 1.0))) as f32;
                level.sample(moisture, work)?.into_iter().map(share).collect()
            }
            None => vec![even as f32; level.grid.len()],
        };
        let sources = match sources {
            Some(sources) if settings.source_discharge > 0.0 => {
                Some(springs(level, sources, settings.source_discharge))
            }
            _ => None,
        };
        Ok(Self { settings, level, rain, sources })
    }

    /// The shower slot of a time in seconds: what falls is the same all through it.
    pub(super) fn slot(&self, seconds: f64) -> u64 {
        let showers = &self.settings.showers;
        if showers.strength > 0.0 && showers.seconds > 0.0 { (seconds / showers.seconds) as u64 } else { 0 }
    }

    /// Rain and sources in a slot, in m/s.
    pub(super) fn falling(&self, slot: u64, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
        let showers = &self.settings.showers;
        let cols = self.level.grid.cols;
        let xs: Vec<f64> = (0..cols).map(|i| self.level.grid.x(i)).collect();
        let seed = hash::mix(self.settings.seed ^ hash::mix(slot));
        self.level.fill(work, |j, out| {
            let row = j * cols;
            out.copy_from_slice(&self.rain[row..][..cols]);
            if showers.strength > 0.0 && showers.size > 0.0 {
                let v = self.level.grid.y(j) / showers.size;
                for (out, x) in out.iter_mut().zip(&xs) {
                    let factor =
                        1.0 + showers.strength.min(1.0) * (shower(seed, [x / showers.size, v]) - 1.0);
                    *out = (f64::from(*out) * factor) as f32;
                }
            }
            if let Some(sources) = &self.sources {
                out.iter_mut().zip(&sources[row..][..cols]).for_each(|(out, source)| *out += source);
            }
        })
    }

    /// Evaporation at the points of the level, in m/s; none where nothing goes into the air.
    pub(super) fn evaporation(
        &self,
        temperature: Option<&Field>,
        work: &Work<'_>,
    ) -> Result<Option<Vec<f32>>, Cancelled> {
        let most = self.settings.evaporation * MM_PER_HOUR;
        if most <= 0.0 {
            return Ok(None);
        }
        let Some(temperature) = temperature else {
            return Ok(Some(vec![most as f32; self.level.grid.len()]));
        };
        let rate = |t: f32| (most * f64::from(t).max(0.0) / WARM) as f32;
        Ok(Some(self.level.sample(temperature, work)?.into_iter().map(rate).collect()))
    }
}

/// How much more rain than its mean falls at a place, in shower widths from the origin of the world: 0 to 3, 1 on average.
fn shower(seed: u64, [u, v]: [f64; 2]) -> f64 {
    let (i, j) = (u.floor(), v.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (a, b) = (ease(u - i), ease(v - j));
    let at = |x: f64, y: f64| {
        let chance = hash::unit(seed ^ hash::mix((x as i64) as u64), (y as i64) as u64);
        3.0 * chance * chance
    };
    let row = |y: f64| at(i, y) + (at(i + 1.0, y) - at(i, y)) * a;
    row(j) + (row(j + 1.0) - row(j)) * b
}

/// A discharge in m³/s shared out over a mask of the base grid, as m/s at the points of a level. Each base sample gives what it
/// has to the four points around it, so that a spring between the points of a coarse level flows as well.
fn springs(level: &Level, mask: &Field, discharge: f64) -> Vec<f32> {
    let base = Level::of(mask.grid());
    let (cols, rows) = (level.grid.cols, level.grid.rows);
    let mut points = vec![0.0f64; level.grid.len()];
    let mut whole = 0.0;
    for (k, &share) in mask.data().iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let share = f64::from(share.min(1.0));
        let [u, v] = [k % mask.grid().cols, k / mask.grid().cols].map(|i| base.steps_on(level, i));
        let (i, j) = ((u as usize).min(cols - 1), (v as usize).min(rows - 1));
        let (a, b) = ((u - i as f64).min(1.0), (v - j as f64).min(1.0));
        let (east, south) = ((i + 1).min(cols - 1), (j + 1).min(rows - 1));
        points[j * cols + i] += share * (1.0 - a) * (1.0 - b);
        points[j * cols + east] += share * a * (1.0 - b);
        points[south * cols + i] += share * (1.0 - a) * b;
        points[south * cols + east] += share * a * b;
        whole += share;
    }
    let per_share = if whole > 0.0 { discharge / (whole * level.cell_area()) } else { 0.0 };
    points.into_iter().map(|share| (share * per_share) as f32).collect()
}
