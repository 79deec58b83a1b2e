//! Cutting the beds of rivers into land, on any grid.
//!
//! A sample belongs to a bed if it stands at most the bed's half width from a river, and at least three quarters of a
//! cell, so that the samples of a bed hang together. It gets the *lowest* height that a river has within that distance:
//! along a river these heights fall as the river does, and where two rivers meet neither dams the other. A sample that
//! touches a bed and is none is lifted above all the bed samples around it, so that a river that stands above the land
//! does not leak. Banks rise from the bed evenly and cut what stands above them; in the outer half of their reach they
//! fade out.

use super::blocks::{Blocks, Course, Sight, near};
use super::line::WideLine;
use crate::kit::rows::Rows;
use crate::value::{Field, Grid, Quantity, fill};
use crate::work::{Cancelled, Work};

/// How beds are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carving {
    /// The cell that a bed must not be lost in, in metres: the coarser of those of the base grid and of the land.
    pub cell: f64,
    /// Rise of the banks, as a tangent.
    pub rise: f64,
    /// How far banks reach from the edge of the bed, in metres.
    pub reach: f64,
}

/// Land with beds.
#[derive(Clone, Debug)]
pub struct Carved {
    /// The land, in metres.
    pub height: Field,
    /// 1 in beds and 0 elsewhere.
    pub bed: Field,
}

/// Half the least width of a bed, in cells: below `√½` a diagonal of samples could slip through.
const LEAST: f64 = 0.75;
/// What a sample beside a bed stands above it at least, in cells.
const LIP: f64 = 1e-3;

/// What is found at a sample.
#[derive(Clone, Copy)]
struct Cut {
    /// The height of the bed; infinite where there is none.
    bed: f32,
    /// What the banks leave of the land.
    land: f32,
}

impl Carving {
    /// Half the width of the bed of a line, in metres.
    fn half(&self, wide: &WideLine) -> f64 {
        (0.5 * wide.width).max(LEAST * self.cell)
    }

    /// How far a line changes the land, in metres.
    fn whole(&self, wide: &WideLine) -> f64 {
        self.half(wide) + self.reach
    }

    /// Bytes of scratch memory that [`carve`](Self::carve) takes on a grid.
    pub fn bytes(&self, grid: &Grid, lines: &[WideLine]) -> u64 {
        let around = grid.grow_cells(1);
        size_of::<Cut>() as u64 * around.len() as u64 + Blocks::bytes(&around, lines, |wide| self.whole(wide))
    }

    /// Cuts lines into land on a grid. Beyond the field its border value continues.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn carve(
        &self,
        work: &Work<'_>,
        land: &Field,
        grid: &Grid,
        lines: &[WideLine],
    ) -> Result<Carved, Cancelled> {
        let around = grid.grow_cells(1);
        let cuts = self.cuts(&work.stage(0.0, 0.8), land, around, lines)?;
        let row = |j: usize| &cuts[j * around.cols..(j + 1) * around.cols];
        let lip = (LIP * self.cell) as f32;
        let height = fill(&work.stage(0.8, 0.9), *grid, land.quantity(), |at, out: &mut [f32]| {
            // The row itself is the second: the first stands north of the grid.
            let rows = [row(at.j), row(at.j + 1), row(at.j + 2)];
            for (i, o) in out.iter_mut().enumerate() {
                let here = rows[1][i + 1];
                let touching = rows.iter().flat_map(|r| &r[i..i + 3]).filter(|c| c.bed < f32::INFINITY);
                let highest = touching.fold(f32::NEG_INFINITY, |m, c| m.max(c.bed));
                *o = if here.bed < f32::INFINITY {
                    here.bed
                } else {
                    // A lip that is lost in the digits of the height is one step of them.
                    here.land.max((highest + lip).max(highest.next_up()))
                };
            }
        })?;
        let bed = fill(&work.stage(0.9, 1.0), *grid, Quantity::Mask, |at, out: &mut [f32]| {
            for (o, cut) in out.iter_mut().zip(&row(at.j + 1)[1..]) {
                *o = f32::from(u8::from(cut.bed < f32::INFINITY));
            }
        })?;
        Ok(Carved { height, bed })
    }

    fn cuts(
        &self,
        work: &Work<'_>,
        land: &Field,
        around: Grid,
        lines: &[WideLine],
    ) -> Result<Vec<Cut>, Cancelled> {
        let blocks = Blocks::new(work, around, lines, |wide| self.whole(wide))?;
        let (rows, xs) = (Rows::of(land, &around), around.xs());
        let mut cuts = vec![Cut { bed: f32::INFINITY, land: 0.0 }; around.len()];
        blocks.fill(work, &mut cuts, |part, lines, band| {
            let line = |j: usize| (j - part.rows.start) * around.cols;
            for j in part.rows.clone() {
                let land = rows.at(around.row + j as i64);
                let cuts = &mut band[line(j)..][part.cols.clone()];
                cuts.iter_mut().zip(&land[part.cols.clone()]).for_each(|(cut, &z)| cut.land = z);
            }
            for wide in lines {
                let Some(there) = near(&around, wide, self.whole(wide)) else { continue };
                let (there, cutter) = (there.and(part), Cutter::new(self, wide));
                for j in there.rows.clone() {
                    let land = rows.at(around.row + j as i64);
                    let y = around.y(j);
                    for i in there.cols.clone() {
                        cutter.cut([xs[i], y], land[i], &mut band[line(j) + i]);
                    }
                }
            }
        })?;
        Ok(cuts)
    }
}

/// What one line cuts.
struct Cutter {
    course: Course,
    low: f64,
    /// Rise of the river, upstream.
    slope: f64,
    half: f64,
    rise: f64,
    reach: f64,
}

impl Cutter {
    fn new(how: &Carving, wide: &WideLine) -> Self {
        let course = Course::new(wide);
        let [low, high] = wide.line.heights;
        let slope = if course.length > 0.0 { (high - low) / course.length } else { 0.0 };
        Self { course, low, slope, half: how.half(wide), rise: how.rise, reach: how.reach }
    }

    fn cut(&self, at: [f64; 2], land: f32, cut: &mut Cut) {
        let sight = self.course.sight(at);
        let beyond = sight.distance - self.half;
        if beyond <= 0.0 {
            cut.bed = cut.bed.min(self.bed(sight) as f32);
        }
        if beyond < self.reach {
            let nearest = self.low + self.slope * sight.along.clamp(0.0, self.course.length);
            let bank = nearest + self.rise * beyond.max(0.0);
            let excess = (f64::from(land) - bank).max(0.0);
            let faded = (f64::from(land) - fade(beyond.max(0.0) / self.reach) * excess) as f32;
            cut.land = cut.land.min(faded);
        }
    }

    /// The lowest height of the river within half a width of a place.
    fn bed(&self, sight: Sight) -> f64 {
        let chord = (self.half * self.half - sight.aside2).max(0.0).sqrt();
        // Rivers that run uphill are none of ours, and still have a lowest place.
        let down = if self.slope >= 0.0 { -chord } else { chord };
        self.low + self.slope * (sight.along + down).clamp(0.0, self.course.length)
    }
}

/// 1 up to a half, and smoothly to 0 at 1.
fn fade(share: f64) -> f64 {
    let t = (2.0 * share - 1.0).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}
