//! How the program ends.

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cap_std::ambient_authority;
use cap_std::fs::Dir;

use crate::engine::{Cause, EngineError, Failure};
use crate::files::write_atomic;

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
}

impl Stop {
    pub(super) fn new(exit: Exit, message: impl Display) -> Self {
        Self { exit, message: message.to_string() }
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
    let cannot = |e: std::io::Error| Stop::new(Exit::Failed, format!("cannot write {}: {e}", path.display()));
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let dir = Dir::open_ambient_dir(folder, ambient_authority()).map_err(cannot)?;
    write_atomic(&dir, &name, |out| out.write_all(bytes)).map(|_| ()).map_err(cannot)
}

/// Writes a line to standard error; a reader that has gone away stops nothing.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Refuses to write over an input, whatever else the user said.
pub(super) fn spare_inputs(path: &Path, inputs: &[PathBuf]) -> Result<(), Stop> {
    let real = path.canonicalize().ok();
    let is_input = real.is_some_and(|p| inputs.iter().any(|i| i.canonicalize().is_ok_and(|i| i == p)));
    if is_input {
        return Err(Stop::usage(format!("{} is an input and is never overwritten", path.display())));
    }
    Ok(())
}

/// Writes to standard output; a reader that has gone away is no error.
pub(super) fn print(text: &str) -> Result<Exit, Stop> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Stop::new(Exit::Failed, format!("cannot write to standard output: {e}")))
        }
        _ => Ok(Exit::Done),
    }
}
