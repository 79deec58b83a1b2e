//! Fragments: parts of graphs as graphs, for copying, pasting and duplicating.

use std::collections::{BTreeMap, HashSet};

use super::problem::{Place, Problem};
use super::{Graph, KindRef, MAX_NAMED, MAX_NODES, NodeId, Note};

/// The nodes and notes that [`Graph::graft`] added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grafted {
    /// The new nodes, in the order of the fragment.
    pub nodes: Vec<NodeId>,
    /// The names of the new notes.
    pub notes: Vec<String>,
}

impl Graph {
    /// A graph of some of the nodes and notes, with the wires between them, the values of their parameters and the
    /// terrain, but without outputs, exposed names and wires from other nodes.
    pub fn fragment(&self, ids: &[NodeId], notes: &[String]) -> Self {
        let chosen: HashSet<NodeId> = ids.iter().copied().collect();
        let mut part = Self::with_registry(self.registry().clone());
        part.settings = self.settings.clone();
        part.terrain = self.terrain.clone();
        let mut copies: BTreeMap<NodeId, NodeId> = BTreeMap::new();
        for id in self.nodes().filter(|id| chosen.contains(id)) {
            let node = self.node(id).clone();
            if let KindRef::Unknown(kind) = &node.kind
                && let Some(version) = self.versions.get(kind)
            {
                part.versions.insert(kind.clone(), version.clone());
            }
            copies.insert(id, part.put_node(node));
        }
        part.copy_wires(self, &copies);
        part.notes = self.notes.iter().filter(|(name, _)| notes.contains(name)).cloned().collect();
        part
    }

    /// Adds the nodes, wires and notes of another graph, moved on the canvas by an offset. Names that are taken have
    /// the next free number added.
    ///
    /// # Errors
    /// Fails when there would be too many nodes or notes; then nothing is added.
    pub fn graft(&mut self, part: &Self, offset: [f64; 2]) -> Result<Grafted, Problem> {
        let too_many = |what: &str, limit: usize| {
            Err(Problem::error(Place::Graph, format!("would have more than {limit} {what}")))
        };
        if self.sequence.len() + part.sequence.len() > MAX_NODES {
            return too_many("nodes", MAX_NODES);
        }
        if self.notes.len() + part.notes.len() > MAX_NAMED {
            return too_many("notes", MAX_NAMED);
        }
        let moved = |at: [f64; 2]| [0, 1].map(|k| (at[k] + offset[k]).clamp(-1e9, 1e9) + 0.0);
        let mut grafted = Grafted::default();
        let mut copies: BTreeMap<NodeId, NodeId> = BTreeMap::new();
        for id in part.nodes() {
            let mut node = part.node(id).clone();
            node.name = self.free_name(&node.name);
            node.at = moved(node.at);
            for bend in node.bends.iter_mut().flat_map(|b| &mut b.at) {
                *bend = moved(*bend);
            }
            if let KindRef::Unknown(kind) = &node.kind
                && let Some(version) = part.versions.get(kind)
            {
                self.versions.entry(kind.clone()).or_insert_with(|| version.clone());
            }
            let copy = self.put_node(node);
            copies.insert(id, copy);
            grafted.nodes.push(copy);
        }
        self.copy_wires(part, &copies);
        for (_, note) in &part.notes {
            grafted.notes.push(self.add_note(Note { at: moved(note.at), ..note.clone() })?);
        }
        // Inputs are connected as when a file with these nodes is read.
        self.link();
        self.settle();
        Ok(grafted)
    }

    /// Copies the wires between nodes of another graph to their copies in this one.
    fn copy_wires(&mut self, from: &Self, copies: &BTreeMap<NodeId, NodeId>) {
        for (&id, &copy) in copies {
            for (port, source) in from.inputs(id) {
                let source = copies.get(&source.node).map(|&node| super::Source { node, ..source });
                match source {
                    Some(source) => self.put_wire(source, copy, port),
                    None => self.dag[copy].bends.retain(|b| b.input != port.as_str()),
                }
            }
        }
    }
}
