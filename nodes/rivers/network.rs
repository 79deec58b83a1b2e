//! What kinds that make river networks share.

use crate::kit::flow::join::{Polyline, join};
use crate::kit::flow::network::lower;
use crate::kit::rivers::drainage;
use crate::node::{Context, Cost, Error, Load, Result};
use crate::units::Metres;
use crate::value::{GUESSED_VERTICES, RiverFault, RiverVertex, Rivers};

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

/// Vertices of the network at an input.
pub fn vertices(load: &Load<'_>) -> f64 {
    load.object::<Rivers>("rivers").map_or(GUESSED_VERTICES as f64, |rivers| rivers.len() as f64)
}

/// The cost of work on so many vertices.
pub fn cost(vertices: f64, bytes: f64, microseconds: f64) -> Cost {
    // A floor for what does not grow with the network.
    Cost { bytes: (1 << 20) + (vertices * bytes) as u64, seconds: 1e-4 + vertices * microseconds * 1e-6 }
}

/// A network of lines from source to mouth, whose ends join others within `snap`: its beds fall all the way, it drains the
/// terrain, and a river that drains a square kilometre is `width` wide.
///
/// # Errors
/// Says as `fault` how the lines are no network; or the work was asked to stop.
pub fn of_lines(
    cx: &Context<'_>,
    lines: &[Polyline],
    [snap, width]: [Metres; 2],
    fault: impl Fn(String) -> Error,
) -> Result<Rivers> {
    let joined = join(lines, snap.0, &cx.work.stage(0.0, 0.4))?;
    let vertex = |&([x, y, height], down): &([f64; 3], Option<u32>)| RiverVertex {
        at: [x, y],
        height,
        down,
        ..RiverVertex::default()
    };
    let vertices: Vec<RiverVertex> = joined.iter().map(vertex).collect();
    let (sorted, _) = Rivers::sorted(&vertices).map_err(|e| fault(e.to_string()))?;
    let mut vertices = changed(&sorted);
    lower(&mut vertices);
    drainage::drain(&mut vertices, cx.terrain()?.bounds(), width.0, &cx.work.stage(0.4, 1.0))?;
    Rivers::new(vertices).map_err(|e| fault(e.to_string()))
}
