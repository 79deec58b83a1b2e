//! The terrain from straight above, north up.

use super::light::Lit;
use super::picture::{Picture, developed, encoded};
use super::plane::{Plane, resampled};
use super::sky::Sky;
use super::surface::{Surface, working_grid};
use super::{MAX_PIXELS, Scene, picture_side};
use crate::node::Result;
use crate::work::Work;

/// Draws the terrain from above, north up: sun, cast shadows, light of the sky, water.
///
/// `width` is in pixels; without it there is one for each sample, up to 4096. The height follows from the field.
/// Light is computed on at least two samples a pixel where the field has them, and averaged.
///
/// # Errors
/// When a setting is out of range, the field has fewer than 2 x 2 samples or a number that is not finite, or
/// the work was cancelled.
pub fn map(scene: &Scene<'_>, width: Option<usize>, work: &Work<'_>) -> Result<Picture> {
    scene.check()?;
    let grid = scene.height.grid();
    width.map_or(Ok(()), |width| picture_side("width", width))?;
    let (size, fine) = sizes([grid.cols, grid.rows], width);
    let surface = Surface::new(scene, fine, &work.stage(0.0, 0.1))?;
    let sky = Sky::new(scene.sun, scene.exposure);
    let mut lit = Lit::new(scene, &surface, &sky, &work.stage(0.1, 0.9))?;
    if let Some(step) = scene.contours {
        let step = (step * scene.exaggeration) as f32;
        let lines =
            Contours { z: &surface.z, step, lowest: lowest(scene), pixel: fine[0] as f32 / size[0] as f32 };
        lines.draw(&mut lit.color, &work.stage(0.9, 0.92))?;
    }
    // Averaged as the screen shows it, so that edges of bright areas stay smooth.
    work.stage(0.92, 0.95).rows(&mut lit.color.data, fine[0], 1, |_, row| {
        row.iter_mut().for_each(|light| *light = developed(*light));
    })?;
    let screen = resampled(&work.stage(0.95, 1.0), &lit.color.data, fine, size)?;
    let rgb = screen.data.iter().map(|&light| encoded(light, 0.0)).collect();
    Ok(Picture { width: size[0], height: size[1], rgb })
}

/// The size of a map of a grid of so many columns and rows, and that of the grid on which its light is computed.
pub(super) fn sizes(from: [usize; 2], width: Option<usize>) -> ([usize; 2], [usize; 2]) {
    let size = match width {
        None => working_grid(from, super::MAX_WORK),
        Some(width) => {
            let height = (width as f64 * from[1] as f64 / from[0] as f64).round() as usize;
            [width, height.clamp(1, MAX_PIXELS)]
        }
    };
    let work = [0, 1].map(|k| {
        if from[k] < size[k] { size[k] } else { from[k].min(3 * size[k]).min(size[k].max(super::MAX_WORK)) }
            .max(2)
    });
    (size, work)
}

/// What the heights of the surface count from, times the exaggeration.
fn lowest(scene: &Scene<'_>) -> f32 {
    scene.height.range().map_or(0.0, |(low, _)| (f64::from(low) * scene.exaggeration) as f32)
}

/// Lines of equal height, every fifth heavier.
struct Contours<'a> {
    z: &'a Plane<f32>,
    step: f32,
    lowest: f32,
    /// Samples in a pixel.
    pixel: f32,
}

impl Contours<'_> {
    const INK: [f32; 3] = [0.055, 0.035, 0.02];

    fn draw(&self, light: &mut Plane<[f32; 3]>, work: &Work<'_>) -> Result<()> {
        Ok(work.rows(&mut light.data, self.z.cols, 1, |j, row| {
            for (i, light) in row.iter_mut().enumerate() {
                let ink = self.ink(i, j);
                for (light, dark) in light.iter_mut().zip(Self::INK) {
                    *light += ink * (dark * 0.6 - *light);
                }
            }
        })?)
    }

    /// How much ink a sample gets, 0 to 1.
    fn ink(&self, i: usize, j: usize) -> f32 {
        let [east, south, up] = Surface::normal(self.z, 1.0, i, j);
        // Height per pixel: how wide a line is, and where lines would run together.
        let fall = ((east * east + south * south).sqrt() / up.max(1e-6) * self.pixel).max(1e-6);
        let height = self.z.row(j)[i] + self.lowest;
        let line = |step: f32, width: f32| {
            let away = (height / step - (height / step).round()).abs() * step;
            let crowded = ((step / fall - 1.5) / 2.5).clamp(0.0, 1.0);
            (width * 0.5 + 0.5 - away / fall).clamp(0.0, 1.0) * crowded
        };
        (0.55 * line(self.step, 0.7)).max(0.8 * line(5.0 * self.step, 1.1))
    }
}
