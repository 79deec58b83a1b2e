//! Edits of nodes, wires and outputs. Each edit is checked before it changes anything, so that a refused edit leaves
//! the graph as it was.

use std::collections::HashSet;
use std::sync::Arc;

use serde_json::{Map, Value as Json};

use super::parts::{About, Backend, GraphNode, KindRef, Output, Part};
use super::problem::{Hints, Place, Problem, listed};
use super::validate::{node_name_fault, output_name_fault};
use super::{Graph, MAX_NAMED, MAX_NODES, NodeId, Source};
use crate::kit::hash;
use crate::name::Name;
use crate::node::Kind;
use crate::ports::Port;

impl Graph {
    /// Adds a node of a kind. Where the kind has a seed, the node has a new one.
    ///
    /// # Errors
    /// Fails when the name is taken or invalid, the kind is unknown, or the graph is full.
    pub fn add(&mut self, name: &str, kind: &str) -> Result<NodeId, Problem> {
        let place = || Place::Node(name.to_owned());
        let bad = |message: String| Err(Problem::error(place(), message));
        self.free_node_name(name)?;
        let Some(known) = self.registry.find(kind) else {
            return bad(format!("there is no kind `{kind}`{}", self.registry.suggest(kind)));
        };
        if self.nodes().any(|id| matches!(&self.node(id).kind, KindRef::Unknown(k) if k == kind)) {
            return bad(format!(
                "the file has nodes of the kind `{kind}` in a version that is not known here"
            ));
        }
        if self.sequence.len() >= MAX_NODES {
            return bad(format!("would be one more than the limit of {MAX_NODES} nodes"));
        }
        let mut set = Map::new();
        if known.param("seed").is_some() {
            set.insert("seed".into(), self.fresh_seed(name).into());
        }
        self.versions.shift_remove(kind);
        let node = GraphNode {
            name: name.to_owned(),
            kind: KindRef::Known(known.clone()),
            set: set.into(),
            at: [0.0; 2],
            backend: Backend::Auto,
            bypass: false,
            bends: Vec::new(),
            extra: Map::new(),
            loose: Map::new(),
        };
        let id = self.put_node(node);
        self.settle();
        Ok(id)
    }

    /// A name that no node has: the wanted one, or the wanted one with the next free number.
    pub fn free_name(&self, wanted: &str) -> String {
        let free = |name: &String| node_name_fault(name).is_none() && self.find(name).is_none();
        let stem = wanted.get(..wanted.len().min(56)).unwrap_or("node");
        let numbered = (2..=self.sequence.len() + 2).map(|n| format!("{stem}_{n}"));
        std::iter::once(wanted.to_owned())
            .chain(numbered)
            .find(free)
            .unwrap_or_else(|| self.free_name("node"))
    }

    /// Removes a node with its wires. Outputs that read it stay and are reported as problems. It is removed from the
    /// binds of exposed parameters, and an exposed parameter that has no other bind is removed, too.
    ///
    /// # Errors
    /// Fails when there is no such node.
    pub fn remove(&mut self, id: NodeId) -> Result<GraphNode, Problem> {
        self.live(id)?;
        self.sequence.retain(|n| *n != id);
        let gone = || Problem::error(Place::Graph, "has no such node");
        let node = self.dag.remove(id).ok_or_else(gone)?;
        Arc::make_mut(&mut self.names).remove(&node.name);
        self.exposed.retain_mut(|(_, exposed)| {
            let before = exposed.bind.len();
            exposed.bind.retain(|bind| bind.split('.').next() != Some(&node.name));
            !exposed.bind.is_empty() || before == 0
        });
        self.settle();
        Ok(node)
    }

    /// Removes a node and wires its input to the readers of its output, where the kind says which output is a change of
    /// which input.
    ///
    /// # Errors
    /// Fails when there is no such node.
    pub fn remove_bridged(&mut self, id: NodeId) -> Result<GraphNode, Problem> {
        self.live(id)?;
        let name = self.node(id).name.clone();
        let readers = self.consumers(id).map(|(reader, to, from)| (reader, to.clone(), from.clone()));
        let readers: Vec<_> = readers.collect();
        for (output, source) in self.bridges(id) {
            let (old, new) = (format!("{name}.{output}"), self.source_text(&source));
            for (_, reader) in self.outputs.iter_mut().filter(|(_, o)| o.from == old) {
                reader.from.clone_from(&new);
            }
            for (reader, input, _) in readers.iter().filter(|(_, _, from)| *from == output) {
                self.put_wire(source.clone(), *reader, input);
            }
        }
        self.remove(id)
    }

