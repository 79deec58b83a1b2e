//! The watch over the file of the document. It runs on a thread, because the window draws no frames while it is idle.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// Time between two checks of the file.
const EVERY: Duration = Duration::from_millis(800);

/// A thread that checks a file for changes until this is dropped.
#[derive(Debug)]
pub(crate) struct FileWatch {
    changed: Arc<AtomicBool>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl FileWatch {
    /// Starts to watch a file; `wake` is called when its length or its time of modification has changed.
    pub(crate) fn on(path: &Path, wake: impl Fn() + Send + 'static) -> Self {
        let changed = Arc::new(AtomicBool::new(false));
        let (stop, stopped) = channel();
        let (path, flag) = (path.to_owned(), changed.clone());
        let mut last = stamp(&path);
        let thread = std::thread::spawn(move || {
            while stopped.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                let now = stamp(&path);
                if now != last {
                    last = now;
                    flag.store(true, Ordering::Relaxed);
                    wake();
                }
            }
        });
        Self { changed, stop: Some(stop), thread: Some(thread) }
    }

    /// Whether the file may have changed since the last call.
    pub(crate) fn take(&self) -> bool {
        self.changed.swap(false, Ordering::Relaxed)
    }
}

impl Drop for FileWatch {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked leaves nothing to clean up.
            let _ = thread.join();
        }
    }
}

/// The time of modification and the length of a file, which tell of most changes without reading it.
fn stamp(path: &PathBuf) -> Option<(SystemTime, u64)> {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}
