//! Evaluates graphs: plans what has to run, runs it within a budget, keeps the results.
//!
//! A graph is first made a *program* (`program`): the part upstream of the wanted values, parsed, each node with its
//! key. The *plan* ([`Plan`]) walks it from the consumers up and states for each node the windows that are needed,
//! on which lattice; what the cache holds ends the walk. Global nodes run on the base grid and their results, or
//! changes, are carried to the consumer's grid (`lift`). The *runner* (`run`) starts what is ready, side by side,
//! as long as the account of memory allows. The cache holds results in memory by key and window, and in a folder
//! that later processes start warm from.

mod account;
mod cache;
mod disk;
mod error;
mod files;
mod foretell;
mod key;
mod lift;
mod memory;
mod mix;
mod outputs;
mod plan;
mod planner;
mod prepared;
mod program;
mod run;
mod sources;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

pub use disk::DEFAULT_LIMIT as DEFAULT_CACHE_BYTES;
pub use error::{Cause, EngineError, Failure, SharedFailure, bytes};
pub use files::{Files, kept_folders, on_this_system};
pub use key::Key;
pub use lift::lift;
pub use memory::{default_budget, process_peak, process_seconds};
pub use plan::{Plan, PlannedTask, Stage};
pub use run::{Observer, TaskReport, Unobserved};

use cache::{Given, Stock, Store};
use prepared::Prepared;
use program::Program;
use sources::Sources;

use crate::graph::{Graph, NodeId, Source};
use crate::name::Name;
use crate::node::{Cancel, Error, SourceFile};
use crate::source::SourceError;
use crate::value::{Grid, Value};
use crate::work::Work;

/// Seconds an evaluation may be estimated to take unless the user says otherwise: a day.
pub const DEFAULT_SECONDS: f64 = 86_400.0;

/// The share of what is alive that the allocator holds beside it: freed blocks that it has not given back, and gaps. The
/// builds of docs/budgets.md take up to an eleventh.
const HELD_BACK: u64 = 10;

/// What an engine may use.
#[derive(Clone, Debug)]
pub struct Options {
    /// Worker threads; 0 for one per processor.
    pub threads: usize,
    /// Bytes of memory.
    pub memory: u64,
    /// Bytes of them that are not for evaluations: the program itself, and what it does with the values.
    pub reserve: u64,
    /// Estimated seconds of one evaluation.
    pub seconds: f64,
    /// What stays in memory for the next evaluation.
    pub keep: Keep,
    /// Folder of results that outlive the process.
    pub cache: Option<PathBuf>,
    /// Bytes that folder may hold.
    pub cache_bytes: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            threads: 0,
            memory: default_budget(),
            reserve: 0,
            seconds: DEFAULT_SECONDS,
            keep: Keep::Everything,
            cache: None,
            cache_bytes: DEFAULT_CACHE_BYTES,
        }
    }
}

/// What stays in memory for the next evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// As much as the budget leaves: for who changes a graph and asks again.
    Everything,
    /// What every tile of a graph reads, results on the base grid: for who asks for one tile after the other. It is part
    /// of the plan.
    Lasting,
    /// Nothing: for who asks once.
    Nothing,
}

/// A value that somebody wants.
#[derive(Clone, Debug, PartialEq)]
pub struct Want {
    /// The node.
    pub node: NodeId,
    /// Its output.
    pub port: Name,
    /// The grid.
    pub grid: Grid,
}

impl Want {
    /// The output that is wanted.
    pub fn source(&self) -> Source {
        Source { node: self.node, port: self.port.clone() }
    }
}

/// What an evaluation gave.
#[derive(Debug)]
pub struct Evaluation {
    /// For each want its value, or why there is none.
    pub values: Vec<Result<Value, SharedFailure>>,
    /// What ran, in order.
    pub tasks: Vec<TaskReport>,
    /// Most bytes alive at once, by account.
    pub peak_bytes: u64,
    /// The estimate it was admitted with.
    pub planned_bytes: u64,
    /// Estimated seconds on one core.
    pub planned_seconds: f64,
    /// For each want the spacing of the finest detail its value can hold, in metres; `None` where there is no value.
    pub effective_cells: Vec<Option<f64>>,
    /// What the engine itself has to say, each once: that the cache folder cannot keep results.
    pub notices: Vec<String>,
}

