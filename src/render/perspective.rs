//! Perspective views of a terrain.

use super::block::{Block, mix};
use super::camera::{Camera, Edge, Eye};
use super::light::{Lamp, Lit};
use super::material::rise;
use super::picture::{Picture, developed, dither, encoded};
use super::plane::{Plane, resampled};
use super::sky::{Direction, Sky, dot};
use super::surface::{Surface, working_grid};
use super::trace::{Hit, Ray, Tracer};
use super::{MAX_WORK, Scene};
use crate::node::Result;
use crate::work::Work;

/// Optical depth of the haze along the longer side of the terrain at its foot, for red, green and blue.
const HAZE: [f64; 3] = [0.20, 0.27, 0.38];
/// Height over which the haze thins to a third, as a share of the longer side.
const HAZE_HEIGHT: f64 = 0.10;
/// How far the land goes on where it fades into haze, as a share of the longer side.
pub(super) const MARGIN: f64 = 0.35;
/// Contrast within a pixel, in light of the screen, above which it gets more rays.
const CONTRAST: f32 = 0.05;
/// Radius of the sun as it blurs the block's shadow on the floor, in radians.
const SUN_RADIUS: f64 = 0.022;
/// Variance of the slopes of waves, on which the spread of the sun's glitter depends.
const WAVES: f64 = 0.012;
/// The greatest tilt of the water's normal by waves.
const WAVE_TILT: f64 = 0.016;

/// Draws the terrain as a camera sees it: sun, cast shadows, sky, haze, water with reflections.
///
/// Each pixel is the mean of 4 rays, of 16 where these differ. The field is averaged to at most three samples
/// a pixel and 4096 along its longer side.
///
/// # Errors
/// When a setting is out of range, the field has fewer than 2 x 2 samples or a number that is not finite, or
/// the work was cancelled.
pub fn perspective(scene: &Scene<'_>, camera: &Camera, work: &Work<'_>) -> Result<Picture> {
    scene.check()?;
    camera.check()?;
    let grid = scene.height.grid();
    let from = [grid.cols, grid.rows];
    let longest = longest(camera);
    let watch_surface = work.stage(0.0, 0.05);
    let surface = match camera.edge {
        Edge::Block => Surface::new(scene, working_grid(from, longest), &watch_surface)?,
        Edge::Haze => {
            let inner = longest.min(MAX_WORK) as f64 / (1.0 + 2.0 * MARGIN);
            Surface::new(scene, working_grid(from, inner as usize), &watch_surface)?
                .mirrored(MARGIN, &watch_surface)?
        }
    };
    let sky = Sky::new(scene.sun, scene.exposure);
    let lit = Lit::new(scene, &surface, &sky, &work.stage(0.05, 0.45))?;
    let view = Perspective::new(scene, camera, &surface, &sky, lit, &work.stage(0.45, 0.55))?;
    let mut rgb = vec![[0; 3]; camera.width * camera.height];
    work.stage(0.55, 1.0).rows(&mut rgb, camera.width, 1, |row, out| {
        for (column, out) in out.iter_mut().enumerate() {
            *out = encoded(view.pixel(column, row), dither(column, row));
        }
    })?;
    Ok(Picture { width: camera.width, height: camera.height, rgb })
}

/// Most samples along a side of the working grid: some for each pixel.
pub(super) fn longest(camera: &Camera) -> usize {
    (3 * camera.width.max(camera.height)).max(1024)
}

/// The scene with everything that a ray can hit.
struct Perspective<'a> {
    surface: &'a Surface,
    tracer: Tracer<'a>,
    /// The light that the ground sends out, and that light averaged over 2 x 2, 4 x 4 … samples.
    light: Vec<Plane<[f32; 3]>>,
    lamp: Lamp<'a>,
    eye: Eye,
    block: Option<Block>,
    sea: Option<f64>,
    haze: f64,
    /// Distance to the terrain: there is no haze in that clear air.
    clear: f64,
    /// How far below the true horizon the sky begins, as the upward part of a direction.
    horizon: f64,
    longer: f64,
}

