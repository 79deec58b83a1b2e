//! The cache folder: what cannot be used, what is too much, what cannot be kept.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use orograph::engine::{Engine, Evaluation, Files, Options};
use orograph::graph::Graph;
use serde_json::json;

use crate::engine::{chain, evaluate, field, graph};

const SIZE: u32 = 129;

fn engine(folder: &Path, cache_bytes: u64) -> Engine {
    let options = Options { threads: 1, cache: Some(folder.to_owned()), cache_bytes, ..Options::default() };
    Engine::new(&options, Files::default()).unwrap()
}

fn run(e: &Engine, g: &Graph) -> Evaluation {
    evaluate(e, g, "end", g.terrain().grid(SIZE).unwrap())
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found
}

fn total(folder: &Path) -> u64 {
    files(folder).iter().map(|p| p.metadata().unwrap().len()).sum()
}

/// Graphs of which none shares a result with another.
fn hills(height: u32) -> Graph {
    graph(json!({ "end": { "kind": "waves", "set": { "height": height } } }))
}

/// What cannot be read is computed, whatever stands there, and is not removed unless it is damaged.
#[test]
fn what_cannot_be_used_is_computed_and_ends_no_evaluation() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let cold = field(&run(&engine(folder.path(), 1 << 30), &g), 0);
    let entries = files(folder.path());
    assert!(entries.len() > 3);
    for path in &entries {
        std::fs::remove_file(path).unwrap();
        std::fs::create_dir_all(path.join("not empty")).unwrap();
        // One that claims a window around all others.
        std::fs::create_dir_all(path.with_file_name("-9999_-9999_99999_99999/x")).unwrap();
    }
    let e = engine(folder.path(), 1 << 30);
    assert_eq!(field(&run(&e, &g), 0), cold);
    assert!(entries.iter().all(|p| p.is_dir()), "nobody's folders are removed");
    for path in entries.iter().map(|p| p.with_file_name("-9998_-9998_99999_99999")) {
        std::fs::write(path, "no entry").unwrap();
    }
    let again = engine(folder.path(), 1 << 30);
    assert_eq!(field(&run(&again, &g), 0), cold);
    let extreme = format!("{}_{}_{}_{}", i64::MAX, i64::MIN, u64::MAX, i64::MAX);
    for path in entries.iter().map(|p| p.with_file_name(&extreme)) {
        std::fs::write(path, "no entry").unwrap();
    }
    assert_eq!(field(&run(&engine(folder.path(), 1 << 30), &g), 0), cold);
}

/// A file in another's place has a right sum and is not believed.
#[test]
fn an_entry_in_the_place_of_another_is_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    run(&engine(folder.path(), 1 << 30), &hills(10));
    let ten = files(folder.path());
    let cold = field(&run(&engine(folder.path(), 1 << 30), &hills(20)), 0);
    let twenty: Vec<_> = files(folder.path()).into_iter().filter(|p| !ten.contains(p)).collect();
    assert!(ten.len() == 1 && twenty.len() == 1);
    std::fs::copy(&ten[0], &twenty[0]).unwrap();
    assert_eq!(field(&run(&engine(folder.path(), 1 << 30), &hills(20)), 0), cold);
}

#[cfg(unix)]
#[test]
fn entries_follow_the_umask_so_that_users_may_share_them() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    run(&engine(&folder.path().join("cache"), 1 << 30), &chain());
    let plain = folder.path().join("plain");
    std::fs::write(&plain, "").unwrap();
    let mode = |p: &Path| p.metadata().unwrap().permissions().mode() & 0o777;
    let entries = files(&folder.path().join("cache"));
    assert!(
        !entries.is_empty() && entries.iter().all(|p| mode(p) == mode(&plain)),
        "{:o}",
        mode(&entries[0])
    );
}

/// The limit holds at every moment of a run, for several processes as far as they see each other.
#[test]
fn the_folder_stays_within_its_size() {
    let folder = tempfile::tempdir().unwrap();
    run(&engine(folder.path(), 1 << 30), &hills(1));
    let one = total(folder.path());
    let limit = 5 * one + one / 2;
    let e = engine(folder.path(), limit);
    for height in 2..30 {
        assert_eq!(run(&e, &hills(height)).notices, [""; 0]);
        assert!(total(folder.path()) <= limit, "{} of {limit}", total(folder.path()));
    }
    assert!(total(folder.path()) >= 3 * one, "it keeps what there is room for");
    let both = [engine(folder.path(), limit), engine(folder.path(), limit)];
    for height in 30..60 {
        run(&both[height as usize % 2], &hills(height));
        assert!(total(folder.path()) <= limit + 2 * one, "{} of {limit}", total(folder.path()));
    }
    let last = engine(folder.path(), limit);
    assert_eq!(run(&last, &hills(59)).tasks[0].cached, Some("disk"), "the newest stay");
}

