//! The eye of the relief view, which circles around a point of the ground or flies.

use glam::camera::rh::proj::directx::perspective;
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3};

/// Vertical field of view.
const FIELD_OF_VIEW: f32 = 38.0;
/// The least and the greatest height of the eye over the horizon, in degrees.
const PITCH: [f32; 2] = [-10.0, 89.0];

/// The position of the eye. Lengths are in units of the longer side of the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orbit {
    /// The point in the middle of the view, relative to the middle of the terrain: east, south, up.
    pub(crate) target: Vec3,
    /// Compass direction from the target to the eye, in degrees.
    pub(crate) azimuth: f32,
    /// Height of the eye over the horizon, in degrees.
    pub(crate) pitch: f32,
    pub(crate) distance: f32,
}

impl Default for Orbit {
    fn default() -> Self {
        Self { target: Vec3::new(0.0, 0.0, -0.02), azimuth: 205.0, pitch: 33.0, distance: 1.75 }
    }
}

impl Orbit {
    /// The eye in the same direction, at the distance at which a block around the middle of the terrain just fits into
    /// the view; `half` is half the width, depth and height of the block.
    pub(crate) fn fitted(self, half: Vec3, aspect: f32) -> Self {
        let mut orbit = Self { target: Vec3::ZERO, distance: 0.3, ..self };
        let corners: [Vec3; 8] = std::array::from_fn(|k| {
            let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * Vec3::new(sign(0), sign(1), sign(2))
        });
        // Distance and target depend on each other; each round at least halves the error.
        for _ in 0..60 {
            let to_screen = orbit.projection(aspect, 1.0);
            let seen = corners.map(|c| to_screen * c.extend(1.0));
            if seen.iter().any(|c| c.w <= 0.01) {
                orbit.zoom(0.8);
                continue;
            }
            let at = seen.map(|c| c.truncate() / c.w);
            let (low, high) = at.iter().fold((at[0], at[0]), |(a, b), p| (a.min(*p), b.max(*p)));
            let (size, middle) = (high - low, 0.5 * (low + high));
            orbit.pan(-0.5 * middle.x * aspect, 0.5 * middle.y);
            orbit.zoom((1.9 / size.x).min(1.86 / size.y).clamp(0.8, 1.25));
        }
        orbit
    }

    /// The unit vector from the target to the eye.
    fn outward(&self) -> Vec3 {
        let (a, p) = (self.azimuth.to_radians(), self.pitch.to_radians());
        let flat = libm::cosf(p);
        Vec3::new(libm::sinf(a) * flat, -libm::cosf(a) * flat, libm::sinf(p))
    }

    pub(crate) fn eye(&self) -> Vec3 {
        self.target + self.outward() * self.distance
    }

    /// Turns the eye around the target.
    pub(crate) fn turn(&mut self, right: f32, up: f32) {
        self.azimuth = (self.azimuth + right).rem_euclid(360.0);
        self.pitch = (self.pitch + up).clamp(PITCH[0], PITCH[1]);
    }

    /// Moves the target along the ground, by shares of the height of the view.
    pub(crate) fn pan(&mut self, right: f32, down: f32) {
        let scale = self.distance * 2.0 * libm::tanf(0.5 * FIELD_OF_VIEW.to_radians());
        let (east, forward) = self.axes();
        self.target += (east * -right + forward * down) * scale;
        self.hold();
    }

    /// Moves the eye and the target along the line of sight and across it.
    pub(crate) fn fly(&mut self, ahead: f32, right: f32, up: f32) {
        let (east, _) = self.axes();
        self.target += (-self.outward() * ahead + east * right + Vec3::Z * up) * self.distance;
        self.hold();
    }

    /// Divides the distance from the target by a factor.
    pub(crate) fn zoom(&mut self, factor: f32) {
        self.distance = (self.distance / factor).clamp(0.01, 6.0);
    }

