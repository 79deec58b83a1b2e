//! Two-dimensional arrays of the renderer's own, and their resampling.

use crate::node::Result;
use crate::work::Work;

/// What can be averaged.
pub(super) trait Blend: Copy + Default + Send + Sync {
    /// This much of it, added to a sum.
    fn add(self, weight: f32, sum: Self) -> Self;
}

impl Blend for f32 {
    fn add(self, weight: f32, sum: Self) -> Self {
        sum + weight * self
    }
}

impl Blend for [f32; 3] {
    fn add(self, weight: f32, sum: Self) -> Self {
        [sum[0] + weight * self[0], sum[1] + weight * self[1], sum[2] + weight * self[2]]
    }
}

/// Rows of values.
#[derive(Clone, Debug)]
pub(super) struct Plane<T> {
    pub(super) cols: usize,
    pub(super) rows: usize,
    pub(super) data: Vec<T>,
}

impl<T: Blend> Plane<T> {
    /// Fills a plane row by row, in parallel.
    pub(super) fn fill(
        work: &Work<'_>,
        [cols, rows]: [usize; 2],
        f: impl Fn(usize, &mut [T]) + Sync,
    ) -> Result<Self> {
        let mut data = vec![T::default(); cols * rows];
        work.rows(&mut data, cols, 1, f)?;
        Ok(Self { cols, rows, data })
    }

    pub(super) fn row(&self, j: usize) -> &[T] {
        &self.data[j * self.cols..][..self.cols]
    }

    /// The value between samples, in steps from the first; the border continues.
    pub(super) fn at(&self, x: f64, y: f64) -> T {
        let (i, u) = place(x, self.cols);
        let (j, v) = place(y, self.rows);
        let right = (i + 1).min(self.cols - 1);
        let (top, bottom) = (self.row(j), self.row((j + 1).min(self.rows - 1)));
        let sum = top[i].add((1.0 - u) * (1.0 - v), T::default());
        let sum = top[right].add(u * (1.0 - v), sum);
        bottom[right].add(u * v, bottom[i].add((1.0 - u) * v, sum))
    }

    /// Rows for columns.
    pub(super) fn transposed(&self, work: &Work<'_>) -> Result<Self> {
        const BLOCK: usize = 16;
        let mut data = vec![T::default(); self.data.len()];
        // Sixteen columns at a time, so that each cache line that is read serves sixteen rows.
        work.rows(&mut data, self.rows * BLOCK, 1, |block, out| {
            for j in 0..self.rows {
                let row = self.row(j);
                for (k, line) in out.chunks_mut(self.rows).enumerate() {
                    line[j] = row[block * BLOCK + k];
                }
            }
        })?;
        Ok(Self { cols: self.rows, rows: self.cols, data })
    }
}

/// The sample before a position and the share of the way to the next; the border continues.
fn place(x: f64, count: usize) -> (usize, f32) {
    let x = x.clamp(0.0, (count - 1) as f64);
    let i = (x as usize).min(count.saturating_sub(2));
    (i, (x - i as f64) as f32)
}

/// Samples and weights that make one sample of another length of the same line: the share that each covers where
/// there are fewer, a Catmull-Rom spline where there are more.
fn taps(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let scale = from as f64 / to as f64;
    let covered = |i: usize| {
        let (start, end) = (i as f64 * scale, (i + 1) as f64 * scale);
        let last = (end.ceil() as usize).clamp(start as usize + 1, from);
        (start as usize..last)
            .map(|k| (k, (end.min((k + 1) as f64) - start.max(k as f64)) / scale))
            .filter(|tap| tap.1 > 1e-9)
            .map(|(k, w)| (k, w as f32))
            .collect()
    };
    let spline = |i: usize| {
        let x = (i as f64 + 0.5) * scale - 0.5;
        let (k, u) = (x.floor() as i64, x - x.floor());
        let weights = [
            u * (u * (2.0 - u) - 1.0),
            u * u * (3.0 * u - 5.0) + 2.0,
            u * (u * (4.0 - 3.0 * u) + 1.0),
            u * u * (u - 1.0),
        ];
        let tap = |(n, w): (i64, f64)| ((k - 1 + n).clamp(0, from as i64 - 1) as usize, (w * 0.5) as f32);
        (0..).zip(weights).map(tap).collect()
    };
    (0..to).map(|i| if scale >= 1.0 { covered(i) } else { spline(i) }).collect()
}

/// The same picture with another number of columns and rows.
pub(super) fn resampled<T: Blend>(
    work: &Work<'_>,
    data: &[T],
    [cols, rows]: [usize; 2],
    to: [usize; 2],
) -> Result<Plane<T>> {
    if [cols, rows] == to {
        return Ok(Plane { cols, rows, data: data.to_vec() });
    }
    let (across, down) = (taps(cols, to[0]), taps(rows, to[1]));
    Plane::fill(work, to, |j, out| {
        let mut line = vec![T::default(); cols];
        for &(k, weight) in &down[j] {
            for (sum, &x) in line.iter_mut().zip(&data[k * cols..][..cols]) {
                *sum = x.add(weight, *sum);
            }
        }
        for (out, taps) in out.iter_mut().zip(&across) {
            *out = taps.iter().fold(T::default(), |sum, &(k, weight)| line[k].add(weight, sum));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Cancel;

    #[test]
    fn averages_are_exact_and_splines_keep_planes() {
        let cancel = Cancel::default();
        let work = Work::new(&cancel);
        let ramp: Vec<f32> = (0..35).map(|i| (i % 7) as f32 + 10.0 * (i / 7) as f32).collect();
        let whole = resampled(&work, &ramp, [7, 5], [1, 1]).unwrap();
        assert!((whole.data[0] - 23.0).abs() < 1e-4, "{whole:?}");
        // 7 columns to 2: the middle column is shared half and half.
        let halves = resampled(&work, &ramp, [7, 5], [2, 1]).unwrap();
        assert!((halves.data[0] - (0.0 + 1.0 + 2.0 + 1.5) / 3.5 - 20.0).abs() < 1e-4, "{halves:?}");
        let fine = resampled(&work, &ramp, [7, 5], [70, 50]).unwrap();
        for (i, j) in [(20, 20), (35, 25), (44, 29)] {
            let want = (i as f32 + 0.5) / 10.0 - 0.5 + 10.0 * ((j as f32 + 0.5) / 10.0 - 0.5);
            assert!((fine.row(j)[i] - want).abs() < 1e-4);
        }
    }

    #[test]
    fn transposing_turns_rows_into_columns() {
        let cancel = Cancel::default();
        let plane = Plane { cols: 37, rows: 5, data: (0..185).map(|i| i as f32).collect() };
        let turned = plane.transposed(&Work::new(&cancel)).unwrap();
        assert!((0..37).all(|i| (0..5).all(|j| turned.row(i)[j] == plane.row(j)[i])));
    }
}