impl<'a> Perspective<'a> {
    fn new(
        scene: &Scene<'_>,
        camera: &Camera,
        surface: &'a Surface,
        sky: &'a Sky,
        lit: Lit,
        work: &Work<'_>,
    ) -> Result<Self> {
        let tracer = Tracer::new(&surface.z, surface.cell, work)?;
        let sea = match camera.edge {
            Edge::Block => lit.water.as_ref().map(|water| f64::from(water.level)),
            // A sea beyond the border is seen even where the terrain has none.
            Edge::Haze => surface.sea.map(f64::from),
        };
        let mut light = vec![lit.color];
        while let Some(fine) = light.last().filter(|l| l.cols.min(l.rows) > 4) {
            let size = [fine.cols.div_ceil(2), fine.rows.div_ceil(2)];
            let coarse = resampled(work, &fine.data, [fine.cols, fine.rows], size)?;
            light.push(coarse);
        }
        let block = match camera.edge {
            Edge::Block => Some(Block::new(surface, [sky.to_sun[0], sky.to_sun[1]], work)?),
            Edge::Haze => None,
        };
        let base = block.as_ref().map_or(0.0, |block| block.base);
        let eye = Eye::new(camera, scene, surface, base);
        let [width, depth] = surface.extent();
        let clear = eye.distance(surface);
        let horizon = if block.is_some() { 0.0 } else { eye.end_of_land(surface) };
        let lamp = Lamp { sky, shadow: scene.shadow as f32 };
        Ok(Self {
            surface,
            tracer,
            light,
            lamp,
            eye,
            block,
            sea,
            haze: scene.haze,
            clear,
            horizon,
            longer: width.max(depth),
        })
    }

    /// The light of a pixel.
    fn pixel(&self, column: usize, row: usize) -> [f32; 3] {
        // Sixteen places in a 4 x 4 net; the first four have one in each row and each column.
        const ORDER: [usize; 16] = [1, 7, 8, 14, 0, 2, 3, 4, 5, 6, 9, 10, 11, 12, 13, 15];
        let sample = |n: usize| {
            let (a, b) = (ORDER[n] % 4, ORDER[n] / 4);
            let (x, y) = (column as f64 + (a as f64 + 0.5) / 4.0, row as f64 + (b as f64 + 0.5) / 4.0);
            // Another net picks parts of the sun and of the waves: the same in each pixel, so that soft edges are
            // overlays of sixteen sharp ones instead of grain.
            let tilt = [b as f64, ((a + b) % 4) as f64].map(|x| (x - 1.5) / 1.5);
            developed(self.seen(&self.eye.ray(x, y), tilt))
        };
        let first: [[f32; 3]; 4] = std::array::from_fn(sample);
        let add = |sum: [f32; 3], x: [f32; 3]| [sum[0] + x[0], sum[1] + x[1], sum[2] + x[2]];
        let mut sum = first.into_iter().fold([0.0; 3], add);
        let differs = (0..3).any(|k| {
            let values = first.map(|x| x[k]);
            values.into_iter().fold(0.0, f32::max) - values.into_iter().fold(1.0, f32::min) > CONTRAST
        });
        if !differs {
            return sum.map(|x| x / 4.0);
        }
        sum = (4..16).map(sample).fold(sum, add);
        sum.map(|x| x / 16.0)
    }

    /// The light that comes along a ray.
    fn seen(&self, ray: &Ray, tilt: [f64; 2]) -> [f32; 3] {
        let over = self.tracer.over(ray, 0.0);
        let hit = self.tracer.hit(ray, 0.0);
        // A sea floor that lies at the level itself, as in many elevation models, is under water too.
        let shore = 1e-6 * self.longer;
        let water = self.water_hit(ray).filter(|&t| hit.is_none_or(|hit| t < hit.t + shore));
        let entry = over.map_or(0.0, |[enter, _]| enter);
        match &self.block {
            Some(block) => {
                // A ray that comes in through a side below ground or water meets that side.
                if entry > 0.0 && over.is_some() {
                    let p = ray.at(entry);
                    let ground = self.tracer.height(p[0] / self.surface.cell, p[1] / self.surface.cell);
                    if p[2] >= block.base && p[2] < self.sea.map_or(ground, |sea| ground.max(sea)) {
                        let light = block.side(p, self.side_normal(p), ground, self.sea, &self.lamp);
                        return self.through_air(light, ray, entry);
                    }
                }
                let inside = water.filter(|&t| over.is_some_and(|[a, b]| a <= t && t <= b));
                match (inside, hit) {
                    (Some(t), _) => self.through_air(self.water(ray, t, tilt), ray, t),
                    (None, Some(hit)) if ray.at(hit.t)[2] >= block.base => {
                        self.through_air(self.ground(ray, hit), ray, hit.t)
                    }
                    _ => self.floor(block, ray, tilt),
                }
            }
            None => {
                let (near, light) = match (water, hit) {
                    (Some(t), _) => {
                        let p = ray.at(t);
                        let [u, v] = [p[0] / self.surface.cell, p[1] / self.surface.cell];
                        match self.faded(u, v) {
                            near if near > 0.0 => (near, self.through_air(self.water(ray, t, tilt), ray, t)),
                            _ => return self.background(ray.direction),
                        }
                    }
                    (None, Some(hit)) => {
                        (self.faded(hit.u, hit.v), self.through_air(self.ground(ray, hit), ray, hit.t))
                    }
                    (None, None) => return self.background(ray.direction),
                };
                mix(self.background(ray.direction), light, near)
            }
        }
    }

