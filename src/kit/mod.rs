//! Numerics that several nodes share.

pub mod hash;
pub mod noise;
pub mod simd;
