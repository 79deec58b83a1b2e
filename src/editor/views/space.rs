//! The flat view as a space to draw in.

use eframe::egui::Pos2;

use super::map::{sample, unit};
use crate::editor::canvas::camera::Viewport;
use crate::editor::drawing::Space;
use crate::value::{Bounds, Field};

/// Pixels that a height handle is pulled to go from the lowest to the highest point.
const REACH: f64 = 240.0;
/// Relief where none is known, in metres.
const RELIEF: f64 = 500.0;

/// The map: places by their position alone.
pub(crate) struct Flat<'a> {
    pub(crate) view: Viewport,
    pub(crate) bounds: Bounds,
    /// Heights of the ground, where they are known.
    pub(crate) height: Option<&'a Field>,
}

impl Space for Flat<'_> {
    fn screen(&self, at: [f64; 3]) -> Option<Pos2> {
        let scale = unit(&self.bounds);
        let [x, y] = [0, 1].map(|k| ((at[k] - self.bounds.min[k]) * scale) as f32);
        Some(self.view.pos(Pos2::new(x, y)))
    }

    fn level(&self, pos: Pos2, _: f64) -> Option<[f64; 2]> {
        let scale = unit(&self.bounds);
        let at = self.view.world(pos);
        Some([self.bounds.min[0] + f64::from(at.x) / scale, self.bounds.min[1] + f64::from(at.y) / scale])
    }

    fn ground(&self, pos: Pos2) -> Option<[f64; 2]> {
        self.level(pos, 0.0)
    }

    fn height(&self, at: [f64; 2]) -> f64 {
        self.height.map_or(0.0, |field| f64::from(sample(field, at)))
    }

    fn rise(&self, _: [f64; 3]) -> f64 {
        let relief = self.relief();
        if relief > 0.0 { relief.max(20.0) / REACH } else { RELIEF / REACH }
    }

    fn across(&self, _: [f64; 3]) -> f64 {
        1.0 / (unit(&self.bounds) * f64::from(self.view.zoom()))
    }

    fn hides(&self, _: [f64; 3]) -> bool {
        false
    }

    fn is_flat(&self) -> bool {
        true
    }

    fn relief(&self) -> f64 {
        self.height.and_then(Field::range).map_or(0.0, |(low, high)| f64::from(high - low))
    }
}
