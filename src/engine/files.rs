//! The files that a graph may read (law 10): those in its own folder, in folders that the user allowed, and those that
//! the user named on the command line. They are opened by directory handle, so that no link leads out of a folder.

use std::collections::BTreeSet;
use std::path::{Component, MAIN_SEPARATOR, Path, PathBuf};
use std::sync::Arc;

use cap_std::ambient_authority;
use cap_std::fs::{Dir, OpenOptions};

use super::sources::{Hashes, Sources};
use crate::node::{AnyNode, Error, FileRequest};
use crate::source::Shelf;
use crate::whole::is_device;

/// The most bytes of a file that is read.
const MAX_BYTES: u64 = 16 << 30;

/// The files that a graph may read, and the hashes and decoded values of those that were read before.
#[derive(Debug, Default)]
pub struct Files {
    allowed: Arc<Allowed>,
    hashes: Arc<Hashes>,
    shelf: Arc<Shelf>,
    pinned: Option<Arc<Sources>>,
}

impl Files {
    /// Allows a folder. The folder of the graph comes first, then those of the user.
    ///
    /// # Errors
    /// Fails when the folder cannot be opened.
    pub fn allow_folder(&mut self, folder: &Path) -> std::io::Result<()> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let dir = Dir::open_ambient_dir(folder, ambient_authority())?;
        let mut allowed = Allowed::clone(&self.allowed);
        allowed.roots.push((folder.canonicalize()?, Arc::new(dir)));
        self.allow(allowed);
        Ok(())
    }

    /// Allows one file by its exact path, wherever it is, as the user named it on the command line.
    pub fn allow_file(&mut self, path: &Path) {
        let mut allowed = Allowed::clone(&self.allowed);
        allowed.named.insert(path.to_owned());
        self.allow(allowed);
    }

    fn allow(&mut self, allowed: Allowed) {
        self.allowed = Arc::new(allowed);
        self.pinned = self.pinned.is_some().then(|| self.fresh());
    }

    /// Fixes the content of files: every file is opened once for all evaluations, and evaluations fail where its
    /// content has changed since. Otherwise every evaluation opens the files again.
    #[must_use]
    pub fn pinned(self) -> Self {
        let sources = self.fresh();
        Self { pinned: Some(sources), ..self }
    }

    /// The files of one evaluation.
    pub(super) fn sources(&self) -> Arc<Sources> {
        self.pinned.clone().unwrap_or_else(|| self.fresh())
    }

    fn fresh(&self) -> Arc<Sources> {
        Arc::new(Sources::new(self.allowed.clone(), self.hashes.clone(), self.shelf.clone()))
    }

    /// The values decoded from files.
    pub(super) fn shelf(&self) -> &Shelf {
        &self.shelf
    }

    /// Checks that the files of a node can be opened, without reading them.
    ///
    /// # Errors
    /// Returns [`Error::File`] with the reason.
    pub fn look(&self, node: &dyn AnyNode) -> Result<(), Error> {
        let found = self.sources().find(&node.files())?;
        node.reading(&found.into_iter().flatten().collect::<Vec<_>>()).map(drop)
    }

    /// The path of the file that a name stands for, if it may be read.
    pub fn locate(&self, name: &str) -> Option<PathBuf> {
        self.allowed.open(name).ok().map(|(spot, _)| spot.path())
    }
}

/// A name written on Windows, with the separators of this system; `None` where this changes nothing.
pub fn on_this_system(name: &str) -> Option<String> {
    (MAIN_SEPARATOR == '/' && name.contains('\\')).then(|| name.replace('\\', "/"))
}

/// Whether a name begins with a drive letter of Windows.
fn has_drive(name: &str) -> bool {
    let is_drive = |b: &[u8]| matches!(b, [letter, b':', b'/' | b'\\', ..] if letter.is_ascii_alphabetic());
    MAIN_SEPARATOR == '/' && is_drive(name.as_bytes())
}

/// A path without `.` and `..`, resolved as text and without following links.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => (),
            Component::ParentDir => _ = plain.pop(),
            Component::Normal(_) | Component::RootDir | Component::Prefix(_) => plain.push(part),
        }
    }
    plain
}

/// The folders and files that may be read.
#[derive(Clone, Debug, Default)]
pub(super) struct Allowed {
    roots: Vec<(PathBuf, Arc<Dir>)>,
    named: BTreeSet<PathBuf>,
}

/// The place of an allowed file.
#[derive(Clone, Debug)]
pub(super) enum Spot {
    /// The path and the handle of an allowed folder, and the path below it.
    Below(PathBuf, Arc<Dir>, PathBuf),
    /// The path of a file that the user named.
    Named(PathBuf),
}

impl Allowed {
    /// Opens the file that a name stands for, and returns its place. Where no file has exactly this name, `\` separates
    /// folders as on Windows, so that a graph works on every system.
    pub(super) fn open(&self, name: &str) -> Result<(Spot, std::fs::File), Refusal> {
        match (self.open_as(name), on_this_system(name)) {
            (Err(Refusal::Absent), _) if has_drive(name) => Err(Refusal::Drive),
            (Err(Refusal::Absent | Refusal::Outside), Some(name)) => self.open_as(&name),
            (opened, _) => opened,
        }
    }

