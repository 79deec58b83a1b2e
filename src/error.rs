//! Why a node, or the numerics below it, could not give a result.

use crate::name::Name;
use crate::value::WireType;
use crate::value::curves::CurveError;
use crate::work::Cancelled;

/// The result of a node.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a node could not run. The graph adds which node it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A required input has no wire.
    #[error("input `{port}` is not connected")]
    Missing {
        /// The input.
        port: Name,
    },
    /// A wire of the wrong type arrived.
    #[error("input `{port}` takes {}, got {}", want.name(), got.name())]
    WireType {
        /// The input.
        port: Name,
        /// What it takes.
        want: WireType,
        /// What came.
        got: WireType,
    },
    /// An input carries something the node cannot work on.
    #[error("input `{port}` {message}")]
    Input {
        /// The input.
        port: Name,
        /// What is wrong with it.
        message: String,
    },
    /// A parameter, or several together, make no sense.
    #[error("parameter `{name}` {message}")]
    Parameter {
        /// The parameter.
        name: String,
        /// What is wrong, with the limit and the value found.
        message: String,
    },
    /// A file is missing, unreadable or not what it should be.
    #[error("parameter `{parameter}`: {message}: {file}")]
    File {
        /// The parameter that names it.
        parameter: &'static str,
        /// The file, as the graph names it.
        file: String,
        /// What is wrong with it.
        message: String,
    },
    /// The kind asked its context for something its `Meta` does not declare: a bug of the kind.
    #[error("the kind asks for `{what}` and does not declare it")]
    Undeclared {
        /// What it asked for.
        what: &'static str,
    },
    /// An output has a number that is not finite: a bug of the kind, or parameters at their limit.
    #[error("output `{port}` is not finite at column {col}, row {row}")]
    NotFinite {
        /// The output.
        port: Name,
        /// Column in the window.
        col: usize,
        /// Row in the window.
        row: usize,
    },
    /// An output stands on another grid, or is missing: a bug of the kind.
    #[error("output `{port}` {message}")]
    Output {
        /// The output.
        port: Name,
        /// What is wrong with it.
        message: String,
    },
    /// The kind panicked: a bug of the kind.
    #[error("stopped by a bug of its kind: {message}")]
    Panic {
        /// What the panic said.
        message: String,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl Error {
    /// A parameter that should name a file and names none.
    pub fn no_file(parameter: &str) -> Self {
        Self::Parameter { name: parameter.to_owned(), message: "names no file; choose one".to_owned() }
    }

    /// What is wrong with curves, as a fault of the node that made or read them.
    pub fn of_curves(e: CurveError) -> Self {
        match e {
            CurveError::Cancelled => Self::Cancelled,
            CurveError::Parameter { name, message } => Self::Parameter { name: name.into(), message },
            other => Self::Parameter { name: "curves".into(), message: other.to_string() },
        }
    }
}
