//! The document: a directed graph of nodes, the terrain they make, and the file with both.
//!
//! A [`Graph`] is read from a `.graph` file, checked, edited and written back. Reading fails only where a file is no
//! graph at all. Faults inside a graph are kept as they were written, and reported by [`Graph::problems`], each
//! [`Problem`] with its [`Place`]. Edits that would cause a fault are refused with the same problems.
//! `docs/graph-file.md` describes the file.
//!
//! Names, places on the canvas, titles and exposed names do not influence what a node computes, so that editing them
//! leaves all cached results valid. The engine uses [`GraphNode::parse`], the wires and the [`Terrain`] and nothing
//! else.

mod bind;
mod canvas;
mod dag;
mod edit;
mod expose;
mod fragment;
mod json;
mod load;
mod migrate;
mod order;
mod parts;
mod path;
mod problem;
mod quantity;
mod schema;
mod set;
mod settings;
mod validate;
mod wires;
mod write;
mod written;

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::{Map, Value as Json};

pub use canvas::{Bends, Note, NoteColor};
use dag::Dag;
pub use dag::NodeId;
pub(crate) use dag::NodeMap;
pub use fragment::Grafted;
pub use json::read as strict_json;
pub use load::{LoadError, MAX_FILE, MAX_NAMED, MAX_NODES};
pub use migrate::FORMAT;
pub use parts::{About, Backend, Exposed, GraphNode, KindRef, Output};
pub use problem::{Place, Problem, Severity};
pub use quantity::GraphQuantities;
pub use schema::schema;
pub use set::Settings;
pub use settings::terrain_params;
pub use wires::Source;
pub use written::Written;

use crate::nodes::Registry;
use crate::value::Terrain;

/// A graph of nodes over a terrain; see the [module](self).
#[derive(Clone, Debug)]
pub struct Graph {
    registry: Registry,
    dag: Dag,
    /// The nodes in the order of the file.
    sequence: Vec<NodeId>,
    names: Arc<HashMap<String, NodeId>>,
    about: About,
    /// The settings of the terrain as the file has them, and the terrain made of them.
    settings: Map<String, Json>,
    terrain: Terrain,
    exposed: Vec<(String, Exposed)>,
    outputs: Vec<(String, Output)>,
    notes: Vec<(String, Note)>,
    /// The versions that the file states for kinds that this program does not know.
    versions: Map<String, Json>,
    extra: Map<String, Json>,
    /// Warnings about the file as it was read. The next change clears them, because writing the graph resolves them.
    load_warnings: Vec<Problem>,
    /// Errors of the terrain and of exposed parameters, which block outputs.
    blocking_problems: Vec<Problem>,
    /// The file as it was read, while nothing has changed.
    original: Option<Arc<[u8]>>,
    edits: u64,
    revision: Revision,
}

/// The number of a revision of a graph. Copies of a graph have the same number until one of them changes, and a change
/// gives a number that no other graph of the process has, so that equal numbers mean equal graphs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Revision(u64);

impl Revision {
    fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

impl Default for Graph {
    fn default() -> Self {
        Self::new()
    }
}

impl Graph {
    /// An empty graph over the default terrain, with the kinds of this program.
    pub fn new() -> Self {
        Self::with_registry(Registry::standard())
    }

    /// An empty graph over the default terrain, with the kinds of a registry.
    pub fn with_registry(registry: Registry) -> Self {
        Self {
            registry,
            dag: Dag::default(),
            sequence: Vec::new(),
            names: Arc::default(),
            about: About::default(),
            settings: Map::new(),
            terrain: Terrain::default(),
            exposed: Vec::new(),
            outputs: Vec::new(),
            versions: Map::new(),
            extra: Map::new(),
            notes: Vec::new(),
            load_warnings: Vec::new(),
            blocking_problems: Vec::new(),
            original: None,
            edits: 0,
            revision: Revision::fresh(),
        }
    }

    /// The kinds that the nodes can have.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Title, author and other texts of the graph.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The terrain, with the values of exposed parameters. It never has a [`Terrain::fault`]: settings with faults have
    /// their defaults instead, and [`problems`](Self::problems) reports them.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// The settings of the terrain as they are written, including those with faults.
    pub fn terrain_settings(&self) -> &Map<String, Json> {
        &self.settings
    }

    /// The nodes, in the order of the file.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = NodeId> + '_ {
        self.sequence.iter().copied()
    }

    /// The node of an id.
    ///
    /// # Panics
    /// Panics when the graph has no such node; see [`get`](Self::get).
    pub fn node(&self, id: NodeId) -> &GraphNode {
        &self.dag[id]
    }

    /// The node of an id, if the graph has it.
    pub fn get(&self, id: NodeId) -> Option<&GraphNode> {
        self.dag.get(id).map(|node| &**node)
    }

    /// A node in the form that copies of the graph share until one changes it. Equal pointers mean equal nodes.
    pub(crate) fn shared(&self, id: NodeId) -> Option<&Arc<GraphNode>> {
        self.dag.get(id)
    }

    /// The node of a name.
    pub fn find(&self, name: &str) -> Option<NodeId> {
        self.names.get(name).copied()
    }

    /// The outputs, in the order of the file.
    pub fn outputs(&self) -> impl ExactSizeIterator<Item = (&str, &Output)> {
        self.outputs.iter().map(|(name, output)| (name.as_str(), output))
    }

    /// The output of a name.
    pub fn output(&self, name: &str) -> Option<&Output> {
        self.outputs().find(|(n, _)| *n == name).map(|(_, output)| output)
    }

    /// The exposed parameters, in the order of the file.
    pub fn exposed(&self) -> impl ExactSizeIterator<Item = (&str, &Exposed)> {
        self.exposed.iter().map(|(name, exposed)| (name.as_str(), exposed))
    }

    /// The notes on the canvas, in the order of the file.
    pub fn notes(&self) -> impl ExactSizeIterator<Item = (&str, &Note)> {
        self.notes.iter().map(|(name, note)| (name.as_str(), note))
    }

    /// The note of a name.
    pub fn note(&self, name: &str) -> Option<&Note> {
        self.notes().find(|(n, _)| *n == name).map(|(_, note)| note)
    }

    /// Parts of the file that this version does not know, as they were written.
    pub fn extra(&self) -> &Map<String, Json> {
        &self.extra
    }

    /// Whether the graph differs from the file it was read from, or was not read from one.
    pub fn is_changed(&self) -> bool {
        self.original.is_none()
    }

    /// The number of edits that have changed the graph since it was made or read; an edit that changes nothing does not
    /// count.
    pub fn edits(&self) -> u64 {
        self.edits
    }

    /// The revision of the graph, by which copies that are equal are known without a look at their nodes.
    pub(crate) fn revision(&self) -> Revision {
        self.revision
    }

    /// Records that an edit changed something.
    fn touch(&mut self) {
        self.original = None;
        self.edits += 1;
        self.revision = Revision::fresh();
        self.load_warnings.clear();
    }
}
