//! Midpoint displacement and its inverse: filling samples beside a skeleton \[zhang2016, section 5.B\].
//!
//! Round `r` works on squares of side `2^r` cells, whose corners stand at whole multiples of it. Its inverse step fills an
//! unknown corner from the known centres and edge midpoints of its four squares, each weighted by one over its distance.
//! Then, from that side down to two cells, midpoint displacement fills an unknown centre of a square from two corners or
//! more, and an unknown midpoint of an edge from two or more of its ends and of the centres beside it. Nothing is filled
//! over more than `limit`. What is filled gets `displacement · d · n`, with `d` the distance and `n` noise of mean 0 and
//! standard deviation 1.
//!
//! No step reads what it writes, so the order within a step does not matter.

use rayon::prelude::*;

use super::bits::{Bits, moved};
use crate::kit::hash;
use crate::work::{Cancelled, Work};

/// How a skeleton is enriched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enrichment {
    /// Rounds, at most [`Enrichment::MOST_ROUNDS`]; more count as that.
    pub rounds: u32,
    /// Largest distance over which a sample is filled, in cells.
    pub limit: f64,
    /// Noise in parts of the distance, in the unit of the field for each cell.
    pub displacement: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Enrichment {
    /// Rounds up to squares of 64 cells.
    pub const MOST_ROUNDS: u32 = 6;
}

/// A field with more known samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Enriched {
    /// Values: those that were known as they were, those that were filled, and else what stood there.
    pub field: Vec<f32>,
    /// Where the value is known now.
    pub known: Bits,
}

/// Fills samples beside the known ones of a field of some columns, row by row.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn enrich(
    cols: usize,
    mut field: Vec<f32>,
    mut known: Bits,
    how: &Enrichment,
    work: &Work<'_>,
) -> Result<Enriched, Cancelled> {
    let rounds = how.rounds.min(Enrichment::MOST_ROUNDS);
    for round in 0..rounds {
        work.step(round as f32 / rounds as f32)?;
        let half = 1 << round;
        Step::corners(half).fill(cols, &mut field, &mut known, how, work)?;
        for half in (0..=round).rev().map(|r| 1 << r) {
            for step in [Step::centres(half), Step::midpoints(half, true), Step::midpoints(half, false)] {
                step.fill(cols, &mut field, &mut known, how, work)?;
            }
        }
    }
    Ok(Enriched { field, known })
}

/// Filling the samples of some columns and rows from neighbours at a distance.
struct Step {
    /// Half the side of the squares, in cells: columns and rows come again after twice as many.
    half: usize,
    /// First column and row.
    first: [usize; 2],
    /// The neighbours, in halves to the east and south.
    near: Vec<[i32; 2]>,
    /// Neighbours that must be known.
    least: u32,
    /// The distance that noise is measured by, in halves.
    distance: f64,
}

const SIDES: [[i32; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];
const DIAGONALS: [[i32; 2]; 4] = [[-1, -1], [1, -1], [-1, 1], [1, 1]];

impl Step {
    fn corners(half: usize) -> Self {
        let near = [DIAGONALS, SIDES].concat();
        Self { half, first: [0, 0], near, least: 1, distance: 1.0 }
    }

    fn centres(half: usize) -> Self {
        let distance = std::f64::consts::SQRT_2;
        Self { half, first: [half, half], near: DIAGONALS.to_vec(), least: 2, distance }
    }

    /// Midpoints of the edges that run along rows, or else along columns.
    fn midpoints(half: usize, along: bool) -> Self {
        let first = if along { [half, 0] } else { [0, half] };
        Self { half, first, near: SIDES.to_vec(), least: 2, distance: 1.0 }
    }

    /// The neighbours that are near enough, each with its weight.
    fn weighted(&self, limit: f64) -> Vec<Neighbour> {
        let one = |&[across, down]: &[i32; 2]| {
            let (half, steps) = (self.half as i32, f64::from(across * across + down * down).sqrt());
            let near = steps * self.half as f64 <= limit;
            near.then_some(Neighbour { across: across * half, down, weight: (1.0 / steps) as f32 })
        };
        self.near.iter().filter_map(one).collect()
    }

    fn fill(
        &self,
        cols: usize,
        field: &mut [f32],
        known: &mut Bits,
        how: &Enrichment,
        work: &Work<'_>,
    ) -> Result<(), Cancelled> {
        let near = self.weighted(how.limit);
        if cols == 0 || near.is_empty() {
            return Ok(());
        }
        let period = 2 * self.half;
        // Squares have at most 64 columns, so one pattern of columns serves every word.
        let pattern = (self.first[0]..64).step_by(period).fold(0_u64, |w, c| w | 1 << c);
        let valid: Vec<u64> = (0..known.words).map(|w| known.valid(w) & pattern).collect();
        let is_target = |row: usize| row % period == self.first[1];
        let (values, other_values) = parted(field, cols, is_target);
        let (bits, other_bits) = parted(&mut known.data, valid.len(), is_target);
        let noise = how.displacement * self.distance * self.half as f64;
        let side = |row: Option<usize>| {
            let row = row?;
            Some(Known { values: other_values.get(row)?.as_deref()?, bits: other_bits.get(row)?.as_deref()? })
        };
        values.into_par_iter().zip(bits).with_min_len(64).try_for_each(|((row, values), (_, bits))| {
            work.check()?;
            let sides = [side(row.checked_sub(self.half)), side(Some(row + self.half))];
            let noise = Noise { size: noise, seed: how.seed, row };
            Row { near: &near, least: self.least, valid: &valid, sides, noise }.fill(values, bits);
            Ok(())
        })
    }
}

/// A neighbour of a sample: columns to the east, halves to the south, and its weight.
struct Neighbour {
    across: i32,
    down: i32,
    weight: f32,
}

/// A row that is read, and where it is known.
#[derive(Clone, Copy)]
struct Known<'a> {
    values: &'a [f32],
    bits: &'a [u64],
}

