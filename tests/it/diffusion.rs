//! Tests of the diffusion solver.
mod closed;
mod exact;
mod robust;
mod scenes;
