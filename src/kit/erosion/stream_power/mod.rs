//! Land that rises while rivers cut into it: `dh/dt = U − K A^m S + D ∇²h`, over some hundred thousand years or more
//! \[howard1994, whipple1999\].
//!
//! `U` is the uplift in metres a year, `A` the drained area in m², `S` the slope along the river, and `K` how easily the
//! rock gives way, in m^(1 − 2m) a year. The term of rivers is implicit from the outlets up, so that a step may be as long as
//! one likes \[braun2013\]; that of hillslopes is implicit along rows and then along columns.
//!
//! Work goes up the [`Ladder`]: each level has half of the time that is left, and the last all of it.
//!
//! # What keeps the grid out of sight
//! Rivers of steepest descent run in eight directions. Here the receiver of each cell is drawn from the two on either side
//! of the true direction ([`Spread::draw`](crate::kit::flow::Spread::draw)), the same at each step, so that rivers stay.
//!
//! Where `U / (K A^m)` is steeper than any slope stands, a cut at the angle of repose leaves flat facets. Here `A` is the
//! drained area plus that at which a river begins: the area with which the steady slope is the angle of repose. So slopes
//! ease from there to the rivers, and no cell is small enough to change them.

mod creep;
mod step;
mod wander;

use super::ladder::{Ladder, Level};
use crate::kit::hash;
use crate::kit::noise::{Form, Fractal, Spectrum};
use crate::value::Field;
use crate::work::{Cancelled, Work};
use step::Step;
use wander::wander;

/// Steps on the first level; each further level has half as many, and [`FEWEST`] at least.
const STEPS: usize = 96;
/// Fewest steps on a level.
const FEWEST: usize = 8;
/// Height of the grains that a land without form starts with, in metres.
const GRAINS: f64 = 1.0;

/// How land rises and wears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How long it goes on, in years.
    pub years: f64,
    /// Uplift where its field is 1, in metres a year.
    pub uplift: f64,
    /// How easily rock gives way.
    pub erodibility: Erodibility,
    /// The power `m` of the drained area.
    pub exponent: f64,
    /// Slope on which rivers begin, as a tangent.
    pub steepest: f64,
    /// Diffusivity `D` of hillslopes, in m² a year.
    pub creep: f64,
    /// How far rock varies: erodibility goes up and down by so many powers of two.
    pub variety: f64,
    /// Size of the largest bodies of rock, in metres.
    pub bodies: f64,
    /// Decides which way water takes.
    pub seed: u64,
}

/// How easily rock gives way where its field is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Erodibility {
    /// `K`, in m^(1 − 2m) a year.
    Given(f64),
    /// As easily as the steady land needs whose highest place stands so many metres above its outlet.
    ForRelief(f64),
}

/// What land is made of, on the base grid.
#[derive(Clone, Copy, Debug)]
pub struct Land<'a> {
    /// Heights at the start, in metres; without them level land at 0 with grains of a metre.
    pub height: Option<&'a Field>,
    /// Factor on the uplift; 1 where there is none.
    pub uplift: Option<&'a Field>,
    /// Factor on how easily rock gives way.
    pub erodibility: Option<&'a Field>,
    /// Factor on all that happens; where it is 0 not a bit changes.
    pub mask: Option<&'a Field>,
    /// Height below which nothing wears, in metres.
    pub sea: Option<f64>,
    /// The base grid.
    pub base: &'a Level,
}

/// Land after its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Eroded {
    /// Heights, in metres, row by row.
    pub height: Vec<f32>,
    /// Drained area, in m², along the ways that were drawn.
    pub area: Vec<f64>,
    /// Rock that went, in metres: what rose less what the land gained.
    pub wear: Vec<f32>,
    /// `K` at the end.
    pub erodibility: f64,
}

/// A finished level: its heights in metres.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Where its points stand.
    pub level: &'a Level,
    /// Heights, in metres, row by row.
    pub height: &'a [f32],
}

