use std::fs::TryLockError;
use std::time::{Duration, SystemTime};

use super::*;

fn folder() -> (tempfile::TempDir, Dir) {
    let temp = tempfile::tempdir().expect("a folder");
    let dir = Dir::open_ambient_dir(temp.path(), ambient_authority()).expect("opens");
    (temp, dir)
}

fn names(dir: &Dir) -> Vec<String> {
    let entries = dir.entries().expect("lists");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn put_text(dir: &Dir, name: &str, text: &str) -> io::Result<()> {
    write(dir, name, Known::Anything, |f| f.write_all(text.as_bytes()))
}

#[test]
fn writes_whole_files_with_their_sum() {
    let (_temp, dir) = folder();
    let (stamp, ()) = write_stamped(&dir, "a.txt", |f| f.write_all(b"abc")).expect("writes");
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
    write(&dir, "a.txt", Known::Anything, fail).expect_err("fails");
    assert_eq!((dir.read_to_string("a.txt").expect("reads"), names(&dir).len()), ("old".to_owned(), 1));
}

#[test]
fn refuses_names_that_are_paths() {
    let (temp, dir) = folder();
    for name in ["", "..", "../x", "a/b", "/etc/passwd", "a\\b", "a\0b"] {
        put_text(&dir, name, "x").expect_err(name);
    }
    for path in ["", "x/..", "x/", "/"] {
        save(&temp.path().join(path), b"x", Known::Anything).expect_err(path);
    }
    assert!(names(&dir).is_empty());
}

#[test]
fn knows_devices_whatever_their_extension() {
    for name in [
        "CON", "con.tif", "Lpt1", "aux.", "nul.png", "com9.asc", "com0", "lpt0.tif", "COM¹", "nul:",
        "con .r32",
    ] {
        assert!(is_device(name), "{name}");
    }
    for name in ["cone", "com", "com10", "lpt", "console.tif", "auxiliary", "com_1", ""] {
        assert!(!is_device(name), "{name}");
    }
}

#[test]
fn long_names_are_written_and_swept() {
    let (_temp, dir) = folder();
    let name = format!("{}.txt", "ü".repeat(125));
    put_text(&dir, &name, "x").expect("writes");
    Killed::leave(&dir, &name);
    assert_eq!(names(&dir).len(), 2);
    sweep(&dir, |left| left.is_of(&name));
    assert_eq!(names(&dir), [name]);
}

/// What a killed writer leaves: its file, without its lock.
struct Killed;

impl Killed {
    fn leave(dir: &Dir, name: &str) {
        let passing = Passing::make(dir, OsStr::new(name)).expect("opens");
        passing.file.unlock().expect("unlocks");
        std::mem::forget(passing);
    }
}

#[test]
fn what_a_killed_writer_left_goes_and_a_living_one_keeps_its_file() {
    let (temp, dir) = folder();
    Killed::leave(&dir, "a.txt");
    Killed::leave(&dir, "theirs.txt");
    let living = Passing::make(&dir, OsStr::new("a.txt")).expect("opens");
    sweep(&dir, |left| left.is_of("a.txt"));
    let left = names(&dir);
    assert_eq!(left.len(), 2, "{left:?}");
    assert!(left.iter().any(|n| *n == living.name.to_string_lossy()) && left[1].starts_with(".theirs.txt."));
    living.rename(OsStr::new("a.txt")).expect("renames");
    // Saving sweeps by itself.
    Killed::leave(&dir, "a.txt");
    save(&temp.path().join("a.txt"), b"x", Known::Anything).expect("saves");
    assert_eq!(names(&dir).len(), 2);
}

#[test]
fn files_of_other_machines_go_by_their_age() {
    let (_temp, dir) = folder();
    let hour = SystemTime::now() - Duration::from_secs(3600);
    for (name, age) in [(".a.txt.beef-1.part", hour), (".a.txt.beef-2.part", SystemTime::now())] {
        let file = dir.create(name).expect("makes").into_std();
        file.set_modified(age).expect("sets");
    }
    let locked = dir.create(".a.txt.beef-3.part").expect("makes").into_std();
    locked.lock().expect("locks");
    locked.set_modified(hour).expect("sets");
    for other in [".a.part", ".a.txt.1.part", ".a.txt.1-x.part", "a.txt.1-2.part", "..1-2.part"] {
        dir.create(other).expect("makes").into_std().set_modified(hour).expect("sets");
    }
    let before = names(&dir).len();
    sweep(&dir, |left| left.is_of("a.txt"));
    let after = names(&dir);
    assert!(!after.iter().any(|n| n == ".a.txt.beef-1.part") && after.len() == before - 1, "{after:?}");
}

#[test]
fn a_writer_that_is_swept_before_its_lock_writes_another_file() {
    let (_temp, dir) = folder();
    // Many makings against one sweep after the other: each file that is given out is there and locked.
    let stop = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (stop, dir) = (&stop, &dir);
        scope.spawn(move || {
            while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                sweep(dir, |_| true);
            }
        });
        for _ in 0..300 {
            let passing = Passing::make(dir, OsStr::new("a.txt")).expect("opens");
            let again = dir.open(&passing.name).expect("is there").into_std();
            assert!(matches!(again.try_lock(), Err(TryLockError::WouldBlock)));
            drop(again);
            passing.rename(OsStr::new("a.txt")).expect("renames");
        }
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
    });
    assert_eq!(names(&dir), ["a.txt"]);
}

