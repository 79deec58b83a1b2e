//! River networks: trees of vertices that drain to outlets.
//!
//! A vertex stands in the plane, x east and y south, and drains to at most one other, the vertex *downstream* of it. One
//! that drains to none is an *outlet*: an estuary, or a place where water leaves the land. The straight line from a
//! vertex to the one downstream is its *link*, so a link has the number of its upper vertex. Downstream stands first:
//! the number of the vertex downstream is smaller than a vertex's own. Loops over growing numbers therefore go
//! upstream, and loops over falling numbers collect what drains.
//!
//! Heights are those of the bed. They are what the maker says, so they may rise downstream (`river_profile` makes them
//! fall); Strahler order and length to the outlet are derived and always right.

mod build;
mod object;
mod tributaries;
pub mod written;

use std::sync::Arc;

pub use build::RiverFault;
pub(in crate::value) use object::least_order;
pub use tributaries::Tributaries;

/// Most vertices of a network.
pub const MAX_VERTICES: usize = 1 << 23;

/// A vertex of a river network, and its link to the vertex downstream.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RiverVertex {
    /// Its place, in metres, x east and y south; at most [`MAX_COORDINATE`](super::curves::MAX_COORDINATE) from zero.
    pub at: [f64; 2],
    /// Height of the bed, in metres; at most [`MAX_HEIGHT`](super::curves::MAX_HEIGHT) from zero.
    pub height: f64,
    /// The vertex downstream; none for an outlet.
    pub down: Option<u32>,
    /// Length of the way to the outlet, in metres; derived.
    pub length: f32,
    /// Area that drains through it, in square metres, its own land included.
    pub area: f32,
    /// Width of the river, in metres.
    pub width: f32,
    /// Strahler order, from 1 at a source; derived.
    pub order: u8,
}

// A million vertices are 48 MB.
const _: () = assert!(size_of::<RiverVertex>() == 48, "a vertex has no room to spare");

/// Vertices that a network is taken to have before it is there: as many as those of rich presets.
pub const GUESSED_VERTICES: usize = 100_000;

/// A river network; cheap to clone. It is valid, whoever made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivers(Arc<[RiverVertex]>);

impl Default for Rivers {
    fn default() -> Self {
        Self(Arc::new([]))
    }
}

impl Rivers {
    /// Its vertices, downstream first.
    pub fn vertices(&self) -> &[RiverVertex] {
        &self.0
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether it has no vertex.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The number of the vertex downstream of a vertex.
    pub fn down(&self, vertex: usize) -> Option<usize> {
        self.0[vertex].down.map(|down| down as usize)
    }

    /// The upper and the lower vertex of each link, in the order of the upper one.
    pub fn links(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.0.iter().enumerate().filter_map(|(i, vertex)| Some((i, vertex.down? as usize)))
    }

    /// The numbers of the outlets.
    pub fn outlets(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().filter(|(_, vertex)| vertex.down.is_none()).map(|(i, _)| i)
    }

    /// The vertices upstream of each vertex.
    pub fn tributaries(&self) -> Tributaries {
        Tributaries::of(&self.0)
    }
}
