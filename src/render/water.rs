//! Water from above: what the eye sees of it and through it, without reflections.

use super::plane::{Plane, resampled};
use super::surface::{Surface, working_grid};
use crate::node::Result;
use crate::work::Work;

/// How fast water swallows red, green and blue, relative to each other.
const SWALLOWED: [f32; 3] = [2.3, 0.95, 0.62];
/// The colour that deep water sends back, linear.
const DEEP: [f32; 3] = [0.010, 0.050, 0.105];
/// The colour that sunlit shallow water scatters back, linear.
const SHALLOW: [f32; 3] = [0.060, 0.235, 0.270];
/// The sea floor near the coast, linear.
const FLOOR: [f32; 3] = [0.42, 0.37, 0.26];
/// Depth that all water has, in units of its clarity, so that a shore is seen as one.
const WET: f32 = 0.25;
/// Samples of the grid on which the nearness of a coast is found.
const COAST_GRID: usize = 256;
/// How far shallows and shelf reach into a sea without depths, in samples of that grid.
const COAST_REACH: [f64; 2] = [2.0, 14.0];

/// The water of a scene.
pub(super) struct Water {
    /// Height of its surface.
    pub(super) level: f32,
    /// The depth at which a third of the light is left, in the units of the surface.
    clarity: f32,
    /// How near the coast is, 0 to 1, where the sea has no depths of its own.
    coast: Option<Coast>,
}

/// How near the coast is, on a coarse grid.
struct Coast {
    near: Plane<f32>,
    /// Steps of this plane in one step of the surface.
    scale: f64,
}

impl Water {
    /// The water of a surface; `None` when there is none.
    pub(super) fn new(surface: &Surface, work: &Work<'_>) -> Result<Option<Self>> {
        let Some(level) = surface.sea else { return Ok(None) };
        let (mut wet, mut volume) = (0u64, 0.0f64);
        for &z in surface.z.data.iter().filter(|&&z| z <= level) {
            wet += 1;
            volume += f64::from(level - z);
        }
        if wet == 0 {
            return Ok(None);
        }
        let mean = (volume / wet as f64) as f32;
        // Elevation models often hold the sea as a flat sheet at its level: its depth is unknown, and drawn as if it
        // fell off from the coast.
        let relief = surface.highest - level;
        let unknown = mean < 0.004 * relief || mean <= 1e-3 * surface.exaggeration;
        let coast = if unknown { Some(Coast::of(surface, level, work)?) } else { None };
        Ok(Some(Self { level, clarity: (0.35 * mean).max(4.0 * surface.exaggeration), coast }))
    }

    /// The colour that the water sends back under full daylight, at a sample.
    pub(super) fn color(&self, i: usize, j: usize, z: f32) -> [f32; 3] {
        let depth = match &self.coast {
            None => WET + (self.level - z).max(0.0) / self.clarity,
            Some(coast) => {
                let near = coast.at(i, j);
                2.2 * WET + 4.2 * (1.0 - near) * (1.0 - near)
            }
        };
        std::array::from_fn(|k| {
            let left = libm::expf(-SWALLOWED[k] * depth);
            let scattered = libm::expf(-0.55 * depth);
            FLOOR[k] * left * 0.8 + (1.0 - left) * (DEEP[k] + (SHALLOW[k] - DEEP[k]) * scattered)
        })
    }
}

impl Coast {
    /// Blurs the land: half of it at the coast, none far out.
    fn of(surface: &Surface, level: f32, work: &Work<'_>) -> Result<Self> {
        let from = [surface.z.cols, surface.z.rows];
        let land: Plane<f32> = Plane::fill(work, from, |j, out| {
            for (out, &z) in out.iter_mut().zip(surface.z.row(j)) {
                *out = if z > level { 1.0 } else { 0.0 };
            }
        })?;
        let size = working_grid(from, COAST_GRID);
        let land = resampled(work, &land.data, from, size)?;
        let [shallows, shelf] = COAST_REACH.map(|reach| {
            let across = blurred_rows(&land, reach, work)?.transposed(work)?;
            blurred_rows(&across, reach, work)?.transposed(work)
        });
        let (mut near, shelf) = (shallows?, shelf?);
        for (near, shelf) in near.data.iter_mut().zip(&shelf.data) {
            *near = 0.55 * *near + 0.45 * shelf;
        }
        Ok(Self { near, scale: size[0] as f64 / from[0] as f64 })
    }

    fn at(&self, i: usize, j: usize) -> f32 {
        let place = |k: usize| (k as f64 + 0.5) * self.scale - 0.5;
        (2.0 * self.near.at(place(i), place(j))).min(1.0)
    }
}

fn blurred_rows(plane: &Plane<f32>, sigma: f64, work: &Work<'_>) -> Result<Plane<f32>> {
    let reach = (3.0 * sigma) as i64;
    let weight = |n: i64| libm::exp(-0.5 * (n as f64 / sigma) * (n as f64 / sigma));
    let total: f64 = (-reach..=reach).map(weight).sum();
    let kernel: Vec<f32> = (-reach..=reach).map(|n| (weight(n) / total) as f32).collect();
    Plane::fill(work, [plane.cols, plane.rows], |j, out| {
        let (row, last) = (plane.row(j), plane.cols as i64 - 1);
        for (i, out) in (0i64..).zip(out) {
            let tap = |(n, &w): (i64, &f32)| w * row[(i + n - reach).clamp(0, last) as usize];
            *out = (0i64..).zip(&kernel).map(tap).sum();
        }
    })
}
