//! The files of one evaluation. Each is opened once, so that the plan and the run have the same content.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use super::files::{Allowed, Refusal, Spot};
use crate::node::{Error, FileRequest};
use crate::source::{Place, ReadAt, Shelf, SourceError, SourceFile};

/// The age of the last change from which the stamp of a file identifies its content. The clocks of file systems tick
/// every two seconds or more often, and two writes within a tick can leave the same stamp.
const SETTLED: Duration = Duration::from_secs(2);

/// The metadata that changes when the content of a file does.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
    /// Device, inode and the time of the last change of either, where the system has them.
    identity: Option<[i64; 4]>,
}

impl Stamp {
    fn of(file: &std::fs::File) -> std::io::Result<Self> {
        let meta = file.metadata()?;
        Ok(Self { bytes: meta.len(), modified: meta.modified().ok(), identity: identity(&meta) })
    }

    /// Whether the last write is so long ago that a further one would change the stamp.
    fn is_settled(&self, now: SystemTime) -> bool {
        self.modified.and_then(|m| now.duration_since(m).ok()).is_some_and(|age| age >= SETTLED)
    }
}

#[cfg(unix)]
fn identity(meta: &std::fs::Metadata) -> Option<[i64; 4]> {
    use std::os::unix::fs::MetadataExt as _;
    Some([meta.dev() as i64, meta.ino() as i64, meta.ctime(), meta.ctime_nsec()])
}

#[cfg(not(unix))]
fn identity(_: &std::fs::Metadata) -> Option<[i64; 4]> {
    None
}

/// Hashes of files, by path and stamp.
#[derive(Debug, Default)]
pub(super) struct Hashes(Mutex<BTreeMap<PathBuf, (Stamp, [u8; 32])>>);

impl Hashes {
    fn known(&self) -> MutexGuard<'_, BTreeMap<PathBuf, (Stamp, [u8; 32])>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, path: &PathBuf, stamp: &Stamp) -> Option<[u8; 32]> {
        self.known().get(path).filter(|(s, _)| s == stamp).map(|(_, hash)| *hash)
    }
}

/// A file with the stamp it had when it was opened.
#[derive(Debug)]
struct Stamped {
    spot: Spot,
    stamp: Stamp,
    /// When the stamp was taken.
    taken: SystemTime,
    hashes: Arc<Hashes>,
}

impl Place for Stamped {
    fn open(&self) -> Result<Box<dyn ReadAt + '_>, SourceError> {
        let file = self.spot.open().map_err(|refusal| match refusal {
            Refusal::Absent => SourceError::Changed("it is gone now".into()),
            other => SourceError::Unreadable(other.to_string()),
        })?;
        let len = file.metadata()?.len();
        Ok(Box::new(Opened { file, len }))
    }

    fn learned(&self, hash: [u8; 32]) {
        let now = self.spot.open().ok().and_then(|file| Stamp::of(&file).ok());
        if now == Some(self.stamp) && self.stamp.is_settled(self.taken) {
            self.hashes.known().insert(self.spot.path(), (self.stamp, hash));
        }
    }
}

/// An open file.
struct Opened {
    file: std::fs::File,
    len: u64,
}

impl ReadAt for Opened {
    fn len(&self) -> u64 {
        self.len
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> std::io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, buffer, offset)
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut buffer: &mut [u8]) -> std::io::Result<()> {
        use std::os::windows::fs::FileExt as _;
        while !buffer.is_empty() {
            match self.file.seek_read(buffer, offset)? {
                0 => return Err(std::io::ErrorKind::UnexpectedEof.into()),
                n => {
                    offset += n as u64;
                    buffer = &mut buffer[n..];
                }
            }
        }
        Ok(())
    }
}

type Looked = Result<Arc<SourceFile>, Refusal>;

/// The files of one evaluation, by their names in the graph.
#[derive(Debug)]
pub(super) struct Sources {
    allowed: Arc<Allowed>,
    hashes: Arc<Hashes>,
    shelf: Arc<Shelf>,
    looked: Mutex<BTreeMap<String, Looked>>,
}

impl Sources {
    pub(super) fn new(allowed: Arc<Allowed>, hashes: Arc<Hashes>, shelf: Arc<Shelf>) -> Self {
        Self { allowed, hashes, shelf, looked: Mutex::default() }
    }

    /// The files for the requests of a node, in their order; `None` for an optional file that is absent.
    ///
    /// # Errors
    /// Returns [`Error::File`] with the reason.
    pub(super) fn find(&self, requests: &[FileRequest]) -> Result<Vec<Option<Arc<SourceFile>>>, Error> {
        let one = |request: &FileRequest| match self.look(&request.name) {
            Ok(file) => Ok(Some(file)),
            Err(Refusal::Absent) if request.optional => Ok(None),
            Err(refusal) => Err(refusal.of(request)),
        };
        requests.iter().map(one).collect()
    }

    fn look(&self, name: &str) -> Looked {
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = looked.get(name) {
            return known.clone();
        }
        let fresh = self.fresh(name).map(Arc::new);
        looked.insert(name.to_owned(), fresh.clone());
        fresh
    }

    fn fresh(&self, name: &str) -> Result<SourceFile, Refusal> {
        let taken = SystemTime::now();
        let (spot, file) = self.allowed.open(name)?;
        let stamp = Stamp::of(&file)?;
        let known = self.hashes.get(&spot.path(), &stamp);
        let place = Stamped { spot, stamp, taken, hashes: self.hashes.clone() };
        let source = SourceFile::at(name.to_owned(), stamp.bytes, Box::new(place), self.shelf.clone());
        Ok(known.into_iter().fold(source, SourceFile::with_hash))
    }
}
