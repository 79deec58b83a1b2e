//! The creep of hillslopes: `D ∇²h`, implicit along rows and then along columns.

use crate::kit::erosion::ladder::Level;
use crate::work::{Cancelled, Work};

/// Spreads heights by diffusivity times time, in m². Between two points it is scaled by the smaller of their shares; points
/// whose share is 0 keep every bit.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub(super) fn creep(
    height: &mut Vec<f32>,
    level: &Level,
    share: &[f32],
    spread: f64,
    work: &Work<'_>,
) -> Result<(), Cancelled> {
    if spread <= 0.0 {
        return Ok(());
    }
    let (cols, rows) = (level.grid.cols, level.grid.rows);
    let rate = spread / level.cell_area();
    lines(height, share, cols, rate, &work.stage(0.0, 0.4))?;
    let mut turned = transposed(height, cols, rows);
    lines(&mut turned, &transposed(share, cols, rows), rows, rate, &work.stage(0.5, 0.9))?;
    *height = transposed(&turned, rows, cols);
    Ok(())
}

/// Solves `(1 + w + e) h − w h_west − e h_east = h_before` along each line of some points.
fn lines(
    values: &mut [f32],
    share: &[f32],
    cols: usize,
    rate: f64,
    work: &Work<'_>,
) -> Result<(), Cancelled> {
    work.rows(values, cols, (1 << 14) / cols.max(1) + 1, |j, line| {
        let share = &share[j * cols..][..cols];
        let between = |i: usize| rate * f64::from(share[i].min(share[i + 1]).clamp(0.0, 1.0));
        // Forward elimination; what is known of the point before: its right side and the factor of the next.
        let (mut right, mut factor) = (vec![0.0; cols], vec![0.0; cols]);
        for i in 0..cols {
            let west = if i > 0 { between(i - 1) } else { 0.0 };
            let east = if i + 1 < cols { between(i) } else { 0.0 };
            let (before, linked) = if i > 0 { (right[i - 1], factor[i - 1]) } else { (0.0, 0.0) };
            let diagonal = 1.0 + west + east - west * linked;
            right[i] = (f64::from(line[i]) + west * before) / diagonal;
            factor[i] = east / diagonal;
        }
        let mut next = 0.0;
        for i in (0..cols).rev() {
            next = right[i] + factor[i] * next;
            // A point without a share keeps its bits, those of a negative zero too.
            if share[i] > 0.0 {
                line[i] = next as f32;
            }
        }
    })
}

fn transposed(values: &[f32], cols: usize, rows: usize) -> Vec<f32> {
    let mut turned = vec![0.0; values.len()];
    for (j, line) in values.chunks_exact(cols.max(1)).enumerate() {
        line.iter().enumerate().for_each(|(i, &v)| turned[i * rows + j] = v);
    }
    turned
}
