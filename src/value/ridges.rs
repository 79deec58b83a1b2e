//! Ridges: the lines between the land that drains to one river and that which drains to another.

use std::sync::Arc;

use rayon::prelude::*;
use serde_json::Value as Json;

use super::curves::{MAX_COORDINATE, MAX_HEIGHT};
use super::rivers::{GUESSED_VERTICES, least_order};
use super::{Feature, Features, Object, ObjectType, Pin, Sketch, SketchPoint, Value};

/// Most vertices, and most edges, of ridges.
pub const MAX_RIDGES: usize = 1 << 25;
/// Most edges of a sketch. Of more, the larger divides are shown.
const MAX_SKETCH: usize = 50_000;
/// Bytes of a vertex in a file of the cache: x, y and height.
const VERTEX_RECORD: usize = 24;
/// Bytes of an edge in a file of the cache: its ends, the rivers beside it, its order.
const EDGE_RECORD: usize = 17;

/// A place where ridges start, end or meet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RidgeVertex {
    /// Its place, in metres, x east and y south.
    pub at: [f64; 2],
    /// Its height, in metres.
    pub height: f64,
}

/// A straight piece of a ridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RidgeEdge {
    /// The numbers of its ends among the vertices of the ridges.
    pub ends: [u32; 2],
    /// The river vertices whose land it parts. The link of a vertex is the one from it downstream.
    pub rivers: [u32; 2],
    /// The lower of the Strahler orders that the two rivers have where they meet, or at their outlets if they do not: 1
    /// between two sources, high on a main divide.
    pub order: u8,
}

/// Ridges between rivers; cheap to clone. They are valid, whoever made them.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridges {
    vertices: Arc<[RidgeVertex]>,
    edges: Arc<[RidgeEdge]>,
}

impl Default for Ridges {
    fn default() -> Self {
        Self { vertices: Arc::new([]), edges: Arc::new([]) }
    }
}

/// Why vertices and edges are no ridges.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RidgeFault {
    /// There are more than this program takes.
    #[error("at most {MAX_RIDGES} ridge {what}, got {found}")]
    TooMany {
        /// Vertices or edges.
        what: &'static str,
        /// How many.
        found: usize,
    },
    /// A number of a vertex is not finite or too large.
    #[error("ridge vertex {vertex}: `{what}` must be from -{most} to {most}, got {found}")]
    Number {
        /// The vertex.
        vertex: usize,
        /// Which of its numbers.
        what: &'static str,
        /// Its largest size.
        most: f64,
        /// What it is.
        found: f64,
    },
    /// An edge ends at a vertex that is not there.
    #[error("ridge edge {edge} ends at vertex {end}, of {count}")]
    Missing {
        /// The edge.
        edge: usize,
        /// The vertex.
        end: u32,
        /// Number of vertices.
        count: usize,
    },
}

impl Ridges {
    /// Ridges of vertices and the edges between them.
    ///
    /// # Errors
    /// Names the first vertex with a number that is not finite or too large, or the first edge that ends nowhere; and
    /// refuses more than [`MAX_RIDGES`] of either.
    pub fn new(vertices: Vec<RidgeVertex>, edges: Vec<RidgeEdge>) -> Result<Self, RidgeFault> {
        for (what, found) in [("vertices", vertices.len()), ("edges", edges.len())] {
            if found > MAX_RIDGES {
                return Err(RidgeFault::TooMany { what, found });
            }
        }
        for (vertex, of) in vertices.iter().enumerate() {
            let numbers = [
                ("x", of.at[0], MAX_COORDINATE),
                ("y", of.at[1], MAX_COORDINATE),
                ("height", of.height, MAX_HEIGHT),
            ];
            // Not a number is in no range.
            let bad = numbers.into_iter().find(|(_, x, most)| !(-most..=*most).contains(x));
            if let Some((what, found, most)) = bad {
                return Err(RidgeFault::Number { vertex, what, most, found });
            }
        }
        let count = vertices.len();
        let missing = |edge: &RidgeEdge| edge.ends.into_iter().find(|&end| end as usize >= count);
        if let Some((edge, end)) = edges.iter().enumerate().find_map(|(i, edge)| Some((i, missing(edge)?))) {
            return Err(RidgeFault::Missing { edge, end, count });
        }
        Ok(Self { vertices: vertices.into(), edges: edges.into() })
    }

    /// Places and heights.
    pub fn vertices(&self) -> &[RidgeVertex] {
        &self.vertices
    }

    /// The straight pieces.
    pub fn edges(&self) -> &[RidgeEdge] {
        &self.edges
    }

