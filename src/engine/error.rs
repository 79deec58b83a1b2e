//! Why an evaluation, or a part of it, did not happen.

use std::sync::Arc;

use crate::node;

/// Why a wanted value could not be made; everything that does not need it is made all the same.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Failure {
    /// A node is wrong in the document: unknown kind, bad parameter, missing input.
    #[error("node `{node}`: {error}")]
    Document {
        /// The node.
        node: String,
        /// What is wrong with it.
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
    /// The graph cannot be evaluated at this place at all.
    #[error("{0}")]
    Graph(String),
}

impl Failure {
    /// The node that failed.
    pub fn node(&self) -> Option<&str> {
        match self {
            Self::Document { node, .. } | Self::Run { node, .. } => Some(node),
            Self::Graph(_) => None,
        }
    }

    /// Whether a missing or unreadable file is the cause.
    pub fn is_file(&self) -> bool {
        matches!(
            self,
            Self::Document { error: node::Error::File { .. }, .. }
                | Self::Run { error: node::Error::File { .. }, .. }
        )
    }

    /// Whether the document is the cause, not its evaluation.
    pub fn is_document(&self) -> bool {
        !self.is_file() && matches!(self, Self::Document { .. } | Self::Graph(_))
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
