//! Colours of the ground.

use super::plane::Plane;
use super::surface::Surface;
use super::{GroundPalette, Scene};
use crate::kit::color::linear_from_srgb;
use crate::kit::hash;
use crate::kit::ramp::{Blend, Ramp, satellite};
use crate::node::Result;
use crate::work::Work;

/// Relief, in metres, below which highlands are drawn without snow, and above which with all of it: a hill of
/// 100 m has a top, but no snow line.
const SNOW_RELIEF: [f32; 2] = [400.0, 1100.0];
/// The clay of [`GroundPalette::Clay`], linear.
const CLAY: [f32; 3] = [0.52, 0.48, 0.435];

/// The ground of a scene: its colour anywhere.
pub(super) struct Material<'a> {
    surface: &'a Surface,
    paint: Paint,
    /// Lowest land and one over the range of the land, in the units of the surface.
    land: [f32; 2],
    /// What slopes count as, so that the steep share of any land is rock.
    steepness: f32,
    /// The share of heights that is never reached without snow.
    top: f32,
    /// Size of a patch of the pattern that breaks up bands, in samples.
    patch: f64,
    decode: Vec<f32>,
}

enum Paint {
    Own,
    Satellite,
    Clay,
    Ramp(Ramp),
}

impl<'a> Material<'a> {
    pub(super) fn new(scene: &Scene<'_>, surface: &'a Surface, work: &Work<'_>) -> Result<Self> {
        let paint = match &scene.palette {
            _ if surface.color.is_some() => Paint::Own,
            GroundPalette::Satellite => Paint::Satellite,
            GroundPalette::Clay => Paint::Clay,
            GroundPalette::Ramp(palette) => Paint::Ramp(Ramp::of(palette, Blend::Smooth)),
        };
        let (low, high) = land_range(surface);
        let relief = (high - low) / surface.exaggeration;
        let slopes = Slopes::of(surface, work)?;
        // Rock begins at about 30° on the ramp; the steepest seventh of a land is rock, but never what is nearly flat,
        // nor is a land of cliffs all rock.
        let steepness = 31.0 / slopes.quantile(0.86).clamp(17.0, 42.0);
        let snow = rise(SNOW_RELIEF[0], SNOW_RELIEF[1], relief);
        Ok(Self {
            surface,
            paint,
            land: [low, if high > low { 1.0 / (high - low) } else { 0.0 }],
            steepness,
            top: 0.62 + 0.38 * snow,
            patch: (surface.z.cols.max(surface.z.rows) as f64 / 90.0).max(3.0),
            decode: (0..=1024).map(|k| linear_from_srgb(k as f32 / 1024.0)).collect(),
        })
    }

    /// The colour at a sample, linear, 0 to 1; `openness` is the share of the sky that it sees.
    pub(super) fn color(&self, i: usize, j: usize, openness: f32) -> [f32; 3] {
        let surface = self.surface;
        let share = ((surface.z.row(j)[i] - self.land[0]) * self.land[1]).clamp(0.0, 1.0);
        let encoded = match &self.paint {
            Paint::Clay => return CLAY,
            Paint::Own => surface.color.as_ref().map_or([0.5; 3], |color| color.row(j)[i]),
            Paint::Ramp(ramp) => ramp.color(share),
            Paint::Satellite => {
                let slope = slope_degrees(surface, i, j);
                let patches = self.patches(i, j);
                // Hollows hold soil and woods, crests are bare: shelter moves the height at which things grow.
                let shelter = (openness - 0.88).clamp(-0.35, 0.12);
                let share = share * self.top + 0.11 * patches + 0.28 * shelter * (0.3 + share);
                satellite(share, slope * self.steepness + 5.0 * patches)
            }
        };
        let light = encoded.map(|x| self.linear(x));
        // A ramp has the colours of leaves and stones near by; the air between makes land paler and warmer.
        let paler = |share: f32| {
            let grey = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
            light.map(|x| x + share * (grey - x))
        };
        match self.paint {
            Paint::Satellite => {
                let grain = 1.0 + 0.10 * self.patches(i.wrapping_mul(3), j.wrapping_mul(3));
                let [r, g, b] = paler(0.22).map(|x| x * grain);
                [1.14 * r + 0.012, 1.04 * g + 0.009, 0.97 * b + 0.006]
            }
            Paint::Ramp(_) => paler(0.12),
            Paint::Own | Paint::Clay => light,
        }
    }

