//! What earlier programs made ready: a hand changes one node after the other, and the rest is as it was.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::program::{Program, Ready};
use crate::graph::{Graph, NodeId};
use crate::value::Terrain;

/// Nodes that an engine knows beyond those of the graph it was asked about last: a session has a few graphs at once, such
/// as that of the window and one that is opened.
const SPARE: usize = 4096;

/// Nodes that are ready to run, by their ids, in one terrain.
#[derive(Debug, Default)]
pub(super) struct Prepared(Mutex<Shelf>);

#[derive(Debug, Default)]
struct Shelf {
    terrain: Terrain,
    nodes: HashMap<NodeId, Arc<Ready>>,
}

impl Prepared {
    /// What was made of a node in a terrain, whether or not the node is still the same.
    pub(super) fn get(&self, terrain: &Terrain, id: NodeId) -> Option<Arc<Ready>> {
        let shelf = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if shelf.terrain == *terrain { shelf.nodes.get(&id).cloned() } else { None }
    }

    /// Keeps what a program made ready.
    pub(super) fn keep(&self, graph: &Graph, program: &Program) {
        let mut shelf = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if shelf.terrain != program.terrain {
            *shelf = Shelf { terrain: program.terrain.clone(), nodes: HashMap::new() };
        }
        shelf.nodes.extend(program.ready());
        if shelf.nodes.len() > graph.nodes().len() + SPARE {
            shelf.nodes.retain(|id, _| graph.get(*id).is_some());
        }
    }
}
