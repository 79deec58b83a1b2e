//! What can be wrong with feature curves.

/// What is wrong with one curve: the place in it, what was found, what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Fault(pub String);

impl Fault {
    /// A fault from a sentence.
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

/// Why curves could not be made, read or rasterised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CurveError {
    /// A curve is not valid.
    #[error("curve {number}{}: {fault}", called(.name))]
    Curve {
        /// Its number in the list, from 0.
        number: usize,
        /// Its name, empty for none.
        name: String,
        /// What is wrong.
        fault: Fault,
    },
    /// There is more than this program takes.
    #[error("{what}: at most {most}, got {found}")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// The limit.
        most: u64,
        /// What was found.
        found: u64,
    },
    /// A file does not say what it should.
    #[error("{place}: {message}")]
    File {
        /// The element, feature or position.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// The name of a file says that it is none of lines.
    #[error("must end in .svg, .geojson or .json")]
    Name,
    /// A parameter makes no sense.
    #[error("`{name}` {message}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// What is wrong with it.
        message: String,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl CurveError {
    /// A fault of a file at a place in it.
    pub fn file(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::File { place: place.into(), message: message.into() }
    }
}

fn called(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" `{name}`") }
}
