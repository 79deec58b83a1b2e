//! The views of a terrain.

pub(crate) mod chart;
pub(crate) mod map;
pub(crate) mod relief;
