//! Rivers and ridges on the samples of a grid.

use super::line::Line;
use crate::kit::noise::Fractal;
use crate::value::Grid;
use crate::work::{Cancelled, Work};

/// What crosses a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feature {
    /// Nothing.
    #[default]
    Open,
    /// A river, whatever ridge crosses as well.
    River,
    /// A ridge.
    Ridge,
}

/// Lines between two looks at whether to stop.
const BATCH: usize = 256;

/// The rivers and ridges of a grid, sample by sample, row by row.
///
/// Where several rivers cross a sample, the lowest says its height; where several ridges do, the highest. A river goes
/// over any ridge. Draw the rivers first, then the ridges, then [`roughen`](Self::roughen).
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    grid: Grid,
    /// What crosses each sample.
    pub features: Vec<Feature>,
    /// Its height in metres; 0 where nothing does.
    pub height: Vec<f32>,
}

impl Skeleton {
    /// A grid that nothing crosses.
    pub fn new(grid: Grid) -> Self {
        Self { grid, features: vec![Feature::Open; grid.len()], height: vec![0.0; grid.len()] }
    }

    /// Takes all lines away.
    pub fn clear(&mut self) {
        self.features.fill(Feature::Open);
        self.height.fill(0.0);
    }

    /// Draws rivers. Lines with a number that is not finite are left out.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn rivers(&mut self, work: &Work<'_>, lines: impl Iterator<Item = Line>) -> Result<(), Cancelled> {
        self.draw(work, lines, |feature, here, height| {
            if *feature != Feature::River || height < *here {
                (*feature, *here) = (Feature::River, height);
            }
        })
    }

    /// Draws ridges where no river is. Lines with a number that is not finite are left out.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn ridges(&mut self, work: &Work<'_>, lines: impl Iterator<Item = Line>) -> Result<(), Cancelled> {
        self.draw(work, lines, |feature, here, height| match feature {
            Feature::River => (),
            Feature::Ridge => *here = here.max(height),
            Feature::Open => (*feature, *here) = (Feature::Ridge, height),
        })
    }

    fn draw(
        &mut self,
        work: &Work<'_>,
        lines: impl Iterator<Item = Line>,
        put: impl Fn(&mut Feature, &mut f32, f32),
    ) -> Result<(), Cancelled> {
        // Enough for progress.
        let count = lines.size_hint().1.unwrap_or(1);
        for (n, line) in lines.enumerate() {
            if n % BATCH == 0 {
                work.step(n as f32 / count as f32)?;
            }
            line.walk(&self.grid, |at, height| put(&mut self.features[at], &mut self.height[at], height));
        }
        Ok(())
    }

    /// Adds noise to the ridges, \[zhang2016\] (5), and lifts each to the highest river among the eight samples around it.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn roughen(&mut self, work: &Work<'_>, noise: Option<&Fractal>) -> Result<(), Cancelled> {
        let (grid, features, before) = (&self.grid, &self.features, &self.height);
        let cols = grid.cols;
        let mut after = vec![0.0; before.len()];
        work.rows(&mut after, cols, (1 << 14) / cols.max(1) + 1, |j, out| {
            let span = j * cols..(j + 1) * cols;
            out.copy_from_slice(&before[span.clone()]);
            let ridges: Vec<usize> =
                (0..cols).filter(|i| features[span.start + i] == Feature::Ridge).collect();
            if ridges.is_empty() {
                return;
            }
            let mut rough = vec![0.0; ridges.len()];
            if let Some(noise) = noise {
                let xs: Vec<f64> = ridges.iter().map(|&i| grid.x(i)).collect();
                noise.over(&xs).row(grid.y(j), &mut rough);
            }
            for (&i, rough) in ridges.iter().zip(rough) {
                out[i] = (out[i] + rough).max(self.bank([i, j]));
            }
        })?;
        self.height = after;
        Ok(())
    }

    /// The highest river among the eight samples around one; the least number where there is none.
    fn bank(&self, [i, j]: [usize; 2]) -> f32 {
        let (cols, rows) = (self.grid.cols, self.grid.rows);
        let mut highest = f32::MIN;
        for row in j.saturating_sub(1)..(j + 2).min(rows) {
            for at in row * cols + i.saturating_sub(1)..row * cols + (i + 2).min(cols) {
                if self.features[at] == Feature::River {
                    highest = highest.max(self.height[at]);
                }
            }
        }
        highest
    }
}
