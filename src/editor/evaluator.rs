//! Evaluation beside the window: one thread takes the newest order, gives up what is stale, and puts what it finds on
//! a board that the window looks at. The window never waits for it.

mod estimate;
mod thumbnails;
mod view;

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::board::{Board, Made, Measured, Scenery};
use super::shade::Light;
use crate::context::Cancel;
use crate::engine::{Engine, EngineError, Files, Options};
use crate::graph::{Graph, NodeId};
use crate::value::Grid;
use view::Found;

/// Bytes of files that are read without asking, to know what they hold: a fraction of a second.
const UNASKED_BYTES: u64 = 256 << 20;

/// What the window would like to see.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    pub(crate) graph: Arc<Graph>,
    /// The state of the document that the graph is.
    pub(crate) state: u64,
    /// What the view shows.
    pub(crate) scene: Option<Scenery>,
    /// A part that is looked at closely: its window of a finer lattice.
    pub(crate) detail: Option<Grid>,
    /// The light of the picture under sun and sky, where that is wanted.
    pub(crate) light: Option<Light>,
    /// Nodes whose thumbnails are in sight.
    pub(crate) in_sight: Vec<NodeId>,
    /// A build that is to be estimated.
    pub(crate) build: Option<Measured>,
    /// Whether estimates over the limit were accepted.
    pub(crate) whatever_it_takes: bool,
}

/// The thread and what it shares with the window.
#[derive(Debug)]
pub(crate) struct Evaluator {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    desk: Mutex<Desk>,
    wake: Condvar,
    board: Mutex<Board>,
    /// What the exact view was made of, to light it anew.
    found: Mutex<Option<(Made, Found)>>,
    /// Called when the board has news.
    repaint: Box<dyn Fn() + Send + Sync>,
    /// Estimated seconds of an evaluation that is not started without asking.
    patience: f64,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").finish_non_exhaustive()
    }
}

/// What waits for the thread.
#[derive(Debug, Default)]
struct Desk {
    order: Option<Order>,
    /// Whether the thread is at work on the one before.
    working: bool,
    /// Whether what it works on is done in a moment, so that a new order waits: else a hand that never rests would see
    /// nothing.
    soon: bool,
    cancel: Cancel,
    closed: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Evaluator {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the engine or the thread cannot be started.
    pub(crate) fn start(
        options: &Options,
        files: Files,
        patience: f64,
        repaint: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self, EngineError> {
        let engine = Engine::new(options, files)?;
        let shared = Arc::new(Shared {
            desk: Mutex::default(),
            wake: Condvar::new(),
            board: Mutex::default(),
            found: Mutex::default(),
            repaint: Box::new(repaint),
            patience,
        });
        let work = shared.clone();
        let thread = std::thread::Builder::new().name("evaluator".to_owned());
        let thread = thread.spawn(move || work.run(&engine));
        let thread = thread.map_err(|e| EngineError::Threads(e.to_string()))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for something else; what is being made for the last order is given up, unless it is done in a moment.
    pub(crate) fn order(&self, order: Order) {
        let mut desk = lock(&self.shared.desk);
        desk.order = Some(order);
        if !desk.soon {
            desk.cancel.cancel();
        }
        self.shared.wake.notify_one();
    }

    /// Gives up what is being made.
    pub(crate) fn stop(&self) {
        let mut desk = lock(&self.shared.desk);
        desk.order = None;
        desk.cancel.cancel();
    }

    /// Whether an order waits or is worked on.
    pub(crate) fn is_busy(&self) -> bool {
        let desk = lock(&self.shared.desk);
        desk.order.is_some() || desk.working
    }

    /// What was found so far.
    pub(crate) fn board(&self) -> MutexGuard<'_, Board> {
        lock(&self.shared.board)
    }
}

impl Drop for Evaluator {
    fn drop(&mut self) {
        let mut desk = lock(&self.shared.desk);
        desk.closed = true;
        desk.cancel.cancel();
        drop(desk);
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to clean up.
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

    /// Waits for an order; `None` when the window is gone.
    fn next(&self) -> Option<(Order, Cancel)> {
        let mut desk = lock(&self.desk);
        loop {
            if desk.closed {
                return None;
            }
            desk.working = desk.order.is_some();
            if let Some(order) = desk.order.take() {
                desk.cancel = Cancel::default();
                return Some((order, desk.cancel.clone()));
            }
            desk = self.wake.wait(desk).unwrap_or_else(PoisonError::into_inner);
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

    /// Does what is done in a moment; new orders wait for it and then go before the rest.
    fn soon<T>(&self, work: impl FnOnce() -> Result<T, Stopped>) -> Result<T, Stopped> {
        lock(&self.desk).soon = true;
        let done = work();
        let mut desk = lock(&self.desk);
        desk.soon = false;
        if desk.order.is_some() || desk.closed { Err(Stopped) } else { done }
    }
}

/// The work was given up.
struct Stopped;
