//! Quick pictures of values for the flat view, made in milliseconds, one pixel a sample. Pictures with cast shadows and
//! light of the sky are made by `render`.

use rayon::prelude::*;

use crate::context::Cancel;
use crate::kit::math::decade;
use crate::kit::ramp::{Blend, Palette, Ramp};
use crate::node::Result;
use crate::render::{Picture, Sun, thumbnail};
use crate::value::{Colors, Field, Grid, Quantity, Terrain, Value};

/// Pixels along the longer side of the picture of a value without a grid.
const SKETCH: usize = 1024;
/// Colour of water, sRGB.
const WATER: [f32; 3] = [0.25, 0.42, 0.56];
/// Colour of a mask that is being painted, sRGB, 0 to 255.
const TINT: [f32; 3] = [235.0, 70.0, 60.0];
/// Colour of contour lines, sRGB.
const INK: [f32; 3] = [0.16, 0.11, 0.07];

/// How values are turned into colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Mode {
    /// Heights are tinted and lit from the north-west; other values have the picture that suits their quantity.
    #[default]
    Relief,
    /// A ramp of colours from the lowest to the highest value.
    Ramp,
    /// Grey from the lowest to the highest value.
    Raw,
}

impl Mode {
    pub(crate) const ALL: [Self; 3] = [Self::Relief, Self::Ramp, Self::Raw];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Relief => "Shaded",
            Self::Ramp => "Ramp",
            Self::Raw => "Raw",
        }
    }

    pub(crate) const fn help(self) -> &'static str {
        match self {
            Self::Relief => "Heights tinted and lit from the north-west; other values as suits them",
            Self::Ramp => "A ramp of colours from the lowest to the highest value",
            Self::Raw => "Grey from the lowest to the highest value",
        }
    }
}

/// How the flat view looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Look {
    pub(crate) mode: Mode,
    /// Whether lines of equal value are drawn.
    pub(crate) contours: bool,
}

/// Where the light of the relief view comes from, in whole degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Light {
    /// Compass direction.
    pub(crate) azimuth: u16,
    /// Height over the horizon.
    pub(crate) altitude: u16,
}

impl Default for Light {
    fn default() -> Self {
        Self { azimuth: 315, altitude: 35 }
    }
}

impl Light {
    pub(crate) fn sun(self) -> Sun {
        Sun { azimuth: f64::from(self.azimuth), altitude: f64::from(self.altitude) }
    }
}

/// The colours of a value that is draped over heights on a grid; `None` where the value is on another grid.
pub(crate) fn colors(drape: &Value, grid: &Grid, cancel: &Cancel) -> Option<Colors> {
    let of_picture = |picture: Picture| {
        let data = picture.rgb.iter().map(|c| c.map(|c| f32::from(c) / 255.0)).collect::<Vec<_>>();
        (data.len() == grid.len()).then(|| Colors::new(*grid, Quantity::Color, data))
    };
    match drape {
        Value::Colors(colors) => (colors.grid() == grid).then(|| colors.clone()),
        Value::Field(f) if f.quantity() == Quantity::Mask && f.grid() == grid => {
            // A ramp from black to white would not do: dark ground shows no form, and white looks like lit ground.
            let ramp = Ramp::of(&Palette::Viridis, Blend::Smooth);
            Some(Colors::new(*grid, Quantity::Color, f.data().iter().map(|v| ramp.color(*v)).collect()))
        }
        Value::Field(f) if f.grid() == grid => {
            let (low, high) = f.range()?;
            let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
            let ramp = Ramp::of(&Palette::Viridis, Blend::Smooth);
            let color = |v: &f32| ramp.color((v - low) * scale);
            Some(Colors::new(*grid, Quantity::Color, f.data().iter().map(color).collect()))
        }
        other => thumbnail(other, grid.cols.max(grid.rows), cancel).ok().and_then(of_picture),
    }
}

