//! Evaluation beside the window: one thread takes the newest order, gives up what is stale, and puts what it finds on
//! a board that the window looks at. The window never waits for it.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::board::{Board, Made, NodeState, Seen, Shown};
use super::draft::{draft_of, preview};
use super::shade::{Look, picture};
use super::watcher::Watcher;
use crate::context::Cancel;
use crate::engine::{Engine, EngineError, Files, Options, Want};
use crate::graph::{Graph, NodeId, Source};
use crate::render::{Scene, Watch, map};
use crate::value::{Field, Grid, Quantity, Value};

/// Samples along the longer side of a thumbnail.
const THUMBNAIL: u32 = 97;
/// Estimated seconds from which a draft is shown before the exact result.
const DRAFT_ABOVE: f64 = 0.12;
/// Estimated seconds of a thumbnail that nobody asked for.
const THUMBNAIL_SECONDS: f64 = 4.0;

/// What the window would like to see.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    pub(crate) graph: Arc<Graph>,
    /// The state of the document that the graph is.
    pub(crate) state: u64,
    /// What the view shows.
    pub(crate) target: Option<Source>,
    /// Samples along the longer side of the view.
    pub(crate) size: u32,
    pub(crate) look: Look,
    /// A part that is looked at closely: its window of a finer lattice.
    pub(crate) detail: Option<Grid>,
    /// Whether the picture under sun and sky is wanted.
    pub(crate) lit: bool,
    /// Nodes whose thumbnails are in sight.
    pub(crate) in_sight: Vec<NodeId>,
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
            repaint: Box::new(repaint),
            patience,
        });
        let work = shared.clone();
        let thread = std::thread::Builder::new().name("evaluator".to_owned());
        let thread = thread.spawn(move || work.run(&engine));
        let thread = thread.map_err(|e| EngineError::Threads(e.to_string()))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for something else; what is being made for the last order is given up.
    pub(crate) fn order(&self, order: Order) {
        let mut desk = lock(&self.shared.desk);
        desk.order = Some(order);
        desk.cancel.cancel();
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
        if let Some(target) = order.target {
            let made = Made { state: order.state, target, size: order.size, look: order.look };
            let stands = lock(&self.board).stands(&made, order.lit);
            if !stands {
                self.view(engine, order, target, cancel)?;
            }
            self.detail(engine, order, target, cancel)?;
        }
        self.thumbnails(engine, order, cancel)
    }

    /// Makes what the view shows: a draft at once where the exact result takes long, then that.
    fn view(&self, engine: &Engine, order: &Order, target: Source, cancel: &Cancel) -> Result<(), Stopped> {
        let graph = &order.graph;
        let Some(grid) = preview(graph.terrain(), order.size) else { return Ok(()) };
        let want = |grid| Want { node: target.node, port: target.port, grid };
        let plan = engine.plan(graph, &[want(grid)]);
        let over = engine.admit(&plan).err().map(|e| e.to_string());
        let long = plan.seconds() > self.patience && !order.whatever_it_takes;
        if over.is_some() || long {
            let seconds = plan.seconds();
            self.tell(|board| board.hold(over, seconds));
            return Err(Stopped);
        }
        if plan.seconds() > DRAFT_ABOVE
            && let Some((draft, grid)) = draft_of(graph, order.size)
        {
            self.show(engine, order, &draft, &want(grid), true, cancel)?;
        }
        self.show(engine, order, graph, &want(grid), false, cancel)
    }

    /// Makes the part that is looked at closely.
    fn detail(&self, engine: &Engine, order: &Order, target: Source, cancel: &Cancel) -> Result<(), Stopped> {
        let Some(grid) = order.detail else { return Ok(()) };
        let whole = lock(&self.board).shown.as_ref().and_then(|s| value_range(&s.value));
        let Some(range) = whole else { return Ok(()) };
        let want = Want { node: target.node, port: target.port, grid };
        let plan = engine.plan(&order.graph, std::slice::from_ref(&want));
        if engine.admit(&plan).is_err() || plan.seconds() > self.patience {
            return Ok(());
        }
        let tell = |node, state| self.tell(|board| board.node(node, state));
        let watch = Watcher::new(&order.graph, &tell);
        let evaluation = match engine.evaluate(&order.graph, &[want], &watch, cancel) {
            Ok(evaluation) => evaluation,
            Err(_) if cancel.is_cancelled() => return Err(Stopped),
            // The whole view stays.
            Err(_) => return Ok(()),
        };
        let effective_cell = evaluation.effective_cells.first().copied().flatten();
        for value in evaluation.values.into_iter().flatten() {
            let terrain = order.graph.terrain();
            let picture = picture(&value, &order.look, Some(range), terrain, cancel).map_err(|_| Stopped)?;
            let (picture, bounds) = (Arc::new(picture), terrain.bounds());
            let shown = Shown { value, picture, draft: false, effective_cell, bounds };
            self.tell(|board| board.refine(shown));
        }
        Ok(())
    }

    fn show(
        &self,
        engine: &Engine,
        order: &Order,
        graph: &Graph,
        want: &Want,
        draft: bool,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let tell = |node, state| self.tell(|board| board.node(node, state));
        let watch = Watcher::new(graph, &tell);
        let evaluation = match engine.evaluate(graph, std::slice::from_ref(want), &watch, cancel) {
            Ok(evaluation) => evaluation,
            Err(EngineError::Cancelled) => return Err(Stopped),
            Err(other) => {
                self.tell(|board| board.view_fails(order.state, other.to_string()));
                return Ok(());
            }
        };
        let effective_cell = evaluation.effective_cells.first().copied().flatten();
        for value in evaluation.values {
            match value {
                Ok(value) => {
                    let picture = picture(&value, &order.look, None, graph.terrain(), cancel);
                    let picture = Arc::new(picture.map_err(|_| Stopped)?);
                    let bounds = graph.terrain().bounds();
                    let height = field_to_light(&value).filter(|_| order.lit && !draft);
                    let shown = Shown { value, picture, draft, effective_cell, bounds };
                    let (state, size, look) = (order.state, order.size, order.look);
                    let target = Source { node: want.node, port: want.port };
                    let made = (!draft).then_some(Made { state, target, size, look });
                    self.tell(|board| board.show(shown, made));
                    if let Some(height) = height {
                        self.light(&height, cancel)?;
                    }
                }
                Err(failure) => {
                    let at = failure.node().and_then(|name| graph.find(name));
                    self.tell(|board| {
                        if let Some(node) = at {
                            board.node(node, NodeState::Failed(failure.to_string()));
                        }
                        board.view_fails(order.state, failure.to_string());
                    });
                }
            }
        }
        Ok(())
    }

    /// Makes the picture under sun and sky of what is shown.
    fn light(&self, height: &Field, cancel: &Cancel) -> Result<(), Stopped> {
        let lit = map(&Scene::new(height), None, &Watch::quiet(cancel));
        match lit {
            Ok(picture) => self.tell(|board| board.light(picture)),
            Err(_) if cancel.is_cancelled() => return Err(Stopped),
            // The quick picture stays.
            Err(_) => (),
        }
        Ok(())
    }

    /// Makes the small pictures of the nodes whose results have changed, those in sight first.
    fn thumbnails(&self, engine: &Engine, order: &Order, cancel: &Cancel) -> Result<(), Stopped> {
        let graph = &order.graph;
        let all: Vec<NodeId> = graph.nodes().collect();
        let keys = engine.keys(graph, &all);
        self.tell(|board| board.keep(&keys));
        let Some(grid) = preview(graph.terrain(), THUMBNAIL) else { return Ok(()) };
        let hidden = all.iter().filter(|id| !order.in_sight.contains(id));
        for &id in order.in_sight.iter().chain(hidden) {
            if cancel.is_cancelled() {
                return Err(Stopped);
            }
            let Some(key) = keys.get(&id) else { continue };
            if !lock(&self.board).lacks(id, *key) {
                continue;
            }
            self.thumbnail(engine, graph, id, *key, grid, cancel)?;
        }
        Ok(())
    }

    fn thumbnail(
        &self,
        engine: &Engine,
        graph: &Graph,
        id: NodeId,
        key: crate::engine::Key,
        grid: Grid,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let Some(port) = graph.get(id).and_then(|n| n.kind()?.outputs.first()) else { return Ok(()) };
        let want = [Want { node: id, port: port.name, grid }];
        let plan = engine.plan(graph, &want);
        if plan.seconds() > THUMBNAIL_SECONDS || engine.admit(&plan).is_err() {
            return Ok(());
        }
        let tell = |node, state| self.tell(|board| board.node(node, state));
        let watch = Watcher::new(graph, &tell);
        match engine.evaluate(graph, &want, &watch, cancel) {
            Err(EngineError::Cancelled) => return Err(Stopped),
            Err(_) => (),
            Ok(evaluation) => {
                for value in evaluation.values {
                    match value {
                        Ok(value) => {
                            let picture = crate::render::thumbnail(&value, THUMBNAIL as usize, cancel);
                            let range = value_range(&value);
                            let picture = picture.map_err(|_| Stopped)?;
                            self.tell(|board| board.thumbnail(id, Seen { key, picture, range }));
                        }
                        Err(failure) => {
                            // The failure belongs to the node that failed, not to those downstream of it.
                            let at = failure.node().and_then(|name| graph.find(name));
                            let at = at.unwrap_or(id);
                            self.tell(|board| board.node(at, NodeState::Failed(failure.to_string())));
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The heights of a value that can be lit.
fn field_to_light(value: &Value) -> Option<Field> {
    match value {
        Value::Field(f) if f.quantity() == Quantity::Elevation && f.grid().cols > 1 && f.grid().rows > 1 => {
            Some(f.clone())
        }
        _ => None,
    }
}

fn value_range(value: &Value) -> Option<(f32, f32)> {
    match value {
        Value::Field(field) => field.range(),
        _ => None,
    }
}

/// The work was given up.
struct Stopped;