    /// For each output of a node that is a change of an input, the source of this input.
    fn bridges(&self, id: NodeId) -> Vec<(Name, Source)> {
        let outputs = self.node(id).kind().map_or(&[][..], |kind| &kind.outputs);
        let bridge = |port: &Port| {
            let source = self.source(id, self.node(id).kind()?.bridge(&port.name)?)?;
            let fits = source.node != id && self.wire_type(&source) == Some(port.wire);
            fits.then_some((port.name.clone(), source))
        };
        outputs.iter().filter_map(bridge).collect()
    }

    /// Renames a node, also in wires, outputs and exposed parameters that name it.
    ///
    /// # Errors
    /// Fails when the name is taken or invalid.
    pub fn rename(&mut self, id: NodeId, name: &str) -> Result<(), Problem> {
        self.live(id)?;
        if self.node(id).name == name {
            return Ok(());
        }
        self.free_node_name(name)?;
        let old = std::mem::replace(&mut self.dag[id].name, name.to_owned());
        let names = Arc::make_mut(&mut self.names);
        names.remove(&old);
        names.insert(name.to_owned(), id);
        let renamed = |text: &str, end: Option<usize>| {
            let (node, rest) = text.split_at(end?);
            (node == old).then(|| format!("{name}{rest}"))
        };
        for id in self.sequence.clone() {
            for written in self.dag[id].loose.values_mut() {
                let new = written.as_str().and_then(|text| renamed(text, text.rfind('.')));
                if let Some(new) = new {
                    *written = Json::from(new);
                }
            }
        }
        for (_, output) in &mut self.outputs {
            if let Some(new) = renamed(&output.from, output.from.rfind('.')) {
                output.from = new;
            }
        }
        for bind in self.exposed.iter_mut().flat_map(|(_, e)| &mut e.bind) {
            if let Some(new) = renamed(bind, bind.find('.')) {
                *bind = new;
            }
        }
        self.settle();
        Ok(())
    }

    /// Connects an output of a node to an input of another, in place of the wire that the input had.
    ///
    /// # Errors
    /// Fails when a port does not exist, the types differ, or the wire would close a cycle, whose nodes the error
    /// names.
    pub fn connect(&mut self, from: NodeId, output: &str, to: NodeId, input: &str) -> Result<(), Problem> {
        let (source, input) = self.fitting(from, output, to, input)?;
        if self.source(to, &input).as_ref() == Some(&source) {
            return Ok(());
        }
        let node = &mut self.dag[to];
        node.loose.shift_remove(input.as_str());
        node.extra.shift_remove("in");
        self.put_wire(source, to, &input);
        self.settle();
        Ok(())
    }

    /// Checks that a wire is possible, without a change.
    ///
    /// # Errors
    /// Returns the errors of [`connect`](Self::connect).
    pub fn can_connect(&self, from: NodeId, output: &str, to: NodeId, input: &str) -> Result<(), Problem> {
        self.fitting(from, output, to, input).map(drop)
    }

    fn fitting(
        &self,
        from: NodeId,
        output: &str,
        to: NodeId,
        input: &str,
    ) -> Result<(Source, Name), Problem> {
        let out_port = self.port(from, output, PortSide::Output)?;
        let in_port = self.port(to, input, PortSide::Input)?;
        let source = Source { node: from, port: out_port.name.clone() };
        let (name, text) = (&self.node(to).name, self.source_text(&source));
        let bad = |message| {
            Err(Problem::error(Place::Input { node: name.clone(), port: input.to_owned() }, message).of(to))
        };
        if out_port.wire != in_port.wire {
            return bad(format!(
                "takes {}, but `{text}` gives {}",
                in_port.wire.name(),
                out_port.wire.name()
            ));
        }
        if from == to {
            return bad(format!("cannot read `{text}`: a node cannot read itself"));
        }
        if let Some(way) = self.way(to, from) {
            let path = self.path_text(&way, to);
            return bad(format!("cannot read `{text}`: that would close a cycle, {path}"));
        }
        Ok((source, in_port.name.clone()))
    }

