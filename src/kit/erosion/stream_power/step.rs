//! One step of uplift and rivers on one level.

use super::creep::creep;
use super::{Erodibility, Land, Settings, chance};
use crate::kit::erosion::ladder::Level;
use crate::kit::flow::neighbor::Cells;
use crate::kit::flow::{Depressions, Rule, Spread, Surface, Tree, accumulate};
use crate::value::Field;
use crate::work::{Cancelled, Work};

/// The least and the greatest `K`: those of land that would be a millimetre or ten thousand kilometres high.
const RANGE: [f64; 2] = [1e-12, 1e3];

/// The largest area at which rivers begin, in m²; where nothing wears it would be infinite.
const LARGEST: f64 = 1e30;
/// Levels of so many cells and more take `K` as those below found it, so that a finer base shows the same land.
const SETTLED: u32 = 256;

/// The rates of a level, and `K` as it stands.
pub(super) struct Step<'a> {
    level: &'a Level,
    settings: &'a Settings,
    sea: Option<f64>,
    /// Uplift, in metres a year; 0 on the border and where the mask is 0.
    pub uplift: Vec<f32>,
    /// Factor on `K`; 0 on the border and where the mask is 0.
    ease: Vec<f32>,
    /// `(U / k)^(1/m)` of each point: the area at which rivers begin, but for a factor that all have.
    head: Vec<f32>,
    /// Factor on all that happens.
    pub mask: Vec<f32>,
    /// `K`.
    pub erodibility: f64,
}

impl<'a> Step<'a> {
    pub(super) fn new(
        land: &Land<'_>,
        settings: &'a Settings,
        level: &'a Level,
        erodibility: f64,
        work: &Work<'_>,
    ) -> Result<Self, Cancelled> {
        let sample = |field: Option<&Field>| match field {
            Some(field) => level.sample(field, work),
            None => Ok(vec![1.0; level.grid.len()]),
        };
        let (mut uplift, mut ease, mask) =
            (sample(land.uplift)?, sample(land.erodibility)?, sample(land.mask)?);
        let rock = settings.rock(level, work)?;
        ease.iter_mut().zip(&rock).for_each(|(ease, rock)| *ease *= rock);
        let power = 1.0 / settings.exponent;
        let mut head = vec![0.0; mask.len()];
        let cells = Cells { cols: level.grid.cols, rows: level.grid.rows };
        for (cell, &mask) in mask.iter().enumerate() {
            let share = if cells.on_border(cell) { 0.0 } else { mask.clamp(0.0, 1.0) };
            let (rate, easy) = (f64::from(uplift[cell]) * settings.uplift, f64::from(ease[cell].max(0.0)));
            if easy > 0.0 && rate > 0.0 {
                head[cell] = libm::pow(rate / easy, power).min(LARGEST) as f32;
            }
            (uplift[cell], ease[cell]) = ((rate * f64::from(share)) as f32, easy as f32 * share);
        }
        let erodibility = match settings.erodibility {
            Erodibility::Given(k) => k,
            Erodibility::ForRelief(_) => erodibility,
        };
        Ok(Self { level, settings, sea: land.sea, uplift, ease, head, mask, erodibility })
    }

    /// Gives level land grains to begin with.
    pub(super) fn strew(&self, height: &mut [f32], most: f64) {
        for (cell, (h, &ease)) in height.iter_mut().zip(&self.ease).enumerate() {
            if ease > 0.0 {
                *h += (most * chance(!self.settings.seed, self.level, cell)) as f32 * ease.min(1.0);
            }
        }
    }

