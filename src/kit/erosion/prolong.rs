//! Carrying what erosion changed from a level to the next finer one.
//!
//! A change is carried by a cubic B-spline: straight lines between the samples would leave stripes. A spline swings past
//! zero beside steep places, though, and wear, loose ground, depth and load have bounds; cutting at the bound alone makes
//! or loses up to 3 % of all that was moved. So what the cut added is taken from the rest of the same sign, in proportion,
//! and the sum of value times cell area is that of the coarser level to within rounding. [`Carried`] says what rounding, or
//! a bound that leaves no room, kept from arriving.
//!
//! What nothing touched stays untouched: between samples that are all 0 everything is 0, to the bit, and so is all where
//! the mask is 0.

use super::ladder::Level;
use crate::kit::spline::Spline;
use crate::work::{Cancelled, Work};

/// How a field is carried to a finer level.
#[derive(Clone, Copy, Debug)]
pub struct Rule<'a> {
    /// The curve between samples.
    pub curve: Curve,
    /// Least value at each point of the finer level; a value that is 0 is never moved by it.
    pub least: Least<'a>,
    /// Points of the finer level where this is 0 get 0; without a mask none.
    pub mask: Option<&'a [f32]>,
    /// Whether the sum of value times cell area must stay.
    pub volume: Volume,
}

/// The curve between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// A cubic B-spline through them.
    Smooth,
    /// Straight between them: never beyond them, but it shows creases.
    Straight,
}

/// The least that values may be.
#[derive(Clone, Copy, Debug)]
pub enum Least<'a> {
    /// As little as they like.
    Any,
    /// Nowhere below 0.
    Zero,
    /// Nowhere below a value of each point, which is 0 or less: a change of what was there before.
    Each(&'a [f32]),
}

/// Whether the sum of value times cell area must stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Volume {
    /// The curve decides: for heights and what does not add up.
    Free,
    /// It is that of the coarser level: for ground, water and load.
    Kept,
}

impl Rule<'static> {
    /// A change of heights, of either sign.
    pub const CHANGE: Self =
        Self { curve: Curve::Smooth, least: Least::Any, mask: None, volume: Volume::Free };
    /// An amount in metres, nowhere below 0, of which nothing is lost: wear, loose ground, load.
    pub const AMOUNT: Self =
        Self { curve: Curve::Smooth, least: Least::Zero, mask: None, volume: Volume::Kept };
}

/// A field on the finer level, and what it could not take along.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// Values at the points of the finer level, row by row.
    pub values: Vec<f32>,
    /// The sum of value times cell area on the coarser level minus that on the finer, in the unit of the values times m².
    /// With [`Volume::Kept`] no more than rounding, but where no value can take up the difference.
    pub left_behind: f64,
}

/// Carries a field from a level to a finer one of the same ladder.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
///
/// # Panics
/// When there is not one value per point of the coarser level, nor one mask and least value per point of the finer.
pub fn prolong(
    [from, to]: [&Level; 2],
    values: &[f32],
    rule: &Rule<'_>,
    work: &Work<'_>,
) -> Result<Carried, Cancelled> {
    let mut carried = match rule.curve {
        Curve::Smooth => smooth([from, to], values, work)?,
        Curve::Straight => straight([from, to], values, work)?,
    };
    if let Some(mask) = rule.mask {
        assert_eq!(mask.len(), carried.len(), "one mask value per point");
        carried.iter_mut().zip(mask).filter(|(_, mask)| **mask == 0.0).for_each(|(value, _)| *value = 0.0);
    }
    match rule.least {
        Least::Any => (),
        Least::Zero => carried.iter_mut().for_each(|value| *value = value.max(0.0)),
        Least::Each(least) => {
            assert_eq!(least.len(), carried.len(), "one least value per point");
            carried.iter_mut().zip(least).for_each(|(value, least)| *value = value.max(least.min(0.0)));
        }
    }
    let wanted = sum(values, |value| value) * from.cell_area();
    if rule.volume == Volume::Kept {
        balance(&mut carried, wanted / to.cell_area());
    }
    work.check()?;
    let left_behind = wanted - sum(&carried, |value| value) * to.cell_area();
    Ok(Carried { values: carried, left_behind })
}

/// Changes values so that they add up to a sum: what is too much is taken from those of its own sign, so that none passes
/// 0, and what is missing is added to them.
fn balance(values: &mut [f32], wanted: f64) {
    let over = sum(values, |value| value) - wanted;
    let [above, below] = [sum(values, |value| value.max(0.0)), sum(values, |value| (-value).max(0.0))];
    // What is over comes from the positive values; what is missing is spared by the negative ones, as far as they go, since
    // their bound lies below.
    let (of_positive, of_negative) = if over >= 0.0 {
        (1.0 - (over / above).min(1.0), 1.0)
    } else if below >= -over {
        (1.0, 1.0 + over / below)
    } else {
        (1.0 + (-over - below) / above, 0.0)
    };
    let usable = |factor: f64| if factor.is_finite() { factor } else { 1.0 };
    let (of_positive, of_negative) = (usable(of_positive), usable(of_negative));
    if of_positive != 1.0 || of_negative != 1.0 {
        for value in values {
            let factor = if *value > 0.0 { of_positive } else { of_negative };
            *value = (f64::from(*value) * factor) as f32;
        }
    }
}

