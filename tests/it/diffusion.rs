//! Tests of the diffusion solver.
mod closed;
mod exact;
mod plate;
mod robust;
mod scenes;
