//! Slippage alone.
//!
//! It does not go from coarse to fine: a pillar that a point of a coarse level meets would be a cell of that level wide, and
//! what falls of it there would leave a hole around the pillar.

use super::slippage::{PACE, Repose, Slippage, Slopes};
use crate::kit::flow::neighbor::Cells;
use crate::value::Field;
use crate::work::{Cancelled, Work};

/// Land whose slopes give way; all fields on one grid.
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
    /// Number of steps. In so many an excess spreads over half as many cells as their square root.
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

/// Lets slopes give way.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn slip(land: &Land<'_>, work: &Work<'_>) -> Result<Slipped, Cancelled> {
    let (grid, start) = (land.height.grid(), land.height.data());
    let before: Vec<f32> = match land.loose {
        Some(loose) => loose.data().iter().map(|l| l.max(0.0)).collect(),
        None => vec![0.0; start.len()],
    };
    let slopes = Slopes {
        cells: Cells { cols: grid.cols, rows: grid.rows },
        cell: grid.cell(),
        start,
        before: Some(&before),
        rock: repose(land.rock.0, land.rock.1),
        loose: repose(land.rubble.0, land.rubble.1),
        mask: land.mask.map(Field::data),
        open: false,
        pace: PACE,
    };
    let (mut wear, mut loose) = (vec![0.0; start.len()], before.clone());
    let mut slippage = Slippage::new(slopes.cells);
    for n in 0..land.steps {
        slippage.step(&slopes, [&mut wear, &mut loose], work)?;
        work.step((n + 1) as f32 / land.steps as f32)?;
    }
    let deposit: Vec<f32> = (0..start.len()).map(|k| (loose[k] - before[k]) - wear[k]).collect();
    // A sum with 0 would turn a negative zero around.
    let moved = |(z, d): (&f32, &f32)| if *d == 0.0 { *z } else { z + d };
    let height = start.iter().zip(&deposit).map(moved).collect();
    Ok(Slipped { height, loose, wear, deposit })
}

fn repose(even: f64, each: Option<&Field>) -> Repose<'_> {
    each.map_or(Repose::Even(even as f32), |field| Repose::Each(field.data()))
}
