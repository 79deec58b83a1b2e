//! The one writer of files that are whole or not there.
//!
//! A file is written under a passing name in its own folder, made durable, and renamed over what had its name. The
//! file keeps the permissions of the one it replaces, and a new file gets those of the user's umask; a file that may
//! not be written is not replaced either. Whoever read the file before can ask that it is replaced only while it still
//! holds what was read ([`Known`]), so that nobody's work is lost.
//!
//! A writer holds a lock on its passing file. What a killed writer left is told from what a living one is at work on by
//! that lock, which the system gives back when a process ends, and by its age where other machines may be at work in
//! the same folder ([`sweep`]).

mod passing;

use std::ffi::OsStr;
use std::fs::{File, Permissions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use cap_std::ambient_authority;
use cap_std::fs::{Dir, Metadata};
use sha2::{Digest, Sha256};

use passing::Passing;
pub use passing::{Left, sweep};

/// What a written file is, for the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Its length.
    pub bytes: u64,
}

/// What the writer of a file knows of the one it replaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known<'a> {
    /// Whatever is there may be replaced.
    Anything,
    /// Nothing is there.
    Absent,
    /// It holds these bytes, or is gone.
    Bytes(&'a [u8]),
}

/// The file is not what its writer knew: somebody else wrote it in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("another program has changed the file since it was read; it is left as it is")]
pub struct Changed;

impl Changed {
    /// Whether this is why a file was not written.
    pub fn is(error: &io::Error) -> bool {
        error.get_ref().is_some_and(|e| e.is::<Self>())
    }
}

/// Writes a file of a folder.
///
/// A link of that name is replaced by the file, so that nothing outside the folder is written.
///
/// # Errors
/// Those of `write` and of the folder, [`Changed`] when the file is not what is known of it; then nothing is left
/// behind and an older file stays as it was.
pub fn write<T, E: From<io::Error>>(
    dir: &Dir,
    name: impl AsRef<OsStr>,
    known: Known<'_>,
    write: impl FnOnce(&mut File) -> Result<T, E>,
) -> Result<T, E> {
    put(dir, name.as_ref(), known, None, write)
}

/// Writes a file of a folder as [`write()`] does, and reads it back for its stamp: what is hashed is what is on the disk.
///
/// # Errors
/// As [`write()`].
pub fn write_stamped<T, E: From<io::Error>>(
    dir: &Dir,
    name: impl AsRef<OsStr>,
    write: impl FnOnce(&mut File) -> Result<T, E>,
) -> Result<(Stamp, T), E> {
    put(dir, name.as_ref(), Known::Anything, None, |file| {
        let given = write(file)?;
        Ok((stamp(file)?, given))
    })
}

/// Writes some bytes to where the user says. A link stays, and what it leads to is replaced; what a killed writer left
/// of this file goes.
///
/// # Errors
/// Those of the file system, [`Changed`] when the file is not what is known of it; it is then as it was.
pub fn save(path: &Path, bytes: &[u8], known: Known<'_>) -> io::Result<()> {
    save_like(path, bytes, known, None)
}

/// Writes some bytes as [`save()`] does; a new file gets the permissions of one that is gone, where they are known.
///
/// # Errors
/// As [`save()`].
pub fn save_like(path: &Path, bytes: &[u8], known: Known<'_>, gone: Option<Permissions>) -> io::Result<()> {
    let (folder, name) = place(path)?;
    let dir = Dir::open_ambient_dir(&folder, ambient_authority())?;
    sweep(&dir, |left| left.is_of(&name));
    put(&dir, &name, known, gone, |file| file.write_all(bytes))
}

/// Whether what has a name in a folder may be replaced: nothing, a link, a file that is not read-only.
///
/// # Errors
/// Why not.
pub fn may_replace(dir: &Dir, name: impl AsRef<OsStr>) -> io::Result<()> {
    replaced(dir, name.as_ref()).map(drop)
}

/// Tries whether a file could be written to where the user says; writes nothing.
///
/// # Errors
/// Why it could not.
pub fn probe(path: &Path) -> io::Result<()> {
    let (folder, name) = place(path)?;
    let dir = Dir::open_ambient_dir(folder, ambient_authority())?;
    probe_in(&dir, &name)
}

/// Tries whether a file of a folder could be written, as [`probe`] does.
///
/// # Errors
/// Why it could not.
pub fn probe_in(dir: &Dir, name: impl AsRef<OsStr>) -> io::Result<()> {
    may_replace(dir, name.as_ref())?;
    Passing::make(dir, name.as_ref()).map(drop)
}

/// Makes an empty file that is locked before anybody can see it under its name; the lock lasts as long as the handle.
///
/// # Errors
/// Those of the file system.
pub fn locked(path: &Path) -> io::Result<File> {
    let (folder, name) = place(path)?;
    let dir = Dir::open_ambient_dir(folder, ambient_authority())?;
    Passing::make(&dir, &name)?.rename(&name)
}

