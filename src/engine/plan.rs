//! The plan of an evaluation: which nodes run, on which grids, at what cost, and which results the cache has.
//!
//! Windows are collected from the consumers up. Each node collects the windows that its consumers need, one for each
//! lattice, before it asks its own sources, so that no task runs twice. Cached results need no sources.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::account::{self, Peak};
use super::cache::{Found, Given, Stock, Store, Warnings};
use super::error::SharedFailure;
use super::foretell::is_input;
use super::key::Key;
use super::outputs::Outputs;
use super::planner::Planner;
use super::program::{Program, Step};
use crate::name::Name;
use crate::node::{Cancel, Cost, Reach, SECONDS_PER_BYTE, SourceFile};
use crate::value::{Grid, Quantity};

/// What a task does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Runs a gridless node.
    Gridless,
    /// Computes the summary of the whole terrain on the base grid.
    Summary,
    /// Runs a global node on the base grid.
    Base,
    /// Brings the result of a global node to the grid of its consumer.
    Lift,
    /// Runs a point or local node.
    Run,
}

impl Stage {
    /// The name used in plans and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gridless => "gridless",
            Self::Summary => "summary",
            Self::Base => "base",
            Self::Lift => "lift",
            Self::Run => "run",
        }
    }
}

/// The role of a dependency of a task. Inputs are given by their index among those of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// An input of the kind.
    Input(usize),
    /// An input of the kind on one of its further windows, in the order of their list.
    View(usize),
    /// The summary of the whole terrain.
    Summary,
    /// The result of a global node on the base grid.
    Base,
    /// An input of a global node on the base grid, from which its change is measured.
    Before(usize),
    /// An input on the grid of the output, which the result is mixed with or carried onto.
    Fine(usize),
}

/// One stage of one step on one grid.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub step: usize,
    pub stage: Stage,
    pub grid: Grid,
    /// The key of the result; `None` while the content of a file upstream is not known.
    pub key: Option<Key>,
    pub cost: Cost,
    /// The outputs that are read.
    pub read: Outputs,
    /// Bytes of the outputs that are read.
    pub output_bytes: u64,
    /// The part of the bytes of the cost that is for files.
    pub file_bytes: u64,
    pub found: Option<Found>,
    pub needs: Vec<(Role, usize)>,
    /// Whether the task is gridless and its result is not known before it runs.
    pub guessed: bool,
    /// Whether the result stays for the next evaluation, which will read it.
    pub lasting: bool,
}

impl Task {
    /// The grid of the task; `None` for a gridless node.
    pub(super) fn grid(&self) -> Option<Grid> {
        (self.stage != Stage::Gridless).then_some(self.grid)
    }

    /// Bytes that the task adds while it runs; results that stay are counted from the start.
    pub(super) fn bytes(&self) -> u64 {
        let output = if self.held() || self.lasting { 0 } else { self.output_bytes };
        output.saturating_add(self.scratch_bytes())
    }

    /// Bytes that the task adds and releases when it is done.
    pub(super) fn scratch_bytes(&self) -> u64 {
        if self.held() { 0 } else { self.cost.bytes }
    }

    /// Bytes that are released after the last read of the result.
    pub(super) fn released_bytes(&self) -> u64 {
        if self.lasting { 0 } else { self.output_bytes }
    }

    /// Whether the result is in memory before the evaluation.
    pub(super) fn held(&self) -> bool {
        matches!(self.found, Some(Found::Memory(..)))
    }
}

/// An output of a step on a grid.
pub(super) type Target = (usize, Name, Grid);

/// A wanted value: the index of its task, or why it cannot be made.
pub(super) type Wanted = Result<usize, SharedFailure>;

/// The tasks of an evaluation before it runs.
#[derive(Debug)]
pub struct Plan {
    pub(super) program: Arc<Program>,
    pub(super) tasks: Vec<Task>,
    pub(super) wanted: Vec<Wanted>,
    /// The quantity of each wanted value.
    quantities: Vec<Option<Quantity>>,
    pub(super) peak: Peak,
    /// Bytes decoded from files that stay for the next evaluation.
    shelf_bytes: u64,
}

