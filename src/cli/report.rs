//! The machine-readable report of a build: removed when the build starts, written last.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{Metadata, Permissions};
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value as Json, json};

use super::exit::{Exit, Stop, json_text, print_json, save};
use super::folder::Folder;
use super::shared::{self, Part};
use crate::engine::{Evaluation, process_peak, process_seconds};
use crate::files::Tile;
use crate::name::Name;
use crate::whole::{self, Known};

/// The name of the report in the folder of a build.
pub(super) const REPORT: &str = "report.json";

/// The path that stands for standard output.
pub(super) const STDOUT: &str = "-";

/// The report of a build while it runs.
pub(super) struct Report<'a> {
    path: PathBuf,
    folder: &'a Folder,
    /// The permissions of the report of an earlier build, which the new report gets.
    permissions: Option<Permissions>,
    started: std::time::Instant,
    head: Map<String, Json>,
    /// The part of this build in a report that several builds share.
    part: Option<Part>,
    outputs: Vec<Json>,
    failures: Vec<Json>,
    warnings: Vec<String>,
    nodes: BTreeMap<(String, &'static str), NodeTotal>,
    peak_bytes: u64,
    planned_bytes: u64,
    reserve_bytes: u64,
    planned_seconds: f64,
}

/// The totals of the tasks of one node and stage over all tiles.
#[derive(Default)]
struct NodeTotal {
    kind: Name,
    runs: u32,
    cached: u32,
    seconds: f64,
    bytes: u64,
    failed: bool,
}

impl<'a> Report<'a> {
    /// Starts a report. The report of an earlier build is removed, so that no report lists files that no longer exist.
    /// Of a report that builds of single tiles share, only the entries of this build's tiles are removed.
    pub(super) fn start(
        path: &Path,
        folder: &'a Folder,
        head: Map<String, Json>,
        part: Option<Part>,
    ) -> Result<Self, Stop> {
        let old = path.metadata().ok().filter(Metadata::is_file);
        let report = Self {
            path: path.to_owned(),
            folder,
            permissions: old.map(|old| old.permissions()),
            started: std::time::Instant::now(),
            head,
            part,
            outputs: Vec::new(),
            failures: Vec::new(),
            warnings: Vec::new(),
            nodes: BTreeMap::new(),
            peak_bytes: 0,
            planned_bytes: 0,
            reserve_bytes: 0,
            planned_seconds: 0.0,
        };
        if !report.is_printed() {
            let cannot = |e: io::Error| {
                Stop::new(Exit::Failed, format!("cannot write the report {}: {e}", path.display()))
            };
            whole::probe(path).map_err(cannot)?;
            report.clear()?;
        }
        Ok(report)
    }

    fn is_printed(&self) -> bool {
        self.path == Path::new(STDOUT)
    }

