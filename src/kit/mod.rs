//! Numerics that several nodes share.

pub mod color;
pub mod hash;
pub mod ramp;
