//! Files that a graph names: what of them is read and when, and that a result is of one content.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant, SystemTime};

use orograph::engine::{Cause, Engine, EngineError, Files, Observer, Options, Plan, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::{Grid, Value};
use serde_json::json;

use crate::engine::{graph, want};

/// Bytes of a file that takes no room on the disk.
const HUGE: u64 = 12 << 30;

fn reads(name: &str) -> Graph {
    graph(json!({ "file": { "kind": "bytes", "set": { "file": name } } }))
}

fn small(g: &Graph) -> Grid {
    g.terrain().grid(5).unwrap()
}

fn engine(folder: &Path, options: Options, pinned: bool) -> Engine {
    let mut files = Files::default();
    files.allow_folder(folder).unwrap();
    let files = if pinned { files.pinned() } else { files };
    Engine::new(&Options { threads: 1, ..options }, files).unwrap()
}

fn length(e: &Engine, g: &Graph, observer: &dyn Observer) -> Result<f32, (Cause, String)> {
    let wants = [want(g, "file", small(g))];
    let evaluation = e.evaluate(g, &wants, observer, &Cancel::default()).unwrap();
    match &evaluation.values[0] {
        Ok(Value::Field(f)) => Ok(f.at(0, 0)),
        Ok(other) => panic!("a field, not {other:?}"),
        Err(failure) => Err((failure.cause(), failure.to_string())),
    }
}

fn sparse(path: &Path, bytes: u64) {
    std::fs::File::create(path).unwrap().set_len(bytes).unwrap();
}

/// The content of a huge file is read neither by the plan nor where a budget refuses it.
#[test]
fn a_huge_file_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    sparse(&folder.path().join("huge.bin"), HUGE);
    let g = reads("huge.bin");
    let wants = [want(&g, "file", small(&g))];
    let cache = Some(folder.path().join("cache"));
    let (memory, seconds) = (1 << 30, 1.0);
    let start = Instant::now();
    for options in [
        Options { memory, ..Options::default() },
        Options { memory, cache: cache.clone(), ..Options::default() },
        Options { memory: 1 << 40, seconds, ..Options::default() },
        Options { memory: 1 << 40, seconds, cache, ..Options::default() },
        Options { memory: 1 << 40, seconds: f64::NAN, ..Options::default() },
    ] {
        let e = engine(folder.path(), options, false);
        let plan = e.plan(&g, &wants);
        assert_eq!(plan.unread_bytes(), HUGE);
        assert!(
            plan.peak_bytes() >= HUGE && plan.seconds() > 5.0,
            "{}, {}",
            plan.peak_bytes(),
            plan.seconds()
        );
        match e.evaluate(&g, &wants, &Unread, &Cancel::default()) {
            Err(EngineError::Memory { at, .. }) => assert!(at.contains("file"), "{at}"),
            Err(EngineError::Time { .. }) => (),
            other => panic!("refused, not {other:?}"),
        }
        assert_eq!(e.key(&g, g.find("file").unwrap()), None);
        let keys = e.keys(&g, &[g.find("file").unwrap()], 1 << 20, &Unread, &Cancel::default()).unwrap();
        assert!(keys.is_empty());
    }
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    let limit = 16 << 30;
    sparse(&folder.path().join("huger.bin"), limit + 1);
    let e = engine(folder.path(), Options::default(), false);
    let (cause, text) = length(&e, &reads("huger.bin"), &Unread).unwrap_err();
    assert!(cause == Cause::File && text.contains(&(limit + 1).to_string()), "{text}");
}

/// Fails when any content is read.
struct Unread;

impl Observer for Unread {
    fn reading(&self, node: &str, file: &str, _: f32) {
        panic!("node `{node}` reads {file}");
    }
}

/// Does something to a file between the plan, which knows its content, and the run.
struct Between<F: Fn()>(F);

impl<F: Fn() + Sync> Observer for Between<F> {
    fn planned(&self, _: &Plan) {
        (self.0)();
    }
}

