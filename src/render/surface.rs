//! The ground that is drawn: heights on the working grid.

use super::plane::{Blend, Plane, resampled};
use super::{MAX_WORK, Scene};
use crate::node::Result;
use crate::work::Work;

/// Heights on the working grid, in metres above the lowest sample, times the exaggeration.
pub(super) struct Surface {
    /// The heights.
    pub(super) z: Plane<f32>,
    /// The height of what light meets: ground, or water above it; the same as `z` where there is no water.
    pub(super) top: Option<Plane<f32>>,
    /// The sRGB colour of the ground, if the scene brings one.
    pub(super) color: Option<Plane<[f32; 3]>>,
    /// Distance between samples, in metres.
    pub(super) cell: f64,
    /// Height of the water in the units of `z`, if it may be seen.
    pub(super) sea: Option<f32>,
    /// Factor on heights.
    pub(super) exaggeration: f32,
    /// Highest of `z`.
    pub(super) highest: f32,
    /// Samples on every side that were added beyond the terrain.
    pub(super) margin: usize,
}

impl Surface {
    /// Brings a scene to a grid of about so many samples along the longer side.
    pub(super) fn new(scene: &Scene<'_>, [cols, rows]: [usize; 2], work: &Work<'_>) -> Result<Self> {
        let grid = scene.height.grid();
        let from = [grid.cols, grid.rows];
        let lowest = scene.height.range().map_or(0.0, |(low, _)| low);
        let mut z = resampled(&work.stage(0.0, 0.6), scene.height.data(), from, [cols, rows])?;
        let factor = scene.exaggeration as f32;
        // Far beyond any planet numbers would overflow on the way; they are clipped and drawn as walls.
        work.stage(0.6, 0.7).rows(&mut z.data, cols, 1, |_, row| {
            for z in row {
                *z = ((*z - lowest) * factor).clamp(-1e9, 1e9);
            }
        })?;
        let color = match scene.color {
            Some(color) => Some(resampled(&work.stage(0.7, 1.0), color.data(), from, [cols, rows])?),
            None => None,
        };
        let highest = z.data.iter().fold(0.0f32, |a, &b| a.max(b));
        let sea = scene.sea_level.map(|level| ((level - f64::from(lowest)) * scene.exaggeration) as f32);
        let sea = sea.filter(|&sea| sea >= 0.0).map(|sea| sea.min(1e9));
        let top = sea.map(|sea| Plane {
            data: z.data.iter().map(|z| z.max(sea)).collect(),
            ..Plane { cols, rows, data: Vec::new() }
        });
        let cell = grid.cell() * grid.cols as f64 / cols as f64;
        Ok(Self { z, top, color, cell, sea, exaggeration: factor, highest, margin: 0 })
    }

    /// The surface with a margin of its mirror image on every side, a share of its longer side wide.
    pub(super) fn mirrored(self, share: f64, work: &Work<'_>) -> Result<Self> {
        let margin = (self.z.cols.max(self.z.rows) as f64 * share) as usize;
        Ok(Self {
            z: grown(&self.z, margin, work)?,
            top: self.top.map(|top| grown(&top, margin, work)).transpose()?,
            color: self.color.map(|color| grown(&color, margin, work)).transpose()?,
            margin,
            ..self
        })
    }

    /// What light meets.
    pub(super) fn top(&self) -> &Plane<f32> {
        self.top.as_ref().unwrap_or(&self.z)
    }

    /// East-west and north-south extent, in metres.
    pub(super) fn extent(&self) -> [f64; 2] {
        [(self.z.cols - 1) as f64 * self.cell, (self.z.rows - 1) as f64 * self.cell]
    }

    /// The upward normal at a sample of a row: east, south, up.
    pub(super) fn normal(z: &Plane<f32>, cell: f64, i: usize, j: usize) -> [f32; 3] {
        let (left, right) = (i.saturating_sub(1), (i + 1).min(z.cols - 1));
        let (north, south) = (j.saturating_sub(1), (j + 1).min(z.rows - 1));
        let row = z.row(j);
        let east = (row[right] - row[left]) / ((right - left) as f64 * cell) as f32;
        let down = (z.row(south)[i] - z.row(north)[i]) / ((south - north) as f64 * cell) as f32;
        // Dividing by the larger part first keeps the steepest cliff finite.
        let scale = 1.0 / east.abs().max(down.abs()).max(1.0);
        let (a, b) = (east * scale, down * scale);
        let length = (a * a + b * b + scale * scale).sqrt();
        [-a / length, -b / length, scale / length]
    }
}

/// A plane with a margin of its mirror image.
fn grown<T: Blend>(plane: &Plane<T>, margin: usize, work: &Work<'_>) -> Result<Plane<T>> {
    // The border sample is the mirror: it is not repeated, and margins may be longer than the plane.
    let fold = |k: usize, count: usize| {
        let period = 2 * (count - 1);
        let k = (k + period - margin % period) % period;
        k.min(period - k)
    };
    Plane::fill(work, [plane.cols + 2 * margin, plane.rows + 2 * margin], |j, out: &mut [T]| {
        let row = plane.row(fold(j, plane.rows));
        for (i, out) in out.iter_mut().enumerate() {
            *out = row[fold(i, plane.cols)];
        }
    })
}

/// The grid that light is computed on for a picture `width` samples wide or `longest` long: at least twice as fine
/// as the picture where the field is, never above the limit.
pub(super) fn working_grid(from: [usize; 2], longest: usize) -> [usize; 2] {
    let longer = from[0].max(from[1]);
    let limit = longest.clamp(2, MAX_WORK);
    if longer <= limit {
        return from;
    }
    from.map(|side| (side * limit).div_ceil(longer).max(2))
}