    fn clear(&self) -> Result<(), Stop> {
        let _lock = self.part.as_ref().and_then(|_| self.folder.lock());
        let others = self.part.as_ref().and_then(|part| shared::without(self.of_others()?, part));
        if let Some(others) = others {
            return save(&self.path, json_text(&Json::from(others)).as_bytes());
        }
        match std::fs::remove_file(&self.path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Stop::new(
                Exit::Failed,
                format!("cannot remove the old report {}: {e}", self.path.display()),
            )),
            _ => Ok(()),
        }
    }

    /// The existing report, where it is of another part of the same build.
    fn of_others(&self) -> Option<Map<String, Json>> {
        let text = std::fs::read(&self.path).ok()?;
        let report = serde_json::from_slice::<Map<String, Json>>(&text).ok()?;
        shared::is_same_build(&report, &self.head).then_some(report)
    }

    pub(super) fn graph_key(&self) -> &str {
        self.head.get("graph_key").and_then(Json::as_str).unwrap_or_default()
    }

    /// The files of this build so far.
    pub(super) fn outputs(&self) -> &[Json] {
        &self.outputs
    }

    pub(super) fn output(&mut self, output: Json) {
        self.outputs.push(output);
    }

    /// Sets the bytes that are reserved for the program, the document and the writers.
    pub(super) fn reserve(&mut self, bytes: u64) {
        self.reserve_bytes = bytes;
    }

    /// Adds seconds to the estimate that are not part of an evaluation.
    pub(super) fn planned_seconds(&mut self, seconds: f64) {
        self.planned_seconds += seconds;
    }

    /// Adds a warning.
    pub(super) fn warning(&mut self, text: String) {
        self.warnings.push(text);
    }

    /// Adds an output that failed, on one tile or on all.
    pub(super) fn failure(&mut self, output: &str, message: &str, exit: Exit, tile: Option<Tile>) {
        let tiles = match (&self.part, tile) {
            (Some(part), None) => part.tiles.iter().copied().map(Some).collect(),
            _ => vec![tile],
        };
        let entry = |tile| json!({ "output": output, "error": message, "exit": exit.code(), "tile": tile });
        self.failures.extend(tiles.into_iter().map(entry));
    }

    /// Adds the tasks of an evaluation; returns the warnings of nodes that were not given before.
    pub(super) fn evaluation(&mut self, of: &Evaluation) -> Vec<String> {
        let mut news = Vec::new();
        self.peak_bytes = self.peak_bytes.max(of.peak_bytes);
        self.planned_bytes = self.planned_bytes.max(of.planned_bytes);
        self.planned_seconds += of.planned_seconds;
        for task in &of.tasks {
            let total = self.nodes.entry((task.node.clone(), task.stage.name())).or_default();
            total.kind.clone_from(&task.kind);
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

    /// Writes the report, whole or not at all.
    pub(super) fn write(mut self) -> Result<(), Stop> {
        let whole = [self.head["whole"]["cols"].as_u64(), self.head["whole"]["rows"].as_u64()];
        let whole = whole.map(|n| n.unwrap_or_default() as usize);
        let key = self.graph_key().to_owned();
        let own = self.taken();
        let _lock = self.part.as_ref().and_then(|_| self.folder.lock());
        let others = self.part.as_ref().filter(|_| !self.is_printed()).and_then(|_| self.of_others());
        let mut report = match (others, &self.part) {
            (Some(others), Some(part)) => shared::merged(others, own, part),
            _ => own,
        };
        let names = files(&report);
        report.insert("stale".into(), json!(self.folder.stale(&names, &key, whole)));
        let report = Json::from(report);
        if self.is_printed() {
            return print_json(&report).map(|_| ());
        }
        let cannot = |e: io::Error| {
            Stop::new(Exit::Failed, format!("cannot write the report {}: {e}", self.path.display()))
        };
        let text = json_text(&report);
        whole::save_like(&self.path, text.as_bytes(), Known::Anything, self.permissions.take())
            .map_err(cannot)
    }

    /// The content of the report.
    fn taken(&mut self) -> Map<String, Json> {
        let nodes = self.nodes.iter().map(|((node, stage), t)| {
            json!({
                "node": node, "stage": stage, "kind": t.kind.as_str(), "backend": "cpu", "runs": t.runs, "cached": t.cached,
                "seconds": t.seconds, "bytes": t.bytes, "failed": t.failed,
            })
        });
        let nodes: Vec<_> = nodes.collect();
        let mut report = self.head.clone();
        report.insert("seconds".into(), json!(self.started.elapsed().as_secs_f64()));
        report.insert("peak_bytes".into(), json!(self.peak_bytes));
        report.insert("planned_bytes".into(), json!(self.planned_bytes));
        report.insert("reserve_bytes".into(), json!(self.reserve_bytes));
        report.insert("process_peak_bytes".into(), json!(process_peak()));
        report.insert("planned_seconds".into(), json!(self.planned_seconds));
        report.insert("processor_seconds".into(), json!(process_seconds()));
        report.insert("outputs".into(), Json::from(std::mem::take(&mut self.outputs)));
        report.insert("warnings".into(), Json::from(std::mem::take(&mut self.warnings)));
        report.insert("failures".into(), Json::from(std::mem::take(&mut self.failures)));
        report.insert("nodes".into(), Json::from(nodes));
        shared::settle(&mut report);
        report
    }
}

/// The files that a report lists.
fn files(report: &Map<String, Json>) -> BTreeSet<String> {
    let outputs = report.get("outputs").and_then(Json::as_array).into_iter().flatten();
    let names = outputs.flat_map(|o| [o["path"].as_str(), o["sidecar"].as_str()]);
    names.flatten().map(str::to_owned).collect()
}