#[test]
fn a_probe_tells_what_cannot_be_written_and_leaves_nothing() {
    let (temp, dir) = folder();
    probe(&temp.path().join("a.txt")).expect("can be");
    probe_in(&dir, "a.txt").expect("can be");
    probe(&temp.path().join("absent/a.txt")).expect_err("there is no such folder");
    dir.create_dir("folder").expect("makes");
    probe_in(&dir, "folder").expect_err("a folder");
    assert_eq!(names(&dir), ["folder"]);
    if cfg!(target_os = "linux") {
        probe(Path::new("/proc/a.txt")).expect_err("a folder that takes no files");
    }
}

#[test]
fn a_locked_file_is_never_seen_unlocked() {
    let (temp, dir) = folder();
    let path = temp.path().join("a.lock");
    let lock = locked(&path).expect("makes");
    assert!(matches!(File::open(&path).expect("opens").try_lock(), Err(TryLockError::WouldBlock)));
    drop(lock);
    File::open(&path).expect("opens").try_lock().expect("is free");
    assert_eq!(names(&dir), ["a.lock"]);
}

#[test]
fn nobodys_work_is_replaced() {
    let (temp, dir) = folder();
    let path = temp.path().join("a.txt");
    save(&path, b"mine", Known::Absent).expect("there is none");
    let refused = save(&path, b"again", Known::Absent).expect_err("there is one");
    assert!(Changed::is(&refused));
    save(&path, b"more", Known::Bytes(b"mine")).expect("as it was read");
    for known in [&b"mine"[..], b"mor", b"more than", b""] {
        let refused = save(&path, b"lost", Known::Bytes(known)).expect_err("was changed");
        assert!(Changed::is(&refused) && refused.to_string().contains("another program"), "{refused}");
    }
    // Changed while the new file was written.
    let meanwhile = write(&dir, "a.txt", Known::Bytes(b"more"), |f| {
        dir.write("a.txt", "theirs")?;
        f.write_all(b"lost")
    });
    assert!(Changed::is(&meanwhile.expect_err("was changed")));
    assert_eq!(dir.read_to_string("a.txt").expect("reads"), "theirs");
    dir.remove_file("a.txt").expect("removes");
    save(&path, b"back", Known::Bytes(b"theirs")).expect("what is gone is nobody's");
    assert_eq!(names(&dir), ["a.txt"]);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    use std::path::Path;

    use super::*;

    fn mode(path: &Path) -> u32 {
        path.metadata().expect("is there").permissions().mode() & 0o777
    }

    fn set_mode(path: &Path, mode: u32) {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("sets");
    }

    #[test]
    fn the_mode_stays_and_new_files_follow_the_umask() {
        let (temp, dir) = folder();
        let path = temp.path().join("a.txt");
        let plain = temp.path().join("plain");
        std::fs::write(&plain, "").expect("writes");
        put_text(&dir, "a.txt", "x").expect("writes");
        assert_eq!(mode(&path), mode(&plain), "as any new file");
        for wanted in [0o600, 0o664, 0o640, 0o755] {
            set_mode(&path, wanted);
            save(&path, b"y", Known::Anything).expect("saves");
            assert_eq!(mode(&path), wanted);
            let during = write(&dir, "a.txt", Known::Anything, |_| {
                let part = names(&dir).into_iter().find(|n| n.ends_with(".part")).expect("is there");
                io::Result::Ok(mode(&temp.path().join(part)))
            });
            assert_eq!(during.expect("writes"), wanted, "from the first byte on");
        }
        for read_only in [0o444, 0o400] {
            std::fs::write(&path, "kept").expect("writes");
            set_mode(&path, read_only);
            let refused = save(&path, b"y", Known::Anything).expect_err("is read-only");
            assert!(refused.to_string().contains("read-only"), "{refused}");
            assert_eq!((mode(&path), std::fs::read(&path).expect("reads")), (read_only, b"kept".to_vec()));
            set_mode(&path, 0o644);
        }
    }

    #[test]
    fn links_that_the_user_names_are_followed_and_those_of_a_folder_replaced() {
        let (temp, dir) = folder();
        let at = |name: &str| temp.path().join(name);
        std::fs::create_dir(at("real")).expect("makes");
        std::fs::write(at("real/a.txt"), "old").expect("writes");
        symlink("real/a.txt", at("one")).expect("links");
        symlink("one", at("two")).expect("links");
        symlink("real/new.txt", at("to_be")).expect("links");
        save(&at("two"), b"new", Known::Anything).expect("saves");
        save(&at("to_be"), b"first", Known::Absent).expect("saves");
        assert!(at("two").is_symlink() && at("one").is_symlink() && at("to_be").is_symlink());
        assert_eq!(std::fs::read(at("real/a.txt")).expect("reads"), b"new");
        assert_eq!(std::fs::read(at("real/new.txt")).expect("reads"), b"first");
        put_text(&dir, "one", "own").expect("writes");
        assert!(!at("one").is_symlink());
        assert_eq!(std::fs::read(at("real/a.txt")).expect("reads"), b"new");
        symlink("round", at("round")).expect("links");
        save(&at("round"), b"x", Known::Anything).expect_err("a circle");
    }

    #[test]
    fn what_is_no_file_is_not_replaced() {
        let (temp, dir) = folder();
        dir.create_dir("folder").expect("makes");
        let pipe = std::process::Command::new("mkfifo").arg(temp.path().join("pipe")).status();
        assert!(pipe.expect("runs").success());
        for name in ["folder", "pipe"] {
            put_text(&dir, name, "x").expect_err(name);
            save(&temp.path().join(name), b"x", Known::Anything).expect_err(name);
        }
        assert_eq!(names(&dir), ["folder", "pipe"]);
        save(Path::new("/dev/null"), b"x", Known::Anything).expect_err("a device");
    }
}