    /// Removes the wire into an input, including one that does not resolve. Does nothing where there is none.
    ///
    /// # Errors
    /// Fails when neither the kind nor the file has such an input.
    pub fn disconnect(&mut self, to: NodeId, input: &str) -> Result<(), Problem> {
        self.live(to)?;
        let was_loose = self.dag[to].loose.shift_remove(input).is_some();
        if was_loose || self.cut_wire(to, input) {
            self.settle();
            return Ok(());
        }
        self.port(to, input, PortSide::Input).map(drop)
    }

    /// Moves a node on the canvas.
    ///
    /// # Errors
    /// Fails when a coordinate is not a number within ±1e9.
    pub fn move_to(&mut self, id: NodeId, at: [f64; 2]) -> Result<(), Problem> {
        self.live(id)?;
        if at.iter().any(|v| !v.is_finite() || v.abs() > 1e9) {
            let message = format!("must stand within 1e9 of the middle of the canvas, got {at:?}");
            return Err(Problem::error(Place::Node(self.node(id).name.clone()), message));
        }
        // The file has no −0.
        let at = at.map(|v| v + 0.0);
        let node = &mut self.dag[id];
        if node.extra.shift_remove("at").is_some() || node.at != at {
            node.at = at;
            self.touch();
        }
        Ok(())
    }

    /// Sets the backend on which a node runs.
    ///
    /// # Errors
    /// Fails when there is no such node.
    pub fn set_backend(&mut self, id: NodeId, backend: Backend) -> Result<(), Problem> {
        self.live(id)?;
        let node = &mut self.dag[id];
        if node.extra.shift_remove("backend").is_some() || node.backend != backend {
            node.backend = backend;
            self.touch();
        }
        Ok(())
    }

    /// Sets title, author and other texts of the graph.
    pub fn set_about(&mut self, about: About) {
        let known = |key: &str| About::keys().iter().any(|p| p.name == key);
        let had_fault = self.extra.keys().any(|key| known(key));
        if had_fault || self.about != about {
            self.extra.retain(|key, _| !known(key));
            self.about = about;
            self.touch();
        }
    }

    /// Adds an output.
    ///
    /// # Errors
    /// Fails when the name is taken or invalid, its source does not exist, or a setting has a fault.
    pub fn add_output(&mut self, name: &str, output: Output) -> Result<(), Problem> {
        self.free_output_name(name, None)?;
        if self.outputs.len() >= MAX_NAMED {
            let message = format!("would be one more than the limit of {MAX_NAMED}");
            return Err(Problem::error(Place::Output(name.to_owned()), message));
        }
        self.outputs.push((name.to_owned(), self.checked_output(name, output)?));
        self.touch();
        Ok(())
    }

    /// Changes an output.
    ///
    /// # Errors
    /// Fails when there is no output of the name, its source does not exist, or a setting has a fault.
    pub fn change_output(&mut self, name: &str, output: Output) -> Result<(), Problem> {
        let i = self.output_index(name)?;
        let output = self.checked_output(name, output)?;
        if self.outputs[i].1 != output {
            self.outputs[i].1 = output;
            self.touch();
        }
        Ok(())
    }

    /// Renames an output.
    ///
    /// # Errors
    /// Fails when there is no output of the name, or the new name is taken or invalid.
    pub fn rename_output(&mut self, name: &str, new: &str) -> Result<(), Problem> {
        let i = self.output_index(name)?;
        if name != new {
            self.free_output_name(new, Some(i))?;
            self.outputs[i].0 = new.to_owned();
            self.touch();
        }
        Ok(())
    }

    /// Removes an output.
    ///
    /// # Errors
    /// Fails when there is no output of the name.
    pub fn remove_output(&mut self, name: &str) -> Result<Output, Problem> {
        let i = self.output_index(name)?;
        self.touch();
        Ok(self.outputs.remove(i).1)
    }

