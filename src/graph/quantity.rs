//! Quantities of outputs, which are known without running any node.

use std::collections::HashMap;

use super::{Graph, NodeId, Source};
use crate::value::Quantity;

/// The quantities of the outputs of some nodes.
#[derive(Clone, Debug, Default)]
pub struct GraphQuantities(HashMap<NodeId, Vec<Option<Quantity>>>);

impl Graph {
    /// The quantities of all outputs in the graph.
    pub fn quantities(&self) -> GraphQuantities {
        // Nodes on a cycle or downstream of one have none.
        let (sorted, _) = self.sorted_as_far(self.sequence.clone());
        self.quantities_of(&sorted)
    }

    /// The quantity of an output; `None` where it has no numbers, or a fault leaves the quantity open.
    pub fn quantity(&self, source: &Source) -> Option<Quantity> {
        let source = self.passed(source.clone())?;
        self.quantities_of(&self.order_of(&[source.node]).ok()?).get(self, &source)
    }

    /// The quantities of nodes that are sorted, sources first.
    fn quantities_of(&self, nodes: &[NodeId]) -> GraphQuantities {
        let mut known = GraphQuantities::default();
        for &id in nodes {
            let node = self.node(id);
            let Some(kind) = node.kind() else { continue };
            let parsed = node.parse().ok();
            let of = |output: &str| {
                let read = |port: &str| known.get(self, &self.source(id, port)?);
                kind.quantity(parsed.as_deref(), output, &read)
            };
            let quantities = kind.outputs.iter().map(|port| of(&port.name)).collect();
            known.0.insert(id, quantities);
        }
        known
    }
}

impl GraphQuantities {
    /// The quantity of an output of a node; `None` where it has no numbers, or a fault leaves the quantity open.
    pub fn get(&self, graph: &Graph, source: &Source) -> Option<Quantity> {
        let source = graph.passed(source.clone())?;
        let output = graph.get(source.node)?.kind()?.outputs.iter().position(|p| p.name == source.port)?;
        *self.0.get(&source.node)?.get(output)?
    }
}
