//! Lines on a grid: how much of each sample they cover, and what colour they give it.

use super::blocks::{Blocks, Course, near};
use super::line::WideLine;
use crate::value::{Colors, Field, Grid, Quantity, Raster};
use crate::work::{Cancelled, Work};

/// How lines are drawn.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Colours by order, the first for order 1, red, green and blue from 0 to 1; the last stands for all above it.
    pub palette: Vec<[f32; 3]>,
    /// What the lines are drawn on, on any window of their lattice; white where there is nothing.
    pub under: Option<Colors>,
}

/// What was drawn.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The share of each sample's cell that lines cover, 0 to 1.
    pub mask: Field,
    /// The colours; a line of a higher order lies over one of a lower.
    pub colors: Colors,
}

/// A sample while lines are drawn: what lies under those of the present order, and how much these cover.
#[derive(Clone, Copy, Default)]
struct Wet {
    color: [f32; 3],
    mask: f32,
    order: u8,
    share: f32,
}

/// Metres around a line in which it covers anything.
fn whole(grid: &Grid, wide: &WideLine) -> f64 {
    0.5 * (wide.width + grid.cell())
}

impl Drawing {
    /// Bytes of scratch memory that [`draw`](Self::draw) takes on a grid.
    pub fn bytes(grid: &Grid, lines: &[WideLine]) -> u64 {
        let sorted = 2 * size_of_val(lines) as u64;
        size_of::<Wet>() as u64 * grid.len() as u64
            + sorted
            + Blocks::bytes(grid, lines, |wide| whole(grid, wide))
    }

    /// Draws lines on a grid, each as wide as it says.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn draw(&self, work: &Work<'_>, grid: &Grid, mut lines: Vec<WideLine>) -> Result<Drawn, Cancelled> {
        lines.sort_by_key(|wide| wide.order);
        let blocks = Blocks::new(work, *grid, &lines, |wide| whole(grid, wide))?;
        let xs = grid.xs();
        let mut wet = self.ground(grid);
        blocks.fill(work, &mut wet, |part, lines, band| {
            for wide in lines {
                let Some(there) = near(grid, wide, whole(grid, wide)) else { continue };
                let (there, course) = (there.and(part), Course::new(wide));
                for j in there.rows.clone() {
                    let line = &mut band[(j - part.rows.start) * grid.cols..][..grid.cols];
                    for i in there.cols.clone() {
                        let distance = course.sight([xs[i], grid.y(j)]).distance;
                        line[i].cover(self, wide.order, coverage(wide.width, distance, grid.cell()));
                    }
                }
            }
            for row in band.chunks_mut(grid.cols) {
                row[part.cols.clone()].iter_mut().for_each(|wet| wet.dry(self));
            }
        })?;
        let mask = wet.iter().map(|wet| wet.mask).collect();
        let colors = wet.iter().map(|wet| wet.color).collect();
        Ok(Drawn {
            mask: Field::new(*grid, Quantity::Mask, mask),
            colors: Raster::new(*grid, Quantity::Color, colors),
        })
    }

    fn ground(&self, grid: &Grid) -> Vec<Wet> {
        let on = |color: [f32; 3]| Wet { color, ..Wet::default() };
        match &self.under {
            Some(under) => under.crop(grid).data().iter().map(|color| on(*color)).collect(),
            None => vec![on([1.0; 3]); grid.len()],
        }
    }

    /// The colour of an order; black where the palette is empty.
    fn color(&self, order: u8) -> [f32; 3] {
        let last = self.palette.len().saturating_sub(1);
        self.palette.get(usize::from(order.max(1) - 1).min(last)).copied().unwrap_or_default()
    }
}

impl Wet {
    /// Covers a share of the sample with a line of an order. Lines come by rising order; of one order the largest share
    /// counts, so that lines do not show where they join.
    fn cover(&mut self, drawing: &Drawing, order: u8, share: f32) {
        if order != self.order {
            self.dry(drawing);
            self.order = order;
        }
        self.share = self.share.max(share);
    }

    /// Puts the lines of the present order down.
    fn dry(&mut self, drawing: &Drawing) {
        let (over, share) = (drawing.color(self.order), std::mem::take(&mut self.share));
        if share > 0.0 {
            self.color = std::array::from_fn(|c| self.color[c] + (over[c] - self.color[c]) * share);
            self.mask = (self.mask + (1.0 - self.mask) * share).min(1.0);
        }
    }
}

/// The share of a cell that a line of a width covers at a distance from its middle: a box of the cell's width across it.
fn coverage(width: f64, distance: f64, cell: f64) -> f32 {
    let (half, box_half) = (0.5 * width / cell, 0.5);
    let distance = distance / cell;
    let covered = (distance + box_half).min(half) - (distance - box_half).max(-half);
    covered.clamp(0.0, 1.0) as f32
}
