//! What is wrong with a graph, and where.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;

use super::NodeId;
use crate::params::did_you_mean;
use crate::text::printable;

/// How bad a [`Problem`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Doubtful: the graph still gives a result.
    Warning,
    /// Wrong: what depends on the place cannot be computed.
    Error,
}

/// Where in a graph something is.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// The graph as a whole.
    Graph,
    /// A setting of the terrain.
    Terrain(String),
    /// A node.
    Node(String),
    /// An input of a node.
    Input {
        /// The node.
        node: String,
        /// The input.
        port: String,
    },
    /// An output of a node.
    NodeOutput {
        /// The node.
        node: String,
        /// The output.
        port: String,
    },
    /// A parameter of a node; a dotted path where it lies inside a mode or a list.
    Parameter {
        /// The node.
        node: String,
        /// The parameter.
        parameter: String,
    },
    /// An output of the graph.
    Output(String),
    /// An exposed parameter.
    Exposed(String),
    /// A note on the canvas.
    Note(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Graph => write!(f, "graph"),
            Self::Terrain(setting) => write!(f, "terrain, setting `{setting}`"),
            Self::Node(node) => write!(f, "node `{node}`"),
            Self::Input { node, port } => write!(f, "node `{node}`, input `{port}`"),
            Self::NodeOutput { node, port } => write!(f, "node `{node}`, output `{port}`"),
            Self::Parameter { node, parameter } => write!(f, "node `{node}`, parameter `{parameter}`"),
            Self::Output(name) => write!(f, "output `{name}`"),
            Self::Exposed(name) => write!(f, "exposed `{name}`"),
            Self::Note(name) => write!(f, "note `{name}`"),
        }
    }
}

/// Something wrong or doubtful in a graph, or the reason why an edit was refused.
///
/// Prints as place and message on one line, whatever texts they quote: "node `hills`, parameter `octaves`: must be a
/// whole number from 1 to 16, got 99".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", printable(&format!("{place}: {message}")))]
pub struct Problem {
    /// How bad it is.
    pub severity: Severity,
    /// Where it is.
    pub place: Place,
    /// What is wrong: the limit and the value found, without the place.
    pub message: String,
    pub(super) node: Option<NodeId>,
}

impl Problem {
    /// An error.
    pub fn error(place: Place, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, place, message: message.into(), node: None }
    }

    /// A warning.
    pub fn warning(place: Place, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(place, message) }
    }

    /// The problem with the node that it belongs to.
    pub fn of(self, node: NodeId) -> Self {
        Self { node: Some(node), ..self }
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// The node that it belongs to: an error stops this node and what lies downstream of it, nothing else. `None`
    /// for problems of the graph, of its terrain and of its outputs.
    pub fn blames(&self) -> Option<NodeId> {
        self.node
    }

    /// Whether the problem is an error that stops the output `name`, whose source has `upstream` above it: one of
    /// those nodes, the output itself, or the graph as a whole.
    pub fn stops(&self, name: &str, upstream: &BTreeSet<NodeId>) -> bool {
        let concerns = match (&self.place, self.node) {
            (_, Some(node)) => upstream.contains(&node),
            (Place::Output(output), None) => output == name,
            // What it would set is told as well, at the node or the setting of the terrain.
            (Place::Exposed(_), None) => false,
            _ => true,
        };
        self.is_error() && concerns
    }
}

/// Looks for the nearest names while a budget of comparisons lasts: a hostile file may hold a hundred thousand
/// misspelt names, and nobody reads that many suggestions.
pub(super) struct Hints(Cell<usize>);

/// Comparisons of two names in one validation: well below a tenth of a second.
const COMPARISONS: usize = 20_000;
/// Longer names, in bytes, are no slip of the pen; comparing is quadratic in the length.
const LONGEST_NAME: usize = 200;

impl Hints {
    pub(super) fn new() -> Self {
        Self(Cell::new(COMPARISONS))
    }

    /// For checks whose messages nobody will read.
    pub(super) fn none() -> Self {
        Self(Cell::new(0))
    }

    /// "; did you mean `x`?", or nothing when no name is near.
    pub(super) fn nearest<'a>(&self, name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
        if name.len() > LONGEST_NAME {
            return String::new();
        }
        let left = self.0.get();
        let candidates: Vec<&str> =
            names.into_iter().filter(|n| n.len() <= LONGEST_NAME).take(left).collect();
        self.0.set(left - candidates.len());
        did_you_mean(name, candidates)
    }
}

/// Some names for a message: "`a`, `b`", or "none".
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 24;
    let mut all: Vec<_> = names.into_iter().map(|n| format!("`{n}`")).take(SHOWN + 1).collect();
    if all.len() > SHOWN {
        all[SHOWN] = "…".to_owned();
    }
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}
