//! Numerics that several nodes share.

pub mod blur;
pub mod curve;
pub mod hash;
pub mod median;
pub mod noise;
pub mod rows;
pub mod sample;
pub mod simd;
pub mod stats;
