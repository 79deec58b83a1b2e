//! What callers see of an evaluation: events while it runs, and a report of each task.

use super::plan::{Plan, Stage};
use crate::name::Name;
use crate::value::{Grid, Value};

/// Events of an evaluation; called from several threads.
pub trait Observer: Sync {
    /// Part of a file that a node names was read to hash its content; `share` is the finished part, 0 to 1.
    fn reading(&self, node: &str, file: &str, share: f32) {
        let _ = (node, file, share);
    }
    /// The plan is made and admitted. Tasks are numbered by their place in it.
    fn planned(&self, plan: &Plan) {
        let _ = plan;
    }
    /// A task has started.
    fn started(&self, task: usize) {
        let _ = task;
    }
    /// Part of a task is done; `share` is the finished part, 0 to 1.
    fn progress(&self, task: usize, share: f32) {
        let _ = (task, share);
    }
    /// Whether somebody looks at the state of an output while its task runs.
    fn looks(&self, task: usize, port: &str) -> bool {
        let _ = (task, port);
        false
    }
    /// An output as it stands while its task runs, on a grid of its own; asked for by [`looks`](Self::looks). It is part of no
    /// result and is not kept.
    fn state(&self, task: usize, port: &str, value: Value) {
        let _ = (task, port, value);
    }
    /// A task is done or has failed.
    fn finished(&self, task: usize, seconds: f64) {
        let _ = (task, seconds);
    }
}

/// An observer that ignores all events.
#[derive(Clone, Copy, Debug)]
pub struct Unobserved;

impl Observer for Unobserved {}

/// The report of a task that ran.
#[derive(Clone, Debug)]
pub struct TaskReport {
    /// Name of the node.
    pub node: String,
    /// Kind of the node.
    pub kind: Name,
    /// What the task did.
    pub stage: Stage,
    /// The grid of the task; `None` for a gridless node.
    pub grid: Option<Grid>,
    /// Where the cache had the result, `memory` or `disk`; `None` where it was computed.
    pub cached: Option<&'static str>,
    /// Seconds that the task took.
    pub seconds: f64,
    /// Bytes of the outputs.
    pub bytes: u64,
    /// Warnings of the node about its result, sorted; results from memory repeat theirs. A result with warnings is not
    /// written to the cache folder, so that the next process computes it and repeats the warnings. A node that does not
    /// run because all results of its consumers were cached gives none.
    pub warnings: Vec<String>,
    /// Whether the task ended with a result.
    pub done: bool,
}
