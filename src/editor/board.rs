//! What the evaluator has found, for the window to look at.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::evaluator::Order;
use super::shade::Look;
use crate::engine::Key;
use crate::graph::{NodeId, Source};
use crate::render::Picture;
use crate::value::{Bounds, Value};

/// How far a node is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NodeState {
    /// It will run.
    Waiting,
    /// It runs; the share that is done.
    Running(f32),
    /// It ran, in so many seconds.
    Done(f64),
    /// It failed; why.
    Failed(String),
}

/// A small picture of a node's first output.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) key: Key,
    pub(crate) picture: Picture,
    /// Lowest and highest value of a field.
    pub(crate) range: Option<(f32, f32)>,
}

/// What a whole view was made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Made {
    pub(crate) state: u64,
    pub(crate) target: Source,
    pub(crate) size: u32,
    pub(crate) look: Look,
}

/// What the view shows.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) value: Value,
    pub(crate) picture: Arc<Picture>,
    /// Whether it is a coarser stand-in for what is being made.
    pub(crate) draft: bool,
    pub(crate) effective_cell: Option<f64>,
    /// The extent of the whole terrain.
    pub(crate) bounds: Bounds,
}

/// An evaluation that was not started.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Held {
    /// Why it cannot be, where it cannot.
    pub(crate) over: Option<String>,
    /// Estimated seconds.
    pub(crate) seconds: f64,
}

/// What was found so far.
#[derive(Debug, Default)]
pub(crate) struct Board {
    /// Counts up with everything that is put on it.
    pub(crate) news: u64,
    pub(crate) busy: bool,
    pub(crate) shown: Option<Shown>,
    /// A part of it, finer.
    pub(crate) detail: Option<Shown>,
    /// What the exact whole view was made for.
    pub(crate) made: Option<Made>,
    /// Counts up with each thing that is shown.
    pub(crate) showings: u64,
    /// Counts up with each finer part.
    pub(crate) details: u64,
    /// The picture of a showing under sun and sky, with cast shadows.
    pub(crate) lit: Option<(u64, Arc<Picture>)>,
    pub(crate) failure: Option<(u64, String)>,
    pub(crate) held: Option<Held>,
    pub(crate) nodes: BTreeMap<NodeId, NodeState>,
    pub(crate) thumbnails: BTreeMap<NodeId, Seen>,
}

impl Board {
    pub(crate) fn begin(&mut self, order: &Order) {
        self.news += 1;
        self.busy = true;
        self.held = None;
        self.failure = None;
        self.nodes.retain(|id, state| {
            // What was given up will be said anew, and so will failures.
            matches!(state, NodeState::Done(_)) && order.graph.get(*id).is_some()
        });
        self.thumbnails.retain(|id, _| order.graph.get(*id).is_some());
        if order.target.is_none() {
            (self.shown, self.detail, self.made) = (None, None, None);
            self.showings += 1;
        }
    }

    pub(crate) fn end(&mut self, whole: bool) {
        self.news += 1;
        self.busy = false;
        if !whole {
            self.nodes.retain(|_, state| !matches!(state, NodeState::Waiting | NodeState::Running(_)));
        }
    }

    pub(crate) fn hold(&mut self, over: Option<String>, seconds: f64) {
        self.news += 1;
        self.held = Some(Held { over, seconds });
    }

    /// Shows a whole view; `made` says what for, when it is exact.
    pub(crate) fn show(&mut self, shown: Shown, made: Option<Made>) {
        self.news += 1;
        self.showings += 1;
        self.failure = None;
        self.shown = Some(shown);
        self.made = made;
        self.detail = None;
    }

    /// Shows a finer part of what is shown.
    pub(crate) fn refine(&mut self, detail: Shown) {
        self.news += 1;
        self.details += 1;
        self.detail = Some(detail);
    }

    /// Takes the lit picture of what is shown.
    pub(crate) fn light(&mut self, picture: Picture) {
        self.news += 1;
        self.lit = Some((self.showings, Arc::new(picture)));
    }

    pub(crate) fn view_fails(&mut self, state: u64, why: String) {
        self.news += 1;
        self.failure = Some((state, why));
    }

    pub(crate) fn node(&mut self, id: NodeId, state: NodeState) {
        self.news += 1;
        self.nodes.insert(id, state);
    }

    pub(crate) fn thumbnail(&mut self, id: NodeId, seen: Seen) {
        self.news += 1;
        self.thumbnails.insert(id, seen);
    }

    /// Whether what is shown is what would be made, lit where that is wanted.
    pub(crate) fn stands(&self, made: &Made, lit: bool) -> bool {
        let is_lit = self.lit.as_ref().is_some_and(|(showing, _)| *showing == self.showings);
        self.failure.is_none() && self.made.as_ref() == Some(made) && (is_lit || !lit)
    }

    /// Whether a node has no picture of its present result.
    pub(crate) fn lacks(&self, id: NodeId, key: Key) -> bool {
        let failed = matches!(self.nodes.get(&id), Some(NodeState::Failed(_)));
        !failed && self.thumbnails.get(&id).is_none_or(|seen| seen.key != key)
    }

    /// Drops the pictures of nodes that have no result now.
    pub(crate) fn keep(&mut self, keys: &BTreeMap<NodeId, Key>) {
        self.thumbnails.retain(|id, _| keys.contains_key(id));
    }
}
