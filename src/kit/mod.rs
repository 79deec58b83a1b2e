//! Numerics that several nodes share.

pub mod hash;
pub mod spline;
