//! The camera of the canvas: which part is visible, and how large.

use eframe::egui::{Pos2, Rect, Vec2, vec2};

/// The least and the greatest zoom.
const ZOOM: [f32; 2] = [0.08, 2.5];

/// The place on the canvas in the middle of the view, and the zoom in points of the screen for each unit of the canvas.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Camera {
    pub(crate) middle: Vec2,
    pub(crate) zoom: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { middle: Vec2::ZERO, zoom: 1.0 }
    }
}

/// A camera and the part of the screen it fills.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewport {
    pub(crate) camera: Camera,
    pub(crate) screen: Rect,
}

impl Viewport {
    /// The point of the screen that shows a place on the canvas.
    pub(crate) fn pos(&self, world: Pos2) -> Pos2 {
        self.screen.center() + (world.to_vec2() - self.camera.middle) * self.camera.zoom
    }

    /// The place on the canvas at a point of the screen.
    pub(crate) fn world(&self, pos: Pos2) -> Pos2 {
        ((pos - self.screen.center()) / self.camera.zoom + self.camera.middle).to_pos2()
    }

    pub(crate) fn rect(&self, world: Rect) -> Rect {
        Rect::from_min_max(self.pos(world.min), self.pos(world.max))
    }

    /// The visible part of the canvas.
    pub(crate) fn seen(&self) -> Rect {
        Rect::from_min_max(self.world(self.screen.min), self.world(self.screen.max))
    }

    pub(crate) fn zoom(&self) -> f32 {
        self.camera.zoom
    }
}

impl Camera {
    /// Multiplies the zoom by a factor; the place at a point of the screen stays there.
    pub(crate) fn zoom_at(&mut self, screen: Rect, pos: Pos2, factor: f32) {
        let fixed = Viewport { camera: *self, screen }.world(pos).to_vec2();
        let zoom = (self.zoom * factor).clamp(ZOOM[0], ZOOM[1]);
        self.middle = fixed + (self.middle - fixed) * (self.zoom / zoom);
        self.zoom = zoom;
    }

    /// Fits a part of the canvas into the screen, with a margin and at most at a zoom of 1.
    pub(crate) fn fit(&mut self, screen: Rect, world: Rect) {
        if !world.is_finite() || !screen.is_positive() {
            return;
        }
        let room = (screen.size() - vec2(60.0, 60.0)).max(vec2(50.0, 50.0));
        let size = world.size().max(vec2(1.0, 1.0));
        self.zoom = (room.x / size.x).min(room.y / size.y).clamp(ZOOM[0], 1.0);
        self.middle = world.center().to_vec2();
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;

    use super::*;

    #[test]
    fn what_is_under_the_pointer_stays() {
        let screen = Rect::from_min_max(pos2(100.0, 50.0), pos2(900.0, 650.0));
        let mut camera = Camera { middle: vec2(30.0, -20.0), zoom: 0.7 };
        let pointer = pos2(333.0, 444.0);
        let before = Viewport { camera, screen }.world(pointer);
        camera.zoom_at(screen, pointer, 1.3);
        assert!(Viewport { camera, screen }.world(pointer).distance(before) < 1e-3);
    }

    #[test]
    fn fits_a_part_whole() {
        let screen = Rect::from_min_max(pos2(0.0, 0.0), pos2(800.0, 600.0));
        let world = Rect::from_min_max(pos2(-4000.0, 0.0), pos2(4000.0, 900.0));
        let mut camera = Camera::default();
        camera.fit(screen, world);
        let view = Viewport { camera, screen };
        assert!(screen.contains_rect(view.rect(world)));
    }
}