    fn surface<'h>(&self, height: &'h [f32]) -> Surface<'h> {
        let grid = &self.level.grid;
        Surface::new(grid.cols, grid.rows, grid.cell(), height, self.sea)
    }

    /// The ways of the water, drawn by chance.
    fn ways(&self, height: &[f32], work: &Work<'_>) -> Result<Tree, Cancelled> {
        let surface = self.surface(height);
        let depressions = Depressions::find(&surface, &work.stage(0.0, 0.4))?;
        let filled = depressions.filled(&surface, &work.stage(0.4, 0.5))?;
        let tree = depressions.into_tree(&surface, &work.stage(0.5, 0.6))?;
        let spread = Spread::new(surface, &tree, &filled, Rule::Infinity);
        spread.draw(|cell| chance(self.settings.seed, self.level, cell), &work.stage(0.6, 1.0))
    }

    fn areas(&self, tree: &Tree, height: &[f32], work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
        let surface = self.surface(height);
        let cell = self.level.cell_area();
        let own = |i: usize| if surface.is_land(i) { cell } else { 0.0 };
        let amounts = accumulate::each(tree.cells, own, &work.stage(0.0, 0.2))?;
        accumulate::along(tree, amounts, &work.stage(0.2, 1.0))
    }

    /// The area that drains through each point, in m².
    pub(super) fn area(&self, height: &[f32], work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
        let tree = self.ways(height, work)?;
        self.areas(&tree, height, work)
    }

    /// `k A^m` of each point, with the area at which rivers begin added to that drained; 0 where nothing wears.
    fn power(&self, area: &[f64], work: &Work<'_>) -> Result<Vec<f64>, Cancelled> {
        let m = self.settings.exponent;
        let begin = libm::pow(1.0 / (self.erodibility * self.settings.steepest), 1.0 / m);
        let mut power = vec![0.0; area.len()];
        let cols = self.level.grid.cols;
        work.rows(&mut power, cols, (1 << 14) / cols.max(1) + 1, |j, row| {
            for (out, cell) in row.iter_mut().zip(j * cols..) {
                let whole = area[cell] + (f64::from(self.head[cell]) * begin).min(LARGEST);
                let raised = if m == 0.5 { whole.sqrt() } else { libm::pow(whole, m) };
                *out = f64::from(self.ease[cell]) * raised;
            }
        })?;
        Ok(power)
    }

    /// `K` with which the steady land on these ways would have the relief that is asked for.
    fn for_relief(&self, relief: f64, tree: &Tree, power: &[f64], work: &Work<'_>) -> Result<f64, Cancelled> {
        let rise = |cell: usize, down: f64| {
            let steady = f64::from(self.uplift[cell]) / power[cell];
            if steady.is_finite() { down + steady * tree.length(cell) } else { down }
        };
        let heights = tree.upwards(|_| 0.0, rise, work)?;
        let highest = heights.iter().fold(0.0, |most: f64, &h| most.max(h));
        let wanted = highest / relief;
        Ok(if wanted > 0.0 { wanted.clamp(RANGE[0], RANGE[1]) } else { self.erodibility })
    }

    /// Lets some years pass.
    pub(super) fn run(
        &mut self,
        height: &mut Vec<f32>,
        years: f64,
        work: &Work<'_>,
    ) -> Result<(), Cancelled> {
        let tree = self.ways(height, &work.stage(0.0, 0.6))?;
        let area = self.areas(&tree, height, &work.stage(0.6, 0.7))?;
        let power = self.power(&area, &work.stage(0.7, 0.75))?;
        if let Erodibility::ForRelief(relief) = self.settings.erodibility
            && self.level.across() < SETTLED
        {
            self.erodibility = self.for_relief(relief, &tree, &power, &work.quiet())?;
        }
        let (pace, surface) = (years * self.erodibility, self.surface(height));
        // A sum with 0 would turn a negative zero around.
        let risen = |cell: usize| match self.uplift[cell] {
            0.0 => height[cell],
            rate => (f64::from(height[cell]) + years * f64::from(rate)) as f32,
        };
        let rise = |cell: usize, down: f32| {
            let here = risen(cell);
            if here <= down || !surface.is_land(cell) {
                return here;
            }
            let factor = pace * power[cell] / tree.length(cell);
            if factor == 0.0 {
                here
            } else {
                ((f64::from(here) + factor * f64::from(down)) / (1.0 + factor)) as f32
            }
        };
        let new = tree.upwards(risen, rise, &work.stage(0.75, 0.9))?;
        *height = new;
        creep(height, self.level, &self.ease, self.settings.creep * years, &work.stage(0.9, 1.0))
    }
}
