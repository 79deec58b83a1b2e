//! How channels run over land whose depressions are filled.

use std::collections::BTreeMap;

use serde::Serialize;

use super::depressions::Filled;
use super::line::{Fit, Line};
use super::network::Node;
use crate::kit::flow::{Tree, accumulate};
use crate::work::{Cancelled, Work};

/// Fewest cells of channels that say something.
const FEWEST: usize = 50;
/// Width of a bin of drained areas, in decades.
const BIN: f64 = 0.2;
/// Fewest cells in a bin that counts.
const FEWEST_IN_BIN: usize = 20;
/// Steps over which the slope of a channel is taken.
const REACH: usize = 20;
/// Steps of the same where only ground counts that was not filled.
const SHORT_REACH: usize = 5;
/// Logarithm of an area of 1 km² in m².
const SQUARE_KILOMETRE: f64 = 6.0;

/// Channels: the cells that drain an area or more, each to the neighbour of steepest descent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Channels {
    /// The drained area from which a cell is a channel, in m².
    pub threshold: f64,
    /// Share of the channels that run over filled ground.
    pub filled: f64,
    /// Concavity `θ` of `S ~ A^−θ` \[flint1974\]: slopes over 20 steps of the filled surface, against the drained area. It
    /// says nothing where more than 0.3 of the channels are filled.
    pub concavity: Option<Fit>,
    /// The same of areas of 1 km² and more: smaller valleys are often cut by debris, and less concave.
    pub concavity_1km2: Option<Fit>,
    /// Concavity over 5 steps from cells that are neither filled nor level.
    pub concavity_unfilled: Option<Fit>,
    /// The same of areas of 1 km² and more.
    pub concavity_unfilled_1km2: Option<Fit>,
    /// Exponent `h` of the longest way upstream, `L ~ A^h` \[hack1957\].
    pub hack: Option<Fit>,
    /// Length of channels over the area of land, in km per km².
    pub density: f64,
    /// The same times the root of the threshold, which takes the unit and most of the threshold away.
    pub relative_density: f64,
    /// Share of all ways that run along the axes of the grid, 0.5 where they run any way; level ground left out.
    pub axis_share: Option<f64>,
    /// The same of channels.
    pub channel_axis_share: Option<f64>,
    /// Mean number of steps that a channel keeps its direction; level ground left out.
    pub straight_run: Option<f64>,
}

/// Channels on the grid.
pub(super) struct Course<'a> {
    filled: &'a Filled<'a>,
    tree: &'a Tree,
    cell: f64,
    /// Drained cells of each cell.
    area: &'a [u32],
    /// The cells that are channels, upstream first.
    cells: Vec<u32>,
}

impl<'a> Course<'a> {
    /// The channels that drain so many cells; none where there are too few to say something.
    pub(super) fn new(
        filled: &'a Filled<'a>,
        tree: &'a Tree,
        area: &'a [u32],
        threshold: u32,
    ) -> Option<Self> {
        let heights = filled.land.heights();
        let is_channel = |cell: &usize| area[*cell] >= threshold && heights[*cell].is_finite();
        let mut cells: Vec<u32> = (0..area.len()).filter(is_channel).map(|cell| cell as u32).collect();
        // A cell drains at least one more than what drains to it.
        cells.sort_unstable_by_key(|cell| (area[*cell as usize], *cell));
        let cell = filled.land.cell();
        (cells.len() >= FEWEST).then_some(Self { filled, tree, cell, area, cells })
    }

    /// The neighbour that a cell drains to, where that is land.
    fn down(&self, cell: usize) -> Option<usize> {
        self.tree.receiver(cell).filter(|down| self.filled.land.heights()[*down].is_finite())
    }

    /// Length of the step to that neighbour, in metres.
    fn step(&self, cell: usize) -> f64 {
        self.down(cell).map_or(0.0, |_| self.tree.length(cell))
    }

    fn square_metres(&self, cell: usize) -> f64 {
        f64::from(self.area[cell]) * self.cell * self.cell
    }

    fn channels(&self) -> impl Iterator<Item = usize> {
        self.cells.iter().map(|cell| *cell as usize)
    }

    /// The channels as a network.
    pub(super) fn nodes(&self) -> Vec<Node> {
        let rank = |cell: usize| {
            let key = (self.area[cell], cell as u32);
            self.cells.binary_search_by_key(&key, |cell| (self.area[*cell as usize], *cell)).ok()
        };
        let node = |cell: usize| Node {
            down: self.down(cell).and_then(rank).map(|rank| rank as u32),
            length: self.step(cell),
            area: self.square_metres(cell),
        };
        self.channels().map(node).collect()
    }

