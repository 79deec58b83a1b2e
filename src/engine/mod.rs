//! The evaluation of graphs: plans what has to run, runs it within budgets, and caches the results.
//!
//! A graph is first made a *program* (`program`): the part upstream of the wanted values, parsed, each node with its
//! key. The *plan* ([`Plan`]) walks the program from the consumers up and states for each node the windows that are
//! needed, and on which lattice; it does not go beyond results that the cache has. Global nodes run on the base grid,
//! and their results or changes are brought to the grid of the consumer (`lift`). The *runner* (`run`) starts tasks
//! (`stage`) side by side, as far as the account of memory allows. The cache holds results by key and window, in memory
//! and in a folder from which later processes start.

mod account;
mod budget;
mod cache;
mod disk;
mod error;
mod evaluate;
mod files;
mod foretell;
mod key;
mod lift;
mod memory;
mod mix;
mod observer;
mod options;
mod outputs;
mod plan;
mod planner;
mod prepared;
mod program;
mod reading;
mod run;
mod sources;
mod stage;
mod walk;

use std::path::PathBuf;
use std::sync::Arc;

pub use disk::DEFAULT_LIMIT as DEFAULT_CACHE_BYTES;
pub use error::{Cause, EngineError, Failure, SharedFailure, bytes};
pub use evaluate::{Evaluation, Want};
pub use files::{Files, kept_folders, on_this_system};
pub use key::Key;
pub use lift::lift;
pub use memory::{default_budget, process_peak, process_seconds};
pub use observer::{Observer, TaskReport, Unobserved};
pub use options::{DEFAULT_SECONDS, Keep, Options};
pub use plan::{Plan, PlannedTask, Stage};

use cache::{Stock, Store};
use prepared::Prepared;
use program::Program;
use sources::Sources;

use crate::graph::{Graph, NodeId, Source};
use crate::node::Cancel;

/// An evaluator of graphs, with its threads and its caches.
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
    /// Fails when the threads cannot be started or the folder cannot be opened.
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

    /// The pool of threads on which nodes run, for other work on the results.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }

    /// Bytes of results and decoded files held in memory.
    pub fn cached_bytes(&self) -> u64 {
        self.store.bytes() + self.files.shelf().bytes()
    }

    /// Bytes of the memory budget that are not for evaluations.
    pub fn reserve(&self) -> u64 {
        self.reserve
    }

    /// The plan of an evaluation. No content of a file is read: results that depend on a file whose content is not
    /// known count as not cached, until [`know`](Self::know) has read the files.
    pub fn plan(&self, graph: &Graph, wants: &[Want]) -> Plan {
        let plan = self.plan_until(graph, wants, &Cancel::default());
        plan.unwrap_or_else(|_| unreachable!("nobody holds the signal"))
    }

    /// The plan of an evaluation, as [`plan`](Self::plan) gives it, unless it is cancelled. A plan of a large graph
    /// takes a while.
    ///
    /// # Errors
    /// Fails when the work is cancelled.
    pub fn plan_until(&self, graph: &Graph, wants: &[Want], cancel: &Cancel) -> Result<Plan, EngineError> {
        self.plan_of(graph, wants, (self.files.sources(), Stock::All), cancel)
    }

    /// The program of some nodes: a part of one that was made of the same graph, where there is one, else a new one that
    /// takes over the nodes that earlier programs prepared.
    fn program(
        &self,
        graph: &Graph,
        nodes: &[NodeId],
        sources: Arc<Sources>,
        cancel: &Cancel,
    ) -> Result<Arc<Program>, EngineError> {
        let earlier = self.prepared.programs();
        if let Some(part) = earlier.iter().find_map(|program| program.part(graph, nodes, &sources)) {
            return Ok(part);
        }
        let program = Program::new(graph, nodes, sources, &earlier, cancel);
        let program = Arc::new(program.ok_or(EngineError::Cancelled)?);
        self.prepared.keep(&program);
        Ok(program)
    }

    /// The plan of wants, with the files and the caches that it may use.
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

    /// The key of the results of a node, which does not depend on the grid. `None` where the node has a fault or the
    /// content of a file upstream is not known.
    pub fn key(&self, graph: &Graph, node: NodeId) -> Option<Key> {
        let program = self.program(graph, &[node], self.files.sources(), &Cancel::default()).ok()?;
        let step = program.steps.get(program.find(node)?)?;
        step.as_ref().ok().and_then(|s| s.key)
    }
}

/// Why a want has no output.
fn absent(graph: &Graph, want: &Want) -> String {
    match graph.get(want.node) {
        None => "a wanted node is not in the graph".to_owned(),
        Some(node) => format!("node `{}` is bypassed and has nothing to pass on", node.name),
    }
}
