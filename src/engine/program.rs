//! A graph made ready to evaluate: what stands upstream of the wanted nodes, parsed, in topological order, with keys.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use super::error::{Failure, SharedFailure};
use super::key::{Key, Parts};
use super::outputs::Outputs;
use super::plan::Stage;
use super::sources::Sources;
use super::walk::{Inlet, Walk};
use crate::graph::{Graph, GraphNode, NodeId, NodeMap, Place, Problem, Revision};
use crate::name::Name;
use crate::node::{AnyNode, Cancel, Cost, Error, FileRequest, Kind, Reach, SourceFile};
use crate::source;
use crate::value::{Grid, Lattice, Quantity, Terrain};

/// The parsed part of a graph that some wanted nodes need.
#[derive(Debug)]
pub(super) struct Program {
    /// The graph that it was made of.
    revision: Revision,
    pub terrain: Terrain,
    /// The files as they were looked at.
    pub sources: Arc<Sources>,
    /// In topological order; a step that failed stands for all that need it.
    pub steps: Vec<Result<Step, SharedFailure>>,
    /// The node of each step.
    nodes: Vec<NodeId>,
    index: NodeMap<usize>,
    /// The steps that the wires of each step lead to, also where it does not use them: one step after the other, with the
    /// end of each.
    wires: Vec<usize>,
    ends: Vec<usize>,
    /// Whether programs of the same graph can be parts of it: no kind names files, which may have changed since, and no
    /// cycle says which of its nodes were reached first.
    is_divisible: bool,
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
    /// What it reads; none while the content of a file is not known.
    sources: Option<Vec<KeyedInput>>,
    pub kind: Arc<Kind>,
    pub node: Arc<dyn AnyNode>,
    pub reach: Reach,
    pub files: Vec<Arc<SourceFile>>,
    /// What the numbers of each output mean.
    quantities: Vec<Option<Quantity>>,
    /// None while the content of a file upstream is not known.
    pub key: Option<Key>,
    reading: OnceLock<Cost>,
    /// The result that was asked for first, and its key: the next plan most often asks for the same.
    first: OnceLock<(Asked, Key)>,
}

/// Which result of a node is asked for: the stage that makes it, the outputs that are read, and the lattice.
type Asked = (Stage, Outputs, Lattice);

/// What an input reads: its name, the key of the source and the output of the source.
type KeyedInput = (Name, Key, Name);
/// The same, borrowed; the key is not known while the content of a file is not.
type Keyed<'a> = (&'a Name, Option<Key>, &'a Name);

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
    fn serves<'a>(&'a self, origin: &Arc<GraphNode>, sources: impl Iterator<Item = Keyed<'a>>) -> bool {
        let Some(own) = &self.sources else { return false };
        let own = own.iter().map(|(port, key, from)| (port, Some(*key), from));
        Arc::ptr_eq(&self.origin, origin) && !self.kind.names_files() && own.eq(sources)
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

    /// The key of a result, which is hashed where it is not that of the result that was asked for first.
    pub(super) fn key_on(&self, asked: Asked, hash: impl Fn() -> Key) -> Key {
        let (first, key) = self.first.get_or_init(|| (asked, hash()));
        if *first == asked { *key } else { hash() }
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

    /// The step in a program in which the steps have other places.
    fn moved(&self, places: &[usize]) -> Self {
        let moved = |input: &Input| Input { step: places[input.step], ..input.clone() };
        Self { inputs: self.inputs.iter().map(moved).collect(), own: self.own.clone() }
    }
}

impl Program {
    /// Makes what some nodes need ready; nothing when it is cancelled. No content of a file is read. What is as it was in
    /// one of the earlier programs is taken over from there.
    pub(super) fn new(
        graph: &Graph,
        wanted: &[NodeId],
        sources: Arc<Sources>,
        earlier: &[Arc<Self>],
        cancel: &Cancel,
    ) -> Option<Self> {
        let walk = Walk::new(graph, wanted);
        let earlier: Vec<_> = earlier.iter().filter(|p| p.terrain == *graph.terrain()).collect();
        let mut program = Self::empty(graph.revision(), graph.terrain(), sources, walk.order.len());
        program.is_divisible = walk.cyclic.is_empty();
        for &place in &walk.order {
            if cancel.is_cancelled() {
                return None;
            }
            let (id, inlets) = (walk.node(place), walk.inlets(place));
            let step = if walk.cyclic.contains(&place) {
                let message = format!("node `{}` is part of a cycle", graph.node(id).name);
                Err(Arc::new(Failure::Graph(message)))
            } else {
                program.step(graph, id, inlets, &earlier)
            };
            let kind = graph.get(id).and_then(|node| node.kind());
            program.is_divisible &= !kind.is_some_and(|kind| kind.names_files());
            for source in inlets.iter().filter_map(|inlet| inlet.source.as_ref()) {
                program.wires.extend(program.index.get(&source.node));
            }
            program.push(id, step);
        }
        Some(program)
    }

