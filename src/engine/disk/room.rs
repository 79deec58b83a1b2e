//! How many bytes the cache folder holds, and which files go when there are too many.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Age of a passing file that nobody is writing any more: a writer that lives touches its own at every block.
const ABANDONED: Duration = Duration::from_secs(3600);
/// Beginning of the names of the folders of all versions of the program.
const VERSIONS: &str = "orograph-";
/// Share of the limit that this process adds before it counts again what others added.
const UNSEEN: u64 = 8;

/// The bytes of a folder that several processes fill.
#[derive(Debug)]
pub(super) struct Room {
    top: PathBuf,
    limit: u64,
    /// Bytes that were there when they were counted last, and what this process wrote since.
    held: u64,
    /// Of them, what this process wrote since.
    added: u64,
}

/// A file of the folder.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Old {
    used: SystemTime,
    bytes: u64,
    path: PathBuf,
}

impl Room {
    /// Counts a folder and trims it to its limit.
    pub(super) fn open(top: &Path, limit: u64) -> Self {
        let mut room = Self { top: top.to_owned(), limit, held: 0, added: 0 };
        room.trim(0);
        room
    }

    pub(super) fn limit(&self) -> u64 {
        self.limit
    }

    /// Makes room for a file, and counts it; whether there is room at all.
    pub(super) fn make(&mut self, bytes: u64) -> bool {
        if bytes > self.limit {
            return false;
        }
        if self.held.saturating_add(bytes) > self.limit || self.added > self.limit / UNSEEN {
            self.trim(bytes);
        }
        self.held += bytes;
        self.added += bytes;
        true
    }

    /// Counts anew. Where the folder and some bytes more are over the limit, removes the files that were not used for
    /// longest, somewhat more than there must be, so that not every file asks for it.
    fn trim(&mut self, more: u64) {
        let mut files = self.files();
        files.sort();
        self.added = 0;
        self.held = files.iter().fold(0, |sum: u64, f| sum.saturating_add(f.bytes));
        if self.held.saturating_add(more) <= self.limit {
            return;
        }
        let target = (self.limit - self.limit / UNSEEN).min(self.limit - more.min(self.limit));
        for file in files {
            if self.held <= target {
                break;
            }
            // Another process may have removed it already; one that cannot be removed still takes its room.
            match fs::remove_file(&file.path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => continue,
                _ => self.held -= file.bytes,
            }
            if let Some(folder) = file.path.parent() {
                // The last one leaves an empty folder; one that is not empty stays.
                let _ = fs::remove_dir(folder);
            }
        }
    }

    /// The files of all versions; what was left half written long ago goes at once.
    fn files(&self) -> Vec<Old> {
        let below = |path: PathBuf| fs::read_dir(path).into_iter().flatten().flatten();
        let is_version = |e: &fs::DirEntry| e.file_name().to_string_lossy().starts_with(VERSIONS);
        let versions = below(self.top.clone()).filter(is_version);
        let keys = versions.flat_map(|v| below(v.path())).flat_map(|k| below(k.path()));
        keys.flat_map(|k| below(k.path())).filter_map(|e| old(&e)).collect()
    }
}

fn old(entry: &fs::DirEntry) -> Option<Old> {
    let meta = entry.metadata().ok().filter(fs::Metadata::is_file)?;
    let file = Old { used: meta.modified().ok()?, bytes: meta.len(), path: entry.path() };
    let is_passing = entry.file_name().to_string_lossy().starts_with('.');
    let age = SystemTime::now().duration_since(file.used).unwrap_or_default();
    if is_passing && age > ABANDONED && fs::remove_file(&file.path).is_ok() { None } else { Some(file) }
}
