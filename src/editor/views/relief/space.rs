//! The relief view as a [`Space`] for drawing: projection of places, and rays from the screen to the ground.

use eframe::egui::{Pos2, Rect, pos2};
use glam::{Mat4, Vec3};

use crate::editor::drawing::Space;
use crate::editor::views::map::sample;
use crate::value::Field;

/// Number of steps along a ray until the hit is refined.
const STEPS: u32 = 512;

/// Number of steps along the ray that finds whether the ground hides a place.
const GLANCE: u32 = 40;

/// The terrain in perspective. `to_screen` takes metres from the middle of the terrain, with heights from the middle of
/// the heights and times the exaggeration.
pub(crate) struct Deep<'a> {
    pub(crate) to_screen: Mat4,
    pub(crate) eye: Vec3,
    pub(crate) screen: Rect,
    pub(crate) height: &'a Field,
    pub(crate) exaggeration: f64,
    /// Lowest and highest point.
    pub(crate) range: [f64; 2],
}

impl Deep<'_> {
    fn middle(&self) -> [f64; 2] {
        let b = self.height.grid().bounds();
        [0, 1].map(|k| 0.5 * (b.min[k] + b.max[k]))
    }

    fn inside(&self, at: [f64; 3]) -> Vec3 {
        let [x, y] = self.middle();
        let z = (at[2] - 0.5 * (self.range[0] + self.range[1])) * self.exaggeration;
        Vec3::new((at[0] - x) as f32, (at[1] - y) as f32, z as f32)
    }

    fn outside(&self, at: Vec3) -> [f64; 3] {
        let [x, y] = self.middle();
        let z = f64::from(at.z) / self.exaggeration + 0.5 * (self.range[0] + self.range[1]);
        [f64::from(at.x) + x, f64::from(at.y) + y, z]
    }

    /// The unit vector from the eye through a point of the screen.
    fn ray(&self, pos: Pos2) -> Option<Vec3> {
        let size = self.screen.size();
        let x = 2.0 * (pos.x - self.screen.left()) / size.x.max(1.0) - 1.0;
        let y = 1.0 - 2.0 * (pos.y - self.screen.top()) / size.y.max(1.0);
        let far = self.to_screen.inverse().project_point3(Vec3::new(x, y, 0.9));
        (far - self.eye).try_normalize()
    }

    /// The height of a point above the ground.
    fn over(&self, at: Vec3) -> f64 {
        let [x, y, z] = self.outside(at);
        z - f64::from(sample(self.height, [x, y]))
    }

    /// The distances at which a ray enters and leaves the block of the terrain.
    fn stretch(&self, ray: Vec3) -> Option<[f32; 2]> {
        let b = self.height.grid().bounds();
        // The block is a little larger than the terrain, so that a ray leaves it below the ground, even on a plain.
        let room = Vec3::splat((0.002 * b.width().max(b.depth())) as f32);
        let low = self.inside([b.min[0], b.min[1], self.range[0]]) - room;
        let high = self.inside([b.max[0], b.max[1], self.range[1]]) + room;
        let (mut from, mut to) = (0.0f32, f32::INFINITY);
        for axis in 0..3 {
            let (a, b) =
                ((low[axis] - self.eye[axis]) / ray[axis], (high[axis] - self.eye[axis]) / ray[axis]);
            // A ray parallel to two faces gives 0/0 here; it is between them or outside all the way.
            if a.is_nan() || b.is_nan() {
                continue;
            }
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        (from < to && to.is_finite()).then_some([from, to])
    }
}

