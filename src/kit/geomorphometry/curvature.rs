//! Whether ridges or valleys are the sharper.

use rayon::prelude::*;
use serde::Serialize;

use super::Land;
use super::sums::{Moments, percentiles};
use crate::work::{Cancelled, Work};

/// Standard deviations, in cells, of the Gaussians that heights are smoothed with.
const SIGMAS: [usize; 3] = [1, 2, 4];
/// Where a Gaussian is cut, in standard deviations.
const CUT: usize = 4;
/// Cells between a border or a void and the first cell that counts, as steps along the axes.
const MARGIN: usize = 6;

/// How the Laplacian of smoothed heights is spread.
///
/// It is above 0 in valleys and below 0 on ridges, so its skewness tells which of both are sharper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Curvature {
    /// Standard deviation of the Gaussian, in cells.
    pub sigma: usize,
    /// Skewness: above 0 where valleys are sharper than ridges, below 0 where ridges are.
    pub skewness: f64,
    /// The same in a way that single cells do not decide: `(p99 + p1 − 2 p50) / (p99 − p1)` of the percentiles.
    pub asymmetry: f64,
}

/// The figures at each scale; none of land that is nowhere 13 cells wide.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub(super) fn measure(land: &Land, work: &Work<'_>) -> Result<Vec<Curvature>, Cancelled> {
    let core = core(land);
    work.check()?;
    let closed = closed(land, CUT * SIGMAS[SIGMAS.len() - 1]);
    let mut all = Vec::new();
    for (k, sigma) in SIGMAS.into_iter().enumerate() {
        let stage = work.stage(k as f32 / SIGMAS.len() as f32, (k + 1) as f32 / SIGMAS.len() as f32);
        all.extend(Curvature::of(land, &closed, &core, sigma, &stage)?);
    }
    Ok(all)
}

impl Curvature {
    fn of(
        land: &Land,
        closed: &[f32],
        core: &[bool],
        sigma: usize,
        work: &Work<'_>,
    ) -> Result<Option<Self>, Cancelled> {
        let kernel = Kernel::new(sigma);
        let cols = land.cols();
        let mut laplacian = vec![0.0f32; closed.len()];
        work.rows(&mut laplacian, cols, 8, |j, out| kernel.laplacian(closed, [cols, land.rows()], j, out))?;
        let mut values: Vec<f32> =
            laplacian.into_iter().zip(core).filter_map(|(value, core)| core.then_some(value)).collect();
        work.check()?;
        let Some(Moments { skewness, .. }) = Moments::of(&values) else { return Ok(None) };
        let Some([p1, p50, p99]) = percentiles(&mut values, [0.01, 0.5, 0.99]) else { return Ok(None) };
        let asymmetry = if p99 > p1 { (p99 + p1 - 2.0 * p50) / (p99 - p1) } else { 0.0 };
        Ok(Some(Self { sigma, skewness, asymmetry }))
    }
}

/// A Gaussian and its second derivative along an axis, from the middle outwards.
struct Kernel {
    smooth: Vec<f64>,
    second: Vec<f64>,
}

impl Kernel {
    fn new(sigma: usize) -> Self {
        let variance = (sigma * sigma) as f64;
        let bell = |x: usize| libm::exp(-0.5 * (x * x) as f64 / variance);
        let reach = CUT * sigma;
        let mass = 2.0 * (1..=reach).map(bell).sum::<f64>() + 1.0;
        let smooth: Vec<f64> = (0..=reach).map(|x| bell(x) / mass).collect();
        let curved = |(x, w): (usize, &f64)| w * ((x * x) as f64 / variance - 1.0) / variance;
        let second = smooth.iter().enumerate().map(curved).collect();
        Self { smooth, second }
    }

