//! Thumbnails of what is no raster: lines and marks.

use super::picture::Picture;
use crate::kit::ramp::{Blend, Palette, Ramp};
use crate::value::{Grid, Sketch, SketchLine, SketchMark, SketchPoint};

/// Colour of what nothing is known of.
const GROUND: [f32; 3] = [0.11, 0.12, 0.14];
/// Colour of a line without a height.
const PLAIN: [f32; 3] = [0.85; 3];
/// Colours of samples of which something is said, but no height.
const STRONG: [f32; 3] = [0.24, 0.36, 0.55];
const WEAK: [f32; 3] = [0.35; 3];
/// A picture of a sketch, at most `side` pixels along the longer side.
pub(super) fn picture(sketch: &Sketch, side: usize) -> Picture {
    match sketch {
        Sketch::Lines(all) => lines(all, side),
        Sketch::Marks(grid, all) => marks(grid, all, side),
    }
}

/// Lines seen from above, coloured by height from the lowest to the highest.
fn lines(lines: &[SketchLine], side: usize) -> Picture {
    let span = |of: fn(&SketchPoint) -> Option<f64>| {
        let all = lines.iter().flatten().filter_map(of);
        all.fold([f64::MAX, f64::MIN], |[lo, hi], v| [lo.min(v), hi.max(v)])
    };
    let (x, y, z) = (span(|p| Some(p.0[0])), span(|p| Some(p.0[1])), span(|p| p.1));
    let extent = (x[1] - x[0]).max(y[1] - y[0]).max(1e-6) * 1.1;
    let shade = Shade::new(z);
    let place = |v: f64, [lo, hi]: [f64; 2]| ((v - (lo + hi) / 2.0) / extent + 0.5) * side as f64;
    let mut canvas = vec![GROUND; side * side];
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        let [from, to] = [pair[0].0, pair[1].0].map(|at| [place(at[0], x), place(at[1], y)]);
        let color = pair[1].1.map_or(PLAIN, |height| shade.color(height));
        let steps =
            (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil().clamp(1.0, side as f64) as usize;
        for k in 0..=steps {
            let t = k as f64 / steps as f64;
            let at = [0, 1].map(|i| (from[i] + (to[i] - from[i]) * t).clamp(0.0, side as f64 - 1.0) as usize);
            canvas[at[1] * side + at[0]] = color;
        }
    }
    paint([side, side], canvas.into_iter())
}

/// What is marked, heights coloured from the lowest to the highest.
fn marks(grid: &Grid, marks: &[SketchMark], side: usize) -> Picture {
    let (cols, rows) = (grid.cols, grid.rows);
    let step = cols.max(rows).div_ceil(side.max(1)).max(1);
    let heights = marks.iter().filter_map(|mark| match mark {
        SketchMark::Height(height) => Some(f64::from(*height)),
        _ => None,
    });
    let shade = Shade::new(heights.fold([f64::MAX, f64::MIN], |[lo, hi], v| [lo.min(v), hi.max(v)]));
    // A thin line is seen where any of the samples under a pixel is marked.
    let pixel = |i: usize, j: usize| {
        let under = (j..(j + step).min(rows)).flat_map(|j| (i..(i + step).min(cols)).map(move |i| [i, j]));
        let mut best = GROUND;
        for [i, j] in under {
            match marks[j * cols + i] {
                SketchMark::Height(height) => return shade.color(height.into()),
                SketchMark::Strong => best = STRONG,
                SketchMark::Weak if best == GROUND => best = WEAK,
                SketchMark::Weak | SketchMark::Nothing => (),
            }
        }
        best
    };
    let size = [cols.div_ceil(step), rows.div_ceil(step)];
    let colors = (0..rows).step_by(step).flat_map(|j| (0..cols).step_by(step).map(move |i| (i, j)));
    paint(size, colors.map(|(i, j)| pixel(i, j)))
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

fn paint([width, height]: [usize; 2], colors: impl Iterator<Item = [f32; 3]>) -> Picture {
    let level = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    Picture { width, height, rgb: colors.map(|c| c.map(level)).collect() }
}