    fn empty(revision: Revision, terrain: &Terrain, sources: Arc<Sources>, len: usize) -> Self {
        Self {
            revision,
            terrain: terrain.clone(),
            sources,
            steps: Vec::with_capacity(len),
            nodes: Vec::with_capacity(len),
            index: NodeMap::with_capacity_and_hasher(len, <_>::default()),
            wires: Vec::with_capacity(len),
            ends: Vec::with_capacity(len),
            is_divisible: false,
        }
    }

    /// Adds a step, after its wires were added.
    fn push(&mut self, id: NodeId, step: Result<Step, SharedFailure>) {
        self.index.insert(id, self.steps.len());
        self.steps.push(step);
        self.nodes.push(id);
        self.ends.push(self.wires.len());
    }

    /// The steps that the wires of a step lead to.
    fn wires(&self, step: usize) -> &[usize] {
        let first = step.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.wires[first..self.ends[step]]
    }

    /// The program of some nodes of the same graph, as [`new`](Self::new) would make it; `None` where this one does not
    /// have it.
    pub(super) fn part(
        self: &Arc<Self>,
        graph: &Graph,
        wanted: &[NodeId],
        sources: &Arc<Sources>,
    ) -> Option<Arc<Self>> {
        if !self.is_divisible || self.revision != graph.revision() {
            return None;
        }
        let wanted: Vec<usize> = wanted.iter().map(|id| self.find(*id)).collect::<Option<_>>()?;
        let order = self.upstream(&wanted);
        if order.iter().copied().eq(0..self.steps.len()) {
            return Some(self.clone());
        }
        let mut part = Self::empty(self.revision, &self.terrain, sources.clone(), order.len());
        let mut places = vec![0; self.steps.len()];
        for (place, i) in order.into_iter().enumerate() {
            places[i] = place;
            let step = self.steps[i].as_ref().map(|step| step.moved(&places)).map_err(Arc::clone);
            part.wires.extend(self.wires(i).iter().map(|wire| places[*wire]));
            part.push(self.nodes[i], step);
        }
        part.is_divisible = true;
        Some(Arc::new(part))
    }

    /// Some steps and those upstream of them, sources first, in the order in which a [`Walk`] leaves them.
    fn upstream(&self, wanted: &[usize]) -> Vec<usize> {
        let (mut order, mut is_entered) = (Vec::new(), vec![false; self.steps.len()]);
        let mut stack: Vec<(usize, usize)> = Vec::new();
        for &root in wanted {
            if !std::mem::replace(&mut is_entered[root], true) {
                stack.push((root, 0));
            }
            while let Some((step, followed)) = stack.last_mut() {
                let Some(&next) = self.wires(*step).get(*followed) else {
                    order.push(*step);
                    stack.pop();
                    continue;
                };
                *followed += 1;
                if !std::mem::replace(&mut is_entered[next], true) {
                    stack.push((next, 0));
                }
            }
        }
        order
    }

    /// Whether another program is of the same graph.
    pub(super) fn is_of_graph(&self, other: &Self) -> bool {
        self.revision == other.revision
    }

    /// Whether another program has all nodes of this one, in the same terrain.
    pub(super) fn is_within(&self, other: &Self) -> bool {
        self.terrain == other.terrain && self.nodes.iter().all(|id| other.find(*id).is_some())
    }

    /// The grid on which a step gives its result when it is asked for on another: a gridless one has none.
    pub(super) fn place(&self, step: usize, grid: Grid) -> Grid {
        let gridless = self.steps[step].as_ref().is_ok_and(|s| s.reach == Reach::Gridless);
        if gridless { Grid::NOWHERE } else { grid }
    }

    pub(super) fn find(&self, id: NodeId) -> Option<usize> {
        self.index.get(&id).copied()
    }

    /// The node of a step.
    pub(super) fn node(&self, step: usize) -> Option<NodeId> {
        self.nodes.get(step).copied()
    }

    /// The step of a node, where it is ready.
    fn ready(&self, id: NodeId) -> Option<&Arc<Ready>> {
        Some(&self.steps[self.find(id)?].as_ref().ok()?.own)
    }

