//! What is looked at: the terrain from above and in space.

pub(crate) mod chart;
pub(crate) mod map;
pub(crate) mod relief;
mod space;
pub(crate) mod wipe;
