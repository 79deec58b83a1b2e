//! Progress of the nodes of an evaluation.

use std::sync::{Mutex, PoisonError};

use super::board::NodeState;
use crate::engine::{Observer, Plan, PlannedTask};
use crate::graph::{Graph, NodeId};
use crate::value::Value;

/// An output that is looked at while its node runs.
pub(super) struct Watched<'a> {
    pub(super) node: NodeId,
    pub(super) port: &'a str,
    pub(super) take: &'a (dyn Fn(Value) + Sync),
}

/// An observer that reports the state of each node. It serves one evaluation after the other.
pub(super) struct NodeProgress<'a> {
    graph: &'a Graph,
    tell: &'a (dyn Fn(NodeId, NodeState) + Sync),
    /// The node of each task; `None` for tasks whose results are cached.
    tasks: Mutex<Vec<Option<NodeId>>>,
    watched: Option<Watched<'a>>,
}

impl<'a> NodeProgress<'a> {
    pub(super) fn new(graph: &'a Graph, tell: &'a (dyn Fn(NodeId, NodeState) + Sync)) -> Self {
        Self { graph, tell, tasks: Mutex::default(), watched: None }
    }

    /// The same, which also watches an output while its node runs.
    pub(super) fn watching(self, watched: Option<Watched<'a>>) -> Self {
        Self { watched, ..self }
    }

    /// The node of a task.
    fn node(&self, task: usize) -> Option<NodeId> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner).get(task).copied().flatten()
    }

    fn at(&self, task: usize, state: NodeState) {
        if let Some(node) = self.node(task) {
            (self.tell)(node, state);
        }
    }
}

impl Observer for NodeProgress<'_> {
    fn reading(&self, node: &str, _: &str, share: f32) {
        if let Some(node) = self.graph.find(node) {
            (self.tell)(node, NodeState::Running(share));
        }
    }

    fn planned(&self, plan: &Plan) {
        // Tasks with cached results take too little time to be shown.
        let node = |t: &PlannedTask| t.cached.is_none().then(|| self.graph.find(&t.node)).flatten();
        let nodes: Vec<Option<NodeId>> = plan.tasks().iter().map(node).collect();
        nodes.iter().flatten().for_each(|id| (self.tell)(*id, NodeState::Waiting));
        *self.tasks.lock().unwrap_or_else(PoisonError::into_inner) = nodes;
    }

    fn started(&self, task: usize) {
        self.at(task, NodeState::Running(0.0));
    }

    fn progress(&self, task: usize, share: f32) {
        self.at(task, NodeState::Running(share));
    }

    fn looks(&self, task: usize, port: &str) -> bool {
        let node = self.node(task);
        self.watched.as_ref().is_some_and(|watched| Some(watched.node) == node && watched.port == port)
    }

    fn state(&self, _: usize, _: &str, value: Value) {
        if let Some(watched) = &self.watched {
            (watched.take)(value);
        }
    }

    fn finished(&self, task: usize, seconds: f64) {
        self.at(task, NodeState::Done(seconds));
    }
}
