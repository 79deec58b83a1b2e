//! The program as a user runs it.

mod builds;
mod commands;
mod names;
mod options;
mod overwriting;
mod refusals;
mod stopping;

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::{Value as Json, json};

pub(crate) fn orograph() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_orograph"));
    command.stdin(Stdio::null()).env("XDG_CONFIG_HOME", "/nonexistent");
    command
}

pub(crate) fn run(args: &[&str]) -> Output {
    orograph().args(args).output().unwrap()
}

pub(crate) fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or(-1)
}

pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

pub(crate) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Starts a command that tells its progress in lines, and comes back when it has told so many, or has ended.
pub(crate) fn until_told(command: &mut Command, lines: usize) -> Child {
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut told = BufReader::with_capacity(256, child.stderr.take().unwrap());
    let mut line = String::new();
    for _ in 0..lines {
        line.clear();
        if told.read_line(&mut line).unwrap() == 0 {
            break;
        }
    }
    // What it tells from here on has somewhere to go.
    std::thread::spawn(move || std::io::copy(&mut told, &mut std::io::sink()));
    child
}

/// A folder with a graph of hills and two outputs.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new(outputs: &Json) -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        let graph = json!({
            "orograph": 1,
            "terrain": { "width": 2048, "depth": 1024, "base": 129, "sea_level": 5 },
            "expose": { "relief": { "bind": ["hills.amplitude"], "value": 200, "min": 10, "max": 500 } },
            "nodes": {
                "hills": { "kind": "fractal_noise", "set": { "seed": 3 } },
                "soft": { "kind": "blur", "in": { "field": "hills.field" }, "set": { "radius": 60 } },
                "dem": { "kind": "import_height", "set": { "file": "missing.tif" } },
            },
            "outputs": outputs,
        });
        std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn build(&self, args: &[&str]) -> Output {
        let (graph, out) = (text(&self.path("a.graph")), text(&self.path("out")));
        run(&[&["build", &graph, "-o", &out], args].concat())
    }

    fn report(&self) -> Json {
        serde_json::from_slice(&std::fs::read(self.path("out/report.json")).unwrap()).unwrap()
    }
}

fn height() -> Json {
    json!({ "height": { "from": "soft.field", "format": "r32" } })
}

fn sha256(path: &Path) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(std::fs::read(path).unwrap()).iter().map(|b| format!("{b:02x}")).collect()
}
