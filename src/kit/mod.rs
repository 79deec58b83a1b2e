//! Numerics that several nodes share.

pub mod blur;
pub mod curve;
pub mod hash;
pub mod spline;
pub mod median;
pub mod rows;
pub mod sample;
pub mod stats;