    /// The ends of an edge.
    pub fn ends(&self, edge: &RidgeEdge) -> [RidgeVertex; 2] {
        edge.ends.map(|end| self.vertices[end as usize])
    }

    /// Whether there is no edge.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }
}

impl Object for Ridges {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "ridges",
        color: [213, 94, 0],
        pin: Pin::Polygon { corners: 3, turn: 0.0 },
        sample_bytes: 0,
        // A Voronoi diagram has two vertices and three edges for a site.
        guessed_bytes: (GUESSED_VERTICES * (2 * size_of::<RidgeVertex>() + 3 * size_of::<RidgeEdge>()))
            as u64,
        load: Some(load),
        has_features: true,
    };

    fn bytes(&self) -> u64 {
        (size_of_val(self.vertices()) + size_of_val(self.edges())) as u64
    }

    /// Ridges are valid, whoever made them.
    fn fault(&self) -> Option<String> {
        None
    }

    fn sketch(&self) -> Sketch {
        let least = least_order(self.edges().iter().map(|edge| edge.order), MAX_SKETCH);
        let large = || self.edges().iter().filter(move |edge| edge.order >= least);
        let stride = large().count().div_ceil(MAX_SKETCH).max(1);
        let point = |of: RidgeVertex| -> SketchPoint { (of.at, Some(of.height)) };
        Sketch::Lines(large().step_by(stride).map(|edge| self.ends(edge).map(point).to_vec()).collect())
    }

    fn say(&self, at: [f64; 2]) -> Option<String> {
        let distance = |edge: &RidgeEdge| {
            let [a, b] = self.ends(edge).map(|end| end.at);
            let [x, y] = [0, 1].map(|i| (a[i] + b[i]) / 2.0 - at[i]);
            x * x + y * y
        };
        let all = self.edges.par_iter().enumerate().map(|(i, edge)| (distance(edge), i));
        let (_, i) = all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        let edge = &self.edges[i];
        let [from, to] = self.ends(edge).map(|end| end.height);
        Some(format!("nearest ridge: order {}, {:.1} m high", edge.order, (from + to) / 2.0))
    }

    fn save(&self) -> Vec<u8> {
        let mut bytes =
            Vec::with_capacity(8 + VERTEX_RECORD * self.vertices.len() + EDGE_RECORD * self.edges.len());
        bytes.extend((self.vertices.len() as u64).to_le_bytes());
        for vertex in self.vertices() {
            let numbers = [vertex.at[0], vertex.at[1], vertex.height];
            bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        }
        for edge in self.edges() {
            let ([a, b], [c, d]) = (edge.ends, edge.rivers);
            bytes.extend([a, b, c, d].into_iter().flat_map(u32::to_le_bytes));
            bytes.push(edge.order);
        }
        bytes
    }

    /// A line for each edge, with its order and the river vertices whose land it parts.
    fn features(&self) -> Features<'_> {
        let point = |of: RidgeVertex| -> SketchPoint { (of.at, Some(of.height)) };
        Box::new(self.edges().iter().map(move |edge| {
            let properties =
                [("order", Json::from(edge.order)), ("rivers", Json::from(edge.rivers.to_vec()))];
            Feature {
                line: self.ends(edge).map(point).to_vec(),
                weight: edge.order.into(),
                properties: properties.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
            }
        }))
    }
}

fn load(bytes: &[u8]) -> Option<Value> {
    let (count, rest) = bytes.split_first_chunk()?;
    let count = usize::try_from(u64::from_le_bytes(*count)).ok()?;
    let (vertices, edges) = rest.split_at_checked(count.checked_mul(VERTEX_RECORD)?)?;
    let (edges, rest) = edges.as_chunks::<EDGE_RECORD>();
    if !rest.is_empty() {
        return None;
    }
    let vertex = |record: &[u8; VERTEX_RECORD]| {
        let number = |i: usize| f64::from_le_bytes(record.as_chunks::<8>().0[i]);
        RidgeVertex { at: [number(0), number(1)], height: number(2) }
    };
    let edge = |record: &[u8; EDGE_RECORD]| {
        let number = |i: usize| u32::from_le_bytes(record.as_chunks::<4>().0[i]);
        let [ends, rivers] = [[number(0), number(1)], [number(2), number(3)]];
        RidgeEdge { ends, rivers, order: record[EDGE_RECORD - 1] }
    };
    let vertices = vertices.as_chunks::<VERTEX_RECORD>().0.iter().map(vertex).collect();
    Some(Ridges::new(vertices, edges.iter().map(edge).collect()).ok()?.into())
}