#[test]
fn a_folder_that_keeps_nothing_says_so_once() {
    let folder = tempfile::tempdir().unwrap();
    let small = engine(folder.path(), 100);
    let said = run(&small, &hills(1)).notices;
    assert!(said.len() == 1 && said[0].contains("larger than the folder may be, 100 B"), "{said:?}");
    assert_eq!(run(&small, &hills(2)).notices, [""; 0]);
    assert_eq!(files(folder.path()).len(), 0);
    // Where the program's own folder should be stands something else.
    let version = std::fs::read_dir(folder.path()).unwrap().flatten().next().unwrap().path();
    std::fs::remove_dir_all(&version).unwrap();
    std::fs::write(&version, "").unwrap();
    let said = run(&engine(folder.path(), 1 << 30), &hills(1)).notices;
    assert!(said.len() == 1 && said[0].contains(&folder.path().display().to_string()), "{said:?}");
    // One that is not there and cannot be made is refused before any work.
    let cache = Some(version.join("below a file"));
    assert!(Engine::new(&Options { cache, ..Options::default() }, Files::default()).is_err());
}

#[test]
fn what_killed_writers_left_goes_by_age() {
    let folder = tempfile::tempdir().unwrap();
    run(&engine(folder.path(), 1 << 30), &hills(1));
    let entry = files(folder.path()).remove(0);
    let [young, old] = [".part-abc", ".part-def"].map(|name| entry.with_file_name(name));
    for path in [&young, &old] {
        std::fs::write(path, "half").unwrap();
    }
    let time = SystemTime::now() - Duration::from_secs(7200);
    std::fs::File::options().append(true).open(&old).unwrap().set_modified(time).unwrap();
    engine(folder.path(), 1 << 30);
    assert!(young.exists() && !old.exists() && entry.exists());
}

/// Results of other versions of the program are not read and count among what the folder may hold.
#[test]
fn other_versions_share_the_room() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("orograph-0.0.1/ab/cdef/0_0_9_9");
    std::fs::create_dir_all(other.parent().unwrap()).unwrap();
    std::fs::write(&other, vec![0; 100_000]).unwrap();
    let time = SystemTime::now() - Duration::from_secs(60);
    std::fs::File::options().append(true).open(&other).unwrap().set_modified(time).unwrap();
    let mine = folder.path().join("notes.txt");
    std::fs::write(&mine, vec![0; 100_000]).unwrap();
    let e = engine(folder.path(), 110_000);
    assert!(other.exists());
    run(&e, &hills(1));
    assert!(!other.exists() && mine.exists());
}

/// A folder of the same entries under the name of another version stays as it is, and gives nothing.
#[test]
fn the_folder_of_another_version_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let first = |g: &Graph| run(&engine(folder.path(), 1 << 30), g).tasks[0].cached;
    assert_eq!((first(&hills(1)), first(&hills(1))), (None, Some("disk")));
    let own = std::fs::read_dir(folder.path()).unwrap().flatten().next().unwrap().path();
    let name = own.file_name().unwrap().to_str().unwrap();
    let version = env!("CARGO_PKG_VERSION");
    assert!(name.contains(version), "{name}");
    for other in [name.replace(version, "0.0.1"), format!("{name}0")] {
        let other = folder.path().join(other);
        std::fs::rename(&own, &other).unwrap();
        let before = files(&other);
        assert_eq!(first(&hills(1)), None, "{} is not read", other.display());
        assert_eq!(files(&other), before, "nor written");
        std::fs::remove_dir_all(&own).unwrap();
        std::fs::rename(&other, &own).unwrap();
        assert_eq!(first(&hills(1)), Some("disk"), "it was the name alone");
    }
}

/// The last part of a name chooses the reader, so it counts; the folder does not.
#[test]
fn the_same_bytes_under_two_names_are_each_read_as_their_name_says() {
    let (cache, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let grid = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 9\n1 2 3\n4 5 6\n";
    std::fs::create_dir(folder.path().join("else")).unwrap();
    for name in ["a.asc", "b.asc", "else/a.asc", "a.xyz"] {
        std::fs::write(folder.path().join(name), grid).unwrap();
    }
    let read = |name: &str| {
        let mut files = Files::default();
        files.allow_folder(folder.path()).unwrap();
        let cache = Some(cache.path().to_owned());
        let e = Engine::new(&Options { threads: 1, cache, ..Options::default() }, files).unwrap();
        let all = run(
            &e,
            &graph(json!({
                "dem": { "kind": "import_height", "set": { "file": name } },
                "end": { "kind": "copy", "in": { "field": "dem.height" } },
            })),
        );
        let cached = all.tasks.iter().all(|t| t.cached == Some("disk"));
        (all.values[0].as_ref().map(|v| v.components().to_vec()).map_err(|e| e.to_string()), cached)
    };
    let (first, cold) = read("a.asc");
    assert!(first.is_ok() && !cold, "{first:?}");
    assert_eq!(read("a.asc"), (first.clone(), true));
    assert_eq!(read("else/a.asc"), (first.clone(), true), "the same file in another folder");
    assert_eq!(read("b.asc"), (first, false), "another name may be another place or format");
    let (other, _) = read("a.xyz");
    assert!(
        other.is_err_and(|e| e.contains("a.xyz")),
        "what was read as one format is not taken for another"
    );
}
