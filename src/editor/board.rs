//! The results of the evaluator, for the window to read.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::evaluator::Order;
use super::shade::{Light, Look};
use crate::engine::Key;
use crate::graph::{NodeId, Source};
use crate::render::Picture;
use crate::value::{Bounds, Value};

/// The progress of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NodeState {
    /// The node will run.
    Waiting,
    /// The node runs; holds the share of its work that is done, 0 to 1.
    Running(f32),
    /// The node ran; holds the seconds that it took.
    Done(f64),
    /// The node failed; holds the message.
    Failed(String),
}

/// A small picture of the first output of a node.
#[derive(Clone, Debug)]
pub(crate) struct Thumbnail {
    pub(crate) key: Key,
    pub(crate) picture: Picture,
    /// Lowest and highest value, where the output is a field.
    pub(crate) range: Option<(f32, f32)>,
}

/// The state of the document and the scene that an exact view shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ViewContents {
    pub(crate) state: u64,
    pub(crate) scene: Scenery,
}

/// The outputs that a view shows, and how.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scenery {
    pub(crate) target: Source,
    /// The output that the target is compared with.
    pub(crate) against: Option<Source>,
    /// The output that colours the target.
    pub(crate) drape: Option<Source>,
    /// A mask that is being painted, shown as a tint over the picture.
    pub(crate) tint: Option<Source>,
    /// Samples along the longer side.
    pub(crate) size: u32,
    pub(crate) look: Look,
}

/// The estimated cost of a build.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) of: BuildRequest,
    /// Seconds with all threads of the engine.
    pub(crate) seconds: f64,
    /// Bytes of memory at the peak.
    pub(crate) bytes: u64,
    /// The message with which the engine would refuse the build; `None` where it fits the budgets.
    pub(crate) refusal: Option<String>,
}

/// A build whose cost is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BuildRequest {
    pub(crate) state: u64,
    pub(crate) outputs: Vec<String>,
    pub(crate) size: u32,
}

/// A value in the view, with its picture.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    /// A number that is unique in this process; views compare it with that of the value they last uploaded.
    pub(crate) id: u64,
    pub(crate) value: Value,
    pub(crate) picture: Arc<Picture>,
    /// Whether this is a draft: a coarser result, shown until the exact one is there.
    pub(crate) is_draft: bool,
    pub(crate) effective_cell: Option<f64>,
    /// The extent of the whole terrain.
    pub(crate) bounds: Bounds,
}

impl Shown {
    /// An `id` that was not used before.
    pub(crate) fn next_id() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }
}

/// An evaluation that was not started because its estimate exceeds a limit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unstarted {
    /// The message and the bytes needed, where the estimate exceeds the memory budget.
    pub(crate) over_budget: Option<(String, u64)>,
    /// Estimated seconds.
    pub(crate) seconds: f64,
    /// Bytes of files that must be read before the evaluation can start.
    pub(crate) unread: u64,
}

/// Pictures under sun and sky, with cast shadows.
#[derive(Clone, Debug)]
pub(crate) struct Lit {
    /// The number of the showing (see `Board::showings`) that the pictures are of.
    pub(crate) showing: u64,
    scene: Option<Scenery>,
    /// A number that differs for each picture.
    pub(crate) number: u64,
    pub(crate) light: Light,
    pub(crate) picture: Arc<Picture>,
    pub(crate) against: Option<Arc<Picture>>,
}

/// The results so far.
#[derive(Debug, Default)]
pub(crate) struct Board {
    /// A counter that rises with every change of the board.
    pub(crate) news: u64,
    pub(crate) is_busy: bool,
    pub(crate) shown: Option<Shown>,
    /// The value that `shown` is compared with.
    pub(crate) against: Option<Shown>,
    /// A part of `shown` with finer samples.
    pub(crate) detail: Option<Shown>,
    /// The scene that `shown` belongs to.
    scene: Option<Scenery>,
    /// The state and scene of the exact view; `None` while a draft is shown.
    pub(crate) contents: Option<ViewContents>,
    /// A counter that rises with each value that is shown, drafts included.
    pub(crate) showings: u64,
    /// The lit pictures of a showing.
    pub(crate) lit: Option<Lit>,
    /// The showing and the light whose shading failed, which is not tried again.
    unlit: Option<(u64, Light)>,
    pub(crate) estimate: Option<Estimate>,
    pub(crate) failure: Option<(u64, String)>,
    pub(crate) unstarted: Option<Unstarted>,
    pub(crate) nodes: BTreeMap<NodeId, NodeState>,
    pub(crate) thumbnails: BTreeMap<NodeId, Thumbnail>,
}

