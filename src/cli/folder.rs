//! The folder into which a build writes: which files may be replaced, and which were written.
//!
//! A build writes only into the folder that the user named. It replaces files of earlier builds, which are in a list in
//! the folder even where a build was killed. It replaces other files only with `--overwrite`, and its own inputs never.
//! Several builds can write into one folder at the same time, as those of single tiles do.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use cap_std::ambient_authority;
use cap_std::fs::{Dir, OpenOptions};
use serde_json::{Value as Json, json};

use super::exit::{Exit, Stop, json_text, spare_inputs};
use super::sidecars::other_owner;
use crate::files::sidecar_name;
use crate::whole::{self, Changed, Known};

const LIST: &str = ".orograph-files.json";
/// The file that a build locks while it changes the list or a report that several builds share.
const LOCK: &str = ".orograph-files.lock";
/// The most times that the list is read again where the system has no locks and other builds change it.
const TRIES: usize = 100;

pub(super) struct Folder {
    path: PathBuf,
    dir: Dir,
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
        let cannot = |what: &str, e: io::Error| {
            Stop::new(Exit::Failed, format!("cannot {what} the folder {}: {e}", path.display()))
        };
        std::fs::create_dir_all(path).map_err(|e| cannot("make", e))?;
        let dir = Dir::open_ambient_dir(path, ambient_authority()).map_err(|e| cannot("open", e))?;
        whole::probe_in(&dir, LIST).map_err(|e| cannot("write into", e))?;
        let theirs = report.symlink_metadata().is_ok() && !is_report(report) && !overwrite;
        if theirs {
            return Err(Stop::usage(format!(
                "{} is there already and is no report; name another with --report or say --overwrite",
                report.display()
            )));
        }
        let (inputs, report) = (inputs.to_vec(), report.to_owned());
        let folder = Self { path: path.to_owned(), dir, inputs, report, overwrite };
        let (_, written) = folder.list()?;
        let is_ours =
            |left: &whole::Left<'_>| left.is_of(LIST) || written.iter().any(|name| left.is_of(name));
        whole::sweep(&folder.dir, is_ours);
        Ok(folder)
    }

    /// The handle of the folder, by which files are written.
    pub(super) fn dir(&self) -> &Dir {
        &self.dir
    }

    /// A lock that keeps other builds from changing list and report; `None` where the system has no locks.
    pub(super) fn lock(&self) -> Option<File> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true);
        let file = self.dir.open_with(LOCK, &options).ok()?.into_std();
        file.lock().ok().map(|()| file)
    }

    /// The content of the file of the list, and the names in it.
    fn list(&self) -> Result<(Option<Vec<u8>>, BTreeSet<String>), Stop> {
        let bytes = match self.dir.read(LIST) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok((None, BTreeSet::new())),
            Err(e) => return Err(self.cannot(LIST, "read", &e)),
        };
        let list: Json = serde_json::from_slice(&bytes).unwrap_or_default();
        let names = list["files"].as_array().into_iter().flatten();
        let names = names.filter_map(|n| n.as_str().map(str::to_owned)).collect();
        Ok((Some(bytes), names))
    }

    /// Refuses to overwrite the sidecar of another existing file, as happens after a change of the format.
    pub(super) fn spare_sidecar(&self, file: &str) -> Result<(), Stop> {
        match other_owner(&self.path, file).filter(|_| !self.overwrite) {
            None => Ok(()),
            Some(other) => Err(Stop::usage(format!(
                "{} is the sidecar of {other}, and {file} needs one of that name; name another folder or say --overwrite",
                self.path.join(sidecar_name(file)).display()
            ))),
        }
    }

    /// Claims the names of all files that a build will write, before it writes any.
    pub(super) fn claim(&self, names: &[String]) -> Result<(), Stop> {
        let _lock = self.lock();
        for _ in 0..TRIES {
            let (bytes, mut written) = self.list()?;
            names.iter().try_for_each(|name| self.may_write(name, &written))?;
            written.extend(names.iter().cloned());
            let text = json_text(&json!({ "about": "files that orograph wrote here", "files": written }));
            let known = bytes.as_deref().map_or(Known::Absent, Known::Bytes);
            match whole::write(&self.dir, LIST, known, |out| out.write_all(text.as_bytes())) {
                Ok(()) => return Ok(()),
                Err(e) if Changed::is(&e) => (),
                Err(e) => return Err(self.cannot(LIST, "write", &e)),
            }
        }
        Err(self.cannot(LIST, "write", &Changed))
    }

    fn may_write(&self, name: &str, written: &BTreeSet<String>) -> Result<(), Stop> {
        let path = self.path.join(name);
        spare_inputs(&path, &self.inputs)?;
        if same_place(&path, &self.report) {
            return Err(Stop::usage(format!(
                "{} is where the report goes; rename the output or name another place with --report",
                path.display()
            )));
        }
        let theirs = path.symlink_metadata().is_ok() && !written.contains(name) && !self.overwrite;
        if theirs {
            return Err(Stop::usage(format!(
                "{} is there already and no build wrote it; name another folder or say --overwrite",
                path.display()
            )));
        }
        whole::may_replace(&self.dir, name).map_err(|e| self.cannot(name, "write", &e))
    }

    fn cannot(&self, name: &str, what: &str, why: &dyn std::fmt::Display) -> Stop {
        Stop::new(Exit::Failed, format!("cannot {what} {}: {why}", self.path.join(name).display()))
    }

    /// The files of earlier builds that do not belong to this one: they are not among `own`, and their sidecars are of
    /// another graph or another size.
    pub(super) fn stale(&self, own: &BTreeSet<String>, graph_key: &str, whole: [usize; 2]) -> Vec<String> {
        let Ok((_, written)) = self.list() else { return Vec::new() };
        let is_there = |name: &String| self.dir.symlink_metadata(name).is_ok();
        let others = written.into_iter().filter(|name| !own.contains(name) && is_there(name));
        others.filter(|name| !self.is_made_of(name, graph_key, whole)).collect()
    }

    fn is_made_of(&self, name: &str, graph_key: &str, whole: [usize; 2]) -> bool {
        let sidecar = self.dir.read(sidecar_name(name)).ok();
        let sidecar: Json = sidecar.and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
        let [cols, rows] = whole;
        let grid = &sidecar["grid"];
        sidecar["graph_key"] == graph_key && grid["whole_cols"] == cols && grid["whole_rows"] == rows
    }
}

/// Whether a file is the report of a build.
fn is_report(path: &Path) -> bool {
    let json = std::fs::read(path).ok().and_then(|text| serde_json::from_slice::<Json>(&text).ok());
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
