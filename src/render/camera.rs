//! The camera of a perspective.

use super::sky::{Direction, dot};
use super::surface::Surface;
use super::trace::Ray;
use super::{Scene, picture_side, within};
use crate::node::Result;

/// What lies where the terrain ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edge {
    /// The terrain is a block with cut sides that stands on a pale floor.
    #[default]
    Block,
    /// The land goes on as its own mirror image, for a third of its length, and sinks into haze under the sky.
    Haze,
}

impl Edge {
    /// The edge of a name: `block` or `haze`; `None` when there is none.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "block" => Some(Self::Block),
            "haze" => Some(Self::Haze),
            _ => None,
        }
    }
}

/// Where a perspective is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Compass direction that it looks in, in degrees: 0 north, so it stands in the south; 90 east.
    pub azimuth: f64,
    /// How far it looks down, in degrees below the horizon, -60 to 90.
    pub pitch: f64,
    /// Angle across the picture's longer side, in degrees, 1 to 150.
    pub field_of_view: f64,
    /// Distance from the point looked at, in metres. When there is none: so far that the whole block is seen, or
    /// just before the near border of a terrain that goes into haze, overlooking it.
    pub distance: Option<f64>,
    /// The point looked at: east, south and elevation, in metres, in the coordinates of the field; the middle when
    /// there is none.
    pub look_at: Option<[f64; 3]>,
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// What is drawn beyond the border of the terrain.
    pub edge: Edge,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            azimuth: 25.0,
            pitch: 28.0,
            field_of_view: 32.0,
            distance: None,
            look_at: None,
            width: 1280,
            height: 800,
            edge: Edge::Block,
        }
    }
}

impl Camera {
    /// Refuses a camera with a setting out of range.
    pub(super) fn check(&self) -> Result<()> {
        picture_side("width", self.width)?;
        picture_side("height", self.height)?;
        within("camera azimuth", self.azimuth, -360.0, 720.0)?;
        within("pitch", self.pitch, -60.0, 90.0)?;
        within("field of view", self.field_of_view, 1.0, 150.0)?;
        if let Some(distance) = self.distance {
            within("distance", distance, 1e-3, 1e8)?;
        }
        self.look_at
            .map_or(Ok(()), |place| place.into_iter().try_for_each(|x| within("look-at point", x, -1e9, 1e9)))
    }
}

/// A camera in place.
pub(super) struct Eye {
    pub(super) origin: [f64; 3],
    forward: Direction,
    /// Half a pixel to the right and half a pixel up, as parts of the direction.
    right: Direction,
    up: Direction,
    size: [f64; 2],
    /// The direction of the look on the ground, east and south.
    pub(super) heading: [f64; 2],
    /// Angle of a pixel, in radians.
    pub(super) pixel: f64,
}

impl Eye {
    /// Puts the camera in place before a surface whose solid begins at `base`.
    pub(super) fn new(camera: &Camera, scene: &Scene<'_>, surface: &Surface, base: f64) -> Self {
        let (a, p) = (camera.azimuth.to_radians(), camera.pitch.to_radians());
        let (sin, cos) = (libm::sin(a), libm::cos(a));
        let (down, level) = (libm::sin(p), libm::cos(p));
        let forward = [sin * level, -cos * level, -down];
        let right = [cos, sin, 0.0];
        let up = [sin * down, -cos * down, level];
        let size = [camera.width as f64, camera.height as f64];
        let half = libm::tan(camera.field_of_view.to_radians() * 0.5);
        let pixel = 2.0 * half / size[0].max(size[1]);
        // Room around the terrain, 4 % of the picture on each side.
        let reach = size.map(|n| 0.92 * n * pixel * 0.5);
        let points = outline(surface, base, camera.edge);
        let origin = match camera.look_at {
            None => match camera.distance {
                None if camera.edge == Edge::Haze => {
                    overlooking([sin, -cos], p, pixel * size[1] * 0.5, surface)
                }
                None => fitted(&points, [right, up, forward], reach),
                Some(distance) => {
                    let [width, depth] = surface.extent();
                    let centre = [width * 0.5, depth * 0.5, f64::from(surface.highest) * 0.35];
                    std::array::from_fn(|k| centre[k] - distance * forward[k])
                }
            },
            Some(place) => {
                let place = placed(place, scene, surface);
                let distance =
                    camera.distance.unwrap_or_else(|| far(&points, place, [right, up, forward], reach));
                std::array::from_fn(|k| place[k] - distance * forward[k])
            }
        };
        Self { origin: above(origin, surface, base), heading: [sin, -cos], forward, right, up, size, pixel }
    }

    /// Distance from the box around the terrain; 0 inside it.
    pub(super) fn distance(&self, surface: &Surface) -> f64 {
        let [width, depth] = surface.extent();
        let box_end = [width, depth, f64::from(surface.highest)];
        let away: [f64; 3] =
            std::array::from_fn(|k| (-self.origin[k]).max(self.origin[k] - box_end[k]).max(0.0));
        dot(away, away).sqrt()
    }

    /// How far below the horizon the land ends that goes into haze, as the upward part of a direction.
    pub(super) fn end_of_land(&self, surface: &Surface) -> f64 {
        let [width, depth] = surface.extent();
        let centre = [width * 0.5 - self.origin[0], depth * 0.5 - self.origin[1]];
        let along = centre[0] * self.heading[0] + centre[1] * self.heading[1];
        let end = (along + 0.5 * width.min(depth)).max(0.3 * width.max(depth));
        let down = (self.origin[2] - 0.15 * f64::from(surface.highest)).max(0.0);
        // A look from high above has no horizon near the land's end; the sky stays where it is.
        (down / (down * down + end * end).sqrt()).min(0.25)
    }

