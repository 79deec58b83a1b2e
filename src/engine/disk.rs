//! The cache folder. It has a folder for each key, and in that a file for each window, which is checked when it is
//! read.
//!
//! Files are written under a temporary name and renamed, so that a file is always whole and several processes can share
//! the folder. A damaged file is removed. A file that cannot be read for another reason is not tried again by this
//! process. In both cases the result is computed. Files get the permissions of the user's umask, so that users can
//! share the folder. The folders of other program versions, or of other forms of file, are never read.

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

/// The default limit of the bytes in the folder.
pub const DEFAULT_LIMIT: u64 = 32 << 30;
/// The largest coordinate of a window in the name of a file, in samples. It is far larger than any lattice, and sums of
/// it do not overflow.
const FARTHEST: i64 = 1 << 40;
/// The prefix of the names of files that are being written.
const PASSING: &str = ".part-";

/// The name of the folder of this program version and this form of files. Both are no part of the keys.
fn salt() -> String {
    format!("orograph-{}-{}", env!("CARGO_PKG_VERSION"), entry::FORM)
}

/// A folder of results.
#[derive(Debug)]
pub(super) struct Disk {
    top: PathBuf,
    folder: PathBuf,
    room: Mutex<Room>,
    /// Files that could not be used, such as another user's, or damaged ones that cannot be removed.
    shunned: Mutex<BTreeSet<PathBuf>>,
    complaint: Mutex<Complaint>,
}

/// The message that the folder cannot store all results, which is given once.
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
    /// Opens a folder with a limit in bytes.
    ///
    /// # Errors
    /// Fails when the folder does not exist and cannot be made. A folder that cannot be written is still read.
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

    /// The path of a file whose window contains the wanted one. Windows of one graph differ between evaluations,
    /// because consumers that are cached themselves need nothing.
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

    /// Writes a result. A failure is reported once by [`complaint`](Self::complaint) and changes no result.
    pub(super) fn put(&self, key: &Key, grid: &Grid, given: &Given) {
        let path = self.windows(key).join(name_of(grid));
        let written = self.write(&path, key, given).or_else(|e| match e.kind() {
            // Another process has just removed the empty folder while trimming.
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

    /// The message that the folder cannot store all results; `None` where it was given before.
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

    /// Reads a result. A file that cannot be used is not found again.
    ///
    /// # Errors
    /// Fails when the file cannot be read or is damaged.
    pub(super) fn get(&self, path: &Path, key: &Key, grid: &Grid, kind: &Kind) -> io::Result<Given> {
        let read = File::open(path).and_then(|file| {
            let size = file.metadata()?.len();
            entry::read(io::BufReader::new(file), size, key, grid, kind)
        });
        match &read {
            Ok(_) => {
                // The time of modification tells the trimming which files are in use. Setting it fails in a folder that
                // cannot be written, which is no error.
                let now = fs::FileTimes::new().set_modified(SystemTime::now());
                let _ = File::options().append(true).open(path).and_then(|f| f.set_times(now));
            }
            Err(e) => {
                lock(&self.shunned).insert(path.to_owned());
                // Other errors, such as too many open files or a failing disk, do not mean that the file is damaged.
                if e.kind() == io::ErrorKind::InvalidData {
                    let _ = fs::remove_file(path);
                }
            }
        }
        read
    }
}

/// A builder of files with a temporary name and the permissions of the umask; by default only their owner could read
/// them.
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

/// The window in the name of a file.
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
