//! Trials of the program as strangers, build farms and failing machines treat it.
//!
//! Every test run has a fixed part of each; `OROGRAPH_BREADTH=1 cargo test --test it trials` runs them whole.

#[cfg(unix)]
mod disks;
mod farm;
mod files;
mod graphs;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod paths;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};

use crate::rig::breadth;

/// No command may take longer, on a busy machine and in a build that is little optimised.
const LIMIT: Duration = Duration::from_secs(60);

/// Every `n`-th of a list, or all of it where the whole is tried.
fn some_of<T>(all: Vec<T>, n: usize) -> Vec<T> {
    let step = if breadth() { 1 } else { n };
    all.into_iter().step_by(step).collect()
}

/// How a command ended.
struct Ended {
    /// The exit code; none where a signal ended it.
    code: Option<i32>,
    /// What it wrote to standard output.
    told: String,
    /// What it wrote to standard output and standard error.
    said: String,
    took: Duration,
}

impl Ended {
    /// What is wrong with the way it ended, whatever the command was: a panic, a signal, a code that is not documented.
    fn fault(&self) -> Option<String> {
        let known = [0, 1, 2, 3, 4, 5, 6, 130];
        if self.said.contains("panicked") || self.said.contains("RUST_BACKTRACE") {
            return Some(format!("panicked: {}", self.said));
        }
        match self.code {
            Some(code) if known.contains(&code) => (),
            other => return Some(format!("ended with {other:?}: {}", self.said)),
        }
        let raw =
            |c: &char| (c.is_control() && !matches!(c, '\n' | '\t')) || matches!(c, '\u{200b}' | '\u{202e}');
        let found = self.said.chars().find(raw);
        found.map(|c| format!("wrote {c:?} to the terminal: {}", self.said.escape_debug()))
    }
}

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_orograph"));
    command.stdin(Stdio::null()).env("XDG_CONFIG_HOME", "/nonexistent");
    command
}

/// Runs a command to its end, or kills it and fails at the limit.
fn ended(command: &mut Command) -> Ended {
    let (out, err) = (tempfile::NamedTempFile::new().unwrap(), tempfile::NamedTempFile::new().unwrap());
    command.stdout(out.reopen().unwrap()).stderr(err.reopen().unwrap());
    let start = Instant::now();
    let mut child = command.spawn().unwrap();
    let status = wait(&mut child, LIMIT);
    let read = |file: &tempfile::NamedTempFile| {
        String::from_utf8_lossy(&std::fs::read(file.path()).unwrap()).into_owned()
    };
    let told = read(&out);
    let said = read(&err) + &told;
    let status = status.unwrap_or_else(|| panic!("{command:?} was not done after {LIMIT:?}: {said}"));
    Ended { code: status.code(), told, said, took: start.elapsed() }
}

/// Waits for a child; kills it at the limit and gives nothing.
fn wait(child: &mut Child, limit: Duration) -> Option<std::process::ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status);
        }
        if start.elapsed() > limit {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Runs the program with some arguments.
fn run(args: &[&str]) -> Ended {
    ended(program().args(args))
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// A folder with a graph of hills, a mask and a picture.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.write("a.graph", hills().to_string().as_bytes());
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> String {
        std::fs::write(self.path(name), bytes).unwrap();
        text(&self.path(name))
    }

    /// Builds the graph into `out`.
    fn build(&self, out: &str, more: &[&str]) -> Ended {
        let (graph, out) = (text(&self.path("a.graph")), text(&self.path(out)));
        run(&[&["build", &graph, "-o", &out], more].concat())
    }

    fn report(&self, out: &str) -> Json {
        serde_json::from_slice(&std::fs::read(self.path(out).join("report.json")).unwrap()).unwrap()
    }
}

/// A graph with point, local and global nodes and an output of each sort.
fn hills() -> Json {
    json!({
        "orograph": 1,
        "terrain": { "width": 2048, "depth": 1024, "base": 129, "sea_level": 5 },
        "nodes": {
            "hills": { "kind": "fractal_noise", "set": { "seed": 3, "amplitude": 200 } },
            "soft": { "kind": "blur", "in": { "field": "hills.field" }, "set": { "radius": 60 } },
            "even": { "kind": "equalize", "in": { "field": "soft.field" } },
            "steep": { "kind": "select_slope", "in": { "height": "soft.field" } },
            "tints": { "kind": "colorize", "in": { "field": "soft.field" } },
        },
        "outputs": {
            "height": { "from": "soft.field", "format": "r32" },
            "even": { "from": "even.field", "format": "exr" },
            "steep": { "from": "steep.mask", "format": "png16" },
            "tints": { "from": "tints.colors", "format": "png8" },
        },
    })
}

/// The hashes of the samples of all outputs of a report, by name.
fn hashes(report: &Json) -> Vec<(String, String)> {
    let word = |v: &Json| v.as_str().unwrap_or_default().to_owned();
    let outputs = report["outputs"].as_array().unwrap().iter();
    let mut all: Vec<_> =
        outputs.map(|o| (word(&o["name"]) + &o["tile"].to_string(), word(&o["samples_sha256"]))).collect();
    assert!(!all.is_empty() && all.iter().all(|(_, sum)| sum.len() == 64), "{report}");
    all.sort();
    all
}
