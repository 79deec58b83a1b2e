//! Errors of an evaluation, and of single values in it.

use std::sync::Arc;

use crate::node;

/// Why a wanted value could not be made. Values that do not depend on the failed node are made all the same.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Failure {
    /// A node has a fault in the document, such as a bad parameter or a missing input.
    #[error("node `{node}`: {error}")]
    Document {
        /// The name of the node.
        node: String,
        /// The fault of the node.
        error: node::Error,
    },
    /// The document has a fault that is not in one parsed node, such as a cycle or an unknown kind.
    #[error("{0}")]
    Graph(String),
    /// A file that a node names is missing, cannot be read, has changed, or is not what it should be.
    #[error("node `{node}`: {error}")]
    File {
        /// The name of the node.
        node: String,
        /// The fault of the file.
        error: node::Error,
    },
    /// A node failed while it ran.
    #[error("node `{node}`: {error}")]
    Run {
        /// The name of the node.
        node: String,
        /// The error of the run.
        error: node::Error,
    },
    /// The evaluation was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A result in the cache folder cannot be used. The engine then computes it, so that callers never see this
    /// failure.
    #[error("a result in the cache folder cannot be used: {0}")]
    Cache(String),
    /// The engine has a bug.
    #[error("a bug of the engine: {0}")]
    Engine(String),
}

/// The cause of a failure, from which the exit code of the program follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The graph is wrong.
    Document,
    /// A file that the graph names is wrong.
    File,
    /// A node failed while it ran.
    Evaluation,
    /// The evaluation was cancelled.
    Cancelled,
    /// The cache folder cannot be used.
    Cache,
    /// The program has a bug.
    Engine,
}

impl Cause {
    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Document => "document",
            Self::File => "file",
            Self::Evaluation => "evaluation",
            Self::Cancelled => "cancelled",
            Self::Cache => "cache",
            Self::Engine => "engine",
        }
    }
}

impl Failure {
    /// The failure of a node that has an error before it runs.
    pub(super) fn of_document(node: &str, error: node::Error) -> Self {
        let node = node.to_owned();
        match error {
            node::Error::Cancelled => Self::Cancelled,
            node::Error::File { .. } => Self::File { node, error },
            _ => Self::Document { node, error },
        }
    }

    /// The failure of a node that has an error while it runs.
    pub(super) fn of_run(node: &str, error: node::Error) -> Self {
        let node = node.to_owned();
        match error {
            node::Error::Cancelled => Self::Cancelled,
            node::Error::File { .. } => Self::File { node, error },
            _ => Self::Run { node, error },
        }
    }

    /// The node that failed.
    pub fn node(&self) -> Option<&str> {
        match self {
            Self::Document { node, .. } | Self::File { node, .. } | Self::Run { node, .. } => Some(node),
            Self::Graph(_) | Self::Cancelled | Self::Cache(_) | Self::Engine(_) => None,
        }
    }

    /// The cause of the failure.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Document { .. } | Self::Graph(_) => Cause::Document,
            Self::File { .. } => Cause::File,
            Self::Run { .. } => Cause::Evaluation,
            Self::Cancelled => Cause::Cancelled,
            Self::Cache(_) => Cause::Cache,
            Self::Engine(_) => Cause::Engine,
        }
    }
}

/// A failure that several wanted values may share.
pub type SharedFailure = Arc<Failure>;

/// Why a whole evaluation failed or was refused.
#[derive(Clone, Debug, thiserror::Error)]
pub enum EngineError {
    /// The estimated memory exceeds the budget.
    #[error(
        "the evaluation needs about {}, {} of them for the program and its writers, and may use {}: {at} is the peak. \
         Build a smaller --size, in tiles (--tile-size), or raise --memory",
        bytes(*need), bytes(*reserve), bytes(*budget)
    )]
    Memory {
        /// Estimated peak, in bytes, with the reserve.
        need: u64,
        /// The part of the budget that is not for evaluations, in bytes.
        reserve: u64,
        /// The memory budget, in bytes.
        budget: u64,
        /// The node at the peak.
        at: String,
    },
    /// The estimated time exceeds the budget.
    #[error(
        "the evaluation would take about {need:.2} s and may take {budget:.2} s; build a smaller --size or raise --time"
    )]
    Time {
        /// Estimated seconds.
        need: f64,
        /// The time budget, in seconds.
        budget: f64,
    },
    /// The cache folder cannot be used.
    #[error("the cache folder cannot be used: {0}")]
    Cache(String),
    /// The threads could not be started.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
    /// The evaluation was cancelled.
    #[error("cancelled")]
    Cancelled,
}

/// A number of bytes as text with a binary unit.
pub fn bytes(n: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = n as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{n} B") } else { format!("{value:.1} {}", UNITS[unit]) }
}
