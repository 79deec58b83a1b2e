//! Builds that are killed or asked to stop: whole files, a true report, and the next build is not in the way.

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::process::Command;
use std::time::{Duration, Instant};

use orograph::files::{Limits, read_height};
use orograph::kit::hash;
use serde_json::Value as Json;

use super::{Desk, hashes, program, some_of, text, wait};
use crate::cli::until_told;

fn sha256(bytes: &[u8]) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Every file under its own name is whole, and what a report says is true.
fn look(desk: &Desk, out: &str) {
    let entries = std::fs::read_dir(desk.path(out)).into_iter().flatten().flatten();
    let files: BTreeMap<String, Vec<u8>> = entries
        .map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()))
        .filter(|(name, _)| !name.starts_with('.'))
        .map(|(name, path)| (name, std::fs::read(path).unwrap()))
        .collect();
    for (name, bytes) in &files {
        if [".exr", ".png"].iter().any(|e| name.ends_with(e)) && !name.contains("tints") {
            read_height(name, bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
        }
        if name.ends_with(".json") {
            serde_json::from_slice::<Json>(bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
    let Some(report) = files.get("report.json") else { return };
    let report: Json = serde_json::from_slice(report).unwrap();
    for output in report["outputs"].as_array().unwrap() {
        let name = output["path"].as_str().unwrap();
        assert_eq!(output["sha256"], sha256(&files[name]), "the report speaks of another {name}");
    }
}

#[test]
fn builds_killed_at_random_moments_leave_no_ruins() {
    let desk = Desk::new();
    let (graph, cache) = (text(&desk.path("a.graph")), text(&desk.path("cache")));
    let whole = desk.build("whole", &["--size", "513", "--progress", "json"]);
    assert_eq!(whole.code, Some(0), "{}", whole.said);
    let (lines, right) = (whole.said.lines().count() as u64, hashes(&desk.report("whole")));
    let mut hit = 0;
    let tries = some_of((0..85u64).collect(), 5);
    for &i in &tries {
        let name = format!("out{}", i % 7);
        let out = text(&desk.path(&name));
        let mut build = program();
        build.args(["build", &graph, "-o", &out, "--size", "513", "--cache", &cache, "--progress", "json"]);
        // At any word of those that a whole build tells.
        let mut child = until_told(&mut build, (hash::nth(7, i) % lines) as usize);
        child.kill().unwrap();
        hit += usize::from(child.wait().unwrap().signal().is_some());
        look(&desk, &name);
        if i % 5 == 0 {
            let again = desk.build(&name, &["--size", "513", "--cache", &cache]);
            assert_eq!(again.code, Some(0), "{}", again.said);
            assert_eq!(hashes(&desk.report(&name)), right, "try {i}");
            look(&desk, &name);
        }
    }
    println!("{} tries, {hit} of them hit a running build", tries.len());
    assert!(hit > 0, "no build was hit");
}

#[test]
fn signals_stop_a_build_soon() {
    let desk = Desk::new();
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    for signal in ["-INT", "-TERM"] {
        let mut build = program();
        build.args(["build", &graph, "-o", &out, "--size", "8193", "--set", "soft.radius=3000"]);
        // The first word of progress says that the handler is there and work has begun.
        let mut child = until_told(build.args(["--progress", "json"]), 1);
        let start = Instant::now();
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let status = wait(&mut child, Duration::from_secs(30)).expect("the build stops");
        println!("{signal}: {:?}", start.elapsed());
        assert_eq!(status.code(), Some(130));
        assert!(!desk.path("out/report.json").exists() && !desk.path("out/height.r32").exists());
    }
}