    /// Where a ray comes down to the water, land or no land.
    fn water_hit(&self, ray: &Ray) -> Option<f64> {
        let sea = self.sea?;
        let t = (sea - ray.origin[2]) / ray.direction[2];
        (ray.direction[2] < 0.0 && t > 0.0).then_some(t)
    }

    /// The light of the ground where a ray hits it, averaged over the width of the ray.
    fn ground(&self, ray: &Ray, hit: Hit) -> [f32; 3] {
        let (i, j) = (hit.u.round() as usize, hit.v.round() as usize);
        let z = &self.surface.z;
        let normal = Surface::normal(z, self.surface.cell, i.min(z.cols - 1), j.min(z.rows - 1));
        let facing = dot(normal.map(f64::from), ray.direction).abs().max(0.1);
        // Half a pixel across, more along the ray where it grazes; between the two lies the least of blur and shimmer.
        let width = 0.5 * hit.t * self.eye.pixel / self.surface.cell;
        self.light_at(hit.u, hit.v, width / facing.sqrt())
    }

    /// The light of the ground at a place, averaged over a width in samples.
    fn light_at(&self, u: f64, v: f64, width: f64) -> [f32; 3] {
        let level = libm::log2(width.max(1.0)).min((self.light.len() - 1) as f64);
        let (k, share) = (level as usize, (level - level.floor()) as f32);
        let read = |k: usize| {
            let plane = &self.light[k];
            let place = |x: f64, n: usize, full: usize| (x + 0.5) * n as f64 / full as f64 - 0.5;
            plane.at(place(u, plane.cols, self.surface.z.cols), place(v, plane.rows, self.surface.z.rows))
        };
        if share == 0.0 { read(k) } else { mix(read(k), read((k + 1).min(self.light.len() - 1)), share) }
    }

    /// The light of the water where a ray hits it at a distance.
    fn water(&self, ray: &Ray, t: f64, tilt: [f64; 2]) -> [f32; 3] {
        let p = ray.at(t);
        let [u, v] = [p[0] / self.surface.cell, p[1] / self.surface.cell];
        let normal = Self::wave(tilt);
        let facing = (-dot(normal, ray.direction)).max(0.02);
        let turned: [f64; 3] = std::array::from_fn(|k| ray.direction[k] + 2.0 * facing * normal[k]);
        let up = [turned[0], turned[1], turned[2].max(0.01)];
        let length = dot(up, up).sqrt();
        let mirrored =
            Ray { origin: [p[0], p[1], p[2] + 1e-6 * self.longer], direction: up.map(|x| x / length) };
        let reflected = match self.tracer.hit(&mirrored, 0.0) {
            Some(hit) => {
                let light =
                    self.light_at(hit.u, hit.v, 2.0 * (t + hit.t) * self.eye.pixel / self.surface.cell);
                mix(
                    self.background(mirrored.direction),
                    light,
                    if self.block.is_some() { 1.0 } else { self.faded(hit.u, hit.v) },
                )
            }
            None => self.background(mirrored.direction),
        };
        let grazing = 1.0 - facing;
        let square = grazing * grazing;
        // Waves hide each other at a grazing look: rough water never mirrors all.
        let share = (0.02 + 0.98 * square * square * grazing).min(0.62) as f32;
        let width = 0.5 * t * self.eye.pixel / self.surface.cell;
        let body = self.light_at(u, v, width / facing.sqrt());
        let glitter = self.glitter(ray.direction);
        std::array::from_fn(|k| {
            body[k] * (1.0 - share) + reflected[k] * share + self.lamp.sky.sunlight[k] * glitter
        })
    }

    /// The sun in many small waves.
    fn glitter(&self, direction: Direction) -> f32 {
        let half: [f64; 3] = std::array::from_fn(|k| self.lamp.sky.to_sun[k] - direction[k]);
        let length = dot(half, half).sqrt();
        let up = (half[2] / length).max(0.05);
        let tangent = (1.0 - up * up) / (up * up);
        let slopes = libm::exp(-tangent / (2.0 * WAVES)) / (std::f64::consts::TAU * WAVES);
        let square = up * up;
        (0.05 * slopes / (4.0 * square * square * (-direction[2]).max(0.15))).min(3.0) as f32
    }

