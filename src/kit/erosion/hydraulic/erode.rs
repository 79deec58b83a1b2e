//! Erosion up the ladder: each level rains for its share of the time, on what the coarser ones left.

use super::climate::Climate;
use super::gauge::{Gauge, Water};
use super::refine::{self, Coarse};
use super::{Account, Border, Run, Settings, Site, State};
use crate::kit::erosion::ladder::{COARSEST, Ladder, Level};
use crate::kit::flow::{Depressions, Surface};
use crate::value::Field;
use crate::work::{Cancelled, Work};

/// The part of the time left that a level does not take: each level has this much of the time of the one before. Its steps are
/// half as long, so it takes a little more than half as many.
const LEFT: f64 = 0.3;

/// How long load settles after the rain, as a part of the rain of the last level.
const RECESSION: f64 = 0.3;

/// Land that water runs over; all fields on the base grid.
#[derive(Clone, Copy, Debug)]
pub struct Land<'a> {
    /// Heights of the ground, loose ground included, in metres.
    pub height: &'a Field,
    /// Factor on the rain, 0 to 1.
    pub moisture: Option<&'a Field>,
    /// Where the discharge of the sources comes up, 0 to 1.
    pub sources: Option<&'a Field>,
    /// Temperature in °C.
    pub temperature: Option<&'a Field>,
    /// 0 for rock that wears as the settings say, 1 for rock that does not wear.
    pub hardness: Option<&'a Field>,
    /// Ground of that which is loose, in metres.
    pub loose: Option<&'a Field>,
    /// Factor on every exchange of ground; where it is 0 not a bit changes.
    pub mask: Option<&'a Field>,
    /// Level of the sea, in metres.
    pub sea: Option<f64>,
    /// The base grid.
    pub base: Level,
}

/// Land after the rain; all row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Eroded {
    /// Heights, in metres.
    pub height: Vec<f32>,
    /// Loose ground, in metres.
    pub loose: Vec<f32>,
    /// Rock that went, in metres.
    pub wear: Vec<f32>,
    /// Ground laid down less ground taken, in metres.
    pub deposit: Vec<f32>,
    /// The water towards the end of the rain.
    pub water: Water,
    /// Solid that the water still carries, in m³.
    pub carried: f64,
    /// What land got and gave, of all levels.
    pub account: Account,
}

/// A finished level: its heights in metres.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Where its points stand.
    pub level: &'a Level,
    /// Heights, in metres, row by row.
    pub height: &'a [f32],
}

/// Seconds of rain of the levels of a ladder, and the steps in which each goes through them.
fn times(ladder: &Ladder, settings: &Settings) -> Vec<(f64, usize)> {
    // What is left after a level depends on its cells alone, so that a coarse base has the rain that a finer one has there.
    let left = |level: &Level| {
        let above = libm::log2((f64::from(level.across()) / f64::from(COARSEST)).max(1.0));
        libm::pow(LEFT, above + 1.0)
    };
    let mut before = 1.0;
    let rain = |level: &Level| {
        let left = left(level);
        let seconds =
            (std::mem::replace(&mut before, left) - left).max(0.0) * settings.hours.max(0.0) * 3600.0;
        (seconds, libm::ceil(seconds / settings.longest_step(level.grid.cell())) as usize)
    };
    ladder.levels().iter().map(rain).collect()
}

/// Cells that all steps together go through, for an estimate.
pub fn cell_steps(base: &Level, settings: &Settings) -> f64 {
    let ladder = Ladder::new(&base.grid, settings.feature);
    let times = times(&ladder, settings);
    let cells = |level: &Level| level.grid.len() as f64;
    let all: f64 = ladder.levels().iter().zip(&times).map(|(level, (_, n))| cells(level) * *n as f64).sum();
    all + times.last().map_or(0.0, |(_, n)| RECESSION * *n as f64 * cells(base))
}

/// Lets rain fall on land.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn erode(
    land: &Land<'_>,
    settings: &Settings,
    on_level: &mut dyn FnMut(Picture<'_>),
    work: &Work<'_>,
) -> Result<Eroded, Cancelled> {
    let ladder = Ladder::new(&land.base.grid, settings.feature);
    let (levels, times) = (ladder.levels(), times(&ladder, settings));
    let total = cell_steps(&land.base, settings).max(1.0);
    let (mut done, mut elapsed, mut account) = (0.0, 0.0, Account::default());
    let mut below: Option<(&Level, Site, State)> = None;
    for (k, (level, (seconds, steps))) in levels.iter().zip(times).enumerate() {
        let is_last = k + 1 == levels.len();
        let rest = if is_last { libm::ceil(RECESSION * steps as f64) as usize } else { 0 };
        let share = (steps + rest) as f64 * level.grid.len() as f64 / total;
        let stage = work.stage(done as f32, (done + share).min(1.0) as f32);
        done += share;
        let quiet = stage.quiet();
        let climate = Climate::new(settings, level, land.moisture, land.sources, &quiet)?;
        let mut site = site(land, settings, level, &climate, &quiet)?;
        let state = start(below.take(), level, &mut site, settings, &mut account, &quiet)?;
        let dt = if steps > 0 { seconds / steps as f64 } else { 1.0 };
        let mut run = Run::new(site, state, settings, dt);
        let all = (steps + rest).max(1) as f32;
        let water = pour(&mut run, &climate, elapsed, [steps, rest], &stage.stage(0.0, steps as f32 / all))?;
        elapsed += seconds;
        run.rain(None);
        for n in 0..rest {
            run.step(&quiet)?;
            stage.report((steps + n + 1) as f32 / all);
        }
        account += *run.account();
        let (site, state) = run.into_parts();
        let height = height(&site, &state);
        on_level(Picture { level, height: &height });
        if is_last {
            return Ok(finish(site, state, height, water, account));
        }
        below = Some((level, site, state));
    }
    unreachable!("a ladder has a level")
}

