//! Small pictures of any value, for panels and pages.

use super::picture::Picture;
use super::plane::resampled;
use super::surface::working_grid;
use super::{GroundPalette, Scene, map, picture_side, sketch};
use crate::context::Cancel;
use crate::kit::ramp::{Blend, Palette, Ramp};
use crate::node::{Error, Result};
use crate::value::{Field, Quantity, Value};
use crate::work::Work;

/// The relief that a thumbnail shows, as a share of the longer side: a plain is raised to it.
const RELIEF: f64 = 0.16;

/// A small picture of any value, `side` pixels along the longer side (fewer where there are fewer samples).
///
/// An elevation is a shaded map whose relief is raised until it shows; a mask is grey from 0 to 1; a direction is
/// a wheel of hues; other fields are coloured from their lowest to their highest value; vectors show their
/// components as red and green around grey; colours are as they are; curves and constraints are coloured by height.
///
/// # Errors
/// When the value has no samples or a number that is not finite, `side` is 0 or too large, or the work was cancelled.
pub fn thumbnail(value: &Value, side: usize, cancel: &Cancel) -> Result<Picture> {
    picture_side("side", side)?;
    let work = Work::new(cancel);
    match value {
        Value::Field(field) => match field.quantity() {
            Quantity::Elevation if field.grid().cols > 1 && field.grid().rows > 1 => {
                relief(field, side, &work)
            }
            Quantity::Mask => flat(field, side, &work, |x| [x; 3]),
            Quantity::Direction => flat(field, side, &work, hue),
            _ => {
                let (low, high) = field.range().unwrap_or((0.0, 1.0));
                let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
                let ramp = Ramp::of(&Palette::Viridis, Blend::Smooth);
                flat(field, side, &work, |x| ramp.color((x - low) * scale))
            }
        },
        Value::Vectors(vectors) => {
            let longest = vectors.data().iter().fold(0.0f32, |a, [x, y]| a.max(x.abs()).max(y.abs()));
            let scale = if longest > 0.0 { 0.5 / longest } else { 0.0 };
            let colors: Vec<_> =
                (vectors.data().iter()).map(|[x, y]| [0.5 + x * scale, 0.5 + y * scale, 0.5]).collect();
            paint(&colors, [vectors.grid().cols, vectors.grid().rows], side, &work)
        }
        Value::Colors(colors) => paint(colors.data(), [colors.grid().cols, colors.grid().rows], side, &work),
        Value::Object(object) => Ok(sketch::picture(&object.sketch(), side)),
    }
}

fn relief(field: &Field, side: usize, work: &Work<'_>) -> Result<Picture> {
    let grid = field.grid();
    let (low, high) = field.range().unwrap_or((0.0, 0.0));
    let extent = grid.cols.max(grid.rows) as f64 * grid.cell();
    let relief = f64::from(high - low) / extent;
    let exaggeration = if relief > 0.0 { (RELIEF / relief).clamp(1.0, 1000.0) } else { 1.0 };
    let [width, _] = working_grid([grid.cols, grid.rows], side);
    let palette = GroundPalette::Ramp(Palette::Hypsometric);
    map(&Scene { exaggeration, palette, ..Scene::new(field) }, Some(width), work)
}

fn flat(field: &Field, side: usize, work: &Work<'_>, f: impl Fn(f32) -> [f32; 3]) -> Result<Picture> {
    let colors: Vec<_> = field.data().iter().map(|&x| f(x)).collect();
    paint(&colors, [field.grid().cols, field.grid().rows], side, work)
}

fn paint(colors: &[[f32; 3]], from: [usize; 2], side: usize, work: &Work<'_>) -> Result<Picture> {
    if from.contains(&0) {
        return Err(Error::Input { port: "value".into(), message: "has no samples".into() });
    }
    let longer = from[0].max(from[1]);
    let size = from.map(|n| if longer > side { (n * side / longer).max(1) } else { n });
    let screen = resampled(work, colors, from, size)?;
    let level = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    Ok(Picture { width: size[0], height: size[1], rgb: screen.data.iter().map(|c| c.map(level)).collect() })
}

/// The hue of a compass direction in degrees: red north, yellow-green east, cyan south, violet west.
fn hue(degrees: f32) -> [f32; 3] {
    let turn = |shift: f32| {
        let x = (degrees + shift) / 360.0;
        0.5 + 0.45 * libm::cosf((x - x.floor()) * std::f32::consts::TAU)
    };
    [turn(0.0), turn(-120.0), turn(120.0)]
}
