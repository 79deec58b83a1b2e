//! Evaluations: what is wanted, how it is run, and what comes of it.

use std::sync::Arc;

use super::cache::{Given, Stock};
use super::error::{EngineError, Failure, SharedFailure};
use super::observer::{Observer, TaskReport};
use super::options::Keep;
use super::plan::Plan;
use super::run::Runner;
use super::{Engine, disk};
use crate::graph::{Graph, NodeId, Source};
use crate::name::Name;
use crate::node::{Cancel, Error};
use crate::value::{Grid, Value};

/// A value that an evaluation is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Want {
    /// The node.
    pub node: NodeId,
    /// The output port of the node.
    pub port: Name,
    /// The grid of the value.
    pub grid: Grid,
}

impl Want {
    /// The wanted output.
    pub fn source(&self) -> Source {
        Source { node: self.node, port: self.port.clone() }
    }
}

/// The results of an evaluation.
#[derive(Debug)]
pub struct Evaluation {
    /// For each want, its value or the failure.
    pub values: Vec<Result<Value, SharedFailure>>,
    /// The reports of the tasks, in the order of the plan.
    pub tasks: Vec<TaskReport>,
    /// The most bytes that were alive at once, by account.
    pub peak_bytes: u64,
    /// The estimated peak with which the evaluation was admitted, in bytes.
    pub planned_bytes: u64,
    /// Estimated seconds on one core.
    pub planned_seconds: f64,
    /// For each want, the spacing of the finest detail that its value can hold, in metres; `None` where there is no
    /// value.
    pub effective_cells: Vec<Option<f64>>,
    /// Notices of the engine for the user, each given once, such as that the cache folder cannot store results.
    pub notices: Vec<String>,
}

/// Number of lost files of the cache folder after which an evaluation starts again without the folder.
const MOST_LOST: u32 = 3;

impl Engine {
    /// Evaluates the wanted values. A failure stops only the values that need the failed node.
    ///
    /// # Errors
    /// Fails when the plan is over a budget or the work is cancelled.
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
        // The cost of other tasks depends on these values. They run first, and the next plan finds their results.
        self.admit(&plan)?;
        let sources = plan.program.sources.clone();
        let first = self.plan_of(graph, &guessed, (sources.clone(), Stock::All), cancel)?;
        let first = self.evaluate_plan(graph, &guessed, first, Keep::Everything, observer, cancel)?;
        let plan = self.plan_of(graph, wants, (sources, Stock::All), cancel)?;
        let mut evaluation = self.evaluate_plan(graph, wants, plan, self.keep, observer, cancel)?;
        evaluation.peak_bytes = evaluation.peak_bytes.max(first.peak_bytes);
        evaluation.planned_bytes = evaluation.planned_bytes.max(first.planned_bytes);
        for task in first.tasks {
            let same = |t: &&mut TaskReport| (&t.node, t.stage) == (&task.node, task.stage);
            if let Some(again) = evaluation.tasks.iter_mut().find(same).filter(|t| t.cached.is_some()) {
                *again = task;
            }
        }
        Ok(evaluation)
    }

    /// Evaluates a plan that knows the content of all files.
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
            // Repeated evaluations gain by cached results, by decoded files and by tasks that run ahead; which of them
            // gains most is not known, so that each has a share of the spare memory. The memory of builds in tiles is
            // stated beforehand, so that they get no more than the plan says.
            let (results, files, ahead) = match keep {
                // Results that were guessed have to stay for the plan that knows them.
                Keep::Everything => ((spare / 4).max(plan.lasting_bytes()), spare / 4, spare / 2),
                Keep::Lasting => (plan.lasting_bytes(), plan.shelf_bytes(), 0),
                Keep::Nothing => (0, 0, 0),
            };
            self.files.shelf().limit(files);
            self.store.limit(results);
            let held = plan.take_held();
            let limit = plan.peak.bytes + ahead;
            let (store, pool) = (&self.store, &self.pool);
            let ran = Runner { plan: &plan, held, store, keep, pool, observer, cancel, limit }.run();
            if cancel.is_cancelled() {
                return Err(EngineError::Cancelled);
            }
            // The file that could not be used is not found again, so that the next plan computes its result.
            if ran.is_cache_lost {
                lost += 1;
                // Other processes may remove files as quickly as plans find them.
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

/// The wanted window of the result of a task.
fn cut(source: Option<Source>, grid: &Grid, given: &Given) -> Result<Value, SharedFailure> {
    let port = source.map(|s| s.port).unwrap_or_default();
    let value = given.wires().and_then(|w| w.get(&port));
    let missing = || {
        let error = Error::Output { port, message: "was not given".into() };
        Arc::new(Failure::Engine(error.to_string()))
    };
    value.map(|v| v.crop(grid)).ok_or_else(missing)
}