/// Whatever happens to a file between plan and run, there is an error that names node and file, and afterwards the
/// result of what is there then.
#[cfg(unix)]
#[test]
fn a_file_that_changes_between_plan_and_run_gives_an_error_and_then_the_new_result() {
    type Change = (&'static str, fn(&Path), &'static str, Option<f32>);
    let changes: [Change; 9] = [
        ("grows", |p| append(p, b"67"), "5 bytes and has 7 now", Some(7.0)),
        ("is cut", |p| std::fs::write(p, "123").unwrap(), "5 bytes and has 3 now", Some(3.0)),
        ("is emptied", |p| std::fs::write(p, "").unwrap(), "5 bytes and has 0 now", Some(0.0)),
        ("is written over", |p| std::fs::write(p, "12346").unwrap(), "its content is another", Some(5.0)),
        ("is replaced", |p| replace(p, "123456"), "5 bytes and has 6 now", Some(6.0)),
        ("is gone", |p| std::fs::remove_file(p).unwrap(), "it is gone now", None),
        ("becomes a folder", |p| swap(p, |p| std::fs::create_dir(p).unwrap()), "not a regular file", None),
        ("becomes a link", |p| swap(p, |p| link("other.bin", p)), "5 bytes and has 4 now", Some(4.0)),
        ("becomes a link out", |p| swap(p, |p| link("/etc/passwd", p)), "", None),
    ];
    for (what, change, why, then) in changes {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        std::fs::write(folder.path().join("other.bin"), "1234").unwrap();
        std::fs::write(&path, "12345").unwrap();
        let (g, e) = (reads("a.bin"), engine(folder.path(), Options::default(), false));
        let (cause, text) = length(&e, &g, &Between(|| change(&path))).expect_err(what);
        assert_eq!(cause, Cause::File, "{what}: {text}");
        assert!(text.contains("node `file`") && text.ends_with(": a.bin"), "{what}: {text}");
        assert!(text.contains(why), "{what}: {text}");
        assert_eq!(length(&e, &g, &Unobserved).ok(), then, "{what}");
    }
}

#[cfg(unix)]
fn append(path: &Path, bytes: &[u8]) {
    use std::io::Write as _;
    std::fs::File::options().append(true).open(path).unwrap().write_all(bytes).unwrap();
}

#[cfg(unix)]
fn replace(path: &Path, content: &str) {
    let fresh = path.with_extension("new");
    std::fs::write(&fresh, content).unwrap();
    std::fs::rename(fresh, path).unwrap();
}

#[cfg(unix)]
fn swap(path: &Path, put: impl Fn(&Path)) {
    std::fs::remove_file(path).unwrap();
    put(path);
}

#[cfg(unix)]
fn link(target: &str, path: &Path) {
    std::os::unix::fs::symlink(target, path).unwrap();
}

/// A file of which only the time of writing changes is the same file; one that is replaced by another of the same
/// length and time is not.
#[test]
fn the_content_decides_whatever_length_and_time_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    let (g, e) = (reads("a.bin"), engine(folder.path(), Options::default(), false));
    let old = SystemTime::now() - Duration::from_secs(3600);
    let write = |content: &str, time: SystemTime| {
        std::fs::write(&path, content).unwrap();
        std::fs::File::options().append(true).open(&path).unwrap().set_modified(time).unwrap();
    };
    let key = || {
        let node = g.find("file").unwrap();
        e.keys(&g, &[node], u64::MAX, &Unobserved, &Cancel::default()).unwrap()[&node]
    };
    write("12345", old);
    let first = key();
    assert_eq!(e.key(&g, g.find("file").unwrap()), Some(first), "known by path and stamp");
    write("12345", old + Duration::from_secs(60));
    assert_eq!(key(), first);
    if cfg!(unix) {
        write("54321", old + Duration::from_secs(60));
        assert_ne!(key(), first);
    }
    // Young: the next writing may leave the same stamp, so that the content is read each time.
    write("12345", SystemTime::now());
    assert_eq!(key(), first);
    assert_eq!(e.key(&g, g.find("file").unwrap()), None);
}

/// All that one command does is of one content, though the file changes between its evaluations.
#[test]
fn a_pinned_file_is_looked_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    std::fs::write(&path, "12345").unwrap();
    let g = reads("a.bin");
    let e = engine(folder.path(), Options::default(), true);
    assert_eq!(length(&e, &g, &Unobserved), Ok(5.0));
    std::fs::write(&path, "123").unwrap();
    // What is in memory is of the first content, and so is all that is asked for: anything else fails.
    assert_eq!(length(&e, &g, &Unread), Ok(5.0));
    let other = Want { grid: g.terrain().grid(9).unwrap(), ..want(&g, "file", small(&g)) };
    let evaluation = e.evaluate(&g, &[other], &Unread, &Cancel::default()).unwrap();
    let failure = evaluation.values[0].as_ref().unwrap_err();
    assert!(failure.cause() == Cause::File && failure.to_string().contains("has changed"), "{failure}");
}

