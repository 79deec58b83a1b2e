//! The folder a build writes into: what may be written there, and what was.
//!
//! A build writes only into the folder the user named. It replaces files that a build wrote there before, which a
//! small list in the folder remembers even when a build was killed; others only with `--overwrite`; its own inputs
//! never.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cap_std::ambient_authority;
use cap_std::fs::Dir;
use serde_json::json;

use super::exit::{Exit, Stop, save};

const LIST: &str = ".orograph-files.json";

pub(super) struct Folder {
    path: PathBuf,
    dir: Dir,
    written: BTreeSet<String>,
    inputs: BTreeSet<PathBuf>,
    overwrite: bool,
}

impl Folder {
    /// Opens the folder, making it when needed.
    pub(super) fn open(
        path: &Path,
        inputs: impl IntoIterator<Item = PathBuf>,
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
        let inputs = inputs.into_iter().filter_map(|p| p.canonicalize().ok()).collect();
        Ok(Self { path: path.to_owned(), dir, written, inputs, overwrite })
    }

    /// The handle that files are written through.
    pub(super) fn dir(&self) -> &Dir {
        &self.dir
    }

    /// Claims the names of all files that a build will write, before it writes any.
    pub(super) fn claim(&mut self, names: &[String]) -> Result<(), Stop> {
        for name in names {
            let path = self.path.join(name);
            if path.canonicalize().is_ok_and(|p| self.inputs.contains(&p)) {
                return Err(Stop::usage(format!(
                    "{} is an input of this build and is never overwritten",
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
