//! Wires: the output that an input reads, and its text in the file.

use serde_json::Value as Json;

use super::problem::{Hints, Place, Problem, listed};
use super::{Graph, KindRef, NodeId};
use crate::name::Name;
use crate::value::WireType;

/// A wire between two nodes, on the edge of the graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wire {
    /// The output at its beginning.
    pub(super) from: Name,
    /// The input at its end.
    pub(super) to: Name,
}

/// An output of a node, which a wire or an output of the graph reads.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Source {
    /// The node.
    pub node: NodeId,
    /// The output port.
    pub port: Name,
}

/// Why a text `node.port` does not resolve.
pub(super) enum Miss<'a> {
    Form,
    Node(&'a str),
    Kind(NodeId),
    Port(NodeId, &'a str),
}

impl Graph {
    /// The wire into an input, if there is one and it resolves.
    pub fn source(&self, id: NodeId, port: &str) -> Option<Source> {
        self.dag.source(id, port)
    }

    /// The source of a value behind bypassed nodes, which pass on the value of their input. `None` where a bypassed
    /// node has nothing to pass on.
    pub fn passed(&self, mut source: Source) -> Option<Source> {
        // A file may have a cycle of bypassed nodes.
        for _ in 0..=self.sequence.len() {
            let node = self.get(source.node)?;
            if !node.bypass {
                return Some(source);
            }
            source = self.source(source.node, node.kind()?.bridge(&source.port)?)?;
        }
        None
    }

    /// All wires into a node that resolve, in the order of its kind's inputs.
    pub fn inputs(&self, id: NodeId) -> impl Iterator<Item = (&Name, Source)> + '_ {
        let kind = self.get(id).and_then(|n| n.kind());
        let ports = kind.into_iter().flat_map(|k| &k.inputs);
        ports.filter_map(move |port| Some((&port.name, self.source(id, &port.name)?)))
    }

    /// The inputs that read an output of a node, as node, input and the output they read.
    pub fn consumers(&self, id: NodeId) -> impl Iterator<Item = (NodeId, &Name, &Name)> + '_ {
        self.dag.wires_from(id).map(|(node, wire)| (node, &wire.to, &wire.from))
    }

    /// The source of an output of the graph.
    ///
    /// # Errors
    /// Fails when there is no such output, or when there is a fault in its name, its source or a setting of it, in a
    /// setting of the terrain, or in an exposed parameter that sets a node upstream. Faults of the nodes are found by
    /// [`GraphNode::parse`](super::GraphNode::parse) and [`problems`](Self::problems).
    pub fn output_source(&self, name: &str) -> Result<Source, Problem> {
        let hints = Hints::new();
        let place = Place::Output(name.to_owned());
        let Some(output) = self.output(name) else {
            let names = || self.outputs().map(|(n, _)| n);
            let (all, hint) = (listed(names()), hints.nearest(name, names()));
            return Err(Problem::error(place, format!("is not an output of this graph; it has {all}{hint}")));
        };
        if let Some(fault) = self.output_faults(name, output, &hints).into_iter().find(Problem::is_error) {
            return Err(fault);
        }
        let source = self.resolve(&output.from);
        let source =
            source.map_err(|miss| Problem::error(place, self.explain(&output.from, &miss, &hints)))?;
        if !self.blocking_problems.is_empty() {
            let upstream = self.upstream(source.node);
            if let Some(fault) = self.blocking_problems.iter().find(|p| p.stops(name, &upstream)) {
                return Err(fault.clone());
            }
        }
        Ok(source)
    }

    /// The text of a source in the file, `node.port`.
    pub fn source_text(&self, source: &Source) -> String {
        format!("{}.{}", self.node(source.node).name, source.port)
    }

    /// The type of an output of a node.
    pub fn wire_type(&self, source: &Source) -> Option<WireType> {
        Some(self.get(source.node)?.kind()?.output(&source.port)?.wire)
    }

    /// The output that a text `node.port` names, if there is one.
    pub fn resolved(&self, text: &str) -> Option<Source> {
        self.resolve(text).ok()
    }

    pub(super) fn resolve<'a>(&self, text: &'a str) -> Result<Source, Miss<'a>> {
        let (name, port) = text.rsplit_once('.').ok_or(Miss::Form)?;
        let node = self.find(name).ok_or(Miss::Node(name))?;
        let kind = self.node(node).kind().ok_or(Miss::Kind(node))?;
        let port = kind.output(port).ok_or(Miss::Port(node, port))?;
        Ok(Source { node, port: port.name.clone() })
    }

    /// The reason why a text does not resolve, without a subject.
    pub(super) fn explain(&self, text: &str, miss: &Miss<'_>, hints: &Hints) -> String {
        match *miss {
            Miss::Form => format!("must be written as `node.port`, got `{text}`"),
            Miss::Node(name) => {
                let hint = hints.nearest(name, self.names_of_nodes());
                format!("reads `{text}`, but the graph has no node `{name}`{hint}")
            }
            Miss::Kind(node) => {
                let kind = self.node(node).kind.id();
                format!("reads `{text}`, whose kind `{kind}` is not known")
            }
            Miss::Port(node, port) => {
                let node = self.node(node);
                let names = || node.kind().into_iter().flat_map(|k| &k.outputs).map(|p| p.name.as_str());
                let (all, hint) = (listed(names()), hints.nearest(port, names()));
                format!("reads `{text}`, but `{}` has no output `{port}`; it has {all}{hint}", node.name)
            }
        }
    }

    pub(super) fn names_of_nodes(&self) -> impl Iterator<Item = &str> {
        self.nodes().map(|id| self.node(id).name.as_str())
    }

    /// Turns the written inputs that resolve and fit into wires.
    pub(super) fn link(&mut self) {
        for i in 0..self.sequence.len() {
            let id = self.sequence[i];
            if self.node(id).loose.is_empty() {
                continue;
            }
            let KindRef::Known(kind) = self.node(id).kind.clone() else { continue };
            for port in &kind.inputs {
                let fits =
                    self.node(id).loose.get(port.name.as_str()).and_then(Json::as_str).and_then(|text| {
                        let source = self.resolve(text).ok()?;
                        (self.wire_type(&source)? == port.wire).then_some(source)
                    });
                if let Some(source) = fits {
                    self.dag[id].loose.shift_remove(port.name.as_str());
                    self.put_wire(source, id, &port.name);
                }
            }
        }
    }

    /// Adds a wire in place of the one that the input had.
    pub(super) fn put_wire(&mut self, source: Source, id: NodeId, port: &Name) {
        self.cut_wire(id, port);
        self.dag.connect(source, id, port.clone());
    }

    /// Removes the wire into an input, if there is one.
    pub(super) fn cut_wire(&mut self, id: NodeId, port: &str) -> bool {
        let cut = self.dag.cut(id, port);
        if cut {
            self.dag[id].bends.retain(|b| b.input != port);
        }
        cut
    }
}