/// How often an evaluation begins anew because a file of the cache folder could not be used, before it looks for none.
const MOST_LOST: u32 = 3;

/// Evaluates graphs and keeps what it computed.
#[derive(Debug)]
pub struct Engine {
    pool: rayon::ThreadPool,
    store: Store,
    files: Files,
    memory: u64,
    reserve: u64,
    seconds: f64,
    keep: Keep,
    prepared: Prepared,
}

impl Engine {
    /// Starts the threads and opens the cache folder.
    ///
    /// # Errors
    /// When either is not possible.
    pub fn new(options: &Options, files: Files) -> Result<Self, EngineError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build();
        let pool = pool.map_err(|e| EngineError::Threads(e.to_string()))?;
        let open = |folder: &PathBuf| disk::Disk::open(folder, options.cache_bytes);
        let disk =
            options.cache.as_ref().map(open).transpose().map_err(|e| EngineError::Cache(e.to_string()))?;
        let (memory, reserve, seconds) = (options.memory, options.reserve, options.seconds);
        let store = Store::new(memory.saturating_sub(reserve), disk);
        let (keep, prepared) = (options.keep, Prepared::default());
        Ok(Self { pool, store, files, memory, reserve, seconds, keep, prepared })
    }

    /// The pool on which nodes run, for work that goes with an evaluation.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }

    /// Bytes of results and decoded files held in memory.
    pub fn cached_bytes(&self) -> u64 {
        self.store.bytes() + self.files.shelf().bytes()
    }

    /// Bytes that are set aside for all but the evaluation.
    pub fn reserve(&self) -> u64 {
        self.reserve
    }

    /// States what an evaluation would run. No content of a file is read: where it is not known, the plan counts
    /// nothing as cached that depends on it, and [`know`](Self::know) makes it one that does.
    pub fn plan(&self, graph: &Graph, wants: &[Want]) -> Plan {
        let plan = self.plan_until(graph, wants, &Cancel::default());
        plan.unwrap_or_else(|_| unreachable!("nobody holds the signal"))
    }

    /// The same, unless it is cancelled: of a graph of many nodes a plan takes a while.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn plan_until(&self, graph: &Graph, wants: &[Want], cancel: &Cancel) -> Result<Plan, EngineError> {
        self.plan_of(graph, wants, (self.files.sources(), Stock::All), cancel)
    }

    /// The program of some nodes, which takes over what earlier ones made ready.
    fn program(
        &self,
        graph: &Graph,
        nodes: &[NodeId],
        sources: Arc<Sources>,
        cancel: &Cancel,
    ) -> Result<Arc<Program>, EngineError> {
        let program = Program::new(graph, nodes, sources, &self.prepared, cancel);
        let program = program.ok_or(EngineError::Cancelled)?;
        self.prepared.keep(graph, &program);
        Ok(Arc::new(program))
    }

    fn plan_of(
        &self,
        graph: &Graph,
        wants: &[Want],
        (sources, stock): (Arc<Sources>, Stock),
        cancel: &Cancel,
    ) -> Result<Plan, EngineError> {
        let passed: Vec<_> = wants.iter().map(|w| graph.passed(w.source())).collect();
        let nodes: Vec<NodeId> = passed.iter().flatten().map(|s| s.node).collect();
        let program = self.program(graph, &nodes, sources, cancel)?;
        let find = |(want, passed): (&Want, &Option<Source>)| {
            let step = passed.as_ref().and_then(|s| Some((program.find(s.node)?, s.port.clone(), want.grid)));
            step.ok_or_else(|| Arc::new(Failure::Graph(absent(graph, want))))
        };
        let wants: Vec<_> = wants.iter().zip(&passed).map(find).collect();
        let plan = Plan::new(program, &wants, (&self.store, stock), self.keep == Keep::Lasting, cancel);
        plan.ok_or(EngineError::Cancelled)
    }

    /// Makes a plan one that knows the content of all files: reads those that are not known, after the plan was held
    /// against the budgets. What cannot be read fails in the plan.
    ///
    /// # Errors
    /// When reading them is over a budget, or the work is cancelled; the plan is then as it was.
    pub fn know(
        &self,
        graph: &Graph,
        wants: &[Want],
        plan: &mut Plan,
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<(), EngineError> {
        let unread = plan.unread();
        if unread.is_empty() {
            return Ok(());
        }
        self.admit_reading(plan)?;
        learn(&unread, observer, cancel)?;
        *plan = self.plan_of(graph, wants, (plan.program.sources.clone(), Stock::All), cancel)?;
        Ok(())
    }

    /// Refuses to read files for a plan that is over a budget. A cache folder may hold what the plan counts: then only
    /// the files themselves are counted.
    fn admit_reading(&self, plan: &Plan) -> Result<(), EngineError> {
        if self.store.disk.is_none() {
            return self.admit(plan);
        }
        let (bytes, node) = plan.largest_reading();
        self.admit_bytes(bytes, || format!("node `{node}`"))?;
        self.admit_seconds(plan.unread_seconds())
    }

    /// The key of a node's results, whatever the grid; `None` when the node has a fault, or the content of a file
    /// before it is not known.
    pub fn key(&self, graph: &Graph, node: NodeId) -> Option<Key> {
        let program = self.program(graph, &[node], self.files.sources(), &Cancel::default()).ok()?;
        let step = program.steps.get(program.find(node)?)?;
        step.as_ref().ok().and_then(|s| s.key)
    }

    /// The keys of the results of some nodes; those that have a fault are left out. Files are read to know their
    /// content as long as they have no more bytes together than `most`; what hangs on the others is left out, too.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn keys(
        &self,
        graph: &Graph,
        nodes: &[NodeId],
        most: u64,
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<BTreeMap<NodeId, Key>, EngineError> {
        let sources = self.files.sources();
        let made = || self.program(graph, nodes, sources.clone(), cancel);
        let mut program = made()?;
        let steps = program.steps.iter().flatten();
        let unread: Vec<_> = steps.flat_map(|s| s.unread().map(|f| (s.name(), f))).collect();
        let bytes = unread.iter().fold(0, |sum: u64, (_, f)| sum.saturating_add(f.len()));
        if !unread.is_empty() && bytes <= most {
            learn(&unread, observer, cancel)?;
            program = made()?;
        }
        let key = |id: &NodeId| {
            let step = program.steps.get(program.find(*id)?)?;
            Some((*id, step.as_ref().ok()?.key?))
        };
        Ok(nodes.iter().filter_map(key).collect())
    }

    /// Refuses a plan that is over a budget.
    ///
    /// # Errors
    /// Names the budget, the estimate and where its peak is.
    pub fn admit(&self, plan: &Plan) -> Result<(), EngineError> {
        self.admit_bytes(plan.peak_bytes(), || plan.peak_node())?;
        // Tasks share the threads; a file is hashed by one.
        self.admit_seconds(
            plan.run_seconds() / self.pool.current_num_threads() as f64 + plan.unread_seconds(),
        )
    }

    fn admit_bytes(&self, bytes: u64, at: impl FnOnce() -> String) -> Result<(), EngineError> {
        let (need, reserve, budget) = (self.need(bytes), self.reserve, self.memory);
        if need > budget {
            return Err(EngineError::Memory { need, reserve, budget, at: at() });
        }
        Ok(())
    }

    /// Bytes the whole process takes with so many in an evaluation: what the budget must hold.
    pub fn need(&self, bytes: u64) -> u64 {
        bytes.saturating_add(bytes / HELD_BACK).saturating_add(self.reserve)
    }

    fn admit_seconds(&self, need: f64) -> Result<(), EngineError> {
        let budget = self.seconds;
        // A budget that is no number allows nothing.
        if need <= budget { Ok(()) } else { Err(EngineError::Time { need, budget }) }
    }

    /// Evaluates what is wanted. A failure stops only what needs the failed node.
    ///
    /// # Errors
    /// When the plan is over a budget or the work is cancelled.
    pub fn evaluate(
        &self,
        graph: &Graph,
        wants: &[Want],
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<Evaluation, EngineError> {
        let mut plan = self.plan_until(graph, wants, cancel)?;
        self.know(graph, wants, &mut plan, observer, cancel)?;
        let guessed = plan.guessed();
        if guessed.is_empty() {
            return self.evaluate_plan(graph, wants, plan, self.keep, observer, cancel);
        }
        // What others cost hangs on the values of these: they run first, and the next plan finds their results.
        self.admit(&plan)?;
        let sources = plan.program.sources.clone();
        let first = self.plan_of(graph, &guessed, (sources.clone(), Stock::All), cancel)?;
        let first = self.evaluate_plan(graph, &guessed, first, Keep::Everything, observer, cancel)?;
        let plan = self.plan_of(graph, wants, (sources, Stock::All), cancel)?;
        let mut evaluation = self.evaluate_plan(graph, wants, plan, self.keep, observer, cancel)?;
        for task in first.tasks {
            let same = |t: &&mut TaskReport| (&t.node, t.stage) == (&task.node, task.stage);
            if let Some(again) = evaluation.tasks.iter_mut().find(same).filter(|t| t.cached.is_some()) {
                *again = task;
            }
        }
        Ok(evaluation)
    }

    /// Evaluates a plan in which the content of all files is known.
    fn evaluate_plan(
        &self,
        graph: &Graph,
        wants: &[Want],
        mut plan: Plan,
        keep: Keep,
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<Evaluation, EngineError> {
        let mut lost = 0;
        loop {
            self.admit(&plan)?;
            observer.planned(&plan);
            let spare = self.memory - self.need(plan.peak_bytes());
            // Who asks again and again gains by all of it, and nobody knows by which most: results and decoded files that
            // are still there, and tasks that run ahead. Who asks for tiles is told before what a build takes, and gets
            // no more.
            let (results, files, ahead) = match keep {
                Keep::Everything => (spare / 4, spare / 4, spare / 2),
                Keep::Lasting => (plan.lasting_bytes(), plan.shelf_bytes(), 0),
                Keep::Nothing => (0, 0, 0),
            };
            self.files.shelf().limit(files);
            self.store.limit(results);
            let held = plan.take_held();
            let limit = plan.peak.bytes + ahead;
            let (store, pool) = (&self.store, &self.pool);
            let ran = run::Runner { plan: &plan, held, store, keep, pool, observer, cancel, limit }.run();
            if cancel.is_cancelled() {
                return Err(EngineError::Cancelled);
            }
            // The file that could not be used is not found again: the next plan computes what it should have held.
            if ran.lost {
                lost += 1;
                // Other processes may remove what a plan has found as quickly as it finds it.
                let stock = if lost >= MOST_LOST { Stock::Memory } else { Stock::All };
                plan = self.plan_of(graph, wants, (plan.program.sources.clone(), stock), cancel)?;
                continue;
            }
            let values = wants.iter().zip(ran.wanted);
            let values = values.map(|(want, given)| cut(graph.passed(want.source()), &want.grid, &*given?));
            let values = values.collect();
            return Ok(Evaluation {
                values,
                tasks: ran.reports,
                peak_bytes: ran.peak_bytes,
                planned_bytes: plan.peak_bytes(),
                planned_seconds: plan.seconds(),
                effective_cells: (0..wants.len()).map(|i| plan.effective_cell(i)).collect(),
                notices: self.store.disk.as_ref().and_then(disk::Disk::complaint).into_iter().collect(),
            });
        }
    }
}

/// Reads files to know what they hold. What is wrong with one of them its hash says from then on.
fn learn(
    unread: &[(&str, &Arc<SourceFile>)],
    observer: &dyn Observer,
    cancel: &Cancel,
) -> Result<(), EngineError> {
    for (node, file) in unread {
        let last = AtomicU32::new(0);
        let progress = |share: f32| {
            let now = (share * 100.0) as u32;
            if last.fetch_max(now, Ordering::Relaxed) < now {
                observer.reading(node, file.name(), share);
            }
        };
        if file.hash(&Work::new(cancel).telling(&progress)) == Err(SourceError::Cancelled) {
            return Err(EngineError::Cancelled);
        }
    }
    Ok(())
}

/// Why nothing stands for a want.
fn absent(graph: &Graph, want: &Want) -> String {
    match graph.get(want.node) {
        None => "a wanted node is not in the graph".to_owned(),
        Some(node) => format!("node `{}` is bypassed and has nothing to pass on", node.name),
    }
}

/// The wanted window of what a task gave.
fn cut(source: Option<Source>, grid: &Grid, given: &Given) -> Result<Value, SharedFailure> {
    let port = source.map(|s| s.port).unwrap_or_default();
    let value = given.wires().and_then(|w| w.get(&port));
    let missing = || {
        let error = Error::Output { port, message: "was not given".into() };
        Arc::new(Failure::Engine(error.to_string()))
    };
    value.map(|v| v.crop(grid)).ok_or_else(missing)
}
