//! Why an evaluation, or a part of it, did not happen.

use std::sync::Arc;

use crate::node;

/// Why a wanted value could not be made; everything that does not need it is made all the same.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Failure {
    /// A node is wrong in the document: bad parameter, missing input.
    #[error("node `{node}`: {error}")]
    Document {
        /// The node.
        node: String,
        /// What is wrong with it.
        error: node::Error,
    },
    /// The document is wrong in more than one node, or in one that cannot be parsed: a cycle, an unknown kind.
    #[error("{0}")]
    Graph(String),
    /// A file that a node names is missing, cannot be read, has changed, or is not what it should be.
    #[error("node `{node}`: {error}")]
    File {
        /// The node.
        node: String,
        /// What is wrong with the file.
        error: node::Error,
    },
    /// A node failed while it ran.
    #[error("node `{node}`: {error}")]
    Run {
        /// The node.
        node: String,
        /// Why.
        error: node::Error,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// A result in the cache folder cannot be used; evaluations compute it themselves, so that this reaches nobody.
    #[error("a result in the cache folder cannot be used: {0}")]
    Cache(String),
    /// A bug of the engine.
    #[error("a bug of the engine: {0}")]
    Engine(String),
}

/// What kind of fault a failure is; exit codes follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The graph is wrong.
    Document,
    /// A file that the graph names is.
    File,
    /// A node could not do its work.
    Evaluation,
    /// Somebody stopped it.
    Cancelled,
    /// The cache folder.
    Cache,
    /// The program itself.
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
    /// What is wrong with a node before it runs.
    pub(super) fn of_document(node: &str, error: node::Error) -> Self {
        let node = node.to_owned();
        match error {
            node::Error::Cancelled => Self::Cancelled,
            node::Error::File { .. } => Self::File { node, error },
            _ => Self::Document { node, error },
        }
    }

    /// What went wrong while a node ran.
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

    /// What kind of fault it is.
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

/// Why a whole evaluation did not happen.
#[derive(Clone, Debug, thiserror::Error)]
pub enum EngineError {
    /// It would need more memory than it may use.
    #[error(
        "the evaluation needs about {}, {} of them for the program and its writers, and may use {}: {at} is the peak. \
         Build a smaller --size, in tiles (--tile-size), or raise --memory",
        bytes(*need), bytes(*reserve), bytes(*budget)
    )]
    Memory {
        /// Estimated peak, in bytes, with the reserve.
        need: u64,
        /// What is set aside for all but the evaluation, in bytes.
        reserve: u64,
        /// The budget, in bytes.
        budget: u64,
        /// The node at the peak.
        at: String,
    },
    /// It would take longer than it may.
    #[error(
        "the evaluation would take about {need:.2} s and may take {budget:.2} s; build a smaller --size or raise --time"
    )]
    Time {
        /// Estimated seconds.
        need: f64,
        /// The budget, in seconds.
        budget: f64,
    },
    /// The cache folder cannot be used.
    #[error("the cache folder cannot be used: {0}")]
    Cache(String),
    /// The threads could not be started.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
    /// It was asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Bytes as a person reads them.
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
