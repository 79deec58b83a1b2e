//! Bytes that a graph may read, wherever they lie.
//!
//! A [`SourceFile`] is known by its length and its first bytes before its content is read. Its content counts in the
//! key of a result by a hash, which is taken in blocks and never holds the whole. A node reads the content when it
//! runs, and the hash is compared: what was planned is what is read, or the node fails.
//!
//! Nothing is mapped into memory: a map of a file that is cut short ends the process.
//!
//! # Caching
//! What a node decoded stands on a [`Shelf`], by the content it was decoded from and the way it was decoded. The shelf
//! says how many bytes it holds and gives up what was not used for longest. The content itself is let go.

mod shelf;

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::{Arc, OnceLock};

pub use shelf::Shelf;

use crate::cost::Cost;
use crate::error::Error;
use crate::work::{Cancelled, Work};

/// Most bytes of [`SourceFile::head`].
pub const HEAD_BYTES: u64 = 1 << 16;
/// Bytes that are read at once: large enough for a disk, small enough to stop soon.
const BLOCK_BYTES: usize = 1 << 20;

/// Random access to some bytes.
pub trait ReadAt: Send + Sync {
    /// How many bytes there are.
    fn len(&self) -> u64;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills a buffer with the bytes from `offset` on.
    ///
    /// # Errors
    /// When there are fewer bytes than the buffer takes, or they cannot be read.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()>;
}

impl ReadAt for [u8] {
    fn len(&self) -> u64 {
        <[u8]>::len(self) as u64
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        let from = usize::try_from(offset).ok();
        let part = from.and_then(|from| self.get(from..from.checked_add(buffer.len())?));
        buffer.copy_from_slice(part.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl ReadAt for Vec<u8> {
    fn len(&self) -> u64 {
        ReadAt::len(&self[..])
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        self[..].read_at(offset, buffer)
    }
}

impl<T: ReadAt + ?Sized> ReadAt for &T {
    fn len(&self) -> u64 {
        (**self).len()
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        (**self).read_at(offset, buffer)
    }
}

/// Random access as a stream, for libraries that want one.
pub struct Stream<'a> {
    from: &'a dyn ReadAt,
    position: u64,
}

impl<'a> Stream<'a> {
    /// A stream from the first byte on.
    pub fn new(from: &'a dyn ReadAt) -> Self {
        Self { from, position: 0 }
    }
}

impl Read for Stream<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.from.len().saturating_sub(self.position);
        let count = left.min(buffer.len() as u64) as usize;
        self.from.read_at(self.position, &mut buffer[..count])?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for Stream<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let target = match to {
            SeekFrom::Start(offset) => Some(offset),
            SeekFrom::End(offset) => self.from.len().checked_add_signed(offset),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
        };
        self.position = target.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

impl fmt::Debug for Stream<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "stream at {} of {}", self.position, self.from.len())
    }
}

/// Why bytes were not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The content is not the one that was looked at first.
    #[error("has changed since it was first looked at ({0}); run again")]
    Changed(String),
    /// It is missing, is not allowed, or cannot be read.
    #[error("{0}")]
    Unreadable(String),
}

impl SourceError {
    /// The same as a fault of the parameter that names the file.
    pub fn of(self, parameter: &'static str, file: &str) -> Error {
        match self {
            Self::Cancelled => Error::Cancelled,
            other => Error::File { parameter, file: file.to_owned(), message: other.to_string() },
        }
    }
}

/// The cost of holding the content of some files.
pub fn reading(files: &[Arc<SourceFile>]) -> Cost {
    Cost::of_reading(files.iter().fold(0, |sum, file| sum.saturating_add(file.len())))
}

impl From<Cancelled> for SourceError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<io::Error> for SourceError {
    fn from(e: io::Error) -> Self {
        match e.kind() {
            io::ErrorKind::UnexpectedEof => Self::Changed("it is shorter now".into()),
            _ => Self::Unreadable(format!("cannot be read: {e}")),
        }
    }
}

/// Where the bytes of a source come from: a file, a part of one, memory.
pub trait Place: Send + Sync {
    /// Opens the bytes.
    ///
    /// # Errors
    /// When they are not there any more, or may not be read.
    fn open(&self) -> Result<Box<dyn ReadAt + '_>, SourceError>;

    /// Called with the hash of the content, once it was read whole.
    fn learned(&self, hash: [u8; 32]) {
        let _ = hash;
    }
}

