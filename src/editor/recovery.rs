//! Recovery after a crash, and claims on files. Unsaved work is written to the user's own folder every few seconds and
//! offered at the next start. A claim warns when two editors have one file open.
//!
//! Each session holds a lock on a file of its own. The system releases the lock when the process ends, however it ends,
//! so that a session whose lock is free is over.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use cap_std::ambient_authority;
use cap_std::fs::Dir;
use serde::{Deserialize, Serialize};

use super::document::Document;
use crate::graph::{Graph, LoadError};
use crate::nodes::Registry;
use crate::whole::{self, Known};

/// The longest time until unsaved work is written.
const EVERY: Duration = Duration::from_secs(3);

/// Unsaved work as it is stored.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    path: Option<PathBuf>,
    graph: String,
    /// The hash of what the file held, see [`Document::file_hash`].
    #[serde(default)]
    known: Option<String>,
}

/// The store of the unsaved work of one session.
#[derive(Debug)]
pub(crate) struct Keeper {
    folder: PathBuf,
    id: String,
    /// The lock that lasts as long as the session.
    _lock: File,
    kept_state: Option<u64>,
    last: Instant,
    writing: Option<JoinHandle<std::io::Result<()>>>,
    /// Recovered work that this session has not yet written itself.
    recovered: Vec<Orphan>,
}

/// The unsaved work of a session that crashed.
#[derive(Clone, Debug)]
pub(crate) struct Orphan {
    /// The file it belongs to, if it had one.
    pub(crate) path: Option<PathBuf>,
    pub(crate) graph: String,
    pub(crate) when: SystemTime,
    known: Option<String>,
    files: [PathBuf; 2],
    /// The lock of the crashed session, held so that no other editor offers the same work.
    _lock: Arc<File>,
}

impl Orphan {
    /// The work as a document.
    ///
    /// # Errors
    /// Fails when the stored text is no graph.
    pub(crate) fn document(&self, registry: &Registry) -> Result<Document, LoadError> {
        let graph = Graph::from_bytes(self.graph.as_bytes(), registry)?;
        Ok(Document::recovered(graph, self.path.clone(), self.known.as_deref()))
    }

    /// Removes the stored work.
    pub(crate) fn forget(&self) {
        for file in &self.files {
            // Work that cannot be removed is offered again, which loses nothing.
            let _ = std::fs::remove_file(file);
        }
    }
}

fn sessions(home: &Path) -> PathBuf {
    home.join("sessions")
}

impl Keeper {
    /// Starts a session.
    ///
    /// # Errors
    /// Fails when the folder cannot be written.
    pub(crate) fn start(home: &Path) -> std::io::Result<Self> {
        let folder = sessions(home);
        std::fs::create_dir_all(&folder)?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let id = format!("{}-{}", std::process::id(), now.as_nanos());
        let lock = whole::locked(&folder.join(format!("{id}.lock")))?;
        let (last, recovered) = (Instant::now(), Vec::new());
        Ok(Self { folder, id, _lock: lock, kept_state: None, last, writing: None, recovered })
    }

    /// Takes over recovered work. The files of the crashed session are removed once this session has written the same
    /// work, which the next call of [`keep`](Self::keep) starts.
    pub(crate) fn take(&mut self, orphan: Orphan) {
        self.recovered.push(orphan);
        self.kept_state = None;
    }

    fn file(&self, extension: &str) -> PathBuf {
        self.folder.join(format!("{}.{extension}", self.id))
    }

