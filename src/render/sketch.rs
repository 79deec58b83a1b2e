//! Thumbnails of what is no raster: curves as lines, constraints as marks.

use super::picture::Picture;
use crate::kit::ramp::{Blend, Palette, Ramp};
use crate::value::{Constraints, Curves, Mark};

/// Colour of what nothing is known of.
const GROUND: [f32; 3] = [0.11, 0.12, 0.14];
/// Colour of a line without a height.
const PLAIN: [f32; 3] = [0.85; 3];
/// Colour of samples with a gradient alone, and with noise alone.
const GRADIENT: [f32; 3] = [0.24, 0.36, 0.55];
const NOISE: [f32; 3] = [0.35; 3];
/// Points drawn on each curve for a pixel of the picture's side.
const DENSITY: usize = 2;

/// A place on a curve, and its height where it has one.
type Point = ([f64; 2], Option<f64>);

/// Curves seen from above, coloured by height from the lowest to the highest.
pub(super) fn curves(curves: &Curves, side: usize) -> Picture {
    let steps = DENSITY * side;
    let at = |k: usize| k as f64 / steps as f64;
    let points: Vec<Point> =
        curves.iter().flat_map(|c| (0..=steps).map(move |k| (c.point(at(k)), c.height(at(k))))).collect();
    let span = |of: fn(&Point) -> Option<f64>| {
        let all = points.iter().filter_map(of);
        all.fold([f64::MAX, f64::MIN], |[lo, hi], v| [lo.min(v), hi.max(v)])
    };
    let (x, y, z) = (span(|p| Some(p.0[0])), span(|p| Some(p.0[1])), span(|p| p.1));
    let extent = (x[1] - x[0]).max(y[1] - y[0]).max(1e-6) * 1.1;
    let shade = Shade::new(z);
    let mut canvas = vec![GROUND; side * side];
    for ([px, py], height) in points {
        let place = |v: f64, [lo, hi]: [f64; 2]| {
            (((v - (lo + hi) / 2.0) / extent + 0.5) * side as f64).clamp(0.0, side as f64 - 1.0) as usize
        };
        canvas[place(py, y) * side + place(px, x)] = height.map_or(PLAIN, |h| shade.color(h));
    }
    picture([side, side], canvas.into_iter())
}

/// What is marked, heights coloured from the lowest to the highest.
pub(super) fn constraints(constraints: &Constraints, side: usize) -> Picture {
    let (cols, rows) = (constraints.grid().cols, constraints.grid().rows);
    let step = cols.max(rows).div_ceil(side.max(1)).max(1);
    let heights = (0..rows).flat_map(|j| (0..cols).filter_map(move |i| constraints.height([i, j])));
    let range = heights.fold([f64::MAX, f64::MIN], |[lo, hi], v| [lo.min(v.into()), hi.max(v.into())]);
    let shade = Shade::new(range);
    // A thin line is seen where any of the samples under a pixel is marked.
    let pixel = |i: usize, j: usize| {
        let under = (j..(j + step).min(rows)).flat_map(|j| (i..(i + step).min(cols)).map(move |i| [i, j]));
        let mut best = GROUND;
        for at in under {
            if let Some(height) = constraints.height(at) {
                return shade.color(height.into());
            }
            if constraints.has(Mark::Gradient, at) {
                best = GRADIENT;
            } else if constraints.has(Mark::Noise, at) && best == GROUND {
                best = NOISE;
            }
        }
        best
    };
    let size = [cols.div_ceil(step), rows.div_ceil(step)];
    let colors = (0..rows).step_by(step).flat_map(|j| (0..cols).step_by(step).map(move |i| (i, j)));
    picture(size, colors.map(|(i, j)| pixel(i, j)))
}

/// Colours of heights in a range.
struct Shade {
    ramp: Ramp,
    low: f64,
    scale: f64,
}

impl Shade {
    fn new([low, high]: [f64; 2]) -> Self {
        let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
        Self { ramp: Ramp::of(&Palette::Viridis, Blend::Smooth), low, scale }
    }

    fn color(&self, height: f64) -> [f32; 3] {
        // Viridis starts as dark as the ground.
        self.ramp.color((0.25 + 0.75 * (height - self.low) * self.scale) as f32)
    }
}

fn picture([width, height]: [usize; 2], colors: impl Iterator<Item = [f32; 3]>) -> Picture {
    let level = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    Picture { width, height, rgb: colors.map(|c| c.map(level)).collect() }
}
