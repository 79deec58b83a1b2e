//! A build farm: many processes, one cache, one folder; any threads, any instruction set; a cache that was damaged.

use std::process::{Child, Stdio};

use super::{Desk, LIMIT, hashes, program, some_of, text, wait};

fn spawn(desk: &Desk, out: &str, more: &[&str]) -> Child {
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path(out)));
    let mut command = program();
    command.args(["build", &graph, "-o", &out]).args(more);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn processes_share_a_cache() {
    let desk = Desk::new();
    assert_eq!(desk.build("alone", &["--size", "257"]).code, Some(0));
    let right = hashes(&desk.report("alone"));
    let cache = text(&desk.path("cache"));
    for size in ["64M", "200K"] {
        let start = |i: usize| {
            spawn(&desk, &format!("out{i}"), &["--size", "257", "--cache", &cache, "--cache-size", size])
        };
        let children: Vec<_> = (0..4).map(start).collect();
        for (i, mut child) in children.into_iter().enumerate() {
            assert_eq!(wait(&mut child, LIMIT).unwrap().code(), Some(0));
            assert_eq!(hashes(&desk.report(&format!("out{i}"))), right);
        }
    }
}

/// Threads, instruction sets and the state of the cache change no bit.
#[test]
fn nothing_around_a_build_changes_a_bit() {
    let desk = Desk::new();
    assert_eq!(desk.build("alone", &["--size", "257"]).code, Some(0));
    let right = hashes(&desk.report("alone"));
    for threads in some_of(vec!["1", "7", "2", "64"], 2) {
        assert_eq!(desk.build("threads", &["--size", "257", "--threads", threads]).code, Some(0));
        assert_eq!(hashes(&desk.report("threads")), right, "{threads} threads");
    }
    for level in some_of(vec!["baseline", "sse2", "avx2"], 2) {
        let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("level")));
        let mut command = program();
        command.args(["build", &graph, "-o", &out, "--size", "257"]).env("OROGRAPH_SIMD", level);
        let end = super::ended(&mut command);
        assert_eq!(end.code, Some(0), "{}", end.said);
        assert_eq!(hashes(&desk.report("level")), right, "{level}");
    }
    let cache = text(&desk.path("cache"));
    let build = |state: &str| {
        let end = desk.build("cached", &["--size", "257", "--cache", &cache]);
        assert_eq!(end.code, Some(0), "{state}: {}", end.said);
        assert_eq!(hashes(&desk.report("cached")), right, "{state}");
    };
    build("cold");
    build("warm");
    assert_eq!(desk.build("other", &["--size", "129", "--cache", &cache]).code, Some(0));
    build("after another size");
    for (state, spoil) in [("flipped", flip as fn(&mut Vec<u8>)), ("cut", cut), ("empty", Vec::clear)] {
        let count = spoil_all(&desk.path("cache"), spoil);
        assert!(count > 3, "{count} files in the cache");
        build(state);
    }
}

#[allow(clippy::ptr_arg, reason = "its siblings change the length")]
fn flip(bytes: &mut Vec<u8>) {
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
}

fn cut(bytes: &mut Vec<u8>) {
    bytes.truncate(bytes.len() / 2);
}

/// Changes every file below a folder; gives their number.
fn spoil_all(folder: &std::path::Path, spoil: fn(&mut Vec<u8>)) -> usize {
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            count += spoil_all(&path, spoil);
            continue;
        }
        let mut bytes = std::fs::read(&path).unwrap();
        if !bytes.is_empty() {
            spoil(&mut bytes);
            std::fs::write(&path, bytes).unwrap();
            count += 1;
        }
    }
    count
}
