//! The walk from wanted nodes up their wires to all that they need.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::graph::{Graph, NodeId, NodeMap, Source};

/// A wire into a node.
#[derive(Debug)]
pub(super) struct Inlet {
    /// The index of the input among those of the kind.
    pub port: usize,
    /// The output behind bypassed nodes; `None` where one of these has nothing to pass on.
    pub source: Option<Source>,
}

/// A node that was reached.
#[derive(Debug)]
struct Reached {
    id: NodeId,
    /// Its wires among those of all nodes.
    inlets: Range<usize>,
    /// Whether all that it needs was walked.
    is_left: bool,
}

/// The nodes upstream of some nodes, the wires between them, and those that stand on a cycle.
#[derive(Debug, Default)]
pub(super) struct Walk {
    reached: Vec<Reached>,
    inlets: Vec<Inlet>,
    places: NodeMap<usize>,
    /// Indices of the nodes that were reached, sources first.
    pub order: Vec<usize>,
    /// Those of them that stand on a cycle.
    pub cyclic: BTreeSet<usize>,
}

impl Walk {
    pub(super) fn new(graph: &Graph, wanted: &[NodeId]) -> Self {
        let mut walk = Self::default();
        // An explicit stack of nodes and the number of their wires that were followed: a chain of ten thousand nodes is a
        // fair graph.
        let mut stack: Vec<(usize, usize)> = Vec::new();
        for &root in wanted {
            if !walk.places.contains_key(&root) {
                stack.push((walk.enter(graph, root), 0));
            }
            while let Some((place, followed)) = stack.last_mut() {
                let Some(inlet) = walk.inlets(*place).get(*followed) else {
                    walk.reached[*place].is_left = true;
                    walk.order.push(*place);
                    stack.pop();
                    continue;
                };
                *followed += 1;
                let Some(next) = inlet.source.as_ref().map(|s| s.node) else { continue };
                match walk.places.get(&next) {
                    None => stack.push((walk.enter(graph, next), 0)),
                    Some(known) if !walk.reached[*known].is_left => {
                        let start = stack.iter().position(|(place, _)| place == known).unwrap_or(0);
                        walk.cyclic.extend(stack[start..].iter().map(|(place, _)| *place));
                    }
                    Some(_) => (),
                }
            }
        }
        walk
    }

    /// The node of an index.
    pub(super) fn node(&self, place: usize) -> NodeId {
        self.reached[place].id
    }

    /// The wires into the node of an index, in the order of its kind's inputs.
    pub(super) fn inlets(&self, place: usize) -> &[Inlet] {
        &self.inlets[self.reached[place].inlets.clone()]
    }

    /// Adds a node with its wires, and returns its index.
    fn enter(&mut self, graph: &Graph, id: NodeId) -> usize {
        let (place, first) = (self.reached.len(), self.inlets.len());
        let kind = graph.get(id).and_then(|node| node.kind());
        for (port, input) in kind.iter().flat_map(|kind| kind.inputs.iter().enumerate()) {
            if let Some(source) = graph.source(id, &input.name) {
                self.inlets.push(Inlet { port, source: graph.passed(source) });
            }
        }
        self.places.insert(id, place);
        self.reached.push(Reached { id, inlets: first..self.inlets.len(), is_left: false });
        place
    }
}
