//! The machine-readable report of a build: removed when the build starts, written last.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value as Json, json};

use super::exit::{Exit, Stop, print, save};
use crate::engine::TaskReport;

/// The path that stands for standard output.
pub(super) const STDOUT: &str = "-";

/// Collects what a build did.
pub(super) struct Report {
    path: PathBuf,
    started: std::time::Instant,
    head: Map<String, Json>,
    outputs: Vec<Json>,
    failures: Vec<Json>,
    warnings: Vec<String>,
    nodes: BTreeMap<(String, &'static str), NodeTotal>,
    peak_bytes: u64,
    planned_bytes: u64,
}

/// What the tasks of one node and stage did together, over all tiles.
#[derive(Default)]
struct NodeTotal {
    kind: &'static str,
    runs: u32,
    cached: u32,
    seconds: f64,
    bytes: u64,
    failed: bool,
}

impl Report {
    /// Starts a report; one that an earlier build left is removed, so that no report speaks of files that are no more.
    pub(super) fn start(path: &Path, head: Map<String, Json>) -> Result<Self, Stop> {
        if path == Path::new(STDOUT) {
            return Ok(Self::empty(path, head));
        }
        match std::fs::remove_file(path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(Stop::new(
                    Exit::Failed,
                    format!("cannot remove the old report {}: {e}", path.display()),
                ));
            }
            _ => (),
        }
        Ok(Self::empty(path, head))
    }

    fn empty(path: &Path, head: Map<String, Json>) -> Self {
        Self {
            path: path.to_owned(),
            started: std::time::Instant::now(),
            head,
            outputs: Vec::new(),
            failures: Vec::new(),
            warnings: Vec::new(),
            nodes: BTreeMap::new(),
            peak_bytes: 0,
            planned_bytes: 0,
        }
    }

    pub(super) fn output(&mut self, output: Json) {
        self.outputs.push(output);
    }

    /// What a person should know of the result.
    pub(super) fn warning(&mut self, text: String) {
        self.warnings.push(text);
    }

    pub(super) fn failure(&mut self, output: &str, message: &str, exit: Exit) {
        self.failures.push(json!({ "output": output, "error": message, "exit": exit.code() }));
    }

    /// Takes up what an evaluation did; gives what nodes said of their results and did not say before.
    pub(super) fn tasks(&mut self, tasks: &[TaskReport], peak_bytes: u64, planned_bytes: u64) -> Vec<String> {
        let mut news = Vec::new();
        self.peak_bytes = self.peak_bytes.max(peak_bytes);
        self.planned_bytes = self.planned_bytes.max(planned_bytes);
        for task in tasks {
            let total = self.nodes.entry((task.node.clone(), task.stage.name())).or_default();
            total.kind = task.kind;
            total.seconds += task.seconds;
            total.bytes = total.bytes.max(task.bytes);
            total.failed |= !task.done;
            match task.cached {
                Some(_) => total.cached += 1,
                None => total.runs += 1,
            }
            for warning in task.warnings.iter().map(|w| format!("node `{}`: {w}", task.node)) {
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning.clone());
                    news.push(warning);
                }
            }
        }
        news
    }

    /// Writes the report whole.
    pub(super) fn write(self) -> Result<(), Stop> {
        let nodes = self.nodes.iter().map(|((node, stage), t)| {
            json!({
                "node": node, "stage": stage, "kind": t.kind, "backend": "cpu", "runs": t.runs, "cached": t.cached,
                "seconds": t.seconds, "bytes": t.bytes, "failed": t.failed,
            })
        });
        let nodes: Vec<_> = nodes.collect();
        let mut report = self.head;
        let done = self.failures.is_empty();
        report.insert("status".into(), json!(if done { "done" } else { "failed" }));
        report.insert("seconds".into(), json!(self.started.elapsed().as_secs_f64()));
        report.insert("peak_bytes".into(), json!(self.peak_bytes));
        report.insert("planned_bytes".into(), json!(self.planned_bytes));
        report.insert("process_peak_bytes".into(), json!(crate::engine::process_peak()));
        report.insert("outputs".into(), Json::from(self.outputs));
        report.insert("warnings".into(), Json::from(self.warnings));
        report.insert("failures".into(), Json::from(self.failures));
        report.insert("nodes".into(), Json::from(nodes));
        let text = format!("{:#}\n", Json::from(report));
        if self.path == Path::new(STDOUT) {
            return print(&text).map(|_| ());
        }
        save(&self.path, text.as_bytes())
    }
}
