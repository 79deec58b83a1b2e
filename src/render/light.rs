//! The light that the ground sends out: the same in every direction, so that map and perspective share it.

use super::Scene;
use super::horizon::{SkyView, sun_share};
use super::material::Material;
use super::plane::Plane;
use super::sky::Sky;
use super::surface::Surface;
use super::water::Water;
use crate::node::Result;
use crate::work::Work;

/// The share of light that the land around sends into hollows which the sky does not reach.
const BOUNCE: f32 = 0.22;

/// A surface under the light of a sky.
pub(super) struct Lit {
    /// What each sample sends out, linear, under the exposure of the sky.
    pub(super) color: Plane<[f32; 3]>,
    /// The water, if any is seen.
    pub(super) water: Option<Water>,
}

impl Lit {
    pub(super) fn new(scene: &Scene<'_>, surface: &Surface, sky: &Sky, work: &Work<'_>) -> Result<Self> {
        let (z, cell) = (surface.top(), surface.cell);
        let sun = sun_share(z, cell, scene.sun, &work.stage(0.0, 0.15))?;
        let towards = [sky.to_sun[0], sky.to_sun[1]];
        let view = SkyView::new(z, cell, towards, &work.stage(0.15, 0.8))?;
        let material = Material::new(scene, surface, &work.stage(0.8, 0.84))?;
        let water = Water::new(surface, &work.stage(0.84, 0.88))?;
        let lamp = Lamp { sky, shadow: scene.shadow as f32 };
        let color = Plane::fill(&work.stage(0.88, 1.0), [z.cols, z.rows], |j, out: &mut [[f32; 3]]| {
            for (i, out) in out.iter_mut().enumerate() {
                let ground = surface.z.row(j)[i];
                let wet = water.as_ref().filter(|water| ground <= water.level);
                let normal = if wet.is_some() { [0.0, 0.0, 1.0] } else { Surface::normal(z, cell, i, j) };
                let sky_light = view.light(i, j, normal);
                let color = match wet {
                    Some(water) => water.color(i, j, ground),
                    None => material.color(i, j, sky_light[1]),
                };
                *out = lamp.light(color, normal, sun.row(j)[i], sky_light);
            }
        })?;
        Ok(Self { color, water })
    }
}

/// Sun and sky on matt ground.
pub(super) struct Lamp<'a> {
    pub(super) sky: &'a Sky,
    pub(super) shadow: f32,
}

impl Lamp<'_> {
    /// What ground of a colour and normal sends out that sees this share of the sun, and of the sky (on itself,
    /// and on level ground).
    pub(super) fn light(&self, color: [f32; 3], normal: [f32; 3], sun: f32, sky: [f32; 2]) -> [f32; 3] {
        let to_sun = self.sky.to_sun.map(|x| x as f32);
        let facing = (normal[0] * to_sun[0] + normal[1] * to_sun[1] + normal[2] * to_sun[2]).max(0.0);
        let sun = facing * (1.0 - self.shadow * (1.0 - sun));
        let hollow = BOUNCE * (1.0 - sky[1]) * (0.3 + 0.7 * to_sun[2]);
        std::array::from_fn(|k| {
            let direct = self.sky.sunlight[k];
            color[k] * (direct * sun + self.sky.skylight[k] * sky[0] + direct * color[k].sqrt() * hollow)
        })
    }
}
