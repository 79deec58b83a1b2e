//! Files under passing names: `.NAME.KERNEL-NUMBER.part`, locked by the writer that is at work on them.

use std::ffi::{OsStr, OsString};
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::io;
use std::sync::OnceLock;
use std::time::Duration;

use cap_std::fs::{Dir, OpenOptions};

/// How long a file must have been left alone to be taken for a dead writer's where its lock may not tell: the writer
/// may be at work on another machine.
const QUIET: Duration = Duration::from_secs(600);
/// Longest name that stands whole in a passing name, in bytes: file systems take 255.
const LONGEST: usize = 200;

/// A file under a passing name, removed when it is dropped before it has its own.
pub(super) struct Passing<'a> {
    dir: &'a Dir,
    pub(super) name: OsString,
    /// Locked as long as it is open.
    pub(super) file: File,
    kept: bool,
}

impl Drop for Passing<'_> {
    fn drop(&mut self) {
        if !self.kept {
            // Nothing can be done about a folder that refuses; the error that led here is reported.
            let _ = self.dir.remove_file(&self.name);
        }
    }
}

impl<'a> Passing<'a> {
    pub(super) fn make(dir: &'a Dir, name: &OsStr) -> io::Result<Self> {
        loop {
            let mut passing = OsString::from(".");
            passing.push(short(name));
            passing.push(format!(".{}-{:016x}.part", kernel().unwrap_or("0"), number()));
            let mut options = OpenOptions::new();
            options.read(true).write(true).create_new(true);
            let file = match dir.open_with(&passing, &options) {
                Ok(file) => file.into_std(),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(e) => return Err(e),
            };
            // A sweep between the making and the lock has taken it for a dead writer's: it holds the lock, or the name
            // is gone. Where there are no locks the age tells.
            let swept = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
            let passing = Self { dir, name: passing, file, kept: false };
            if !swept && dir.symlink_metadata(&passing.name).is_ok() {
                return Ok(passing);
            }
        }
    }

    /// Gives it its own name; it stays locked while the handle is open.
    pub(super) fn rename(mut self, name: &OsStr) -> io::Result<File> {
        self.dir.rename(&self.name, self.dir, name)?;
        self.kept = true;
        self.file.try_clone()
    }
}

/// A file under a passing name that stands in a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Left<'a> {
    file: &'a [u8],
    kernel: &'a str,
}

impl<'a> Left<'a> {
    /// Takes a name apart; none where it is no passing name.
    fn of(name: &'a OsStr) -> Option<Self> {
        let name = name.as_encoded_bytes().strip_prefix(b".")?.strip_suffix(b".part")?;
        let dot = name.iter().rposition(|b| *b == b'.')?;
        let (kernel, number) = std::str::from_utf8(&name[dot + 1..]).ok()?.split_once('-')?;
        let hex = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_hexdigit());
        (dot > 0 && hex(kernel) && hex(number)).then_some(Self { file: &name[..dot], kernel })
    }

    /// Whether it was to become the file of this name.
    pub fn is_of(&self, name: impl AsRef<OsStr>) -> bool {
        short(name.as_ref()).as_encoded_bytes() == self.file
    }
}

/// Removes what dead writers left in a folder, of the files that are the caller's.
///
/// A lock that is free tells at once that the writer is dead where it ran under this machine's kernel, which keeps the
/// lock; what another machine wrote must have been left alone for ten minutes as well.
pub fn sweep(dir: &Dir, is_ours: impl Fn(&Left<'_>) -> bool) {
    let Ok(entries) = dir.entries() else { return };
    let names = entries.flatten().map(|e| e.file_name());
    let left: Vec<_> = names.filter(|name| Left::of(name).is_some_and(|left| is_ours(&left))).collect();
    left.iter().for_each(|name| remove_dead(dir, name));
}

fn remove_dead(dir: &Dir, name: &OsStr) {
    let Ok(meta) = dir.symlink_metadata(name) else { return };
    let age = meta.modified().ok().and_then(|m| m.into_std().elapsed().ok());
    let is_quiet = age.is_some_and(|age| age > QUIET);
    let is_near = kernel().is_some() && Left::of(name).map(|left| left.kernel) == kernel();
    if !meta.is_file() || !(is_near || is_quiet) {
        return;
    }
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    let file = dir.open_with(name, &options).or_else(|_| dir.open(name)).map(|f| f.into_std());
    // Held until the file is gone, so that its writer, if it is only just there, sees it.
    let is_dead = match file.as_ref().map(File::try_lock) {
        Ok(Ok(())) => true,
        Ok(Err(TryLockError::WouldBlock)) => false,
        Ok(Err(TryLockError::Error(_))) | Err(_) => is_quiet,
    };
    if is_dead {
        // Another process may have removed it already.
        let _ = dir.remove_file(name);
    }
}

/// A name short enough to stand in a passing name.
fn short(name: &OsStr) -> OsString {
    if name.len() <= LONGEST {
        return name.to_owned();
    }
    let text = name.to_string_lossy();
    let start = &text[..text.floor_char_boundary(LONGEST - 20)];
    format!("{start}~{}", &blake3::hash(name.as_encoded_bytes()).to_hex()[..16]).into()
}

/// Which running kernel this is: processes under one see each other's locks, in containers as well. Not known on
/// every system.
fn kernel() -> Option<&'static str> {
    static KERNEL: OnceLock<Option<String>> = OnceLock::new();
    let find = || {
        let boot = std::fs::read("/proc/sys/kernel/random/boot_id").ok()?;
        Some(blake3::hash(&boot).to_hex()[..8].to_owned())
    };
    KERNEL.get_or_init(find).as_deref()
}

/// A number that no other writer is likely to draw.
fn number() -> u64 {
    RandomState::new().build_hasher().finish()
}
