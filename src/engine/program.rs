//! A graph made ready to evaluate: what stands upstream of the wanted nodes, parsed, in topological order, with keys.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use super::error::{Failure, SharedFailure};
use super::key::{Key, Parts};
use super::outputs::Outputs;
use super::prepared::Prepared;
use super::sources::Sources;
use crate::graph::{Graph, GraphNode, NodeId, Place, Problem};
use crate::name::Name;
use crate::node::{AnyNode, Cancel, Cost, Error, FileRequest, Kind, Reach, SourceFile};
use crate::source;
use crate::value::{Grid, Quantity, Terrain};

/// The parsed part of a graph that some wanted nodes need.
#[derive(Debug)]
pub(super) struct Program {
    pub terrain: Terrain,
    /// The files as they were looked at.
    pub sources: Arc<Sources>,
    /// In topological order; a step that failed stands for all that need it.
    pub steps: Vec<Result<Step, SharedFailure>>,
    index: BTreeMap<NodeId, usize>,
}

/// A node ready to run, with what it reads.
#[derive(Debug)]
pub(super) struct Step {
    pub inputs: Vec<Input>,
    own: Arc<Ready>,
}

impl Deref for Step {
    type Target = Ready;

    fn deref(&self) -> &Ready {
        &self.own
    }
}

/// A node ready to run, wherever it stands in a program; the next program has it again while nothing changed that it
/// depends on.
#[derive(Debug)]
pub(super) struct Ready {
    /// The node of the graph that it was made of.
    origin: Arc<GraphNode>,
    /// What it reads: its input, the key of the source and its output; none while the content of a file is not known.
    sources: Option<Vec<(Name, Key, Name)>>,
    pub kind: Arc<Kind>,
    pub node: Arc<dyn AnyNode>,
    pub reach: Reach,
    pub files: Vec<Arc<SourceFile>>,
    /// What the numbers of each output mean.
    quantities: Vec<Option<Quantity>>,
    /// None while the content of a file upstream is not known.
    pub key: Option<Key>,
    reading: OnceLock<Cost>,
}

/// A connected input that matters to the result.
#[derive(Clone, Debug)]
pub(super) struct Input {
    pub port: Name,
    /// The step it reads, and which of its outputs.
    pub step: usize,
    pub from: Name,
    pub read: Outputs,
}

impl Ready {
    /// The name of the node.
    pub(super) fn name(&self) -> &str {
        &self.origin.name
    }

    /// Whether it is what would be made of a node that reads some sources. Files may have changed since.
    fn serves(&self, origin: &Arc<GraphNode>, sources: Option<&[(Name, Key, Name)]>) -> bool {
        let same = sources.is_some() && self.sources.as_deref() == sources;
        same && Arc::ptr_eq(&self.origin, origin) && !self.kind.names_files()
    }

    /// What reading its files takes; headers are looked at once. Of files that cannot be read it is the content: the
    /// run says what is wrong with them.
    pub(super) fn reading(&self) -> Cost {
        if self.files.is_empty() {
            return Cost::default();
        }
        let content = |_| source::reading(&self.files);
        *self.reading.get_or_init(|| self.node.reading(&self.files).unwrap_or_else(content))
    }

    /// Its files whose content is not known.
    pub(super) fn unread(&self) -> impl Iterator<Item = &Arc<SourceFile>> {
        self.files.iter().filter(|f| f.known_hash().is_none())
    }

    /// What the numbers of an output mean; `None` where it has none.
    pub(super) fn quantity(&self, output: &str) -> Option<Quantity> {
        let i = self.kind.outputs.iter().position(|p| p.name == output)?;
        self.quantities[i]
    }
}

impl Step {
    /// The input of a name, by its place among the inputs.
    pub(super) fn index(&self, port: &str) -> Option<usize> {
        self.inputs.iter().position(|i| i.port == port)
    }

    pub(super) fn input(&self, port: &str) -> Option<&Input> {
        self.index(port).map(|i| &self.inputs[i])
    }
}