    /// The ray through a place of the picture, in pixels from its upper left.
    pub(super) fn ray(&self, x: f64, y: f64) -> Ray {
        let (a, b) = ((x - self.size[0] * 0.5) * self.pixel, (self.size[1] * 0.5 - y) * self.pixel);
        let way: [f64; 3] = std::array::from_fn(|k| self.forward[k] + a * self.right[k] + b * self.up[k]);
        let length = dot(way, way).sqrt();
        Ray { origin: self.origin, direction: way.map(|x| x / length) }
    }
}

/// A point of the world in the coordinates of the surface.
fn placed([x, y, z]: [f64; 3], scene: &Scene<'_>, surface: &Surface) -> [f64; 3] {
    let grid = scene.height.grid();
    let lowest = scene.height.range().map_or(0.0, |(low, _)| f64::from(low));
    // The surface is a little smaller than the field where it was averaged.
    let cols = (surface.z.cols - 2 * surface.margin - 1) as f64;
    let shrink = cols * surface.cell / ((grid.cols - 1) as f64 * grid.cell());
    let margin = surface.margin as f64 * surface.cell;
    [(x - grid.x(0)) * shrink + margin, (y - grid.y(0)) * shrink + margin, (z - lowest) * scene.exaggeration]
}

/// Points that should be seen: a net over the surface, and the feet of a block.
fn outline(surface: &Surface, base: f64, edge: Edge) -> Vec<[f64; 3]> {
    const NET: usize = 96;
    let top = surface.top();
    let margin = surface.margin;
    let steps = |count: usize| (0..=NET).map(move |n| margin + n * (count - 2 * margin - 1) / NET);
    let point = |i: usize, j: usize, z: f64| [i as f64 * surface.cell, j as f64 * surface.cell, z];
    let net = steps(top.rows).flat_map(|j| steps(top.cols).map(move |i| (i, j)));
    let mut points: Vec<_> = net.map(|(i, j)| point(i, j, f64::from(top.row(j)[i]))).collect();
    if edge == Edge::Block {
        for (i, j) in [(0, 0), (top.cols - 1, 0), (0, top.rows - 1), (top.cols - 1, top.rows - 1)] {
            points.push(point(i, j, base));
        }
    }
    points
}

/// A place from which the lower border of the picture lies a little inside the near border of the terrain, and
/// its middle row two fifths of the way across; `half` is the tangent of half the picture's height.
fn overlooking(heading: [f64; 2], pitch: f64, half: f64, surface: &Surface) -> [f64; 3] {
    let centre = surface.extent().map(|side| side * 0.5);
    let margin = surface.margin as f64 * surface.cell;
    // From the centre to the border, along the look.
    let chord =
        (0..2).map(|k| (centre[k] - margin) / heading[k].abs().max(1e-9)).fold(f64::INFINITY, f64::min);
    // A look along or above the horizon never meets the ground; it is set up like one a little below.
    let middle = libm::tan(pitch.clamp(0.05, 1.5));
    let lowest = libm::tan((pitch + libm::atan(half)).clamp(0.12, 1.55)).max(middle * 1.05);
    let height = 0.8 * chord / (1.0 / middle - 1.0 / lowest);
    let back = 0.9 * chord + height / lowest;
    let ground = 0.25 * f64::from(surface.highest);
    [centre[0] - back * heading[0], centre[1] - back * heading[1], ground + height]
}

/// The place nearest to some points from which all are seen within `reach` of the middle of the picture (tangents
/// of angles), with as much room on the left as on the right, and below as above.
fn fitted(points: &[[f64; 3]], [right, up, forward]: [Direction; 3], reach: [f64; 2]) -> [f64; 3] {
    // A point (x, z) is inside when |x - ex| <= k (z - ez): two half planes for each axis, whose tightest are kept.
    let bounds = |axis: Direction, k: f64| {
        let fold = |[a, b]: [f64; 2], p: &[f64; 3]| {
            let (x, z) = (dot(axis, *p), dot(forward, *p));
            [a.max(x - k * z), b.max(-x - k * z)]
        };
        points.iter().fold([f64::NEG_INFINITY; 2], fold)
    };
    let ([a, b], [c, d]) = (bounds(right, reach[0]), bounds(up, reach[1]));
    let depth = (-(a + b) / (2.0 * reach[0])).min(-(c + d) / (2.0 * reach[1]));
    let (x, y) = ((a - b) * 0.5, (c - d) * 0.5);
    std::array::from_fn(|k| x * right[k] + y * up[k] + depth * forward[k])
}

/// The distance from which all points are seen when the middle of the picture is fixed.
fn far(points: &[[f64; 3]], place: [f64; 3], [right, up, forward]: [Direction; 3], reach: [f64; 2]) -> f64 {
    let needed = |p: &[f64; 3]| {
        let from: [f64; 3] = std::array::from_fn(|k| p[k] - place[k]);
        (dot(right, from).abs() / reach[0]).max(dot(up, from).abs() / reach[1]) - dot(forward, from)
    };
    points.iter().map(needed).fold(1e-3, f64::max)
}

/// Lifts a camera out of the ground.
fn above(origin: [f64; 3], surface: &Surface, base: f64) -> [f64; 3] {
    let [width, depth] = surface.extent();
    let room = 0.002 * width.max(depth);
    let over = (0.0..=width).contains(&origin[0]) && (0.0..=depth).contains(&origin[1]);
    let ground = if over {
        f64::from(surface.top().at(origin[0] / surface.cell, origin[1] / surface.cell))
    } else {
        surface.sea.map_or(base, f64::from).max(base)
    };
    [origin[0], origin[1], origin[2].max(ground + room)]
}
