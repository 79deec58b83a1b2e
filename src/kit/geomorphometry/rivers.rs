//! Figures of a network that is drawn and not found on a grid.

use serde::Serialize;

use super::{Network, Node};
use crate::value::{RiverVertex, Rivers};

/// How large a network of rivers is, and how it branches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RiverFigures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of vertices that drain to no other.
    pub outlets: usize,
    /// Length of all links, in metres.
    pub length: f64,
    /// Length of the longest way to an outlet, in metres.
    pub longest: f64,
    /// How it branches.
    pub network: Network,
}

impl RiverFigures {
    /// The figures of a network; none of one without a vertex.
    pub fn of(rivers: &Rivers) -> Option<Self> {
        let vertices = rivers.vertices();
        // A network stands downstream first, and streams are counted from upstream.
        let turned = |down: u32| (vertices.len() - 1) as u32 - down;
        let node = |(i, vertex): (usize, &RiverVertex)| Node {
            down: vertex.down.map(turned),
            length: vertex.down.map_or(0.0, |down| {
                let ([x, y], [u, v]) = (vertices[i].at, vertices[down as usize].at);
                libm::hypot(x - u, y - v)
            }),
            area: f64::from(vertex.area),
        };
        let nodes: Vec<Node> = vertices.iter().enumerate().rev().map(node).collect();
        let longest = vertices.iter().map(|vertex| vertex.length).fold(0.0, f32::max);
        Some(Self {
            vertices: nodes.len(),
            outlets: nodes.iter().filter(|node| node.down.is_none()).count(),
            length: nodes.iter().map(|node| node.length).sum(),
            longest: f64::from(longest),
            network: Network::of(&nodes)?,
        })
    }
}
