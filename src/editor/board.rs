//! What the evaluator has found, for the window to look at.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::evaluator::Order;
use super::shade::{Light, Look};
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
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Made {
    pub(crate) state: u64,
    pub(crate) scene: Scenery,
}

/// What a view is made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scenery {
    pub(crate) target: Source,
    /// What it is compared with.
    pub(crate) against: Option<Source>,
    /// What colours it.
    pub(crate) drape: Option<Source>,
    /// A mask that is being painted: shown as a tint over all.
    pub(crate) tint: Option<Source>,
    /// Samples along the longer side.
    pub(crate) size: u32,
    pub(crate) look: Look,
}

/// What a build would take.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) of: Measured,
    /// Seconds on all cores.
    pub(crate) seconds: f64,
    /// Bytes at the peak.
    pub(crate) bytes: u64,
    /// Why it would be refused.
    pub(crate) over: Option<String>,
}

/// A build that is to be estimated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    pub(crate) state: u64,
    pub(crate) outputs: Vec<String>,
    pub(crate) size: u32,
}

/// What the view shows.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    /// Another for each in this process: tells whether a view or a device has it already.
    pub(crate) id: u64,
    pub(crate) value: Value,
    pub(crate) picture: Arc<Picture>,
    /// Whether it is a coarser stand-in for what is being made.
    pub(crate) draft: bool,
    pub(crate) effective_cell: Option<f64>,
    /// The extent of the whole terrain.
    pub(crate) bounds: Bounds,
}

impl Shown {
    /// A number for something new.
    pub(crate) fn next_id() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }
}

/// An evaluation that was not started.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Held {
    /// Where it is over the budget of memory: why, and the bytes that it needs.
    pub(crate) over: Option<(String, u64)>,
    /// Estimated seconds.
    pub(crate) seconds: f64,
    /// Bytes of files that must be read before it is known what they hold.
    pub(crate) unread: u64,
}

/// Pictures under sun and sky, with cast shadows.
#[derive(Clone, Debug)]
pub(crate) struct Lit {
    /// The showing that they are of, and what it was made of.
    pub(crate) showing: u64,
    scene: Option<Scenery>,
    /// Another for each picture.
    pub(crate) number: u64,
    pub(crate) light: Light,
    pub(crate) picture: Arc<Picture>,
    pub(crate) against: Option<Arc<Picture>>,
}

/// What was found so far.
#[derive(Debug, Default)]
pub(crate) struct Board {
    /// Counts up with everything that is put on it.
    pub(crate) news: u64,
    pub(crate) busy: bool,
    pub(crate) shown: Option<Shown>,
    /// What it is compared with.
    pub(crate) against: Option<Shown>,
    /// A part of it, finer.
    pub(crate) detail: Option<Shown>,
    /// What it is made of.
    scene: Option<Scenery>,
    /// What the exact whole view was made for.
    pub(crate) made: Option<Made>,
    /// Counts up with each thing that is shown.
    pub(crate) showings: u64,
    /// The picture of a showing under a light, and of what it is compared with.
    pub(crate) lit: Option<Lit>,
    /// The showing that cannot be lit, and the light that was asked for.
    dark: Option<(u64, Light)>,
    pub(crate) estimate: Option<Estimate>,
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
        if order.scene.is_none() {
            (self.shown, self.against, self.detail, self.made) = (None, None, None, None);
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

    pub(crate) fn hold(&mut self, held: Held) {
        self.news += 1;
        self.held = Some(held);
    }

    /// Shows a whole view of a scene; `made` says what for, when it is exact.
    pub(crate) fn show(&mut self, scene: Scenery, shown: Shown, against: Option<Shown>, made: Option<Made>) {
        self.news += 1;
        self.showings += 1;
        self.failure = None;
        (self.shown, self.against, self.scene) = (Some(shown), against, Some(scene));
        self.made = made;
        self.detail = None;
    }

    /// Shows a finer part of what is shown.
    pub(crate) fn refine(&mut self, detail: Shown) {
        self.news += 1;
        self.detail = Some(detail);
    }

    /// Takes the lit pictures of what is shown and of what it is compared with; none where it cannot be lit.
    pub(crate) fn take_light(&mut self, light: Light, lit: Option<(Picture, Option<Picture>)>) {
        self.news += 1;
        let (showing, number) = (self.showings, self.news);
        match lit {
            None => self.dark = Some((showing, light)),
            Some((picture, against)) => {
                let (picture, against) = (Arc::new(picture), against.map(Arc::new));
                self.lit = Some(Lit { showing, scene: self.scene.clone(), number, light, picture, against });
            }
        }
    }

    /// Whether what is shown is lit by a light, or cannot be.
    pub(crate) fn is_lit(&self, light: Light) -> bool {
        self.dark == Some((self.showings, light)) || self.lit_now().is_some_and(|lit| lit.light == light)
    }

    /// The lit pictures of what is shown now.
    pub(crate) fn lit_now(&self) -> Option<&Lit> {
        self.lit.as_ref().filter(|lit| lit.showing == self.showings)
    }

    /// The lit pictures to show: those of what is shown now, else those of the same scene a moment ago, so that the
    /// light does not go out while a hand moves.
    pub(crate) fn lit_lately(&self) -> Option<&Lit> {
        self.lit_now().or(self.lit.as_ref().filter(|lit| self.busy && lit.scene == self.scene))
    }

    pub(crate) fn measure(&mut self, estimate: Estimate) {
        self.news += 1;
        self.estimate = Some(estimate);
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

    /// Whether what is shown is what would be made, under the light where one is wanted.
    pub(crate) fn stands(&self, made: &Made, light: Option<Light>) -> bool {
        let is_lit = light.is_none_or(|light| self.is_lit(light));
        self.is_made(made) && is_lit
    }

    /// Whether what is shown is what would be made, whatever the light.
    pub(crate) fn is_made(&self, made: &Made) -> bool {
        self.failure.is_none() && self.made.as_ref() == Some(made)
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
