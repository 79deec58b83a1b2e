//! Exit codes, and the output with which the program ends.

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::engine::{Cause, EngineError, Failure};
use crate::text::{printable, printable_json};
use crate::whole::{self, Known};

/// The exit codes of the program; scripts rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// All was done.
    Done,
    /// Evaluation or writing failed.
    Failed,
    /// The command line is wrong.
    Usage,
    /// The graph is wrong.
    Graph,
    /// An input file is missing or unreadable.
    Input,
    /// Over the budget of memory or time.
    Budget,
    /// The asked-for device is not there.
    Device,
    /// Cancelled.
    Cancelled,
}

impl Exit {
    /// The number.
    pub fn code(self) -> i32 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            Self::Usage => 2,
            Self::Graph => 3,
            Self::Input => 4,
            Self::Budget => 5,
            Self::Device => 6,
            Self::Cancelled => 130,
        }
    }

    /// The code of a failure of one output.
    pub(super) fn of(failure: &Failure) -> Self {
        match failure.cause() {
            Cause::Document => Self::Graph,
            Cause::File => Self::Input,
            Cause::Cancelled => Self::Cancelled,
            Cause::Evaluation | Cause::Cache | Cause::Engine => Self::Failed,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        u8::try_from(exit.code()).map_or(Self::FAILURE, Self::from)
    }
}

/// Why the program stops, with the code it ends with.
#[derive(Debug)]
pub(super) struct Stop {
    pub exit: Exit,
    pub message: String,
    /// Whether the result was printed to standard output all the same, such as a plan over the budget.
    pub printed: bool,
}

impl Stop {
    pub(super) fn new(exit: Exit, message: impl Display) -> Self {
        Self { exit, message: message.to_string(), printed: false }
    }

    pub(super) fn usage(message: impl Display) -> Self {
        Self::new(Exit::Usage, message)
    }
}

impl From<EngineError> for Stop {
    fn from(e: EngineError) -> Self {
        let exit = match e {
            EngineError::Memory { .. } | EngineError::Time { .. } => Exit::Budget,
            EngineError::Cancelled => Exit::Cancelled,
            EngineError::Cache(_) | EngineError::Threads(_) => Exit::Failed,
        };
        Self::new(exit, e)
    }
}

/// Writes a small file whole or not at all.
pub(super) fn save(path: &Path, bytes: &[u8]) -> Result<(), Stop> {
    save_known(path, bytes, Known::Anything)
}

/// Writes a small file whole or not at all, provided that the old file is as `known` says.
pub(super) fn save_known(path: &Path, bytes: &[u8], known: Known<'_>) -> Result<(), Stop> {
    let cannot = |e: std::io::Error| Stop::new(Exit::Failed, format!("cannot write {}: {e}", path.display()));
    whole::save(path, bytes, known).map_err(cannot)
}

/// Writes a text to standard error as one line. An error, such as that of a closed pipe, is ignored.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}

/// Writes a line of JSON to standard error.
pub(super) fn tell_json(value: &serde_json::Value) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable_json(&value.to_string()));
}

/// Refuses to overwrite an input, whatever the other options are.
pub(super) fn spare_inputs(path: &Path, inputs: &[PathBuf]) -> Result<(), Stop> {
    let real = path.canonicalize().ok();
    let is_input = real.is_some_and(|p| inputs.iter().any(|i| i.canonicalize().is_ok_and(|i| i == p)));
    if is_input {
        return Err(Stop::usage(format!("{} is an input and is never overwritten", path.display())));
    }
    Ok(())
}

/// Writes texts to standard output, each as one line.
pub(super) fn print_lines(lines: impl IntoIterator<Item = impl AsRef<str>>) -> Result<Exit, Stop> {
    let mut text = String::new();
    for line in lines {
        text += &printable(line.as_ref());
        text.push('\n');
    }
    print(&text)
}

/// Writes a JSON document to standard output.
pub(super) fn print_json(value: &serde_json::Value) -> Result<Exit, Stop> {
    print(&json_text(value))
}

/// The text of a JSON document for output and files.
pub(super) fn json_text(value: &serde_json::Value) -> String {
    format!("{}\n", printable_json(&format!("{value:#}")))
}

/// Writes a text of the program to standard output; a closed pipe is no error.
pub(super) fn print(text: &str) -> Result<Exit, Stop> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Stop::new(Exit::Failed, format!("cannot write to standard output: {e}")))
        }
        _ => Ok(Exit::Done),
    }
}
