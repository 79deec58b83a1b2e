//! The system's dialogs for files, asked beside the window: it goes on while they are open.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

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

/// An answer that may not be there yet.
#[derive(Debug)]
pub struct Answer(Receiver<Option<PathBuf>>);

impl Answer {
    /// An answer that is known: for those who ask nobody.
    pub fn known(path: Option<PathBuf>) -> Self {
        let (to, from) = channel();
        // The receiver is here.
        let _ = to.send(path);
        Self(from)
    }

    /// The answer, once; `Some(None)` where nothing was chosen.
    pub(crate) fn take(&self) -> Option<Option<PathBuf>> {
        match self.0.try_recv() {
            Ok(path) => Some(path),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(None),
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
        let path = pollster::block_on(waiting).map(|file| file.path().to_owned());
        // The window may be gone.
        let _ = to.send(path);
        ctx.request_repaint();
    });
    Answer(from)
}
