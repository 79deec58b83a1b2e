//! The solid below a terrain: its cut sides, and the floor that it stands on.

use super::horizon::SkyView;
use super::light::Lamp;
use super::material;
use super::plane::Plane;
use super::surface::Surface;
use super::trace::{Ray, Tracer};
use crate::kit::hash;
use crate::node::Result;
use crate::work::Work;

/// Thickness below the lowest sample, as a share of the longer side.
const THICKNESS: f64 = 0.035;
/// Samples along a side of the grid on which the floor's share of the sky is computed.
const FLOOR_GRID: usize = 384;
/// The floor's reflectance, linear.
const FLOOR: [f32; 3] = [0.36, 0.355, 0.345];
/// Rock of the sides, dark and light layers, linear.
const LAYERS: [[f32; 3]; 2] = [[0.105, 0.075, 0.054], [0.31, 0.235, 0.165]];
/// The soil on top of them, linear.
const SOIL: [f32; 3] = [0.045, 0.034, 0.024];
/// Water where it is cut, near its surface and deep down, linear.
const CUT_WATER: [[f32; 3]; 2] = [[0.10, 0.30, 0.36], [0.014, 0.062, 0.125]];

/// Height of the floor in the units of a surface.
pub(super) fn base(surface: &Surface) -> f64 {
    let [width, depth] = surface.extent();
    -THICKNESS * width.max(depth)
}

/// The block of a surface.
pub(super) struct Block {
    pub(super) base: f64,
    /// The share of the sky that the floor sees, on a grid three times as long as the terrain.
    view: SkyView,
    /// Where that grid begins, and its cell, in metres.
    corner: [f64; 2],
    cell: f64,
    extent: [f64; 2],
}

impl Block {
    pub(super) fn new(surface: &Surface, to_sun: [f64; 2], work: &Work<'_>) -> Result<Self> {
        let (extent, base) = (surface.extent(), base(surface));
        let longer = extent[0].max(extent[1]);
        let cell = 3.0 * longer / (FLOOR_GRID - 1) as f64;
        let corner = extent.map(|side| (side - 3.0 * longer) * 0.5);
        let top = surface.top();
        let z: Plane<f32> = Plane::fill(work, [FLOOR_GRID; 2], |j, out| {
            let y = corner[1] + j as f64 * cell;
            for (i, out) in out.iter_mut().enumerate() {
                let x = corner[0] + i as f64 * cell;
                let inside = (0.0..=extent[0]).contains(&x) && (0.0..=extent[1]).contains(&y);
                let height = || (f64::from(top.at(x / surface.cell, y / surface.cell)) - base) as f32;
                *out = if inside { height() } else { 0.0 };
            }
        })?;
        let view = SkyView::new(&z, cell, to_sun, work)?;
        Ok(Self { base, view, corner, cell, extent })
    }

    /// What the floor sends out at a place; `to_sun` is a ray's direction to some part of the sun.
    pub(super) fn floor(
        &self,
        [x, y]: [f64; 2],
        to_sun: [f64; 3],
        tracer: &Tracer<'_>,
        lamp: &Lamp<'_>,
    ) -> [f32; 3] {
        let ray = Ray { origin: [x, y, self.base], direction: to_sun };
        let sun = if tracer.hit(&ray, 0.0).is_some() { 0.0 } else { 1.0 };
        lamp.light(FLOOR, [0.0, 0.0, 1.0], sun, self.sky_at([x, y]))
    }

    /// The share of the sky between samples of the grid; all of it beyond.
    fn sky_at(&self, place: [f64; 2]) -> [f32; 2] {
        let steps = [0, 1].map(|k: usize| (place[k] - self.corner[k]) / self.cell);
        let last = (FLOOR_GRID - 2) as f64;
        if steps.iter().any(|s| !(0.0..last).contains(s)) {
            return [1.0; 2];
        }
        let [i, j] = steps.map(|s| s as usize);
        let [u, v] = [(steps[0] - i as f64) as f32, (steps[1] - j as f64) as f32];
        // A sample under the block sees all the sky from its top; only those on the floor count.
        let mut sum = [0.0f32, 0.0, 1e-6];
        for (a, b, weight) in
            [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)]
        {
            let [x, y] =
                [(i + a) as f64 * self.cell + self.corner[0], (j + b) as f64 * self.cell + self.corner[1]];
            if (0.0..=self.extent[0]).contains(&x) && (0.0..=self.extent[1]).contains(&y) {
                continue;
            }
            let sky = self.view.light(i + a, j + b, [0.0, 0.0, 1.0]);
            sum = [sum[0] + weight * sky[0], sum[1] + weight * sky[1], sum[2] + weight];
        }
        if sum[2] < 1e-3 { [0.5; 2] } else { [sum[0] / sum[2], sum[1] / sum[2]] }
    }

    /// What a side sends out at a point, where the ground above it ends at `ground` and the water at `sea`.
    pub(super) fn side(
        &self,
        p: [f64; 3],
        normal: [f32; 3],
        ground: f64,
        sea: Option<f64>,
        lamp: &Lamp<'_>,
    ) -> [f32; 3] {
        let longer = self.extent[0].max(self.extent[1]);
        let color = match sea {
            Some(sea) if p[2] > ground => {
                let deep = (((sea - p[2]) / (0.05 * longer)) as f32).clamp(0.0, 1.0).sqrt();
                mix(CUT_WATER[0], CUT_WATER[1], deep)
            }
            _ => {
                let below = (ground - p[2]) / longer;
                let soil = 1.0 - material::rise(0.0025, 0.0060, below as f32);
                mix(self.layers(p, longer), SOIL, 0.75 * soil)
            }
        };
        // A wall sees half the sky, less near the floor, which in turn lights it.
        let above = ((p[2] - self.base) / (0.06 * longer)) as f32;
        let open = 0.42 + 0.18 * above.clamp(0.0, 1.0);
        let mut light = lamp.light(color, normal, 1.0, [open, 1.0]);
        let to_sun = lamp.sky.to_sun[2] as f32;
        for k in 0..3 {
            light[k] += color[k] * FLOOR[k] * 0.22 * (lamp.sky.sunlight[k] * to_sun + lamp.sky.skylight[k]);
        }
        light
    }

    /// Layers of rock, a little wavy.
    fn layers(&self, p: [f64; 3], longer: f64) -> [f32; 3] {
        let along = (p[0] + p[1]) / longer;
        let wave = 0.004 * (libm::sin(along * 9.0) + 0.5 * libm::sin(along * 23.0 + 1.7));
        let depth = p[2] / longer + wave;
        let layer = |scale: f64, seed: u64| {
            let at = depth * scale;
            let (k, u) = (at.floor(), at - at.floor());
            let value = |k: f64| hash::unit(seed, k as i64 as u64);
            // Layers meet in a short transition instead of a gradient.
            let u = ((u - 0.35) / 0.3).clamp(0.0, 1.0);
            value(k) + u * u * (3.0 - 2.0 * u) * (value(k + 1.0) - value(k))
        };
        mix(LAYERS[0], LAYERS[1], (0.65 * layer(90.0, 11) + 0.35 * layer(310.0, 12)) as f32)
    }
}

pub(super) fn mix(a: [f32; 3], b: [f32; 3], u: f32) -> [f32; 3] {
    [a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * u, a[2] + (b[2] - a[2]) * u]
}