/// Keeps values that are not below 0 to a most of each point, and adds what was above it to the others that are not 0, as far as
/// they have room.
pub fn cap(values: &mut [f32], most: impl Fn(usize) -> f32) {
    let before = sum(values, |value| value);
    for (k, value) in values.iter_mut().enumerate() {
        *value = value.min(most(k));
    }
    let over = before - sum(values, |value| value);
    if over <= 0.0 {
        return;
    }
    let room = |k: usize, value: f32| if value > 0.0 { f64::from(most(k) - value) } else { 0.0 };
    let whole: f64 = values.iter().enumerate().map(|(k, &value)| room(k, value)).sum();
    let part = if whole > 0.0 { (over / whole).min(1.0) } else { 0.0 };
    for (k, value) in values.iter_mut().enumerate() {
        *value += (part * room(k, *value)) as f32;
    }
}

/// A sum over values in their order.
pub fn sum(values: &[f32], of: impl Fn(f32) -> f32) -> f64 {
    // Blocks of one size whatever the machine; eight sums side by side, since each addition waits for the one before.
    let block = |block: &[f32]| {
        let mut sums = [0.0f64; 8];
        let eights = block.chunks_exact(8);
        let rest = eights.remainder();
        for eight in eights {
            sums.iter_mut().zip(eight).for_each(|(sum, &value)| *sum += f64::from(of(value)));
        }
        sums.iter_mut().zip(rest).for_each(|(sum, &value)| *sum += f64::from(of(value)));
        ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
    };
    values.chunks(1 << 12).map(block).sum()
}

/// The cubic B-spline through values at the points of a finer level.
fn smooth([from, to]: [&Level; 2], values: &[f32], work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
    if from.grid.is_empty() {
        return Ok(vec![0.0; to.grid.len()]);
    }
    let (cols, rows) = (from.grid.cols, from.grid.rows);
    let spline = Spline::fit(cols, rows, values);
    let touched = Touched::of(values, cols);
    work.check()?;
    let across: Vec<f64> = (0..to.grid.cols).map(|i| to.steps_on(from, i)).collect();
    let taps = spline.taps(across.iter().copied());
    to.fill(work, |j, out| {
        let v = to.steps_on(from, j);
        let near = touched.rows(v, rows);
        spline.row(v, &taps, out);
        // The swing of a spline goes on without end, as grains of dust that would wake what is at rest.
        for (out, &u) in out.iter_mut().zip(&across) {
            if !touched.near(&near, u, cols) {
                *out = 0.0;
            }
        }
    })
}

/// Straight lines between values at the points of a finer level.
fn straight([from, to]: [&Level; 2], values: &[f32], work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
    let (cols, rows) = (from.grid.cols, from.grid.rows);
    assert_eq!(values.len(), from.grid.len(), "one value per point");
    if values.is_empty() {
        return Ok(vec![0.0; to.grid.len()]);
    }
    let across: Vec<_> = (0..to.grid.cols).map(|i| between(to.steps_on(from, i), cols)).collect();
    to.fill(work, |j, out| {
        let ([top, bottom], t) = between(to.steps_on(from, j), rows);
        let (top, bottom) = (&values[top * cols..][..cols], &values[bottom * cols..][..cols]);
        for (out, &([a, b], s)) in out.iter_mut().zip(&across) {
            let along = |line: &[f32]| line[a] + (line[b] - line[a]) * s;
            let (top, bottom) = (along(top), along(bottom));
            *out = top + (bottom - top) * t;
        }
    })
}

/// The samples before and after a position on a line of `n`, and how far behind the first it lies.
fn between(steps: f64, n: usize) -> ([usize; 2], f32) {
    let at = steps.clamp(0.0, n.saturating_sub(1) as f64);
    let before = at.floor();
    ([before as usize, (before as usize + 1).min(n - 1)], (at - before) as f32)
}

/// Which of the values are not 0.
struct Touched {
    flags: Vec<bool>,
    cols: usize,
}

impl Touched {
    fn of(values: &[f32], cols: usize) -> Self {
        Self { flags: values.iter().map(|&value| value != 0.0).collect(), cols }
    }

    /// Columns in which one of the four rows around a position is touched.
    fn rows(&self, v: f64, rows: usize) -> Vec<bool> {
        let mut any = vec![false; self.cols];
        for row in around(v, rows) {
            let flags = &self.flags[row * self.cols..][..self.cols];
            any.iter_mut().zip(flags).for_each(|(any, flag)| *any |= flag);
        }
        any
    }

    /// Whether one of the four columns around a position is touched.
    fn near(&self, rows: &[bool], u: f64, cols: usize) -> bool {
        rows[around(u, cols)].iter().any(|&touched| touched)
    }
}

/// The two samples on either side of a position on a line of `n`; of one that meets a sample those beside it.
fn around(steps: f64, n: usize) -> std::ops::Range<usize> {
    let at = steps.clamp(0.0, n.saturating_sub(1) as f64);
    let before = at.floor() as usize;
    before.saturating_sub(1)..(at.ceil() as usize + 2).min(n)
}
