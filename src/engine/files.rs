//! The files a graph may read (law 10): those in its own folder, in folders that the user allowed, and those that
//! the user named on the command line. Checked by directory handle, not by text: no link leads out.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use cap_std::ambient_authority;
use cap_std::fs::{Dir, OpenOptions};

use crate::node::{Error, FileRequest, SourceFile};

/// Largest file that is read, in bytes.
const MAX_BYTES: u64 = 16 << 30;

/// Reads source files inside what the user allowed, and remembers them while they do not change.
#[derive(Debug, Default)]
pub struct Files {
    roots: Vec<(PathBuf, Dir)>,
    named: BTreeSet<PathBuf>,
    read: Mutex<BTreeMap<String, (Stamp, Arc<SourceFile>)>>,
}

/// What tells a changed file from an unchanged one without reading it.
#[derive(Clone, Debug, PartialEq)]
struct Stamp {
    bytes: u64,
    modified: Option<std::time::SystemTime>,
}

impl std::fmt::Debug for SourceFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} bytes)", self.name, self.bytes.len())
    }
}

impl Files {
    /// Allows a folder: the graph's own first, then those of the user.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn allow_folder(&mut self, folder: &Path) -> std::io::Result<()> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let dir = Dir::open_ambient_dir(folder, ambient_authority())?;
        self.roots.push((folder.canonicalize()?, dir));
        Ok(())
    }

    /// Allows one file by its exact path: what the user wrote on the command line is the user's own word.
    pub fn allow_file(&mut self, path: &Path) {
        self.named.insert(path.to_owned());
    }

    /// Reads what a node asks for, in the order it asks; optional files that are not there are left out.
    ///
    /// # Errors
    /// [`Error::File`] with the reason.
    pub fn read(&self, requests: &[FileRequest]) -> Result<Vec<Arc<SourceFile>>, Error> {
        let mut found = Vec::new();
        for request in requests {
            match self.one(&request.name) {
                Ok(file) => found.push(file),
                Err(Refusal::Absent) if request.optional => (),
                Err(refusal) => {
                    return Err(refusal.of(request));
                }
            }
        }
        Ok(found)
    }

    /// Looks whether the files that a node asks for could be read, without reading them.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn look(&self, requests: &[FileRequest]) -> Result<(), Error> {
        for request in requests {
            match self.open(&request.name).and_then(|file| regular(&file)) {
                Ok(_) => (),
                Err(Refusal::Absent) if request.optional => (),
                Err(refusal) => return Err(refusal.of(request)),
            }
        }
        Ok(())
    }

    fn one(&self, name: &str) -> Result<Arc<SourceFile>, Refusal> {
        let mut file = self.open(name)?;
        let stamp = regular(&file)?;
        let known = self.read.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned();
        if let Some((old, source)) = known
            && old == stamp
            && stamp.modified.is_some()
        {
            return Ok(source);
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|e| Refusal::Unreadable(e.to_string()))?;
        let source = Arc::new(SourceFile::new(name.to_owned(), bytes));
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(name.to_owned(), (stamp, source.clone()));
        Ok(source)
    }

    fn open(&self, name: &str) -> Result<cap_std::fs::File, Refusal> {
        let path = Path::new(name);
        if let Some(full) = self.named.get(path) {
            // The user's own word may be a link: only its target must be a regular file.
            return open_named(&full.canonicalize().map_err(Refusal::from)?);
        }
        if path.is_absolute() {
            let inside = self.roots.iter().find_map(|(root, dir)| Some((path.strip_prefix(root).ok()?, dir)));
            let (rest, dir) = inside.ok_or(Refusal::Outside)?;
            return open_in(dir, rest);
        }
        if path.components().any(|c| !matches!(c, Component::Normal(_) | Component::CurDir)) {
            return Err(Refusal::Outside);
        }
        if path.components().any(|c| is_device(&c.as_os_str().to_string_lossy())) {
            return Err(Refusal::Device);
        }
        let mut last = Refusal::Absent;
        for (_, dir) in &self.roots {
            match open_in(dir, path) {
                Ok(file) => return Ok(file),
                Err(Refusal::Absent) => (),
                Err(other) => last = other,
            }
        }
        Err(last)
    }
}

