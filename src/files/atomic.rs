//! Files that are whole or not there.

use std::io::{self, Read, Seek, SeekFrom};
use std::sync::atomic::{AtomicU32, Ordering};

use cap_std::fs::{Dir, File, OpenOptions};
use sha2::{Digest, Sha256};

/// What a written file is, for the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Its length.
    pub bytes: u64,
}

/// A file under a passing name, removed when it is dropped before its time.
struct Passing<'a> {
    dir: &'a Dir,
    name: String,
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

/// Writes a file whole or not at all: under a passing name in the same folder, made durable, then renamed over
/// whatever had its name.
///
/// # Errors
/// Those of `write`, and those of the folder; then nothing is left behind and an older file stays as it was.
pub fn write_atomic<T, E: From<io::Error>>(
    dir: &Dir,
    name: &str,
    write: impl FnOnce(&mut File) -> Result<T, E>,
) -> Result<(Stamp, T), E> {
    if name.is_empty() || name.contains(['/', '\\', '\0']) || name == "." || name == ".." {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file").into());
    }
    let (mut passing, mut file) = open(dir, name)?;
    let result = write(&mut file)?;
    let stamp = stamp(&mut file)?;
    file.sync_all()?;
    drop(file);
    dir.rename(&passing.name, dir, name)?;
    passing.kept = true;
    // Makes the new name durable where folders can be synced; where they cannot, the file is still whole.
    if let Ok(folder) = dir.open(".") {
        let _ = folder.sync_all();
    }
    Ok((stamp, result))
}

/// The name that a file under a passing name is meant to get; `None` for any other file.
pub fn passing_name_of(name: &str) -> Option<&str> {
    let (file, number) = name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.')?;
    let (process, count) = number.split_once('-')?;
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    (digits(process) && digits(count)).then_some(file)
}

fn open<'a>(dir: &'a Dir, name: &str) -> io::Result<(Passing<'a>, File)> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    loop {
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let passing = format!(".{name}.{}-{n}.part", std::process::id());
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        match dir.open_with(&passing, &options) {
            Ok(file) => return Ok((Passing { dir, name: passing, kept: false }, file)),
            // Left over from a process of the same number that was killed.
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => (),
            Err(e) => return Err(e),
        }
    }
}

/// Reads the file back: what is hashed is what is on the disk.
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
mod tests {
    use super::*;
    use std::io::Write;

    fn folder() -> (tempfile::TempDir, Dir) {
        let temp = tempfile::tempdir().expect("a folder");
        let dir = Dir::open_ambient_dir(temp.path(), cap_std::ambient_authority()).expect("opens");
        (temp, dir)
    }

    fn names(dir: &Dir) -> Vec<String> {
        let entries = dir.entries().expect("lists");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn writes_whole_files_with_their_sum() {
        let (_temp, dir) = folder();
        let write = |f: &mut File| f.write_all(b"abc");
        let (stamp, ()) = write_atomic(&dir, "a.txt", write).expect("writes");
        // FIPS 180-2, appendix B.1.
        assert_eq!(stamp.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!((stamp.bytes, names(&dir)), (3, vec!["a.txt".to_owned()]));
    }

    #[test]
    fn leaves_nothing_behind_when_writing_fails() {
        let (_temp, dir) = folder();
        dir.write("a.txt", "old").expect("writes");
        let fail = |f: &mut File| -> io::Result<()> {
            f.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        };
        write_atomic(&dir, "a.txt", fail).expect_err("fails");
        assert_eq!((dir.read_to_string("a.txt").expect("reads"), names(&dir).len()), ("old".to_owned(), 1));
    }

    #[test]
    fn knows_its_passing_names() {
        let (_temp, dir) = folder();
        let (passing, _) = open(&dir, "a.b.tif").expect("opens");
        assert_eq!(passing_name_of(&passing.name), Some("a.b.tif"));
        for other in ["a.tif", ".a.part", ".a.1.part", ".a.1-x.part", "a.1-2.part"] {
            assert_eq!(passing_name_of(other), None, "{other}");
        }
    }

    #[test]
    fn refuses_names_that_are_paths() {
        let (_temp, dir) = folder();
        for name in ["", "..", "../x", "a/b", "/etc/passwd", "a\\b"] {
            write_atomic(&dir, name, |_| Ok::<(), io::Error>(())).expect_err(name);
        }
        assert!(names(&dir).is_empty());
    }
}