    fn linear(&self, encoded: f32) -> f32 {
        let x = if encoded > 0.0 { encoded.min(1.0) } else { 0.0 } * 1024.0;
        let k = (x as usize).min(1023);
        self.decode[k] + (self.decode[k + 1] - self.decode[k]) * (x - k as f32)
    }

    /// Patches from -1 to 1, of several sizes.
    fn patches(&self, i: usize, j: usize) -> f32 {
        let mut sum = 0.0;
        for (octave, weight) in [(1.0, 0.5), (2.7, 0.3), (7.1, 0.2)] {
            let scale = octave / self.patch;
            // Each size is turned against the last, so that no lattice shows.
            let (x, y) = (i as f64 * scale, j as f64 * scale);
            sum += weight * patch(0.8 * x - 0.6 * y + 7.0 * octave, 0.6 * x + 0.8 * y);
        }
        sum as f32
    }
}

/// Smooth random values from -1 to 1 on the unit lattice.
fn patch(x: f64, y: f64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let ease = |u: f64| u * u * u * (u * (u * 6.0 - 15.0) + 10.0);
    let (u, v) = (ease(x - i), ease(y - j));
    let value = |a: i64, b: i64| {
        let index = ((i as i64 + a) as u64) << 32 | u64::from((j as i64 + b) as u32);
        hash::unit(0x7061_7463, index) * 2.0 - 1.0
    };
    let top = value(0, 0) + u * (value(1, 0) - value(0, 0));
    let bottom = value(0, 1) + u * (value(1, 1) - value(0, 1));
    top + v * (bottom - top)
}

/// Steepness of the ground as it is, without exaggeration.
fn slope_degrees(surface: &Surface, i: usize, j: usize) -> f32 {
    let [east, south, up] = Surface::normal(&surface.z, surface.cell, i, j);
    let flat = (east * east + south * south).sqrt() / surface.exaggeration;
    libm::atan2f(flat, up).to_degrees()
}

pub(super) fn rise(low: f32, high: f32, x: f32) -> f32 {
    let u = ((x - low) / (high - low)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Lowest and highest dry sample; those of all where none is dry.
fn land_range(surface: &Surface) -> (f32, f32) {
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    let widen = |(low, high): (f32, f32), &z: &f32| (low.min(z), high.max(z));
    let sea = surface.sea.unwrap_or(f32::NEG_INFINITY);
    let dry = surface.z.data.iter().filter(|&&z| z > sea).fold(none, widen);
    if dry.0 <= dry.1 { dry } else { (0.0, surface.highest) }
}

/// How often which slope occurs on the land.
struct Slopes([u64; 91]);

impl Slopes {
    fn of(surface: &Surface, work: &Work<'_>) -> Result<Self> {
        // A sample of the rows tells enough.
        let stride = (surface.z.rows / 256).max(1);
        let rows = surface.z.rows.div_ceil(stride);
        let sea = surface.sea.unwrap_or(f32::NEG_INFINITY);
        let slopes: Plane<f32> = Plane::fill(work, [surface.z.cols, rows], |n, out| {
            let j = n * stride;
            for (i, out) in out.iter_mut().enumerate() {
                *out = if surface.z.row(j)[i] > sea { slope_degrees(surface, i, j) } else { -1.0 };
            }
        })?;
        let mut counts = [0; 91];
        for &slope in slopes.data.iter().filter(|&&slope| slope >= 0.0) {
            counts[(slope as usize).min(90)] += 1;
        }
        Ok(Self(counts))
    }

    /// The slope that this share of the land does not reach; 0 where there is no land.
    fn quantile(&self, share: f32) -> f32 {
        let target = (self.0.iter().sum::<u64>() as f64 * f64::from(share)) as u64;
        let mut seen = 0;
        for (degrees, &count) in self.0.iter().enumerate() {
            if seen + count > target {
                return degrees as f32 + (target - seen) as f32 / count as f32;
            }
            seen += count;
        }
        0.0
    }
}