    fn open_as(&self, name: &str) -> Result<(Spot, std::fs::File), Refusal> {
        let path = Path::new(name);
        if let Some(full) = self.named.get(path) {
            return Spot::Named(full.clone()).opened();
        }
        if path.is_absolute() {
            return self.below(&plain(path)).ok_or(Refusal::Outside)?.opened();
        }
        let goes_down = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if path.components().any(|c| is_device(&c.as_os_str().to_string_lossy())) {
            return Err(Refusal::Device);
        }
        let (mut inside, mut refused) = (goes_down, None);
        for (root, dir) in &self.roots {
            let spot = if goes_down {
                Some(Spot::Below(root.clone(), dir.clone(), path.to_owned()))
            } else {
                self.below(&plain(&root.join(path)))
            };
            let Some(spot) = spot else { continue };
            inside = true;
            match spot.opened() {
                Err(Refusal::Absent) => (),
                Err(other) => refused = Some(other),
                found => return found,
            }
        }
        // A file that does not exist is reported as absent, not as outside, where an allowed folder could contain it.
        Err(refused.unwrap_or(if inside { Refusal::Absent } else { Refusal::Outside }))
    }

    /// The place of a path in the first allowed folder that contains it.
    fn below(&self, path: &Path) -> Option<Spot> {
        let inside = |(root, dir): &(PathBuf, Arc<Dir>)| {
            Some(Spot::Below(root.clone(), dir.clone(), path.strip_prefix(root).ok()?.to_owned()))
        };
        self.roots.iter().find_map(inside)
    }
}

impl Spot {
    fn opened(self) -> Result<(Self, std::fs::File), Refusal> {
        let file = self.open()?;
        Ok((self, file))
    }

    /// Opens the file that is at this place now, with the same checks as the first time.
    pub(super) fn open(&self) -> Result<std::fs::File, Refusal> {
        match self {
            Self::Below(_, dir, path) => open_in(dir, path),
            // A file that the user named may be a link; its target must be a regular file.
            Self::Named(full) => open_named(&full.canonicalize().map_err(Refusal::from)?),
        }
    }

    /// The path, which identifies the file.
    pub(super) fn path(&self) -> PathBuf {
        match self {
            Self::Below(root, _, path) => root.join(path),
            Self::Named(full) => full.clone(),
        }
    }
}

/// The folders that the user allows for all graphs, from the user's own configuration, one a line.
pub fn kept_folders() -> Vec<PathBuf> {
    let home = std::env::var_os("XDG_CONFIG_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".config")));
    let Some(file) = home.map(|h| h.join("orograph").join("allowed_folders")) else { return Vec::new() };
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    // Folders that do not exist, or are on a drive that is not mounted, are left out, so that they stop no build.
    lines.map(PathBuf::from).filter(|p| p.is_dir()).collect()
}

/// Opens a file below a directory handle, which refuses links that lead out of it.
fn open_in(dir: &Dir, path: &Path) -> Result<std::fs::File, Refusal> {
    // The type is checked before the file is opened, because opening a pipe would block until there is a writer.
    let meta = dir.metadata(path).map_err(Refusal::from)?;
    if !meta.is_file() {
        return Err(Refusal::NotRegular);
    }
    let mut options = OpenOptions::new();
    options.read(true);
    nonblocking(&mut options);
    let file = dir.open_with(path, &options).map_err(Refusal::from)?.into_std();
    let meta = file.metadata().map_err(Refusal::from)?;
    if !meta.is_file() {
        return Err(Refusal::NotRegular);
    }
    if meta.len() > MAX_BYTES {
        return Err(Refusal::TooLarge(meta.len()));
    }
    Ok(file)
}

fn open_named(path: &Path) -> Result<std::fs::File, Refusal> {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
        return Err(Refusal::NotRegular);
    };
    let dir = Dir::open_ambient_dir(folder, ambient_authority()).map_err(Refusal::from)?;
    open_in(&dir, Path::new(name))
}

/// Sets an option by which opening does not block on a pipe that replaced the file after the check of its type.
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

/// Why a file was not read.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum Refusal {
    #[error("there is no such file beside the graph or in a folder that you allowed (--allow DIR)")]
    Absent,
    #[error("a graph reads files only beside itself or in a folder that you allowed (--allow DIR); refused")]
    Outside,
    #[error("names a drive of Windows, and this system has none; name the file from the graph's folder on")]
    Drive,
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
    pub(super) fn of(self, request: &FileRequest) -> Error {
        let FileRequest { parameter, name, .. } = request;
        Error::File { parameter, file: name.clone(), message: self.to_string() }
    }
}

impl From<std::io::Error> for Refusal {
    fn from(e: std::io::Error) -> Self {
        match e.kind() {
            std::io::ErrorKind::NotFound => Self::Absent,
            // This is the error of cap-std for links that lead out of the handle.
            std::io::ErrorKind::PermissionDenied if e.to_string().contains("outside") => Self::Outside,
            _ => Self::Unreadable(e.to_string()),
        }
    }
}
