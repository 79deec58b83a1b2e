//! Surfaces to be tried, and plain references for what is found on them.

use orograph::kit::flow::Surface;
use orograph::kit::hash;
use proptest::prelude::*;

/// Heights on a grid with a sea.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    pub cols: usize,
    pub rows: usize,
    pub height: Vec<f32>,
    pub sea: Option<f64>,
}

impl Ground {
    pub(crate) fn of(cols: usize, rows: usize, height: impl Fn(usize, usize) -> f32) -> Self {
        let height = (0..cols * rows).map(|i| height(i % cols, i / cols)).collect();
        Self { cols, rows, height, sea: None }
    }

    /// Noise of several octaves with some steps, so that there are flats, pits, and pits in flats.
    pub(crate) fn rough(cols: usize, rows: usize, seed: u64) -> Self {
        let value = |c: usize, r: usize, octave: u32| {
            hash::unit(seed + u64::from(octave), ((c >> octave) as u64) << 32 | (r >> octave) as u64)
        };
        let mut ground = Self::of(cols, rows, |c, r| {
            let sum: f64 = (0..5).map(|o| value(c, r, o) * f64::from(1 << o)).sum();
            (2.0 * sum).floor() as f32 * 0.5
        });
        ground.sea = Some(9.0);
        ground
    }

    pub(crate) fn surface(&self) -> Surface<'_> {
        Surface::new(self.cols, self.rows, 10.0, &self.height, self.sea)
    }

    pub(crate) fn len(&self) -> usize {
        self.height.len()
    }

    /// The neighbours of a cell, found without the code under test.
    pub(crate) fn around(&self, cell: usize) -> Vec<usize> {
        let (c, r) = ((cell % self.cols) as i64, (cell / self.cols) as i64);
        let inside = |&(x, y): &(i64, i64)| {
            (x, y) != (c, r) && (0..self.cols as i64).contains(&x) && (0..self.rows as i64).contains(&y)
        };
        let square = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (c + dx, r + dy)));
        square.filter(inside).map(|(x, y)| (y * self.cols as i64 + x) as usize).collect()
    }

    pub(crate) fn is_land(&self, cell: usize) -> bool {
        let height = self.height[cell];
        height.is_finite() && height > f32::MIN && self.sea.is_none_or(|sea| height > sea as f32)
    }

    /// Whether water leaves the surface at a cell at the latest.
    pub(crate) fn is_seed(&self, cell: usize) -> bool {
        !self.is_land(cell) || self.around(cell).len() < 8
    }

    /// The lowest surface over the ground such that each cell that is no seed has a neighbour that `above` makes no higher
    /// than it: by going over all cells until nothing changes.
    pub(crate) fn lowest(&self, above: impl Fn(f32) -> f32) -> Vec<f32> {
        let own = |cell: usize| if self.is_seed(cell) { self.height[cell] } else { f32::INFINITY };
        let mut filled: Vec<f32> = (0..self.len()).map(own).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for cell in (0..self.len()).filter(|&cell| !self.is_seed(cell)) {
                let from = |i: usize| if self.is_land(i) { filled[i] } else { self.solid(i) };
                let lowest =
                    self.around(cell).into_iter().map(|i| above(from(i))).fold(f32::INFINITY, f32::min);
                let height = self.height[cell].max(lowest);
                changed |= height < filled[cell];
                filled[cell] = height;
            }
        }
        filled
    }

    fn solid(&self, cell: usize) -> f32 {
        if self.height[cell].is_finite() { self.height[cell] } else { f32::MIN }
    }
}

/// Small surfaces with many ties, seas and places without data.
pub(crate) fn grounds() -> impl Strategy<Value = Ground> {
    let height = prop_oneof![
        12 => (0u8..7).prop_map(f32::from),
        6 => 0.0f32..7.0,
        1 => Just(f32::NAN),
        1 => Just(-0.0),
        1 => Just(100.0),
    ];
    let sea = prop_oneof![Just(None), Just(Some(-5.0)), Just(Some(0.0)), Just(Some(1.5)), Just(Some(1e9))];
    (1usize..14, 1usize..14, sea).prop_flat_map(move |(cols, rows, sea)| {
        prop::collection::vec(height.clone(), cols * rows).prop_map(move |height| Ground {
            cols,
            rows,
            height,
            sea,
        })
    })
}

/// The bits of numbers: NaN is equal to itself.
pub(crate) fn bits(numbers: &[f32]) -> Vec<u32> {
    numbers.iter().map(|x| (x + 0.0).to_bits()).collect()
}
