//! Why a file could not be read or written.

use std::io;

use super::codec::Codec;
use crate::params::did_you_mean;
use crate::work::Cancelled;

/// Why a height file could not be read, and which file it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{fault}: {file}")]
pub struct ReadError {
    /// What is wrong.
    pub fault: Fault,
    /// The file, as the caller named it.
    pub file: String,
}

/// What is wrong with a height file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The name has no extension that a reader knows.
    #[error("no reader for {found}; there are readers for {known}{hint}")]
    Extension {
        /// What the name ends with.
        found: String,
        /// All that would do.
        known: String,
        /// The nearest, if one is near.
        hint: String,
    },
    /// The content is not what the name says.
    #[error("named as {named}, and its content is {found}")]
    Magic {
        /// What the name says.
        named: &'static str,
        /// What the first bytes say.
        found: &'static str,
    },
    /// The header claims more samples than the limits allow.
    #[error("claims {cols} x {rows} samples; the limit is {samples} samples, {side} along a side")]
    Size {
        /// Columns claimed.
        cols: u64,
        /// Rows claimed.
        rows: u64,
        /// Most samples allowed.
        samples: u64,
        /// Most samples along a side.
        side: u32,
    },
    /// The header claims more than a file of this length can hold, however well compressed.
    #[error("claims {claimed} bytes of samples, more than {bytes} bytes can hold")]
    Overclaim {
        /// Bytes of samples claimed.
        claimed: u64,
        /// Length of the file.
        bytes: u64,
    },
    /// The file ends before its content does.
    #[error("ends early: {what} takes {want} bytes, there are {found}")]
    Short {
        /// What was being read.
        what: &'static str,
        /// Bytes it takes.
        want: u64,
        /// Bytes there are.
        found: u64,
    },
    /// A channel or band that is not there was asked for.
    #[error("`channel` asks for \"{asked}\"; {known}")]
    Channel {
        /// What was asked for.
        asked: String,
        /// All that there are, as a clause.
        known: String,
    },
    /// The content breaks the rules of its format.
    #[error("damaged: {0}")]
    Damaged(String),
    /// The content is of a kind that is not read.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// The machine, or the limit it was started under, has no room for it.
    #[error("takes {bytes} bytes of memory, more than there are")]
    NoMemory {
        /// Bytes that were asked for.
        bytes: u64,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The JSON file beside it cannot be used.
    #[error("its sidecar {0}")]
    Sidecar(String),
}

impl Fault {
    pub(super) fn extension(name: &str) -> Self {
        let known: Vec<_> = Codec::all_extensions().collect();
        let (found, hint) = match extension_of(name) {
            Some(e) => (format!("`.{e}`"), did_you_mean(&e, known.iter().copied())),
            None => ("a name without extension".to_owned(), String::new()),
        };
        Self::Extension { found, known: known.join(", "), hint }
    }

    pub(super) fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged(what.into())
    }

    pub(super) fn unsupported(what: impl Into<String>) -> Self {
        Self::Unsupported(what.into())
    }

    pub(super) fn of(self, file: &str) -> ReadError {
        ReadError { fault: self, file: file.to_owned() }
    }
}

impl From<io::Error> for Fault {
    fn from(e: io::Error) -> Self {
        Self::Damaged(format!("cannot be read: {e}"))
    }
}

impl From<Cancelled> for Fault {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Cancelled> for WriteError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// The bands of a file, as a clause.
pub(super) fn known_bands(bands: u64) -> String {
    if bands == 1 { "there is band 1".into() } else { format!("there are bands 1 to {bands}") }
}

/// The extension of a file name, in lower case.
pub(super) fn extension_of(name: &str) -> Option<String> {
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    last.rsplit_once('.').map(|(_, e)| e.to_ascii_lowercase())
}

/// Why a file could not be written. The caller adds which output and file it was.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The format cannot hold such values.
    #[error("{format} cannot hold {what}; {instead}")]
    Unfit {
        /// The format.
        format: &'static str,
        /// What it was to hold.
        what: String,
        /// What would do.
        instead: String,
    },
    /// A format of integers needs to know which values its lowest and highest number stand for.
    #[error("{format} needs a range: which {unit} its lowest and its highest number stand for")]
    NoRange {
        /// The format.
        format: &'static str,
        /// The unit of the values.
        unit: &'static str,
    },
    /// A range is empty, upside down or not finite.
    #[error("a range goes from a lower to a higher number, got {0:?}")]
    Range([f64; 2]),
    /// Values lie outside the range.
    #[error(
        "{count} of {of} values lie outside the range {range:?}: they go from {min} to {max}; widen the range or allow clipping"
    )]
    Clipped {
        /// How many.
        count: u64,
        /// Of how many.
        of: u64,
        /// The range.
        range: [f64; 2],
        /// Lowest value.
        min: f32,
        /// Highest value.
        max: f32,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The disk or folder refused.
    #[error("cannot be written: {0}")]
    Io(#[from] io::Error),
}