/// The folders that this user keeps as allowed, one a line, in the user's own settings.
pub fn kept_folders() -> Vec<PathBuf> {
    let home = std::env::var_os("XDG_CONFIG_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".config")));
    let Some(file) = home.map(|h| h.join("orograph").join("allowed_folders")) else { return Vec::new() };
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    // A folder that is gone, or a drive that is not mounted, must not stop every build.
    lines.map(PathBuf::from).filter(|p| p.is_dir()).collect()
}

/// The stamp of an open file, which must be a regular one of a fair size.
fn regular(file: &cap_std::fs::File) -> Result<Stamp, Refusal> {
    let meta = file.metadata().map_err(|e| Refusal::Unreadable(e.to_string()))?;
    if !meta.is_file() {
        return Err(Refusal::NotRegular);
    }
    if meta.len() > MAX_BYTES {
        return Err(Refusal::TooLarge(meta.len()));
    }
    Ok(Stamp { bytes: meta.len(), modified: meta.modified().ok().map(|t| t.into_std()) })
}

/// Opens below a directory handle; a link that leads out of it is refused by the handle.
fn open_in(dir: &Dir, path: &Path) -> Result<cap_std::fs::File, Refusal> {
    // Looked at before it is opened: opening a pipe would wait for a writer for ever.
    let meta = dir.metadata(path).map_err(Refusal::from)?;
    if !meta.is_file() {
        return Err(Refusal::NotRegular);
    }
    let mut options = OpenOptions::new();
    options.read(true);
    nonblocking(&mut options);
    dir.open_with(path, &options).map_err(Refusal::from)
}

fn open_named(path: &Path) -> Result<cap_std::fs::File, Refusal> {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
        return Err(Refusal::NotRegular);
    };
    let dir = Dir::open_ambient_dir(folder, ambient_authority()).map_err(Refusal::from)?;
    open_in(&dir, Path::new(name))
}

/// So that a pipe put in place between the look and the opening does not block either.
#[cfg(unix)]
fn nonblocking(options: &mut OpenOptions) {
    use cap_std::fs::OpenOptionsExt as _;
    const O_NONBLOCK: i32 = 0o4000;
    if cfg!(target_os = "linux") {
        options.custom_flags(O_NONBLOCK);
    }
}

#[cfg(not(unix))]
fn nonblocking(_: &mut OpenOptions) {}

/// Whether Windows takes a file name for a device, whatever its extension.
pub fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_lowercase();
    let numbered = |prefix: &str| {
        let rest = stem.strip_prefix(prefix);
        rest.is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit() && n != "0")
    };
    matches!(stem.as_str(), "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
}

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
enum Refusal {
    #[error("there is no such file beside the graph or in a folder that you allowed (--allow DIR)")]
    Absent,
    #[error("a graph reads files only beside itself or in a folder that you allowed (--allow DIR); refused")]
    Outside,
    #[error("is the name of a device")]
    Device,
    #[error("is not a regular file")]
    NotRegular,
    #[error("is larger than {MAX_BYTES} bytes: {0}")]
    TooLarge(u64),
    #[error("cannot be read: {0}")]
    Unreadable(String),
}

impl Refusal {
    fn of(self, request: &FileRequest) -> Error {
        let FileRequest { parameter, name, .. } = request;
        Error::File { parameter, file: name.clone(), message: self.to_string() }
    }
}

impl From<std::io::Error> for Refusal {
    fn from(e: std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::NotFound => Self::Absent,
            // cap-std says "a path led outside of the filesystem" for links that lead out of the handle.
            std::io::ErrorKind::PermissionDenied if e.to_string().contains("outside") => Self::Outside,
            _ => Self::Unreadable(e.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_devices_whatever_their_extension() {
        for name in ["CON", "con.tif", "Lpt1", "aux.", "nul.png", "com9.asc"] {
            assert!(is_device(name), "{name}");
        }
        for name in ["cone", "com", "com10", "lpt0", "console.tif", "auxiliary"] {
            assert!(!is_device(name), "{name}");
        }
    }
}
