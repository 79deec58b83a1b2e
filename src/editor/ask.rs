//! The system's dialogs for files, asked beside the window: it goes on while they are open.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use eframe::egui::Context;

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question {
    /// A graph to open.
    Open,
    /// Where to write a graph; the name to start from.
    Save(String),
    /// A file that a node reads.
    Source,
    /// A folder to build to.
    Folder,
}

/// Asks, and gives where the answer will come.
pub type Asker = Box<dyn Fn(Question, Option<&Path>, &Context) -> Answer>;

/// How quickly a dialog ends that never opened: nobody closes one in that time.
const NEVER_OPENED: Duration = Duration::from_millis(400);

/// What came of asking.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    /// A path was chosen.
    Path(PathBuf),
    /// Nothing was chosen.
    Nothing,
    /// The system has no dialogs: the editor asks by itself.
    NoDialogs,
}

/// An answer that may not be there yet.
#[derive(Debug)]
pub struct Answer(Receiver<Given>);

impl Answer {
    /// An answer that is known: for those who ask nobody.
    pub fn known(path: Option<PathBuf>) -> Self {
        let (to, from) = channel();
        // The receiver is here.
        let _ = to.send(path.map_or(Given::Nothing, Given::Path));
        Self(from)
    }

    /// The answer of a system without dialogs.
    pub fn no_dialogs() -> Self {
        let (to, from) = channel();
        // The receiver is here.
        let _ = to.send(Given::NoDialogs);
        Self(from)
    }

    /// The answer, once it is there.
    pub(crate) fn take(&self) -> Option<Given> {
        match self.0.try_recv() {
            Ok(given) => Some(given),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Given::Nothing),
        }
    }
}

/// Asks by the dialogs of the system.
pub(crate) fn system(question: Question, folder: Option<&Path>, ctx: &Context) -> Answer {
    let mut dialog = rfd::AsyncFileDialog::new();
    if let Some(folder) = folder {
        dialog = dialog.set_directory(folder);
    }
    let graphs = |d: rfd::AsyncFileDialog| d.add_filter("Orograph graph", &["graph"]);
    let (to, from) = channel();
    let ctx = ctx.clone();
    // The dialog is made here, as some systems ask, and waited for elsewhere.
    let waiting: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> = match question {
        Question::Open => Box::pin(graphs(dialog).pick_file()),
        Question::Save(name) => Box::pin(graphs(dialog).set_file_name(name).save_file()),
        Question::Source => Box::pin(dialog.pick_file()),
        Question::Folder => Box::pin(dialog.pick_folder()),
    };
    std::thread::spawn(move || {
        let asked = Instant::now();
        let given = match pollster::block_on(waiting) {
            Some(file) => Given::Path(file.path().to_owned()),
            None if asked.elapsed() < NEVER_OPENED => Given::NoDialogs,
            None => Given::Nothing,
        };
        // The window may be gone.
        let _ = to.send(given);
        ctx.request_repaint();
    });
    Answer(from)
}
