//! The folder a build writes into: what may be written there, and what was.
//!
//! A build writes only into the folder the user named. It replaces files that a build wrote there before, which a
//! small list in the folder remembers even when a build was killed; others only with `--overwrite`; its own inputs
//! never.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use cap_std::ambient_authority;
use cap_std::fs::Dir;
use serde_json::json;

use super::exit::{Exit, Stop, save, spare_inputs};
use crate::files::passing_name_of;

const LIST: &str = ".orograph-files.json";

/// How long a file under a passing name must have been left alone to be taken for a dead build's.
const QUIET: Duration = Duration::from_secs(600);

pub(super) struct Folder {
    path: PathBuf,
    dir: Dir,
    written: BTreeSet<String>,
    inputs: Vec<PathBuf>,
    report: PathBuf,
    overwrite: bool,
}

impl Folder {
    /// Opens the folder, making it when needed.
    pub(super) fn open(
        path: &Path,
        inputs: &[PathBuf],
        report: &Path,
        overwrite: bool,
    ) -> Result<Self, Stop> {
        let cannot = |e: std::io::Error| {
            Stop::new(Exit::Failed, format!("cannot make the folder {}: {e}", path.display()))
        };
        std::fs::create_dir_all(path).map_err(cannot)?;
        let dir = Dir::open_ambient_dir(path, ambient_authority()).map_err(cannot)?;
        let list = std::fs::read(path.join(LIST)).ok();
        let list = list.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
        let names = list.as_ref().and_then(|v| v["files"].as_array());
        let written = names.into_iter().flatten().filter_map(|n| n.as_str().map(str::to_owned)).collect();
        let theirs = report.symlink_metadata().is_ok() && !is_report(report) && !overwrite;
        if theirs {
            return Err(Stop::usage(format!(
                "{} is there already and is no report; name another with --report or say --overwrite",
                report.display()
            )));
        }
        let folder = Self {
            path: path.to_owned(),
            dir,
            written,
            inputs: inputs.to_vec(),
            report: report.to_owned(),
            overwrite,
        };
        folder.sweep();
        Ok(folder)
    }

    /// Removes what builds that were killed left under passing names.
    fn sweep(&self) {
        let Ok(entries) = self.dir.entries() else { return };
        let names = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned());
        let left: Vec<String> = names.filter(|n| self.is_left_over(n)).collect();
        for name in left {
            // Another build may sweep at the same time.
            let _ = self.dir.remove_file(name);
        }
    }

    /// Whether a file is one of this folder's under a passing name, and nobody has written it for a while: a process
    /// of another machine may be at work in the same folder.
    fn is_left_over(&self, name: &str) -> bool {
        let ours = passing_name_of(name).is_some_and(|file| file == LIST || self.written.contains(file));
        let modified = self.dir.metadata(name).ok().and_then(|m| m.modified().ok());
        ours && modified.and_then(|m| m.into_std().elapsed().ok()).is_some_and(|age| age > QUIET)
    }

    /// The handle that files are written through.
    pub(super) fn dir(&self) -> &Dir {
        &self.dir
    }

    /// Claims the names of all files that a build will write, before it writes any.
    pub(super) fn claim(&mut self, names: &[String]) -> Result<(), Stop> {
        for name in names {
            let path = self.path.join(name);
            spare_inputs(&path, &self.inputs)?;
            if same_place(&path, &self.report) {
                return Err(Stop::usage(format!(
                    "{} is where the report goes; rename the output or name another place with --report",
                    path.display()
                )));
            }
            let theirs = path.symlink_metadata().is_ok() && !self.written.contains(name) && !self.overwrite;
            if theirs {
                return Err(Stop::usage(format!(
                    "{} is there already and no build wrote it; name another folder or say --overwrite",
                    path.display()
                )));
            }
        }
        self.written.extend(names.iter().cloned());
        let text =
            format!("{:#}\n", json!({ "about": "files that orograph wrote here", "files": self.written }));
        save(&self.path.join(LIST), text.as_bytes())
    }
}

/// Whether a file is the report of a build.
fn is_report(path: &Path) -> bool {
    let json =
        std::fs::read(path).ok().and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    json.is_some_and(|report| report.get("orograph").is_some() && report.get("graph_key").is_some())
}

/// Whether two paths, which need not exist, name one place.
fn same_place(a: &Path, b: &Path) -> bool {
    let whole = |p: &Path| {
        let folder = p.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some((folder.canonicalize().ok()?, p.file_name()?.to_owned()))
    };
    whole(a).is_some_and(|a| whole(b) == Some(a))
}
