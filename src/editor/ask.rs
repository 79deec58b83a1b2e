//! The system's file dialogs. They run on a thread of their own, so that the window stays responsive while one is open.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use eframe::egui::Context;

/// The kind of file or folder that is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question {
    /// A graph to open.
    Open,
    /// A path to write a graph to; holds the suggested file name.
    Save(String),
    /// A file that a node reads.
    Source,
    /// A folder to build into.
    Folder,
}

/// Opens a dialog that starts in a folder, and returns where its answer arrives.
pub type Asker = Box<dyn Fn(Question, Option<&Path>, &Context) -> Answer>;

/// A dialog that ends without a path in less than this time never opened: no user is that quick.
const NEVER_OPENED: Duration = Duration::from_millis(400);

/// The result of a file dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// A path was chosen.
    Path(PathBuf),
    /// The dialog was cancelled.
    Nothing,
    /// The system has no file dialogs, so that the editor asks for a path in a window of its own.
    NoDialogs,
}

/// The answer of a file dialog, which may still be open.
#[derive(Debug)]
pub struct Answer(Receiver<Reply>);

impl Answer {
    /// An answer that is known from the start, for tests and other callers without dialogs.
    pub fn known(path: Option<PathBuf>) -> Self {
        let (to, from) = channel();
        // Sending cannot fail: the receiver still exists.
        let _ = to.send(path.map_or(Reply::Nothing, Reply::Path));
        Self(from)
    }

    /// The answer of a system without dialogs.
    pub fn no_dialogs() -> Self {
        let (to, from) = channel();
        // Sending cannot fail: the receiver still exists.
        let _ = to.send(Reply::NoDialogs);
        Self(from)
    }

    /// The answer, or `None` while the dialog is open.
    pub(crate) fn take(&self) -> Option<Reply> {
        match self.0.try_recv() {
            Ok(reply) => Some(reply),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Reply::Nothing),
        }
    }
}

/// Opens a dialog of the system.
pub(crate) fn system(question: Question, folder: Option<&Path>, ctx: &Context) -> Answer {
    let mut dialog = rfd::AsyncFileDialog::new();
    if let Some(folder) = folder {
        dialog = dialog.set_directory(folder);
    }
    let graphs = |d: rfd::AsyncFileDialog| d.add_filter("Orograph graph", &["graph"]);
    let (to, from) = channel();
    let ctx = ctx.clone();
    // The dialog is made on this thread, as some systems require, and awaited on another one.
    let waiting: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> = match question {
        Question::Open => Box::pin(graphs(dialog).pick_file()),
        Question::Save(name) => Box::pin(graphs(dialog).set_file_name(name).save_file()),
        Question::Source => Box::pin(dialog.pick_file()),
        Question::Folder => Box::pin(dialog.pick_folder()),
    };
    std::thread::spawn(move || {
        let asked = Instant::now();
        let reply = match pollster::block_on(waiting) {
            Some(file) => Reply::Path(file.path().to_owned()),
            None if asked.elapsed() < NEVER_OPENED => Reply::NoDialogs,
            None => Reply::Nothing,
        };
        // Sending fails when the window has closed, and the answer is no longer needed.
        let _ = to.send(reply);
        ctx.request_repaint();
    });
    Answer(from)
}
