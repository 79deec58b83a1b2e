//! Nodes prepared by earlier programs. In the editor one node changes at a time, and the others are taken over.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::program::{Program, Ready};
use crate::graph::{Graph, NodeId};
use crate::value::Terrain;

/// Number of prepared nodes beyond those of the last graph. A session has a few graphs at once, such as that of the
/// window and one that is being opened.
const SPARE: usize = 4096;

/// The nodes that are ready to run, by id, for one terrain.
#[derive(Debug, Default)]
pub(super) struct Prepared(Mutex<Shelf>);

#[derive(Debug, Default)]
struct Shelf {
    terrain: Terrain,
    nodes: HashMap<NodeId, Arc<Ready>>,
}

impl Prepared {
    /// The prepared form of a node in a terrain; the caller checks that the node is unchanged.
    pub(super) fn get(&self, terrain: &Terrain, id: NodeId) -> Option<Arc<Ready>> {
        let shelf = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if shelf.terrain == *terrain { shelf.nodes.get(&id).cloned() } else { None }
    }

    /// Stores the nodes that a program prepared.
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
