//! The links near a place.

use super::Map;
use crate::kit::predicates::Point;
use crate::value::Bounds;

impl Map<'_> {
    /// Collects the segments within a distance of a rectangle around some points, but for links that are left out.
    pub(super) fn segments_near(
        &mut self,
        points: &[Point],
        distance: f64,
        is_left_out: impl Fn(&Self, u32) -> bool,
    ) -> Vec<[Point; 2]> {
        let Some(around) = Bounds::around(points.iter().copied()) else { return Vec::new() };
        let mut near = std::mem::take(&mut self.near);
        self.grid.collect(around.grown(distance), &mut near);
        let others = near.iter().filter(|&&link| !is_left_out(self, link));
        let segments = others.filter_map(|&link| self.segment(link as usize)).collect();
        self.near = near;
        segments
    }

    /// Whether a link has an end at a vertex.
    pub(super) fn is_at(&self, link: u32, vertex: u32) -> bool {
        link == vertex || self.grown.down[link as usize] == Some(vertex)
    }
}
