//! The cache folder: a folder for each key, in it a file for each window, whole or not there, checked when read.
//!
//! Files are written beside their place and renamed into it, so that many processes may share the folder. One that is
//! damaged is removed; whatever else keeps one from being read, this process does not try it again. Either way the
//! result is computed. Files get the permissions of the user's umask, so that users may share the folder. The folder
//! of another program version, or of another form of file, is never read.

mod entry;
mod room;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use super::bytes;
use super::cache::Given;
use super::key::Key;
use crate::node::Kind;
use crate::value::{Grid, Lattice};
use room::Room;

/// The folder may hold this many bytes unless the user says otherwise.
pub const DEFAULT_LIMIT: u64 = 32 << 30;
/// Farthest window that a file may be named for, in samples: far beyond any lattice, far within what adds up.
const FARTHEST: i64 = 1 << 40;
/// Beginning of the names of files that are being written.
const PASSING: &str = ".part-";

/// Results are keyed by what they depend on; the program itself, and the form of the files, are in the name of the
/// folder.
fn salt() -> String {
    format!("orograph-{}-{}", env!("CARGO_PKG_VERSION"), entry::FORM)
}

/// A folder of results.
#[derive(Debug)]
pub(super) struct Disk {
    top: PathBuf,
    folder: PathBuf,
    room: Mutex<Room>,
    /// Files that could not be used: another user's, damaged ones that cannot be removed.
    shunned: Mutex<BTreeSet<PathBuf>>,
    complaint: Mutex<Complaint>,
}

/// Why the folder does not keep everything; said once.
#[derive(Debug, Default)]
enum Complaint {
    #[default]
    None,
    New(String),
    Said,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Disk {
    /// Opens a folder that is to hold no more than some bytes.
    ///
    /// # Errors
    /// When it is not there and cannot be made. One that cannot be written is still good to read.
    pub(super) fn open(top: &Path, limit: u64) -> io::Result<Self> {
        let folder = top.join(salt());
        match fs::create_dir_all(&folder) {
            Err(e) if !top.is_dir() => return Err(e),
            _ => (),
        }
        let room = Mutex::new(Room::open(top, limit));
        let (shunned, complaint) = (Mutex::default(), Mutex::default());
        Ok(Self { top: top.to_owned(), folder, room, shunned, complaint })
    }

    /// The folder of all windows of a key.
    fn windows(&self, key: &Key) -> PathBuf {
        let name = key.to_string();
        self.folder.join(&name[..2]).join(&name[2..])
    }

    /// A file whose window holds the wanted one: consumers that are cached themselves ask for nothing, so the same
    /// graph may ask for less another time.
    pub(super) fn find(&self, key: &Key, grid: &Grid) -> Option<PathBuf> {
        let folder = self.windows(key);
        let shunned = lock(&self.shunned);
        let exact = folder.join(name_of(grid));
        if exact.is_file() && !shunned.contains(&exact) {
            return Some(exact);
        }
        let files = fs::read_dir(folder).ok()?.flatten();
        let mut wider: Vec<_> = files
            .filter_map(|f| Some((window_of(f.file_name().to_str()?, grid.lattice)?, f.path())))
            .filter(|(window, path)| window.contains(grid) && !shunned.contains(path) && path.is_file())
            .collect();
        wider.sort_by_key(|(window, _)| (window.len(), window.row, window.col));
        wider.into_iter().next().map(|(_, path)| path)
    }

    /// Writes a result. What cannot be written costs a later process time, and this one a word.
    pub(super) fn put(&self, key: &Key, grid: &Grid, given: &Given) {
        let path = self.windows(key).join(name_of(grid));
        let written = self.write(&path, key, given).or_else(|e| match e.kind() {
            // Another process trims, and has just removed the empty folder.
            io::ErrorKind::NotFound => self.write(&path, key, given),
            _ => Err(e),
        });
        match written {
            Ok(()) => {
                lock(&self.shunned).remove(&path);
            }
            Err(e) => self.complain(|| e.to_string()),
        }
    }

    fn write(&self, path: &Path, key: &Key, given: &Given) -> io::Result<()> {
        let size = entry::size(key, given)?;
        if !lock(&self.room).make(size) {
            let limit = bytes(lock(&self.room).limit());
            return Err(io::Error::other(format!(
                "a result of {} is larger than the folder may be, {limit} (--cache-size)",
                bytes(size)
            )));
        }
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)?;
        let mut file = shared().tempfile_in(folder)?;
        entry::write(&mut file, key, given)?;
        file.persist(path).map_err(|e| e.error)?;
        Ok(())
    }

    fn complain(&self, why: impl FnOnce() -> String) {
        let mut complaint = lock(&self.complaint);
        if matches!(*complaint, Complaint::None) {
            let folder = self.top.display();
            *complaint =
                Complaint::New(format!("the cache folder {folder} does not keep all results: {}", why()));
        }
    }

    /// Why the folder does not keep everything, the first time that it is asked for.
    pub(super) fn complaint(&self) -> Option<String> {
        let mut complaint = lock(&self.complaint);
        match std::mem::take(&mut *complaint) {
            Complaint::New(text) => {
                *complaint = Complaint::Said;
                Some(text)
            }
            other => {
                *complaint = other;
                None
            }
        }
    }

    /// Reads a result; one that cannot be used is not found again.
    ///
    /// # Errors
    /// Why it cannot.
    pub(super) fn get(&self, path: &Path, key: &Key, grid: &Grid, kind: &Kind) -> io::Result<Given> {
        let read = File::open(path).and_then(|file| {
            let size = file.metadata()?.len();
            entry::read(io::BufReader::new(file), size, key, grid, kind)
        });
        match &read {
            Ok(_) => {
                // Its age tells the trimming what is in use; a folder that cannot be written is still good to read.
                let now = fs::FileTimes::new().set_modified(SystemTime::now());
                let _ = File::options().append(true).open(path).and_then(|f| f.set_times(now));
            }
            Err(e) => {
                lock(&self.shunned).insert(path.to_owned());
                // Too many open files, or a disk that fails, say nothing about the file.
                if e.kind() == io::ErrorKind::InvalidData {
                    let _ = fs::remove_file(path);
                }
            }
        }
        read
    }
}

/// A file under a passing name with the permissions that the umask leaves: a temporary file is its maker's alone.
fn shared() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PASSING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// The name of the file of a window.
fn name_of(grid: &Grid) -> String {
    format!("{}_{}_{}_{}", grid.col, grid.row, grid.cols, grid.rows)
}

/// The window that a file is named for.
fn window_of(name: &str, lattice: Lattice) -> Option<Grid> {
    let numbers: Option<Vec<i64>> = name.split('_').map(|n| n.parse().ok()).collect();
    let &[col, row, cols, rows] = &numbers?[..] else { return None };
    let near = |n: i64| (-FARTHEST..=FARTHEST).contains(&n);
    let count = |n: i64| usize::try_from(n).ok().filter(|n| *n > 0);
    (near(col) && near(row) && near(cols) && near(rows)).then_some(())?;
    Some(Grid { lattice, col, row, cols: count(cols)?, rows: count(rows)? })
}

#[cfg(test)]
mod tests;