impl Space for Deep<'_> {
    fn screen(&self, at: [f64; 3]) -> Option<Pos2> {
        let clip = self.to_screen * self.inside(at).extend(1.0);
        if clip.w <= 1e-3 {
            return None;
        }
        let [x, y] = [clip.x / clip.w, clip.y / clip.w];
        let size = self.screen.size();
        let at =
            pos2(self.screen.left() + 0.5 * (x + 1.0) * size.x, self.screen.top() + 0.5 * (1.0 - y) * size.y);
        (at.x.abs() < 1e5 && at.y.abs() < 1e5).then_some(at)
    }

    fn level(&self, pos: Pos2, height: f64) -> Option<[f64; 2]> {
        let ray = self.ray(pos)?;
        let plane = self.inside([0.0, 0.0, height]).z;
        let t = (plane - self.eye.z) / ray.z;
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let [x, y, _] = self.outside(self.eye + ray * t);
        // Near the horizon a pixel is kilometres wide, so that places beyond the terrain are moved to its border.
        let b = self.height.grid().bounds();
        let far = b.width().max(b.depth());
        Some([x.clamp(b.min[0] - far, b.max[0] + far), y.clamp(b.min[1] - far, b.max[1] + far)])
    }

    fn ground(&self, pos: Pos2) -> Option<[f64; 2]> {
        let ray = self.ray(pos)?;
        let [from, to] = self.stretch(ray)?;
        let at = |k: u32| from + (to - from) * k as f32 / STEPS as f32;
        let hit = (1..=STEPS).find(|k| self.over(self.eye + ray * at(*k)) <= 0.0)?;
        let (mut above, mut below) = (at(hit - 1), at(hit));
        for _ in 0..20 {
            let middle = 0.5 * (above + below);
            if self.over(self.eye + ray * middle) > 0.0 { above = middle } else { below = middle }
        }
        let [x, y, _] = self.outside(self.eye + ray * below);
        Some([x, y])
    }

    fn height(&self, at: [f64; 2]) -> f64 {
        f64::from(sample(self.height, at))
    }

    fn rise(&self, at: [f64; 3]) -> f64 {
        // Seen from straight above, a height has no length on the screen; then a pixel is as high as it is wide.
        self.across(at) / self.exaggeration
    }

    fn across(&self, at: [f64; 3]) -> f64 {
        let away = f64::from(self.inside(at).distance(self.eye)).max(1e-3);
        let share = super::orbit::Orbit::share(1.0, away as f32) * self.screen.height();
        1.0 / f64::from(share).max(1e-9)
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn relief(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    fn hides(&self, at: [f64; 3]) -> bool {
        let to = self.inside(at) - self.eye;
        let Some([from, end]) = to.try_normalize().and_then(|ray| self.stretch(ray)) else { return false };
        // A curve on rough ground lies partly below it, so that the last steps are not tested.
        let (length, ray) = (to.length(), to.normalize());
        let slack = self.height.grid().cell() * 3.0;
        let end = end.min(length * 0.985);
        let step = (end - from) / GLANCE as f32;
        (1..GLANCE).any(|k| self.over(self.eye + ray * (from + step * k as f32)) < -slack)
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::vec2;

    use super::super::orbit::Orbit;
    use super::*;
    use crate::value::{Grid, Lattice, Quantity};

    fn hills() -> Field {
        let lattice = Lattice { origin: [1000.0, -500.0], span: 4000.0, intervals: 100 };
        let grid = Grid { lattice, col: 0, row: 0, cols: 101, rows: 101 };
        Field::from_fn(grid, Quantity::Elevation, |x, y| {
            (300.0 * libm::sin(x / 400.0) * libm::cos(y / 500.0)) as f32
        })
    }

    #[test]
    fn a_plain_is_ground() {
        let field = Field::constant(*hills().grid(), Quantity::Elevation, 7.0);
        let orbit = Orbit::default();
        let (to_screen, eye) = (orbit.projection(1.8, 4000.0), orbit.eye() * 4000.0);
        let screen = Rect::from_min_size(pos2(0.0, 0.0), vec2(900.0, 500.0));
        let space = Deep { to_screen, eye, screen, height: &field, exaggeration: 1.0, range: [7.0, 7.0] };
        for k in 0..40 {
            let at = [1200.0 + 90.0 * f64::from(k), 1500.0];
            let pos = space.screen([at[0], at[1], 7.0]).expect("in front of the eye");
            let ground = space.ground(pos).expect("ground");
            assert!((ground[0] - at[0]).abs() < 5.0 && (ground[1] - at[1]).abs() < 5.0, "{at:?} {ground:?}");
        }
    }

    #[test]
    fn what_is_seen_at_a_place_is_the_place() {
        let field = hills();
        let screen = Rect::from_min_size(pos2(30.0, 40.0), vec2(900.0, 500.0));
        for (pitch, azimuth, exaggeration) in [(35.0, 205.0, 1.0), (60.0, 20.0, 2.0), (89.0, 0.0, 1.0)] {
            let orbit = Orbit { pitch, azimuth, ..Orbit::default() };
            let to_screen = orbit.projection(1.8, 4000.0);
            let (low, high) = field.range().expect("a range");
            let range = [f64::from(low), f64::from(high)];
            let space =
                Deep { to_screen, eye: orbit.eye() * 4000.0, screen, height: &field, exaggeration, range };
            let mut seen = 0;
            for k in 0..100 {
                let at = [1200.0 + 36.0 * f64::from(k), -300.0 + 31.0 * f64::from(k * 37 % 100)];
                let z = space.height(at);
                let pos = space.screen([at[0], at[1], z]).expect("in front of the eye");
                let level = space.level(pos, z).expect("on the level");
                assert!((level[0] - at[0]).abs() < 2.0 && (level[1] - at[1]).abs() < 2.0, "{at:?} {level:?}");
                // What hides behind a hill is not what the hand points at.
                let ground = space.ground(pos).expect("ground");
                seen += i32::from((ground[0] - at[0]).abs() < 25.0 && (ground[1] - at[1]).abs() < 25.0);
                let up = space.screen([at[0], at[1], z + 50.0]).expect("in front of the eye");
                // From straight above, what is higher is farther from the middle.
                assert!(up.y < pos.y || pitch > 80.0, "up is up");
            }
            assert!(seen > 60, "{pitch}: {seen}");
            assert!(space.ground(pos2(31.0, 41.0)).is_none() || pitch > 80.0, "the sky is no ground");
        }
    }
}
