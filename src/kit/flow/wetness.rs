//! How wet the ground is: by what drains through it, and by how high it lies over the nearest river.

use super::tree::Tree;
use crate::work::{Cancelled, Work};

/// The topographic wetness index `ln(a / tan β)` \[beven1979\], with the area `a` that drains through a metre of contour, in
/// m, and the slope `tan β`, which counts as `least` at the least.
#[inline]
pub fn index(area: f64, cell: f64, slope: f64, least: f64) -> f64 {
    let per_contour = (area / cell).max(f64::MIN_POSITIVE);
    libm::log(per_contour / slope.max(least))
}

/// Height of each cell over the river that it drains to along the tree, in metres \[nobre2011\]: 0 in rivers and at outlets,
/// and where a pit lies lower than its river.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn above_river(
    tree: &Tree,
    height: impl Fn(usize) -> f32,
    is_river: impl Fn(usize) -> bool,
    work: &Work<'_>,
) -> Result<Vec<f32>, Cancelled> {
    let rise = |cell: usize, down: f32| if is_river(cell) { height(cell) } else { down };
    let mut river = tree.upwards(&height, rise, work)?;
    river.iter_mut().enumerate().for_each(|(cell, river)| *river = (height(cell) - *river).max(0.0));
    Ok(river)
}
