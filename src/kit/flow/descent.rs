//! The steepest way down from each cell to one of its eight neighbours.

use super::neighbor::NONE;
use super::surface::{Surface, solid};
use crate::kit::simd::{Kernel, Level};
use crate::work::{Cancelled, Work};

/// Rows that a task works on at a time: few enough to stop soon, enough to hide the scheduling.
pub(super) fn band(cols: usize) -> usize {
    (1 << 16) / cols.max(1) + 1
}

/// For each cell the direction of its steepest descent \[ocallaghan1984\], and none where no neighbour is lower or the
/// cell is no land. Of equal descents the first counts.
pub(super) fn steepest(surface: &Surface<'_>, work: &Work<'_>) -> Result<Vec<u8>, Cancelled> {
    let (cols, rows) = (surface.cells.cols, surface.cells.rows);
    let mut to = vec![NONE; surface.cells.len()];
    work.rows(&mut to, cols, band(cols), |j, out| {
        // What lies beyond the border is higher than everything.
        let padded = |row: Option<usize>| {
            let mut line = vec![f32::INFINITY; cols + 2];
            if let Some(row) = row.filter(|&row| row < rows) {
                line[1..=cols].iter_mut().zip(surface.row(row)).for_each(|(l, &h)| *l = solid(h));
            }
            line
        };
        let lines = [padded(j.checked_sub(1)), padded(Some(j)), padded(Some(j + 1))];
        Level::best().run(Row { lines: lines.each_ref().map(Vec::as_slice), sea: surface.sea(), out });
    })?;
    Ok(to)
}

/// A row of cells between its neighbours.
struct Row<'a> {
    /// The rows to the north, here and to the south, with a cell more on either side.
    lines: [&'a [f32]; 3],
    sea: f32,
    out: &'a mut [u8],
}

impl Kernel for Row<'_> {
    #[inline(always)]
    fn run(self) {
        const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let Row { lines, sea, out } = self;
        let n = out.len();
        let [north, here, south] = lines.map(|line| &line[..n + 2]);
        for (i, out) in out.iter_mut().enumerate() {
            let h = here[i + 1];
            let mut best = (0.0f32, u32::from(NONE));
            let mut look = |height: f32, length: f32, k: u32| {
                let descent = (h - height) * length;
                best = if descent > best.0 { (descent, k) } else { best };
            };
            look(north[i], DIAGONAL, 0);
            look(north[i + 1], 1.0, 1);
            look(north[i + 2], DIAGONAL, 2);
            look(here[i], 1.0, 3);
            look(here[i + 2], 1.0, 4);
            look(south[i], DIAGONAL, 5);
            look(south[i + 1], 1.0, 6);
            look(south[i + 2], DIAGONAL, 7);
            *out = if h > sea { best.1 as u8 } else { NONE };
        }
    }
}