    /// Adds a node to the graph and its name to the index.
    pub(super) fn put_node(&mut self, node: GraphNode) -> NodeId {
        let name = node.name.clone();
        let id = self.dag.add(node);
        self.sequence.push(id);
        Arc::make_mut(&mut self.names).insert(name, id);
        id
    }

    fn free_node_name(&self, name: &str) -> Result<(), Problem> {
        let fault = node_name_fault(name);
        let taken = self.find(name).map(|_| "is the name of another node".to_owned());
        fault.or(taken).map_or(Ok(()), |message| Err(Problem::error(Place::Node(name.to_owned()), message)))
    }

    fn free_output_name(&self, name: &str, itself: Option<usize>) -> Result<(), Problem> {
        let others = self.outputs.iter().enumerate().filter(|(i, _)| Some(*i) != itself);
        let twin = others.map(|(_, (n, _))| n).find(|n| n.eq_ignore_ascii_case(name));
        let taken = twin.map(|twin| format!("is the name of another output, `{twin}`"));
        let fault = output_name_fault(name).or(taken);
        fault.map_or(Ok(()), |message| Err(Problem::error(Place::Output(name.to_owned()), message)))
    }

    fn output_index(&self, name: &str) -> Result<usize, Problem> {
        self.outputs.iter().position(|(n, _)| n == name).ok_or_else(|| {
            let names = || self.outputs().map(|(n, _)| n);
            let hint = Hints::new().nearest(name, names());
            let message = format!("is not an output of this graph; it has {}{hint}", listed(names()));
            Problem::error(Place::Output(name.to_owned()), message)
        })
    }

    fn checked_output(&self, name: &str, mut output: Output) -> Result<Output, Problem> {
        Output::forget_known(&mut output.extra);
        output.range = output.range.map(|ends| ends.map(|v| v + 0.0));
        match self.output_faults(name, &output, &Hints::new()).into_iter().find(Problem::is_error) {
            Some(fault) => Err(fault),
            None => Ok(output),
        }
    }

    fn port(&self, id: NodeId, port: &str, side: PortSide) -> Result<&Port, Problem> {
        self.live(id)?;
        let node = self.node(id);
        let (name, port_name) = (node.name.clone(), port.to_owned());
        let (place, what) = match side {
            PortSide::Input => (Place::Input { node: name, port: port_name }, "input"),
            PortSide::Output => (Place::NodeOutput { node: name, port: port_name }, "output"),
        };
        let Some(kind) = node.kind() else {
            let message = format!("cannot be connected, since the kind `{}` is not known", node.kind.id());
            return Err(Problem::error(place, message));
        };
        let ports = side.ports(kind);
        if let Some(found) = ports.iter().find(|p| p.name == port) {
            return Ok(found);
        }
        let names = || ports.iter().map(|p| p.name.as_str());
        let (all, hint) = (listed(names()), Hints::new().nearest(port, names()));
        Err(Problem::error(place, format!("`{}` has no such {what}; it has {all}{hint}", kind.id)))
    }

    /// A seed that no node has. It depends on the name of the node and is the same in every run of the program.
    fn fresh_seed(&self, name: &str) -> u32 {
        let seed = |id: NodeId| self.node(id).set.view("seed").and_then(|seed| seed.json().as_u64());
        let taken: HashSet<u64> = self.nodes().filter_map(seed).collect();
        let start = name.bytes().fold(0, |h, b| hash::mix(h ^ u64::from(b)));
        // Six digits are short in the file, and give far more seeds than a graph has nodes.
        let drawn = (0..).map(|i| 1 + hash::nth(start, i) % 999_999).find(|s| !taken.contains(s));
        drawn.unwrap_or(1) as u32
    }
}

#[derive(Clone, Copy)]
enum PortSide {
    Input,
    Output,
}

impl PortSide {
    fn ports(self, kind: &Kind) -> &[Port] {
        match self {
            Self::Input => &kind.inputs,
            Self::Output => &kind.outputs,
        }
    }
}
