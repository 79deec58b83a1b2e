//! What drawing takes, for budgets, known before there is anything to draw.

use super::MAX_WORK;
use super::camera::{Camera, Edge};
use super::horizon::SKY_GRID;
use super::map::sizes;
use super::perspective::{MARGIN, longest};
use super::surface::working_grid;
use crate::node::Cost;

/// Bytes a sample of the grid for the field, and for its colours where it has some.
const FIELD_BYTES: f64 = 4.0;
const FIELD_COLOR_BYTES: f64 = 12.0;
/// Bytes a sample of the working grid: heights, the top of the water, the share of the sun and what a sweep turns
/// around, the light that is sent out.
const SAMPLE_BYTES: f64 = 36.0;
/// Bytes more for rays: their pyramid of maxima, and the light averaged over more and more samples.
const RAY_BYTES: f64 = 12.0;
/// Bytes more where the scene brings its own colours.
const COLOR_BYTES: f64 = 12.0;
/// Bytes a sample of the grid on which the sky is looked at: heights, sums, and what a sweep turns around.
const SKY_BYTES: f64 = 32.0;
/// Bytes a pixel: light on the screen, colours, and the file while it is pressed.
const PIXEL_BYTES: f64 = 20.0;

/// Nanoseconds a sample of the working grid, a sample of the sky's, a pixel of a map and one of a perspective.
const SAMPLE: f64 = 730.0;
const SKY: f64 = 1850.0;
const PIXEL: f64 = 100.0;
const RAYS: f64 = 3500.0;

/// What a [`map`](super::map) takes of a grid of so many columns and rows, the field and its colours among it.
pub fn map_cost(grid: [usize; 2], width: Option<usize>, colored: bool) -> Cost {
    let (size, work) = sizes(grid, width);
    cost(grid, (work, size), colored, [0.0, PIXEL])
}

/// What a [`perspective`](super::perspective) takes of a grid of so many columns and rows, the field and its
/// colours among it.
pub fn perspective_cost(grid: [usize; 2], camera: &Camera, colored: bool) -> Cost {
    let longest = longest(camera);
    let work = match camera.edge {
        Edge::Block => working_grid(grid, longest),
        Edge::Haze => {
            let inner = longest.min(MAX_WORK) as f64 / (1.0 + 2.0 * MARGIN);
            working_grid(grid, inner as usize).map(|side| (side as f64 * (1.0 + 2.0 * MARGIN)) as usize)
        }
    };
    cost(grid, (work, [camera.width, camera.height]), colored, [RAY_BYTES, RAYS])
}

fn cost(
    grid: [usize; 2],
    (work, size): ([usize; 2], [usize; 2]),
    colored: bool,
    [rays, pixel]: [f64; 2],
) -> Cost {
    let area = |[cols, rows]: [usize; 2]| cols as f64 * rows as f64;
    let (samples, sky, pixels) = (area(work), area(working_grid(work, SKY_GRID)), area(size));
    let (color, field_color) = if colored { (COLOR_BYTES, FIELD_COLOR_BYTES) } else { (0.0, 0.0) };
    let (each, drawn) = (SAMPLE_BYTES + rays + color, area(grid) * (FIELD_BYTES + field_color));
    Cost {
        bytes: (drawn + samples * each + sky * SKY_BYTES + pixels * PIXEL_BYTES) as u64,
        seconds: (samples * SAMPLE + sky * SKY + pixels * pixel) * 1e-9,
    }
}