#[test]
fn a_key_holds_the_role_the_last_part_of_the_name_and_the_content() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in [
        ("1/a.bin", "x"),
        ("2/a.bin", "x"),
        ("2/b.bin", "x"),
        ("3/a.bin", "y"),
        ("only_first/f", "x"),
        ("only_second/s", "x"),
    ] {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    let e = engine(folder.path(), Options::default(), false);
    let key = |nodes| {
        let g = graph(json!({ "n": nodes }));
        let node = g.find("n").unwrap();
        e.keys(&g, &[node], u64::MAX, &Unobserved, &Cancel::default()).unwrap()[&node]
    };
    let one = |name: &str| key(json!({ "kind": "bytes", "set": { "file": name } }));
    assert_eq!(one("1/a.bin"), one("2/a.bin"), "the folder is in no key");
    assert_ne!(one("2/a.bin"), one("2/b.bin"), "the name may choose the reader");
    assert_ne!(one("1/a.bin"), one("3/a.bin"));
    let two = |first: &str, second: &str| {
        key(json!({ "kind": "either", "set": { "first": first, "second": second } }))
    };
    let all = [
        two("1/a.bin", "none/a.bin"),
        two("none/a.bin", "1/a.bin"),
        two("1/a.bin", "2/a.bin"),
        two("none/a.bin", "none/a.bin"),
    ];
    for (i, a) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|b| a != b), "{i}");
    }
}

/// Reading to know the content tells how far it is, and stops.
#[test]
fn hashing_tells_and_stops() {
    struct Stop(Cancel, Mutex<Vec<(String, f32)>>);
    impl Observer for Stop {
        fn reading(&self, node: &str, file: &str, share: f32) {
            assert_eq!(node, "file");
            self.1.lock().unwrap().push((file.to_owned(), share));
            if share > 0.1 {
                self.0.cancel();
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    sparse(&folder.path().join("large.bin"), 256 << 20);
    let (g, e) = (reads("large.bin"), engine(folder.path(), Options::default(), false));
    let stop = Stop(Cancel::default(), Mutex::default());
    let ended = e.evaluate(&g, &[want(&g, "file", small(&g))], &stop, &stop.0);
    assert!(matches!(ended, Err(EngineError::Cancelled)), "{ended:?}");
    let told = stop.1.into_inner().unwrap();
    assert!(
        told.len() > 5 && told.iter().all(|(file, share)| file == "large.bin" && *share < 0.2),
        "{told:?}"
    );
    assert_eq!(length(&e, &g, &Unobserved), Ok((256u32 << 20) as f32));
}

/// What was decoded counts among what is held, and goes when there is no room.
#[test]
fn decoded_files_are_accounted_and_let_go() {
    let folder = tempfile::tempdir().unwrap();
    let samples = |n: usize| (0..n * n).flat_map(|k| (k as f32).to_le_bytes()).collect::<Vec<u8>>();
    let path = folder.path().join("a.r32");
    std::fs::write(&path, samples(257)).unwrap();
    // The stamp of a file that is younger than two seconds does not tell its content.
    let hour = std::time::Duration::from_secs(3600);
    let before = std::time::SystemTime::now() - hour;
    std::fs::File::options().append(true).open(&path).unwrap().set_modified(before).unwrap();
    let g = graph(json!({ "file": { "kind": "import_height", "set": { "file": "a.r32" } } }));
    let wants = [Want { port: "height".into(), ..want(&g, "file", small(&g)) }];
    let bytes = 257 * 257 * 4;
    let roomy = engine(folder.path(), Options::default(), false);
    let run = |e: &Engine| {
        e.evaluate(&g, &wants, &Unobserved, &Cancel::default()).unwrap().values[0].clone().unwrap()
    };
    let first = run(&roomy);
    assert!(roomy.cached_bytes() > bytes, "{}", roomy.cached_bytes());
    let fresh = engine(folder.path(), Options::default(), false);
    let [cold, warm] = [&fresh, &roomy].map(|e| e.plan(&g, &wants).peak_bytes());
    assert!(cold > warm + 2 * bytes, "content and what is decoded, {cold}, which is in memory then, {warm}");
    let need = fresh.need(cold);
    let tight = engine(folder.path(), Options { memory: need, ..Options::default() }, false);
    assert_eq!(run(&tight), first);
    assert_eq!(tight.cached_bytes(), 0);
    let less = engine(folder.path(), Options { memory: need - 1, ..Options::default() }, false);
    let refused = less.evaluate(&g, &wants, &Unread, &Cancel::default());
    assert!(matches!(refused, Err(EngineError::Memory { .. })), "{refused:?}");
}