impl Board {
    pub(crate) fn begin(&mut self, order: &Order) {
        self.news += 1;
        self.is_busy = true;
        self.unstarted = None;
        self.failure = None;
        self.nodes.retain(|id, state| {
            // Nodes that were waiting, running or failed report their state again in this evaluation.
            matches!(state, NodeState::Done(_)) && order.graph.get(*id).is_some()
        });
        self.thumbnails.retain(|id, _| order.graph.get(*id).is_some());
        if order.scene.is_none() {
            (self.shown, self.against, self.detail, self.contents) = (None, None, None, None);
            self.showings += 1;
        }
    }

    pub(crate) fn end(&mut self, whole: bool) {
        self.news += 1;
        self.is_busy = false;
        if !whole {
            self.nodes.retain(|_, state| !matches!(state, NodeState::Waiting | NodeState::Running(_)));
        }
    }

    pub(crate) fn refuse(&mut self, unstarted: Unstarted) {
        self.news += 1;
        self.unstarted = Some(unstarted);
    }

    /// Shows the whole terrain of a scene; `contents` is `None` for a draft.
    pub(crate) fn show(
        &mut self,
        scene: Scenery,
        shown: Shown,
        against: Option<Shown>,
        contents: Option<ViewContents>,
    ) {
        self.news += 1;
        self.showings += 1;
        self.failure = None;
        (self.shown, self.against, self.scene) = (Some(shown), against, Some(scene));
        self.contents = contents;
        self.detail = None;
    }

    /// The draft of a scene, if that is shown.
    pub(crate) fn draft_of(&self, scene: &Scenery) -> Option<&Shown> {
        self.shown.as_ref().filter(|shown| shown.is_draft && self.scene.as_ref() == Some(scene))
    }

    /// Adds a finer part of the shown value.
    pub(crate) fn show_detail(&mut self, detail: Shown) {
        self.news += 1;
        self.detail = Some(detail);
    }

    /// Stores the lit pictures of the shown value and of the one it is compared with; `None` where shading failed.
    pub(crate) fn set_lit(&mut self, light: Light, lit: Option<(Picture, Option<Picture>)>) {
        self.news += 1;
        let (showing, number) = (self.showings, self.news);
        match lit {
            None => self.unlit = Some((showing, light)),
            Some((picture, against)) => {
                let (picture, against) = (Arc::new(picture), against.map(Arc::new));
                self.lit = Some(Lit { showing, scene: self.scene.clone(), number, light, picture, against });
            }
        }
    }

    /// Whether the shown value has its picture under a light, or shading it failed.
    pub(crate) fn is_lit(&self, light: Light) -> bool {
        self.unlit == Some((self.showings, light)) || self.lit_now().is_some_and(|lit| lit.light == light)
    }

    /// The lit pictures of the shown value.
    pub(crate) fn lit_now(&self) -> Option<&Lit> {
        self.lit.as_ref().filter(|lit| lit.showing == self.showings)
    }

    /// The lit pictures of the shown value, or, while an evaluation runs, the last ones of the same scene, so that the
    /// view does not flicker between lit and unlit pictures during a drag.
    pub(crate) fn lit_now_or_before(&self) -> Option<&Lit> {
        self.lit_now().or(self.lit.as_ref().filter(|lit| self.is_busy && lit.scene == self.scene))
    }

    pub(crate) fn set_estimate(&mut self, estimate: Estimate) {
        self.news += 1;
        self.estimate = Some(estimate);
    }

    pub(crate) fn fail_view(&mut self, state: u64, why: String) {
        self.news += 1;
        self.failure = Some((state, why));
    }

    pub(crate) fn set_node(&mut self, id: NodeId, state: NodeState) {
        self.news += 1;
        self.nodes.insert(id, state);
    }

    pub(crate) fn set_thumbnail(&mut self, id: NodeId, thumbnail: Thumbnail) {
        self.news += 1;
        self.thumbnails.insert(id, thumbnail);
    }

    /// Whether the view shows exactly these contents, under the light where one is given.
    pub(crate) fn is_current(&self, contents: &ViewContents, light: Option<Light>) -> bool {
        let is_lit = light.is_none_or(|light| self.is_lit(light));
        self.shows(contents) && is_lit
    }

    /// Whether the view shows exactly these contents, under whatever light.
    pub(crate) fn shows(&self, contents: &ViewContents) -> bool {
        self.failure.is_none() && self.contents.as_ref() == Some(contents)
    }

    /// Whether a node has no thumbnail of the result with this key, and has not failed.
    pub(crate) fn needs_thumbnail(&self, id: NodeId, key: Key) -> bool {
        let failed = matches!(self.nodes.get(&id), Some(NodeState::Failed(_)));
        !failed && self.thumbnails.get(&id).is_none_or(|thumbnail| thumbnail.key != key)
    }

    /// Drops the thumbnails of nodes that have no key, and so no result.
    pub(crate) fn retain_thumbnails(&mut self, keys: &BTreeMap<NodeId, Key>) {
        self.thumbnails.retain(|id, _| keys.contains_key(id));
    }
}
