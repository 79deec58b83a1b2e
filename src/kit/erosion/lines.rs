//! The few rows of a quantity that a sweep over a grid has in hand.

/// Rows that are in hand at the same time, and one to spare.
const HELD: usize = 6;

/// Rows of one quantity: row `y` stands where row `y − 6` stood. Each has a sample before its first and one after its last,
/// which are 0 unless they are written.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    data: Vec<f32>,
    stride: usize,
}

impl Lines {
    pub(super) fn new(cols: usize) -> Self {
        let stride = cols + 2;
        Self { data: vec![0.0; stride * HELD], stride }
    }

    /// A row with the samples before and after it.
    #[inline(always)]
    pub(super) fn wide(&self, y: usize) -> &[f32] {
        &self.data[y % HELD * self.stride..][..self.stride]
    }

    /// A row to write, with the samples before and after it.
    #[inline(always)]
    pub(super) fn wide_mut(&mut self, y: usize) -> &mut [f32] {
        &mut self.data[y % HELD * self.stride..][..self.stride]
    }

    /// A row.
    #[inline(always)]
    pub(super) fn row(&self, y: usize) -> &[f32] {
        &self.wide(y)[1..self.stride - 1]
    }

    /// A row to write.
    #[inline(always)]
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [f32] {
        &mut self.data[y % HELD * self.stride + 1..][..self.stride - 2]
    }

    /// Copies a row to another.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        let start = from % HELD * self.stride;
        self.data.copy_within(start..start + self.stride, to % HELD * self.stride);
    }
}
