//! The preferences of the user, stored in the user's own folder and never in a graph.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::shade::Look;
use crate::whole::{self, Known};

/// The most files in the list of recent files.
const RECENT: usize = 12;

/// The preferences; the names of the fields are those in `settings.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Preferences {
    pub(crate) dark: bool,
    pub(crate) snap: bool,
    /// Whether nodes show how long they took.
    pub(crate) times: bool,
    pub(crate) look: Look,
    pub(crate) charts: bool,
    pub(crate) recent: Vec<PathBuf>,
    /// Whether the first-run page was shown.
    pub(crate) welcomed: bool,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            dark: true,
            snap: true,
            times: true,
            look: Look::default(),
            charts: false,
            recent: Vec::new(),
            welcomed: false,
        }
    }
}

impl Preferences {
    /// Reads the preferences; a file that cannot be read gives the defaults.
    pub(crate) fn read(home: Option<&Path>) -> Self {
        let text = home.and_then(|h| std::fs::read(h.join("settings.json")).ok());
        text.and_then(|t| serde_json::from_slice(&t).ok()).unwrap_or_default()
    }

    /// Writes the preferences, whole or not at all.
    ///
    /// # Errors
    /// Returns the errors of the file system.
    pub(crate) fn write(&self, home: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(home)?;
        whole::save(&home.join("settings.json"), &serde_json::to_vec_pretty(self)?, Known::Anything)
    }

    /// Puts a file at the top of the recent files.
    pub(crate) fn opened(&mut self, path: &Path) {
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }
}