impl Place for Vec<u8> {
    fn open(&self) -> Result<Box<dyn ReadAt + '_>, SourceError> {
        Ok(Box::new(self))
    }
}

/// Bytes that a node reads, by the name that the graph gives them.
pub struct SourceFile {
    name: String,
    len: u64,
    place: Box<dyn Place>,
    hash: OnceLock<Result<[u8; 32], SourceError>>,
    shelf: Arc<Shelf>,
}

impl SourceFile {
    /// A source of a length that has not been read yet.
    pub fn at(name: String, len: u64, place: Box<dyn Place>, shelf: Arc<Shelf>) -> Self {
        Self { name, len, place, hash: OnceLock::new(), shelf }
    }

    /// A source that is in memory, on a shelf of its own.
    pub fn new(name: String, bytes: Vec<u8>) -> Self {
        let hash = *blake3::hash(&bytes).as_bytes();
        let len = bytes.len() as u64;
        Self::at(name, len, Box::new(bytes), Arc::default()).with_hash(hash)
    }

    /// The source with a hash that is known from before.
    #[must_use]
    pub fn with_hash(self, hash: [u8; 32]) -> Self {
        Self { hash: OnceLock::from(Ok(hash)), ..self }
    }

    /// The name as the graph wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of the content.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Whether the content is empty.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Opens the content for random access. Nothing that goes into a result may come from here alone: it is
    /// [`read`](Self::read) that compares the content with its hash.
    ///
    /// # Errors
    /// When it is gone, may not be read, or has another length.
    pub fn open(&self) -> Result<Box<dyn ReadAt + '_>, SourceError> {
        let opened = self.place.open()?;
        if opened.len() == self.len {
            Ok(opened)
        } else {
            Err(SourceError::Changed(format!("it had {} bytes and has {} now", self.len, opened.len())))
        }
    }

    /// The first bytes of the content, at most [`HEAD_BYTES`].
    ///
    /// # Errors
    /// Those of [`open`](Self::open).
    pub fn head(&self) -> Result<Vec<u8>, SourceError> {
        let mut head = vec![0; self.len.min(HEAD_BYTES) as usize];
        self.open()?.read_at(0, &mut head)?;
        Ok(head)
    }

    /// The hash of the content, BLAKE3, where it is known.
    pub fn known_hash(&self) -> Option<Result<[u8; 32], SourceError>> {
        self.hash.get().cloned()
    }

    /// The hash of the content, which is read in blocks where the hash is not known.
    ///
    /// # Errors
    /// When the work is cancelled, or the content cannot be read.
    pub fn hash(&self, work: &Work<'_>) -> Result<[u8; 32], SourceError> {
        if let Some(known) = self.known_hash() {
            return known;
        }
        let fresh = self.walk(work, |_| ());
        if fresh == Err(SourceError::Cancelled) {
            return fresh;
        }
        if let Ok(hash) = fresh {
            self.place.learned(hash);
        }
        self.hash.get_or_init(|| fresh).clone()
    }

    /// The whole content, held against the hash.
    ///
    /// # Errors
    /// When the work is cancelled, the content cannot be read, or it is another one.
    pub fn read(&self, work: &Work<'_>) -> Result<Vec<u8>, SourceError> {
        let too_long = || SourceError::Unreadable(format!("{} bytes do not fit into memory", self.len));
        let mut bytes = Vec::new();
        bytes
            .try_reserve_exact(usize::try_from(self.len).map_err(|_| too_long())?)
            .map_err(|_| too_long())?;
        let found = self.walk(work, |block| bytes.extend_from_slice(block))?;
        // A source that nobody hashed before is in no key: what is read now is what counts.
        if self.hash.get_or_init(|| Ok(found)).clone()? != found {
            return Err(SourceError::Changed("its content is another".into()));
        }
        Ok(bytes)
    }

    /// Goes through the content in blocks; gives its hash.
    fn walk(&self, work: &Work<'_>, mut take: impl FnMut(&[u8])) -> Result<[u8; 32], SourceError> {
        let opened = self.open()?;
        let mut hasher = blake3::Hasher::new();
        let mut block = vec![0; self.len.min(BLOCK_BYTES as u64) as usize];
        let mut offset = 0;
        while offset < self.len {
            work.check()?;
            let count = (self.len - offset).min(block.len() as u64) as usize;
            opened.read_at(offset, &mut block[..count])?;
            hasher.update(&block[..count]);
            take(&block[..count]);
            offset += count as u64;
            work.report(offset as f32 / self.len as f32);
        }
        drop(opened);
        // Somebody may have written meanwhile: then nobody knows which content was read.
        self.open()?;
        Ok(*hasher.finalize().as_bytes())
    }

    /// What the content decodes to in one way of decoding it, from the shelf where it stands there. `make` gives it
    /// with the bytes it holds, and runs once however many ask; it runs under a lock, so that parallel work in it
    /// must run on threads apart.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn decoded<T: Send + Sync + 'static, E>(
        &self,
        way: &[u8],
        make: impl FnOnce() -> Result<(T, u64), E>,
    ) -> Result<Arc<T>, E> {
        let content = match self.known_hash() {
            Some(Ok(hash)) => hash,
            // Of what is not known nothing can be found again.
            _ => return make().map(|(made, _)| Arc::new(made)),
        };
        self.shelf.get([&content[..], last_name(&self.name).as_bytes(), b"\0", way].concat(), make)
    }
}

