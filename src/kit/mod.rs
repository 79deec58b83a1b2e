//! Numerics that several nodes share.

pub mod color;
pub mod derivative;
pub mod distance;
pub mod hash;
pub mod math;
pub mod morphology;
pub mod ramp;
pub mod shifted;
