//! Undo and redo: the states of the document, each with the name of the change that led to it.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::graph::Graph;

/// Estimated bytes that all states together may take.
const BUDGET: usize = 256 << 20;
/// Estimated bytes of a state without its nodes, and of a node without its parameters.
const STATE: usize = 20_000;
const NODE: usize = 1500;
/// States that are kept even if they exceed the budget.
const KEPT: usize = 20;
/// The most states that are kept.
const MOST: usize = 1000;

/// A state of the document.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// A number that rises with each new state and is never used twice.
    pub(crate) id: u64,
    /// The name of the change that led to the state.
    pub(crate) label: String,
    pub(crate) graph: Arc<Graph>,
    /// Estimated bytes of the graph.
    bytes: usize,
}

impl State {
    fn new(id: u64, label: &str, graph: Graph) -> Self {
        let node = |id| NODE + graph.get(id).map_or(0, |n| n.set.bytes());
        let bytes = STATE + graph.nodes().map(node).sum::<usize>();
        Self { id, label: label.to_owned(), graph: Arc::new(graph), bytes }
    }
}

/// The states of a document and the current one among them.
#[derive(Debug)]
pub(crate) struct History {
    states: VecDeque<State>,
    at: usize,
    next: u64,
    /// The gesture in progress, whose edits become one state.
    gesture: Option<String>,
}

impl History {
    pub(crate) fn new(graph: Graph, label: &str) -> Self {
        let first = State::new(0, label, graph);
        Self { states: VecDeque::from([first]), at: 0, next: 1, gesture: None }
    }

    pub(crate) fn current(&self) -> &State {
        &self.states[self.at]
    }

    /// Adds a state after the current one and drops the undone ones. Within a gesture it replaces the last state.
    pub(crate) fn push(&mut self, label: &str, gesture: Option<&str>, graph: Graph) {
        let goes_on = gesture.is_some() && gesture == self.gesture.as_deref();
        self.states.truncate(self.at + 1);
        if goes_on && self.at > 0 {
            self.states.pop_back();
        }
        let state = State::new(self.next, label, graph);
        self.next += 1;
        self.states.push_back(state);
        self.at = self.states.len() - 1;
        self.gesture = gesture.map(str::to_owned);
        self.shrink();
    }

    /// Ends a gesture, so that the next edit becomes a state of its own.
    pub(crate) fn end_gesture(&mut self) {
        self.gesture = None;
    }

    pub(crate) fn can_undo(&self) -> bool {
        self.at > 0
    }

    /// The name of the change that undo would revert.
    pub(crate) fn undo_label(&self) -> Option<&str> {
        self.can_undo().then(|| self.current().label.as_str())
    }

    /// The name of the change that redo would make again.
    pub(crate) fn redo_label(&self) -> Option<&str> {
        self.states.get(self.at + 1).map(|s| s.label.as_str())
    }

    /// Makes the state at an index the current one; returns false where there is none or it is current.
    pub(crate) fn go(&mut self, to: usize) -> bool {
        let there = to < self.states.len() && to != self.at;
        if there {
            self.at = to;
            self.end_gesture();
        }
        there
    }

    pub(crate) fn undo(&mut self) -> bool {
        self.at.checked_sub(1).is_some_and(|to| self.go(to))
    }

    pub(crate) fn redo(&mut self) -> bool {
        self.go(self.at + 1)
    }

    /// All states, oldest first, and the index of the current one.
    pub(crate) fn list(&self) -> (impl ExactSizeIterator<Item = &State>, usize) {
        (self.states.iter(), self.at)
    }

    fn shrink(&mut self) {
        let mut bytes: usize = self.states.iter().map(|s| s.bytes).sum();
        while (bytes > BUDGET || self.states.len() > MOST) && self.states.len() > KEPT && self.at > 0 {
            bytes -= self.states.pop_front().map_or(0, |s| s.bytes);
            self.at -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_states_are_fewer_and_some_always_stay() {
        let mut graph = Graph::new();
        let mask = graph.add("mask", "paint_mask").expect("adds");
        let path: Vec<f64> = (0..8000).map(f64::from).collect();
        let strokes: Vec<_> = (0..250).map(|_| serde_json::json!({ "path": path })).collect();
        graph.set(mask, "strokes", strokes.into()).expect("sets");
        let mut history = History::new(graph.clone(), "first");
        for k in 0..100 {
            history.push(&format!("{k}"), None, graph.clone());
        }
        let (states, at) = history.list();
        assert_eq!((states.len(), at), (KEPT, KEPT - 1));
        let mut small = History::new(Graph::new(), "first");
        (0..100).for_each(|k| small.push(&format!("{k}"), None, Graph::new()));
        assert_eq!(small.list().0.len(), 101);
    }
}