/// A task of a plan, for display.
#[derive(Clone, Debug)]
pub struct PlannedTask {
    /// Name of the node.
    pub node: String,
    /// Kind of the node.
    pub kind: Name,
    /// What the task does.
    pub stage: Stage,
    /// The grid of the task; `None` for a gridless node.
    pub grid: Option<Grid>,
    /// Spacing of the finest detail that the result can hold, in metres.
    pub effective_cell: f64,
    /// Where the cache has the result, `memory` or `disk`; `None` where it will be computed.
    pub cached: Option<&'static str>,
    /// Bytes of the outputs that are read.
    pub output_bytes: u64,
    /// Estimated cost.
    pub cost: Cost,
}

impl Plan {
    /// The plan for outputs of steps on grids; with `lasting`, results that further evaluations will read stay. `None`
    /// when the work is cancelled.
    pub(super) fn new(
        program: Arc<Program>,
        wants: &[Result<Target, SharedFailure>],
        (store, stock): (&Store, Stock),
        lasting: bool,
        cancel: &Cancel,
    ) -> Option<Self> {
        let (mut tasks, wanted, cut_bytes) = Planner::new(&program, store, stock).plan(wants, cancel)?;
        let shelf_bytes = if lasting { account::mark_lasting(&mut tasks) } else { 0 };
        account::mark_guessed(&mut tasks);
        let peak = account::peak(&tasks, &wanted, shelf_bytes, cut_bytes);
        let quantity = |want: &Result<Target, _>| {
            let (step, from, _) = want.as_ref().ok()?;
            program.steps[*step].as_ref().ok()?.quantity(from)
        };
        let quantities = wants.iter().map(quantity).collect();
        Some(Self { program, tasks, wanted, quantities, peak, shelf_bytes })
    }

    /// The estimated peak of memory when tasks run in order, in bytes; files count in the tasks that read them.
    pub fn peak_bytes(&self) -> u64 {
        self.peak.bytes
    }

    /// The files whose content is not known yet, each with the name of its node. Results that depend on them are not
    /// found in the cache.
    pub(super) fn unread(&self) -> Vec<(&str, &Arc<SourceFile>)> {
        let mut seen = BTreeSet::new();
        let steps = self.program.steps.iter().flatten();
        let files = steps.flat_map(|s| s.unread().map(|f| (s.name(), f)));
        files.filter(|(_, f)| seen.insert(f.name())).collect()
    }

    /// Bytes of files whose content is not known yet.
    pub fn unread_bytes(&self) -> u64 {
        self.unread().iter().fold(0, |sum, (_, f)| sum.saturating_add(f.len()))
    }

    /// Estimated seconds to read the files whose content is not known yet, on one thread.
    pub fn unread_seconds(&self) -> f64 {
        self.unread_bytes() as f64 * SECONDS_PER_BYTE
    }

    /// The most bytes that a node takes for its files alone, with the name of the node.
    pub(super) fn largest_reading(&self) -> (u64, &str) {
        let steps = self.program.steps.iter().flatten();
        steps.map(|s| (s.reading().bytes, s.name())).max().unwrap_or_default()
    }

    /// For each wanted value, the failure that is known before any task runs.
    pub fn failures(&self) -> Vec<Option<SharedFailure>> {
        self.wanted.iter().map(|w| w.as_ref().err().cloned()).collect()
    }

    /// The gridless values that are not known yet and on which the costs of other tasks depend, as wants.
    pub(super) fn guessed(&self) -> Vec<super::Want> {
        let read = self.tasks.iter().filter(|t| t.stage != Stage::Gridless && t.found.is_none());
        let inputs =
            read.flat_map(|t| t.needs.iter().filter(|(role, _)| is_input(role)).map(|(_, need)| *need));
        let guessed: BTreeSet<usize> = inputs.filter(|i| self.tasks[*i].guessed).collect();
        let want = |i: usize| {
            let task = &self.tasks[i];
            let port = self.step(task).kind.outputs.first()?.name.clone();
            Some(super::Want { node: self.program.node(task.step)?, port, grid: task.grid })
        };
        guessed.into_iter().filter_map(want).collect()
    }

    /// Bytes that count as alive before any task runs.
    pub(super) fn standing_bytes(&self) -> u64 {
        account::standing_bytes(&self.tasks).saturating_add(self.shelf_bytes)
    }

    /// Bytes decoded from files that stay for the next evaluation.
    pub(super) fn shelf_bytes(&self) -> u64 {
        self.shelf_bytes
    }

    /// Bytes of results that stay for the next evaluation.
    pub(super) fn lasting_bytes(&self) -> u64 {
        account::lasting_bytes(&self.tasks)
    }