    /// The Laplacian along one row: each axis derived twice, the other smoothed.
    fn laplacian(&self, heights: &[f32], [cols, rows]: [usize; 2], j: usize, out: &mut [f32]) {
        let reach = self.smooth.len() - 1;
        let (mut smooth, mut second) = (vec![0.0; cols + 2 * reach], vec![0.0; cols + 2 * reach]);
        for (d, (w0, w2)) in self.smooth.iter().zip(&self.second).enumerate() {
            let line = |row: i64| &heights[mirrored(row, rows) * cols..][..cols];
            let (above, below) = (line(j as i64 - d as i64), line(j as i64 + d as i64));
            // The row itself is there once.
            let share = if d == 0 { 0.5 } else { 1.0 };
            let both = above.iter().zip(below).map(|(a, b)| share * (f64::from(*a) + f64::from(*b)));
            for (sum, (s, t)) in both.zip(smooth[reach..].iter_mut().zip(&mut second[reach..])) {
                *s += w0 * sum;
                *t += w2 * sum;
            }
        }
        for k in 0..reach {
            let (left, right) = (mirrored(k as i64 - reach as i64, cols), mirrored((cols + k) as i64, cols));
            for line in [&mut smooth, &mut second] {
                line[k] = line[reach + left];
                line[reach + cols + k] = line[reach + right];
            }
        }
        for (i, value) in out.iter_mut().enumerate() {
            let at = reach + i;
            let mut sum = self.smooth[0] * second[at] + self.second[0] * smooth[at];
            for d in 1..=reach {
                sum += self.smooth[d] * (second[at - d] + second[at + d]);
                sum += self.second[d] * (smooth[at - d] + smooth[at + d]);
            }
            *value = sum as f32;
        }
    }
}

/// The index that stands for one beyond the border: the border is a mirror between two samples.
fn mirrored(k: i64, n: usize) -> usize {
    let n = n as i64;
    let k = k.rem_euclid(2 * n);
    (if k < n { k } else { 2 * n - 1 - k }) as usize
}

/// Whether each cell is land with no border and no void within the margin, counted in steps along the axes.
fn core(land: &Land) -> Vec<bool> {
    let cols = land.cols();
    let mut inside: Vec<bool> = land.heights().iter().map(|z| z.is_finite()).collect();
    for _ in 0..MARGIN {
        let before = inside.clone();
        let stays = |i: usize, j: usize| {
            let at = j * cols + i;
            let has_neighbours = i > 0 && j > 0 && i + 1 < cols && j + 1 < land.rows();
            before[at] && has_neighbours && [at - 1, at + 1, at - cols, at + cols].iter().all(|k| before[*k])
        };
        inside.par_chunks_mut(cols.max(1)).enumerate().for_each(|(j, row)| {
            row.iter_mut().enumerate().for_each(|(i, cell)| *cell = stays(i, j));
        });
    }
    inside
}

/// The heights, with the voids within `reach` cells of land closed by the nearest height; other voids are 0.
///
/// Land grows into the voids by a ring of cells at a time. A cell takes the height of a neighbour of the ring before,
/// of one along an axis where there is one.
fn closed(land: &Land, reach: usize) -> Vec<f32> {
    const AROUND: [[i64; 2]; 8] = [[1, 0], [0, -1], [-1, 0], [0, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]];
    let (cols, rows) = (land.cols() as i64, land.rows() as i64);
    let mut heights = land.heights().to_vec();
    let neighbours = |at: usize| {
        let (i, j) = (at as i64 % cols, at as i64 / cols);
        let inside = move |[x, y]: &[i64; 2]| (0..cols).contains(x) && (0..rows).contains(y);
        AROUND
            .map(|[x, y]| [i + x, j + y])
            .into_iter()
            .filter(inside)
            .map(move |[x, y]| (y * cols + x) as usize)
    };
    let mut ring: Vec<usize> = (0..heights.len()).filter(|at| heights[*at].is_nan()).collect();
    for _ in 0..reach {
        let near = |at: &usize| {
            let found = neighbours(*at).map(|k| heights[k]).find(|z| z.is_finite());
            found.map(|z| (*at, z))
        };
        let found: Vec<(usize, f32)> = ring.par_iter().filter_map(near).collect();
        if found.is_empty() {
            break;
        }
        found.iter().for_each(|(at, z)| heights[*at] = *z);
        ring.retain(|at| heights[*at].is_nan());
    }
    ring.into_iter().for_each(|at| heights[at] = 0.0);
    heights
}