/// The state at the start of a level: that of the coarser one, or the input.
fn start(
    below: Option<(&Level, Site, State)>,
    level: &Level,
    site: &mut Site,
    settings: &Settings,
    account: &mut Account,
    work: &Work<'_>,
) -> Result<State, Cancelled> {
    let Some((from, below, coarse)) = below else {
        fill(site, settings, work)?;
        return Ok(State::of(site));
    };
    let from = Coarse { level: from, site: &below, state: &coarse };
    let mut state = refine::ground(from, level, site, settings, work)?;
    fill(site, settings, work)?;
    let (water, more) = refine::water(from, level, site, &state, work)?;
    account.refined += more;
    state.water = water;
    state.flow = refine::flow(from, level, work)?;
    Ok(state)
}

/// Rains for so many steps from a time on; the mean of the water where so many steps of rest follow, nothing where none do.
fn pour(
    run: &mut Run,
    climate: &Climate<'_>,
    elapsed: f64,
    [steps, rest]: [usize; 2],
    work: &Work<'_>,
) -> Result<Water, Cancelled> {
    let (quiet, dt) = (work.quiet(), run.dt());
    let mut slot = None;
    let mut gauge = (rest > 0 || steps == 0).then(|| Gauge::new(steps));
    for n in 0..steps {
        let now = climate.slot(elapsed + n as f64 * dt);
        if slot.replace(now) != Some(now) {
            run.rain(Some(climate.falling(now, &quiet)?));
        }
        run.step(&quiet)?;
        if let Some(gauge) = &mut gauge {
            gauge.read(n, run);
        }
        work.report((n + 1) as f32 / steps as f32);
    }
    Ok(gauge.map(|gauge| gauge.water(run)).unwrap_or_default())
}

/// What a level is given.
fn site(
    land: &Land<'_>,
    settings: &Settings,
    level: &Level,
    climate: &Climate<'_>,
    work: &Work<'_>,
) -> Result<Site, Cancelled> {
    let sample = |field: Option<&Field>, of: fn(f32) -> f32| -> Result<Option<Vec<f32>>, Cancelled> {
        let values = field.map(|field| level.sample(field, work)).transpose()?;
        Ok(values.map(|values| values.into_iter().map(of).collect()))
    };
    let mut site =
        Site::new(level.grid.cols, level.grid.rows, level.grid.cell(), level.sample(land.height, work)?);
    site.before = sample(land.loose, |loose| loose.max(0.0))?;
    site.soft = sample(land.hardness, |hardness| 1.0 - hardness.clamp(0.0, 1.0))?;
    site.mask = sample(land.mask, |mask| mask.clamp(0.0, 1.0))?;
    site.evaporation = climate.evaporation(land.temperature, work)?;
    site.sea = land.sea.map(|sea| sea as f32);
    site.open = settings.border == Border::Open;
    Ok(site)
}

/// Fills the sea, and the lakes where they are full.
fn fill(site: &mut Site, settings: &Settings, work: &Work<'_>) -> Result<(), Cancelled> {
    let sea = site.sea.map(f64::from);
    site.filled = if settings.full_lakes {
        let surface = Surface::new(site.cols, site.rows, site.cell, &site.height, sea);
        Depressions::find(&surface, work)?.filled(&surface, work)?
    } else {
        site.height.clone()
    };
    if let Some(sea) = site.sea {
        site.filled.iter_mut().for_each(|level| *level = level.max(sea));
    }
    Ok(())
}

/// The ground, in metres.
fn height(site: &Site, state: &State) -> Vec<f32> {
    let moved = |(cell, height): (usize, &f32)| match state.change(site, cell) {
        // A sum with 0 would turn a negative zero around.
        0.0 => *height,
        change => height + change,
    };
    site.height.iter().enumerate().map(moved).collect()
}

/// The result. Detail that faded went as rock or loose ground, and what filled hollows is loose.
fn finish(site: Site, mut state: State, height: Vec<f32>, water: Water, account: Account) -> Eroded {
    for (cell, &faded) in site.faded.iter().flatten().enumerate().filter(|(_, faded)| **faded != 0.0) {
        let loose = faded.min(state.loose[cell]);
        state.loose[cell] -= loose;
        state.wear[cell] += faded - loose;
    }
    let deposit = (0..site.len()).map(|cell| state.change(&site, cell)).collect();
    let carried = crate::kit::erosion::prolong::sum(&state.load, |load| load) * site.cell_area();
    let State { wear, loose, .. } = state;
    Eroded { height, loose, wear, deposit, water, carried, account }
}