    /// Starts to write unsaved work when that is due. Returns the time until the next call, where one is needed.
    ///
    /// # Errors
    /// Returns the error of the last writing, once.
    pub(crate) fn keep(&mut self, document: &Document) -> std::io::Result<Option<Duration>> {
        if let Some(writing) = self.writing.take_if(|w| w.is_finished()) {
            let failed = || Err(std::io::Error::other("the writer stopped"));
            writing.join().unwrap_or_else(|_| failed())?;
        }
        if !document.is_unsaved() {
            // The work was saved or discarded.
            self.recovered.drain(..).for_each(|orphan| orphan.forget());
            if self.kept_state.take().is_some() {
                // The file may be gone already.
                let _ = std::fs::remove_file(self.file("json"));
            }
            return Ok(None);
        }
        if self.kept_state == Some(document.state()) || self.writing.is_some() {
            let again = Duration::from_millis(100);
            return Ok((!self.recovered.is_empty()).then_some(again));
        }
        let wait = EVERY.saturating_sub(self.last.elapsed());
        if !wait.is_zero() && self.recovered.is_empty() {
            return Ok(Some(wait));
        }
        self.last = Instant::now();
        self.kept_state = Some(document.state());
        let (graph, path) = (document.shared(), document.path().map(Path::to_owned));
        let (known, to, recovered) =
            (document.file_hash(), self.file("json"), std::mem::take(&mut self.recovered));
        self.writing = Some(std::thread::spawn(move || {
            write(&graph, path, known, &to)?;
            recovered.iter().for_each(Orphan::forget);
            Ok(())
        }));
        Ok(None)
    }

    /// The unsaved work of sessions that crashed, newest first.
    pub(crate) fn orphans(&self) -> Vec<Orphan> {
        if let Ok(dir) = Dir::open_ambient_dir(&self.folder, ambient_authority()) {
            whole::sweep(&dir, |_| true);
        }
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return Vec::new() };
        let mut found = Vec::new();
        for path in entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "lock"))
        {
            if path == self.file("lock") {
                continue;
            }
            let Ok(lock) = OpenOptions::new().write(true).open(&path) else { continue };
            if lock.try_lock().is_err() {
                continue;
            }
            let kept = path.with_extension("json");
            match orphan(&kept, &path, lock) {
                Some(orphan) => found.push(orphan),
                // The session crashed without unsaved work.
                None if !kept.exists() => _ = std::fs::remove_file(&path),
                None => (),
            }
        }
        found.sort_by_key(|o| std::cmp::Reverse(o.when));
        found
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if let Some(writing) = self.writing.take() {
            let _ = writing.join();
        }
        let _ = std::fs::remove_file(self.file("json"));
        let _ = std::fs::remove_file(self.file("lock"));
    }
}

fn write(graph: &Graph, path: Option<PathBuf>, known: Option<String>, to: &Path) -> std::io::Result<()> {
    let graph = String::from_utf8_lossy(&graph.to_bytes()).into_owned();
    whole::save(to, &serde_json::to_vec(&Kept { path, graph, known })?, Known::Anything)
}

fn orphan(kept: &Path, path: &Path, lock: File) -> Option<Orphan> {
    let when = kept.metadata().ok()?.modified().ok()?;
    let files = [kept.to_owned(), path.to_owned()];
    let Kept { path, graph, known } = serde_json::from_slice(&std::fs::read(kept).ok()?).ok()?;
    Some(Orphan { path, graph, when, known, files, _lock: Arc::new(lock) })
}

/// A lock that stands for a graph file; a second editor sees by it that the file is open.
#[derive(Debug)]
pub(crate) struct Claim {
    _lock: File,
}

/// The result of a claim on a file.
#[derive(Debug)]
pub(crate) enum Claimed {
    Ours(Claim),
    /// Another editor has it open.
    Taken,
    /// The lock could not be made.
    Unknown,
}

