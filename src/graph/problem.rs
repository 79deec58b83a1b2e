//! Problems: faults of a graph, with their places.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;

use super::NodeId;
use crate::params::did_you_mean;
use crate::text::printable;

/// The severity of a [`Problem`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// A likely mistake; the graph still gives a result.
    Warning,
    /// A fault; nothing that depends on the place can be computed.
    Error,
}

/// A place in a graph.
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
    /// A parameter of a node; a dotted path where it is inside a mode or a list.
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

/// A fault or a likely mistake in a graph, or the reason why an edit was refused.
///
/// It prints as place and message on one line, even where quoted texts have line breaks: "node `hills`, parameter
/// `octaves`: must be a whole number from 1 to 16, got 99".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", printable(&format!("{place}: {message}")))]
pub struct Problem {
    /// Error or warning.
    pub severity: Severity,
    /// The place of the fault.
    pub place: Place,
    /// The message with the limit and the value found, without the place.
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

    /// The problem, attributed to a node.
    pub fn of(self, node: NodeId) -> Self {
        Self { node: Some(node), ..self }
    }

    /// Whether the problem is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// The node to which the problem belongs. An error stops this node and those downstream of it, and nothing else.
    /// `None` for problems of the graph, of its terrain and of its outputs.
    pub fn blames(&self) -> Option<NodeId> {
        self.node
    }

    /// Whether the problem is an error that stops the output `name`, whose source has `upstream` above it: one of
    /// those nodes, the output itself, or the graph as a whole.
    pub fn stops(&self, name: &str, upstream: &BTreeSet<NodeId>) -> bool {
        let concerns = match (&self.place, self.node) {
            (_, Some(node)) => upstream.contains(&node),
            (Place::Output(output), None) => output == name,
            // The nodes and settings that it sets have problems of their own.
            (Place::Exposed(_), None) => false,
            _ => true,
        };
        self.is_error() && concerns
    }
}

/// A search for similar names with a budget of comparisons. A hostile file may have a hundred thousand misspelt names,
/// for which suggestions are of no use.
pub(super) struct Hints(Cell<usize>);

/// The most comparisons of names in one validation; they take well below a tenth of a second.
const COMPARISONS: usize = 20_000;
/// The most bytes of a name that is compared, since the time is quadratic in the length.
const LONGEST_NAME: usize = 200;

impl Hints {
    pub(super) fn new() -> Self {
        Self(Cell::new(COMPARISONS))
    }

    /// A search that finds nothing, for checks whose messages are not shown.
    pub(super) fn none() -> Self {
        Self(Cell::new(0))
    }

    /// The text "; did you mean `x`?", or an empty one where no name is similar.
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

/// The text of some names, such as "`a`, `b`", or "none".
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 24;
    let mut all: Vec<_> = names.into_iter().map(|n| format!("`{n}`")).take(SHOWN + 1).collect();
    if all.len() > SHOWN {
        all[SHOWN] = "…".to_owned();
    }
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}
