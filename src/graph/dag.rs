//! Nodes and wires in a graph of petgraph, under ids that are counted and never reused.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::{Index, IndexMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use petgraph::Direction::{self, Incoming, Outgoing};
use petgraph::stable_graph::{EdgeIndex, NodeIndex, StableDiGraph};
use petgraph::visit::EdgeRef as _;

use super::parts::GraphNode;
use super::wires::{Source, Wire};
use crate::name::Name;

/// The id of a node. Copies of a graph, such as those in a history, have the same ids. Apart from that, no two nodes of
/// a process share an id, so that a stored id finds its own node or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(u64);

impl NodeId {
    fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Values by node. Ids are counted by the program itself and never chosen by a file, so that one multiplication spreads
/// them well enough; the hash of the standard library took a tenth of the time of a plan.
pub(crate) type NodeMap<T> = HashMap<NodeId, T, BuildHasherDefault<Spread>>;

/// The hash of a counted number.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spread(u64);

impl Hasher for Spread {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u64(&mut self, number: u64) {
        // 2^64 divided by the golden ratio.
        self.0 = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

/// The nodes, and the wires as edges from source to reader.
#[derive(Clone, Debug, Default)]
pub(super) struct Dag {
    /// Nodes are shared with copies of the graph until they are changed.
    graph: StableDiGraph<(NodeId, Arc<GraphNode>), Wire>,
    /// The index of each node in petgraph, which reuses indices after a removal.
    places: NodeMap<NodeIndex>,
}

impl Dag {
    pub(super) fn add(&mut self, node: GraphNode) -> NodeId {
        let id = NodeId::fresh();
        self.places.insert(id, self.graph.add_node((id, Arc::new(node))));
        id
    }

    /// Removes a node with its wires.
    pub(super) fn remove(&mut self, id: NodeId) -> Option<GraphNode> {
        let place = self.places.remove(&id)?;
        self.graph.remove_node(place).map(|(_, node)| Arc::unwrap_or_clone(node))
    }

    pub(super) fn get(&self, id: NodeId) -> Option<&Arc<GraphNode>> {
        self.graph.node_weight(self.place(id)?).map(|(_, node)| node)
    }

    fn place(&self, id: NodeId) -> Option<NodeIndex> {
        self.places.get(&id).copied()
    }

    /// The nodes that a node reads (`Incoming`) or that read it (`Outgoing`), one for each wire.
    pub(super) fn neighbors(&self, id: NodeId, direction: Direction) -> impl Iterator<Item = NodeId> + '_ {
        let place = self.place(id).into_iter();
        place.flat_map(move |place| self.graph.neighbors_directed(place, direction)).map(|n| self.graph[n].0)
    }

    /// The wires out of a node, each with the node that it leads to.
    pub(super) fn wires_from(&self, id: NodeId) -> impl Iterator<Item = (NodeId, &Wire)> + '_ {
        let edges = self.place(id).into_iter().flat_map(|place| self.graph.edges_directed(place, Outgoing));
        edges.map(|e| (self.graph[e.target()].0, e.weight()))
    }

    /// The source of the wire into an input.
    pub(super) fn source(&self, id: NodeId, port: &str) -> Option<Source> {
        let edge = self.edge_into(id, port)?;
        let (from, _) = self.graph.edge_endpoints(edge)?;
        Some(Source { node: self.graph[from].0, port: self.graph[edge].from.clone() })
    }

    /// Adds a wire beside the existing ones; does nothing where a node is missing.
    pub(super) fn connect(&mut self, source: Source, id: NodeId, port: Name) {
        if let Some((from, to)) = self.place(source.node).zip(self.place(id)) {
            self.graph.add_edge(from, to, Wire { from: source.port, to: port });
        }
    }

    /// Removes the wire into an input; returns whether there was one.
    pub(super) fn cut(&mut self, id: NodeId, port: &str) -> bool {
        self.edge_into(id, port).is_some_and(|edge| self.graph.remove_edge(edge).is_some())
    }

    fn edge_into(&self, id: NodeId, port: &str) -> Option<EdgeIndex> {
        let mut edges = self.graph.edges_directed(self.place(id)?, Incoming);
        edges.find(|e| e.weight().to == port).map(|e| e.id())
    }
}

/// The node of an id that exists.
///
/// # Panics
/// Panics when there is no such node.
impl Index<NodeId> for Dag {
    type Output = GraphNode;

    fn index(&self, id: NodeId) -> &GraphNode {
        &self.graph[self.places[&id]].1
    }
}

impl IndexMut<NodeId> for Dag {
    fn index_mut(&mut self, id: NodeId) -> &mut GraphNode {
        Arc::make_mut(&mut self.graph[self.places[&id]].1)
    }
}
