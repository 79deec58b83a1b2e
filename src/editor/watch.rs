//! Looks at the file of the document beside the window, which sleeps while nothing happens.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// How often the file is looked at.
const EVERY: Duration = Duration::from_millis(800);

/// A thread that looks at a file until it is dropped.
#[derive(Debug)]
pub(crate) struct FileWatch {
    changed: Arc<AtomicBool>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl FileWatch {
    /// Looks at a file; `wake` is called when it has changed.
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

    /// Whether the file may have changed since this was last asked.
    pub(crate) fn take(&self) -> bool {
        self.changed.swap(false, Ordering::Relaxed)
    }
}

impl Drop for FileWatch {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // It has nothing to clean up.
            let _ = thread.join();
        }
    }
}

/// What tells a changed file from an unchanged one without reading it.
fn stamp(path: &PathBuf) -> Option<(SystemTime, u64)> {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}