/// The folder and the name that a path leads to.
///
/// # Errors
/// When it names no file, or its links lead nowhere or in a circle.
pub fn place(path: &Path) -> io::Result<(PathBuf, std::ffi::OsString)> {
    const MOST_LINKS: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        match std::fs::read_link(&path) {
            Ok(target) => path = folder.join(target),
            Err(_) => {
                let name = path.file_name().filter(|_| !ends_as_folder(&path));
                return name.map(|name| (folder, name.to_owned())).ok_or_else(no_name);
            }
        }
    }
    Err(io::Error::other("its links go in a circle"))
}

/// Whether a path is written as that of a folder, with a separator at its end.
fn ends_as_folder(path: &Path) -> bool {
    path.as_os_str().as_encoded_bytes().last().is_some_and(|b| std::path::is_separator(char::from(*b)))
}

/// Whether Windows takes a file name for a device, whatever its extension.
pub fn is_device(name: &str) -> bool {
    let stem = name.split(['.', ':']).next().unwrap_or_default().trim_end().to_ascii_lowercase();
    let number = |rest: &str| matches!(rest, "¹" | "²" | "³") || matches!(rest.as_bytes(), [b'0'..=b'9']);
    let numbered = |device: &str| stem.strip_prefix(device).is_some_and(number);
    let plain = ["con", "prn", "aux", "nul", "conin$", "conout$"];
    plain.contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

fn no_name() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file")
}

fn put<T, E: From<io::Error>>(
    dir: &Dir,
    name: &OsStr,
    known: Known<'_>,
    gone: Option<Permissions>,
    write: impl FnOnce(&mut File) -> Result<T, E>,
) -> Result<T, E> {
    let separates = |b: &u8| matches!(b, b'/' | b'\\' | b'\0');
    if name.is_empty() || name == "." || name == ".." || name.as_encoded_bytes().iter().any(separates) {
        return Err(no_name().into());
    }
    let old = replaced(dir, name)?;
    // Before the work as well: a refusal after it would come late.
    check(dir, name, known)?;
    let mut passing = Passing::make(dir, name)?;
    let old = old.map(|old| old.permissions().into_std(&passing.file)).transpose()?;
    if let Some(permissions) = old.or(gone) {
        // At once, so that what only its owner may read is never open to others.
        passing.file.set_permissions(permissions)?;
    }
    let result = write(&mut passing.file)?;
    passing.file.sync_all()?;
    check(dir, name, known)?;
    passing.rename(name)?;
    // Makes the new name durable where folders can be synced; where they cannot, the file is still whole.
    if let Ok(folder) = dir.open(".") {
        let _ = folder.sync_all();
    }
    Ok(result)
}

/// The file that is replaced; none where there is none, or a link.
///
/// # Errors
/// When what is there may not be replaced.
fn replaced(dir: &Dir, name: &OsStr) -> io::Result<Option<Metadata>> {
    let refuse = |kind, why| Err(io::Error::new(kind, why));
    match dir.symlink_metadata(name) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
        Ok(old) if old.is_symlink() => Ok(None),
        Ok(old) if !old.is_file() => {
            refuse(io::ErrorKind::InvalidInput, "what is there is not a regular file")
        }
        Ok(old) if old.permissions().readonly() => {
            refuse(io::ErrorKind::PermissionDenied, "the file there is read-only")
        }
        Ok(old) => Ok(Some(old)),
    }
}

/// Whether the file is what its writer knows.
///
/// # Errors
/// [`Changed`] when it is not.
fn check(dir: &Dir, name: &OsStr, known: Known<'_>) -> io::Result<()> {
    let same = match known {
        Known::Anything => true,
        Known::Absent => dir.symlink_metadata(name).is_err_and(|e| e.kind() == io::ErrorKind::NotFound),
        Known::Bytes(bytes) => match dir.open(name) {
            Err(e) => e.kind() == io::ErrorKind::NotFound,
            Ok(file) => holds(file.into_std(), bytes)?,
        },
    };
    if same { Ok(()) } else { Err(io::Error::other(Changed)) }
}

/// Whether a file holds these bytes and no more.
fn holds(file: File, bytes: &[u8]) -> io::Result<bool> {
    if file.metadata()?.len() != bytes.len() as u64 {
        return Ok(false);
    }
    let mut found = Vec::with_capacity(bytes.len());
    file.take(bytes.len() as u64 + 1).read_to_end(&mut found)?;
    Ok(found == bytes)
}

/// Reads a file back from its start.
fn stamp(file: &mut File) -> io::Result<Stamp> {
    file.seek(SeekFrom::Start(0))?;
    let (mut sum, mut bytes, mut buffer) = (Sha256::new(), 0, vec![0; 1 << 18]);
    loop {
        match file.read(&mut buffer) {
            Ok(0) => break,
            Ok(n) => {
                sum.update(&buffer[..n]);
                bytes += n as u64;
            }
            Err(e) if e.kind() == io::ErrorKind::Interrupted => (),
            Err(e) => return Err(e),
        }
    }
    let sha256 = sum.finalize().iter().map(|b| format!("{b:02x}")).collect();
    Ok(Stamp { sha256, bytes })
}

#[cfg(test)]
mod tests;