    /// The figures.
    pub(super) fn figures(&self, threshold: f64, work: &Work<'_>) -> Result<Channels, Cancelled> {
        let [concavity, concavity_1km2] = self.concavity(REACH, |_| true);
        work.step(0.3)?;
        let [concavity_unfilled, concavity_unfilled_1km2] =
            self.concavity(SHORT_REACH, |cell| !self.filled.is_level[cell]);
        work.step(0.5)?;
        let hack = self.hack(&work.stage(0.5, 0.9))?;
        let count = self.cells.len() as f64;
        let length: f64 = self.channels().map(|cell| self.step(cell)).sum();
        let density = length / (self.filled.land.count() as f64 * self.cell * self.cell);
        let filled = self.channels().filter(|cell| self.filled.is_filled(*cell)).count() as f64 / count;
        Ok(Channels {
            threshold,
            filled,
            concavity,
            concavity_1km2,
            concavity_unfilled,
            concavity_unfilled_1km2,
            hack,
            density: density * 1000.0,
            relative_density: density * threshold.sqrt(),
            axis_share: self.axis_share(0..self.area.len()),
            channel_axis_share: self.axis_share(self.channels()),
            straight_run: self.straight_run(),
        })
    }

    /// Concavity over all bins, and over those of 1 km² and more.
    fn concavity(&self, steps: usize, counts: impl Fn(usize) -> bool) -> [Option<Fit>; 2] {
        let slopes = self.channels().filter(|cell| counts(*cell));
        let slopes = slopes.filter_map(|cell| Some([self.square_metres(cell), self.slope(cell, steps)?]));
        let mean = |values: &mut [f64]| values.iter().sum::<f64>() / values.len() as f64;
        let points = binned(slopes, mean);
        [f64::NEG_INFINITY, SQUARE_KILOMETRE].map(|from| {
            let falls = points.iter().filter(|[area, slope]| *slope > 0.0 && *area >= from);
            let points: Vec<_> = falls.map(|[area, slope]| [*area, libm::log10(*slope)]).collect();
            if points.len() >= 5 { Line::even(points).map(Line::falling) } else { None }
        })
    }

    /// Mean slope of the filled surface over so many steps down; none where the way ends before.
    fn slope(&self, cell: usize, steps: usize) -> Option<f64> {
        let mut way = 0.0;
        let mut end = cell;
        for _ in 0..steps {
            way += self.step(end);
            end = self.down(end)?;
        }
        let level = |cell: usize| f64::from(self.filled.level[cell]);
        Some((level(cell) - level(end)) / way)
    }

    /// The exponent of the longest way upstream.
    fn hack(&self, work: &Work<'_>) -> Result<Option<Fit>, Cancelled> {
        let none = vec![0.0f32; self.area.len()];
        let climb =
            |cell: usize, way: f32, down: &mut f32| *down = down.max(way + self.tree.length(cell) as f32);
        let longest = accumulate::downwards(self.tree, none, climb, work)?;
        let ways = self.channels().map(|cell| [self.square_metres(cell), f64::from(longest[cell])]);
        let ways = ways.filter(|[_, way]| *way > 0.0).map(|[area, way]| [area, way.max(self.cell)]);
        let points = binned(ways, median).into_iter().map(|[area, way]| [area, libm::log10(way)]);
        let points: Vec<_> = points.collect();
        Ok(if points.len() >= 4 { Line::even(points).map(Line::rising) } else { None })
    }

    /// Share of the ways from cells, but for level ground, that run along the axes.
    fn axis_share(&self, cells: impl Iterator<Item = usize>) -> Option<f64> {
        let ways =
            cells.filter(|cell| !self.filled.is_level[*cell]).filter(|cell| self.down(*cell).is_some());
        let [all, axes] = ways.fold([0usize; 2], |[all, axes], cell| {
            [all + 1, axes + usize::from(self.tree.length(cell) <= self.cell)]
        });
        (all > 0).then(|| axes as f64 / all as f64)
    }

    /// Mean number of steps in the same direction, but for level ground.
    fn straight_run(&self) -> Option<f64> {
        let runs = |cell: usize| !self.filled.is_level[cell] && self.down(cell).is_some();
        let pairs = self.channels().filter(|cell| runs(*cell));
        let pairs = pairs.filter_map(|cell| Some((cell, self.down(cell).filter(|down| runs(*down))?)));
        let to = self.tree.directions();
        let [all, turns] = pairs.fold([0usize; 2], |[all, turns], (cell, down)| {
            [all + 1, turns + usize::from(to[cell] != to[down])]
        });
        (turns > 0).then(|| all as f64 / turns as f64)
    }
}

/// The mean logarithm of the area and some mean of the values, for each bin of drained areas in m².
fn binned(values: impl Iterator<Item = [f64; 2]>, mean: impl Fn(&mut [f64]) -> f64) -> Vec<[f64; 2]> {
    let mut bins: BTreeMap<i64, (f64, Vec<f64>)> = BTreeMap::new();
    for [area, value] in values {
        let area = libm::log10(area);
        let (areas, values) = bins.entry(libm::floor(area / BIN) as i64).or_default();
        *areas += area;
        values.push(value);
    }
    let full = bins.into_values().filter(|(_, values)| values.len() >= FEWEST_IN_BIN);
    full.map(|(areas, mut values)| [areas / values.len() as f64, mean(&mut values)]).collect()
}

/// The median of some values, of which there is one at least.
fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