/// A picture of a value, one pixel a sample. `range` is the range of the whole where the value is a part of it, so that
/// both have the same colours. Heights take the colours of `drape` where there is one, and are shaded by their slopes.
///
/// # Errors
/// Fails when the value has no samples, or the work was cancelled.
pub(crate) fn picture(
    value: &Value,
    look: &Look,
    range: Option<(f32, f32)>,
    drape: Option<&Value>,
    terrain: &Terrain,
    cancel: &Cancel,
) -> Result<Picture> {
    let side = value.grid().map_or(SKETCH, |g| g.cols.max(g.rows));
    let Value::Field(field) = value else { return thumbnail(value, side, cancel) };
    let relief = look.mode == Mode::Relief;
    let is_height = field.quantity() == Quantity::Elevation;
    let drape = drape.filter(|_| is_height).and_then(|d| colors(d, field.grid(), cancel));
    if relief && !is_height && !look.contours && range.is_none() {
        return thumbnail(value, side, cancel);
    }
    cancel.check()?;
    let (low, high) = range.or_else(|| field.range()).unwrap_or((0.0, 0.0));
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    let ramp = match look.mode {
        Mode::Relief if is_height => &Palette::Hypsometric,
        Mode::Relief if field.quantity() == Quantity::Mask => &Palette::Grey,
        Mode::Relief | Mode::Ramp => &Palette::Viridis,
        Mode::Raw => &Palette::Grey,
    };
    let ramp = Ramp::of(ramp, Blend::Smooth);
    let lit = relief && is_height;
    let sea = terrain.sea_level.map_or(f32::NEG_INFINITY, |level| level as f32);
    let lines = look.contours.then(|| Lines { step: contour_step(low, high) });
    let pixel = |i: usize, j: usize| {
        let z = field.row(j)[i];
        let [east, south] = fall(field, i, j);
        let mut color = match &drape {
            Some(drape) => drape.row(j)[i],
            None => ramp.color((z - low) * scale),
        };
        if lit {
            let wet = z < sea && drape.is_none();
            let light = if wet { 1.0 } else { shade(east, south) };
            let ground = if wet { WATER.map(|c| c * depth_shade(sea - z, high - low)) } else { color };
            color = ground.map(|c| c * light);
        }
        if let Some(lines) = &lines {
            let cell = field.grid().cell() as f32;
            let ink = lines.ink(z, (east * east + south * south).sqrt() * cell);
            color = [0, 1, 2].map(|k| color[k] + ink * (INK[k] - color[k]));
        }
        color.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    };
    let (cols, rows) = (field.grid().cols, field.grid().rows);
    let mut rgb = vec![[0; 3]; cols * rows];
    rgb.par_chunks_mut(cols.max(1)).enumerate().for_each(|(j, row)| {
        row.iter_mut().enumerate().for_each(|(i, out)| *out = pixel(i, j));
    });
    Ok(Picture { width: cols, height: rows, rgb })
}

/// A picture with a mask of its size shown as a tint over it.
pub(crate) fn tinted(mut picture: Picture, mask: Option<&Value>) -> Picture {
    let Some(Value::Field(mask)) = mask else { return picture };
    if mask.data().len() == picture.rgb.len() {
        picture.rgb.par_iter_mut().zip(mask.data()).with_min_len(1 << 14).for_each(|(color, v)| {
            let share = 0.6 * v.clamp(0.0, 1.0);
            for (c, tint) in color.iter_mut().zip(TINT) {
                *c = (f32::from(*c) * (1.0 - share) + tint * share + 0.5) as u8;
            }
        });
    }
    picture
}

/// The slope of a field at a sample: metres of rise for each metre to the east and to the south.
fn fall(field: &Field, i: usize, j: usize) -> [f32; 2] {
    let grid = field.grid();
    let (w, e) = (i.saturating_sub(1), (i + 1).min(grid.cols - 1));
    let (n, s) = (j.saturating_sub(1), (j + 1).min(grid.rows - 1));
    let across = field.row(j)[e] - field.row(j)[w];
    let along = field.row(s)[i] - field.row(n)[i];
    let cell = grid.cell() as f32;
    [across / (cell * (e - w).max(1) as f32), along / (cell * (s - n).max(1) as f32)]
}

/// The light on a slope: most of it from the north-west, some from the west and the north, so that no flank is black.
fn shade(east: f32, south: f32) -> f32 {
    let up = 1.0 / (1.0 + east * east + south * south).sqrt();
    let from = |x: f32, y: f32, z: f32| ((-east * x - south * y + z) * up).max(0.0);
    // Unit vectors towards lights 45° high, 30° high and straight above.
    let sun = from(-0.5, -0.5, 0.707);
    let sides = from(-0.866, 0.0, 0.5) + from(0.0, -0.866, 0.5);
    0.18 + 0.86 * sun + 0.14 * sides + 0.06 * up
}

/// The brightness of water at a depth; deep water is darker.
fn depth_shade(depth: f32, relief: f32) -> f32 {
    1.0 - 0.5 * (depth / relief.max(1.0)).clamp(0.0, 1.0)
}

/// A round distance between contour lines: about twenty of them.
pub(crate) fn contour_step(low: f32, high: f32) -> f32 {
    let wanted = f64::from(high - low) / 20.0;
    if !(wanted > 0.0 && wanted.is_finite()) {
        return 1.0;
    }
    let power = decade(wanted);
    let step = [1.0, 2.0, 5.0].into_iter().find(|m| m * power >= wanted).unwrap_or(10.0);
    (step * power) as f32
}

/// Lines of equal value, every fifth heavier.
struct Lines {
    step: f32,
}

impl Lines {
    /// The share of ink in a pixel, by its value and the change of the value across a pixel.
    fn ink(&self, z: f32, change: f32) -> f32 {
        let change = change.max(self.step * 1e-4);
        let line = |step: f32, width: f32| {
            let away = (z / step - (z / step).round()).abs() * step;
            (width * 0.5 + 0.5 - away / change).clamp(0.0, 1.0) * (step / change / 3.0 - 0.5).clamp(0.0, 1.0)
        };
        (0.6 * line(self.step, 0.8)).max(0.85 * line(5.0 * self.step, 1.3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contour_steps_are_round() {
        assert_eq!(contour_step(0.0, 1000.0), 50.0);
        assert_eq!(contour_step(-3.0, 1.0), 0.2);
        assert_eq!(contour_step(5.0, 5.0), 1.0);
    }

    #[test]
    fn slopes_towards_the_light_are_brighter() {
        // Ground that rises to the south-east faces the north-west.
        assert!(shade(0.5, 0.5) > shade(0.0, 0.0));
        assert!(shade(0.0, 0.0) > shade(-0.5, -0.5));
    }
}