impl Program {
    /// Makes what some nodes need ready; nothing when it is cancelled. No content of a file is read. What is as it was in
    /// an earlier program is taken over from there.
    pub(super) fn new(
        graph: &Graph,
        wanted: &[NodeId],
        sources: Arc<Sources>,
        prepared: &Prepared,
        cancel: &Cancel,
    ) -> Option<Self> {
        let terrain = graph.terrain().clone();
        let mut program = Self { terrain, sources, steps: Vec::new(), index: BTreeMap::new() };
        let (order, cyclic) = upstream(graph, wanted);
        for id in order {
            if cancel.is_cancelled() {
                return None;
            }
            let step = if cyclic.contains(&id) {
                let message = format!("node `{}` is part of a cycle", graph.node(id).name);
                Err(Arc::new(Failure::Graph(message)))
            } else {
                program.step(graph, id, prepared)
            };
            program.index.insert(id, program.steps.len());
            program.steps.push(step);
        }
        Some(program)
    }

    /// The grid on which a step gives its result when it is asked for on another: a gridless one has none.
    pub(super) fn place(&self, step: usize, grid: Grid) -> Grid {
        let gridless = self.steps[step].as_ref().is_ok_and(|s| s.reach == Reach::Gridless);
        if gridless { Grid::NOWHERE } else { grid }
    }

    /// The nodes that are ready.
    pub(super) fn ready(&self) -> impl Iterator<Item = (NodeId, Arc<Ready>)> {
        let ready = |(id, step): (&NodeId, &usize)| Some((*id, self.steps[*step].as_ref().ok()?.own.clone()));
        self.index.iter().filter_map(ready)
    }

    pub(super) fn find(&self, id: NodeId) -> Option<usize> {
        self.index.get(&id).copied()
    }

    /// The node of a step.
    pub(super) fn node(&self, step: usize) -> Option<NodeId> {
        self.index.iter().find(|(_, i)| **i == step).map(|(id, _)| *id)
    }

    fn step(&self, graph: &Graph, id: NodeId, prepared: &Prepared) -> Result<Step, SharedFailure> {
        let origin = graph.shared(id).ok_or_else(|| Arc::new(Failure::Graph("a node is gone".to_owned())))?;
        let name = &origin.name;
        let wrong = |error: Error| Arc::new(Failure::of_document(name, error));
        let node = origin.parse().map_err(wrong)?;
        let unknown = || Arc::new(Failure::Graph(format!("node `{name}` is of an unknown kind")));
        let kind = origin.kind().ok_or_else(unknown)?;
        let inputs = self.inputs(graph, id, kind, &*node).map_err(|e| match e {
            InputFault::Here(error) => wrong(error),
            InputFault::Upstream(shared) => shared,
        })?;
        let sources = self.sources_of(&inputs);
        let known = prepared.get(&self.terrain, id);
        if let Some(own) = known.filter(|known| known.serves(origin, sources.as_deref())) {
            return Ok(Step { inputs, own });
        }
        let requests = node.files();
        let nothing_asked = requests.is_empty();
        let found = self.sources.find(&requests).map_err(wrong)?;
        let parameters = origin.digest().map_err(wrong)?;
        let key =
            self.key((kind, &*node, &parameters), sources.as_deref(), requests, &found).map_err(wrong)?;
        let (reach, files) = (node.reach(), found.into_iter().flatten().collect::<Vec<_>>());
        let reading = OnceLock::new();
        // What is wrong with a header shows before anybody goes through the content to know it, and so does a file that is
        // not chosen yet.
        let none = nothing_asked && kind.names_files();
        if none || files.iter().any(|f: &Arc<SourceFile>| f.known_hash().is_none()) {
            let _ = reading.set(node.reading(&files).map_err(wrong)?);
        }
        let quantities = self.quantities(kind, &*node, &inputs);
        let (origin, kind) = (origin.clone(), kind.clone());
        let own = Arc::new(Ready { origin, sources, kind, node, reach, files, quantities, key, reading });
        Ok(Step { inputs, own })
    }

    fn quantities(&self, kind: &Kind, node: &dyn AnyNode, inputs: &[Input]) -> Vec<Option<Quantity>> {
        let read = |port: &str| {
            let input = inputs.iter().find(|i| i.port == port)?;
            self.steps[input.step].as_ref().ok()?.quantity(&input.from)
        };
        kind.outputs.iter().map(|p| kind.quantity(Some(node), &p.name, &read)).collect()
    }

    /// What inputs read, by key; none while the content of a file above is not known.
    fn sources_of(&self, inputs: &[Input]) -> Option<Vec<(Name, Key, Name)>> {
        let key = |input: &Input| self.steps[input.step].as_ref().ok()?.key;
        inputs.iter().map(|input| Some((input.port.clone(), key(input)?, input.from.clone()))).collect()
    }