    /// For each task, how often its result is read.
    pub(super) fn uses(&self) -> Vec<usize> {
        account::uses(&self.tasks, &self.wanted)
    }

    /// Takes the results that were in memory out of the plan, so that each is dropped after its last read.
    pub(super) fn take_held(&mut self) -> Vec<Option<(Given, Warnings)>> {
        self.tasks.iter_mut().map(|t| t.found.as_mut().and_then(Found::take)).collect()
    }

    /// For each task, the tasks that read its result, once for each read.
    pub(super) fn consumers(&self) -> Vec<Vec<usize>> {
        let mut consumers = vec![Vec::new(); self.tasks.len()];
        for (i, task) in self.tasks.iter().enumerate() {
            task.needs.iter().for_each(|(_, need)| consumers[*need].push(i));
        }
        consumers
    }

    /// The cell of the base grid, in metres.
    pub fn base_cell(&self) -> f64 {
        self.program.terrain.base_cell()
    }

    /// The nodes with a feature narrower than two cells of the base grid, with its width in metres.
    pub fn too_narrow(&self) -> Vec<(&str, f64)> {
        let base = self.base_cell();
        let steps = self.program.steps.iter().flatten().filter(|s| s.reach == Reach::Global);
        let narrow = steps.filter_map(|s| Some((s.name(), s.node.narrowest()?)));
        narrow.filter(|(_, width)| *width < 2.0 * base).collect()
    }

    /// Estimated seconds on one core, with those for reading files whose content is not known.
    pub fn seconds(&self) -> f64 {
        self.run_seconds() + self.unread_seconds()
    }

    /// Estimated seconds of the tasks alone, on one core.
    pub fn run_seconds(&self) -> f64 {
        self.tasks.iter().filter(|t| !t.held()).map(|t| t.cost.seconds).fold(0.0, |a, b| a + b)
    }

    /// The tasks in the order in which they run on one core.
    pub fn tasks(&self) -> Vec<PlannedTask> {
        let effective = self.effective_cells();
        let one = |(i, t): (usize, &Task)| {
            let step = self.step(t);
            PlannedTask {
                node: step.name().to_owned(),
                kind: step.kind.id.clone(),
                stage: t.stage,
                grid: t.grid(),
                effective_cell: effective[i],
                cached: t.found.as_ref().map(Found::place),
                output_bytes: t.output_bytes,
                cost: t.cost,
            }
        };
        self.tasks.iter().enumerate().map(one).collect()
    }

    /// The spacing of the finest detail that a wanted value can hold, in metres: the cell of its grid, or that of the
    /// base grid where a global node is upstream; 0 for a gridless value. `None` where the value cannot be made.
    pub fn effective_cell(&self, want: usize) -> Option<f64> {
        let task = *self.wanted.get(want)?.as_ref().ok()?;
        Some(self.effective_cells()[task])
    }

    /// The quantity of a wanted value, which is known before any task runs; `None` where it has none or cannot be made.
    pub fn quantity(&self, want: usize) -> Option<Quantity> {
        self.quantities.get(want).copied().flatten()
    }

    fn effective_cells(&self) -> Vec<f64> {
        let base = self.base_cell();
        let mut cells: Vec<f64> = Vec::with_capacity(self.tasks.len());
        for task in &self.tasks {
            let own = match task.stage {
                Stage::Gridless => 0.0,
                Stage::Lift => base.max(task.grid.cell()),
                Stage::Summary | Stage::Base | Stage::Run => task.grid.cell(),
            };
            let inputs = task.needs.iter().filter(|(role, _)| matches!(role, Role::Input(_) | Role::Fine(_)));
            // A cached lift has no inputs here. One that carries a change is as coarse as the base grid at least.
            let carried = task.stage == Stage::Lift && !self.step(task).kind.carries.is_empty();
            let widest = inputs.map(|(_, t)| cells[*t]).fold(own, f64::max);
            cells.push(if carried { widest.max(base) } else { widest });
        }
        cells
    }

    pub(super) fn step(&self, task: &Task) -> &Step {
        match &self.program.steps[task.step] {
            Ok(step) => step,
            Err(_) => unreachable!("no task is made for a step that failed"),
        }
    }

    /// The name of the node at the peak of memory.
    pub(super) fn peak_node(&self) -> String {
        self.tasks.get(self.peak.task).map(|t| format!("node `{}`", self.step(t).name())).unwrap_or_default()
    }
}