    /// Keeps the target over the terrain, so that the terrain is not lost from sight.
    fn hold(&mut self) {
        self.target = self.target.clamp(Vec3::splat(-1.0), Vec3::splat(1.0));
    }

    /// The unit vectors to the right and ahead, along the ground.
    fn axes(&self) -> (Vec3, Vec3) {
        let a = self.azimuth.to_radians();
        let (sin, cos) = (libm::sinf(a), libm::cosf(a));
        (Vec3::new(cos, sin, 0.0) * -1.0, Vec3::new(-sin, cos, 0.0))
    }

    /// The projection from metres around the middle of the terrain to clip space; `unit` is the longer side in metres.
    pub(crate) fn projection(&self, aspect: f32, unit: f32) -> Mat4 {
        let (eye, target) = (self.eye() * unit, self.target * unit);
        let near = (self.distance * unit * 0.01).max(0.05);
        let far = (self.distance + 4.0) * unit;
        // East, south and up form left-handed axes; mirroring one of them makes them right-handed.
        let flip = Mat4::from_scale(Vec3::new(1.0, -1.0, 1.0));
        let mirrored = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
        let view = look_at_mat4(mirrored(eye), mirrored(target), Vec3::Z);
        perspective(FIELD_OF_VIEW.to_radians(), aspect.max(0.01), near, far) * view * flip
    }

    /// The size of a length at a distance on the screen, as a share of its height.
    pub(crate) fn share(length: f32, distance: f32) -> f32 {
        length / (distance.max(1e-6) * 2.0 * libm::tanf(0.5 * FIELD_OF_VIEW.to_radians()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_is_in_the_middle_and_east_is_right_when_looking_north() {
        let orbit = Orbit { azimuth: 180.0, target: Vec3::ZERO, ..Orbit::default() };
        let to_screen = orbit.projection(1.5, 8000.0);
        let at = |v: Vec3| to_screen.project_point3(v);
        let middle = at(Vec3::ZERO);
        assert!(middle.x.abs() < 1e-5 && middle.y.abs() < 1e-5 && (0.0..1.0).contains(&middle.z));
        assert!(at(Vec3::new(1000.0, 0.0, 0.0)).x > 0.05, "east is right");
        assert!(at(Vec3::new(0.0, -1000.0, 0.0)).y > 0.02, "north is ahead");
        assert!(at(Vec3::new(0.0, 0.0, 1000.0)).y > 0.05, "up is up");
    }

    #[test]
    fn a_fitted_block_fills_the_view_and_no_more() {
        for (aspect, half) in [
            (2.5, Vec3::new(0.5, 0.5, 0.1)),
            (1.0, Vec3::new(0.5, 0.25, 0.02)),
            (0.6, Vec3::new(0.2, 0.5, 0.4)),
        ] {
            let to_screen = Orbit::default().fitted(half, aspect).projection(aspect, 1.0);
            let mut most = 0.0f32;
            for k in 0..8 {
                let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let at = to_screen.project_point3(half * Vec3::new(sign(0), sign(1), sign(2)));
                most = most.max(at.x.abs()).max(at.y.abs());
            }
            assert!((0.8..1.0).contains(&most), "{aspect}: {most}");
        }
    }

    #[test]
    fn panning_follows_the_hand() {
        for azimuth in [0.0, 90.0, 180.0, 270.0, 33.0] {
            let mut orbit = Orbit { azimuth, ..Orbit::default() };
            let before = orbit.projection(1.0, 1000.0).project_point3(Vec3::ZERO);
            orbit.pan(0.1, 0.0);
            let after = orbit.projection(1.0, 1000.0).project_point3(Vec3::ZERO);
            assert!(after.x > before.x + 0.05, "{azimuth}: {before} {after}");
            let mut orbit = Orbit { azimuth, ..Orbit::default() };
            orbit.pan(0.0, 0.1);
            let after = orbit.projection(1.0, 1000.0).project_point3(Vec3::ZERO);
            assert!(after.y < before.y - 0.02, "{azimuth}: {before} {after}");
        }
    }
}