/// Claims a graph file.
pub(crate) fn claim(home: &Path, graph: &Path) -> Claimed {
    let full = graph.canonicalize().unwrap_or_else(|_| graph.to_owned());
    let name = blake3::hash(full.as_os_str().as_encoded_bytes());
    let folder = home.join("claims");
    let file = std::fs::create_dir_all(&folder)
        .and_then(|()| File::create(folder.join(format!("{}.lock", &name.to_hex()[..24]))));
    match file.map(|f| (f.try_lock(), f)) {
        Ok((Ok(()), lock)) => Claimed::Ours(Claim { _lock: lock }),
        Ok((Err(std::fs::TryLockError::WouldBlock), _)) => Claimed::Taken,
        _ => Claimed::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::Registry;

    fn unsaved() -> Document {
        let mut document = Document::untitled(&Registry::standard());
        document.edit("Add", |g| g.add("hills", "fractal_noise")).expect("adds");
        document
    }

    fn keep_now(keeper: &mut Keeper, document: &Document) {
        keeper.last = Instant::now() - EVERY;
        keeper.keep(document).expect("starts");
        if let Some(writing) = keeper.writing.take() {
            writing.join().expect("ends").expect("writes");
        }
    }

    #[test]
    fn a_session_that_did_not_end_well_leaves_its_work() {
        let home = tempfile::tempdir().expect("a folder");
        let mut lost = Keeper::start(home.path()).expect("starts");
        let document = unsaved();
        keep_now(&mut lost, &document);
        let next = Keeper::start(home.path()).expect("starts");
        assert!(next.orphans().is_empty(), "the first session still lives");
        // What the system does when a process is killed.
        lost._lock.unlock().expect("unlocks");
        std::mem::forget(lost);
        let orphans = next.orphans();
        assert_eq!(orphans.len(), 1);
        let graph = Graph::from_bytes(orphans[0].graph.as_bytes(), &Registry::standard()).expect("a graph");
        assert_eq!(graph.to_bytes(), document.graph().to_bytes());
        orphans[0].forget();
        assert!(next.orphans().is_empty());
    }

    #[test]
    fn recovered_work_is_kept_before_what_was_left_goes() {
        let home = tempfile::tempdir().expect("a folder");
        let mut lost = Keeper::start(home.path()).expect("starts");
        keep_now(&mut lost, &unsaved());
        lost._lock.unlock().expect("unlocks");
        let left = lost.file("json");
        std::mem::forget(lost);
        let mut next = Keeper::start(home.path()).expect("starts");
        let orphan = next.orphans().remove(0);
        let document = orphan.document(&Registry::standard()).expect("a graph");
        assert!(Keeper::start(home.path()).expect("starts").orphans().is_empty(), "it is being offered");
        next.take(orphan);
        assert!(left.exists() && !next.file("json").exists());
        // The work is written at once and not after the usual time.
        assert_eq!(next.keep(&document).expect("starts"), None);
        next.writing.take().expect("writes").join().expect("ends").expect("writes");
        assert!(!left.exists() && next.file("json").exists());
        let again: Kept =
            serde_json::from_slice(&std::fs::read(next.file("json")).expect("reads")).expect("JSON");
        assert_eq!(again.graph.as_bytes(), document.graph().to_bytes());
    }

    #[test]
    fn recovered_work_that_cannot_be_kept_is_offered_again() {
        let home = tempfile::tempdir().expect("a folder");
        let mut lost = Keeper::start(home.path()).expect("starts");
        keep_now(&mut lost, &unsaved());
        lost._lock.unlock().expect("unlocks");
        std::mem::forget(lost);
        let mut next = Keeper::start(home.path()).expect("starts");
        let orphan = next.orphans().remove(0);
        let document = orphan.document(&Registry::standard()).expect("a graph");
        // No file can be written where a folder stands.
        std::fs::create_dir(next.file("json")).expect("makes");
        next.take(orphan);
        next.keep(&document).expect("starts");
        next.writing.take().expect("writes").join().expect("ends").expect_err("fails");
        assert_eq!(next.orphans().len(), 1);
    }

    #[test]
    fn nothing_is_left_of_a_session_that_ends() {
        let home = tempfile::tempdir().expect("a folder");
        let mut keeper = Keeper::start(home.path()).expect("starts");
        keep_now(&mut keeper, &unsaved());
        drop(keeper);
        assert_eq!(std::fs::read_dir(sessions(home.path())).expect("a folder").count(), 0);
    }

    #[test]
    fn a_file_is_claimed_once() {
        let home = tempfile::tempdir().expect("a folder");
        let file = home.path().join("a.graph");
        let first = claim(home.path(), &file);
        assert!(matches!(first, Claimed::Ours(_)));
        assert!(matches!(claim(home.path(), &file), Claimed::Taken));
        drop(first);
        assert!(matches!(claim(home.path(), &file), Claimed::Ours(_)));
    }
}