impl fmt::Debug for SourceFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} bytes)", self.name, self.len)
    }
}

/// The last part of a name, without the folder it lies in.
pub fn last_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Cancel;

    #[test]
    fn bytes_are_read_at_any_place_and_not_beyond_the_end() {
        let bytes: &[u8] = b"0123456789";
        let mut three = [0; 3];
        bytes.read_at(7, &mut three).expect("inside");
        assert_eq!(&three, b"789");
        for beyond in [8, 10, 11, u64::MAX] {
            assert!(bytes.read_at(beyond, &mut three).is_err(), "{beyond}");
        }
        let mut text = String::new();
        let mut stream = Stream::new(&bytes);
        stream.seek(SeekFrom::End(-4)).expect("inside");
        stream.read_to_string(&mut text).expect("text");
        assert_eq!(text, "6789");
    }

    /// A place whose content changes from one opening to the next.
    struct Turning(std::sync::Mutex<Vec<&'static [u8]>>);

    impl Place for Turning {
        fn open(&self) -> Result<Box<dyn ReadAt + '_>, SourceError> {
            let mut left = self.0.lock().expect("nobody panics");
            Ok(Box::new(if left.len() > 1 { left.remove(0) } else { left[0] }))
        }
    }

    fn turning(contents: &[&'static [u8]]) -> SourceFile {
        let place = Turning(std::sync::Mutex::new(contents.to_vec()));
        SourceFile::at("a".into(), 3, Box::new(place), Arc::default())
    }

    #[test]
    fn content_that_is_another_than_the_hashed_one_is_refused() {
        let work = Work::default();
        let same = turning(&[b"abc"]);
        assert_eq!(same.hash(&work), Ok(*blake3::hash(b"abc").as_bytes()));
        assert_eq!(same.read(&work), Ok(b"abc".to_vec()));
        for (contents, why) in [
            ([b"abc", b"abc", b"abd" as &[u8], b"abd"], "its content is another"),
            ([b"abc", b"abc", b"ab", b"ab"], "it had 3 bytes and has 2 now"),
            ([b"abc", b"abc", b"abc", b"abcd"], "it had 3 bytes and has 4 now"),
        ] {
            let file = turning(&contents);
            file.hash(&work).expect("reads");
            assert_eq!(file.read(&work), Err(SourceError::Changed(why.into())));
        }
    }

    #[test]
    fn reading_and_hashing_stop_when_they_are_asked_to_and_can_go_on() {
        let file = turning(&[b"abc"]);
        let cancel = Cancel::default();
        cancel.cancel();
        let work = Work::new(&cancel);
        assert_eq!(file.hash(&work), Err(SourceError::Cancelled));
        assert_eq!(file.known_hash(), None);
        assert_eq!(file.read(&work), Err(SourceError::Cancelled));
        assert!(file.hash(&Work::default()).is_ok());
    }

    #[test]
    fn the_last_part_of_a_name_is_without_its_folder() {
        for (name, last) in [("a.tif", "a.tif"), ("d/e/a.tif", "a.tif"), ("C:\\d\\a.tif", "a.tif"), ("", "")]
        {
            assert_eq!(last_name(name), last);
        }
    }
}