/// What fills one row.
struct Row<'a> {
    near: &'a [Neighbour],
    least: u32,
    /// The columns that are filled.
    valid: &'a [u64],
    /// The rows half a side to the north and south.
    sides: [Option<Known<'a>>; 2],
    noise: Noise,
}

impl Row<'_> {
    fn fill(&self, values: &mut [f32], bits: &mut [u64]) {
        for (word, valid) in self.valid.iter().enumerate() {
            let (mut once, mut twice) = (0, 0);
            for near in self.near {
                let there = self.bits(near, word, bits);
                twice |= once & there;
                once |= there;
            }
            let fresh = if self.least == 1 { once } else { twice } & valid & !bits[word];
            let mut left = fresh;
            while left != 0 {
                let bit = left.trailing_zeros();
                values[64 * word + bit as usize] = self.value(word, bit, values, bits);
                left &= left - 1;
            }
            bits[word] |= fresh;
        }
    }

    /// Which neighbours of the samples of a word are known.
    fn bits(&self, near: &Neighbour, word: usize, own: &[u64]) -> u64 {
        let row = match near.down {
            0 => own,
            down => match self.sides[usize::from(down > 0)] {
                Some(line) => line.bits,
                None => return 0,
            },
        };
        moved(row, word, near.across)
    }

    /// The weighted mean of the known neighbours of a sample, and noise.
    fn value(&self, word: usize, bit: u32, own: &[f32], own_bits: &[u64]) -> f32 {
        let col = 64 * word + bit as usize;
        let (mut sum, mut weights) = (0.0, 0.0);
        for near in self.near {
            if self.bits(near, word, own_bits) >> bit & 1 == 1 {
                let row = match near.down {
                    0 => own,
                    down => self.sides[usize::from(down > 0)].map_or(own, |line| line.values),
                };
                sum += near.weight * row[col.wrapping_add_signed(near.across as isize)];
                weights += near.weight;
            }
        }
        sum / weights + self.noise.at(col)
    }
}

/// Noise of a row.
struct Noise {
    size: f64,
    seed: u64,
    row: usize,
}

impl Noise {
    /// Noise of a column: four uniform numbers added, scaled to a standard deviation of one.
    fn at(&self, col: usize) -> f32 {
        if self.size == 0.0 {
            return 0.0;
        }
        let bits = hash::nth(self.seed, (self.row as u64) << 32 | col as u64);
        let sum: u32 = (0..4).map(|k| (bits >> (16 * k)) as u32 & 0xffff).sum();
        // Four numbers from 0 to 1 have the mean 2 and the variance 1/3.
        (self.size * (f64::from(sum) / 65535.0 - 2.0) * 3.0_f64.sqrt()) as f32
    }
}

/// Rows that are written, each with its number.
type Targets<'a, T> = Vec<(usize, &'a mut [T])>;
/// Rows that are read, by number; none where the row is written.
type Others<'a, T> = Vec<Option<&'a mut [T]>>;

/// Parts rows into those that are written and those that are read.
fn parted<T>(
    data: &mut [T],
    width: usize,
    is_target: impl Fn(usize) -> bool,
) -> (Targets<'_, T>, Others<'_, T>) {
    let (mut targets, mut others) = (Vec::new(), Vec::new());
    for (row, line) in data.chunks_mut(width).enumerate() {
        if is_target(row) {
            targets.push((row, line));
            others.push(None);
        } else {
            others.push(Some(line));
        }
    }
    (targets, others)
}
