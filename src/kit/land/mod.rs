//! From a skeleton of rivers and ridges to land \[zhang2016, section 5\].
//!
//! [`Skeleton`] draws the lines on the samples of a grid. [`enrich`] fills samples beside them by midpoint displacement.
//! A membrane through both ([`crate::kit::diffusion`]) is the land. It drains on the grid that it was made on, and no
//! longer once it is interpolated, so [`carve`] cuts the beds into the land as it is at last, on any grid.
//! [`draw`] shows the lines.

mod bits;
mod blocks;
pub mod carve;
pub mod draw;
mod enrich;
mod line;
mod skeleton;

pub use self::bits::Bits;
pub use self::enrich::{Enriched, Enrichment, enrich};
pub use self::line::{Line, WideLine};
pub use self::skeleton::{Feature, Skeleton};
