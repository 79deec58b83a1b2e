//! What kinds that make river networks share.

use crate::node::{Cost, Error, Load, Result};
use crate::value::{RiverFault, RiverVertex, Rivers};

/// Most links that a kind makes.
pub const MAX_LINKS: f64 = 4.0e6;

/// A network of vertices that stand downstream first, as the output of a kind.
///
/// # Errors
/// When they are none: a bug of the kind, or heights out of range.
pub fn made(vertices: Vec<RiverVertex>) -> Result<Rivers> {
    Rivers::new(vertices).map_err(of_fault)
}

/// What is wrong with a network, as a fault of the kind that made it.
pub fn of_fault(fault: RiverFault) -> Error {
    Error::Output { port: "rivers".into(), message: format!("has a fault: {fault}") }
}

/// The network that a kind reads, as vertices to change.
pub fn changed(rivers: &Rivers) -> Vec<RiverVertex> {
    rivers.vertices().to_vec()
}

/// Vertices of the network at an input, where it is known.
pub fn vertices(load: &Load<'_>) -> f64 {
    load.object::<Rivers>("rivers").map_or(0.0, |rivers| rivers.len() as f64)
}

/// The cost of work on so many vertices.
pub fn cost(vertices: f64, bytes: f64, microseconds: f64) -> Cost {
    // A floor for what does not grow with the network.
    Cost { bytes: (1 << 20) + (vertices * bytes) as u64, seconds: 1e-4 + vertices * microseconds * 1e-6 }
}
