//! Cutting through what holds water back.

use super::accumulate::downwards;
use super::depressions::Depressions;
use super::surface::Surface;
use crate::work::{Cancelled, Work};

/// Fall of a cut and of the bottom of what is filled, in metres per metre: a centimetre over a kilometre.
const FALL: f64 = 1e-5;

/// A surface on which every cell but the outlets has a lower neighbour, made by cutting channels through the lowest passes
/// along the bottoms of the valleys \[lindsay2016\]. No cut is deeper than `deepest` metres, where that is given: what lies
/// deeper is filled first, up to so much below its level, so that 0 fills everything.
///
/// Heights that drain stay as they are, to the bit. Nothing is cut down to the sea.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn cut(surface: &Surface<'_>, deepest: Option<f64>, work: &Work<'_>) -> Result<Vec<f32>, Cancelled> {
    let depressions = Depressions::find(surface, &work.stage(0.0, 0.4))?;
    let height = match deepest {
        Some(depth) => depressions.filled_below(surface, depth as f32, &work.stage(0.4, 0.5))?,
        None => surface.raw().to_vec(),
    };
    let tree = depressions.into_tree(surface, work)?;
    let shore = surface.sea().next_up();
    let lower = |cell: usize, height: f32, down: &mut f32| {
        // Of the sea and what is no number nothing is cut.
        if *down >= height {
            let fallen = (f64::from(height) - FALL * tree.length(cell)) as f32;
            *down = fallen.min(height.next_down()).max(shore);
        }
    };
    downwards(&tree, height, lower, &work.stage(0.5, 1.0))
}
