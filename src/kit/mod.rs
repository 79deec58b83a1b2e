//! Numerics that several nodes share.

pub mod blur;
pub mod color;
pub mod curve;
pub mod curves;
pub mod derivative;
pub mod diffusion;
pub mod distance;
pub mod far;
pub mod flow;
pub mod geomorphometry;
pub mod hash;
pub mod math;
pub mod median;
pub mod morphology;
pub mod noise;
pub mod paint;
pub mod ramp;
pub mod rows;
pub mod sample;
pub mod shifted;
pub mod simd;
pub mod spline;
pub mod stats;