impl Settings {
    /// The factor on how easily rock gives way at the points of a level.
    fn rock(&self, level: &Level, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
        if self.variety == 0.0 {
            return Ok(vec![1.0; level.grid.len()]);
        }
        let spectrum = Spectrum { feature_size: self.bodies, octaves: 7, lacunarity: 2.0, gain: 0.8 };
        let noise = Fractal::new(Form::Fbm, spectrum, self.seed, 0.0, 2.0 * self.variety);
        let over = noise.over(&level.grid.xs());
        level.fill(work, |j, out| {
            over.row(level.grid.y(j), out);
            out.iter_mut().for_each(|v| *v = libm::exp2f(*v));
        })
    }
}

/// Cells that all steps together go through, for an estimate.
pub fn cell_steps(base: &Level) -> f64 {
    let ladder = Ladder::new(&base.grid, f64::INFINITY);
    ladder.levels().iter().enumerate().map(|(k, level)| (level.grid.len() * steps(k)) as f64).sum()
}

fn steps(level: usize) -> usize {
    (STEPS >> level.min(16)).max(FEWEST)
}

/// Lets land rise and wear. Its border stays where it is: that is where water leaves, beside the sea.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn erode(
    land: &Land<'_>,
    settings: &Settings,
    on_level: &mut dyn FnMut(Picture<'_>),
    work: &Work<'_>,
) -> Result<Eroded, Cancelled> {
    let ladder = Ladder::new(&land.base.grid, f64::INFINITY);
    let levels = ladder.levels();
    let total = cell_steps(land.base);
    let (mut done, mut left, mut erodibility) = (0.0, settings.years, 1e-5);
    let mut below: Option<(&Level, Vec<f32>)> = None;
    for (k, level) in levels.iter().enumerate() {
        let share = (level.grid.len() * steps(k)) as f64 / total;
        let stage = work.stage(done as f32, (done + share).min(1.0) as f32);
        done += share;
        let is_last = k + 1 == levels.len();
        let years = if is_last { left } else { 0.5 * left };
        left -= years;
        let start = match land.height {
            Some(height) => level.sample(height, &stage.quiet())?,
            None => vec![0.0; level.grid.len()],
        };
        let mut step = Step::new(land, settings, level, erodibility, &stage.quiet())?;
        let mut height = start.clone();
        match &below {
            Some((from, change)) => {
                let carried =
                    wander([from, level], change.clone(), &step.mask, settings.seed, &stage.quiet())?;
                // A sum with 0 would turn a negative zero around.
                height.iter_mut().zip(&carried).filter(|(_, c)| **c != 0.0).for_each(|(h, c)| *h += c);
            }
            None if land.height.is_none() && years > 0.0 => step.strew(&mut height, GRAINS),
            None => (),
        }
        let count = if years > 0.0 { steps(k) } else { 0 };
        for n in 0..count {
            step.run(
                &mut height,
                years / count as f64,
                &stage.stage(n as f32 / count as f32, (n + 1) as f32 / count as f32),
            )?;
        }
        erodibility = step.erodibility;
        on_level(Picture { level, height: &height });
        if is_last {
            let area = step.area(&height, &work.quiet())?;
            let rose = |i: usize| f64::from(step.uplift[i]) * settings.years;
            let gained = |i: usize| f64::from(height[i]) - f64::from(start[i]);
            let wear = (0..height.len()).map(|i| (rose(i) - gained(i)).max(0.0) as f32).collect();
            return Ok(Eroded { height, area, wear, erodibility });
        }
        let change = height.iter().zip(&start).map(|(h, s)| h - s).collect();
        below = Some((level, change));
    }
    Ok(Eroded { height: Vec::new(), area: Vec::new(), wear: Vec::new(), erodibility })
}

/// A number in \[0, 1) of a point of a level.
fn chance(seed: u64, level: &Level, cell: usize) -> f64 {
    hash::unit(seed ^ hash::mix(u64::from(level.across())), cell as u64)
}
