//! Slippage alone, from coarse to fine: a cliff that falls spreads over many cells, which takes steps by their square.

use super::ladder::{Ladder, Level};
use super::prolong::{Least, Rule, prolong};
use super::slippage::{Ground, Repose, Slippage, Slopes};
use crate::kit::flow::neighbor::Cells;
use crate::value::Field;
use crate::work::{Cancelled, Work};

/// Land whose slopes give way, on the base grid.
#[derive(Clone, Copy, Debug)]
pub struct Land<'a> {
    /// Heights, in metres.
    pub height: &'a Field,
    /// Ground of that which is loose, in metres; none without it.
    pub loose: Option<&'a Field>,
    /// Tangent of the angle of repose of rock: for all, and a field that counts instead.
    pub rock: (f64, Option<&'a Field>),
    /// The same of loose ground.
    pub rubble: (f64, Option<&'a Field>),
    /// Factor on all that moves; where it is 0 not a bit changes.
    pub mask: Option<&'a Field>,
    /// Steps on each level.
    pub steps: usize,
}

/// Land after its slopes gave way.
#[derive(Clone, Debug, PartialEq)]
pub struct Slipped {
    /// Heights, in metres.
    pub height: Vec<f32>,
    /// Loose ground, in metres.
    pub loose: Vec<f32>,
    /// Rock that went, in metres.
    pub wear: Vec<f32>,
    /// Ground laid down less ground taken, in metres.
    pub deposit: Vec<f32>,
}

/// Cells that all steps together go through, for an estimate.
pub fn cell_steps(base: &Level, steps: usize) -> f64 {
    Ladder::new(&base.grid, f64::INFINITY).len() as f64 * steps as f64
}

/// Lets slopes give way.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn slip(land: &Land<'_>, work: &Work<'_>) -> Result<Slipped, Cancelled> {
    let ladder = Ladder::new(land.height.grid(), f64::INFINITY);
    let total = ladder.len().max(1) as f64;
    let (mut done, mut below): (f64, Option<(&Level, Ground, Vec<f32>)>) = (0.0, None);
    for level in ladder.levels() {
        let next = done + level.grid.len() as f64 / total;
        let stage = work.stage(done as f32, next.min(1.0) as f32);
        done = next;
        let (ground, before) = on_level(land, level, below.take(), &stage)?;
        below = Some((level, ground, before));
    }
    let (_, ground, before) = below.unwrap_or_else(|| (&ladder.levels()[0], Ground::default(), Vec::new()));
    let deposit: Vec<f32> =
        (0..ground.wear.len()).map(|k| (ground.loose[k] - before[k]) - ground.wear[k]).collect();
    let start = land.height.data();
    // A sum with 0 would turn a negative zero around.
    let moved = |(z, d): (&f32, &f32)| if *d == 0.0 { *z } else { z + d };
    let height = start.iter().zip(&deposit).map(moved).collect();
    Ok(Slipped { height, loose: ground.loose, wear: ground.wear, deposit })
}

/// The ground of a level after its steps, and the loose ground that it started with.
fn on_level(
    land: &Land<'_>,
    level: &Level,
    below: Option<(&Level, Ground, Vec<f32>)>,
    work: &Work<'_>,
) -> Result<(Ground, Vec<f32>), Cancelled> {
    let quiet = work.quiet();
    let sample = |field: Option<&Field>| field.map(|field| level.sample(field, &quiet)).transpose();
    let start = level.sample(land.height, &quiet)?;
    let mask = sample(land.mask)?;
    let mut before = sample(land.loose)?.unwrap_or_else(|| vec![0.0; start.len()]);
    before.iter_mut().for_each(|l| *l = l.max(0.0));
    let [rock, rubble] = [sample(land.rock.1)?, sample(land.rubble.1)?];
    let mut ground = Ground { wear: vec![0.0; start.len()], loose: before.clone() };
    if let Some((from, coarse, had)) = below {
        carry([from, level], (&coarse, &had), (&mut ground, &before), mask.as_deref(), &quiet)?;
    }
    let slopes = Slopes {
        cells: Cells { cols: level.grid.cols, rows: level.grid.rows },
        cell: level.grid.cell(),
        start: &start,
        rock: rock.as_deref().map_or(Repose::Even(land.rock.0 as f32), Repose::Each),
        loose: rubble.as_deref().map_or(Repose::Even(land.rubble.0 as f32), Repose::Each),
        mask: mask.as_deref(),
    };
    let mut slippage = Slippage::default();
    for n in 0..land.steps {
        let share = |n: usize| n as f32 / land.steps as f32;
        slippage.step(&slopes, &before, &mut ground, &work.stage(share(n), share(n + 1)).quiet())?;
        work.step(share(n + 1))?;
    }
    Ok((ground, before))
}

/// Carries what a coarse level changed to the next: wear, and loose ground as a change from that at the start.
fn carry(
    levels: [&Level; 2],
    (coarse, had): (&Ground, &[f32]),
    (ground, before): (&mut Ground, &[f32]),
    mask: Option<&[f32]>,
    work: &Work<'_>,
) -> Result<(), Cancelled> {
    let amount = Rule { mask, ..Rule::AMOUNT };
    ground.wear = prolong(levels, &coarse.wear, &amount, work)?.values;
    let change: Vec<f32> = coarse.loose.iter().zip(had).map(|(l, h)| l - h).collect();
    // No more goes than is there: the rest is spared elsewhere, so that what rock lost stands in the loose ground.
    let least: Vec<f32> = before.iter().map(|b| -b).collect();
    let rule = Rule { least: Least::Each(&least), ..amount };
    let change = prolong(levels, &change, &rule, work)?.values;
    let fine = ground.loose.iter_mut().zip(before).zip(&change);
    fine.for_each(|((l, before), change)| {
        *l = if *change == 0.0 { *before } else { (before + change).max(0.0) }
    });
    Ok(())
}
