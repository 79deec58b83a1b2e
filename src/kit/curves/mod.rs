//! Work on feature curves: short forms, transformation and the raster that diffusion starts from.

pub mod flatten;
pub mod raster;
pub mod transform;

pub use raster::{Options, rasterise};
pub use transform::{Mirror, Transform, merge};
