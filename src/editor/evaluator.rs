//! Evaluation in the background: a thread takes the newest order, cancels work on older ones, and puts the results on a
//! board that the window reads. The window never blocks on an evaluation.

mod estimate;
mod thumbnails;
mod view;

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::board::{Board, BuildRequest, Scenery, ViewContents};
use super::shade::Light;
use crate::context::Cancel;
use crate::engine::{Engine, EngineError, Files, Options};
use crate::graph::{Graph, NodeId};
use crate::value::Grid;
use view::Evaluated;

/// Bytes of files that are read without asking the user; reading them takes a fraction of a second.
const UNASKED_BYTES: u64 = 256 << 20;

/// What the window asks the evaluator for.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    pub(crate) graph: Arc<Graph>,
    /// The state of the document that has this graph.
    pub(crate) state: u64,
    /// The scene to show.
    pub(crate) scene: Option<Scenery>,
    /// The window of a finer lattice that the user has zoomed in to.
    pub(crate) detail: Option<Grid>,
    /// The light of the shaded picture, where one is shown.
    pub(crate) light: Option<Light>,
    /// Nodes whose thumbnails are visible; these are made first.
    pub(crate) in_sight: Vec<NodeId>,
    /// The build whose cost is to be estimated.
    pub(crate) build: Option<BuildRequest>,
    /// Whether the user has accepted estimates over the limits.
    pub(crate) is_cost_accepted: bool,
}

/// The thread that evaluates, and the data it shares with the window.
#[derive(Debug)]
pub(crate) struct Evaluator {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    mailbox: Mutex<Mailbox>,
    wake: Condvar,
    board: Mutex<Board>,
    /// The values of the last exact view, so that a change of light needs no evaluation.
    evaluated: Mutex<Option<(ViewContents, Evaluated)>>,
    /// Called when the board has changed.
    repaint: Box<dyn Fn() + Send + Sync>,
    /// Estimated seconds above which the user is asked before an evaluation starts.
    patience: f64,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").finish_non_exhaustive()
    }
}

/// The next order, and the state of the work on the one before.
#[derive(Debug, Default)]
struct Mailbox {
    order: Option<Order>,
    /// Whether the thread works on an order.
    is_working: bool,
    /// Whether the running work is short and a new order does not cancel it. Continuous dragging would otherwise cancel
    /// every draft and never show a result.
    is_uninterruptible: bool,
    cancel: Cancel,
    is_closed: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Evaluator {
    /// Starts the thread.
    ///
    /// # Errors
    /// Fails when the engine or the thread cannot be started.
    pub(crate) fn start(
        options: &Options,
        files: Files,
        patience: f64,
        repaint: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self, EngineError> {
        let engine = Engine::new(options, files)?;
        let shared = Arc::new(Shared {
            mailbox: Mutex::default(),
            wake: Condvar::new(),
            board: Mutex::default(),
            evaluated: Mutex::default(),
            repaint: Box::new(repaint),
            patience,
        });
        let work = shared.clone();
        let thread = std::thread::Builder::new().name("evaluator".to_owned());
        let thread = thread.spawn(move || work.run(&engine));
        let thread = thread.map_err(|e| EngineError::Threads(e.to_string()))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Places a new order and cancels work on the last one, unless that is uninterruptible.
    pub(crate) fn order(&self, order: Order) {
        let mut mailbox = lock(&self.shared.mailbox);
        mailbox.order = Some(order);
        if !mailbox.is_uninterruptible {
            mailbox.cancel.cancel();
        }
        self.shared.wake.notify_one();
    }

    /// Withdraws the order and cancels the work on it.
    pub(crate) fn stop(&self) {
        let mut mailbox = lock(&self.shared.mailbox);
        mailbox.order = None;
        mailbox.cancel.cancel();
    }

    /// Whether an order is waiting or being worked on.
    pub(crate) fn is_busy(&self) -> bool {
        let mailbox = lock(&self.shared.mailbox);
        mailbox.order.is_some() || mailbox.is_working
    }

    /// The board with the results so far; the evaluator cannot write to it while it is borrowed.
    pub(crate) fn board(&self) -> MutexGuard<'_, Board> {
        lock(&self.shared.board)
    }
}

impl Drop for Evaluator {
    fn drop(&mut self) {
        let mut mailbox = lock(&self.shared.mailbox);
        mailbox.is_closed = true;
        mailbox.cancel.cancel();
        drop(mailbox);
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked leaves nothing to clean up.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn run(&self, engine: &Engine) {
        while let Some((order, cancel)) = self.next() {
            self.tell(|board| board.begin(&order));
            let done = self.work(engine, &order, &cancel);
            self.tell(|board| board.end(done.is_ok()));
        }
    }

    /// Blocks until there is an order; returns `None` when the window has closed.
    fn next(&self) -> Option<(Order, Cancel)> {
        let mut mailbox = lock(&self.mailbox);
        loop {
            if mailbox.is_closed {
                return None;
            }
            mailbox.is_working = mailbox.order.is_some();
            if let Some(order) = mailbox.order.take() {
                mailbox.cancel = Cancel::default();
                return Some((order, mailbox.cancel.clone()));
            }
            mailbox = self.wake.wait(mailbox).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn tell(&self, news: impl FnOnce(&mut Board)) {
        news(&mut lock(&self.board));
        (self.repaint)();
    }

    fn work(&self, engine: &Engine, order: &Order, cancel: &Cancel) -> Result<(), Stopped> {
        self.estimate(engine, order);
        if let Some(scene) = &order.scene {
            self.view(engine, order, scene, cancel)?;
            self.detail(engine, order, scene, cancel)?;
        }
        self.thumbnails(engine, order, cancel)
    }

    /// Does short work that a new order does not cancel. Fails when an order has arrived in the meantime, so that the
    /// caller drops the rest of the old one.
    fn uninterrupted<T>(&self, work: impl FnOnce() -> Result<T, Stopped>) -> Result<T, Stopped> {
        lock(&self.mailbox).is_uninterruptible = true;
        let done = work();
        let mut mailbox = lock(&self.mailbox);
        mailbox.is_uninterruptible = false;
        if mailbox.order.is_some() || mailbox.is_closed { Err(Stopped) } else { done }
    }
}

/// The error of work that was cancelled.
struct Stopped;
