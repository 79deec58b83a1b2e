//! What a level hands to the next finer one: the change of the land so far, moved about by less than two cells.
//!
//! A river that once runs along a row of cells stays there, since its bed is the lowest of its neighbourhood: in eight
//! directions whatever chance says. So the change is read at places that a smooth noise moves, of waves some cells long. What
//! was straight on the coarse level then winds on the fine one, which cuts on from there.

use crate::kit::erosion::ladder::{COARSEST, Level};
use crate::kit::hash;
use crate::kit::noise::{Form, Fractal, Spectrum};
use crate::kit::sample::{Interpolation, Sampler};
use crate::value::{Field, Quantity};
use crate::work::{Cancelled, Work};

/// Length of the longest waves, in cells of the coarse level.
const WAVE: f64 = 7.0;
/// How far a place is moved along each axis at most on the first level, in its cells. On a level of four times as many it is
/// half as many of them: the finer, the less there is to make good, and the more a finer base shows the same land.
const REACH: f64 = 2.4;
/// Within so many cells of the border places move less, and on it not at all.
const FADE: f64 = 5.0;

/// The change of a level, moved about, at the points of a finer one; 0 on the border and where `share` is 0.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub(super) fn wander(
    [from, to]: [&Level; 2],
    change: Vec<f32>,
    share: &[f32],
    seed: u64,
    work: &Work<'_>,
) -> Result<Vec<f32>, Cancelled> {
    let field = Field::new(from.grid, Quantity::Elevation, change);
    let Some(sampler) = Sampler::new(&field) else { return Ok(vec![0.0; to.grid.len()]) };
    let cell = from.grid.cell();
    let noise = |axis: u64| {
        let spectrum = Spectrum { feature_size: WAVE * cell, octaves: 2, lacunarity: 2.0, gain: 0.5 };
        let seed = hash::nth(seed, 2 * u64::from(from.across()) + axis);
        Fractal::new(Form::Fbm, spectrum, seed, 0.0, 1.0)
    };
    let most = REACH * (f64::from(COARSEST) / f64::from(from.across().max(COARSEST))).sqrt();
    let xs = to.grid.xs();
    let (east, south) = (noise(0), noise(1));
    let (east, south) = (east.over(&xs), south.over(&xs));
    let last = [from.grid.cols, from.grid.rows].map(|n| n.saturating_sub(1) as f64);
    let (cols, rows) = (to.grid.cols, to.grid.rows);
    to.fill(work, |j, out| {
        let y = to.grid.y(j);
        let (mut dx, mut dy) = (vec![0.0; cols], vec![0.0; cols]);
        east.row(y, &mut dx);
        south.row(y, &mut dy);
        let v = to.steps_on(from, j);
        for (i, out) in out.iter_mut().enumerate() {
            if share[j * cols + i] == 0.0 || i == 0 || j == 0 || i + 1 == cols || j + 1 == rows {
                *out = 0.0;
                continue;
            }
            let u = to.steps_on(from, i);
            let inside = u.min(v).min(last[0] - u).min(last[1] - v).max(0.0);
            let reach = most * (inside / FADE).min(1.0);
            let place = [u + reach * f64::from(dx[i]), v + reach * f64::from(dy[i])];
            let at = [0, 1].map(|axis| place[axis].clamp(0.0, last[axis]));
            *out = sampler
                .value(Interpolation::Cubic, [from.grid.col as f64 + at[0], from.grid.row as f64 + at[1]]);
        }
    })
}