    /// The key of a node; none while the content of a file is not known.
    fn key(
        &self,
        (kind, node, parameters): (&Kind, &dyn AnyNode, &[u8; 32]),
        sources: Option<&[(Name, Key, Name)]>,
        requests: Vec<FileRequest>,
        found: &[Option<Arc<SourceFile>>],
    ) -> Result<Option<Key>, Error> {
        let mut files = Vec::new();
        for (request, file) in requests.into_iter().zip(found) {
            let content = match file.as_ref().map(|f| f.known_hash()) {
                None => None,
                Some(None) => return Ok(None),
                Some(Some(hash)) => Some(hash.map_err(|e| e.of(request.parameter, &request.name))?),
            };
            files.push((request, content));
        }
        let terrain = &self.terrain;
        Ok(sources.map(|inputs| Parts { kind, node, parameters, terrain, inputs, files: &files }.key()))
    }

    fn inputs(
        &self,
        graph: &Graph,
        id: NodeId,
        kind: &Kind,
        node: &dyn AnyNode,
    ) -> Result<Vec<Input>, InputFault> {
        let mut inputs = Vec::new();
        for port in kind.inputs.iter().filter(|p| kind.uses(node, &p.name)) {
            let Some(source) = graph.source(id, &port.name) else {
                if graph.node(id).unresolved().any(|(p, _)| port.name == p) {
                    return Err(InputFault::Upstream(Arc::new(Failure::Graph(loose_wire(
                        graph, id, &port.name,
                    )))));
                }
                if port.required {
                    return Err(InputFault::Here(Error::Missing { port: port.name.clone() }));
                }
                continue;
            };
            let Some(source) = graph.passed(source) else {
                if port.required {
                    return Err(InputFault::Here(Error::Missing { port: port.name.clone() }));
                }
                continue;
            };
            let step = self.index.get(&source.node).copied();
            let step = step.ok_or(InputFault::Here(Error::Missing { port: port.name.clone() }))?;
            match &self.steps[step] {
                Ok(read) => {
                    let read = Outputs::one(&read.kind, &source.port);
                    inputs.push(Input { port: port.name.clone(), step, from: source.port, read });
                }
                Err(shared) => return Err(InputFault::Upstream(shared.clone())),
            }
        }
        Ok(inputs)
    }
}

/// What the document says of a wire that does not resolve.
fn loose_wire(graph: &Graph, id: NodeId, port: &str) -> String {
    let here = |p: &Problem| {
        p.blames() == Some(id) && matches!(&p.place, Place::Input { port: name, .. } if name == port)
    };
    let problem = graph.problems().into_iter().find(here);
    problem.map_or_else(
        || format!("node `{}`, input `{port}`: leads nowhere", graph.node(id).name),
        |p| p.to_string(),
    )
}

enum InputFault {
    Here(Error),
    Upstream(SharedFailure),
}

/// The nodes upstream of some nodes, sources first, and those of them that stand on a cycle.
fn upstream(graph: &Graph, wanted: &[NodeId]) -> (Vec<NodeId>, BTreeSet<NodeId>) {
    let (mut order, mut cyclic) = (Vec::new(), BTreeSet::new());
    let (mut entered, mut left) = (BTreeSet::new(), BTreeSet::new());
    // An explicit stack: a chain of ten thousand nodes is a fair graph.
    let mut stack: Vec<(NodeId, Vec<NodeId>)> = Vec::new();
    for &root in wanted {
        if entered.insert(root) {
            stack.push((root, sources(graph, root)));
        }
        while let Some((id, pending)) = stack.last_mut() {
            let id = *id;
            match pending.pop() {
                Some(next) if entered.insert(next) => stack.push((next, sources(graph, next))),
                Some(next) if !left.contains(&next) => {
                    let start = stack.iter().position(|(n, _)| *n == next).unwrap_or(0);
                    cyclic.extend(stack[start..].iter().map(|(n, _)| *n));
                }
                Some(_) => (),
                None => {
                    left.insert(id);
                    order.push(id);
                    stack.pop();
                }
            }
        }
    }
    (order, cyclic)
}

fn sources(graph: &Graph, id: NodeId) -> Vec<NodeId> {
    let Some(kind) = graph.node(id).kind() else { return Vec::new() };
    let source = |port: &str| Some(graph.passed(graph.source(id, port)?)?.node);
    let mut nodes: Vec<_> = kind.inputs.iter().filter_map(|p| source(&p.name)).collect();
    nodes.reverse();
    nodes
}