    /// The normal of the water: waves too small to see, as a random tilt of each ray.
    fn wave(tilt: [f64; 2]) -> Direction {
        let [x, y] = tilt.map(|x| x * WAVE_TILT);
        let length = (1.0 + x * x + y * y).sqrt();
        [x / length, y / length, 1.0 / length]
    }

    fn floor(&self, block: &Block, ray: &Ray, tilt: [f64; 2]) -> [f32; 3] {
        let t = (block.base - ray.origin[2]) / ray.direction[2];
        if ray.direction[2] >= 0.0 || !t.is_finite() || t > 400.0 * self.longer {
            return self.background(ray.direction);
        }
        let p = ray.at(t);
        // Some part of the sun, so that the shadow has a soft edge.
        let to_sun = self.lamp.sky.to_sun;
        let to_sun = [to_sun[0] + tilt[0] * SUN_RADIUS, to_sun[1] + tilt[1] * SUN_RADIUS, to_sun[2]];
        let light = block.floor([p[0], p[1]], to_sun, &self.tracer, &self.lamp);
        let far = 1.0 - libm::exp(-(t / (7.0 * self.longer)) * (t / (7.0 * self.longer)));
        mix(self.through_air(light, ray, t), self.background(ray.direction), far as f32)
    }

    /// The outward normal of the side of the block that a point lies on.
    fn side_normal(&self, p: [f64; 3]) -> [f32; 3] {
        let [width, depth] = self.surface.extent();
        let sides = [
            (p[0], [-1.0, 0.0, 0.0]),
            (width - p[0], [1.0, 0.0, 0.0]),
            (p[1], [0.0, -1.0, 0.0]),
            (depth - p[1], [0.0, 1.0, 0.0]),
        ];
        sides.into_iter().min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).map_or([0.0; 3], |side| side.1)
    }

    /// How much of the land is left at a place beyond the terrain, 0 to 1.
    fn faded(&self, u: f64, v: f64) -> f32 {
        let (z, margin) = (&self.surface.z, (self.surface.margin as f64).max(1.0));
        let (cols, rows) = ((z.cols - 1) as f64, (z.rows - 1) as f64);
        let inside = (u.min(cols - u).min(v).min(rows - v) / margin) as f32;
        // Towards the camera haze would be a veil before the terrain: there the land ends late.
        let away = (u - 0.5 * cols) * self.eye.heading[0] + (v - 0.5 * rows) * self.eye.heading[1];
        let behind = rise(-0.25, 0.25, (away / (cols.min(rows) - 2.0 * margin).max(1.0)) as f32);
        let (far, near) = (rise(0.0, 1.0, inside), rise(0.0, 0.25, inside));
        near + behind * (far - near)
    }

    /// Sky, and haze below the horizon.
    fn background(&self, direction: Direction) -> [f32; 3] {
        // Where the land ends in haze, the sky begins behind it: the world is not seen to go on below.
        let up = (direction[2] + self.horizon) / (1.0 + self.horizon);
        let air = self.lamp.sky.airlight(direction);
        let clear = rise(0.0, 0.09, up as f32);
        if clear <= 0.0 {
            return air;
        }
        let flat = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt().max(1e-9);
        let level = (1.0 - up * up).max(0.0).sqrt() / flat;
        mix(air, self.lamp.sky.radiance([direction[0] * level, direction[1] * level, up]), clear)
    }

    /// Light after a way through the air: dimmed, and with the light of the air added.
    fn through_air(&self, light: [f32; 3], ray: &Ray, t: f64) -> [f32; 3] {
        if self.haze == 0.0 {
            return light;
        }
        // The mean density over the way, exponential in height.
        let scale = HAZE_HEIGHT * self.longer;
        let (from, to) = (ray.origin[2] / scale, ray.at(t)[2] / scale);
        let density = |h: f64| libm::exp(-h.max(-2.0));
        let mean = if (to - from).abs() < 1e-4 {
            density(from)
        } else {
            (density(from) - density(to)) / (to - from)
        };
        let way = self.haze * mean.clamp(0.0, 8.0) * (t - self.clear).max(0.0) / self.longer;
        let air = self.lamp.sky.airlight(ray.direction);
        std::array::from_fn(|k| {
            let left = libm::exp(-HAZE[k] * way) as f32;
            light[k] * left + air[k] * (1.0 - left)
        })
    }
}