    fn step(
        &self,
        graph: &Graph,
        id: NodeId,
        inlets: &[Inlet],
        earlier: &[&Arc<Self>],
    ) -> Result<Step, SharedFailure> {
        let origin = graph.shared(id).ok_or_else(|| Arc::new(Failure::Graph("a node is gone".to_owned())))?;
        let name = &origin.name;
        let wrong = |error: Error| Arc::new(Failure::of_document(name, error));
        let node = origin.parse().map_err(wrong)?;
        let unknown = || Arc::new(Failure::Graph(format!("node `{name}` is of an unknown kind")));
        let kind = origin.kind().ok_or_else(unknown)?;
        let inputs = self.inputs(graph, id, inlets, kind, &*node).map_err(|e| match e {
            InputFault::Here(error) => wrong(error),
            InputFault::Upstream(shared) => shared,
        })?;
        let known = earlier.iter().find_map(|program| program.ready(id));
        if let Some(own) = known.filter(|own| own.serves(origin, self.keyed(&inputs))) {
            return Ok(Step { inputs, own: own.clone() });
        }
        let sources = self.sources_of(&inputs);
        let requests = node.files();
        let nothing_asked = requests.is_empty();
        let found = self.sources.find(&requests).map_err(wrong)?;
        let parameters = origin.digest().map_err(wrong)?;
        let key =
            self.key((kind, &*node, &parameters), sources.as_deref(), requests, &found).map_err(wrong)?;
        let (reach, files) = (node.reach(), found.into_iter().flatten().collect::<Vec<_>>());
        let (reading, first) = (OnceLock::new(), OnceLock::new());
        // What is wrong with a header shows before anybody goes through the content to know it, and so does a file that is
        // not chosen yet.
        let none = nothing_asked && kind.names_files();
        if none || files.iter().any(|f: &Arc<SourceFile>| f.known_hash().is_none()) {
            let _ = reading.set(node.reading(&files).map_err(wrong)?);
        }
        let quantities = self.quantities(kind, &*node, &inputs);
        let (origin, kind) = (origin.clone(), kind.clone());
        let own =
            Arc::new(Ready { origin, sources, kind, node, reach, files, quantities, key, reading, first });
        Ok(Step { inputs, own })
    }

    fn quantities(&self, kind: &Kind, node: &dyn AnyNode, inputs: &[Input]) -> Vec<Option<Quantity>> {
        let read = |port: &str| {
            let input = inputs.iter().find(|i| i.port == port)?;
            self.steps[input.step].as_ref().ok()?.quantity(&input.from)
        };
        kind.outputs.iter().map(|p| kind.quantity(Some(node), &p.name, &read)).collect()
    }

    /// What inputs read, by key.
    fn keyed<'a>(&'a self, inputs: &'a [Input]) -> impl Iterator<Item = Keyed<'a>> {
        let key = |input: &Input| self.steps[input.step].as_ref().ok()?.key;
        inputs.iter().map(move |input| (&input.port, key(input), &input.from))
    }

    /// What inputs read, by key; none while the content of a file above is not known.
    fn sources_of(&self, inputs: &[Input]) -> Option<Vec<KeyedInput>> {
        self.keyed(inputs).map(|(port, key, from)| Some((port.clone(), key?, from.clone()))).collect()
    }

    /// The key of a node; none while the content of a file is not known.
    fn key(
        &self,
        (kind, node, parameters): (&Kind, &dyn AnyNode, &[u8; 32]),
        sources: Option<&[KeyedInput]>,
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
        inlets: &[Inlet],
        kind: &Kind,
        node: &dyn AnyNode,
    ) -> Result<Vec<Input>, InputFault> {
        let mut inputs = Vec::with_capacity(inlets.len());
        for (i, port) in kind.inputs.iter().enumerate().filter(|(_, p)| kind.uses(node, &p.name)) {
            let missing = || InputFault::Here(Error::Missing { port: port.name.clone() });
            let inlet = inlets.iter().find(|inlet| inlet.port == i);
            if inlet.is_none() && graph.node(id).unresolved().any(|(p, _)| port.name == p) {
                let failure = Failure::Graph(loose_wire(graph, id, &port.name));
                return Err(InputFault::Upstream(Arc::new(failure)));
            }
            let Some(source) = inlet.and_then(|inlet| inlet.source.as_ref()) else {
                if port.required {
                    return Err(missing());
                }
                continue;
            };
            let step = self.find(source.node).ok_or_else(missing)?;
            match &self.steps[step] {
                Ok(read) => {
                    let (port, from) = (port.name.clone(), source.port.clone());
                    inputs.push(Input { read: Outputs::one(&read.kind, &from), port, step, from });
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
