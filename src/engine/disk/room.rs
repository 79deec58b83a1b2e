//! The bytes in the cache folder, and the removal of files beyond the limit.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The age from which a temporary file is abandoned; a running writer modifies its file with every block.
const ABANDONED: Duration = Duration::from_secs(3600);
/// The prefix of the names of the folders of all program versions.
const VERSIONS: &str = "orograph-";
/// The folder is counted again, for files of other processes, after this process has added `1 / UNSEEN` of the limit.
const UNSEEN: u64 = 8;

/// The bytes of a folder that several processes fill.
#[derive(Debug)]
pub(super) struct Room {
    top: PathBuf,
    limit: u64,
    /// Bytes at the last count, and those that this process has written since.
    held: u64,
    /// Bytes that this process has written since the last count.
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

    /// Makes room for a file and counts it; returns whether there is room.
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

    /// Counts the folder again. Where it and `more` bytes exceed the limit, removes the least recently used files, and
    /// somewhat more of them than necessary, so that trimming is rare.
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
            // Another process may have removed the file already. A file that cannot be removed still counts.
            match fs::remove_file(&file.path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => continue,
                _ => self.held -= file.bytes,
            }
            if let Some(folder) = file.path.parent() {
                // This removes the folder where the file was its last one, and fails otherwise.
                let _ = fs::remove_dir(folder);
            }
        }
    }

    /// The files of all program versions. Abandoned temporary files are removed at once.
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
