//! Undo and redo: every state of the document, with what led to it.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::graph::Graph;

/// Bytes that all states together may take, by estimate.
const BUDGET: usize = 256 << 20;
/// Estimated bytes of a node in a state.
const NODE: usize = 1500;
/// Fewest states that are kept whatever they take.
const KEPT: usize = 20;
/// Most states that are kept.
const MOST: usize = 1000;

/// A state of the document.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Counts up over the life of the document; never used twice.
    pub(crate) id: u64,
    /// What led to it.
    pub(crate) label: String,
    pub(crate) graph: Arc<Graph>,
}

/// The states of a document and which of them is shown.
#[derive(Debug)]
pub(crate) struct History {
    states: VecDeque<State>,
    at: usize,
    next: u64,
    /// The gesture whose edits become one state, while it lasts.
    gesture: Option<String>,
}

impl History {
    pub(crate) fn new(graph: Graph, label: &str) -> Self {
        let first = State { id: 0, label: label.to_owned(), graph: Arc::new(graph) };
        Self { states: VecDeque::from([first]), at: 0, next: 1, gesture: None }
    }

    pub(crate) fn current(&self) -> &State {
        &self.states[self.at]
    }

    /// Enters a new state; what was undone is gone. Of one gesture only the last state stays.
    pub(crate) fn push(&mut self, label: &str, gesture: Option<&str>, graph: Graph) {
        let goes_on = gesture.is_some() && gesture == self.gesture.as_deref();
        self.states.truncate(self.at + 1);
        if goes_on && self.at > 0 {
            self.states.pop_back();
        }
        let state = State { id: self.next, label: label.to_owned(), graph: Arc::new(graph) };
        self.next += 1;
        self.states.push_back(state);
        self.at = self.states.len() - 1;
        self.gesture = gesture.map(str::to_owned);
        self.shrink();
    }

    /// Ends a gesture: the next edit is a state of its own.
    pub(crate) fn rest(&mut self) {
        self.gesture = None;
    }

    pub(crate) fn can_undo(&self) -> bool {
        self.at > 0
    }

    /// What undoing would take back.
    pub(crate) fn undo_label(&self) -> Option<&str> {
        self.can_undo().then(|| self.current().label.as_str())
    }

    /// What redoing would do again.
    pub(crate) fn redo_label(&self) -> Option<&str> {
        self.states.get(self.at + 1).map(|s| s.label.as_str())
    }

    /// Shows another state; false where there is none.
    pub(crate) fn go(&mut self, to: usize) -> bool {
        let there = to < self.states.len() && to != self.at;
        if there {
            self.at = to;
            self.rest();
        }
        there
    }

    pub(crate) fn undo(&mut self) -> bool {
        self.at.checked_sub(1).is_some_and(|to| self.go(to))
    }

    pub(crate) fn redo(&mut self) -> bool {
        self.go(self.at + 1)
    }

    /// All states, oldest first, and which is shown.
    pub(crate) fn list(&self) -> (impl ExactSizeIterator<Item = &State>, usize) {
        (self.states.iter(), self.at)
    }

    fn shrink(&mut self) {
        let one = 20_000 + NODE * self.current().graph.nodes().len();
        let room = (BUDGET / one).clamp(KEPT, MOST);
        while self.states.len() > room && self.at > 0 {
            self.states.pop_front();
            self.at -= 1;
        }
    }
}
