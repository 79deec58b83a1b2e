//! What the water of the last level does, as a mean: on steep beds it runs in waves, and a picture of one moment shows them.

use super::Run;

/// The part of the rain over which the mean is taken.
const PART: usize = 2;

/// Number of readings, if there are as many steps.
const READINGS: usize = 48;

/// Water over a while, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Water {
    /// Depth, in metres.
    pub depth: Vec<f32>,
    /// Discharge across a cell, in m³/s; 0 in the sea, which takes what comes.
    pub flow: Vec<f32>,
    /// Speed to the east and south, in m/s; 0 in the sea.
    pub velocity: Vec<[f32; 2]>,
}

/// Readings of depth and flow over the last half of the rain.
pub(super) struct Gauge {
    first: usize,
    every: usize,
    count: usize,
    /// Depth in metres, and flow to the east and south in m²/s, summed over readings.
    sums: Vec<[f32; 3]>,
}

impl Gauge {
    /// A gauge of so many steps.
    pub(super) fn new(steps: usize) -> Self {
        let (first, every) = (steps - steps / PART, (steps / PART / READINGS).max(1));
        Self { first, every, count: 0, sums: Vec::new() }
    }

    /// Reads the water after a step, when it is time.
    pub(super) fn read(&mut self, step: usize, run: &Run) {
        if step < self.first || !(step - self.first).is_multiple_of(self.every) {
            return;
        }
        let (site, state) = (run.site(), run.state());
        self.sums.resize(site.len(), [0.0; 3]);
        self.count += 1;
        for (cell, sum) in self.sums.iter_mut().enumerate() {
            let [x, y] = state.vector(site, cell);
            *sum = [sum[0] + state.depth(site, cell), sum[1] + x, sum[2] + y];
        }
    }

    /// The mean; what is there now without a reading.
    pub(super) fn water(mut self, run: &Run) -> Water {
        let (site, state) = (run.site(), run.state());
        if self.count == 0 {
            self.first = 0;
            self.read(0, run);
        }
        let mut water = Water::default();
        let part = 1.0 / self.count as f32;
        for (cell, sum) in self.sums.iter().enumerate() {
            let [depth, x, y] = sum.map(|sum| sum * part);
            let in_sea = site.sea.is_some_and(|sea| site.height[cell] + state.change(site, cell) < sea);
            let [x, y] = if in_sea { [0.0; 2] } else { [x, y] };
            let slow = 1.0 / depth.max(Run::THINNEST);
            water.depth.push(depth);
            water.flow.push((x * x + y * y).sqrt() * site.cell as f32);
            water.velocity.push([x * slow, y * slow]);
        }
        water
    }
}
