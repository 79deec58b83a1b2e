//! What an evaluation will run: which node, on which grid, at what cost, and what the cache has already.
//!
//! Windows are asked for from the consumers up: each node collects the windows that its consumers need, one per
//! lattice, before it asks its own sources; so nothing runs twice. What the cache holds asks for nothing.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::account::{Peak, cost, held_bytes, output_bytes, peak, uses};
use super::cache::{Found, Stock, Store};
use super::error::SharedFailure;
use super::foretell::{Foretold, is_input};
use super::key::Key;
use super::program::{Program, Step};
use crate::node::{Cost, Reach, SECONDS_PER_BYTE, SourceFile};
use crate::ports::Wires;
use crate::value::Grid;

/// What a task does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Runs a gridless node.
    Gridless,
    /// Computes a statistic of the whole on the base grid.
    Summary,
    /// Runs a global node on the base grid.
    Base,
    /// Carries the result of a global node to the grid of its consumer.
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

/// What a dependency is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// An input of the kind.
    Input { port: &'static str, from: &'static str },
    /// An input of the kind on one of its further windows, in the order of their list.
    View { port: &'static str, from: &'static str },
    /// The statistic of the whole.
    Summary,
    /// A global node's own result on the base grid.
    Base,
    /// An input of a global node on the base grid: what its change is measured against.
    Before { port: &'static str, from: &'static str },
    /// An input on the output grid itself: what the result is mixed with or carried onto.
    Fine { port: &'static str, from: &'static str },
}

/// One piece of work.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub step: usize,
    pub stage: Stage,
    pub grid: Grid,
    /// None while the content of a file upstream is not known.
    pub key: Option<Key>,
    pub cost: Cost,
    pub output_bytes: u64,
    pub found: Option<Found>,
    pub needs: Vec<(Role, usize)>,
    /// It has no grid, and what it gives is not known before it runs.
    pub guessed: bool,
}

impl Task {
    /// The grid it runs on; none for a gridless node.
    pub(super) fn grid(&self) -> Option<Grid> {
        (self.stage != Stage::Gridless).then_some(self.grid)
    }

    /// Bytes it adds while it runs.
    pub(super) fn bytes(&self) -> u64 {
        if self.held() { 0 } else { self.output_bytes.saturating_add(self.scratch_bytes()) }
    }

    /// Bytes it adds and gives back.
    pub(super) fn scratch_bytes(&self) -> u64 {
        if self.found.is_some() { 0 } else { self.cost.bytes }
    }

    /// Whether its result is in memory before it runs.
    pub(super) fn held(&self) -> bool {
        matches!(self.found, Some(Found::Memory(..)))
    }
}

/// A value that is wanted: its task, or why it cannot be made.
pub(super) type Wanted = Result<usize, SharedFailure>;

/// An evaluation before it runs.
#[derive(Debug)]
pub struct Plan {
    pub(super) program: Arc<Program>,
    pub(super) tasks: Vec<Task>,
    pub(super) wanted: Vec<Wanted>,
    pub(super) peak: Peak,
}

/// A task as a person sees it in a plan.
#[derive(Clone, Debug)]
pub struct PlannedTask {
    /// Name of the node.
    pub node: String,
    /// Its kind.
    pub kind: &'static str,
    /// What the task does.
    pub stage: Stage,
    /// The grid it runs on; none for a gridless node.
    pub grid: Option<Grid>,
    /// Spacing of the finest detail its result can hold, in metres.
    pub effective_cell: f64,
    /// Whether the cache has its result: `memory`, `disk`, or not.
    pub cached: Option<&'static str>,
    /// Bytes of its outputs.
    pub output_bytes: u64,
    /// Estimated cost.
    pub cost: Cost,
}

/// A task before its dependencies have numbers.
struct Draft {
    step: usize,
    stage: Stage,
    grid: Grid,
    key: Option<Key>,
    found: Option<Found>,
    asks: Vec<(Role, Ask)>,
}

/// A result that a draft depends on.
#[derive(Clone, Copy)]
enum Ask {
    /// What a step gives its consumers on a grid.
    Result { step: usize, grid: Grid },
    /// Another stage of the same step.
    Own(Stage),
}

struct Planner<'a> {
    program: &'a Program,
    store: &'a Store,
    stock: Stock,
    base: Grid,
    /// Windows asked of each step, one per lattice.
    windows: Vec<Vec<Grid>>,
    drafts: Vec<Draft>,
}

impl Plan {
    pub(super) fn new(
        program: Arc<Program>,
        wants: &[Result<(usize, Grid), SharedFailure>],
        store: &Store,
        stock: Stock,
    ) -> Self {
        let base = program.terrain.base_grid();
        let windows = vec![Vec::new(); program.steps.len()];
        let mut planner = Planner { program: &program, store, stock, base, windows, drafts: Vec::new() };
        for (step, grid) in wants.iter().flatten() {
            planner.ask(*step, *grid);
        }
        for step in (0..program.steps.len()).rev() {
            planner.visit(step);
        }
        let (tasks, results) = planner.number();
        let wanted = wants.iter().map(|w| match w {
            Ok((step, grid)) => match &program.steps[*step] {
                Ok(_) => Ok(results.find(*step, &program.place(*step, *grid))),
                Err(failure) => Err(failure.clone()),
            },
            Err(failure) => Err(failure.clone()),
        });
        let wanted: Vec<Wanted> = wanted.collect();
        let peak = peak(&tasks, &wanted);
        Self { program, tasks, wanted, peak }
    }

    /// Estimated peak of memory when run in order, in bytes; files count in the tasks that read them.
    pub fn peak_bytes(&self) -> u64 {
        self.peak.bytes
    }

    /// The files whose content is not known yet, each with the node that asks for it: until it is, nothing that
    /// depends on them is found in a cache.
    pub(super) fn unread(&self) -> Vec<(&str, &Arc<SourceFile>)> {
        let mut seen = BTreeSet::new();
        let steps = self.program.steps.iter().flatten();
        let files = steps.flat_map(|s| s.unread().map(|f| (s.name.as_str(), f)));
        files.filter(|(_, f)| seen.insert(f.name())).collect()
    }

    /// Bytes of files that must be read once before it is known what they hold.
    pub fn unread_bytes(&self) -> u64 {
        self.unread().iter().fold(0, |sum, (_, f)| sum.saturating_add(f.len()))
    }

    /// Seconds that takes, on one thread.
    pub fn unread_seconds(&self) -> f64 {
        self.unread_bytes() as f64 * SECONDS_PER_BYTE
    }

    /// The most bytes that a node takes for its files alone, with its name.
    pub(super) fn largest_reading(&self) -> (u64, &str) {
        let steps = self.program.steps.iter().flatten();
        steps.map(|s| (s.reading().bytes, s.name.as_str())).max().unwrap_or_default()
    }

    /// Why each wanted value cannot be made, where that is known before anything runs.
    pub fn failures(&self) -> Vec<Option<SharedFailure>> {
        self.wanted.iter().map(|w| w.as_ref().err().cloned()).collect()
    }

    /// Values without a grid that are not known yet though what others cost hangs on them, each wanted where it stands.
    pub(super) fn guessed(&self) -> Vec<super::Want> {
        let read = self.tasks.iter().filter(|t| t.stage != Stage::Gridless && t.found.is_none());
        let inputs =
            read.flat_map(|t| t.needs.iter().filter(|(role, _)| is_input(role)).map(|(_, need)| *need));
        let guessed: BTreeSet<usize> = inputs.filter(|i| self.tasks[*i].guessed).collect();
        let want = |i: usize| {
            let task = &self.tasks[i];
            let port = self.step(task).kind.outputs.first()?.name;
            Some(super::Want { node: self.program.node(task.step)?, port, grid: task.grid })
        };
        guessed.into_iter().filter_map(want).collect()
    }

    /// Bytes of results that are in memory before anything runs.
    pub(super) fn held_bytes(&self) -> u64 {
        held_bytes(&self.tasks)
    }

    /// How often each task's result is read.
    pub(super) fn uses(&self) -> Vec<usize> {
        uses(&self.tasks, &self.wanted)
    }

    /// The tasks that read each task's result, once for each reading.
    pub(super) fn consumers(&self) -> Vec<Vec<usize>> {
        let mut consumers = vec![Vec::new(); self.tasks.len()];
        for (i, task) in self.tasks.iter().enumerate() {
            task.needs.iter().for_each(|(_, need)| consumers[*need].push(i));
        }
        consumers
    }

    /// Distance between samples of the base grid, in metres.
    pub fn base_cell(&self) -> f64 {
        self.program.terrain.base_cell()
    }

    /// Nodes whose narrowest feature the base grid cannot hold: two of its cells are wider.
    pub fn too_narrow(&self) -> Vec<(&str, f64)> {
        let base = self.base_cell();
        let steps = self.program.steps.iter().flatten().filter(|s| s.reach == Reach::Global);
        let narrow = steps.filter_map(|s| Some((s.name.as_str(), s.node.narrowest()?)));
        narrow.filter(|(_, width)| *width < 2.0 * base).collect()
    }

    /// Estimated seconds on one core, those for getting to know the content of files among them.
    pub fn seconds(&self) -> f64 {
        self.run_seconds() + self.unread_seconds()
    }

    /// Estimated seconds of the tasks on one core.
    pub fn run_seconds(&self) -> f64 {
        self.tasks.iter().filter(|t| t.found.is_none()).map(|t| t.cost.seconds).fold(0.0, |a, b| a + b)
    }

    /// The tasks in the order in which they run on one core.
    pub fn tasks(&self) -> Vec<PlannedTask> {
        let effective = self.effective_cells();
        let one = |(i, t): (usize, &Task)| {
            let step = self.step(t);
            PlannedTask {
                node: step.name.clone(),
                kind: step.kind.id,
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

    /// Spacing of the finest detail a wanted value can hold, in metres: that of its grid, or the base grid's where
    /// a global node stands before it; 0 for what is gridless. `None` when it cannot be made.
    pub fn effective_cell(&self, want: usize) -> Option<f64> {
        let task = *self.wanted.get(want)?.as_ref().ok()?;
        Some(self.effective_cells()[task])
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
            let inputs =
                task.needs.iter().filter(|(role, _)| matches!(role, Role::Input { .. } | Role::Fine { .. }));
            // A cached lift has no inputs to look at; its own rule covers it.
            let carried = task.stage == Stage::Lift && !self.step(task).kind.meta.carries.is_empty();
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

    /// Name of the node at the peak of memory.
    pub(super) fn peak_node(&self) -> String {
        self.tasks.get(self.peak.task).map(|t| format!("node `{}`", self.step(t).name)).unwrap_or_default()
    }
}

impl Planner<'_> {
    fn ask(&mut self, step: usize, grid: Grid) {
        let grid = self.program.place(step, grid);
        let windows = &mut self.windows[step];
        match windows.iter_mut().find(|w| w.lattice == grid.lattice) {
            Some(window) => *window = window.union(&grid),
            None => windows.push(grid),
        }
    }

    fn visit(&mut self, i: usize) {
        let program = self.program;
        let Ok(step) = &program.steps[i] else { return };
        let mut base_needed = false;
        let first = self.drafts.len();
        for grid in self.windows[i].clone() {
            let stage = match step.reach {
                Reach::Gridless => Stage::Gridless,
                Reach::Global => Stage::Lift,
                Reach::Point | Reach::Local(_) => Stage::Run,
            };
            let (key, found) = self.found(step, stage, &grid);
            let mut asks = Vec::new();
            if found.is_none() {
                asks = match stage {
                    Stage::Lift => self.lift_asks(step, &grid),
                    Stage::Gridless => Self::input_asks(step, |_| self.base),
                    _ => self.run_asks(step, &grid),
                };
                base_needed |= stage == Stage::Lift || step.node.needs_summary();
            }
            self.drafts.push(Draft { step: i, stage, grid, key, found, asks });
        }
        if base_needed {
            let stage = if step.reach == Reach::Global { Stage::Base } else { Stage::Summary };
            let (key, found) = self.found(step, stage, &self.base);
            let asks = if found.is_none() { Self::input_asks(step, |_| self.base) } else { Vec::new() };
            self.drafts.push(Draft { step: i, stage, grid: self.base, key, found, asks });
        }
        let asked: Vec<_> = self.drafts[first..].iter().flat_map(|d| d.asks.clone()).collect();
        for (_, ask) in asked {
            if let Ask::Result { step, grid } = ask {
                self.ask(step, grid);
            }
        }
    }

    /// The key of a result, and where the store has it. What has no key yet is taken for not there.
    fn found(&self, step: &Step, stage: Stage, grid: &Grid) -> (Option<Key>, Option<Found>) {
        let key = step.key.map(|key| key.on(stage.name(), &grid.lattice));
        (key, key.and_then(|key| self.store.find(&key, grid, self.stock)))
    }

    fn input_asks(step: &Step, window: impl Fn(&'static str) -> Grid) -> Vec<(Role, Ask)> {
        let kind = step.kind;
        let own =
            step.inputs.iter().filter(|i| kind.meta.mixes.is_empty() || i.port != crate::ports::MASK.name);
        own.map(|i| {
            let role = Role::Input { port: i.port, from: i.from };
            (role, Ask::Result { step: i.step, grid: window(i.port) })
        })
        .collect()
    }

    fn run_asks(&self, step: &Step, grid: &Grid) -> Vec<(Role, Ask)> {
        let terrain = &self.program.terrain;
        let mut asks =
            Self::input_asks(step, |port| clip(&step.node.footprint(port, grid, terrain), terrain));
        let views = asks.iter().flat_map(|(role, ask)| match (*role, *ask) {
            (Role::Input { port, from }, Ask::Result { step: source, .. }) => {
                let windows = step.node.views(port, grid, terrain).into_iter();
                let ask = |w: Grid| Ask::Result { step: source, grid: clip(&w, terrain) };
                windows.map(|w| (Role::View { port, from }, ask(w))).collect()
            }
            _ => Vec::new(),
        });
        let views: Vec<_> = views.collect();
        asks.extend(views);
        if step.node.needs_summary() {
            asks.push((Role::Summary, Ask::Own(Stage::Summary)));
        }
        self.mix_asks(step, grid, &mut asks);
        asks
    }

    fn lift_asks(&self, step: &Step, grid: &Grid) -> Vec<(Role, Ask)> {
        let mut asks = vec![(Role::Base, Ask::Own(Stage::Base))];
        if !self.base.contains(grid) {
            for input in step.kind.meta.carries.iter().filter_map(|(_, input)| step.input(input)) {
                let before = Role::Before { port: input.port, from: input.from };
                asks.push((before, Ask::Result { step: input.step, grid: self.base }));
                let fine = Role::Fine { port: input.port, from: input.from };
                asks.push((fine, Ask::Result { step: input.step, grid: *grid }));
            }
        }
        self.mix_asks(step, grid, &mut asks);
        asks
    }

    fn mix_asks(&self, step: &Step, grid: &Grid, asks: &mut Vec<(Role, Ask)>) {
        let mixes = step.kind.meta.mixes;
        let Some(mask) = step.input(crate::ports::MASK.name).filter(|_| !mixes.is_empty()) else { return };
        for input in mixes.iter().filter_map(|(_, input)| step.input(input)).chain([mask]) {
            let role = Role::Fine { port: input.port, from: input.from };
            if !asks.iter().any(|(r, _)| *r == role) {
                asks.push((role, Ask::Result { step: input.step, grid: *grid }));
            }
        }
    }

    /// Turns drafts into tasks in the order of the steps, sources first.
    fn number(self) -> (Vec<Task>, Results) {
        let Self { program, mut drafts, .. } = self;
        drafts.sort_by_key(|d| (d.step, d.stage));
        let mut results = Results::default();
        let mut tasks: Vec<Task> = Vec::with_capacity(drafts.len());
        let mut foretold = Foretold::new(program);
        for draft in drafts {
            let Draft { step, stage, grid, key, found, asks } = draft;
            let needs = asks.into_iter().map(|(role, ask)| {
                let task = match ask {
                    Ask::Result { step, grid } => results.find(step, &program.place(step, grid)),
                    Ask::Own(stage) => results.own(step, stage),
                };
                (role, task)
            });
            let needs = needs.collect();
            let known = foretold.take(step, stage, found.as_ref()).map(Wires::bytes);
            let guessed = stage == Stage::Gridless && found.is_none() && known.is_none();
            let (cost, output_bytes) = match &program.steps[step] {
                Ok(s) => (
                    cost(s, stage, &grid, &program.terrain.base_grid(), &foretold),
                    known.unwrap_or_else(|| output_bytes(s, stage, &grid, found.as_ref())),
                ),
                Err(_) => (Cost::default(), 0),
            };
            results.0.push((step, stage, grid, tasks.len()));
            tasks.push(Task { step, stage, grid, key, cost, output_bytes, found, needs, guessed });
        }
        (tasks, results)
    }
}

/// Task numbers by what they give.
#[derive(Default)]
struct Results(Vec<(usize, Stage, Grid, usize)>);

impl Results {
    /// Tasks stand in the order of their steps: those of a step are found by bisection.
    fn of_step(&self, step: usize) -> &[(usize, Stage, Grid, usize)] {
        let from = self.0.partition_point(|r| r.0 < step);
        let to = self.0.partition_point(|r| r.0 <= step);
        &self.0[from..to]
    }

    fn find(&self, step: usize, grid: &Grid) -> usize {
        let serves = |r: &&(usize, Stage, Grid, usize)| {
            matches!(r.1, Stage::Gridless | Stage::Run | Stage::Lift) && r.2.contains(grid)
        };
        let found = self.of_step(step).iter().find(serves);
        found.map(|r| r.3).expect("every window that is asked for was collected")
    }

    fn own(&self, step: usize, stage: Stage) -> usize {
        let found = self.of_step(step).iter().find(|r| r.1 == stage);
        found.map(|r| r.3).expect("a stage that is asked for was drafted")
    }
}

/// Keeps a footprint inside the apron; one that lies wholly outside becomes the nearest line of it.
fn clip(window: &Grid, terrain: &crate::value::Terrain) -> Grid {
    let apron = terrain.apron(window.lattice);
    let clamp = |start: i64, end: i64, lo: i64, hi: i64| {
        let start = start.clamp(lo, hi - 1);
        (start, end.clamp(start + 1, hi))
    };
    let (col, col_end) = clamp(window.col, window.col_end(), apron.col, apron.col_end());
    let (row, row_end) = clamp(window.row, window.row_end(), apron.row, apron.row_end());
    Grid::between(window.lattice, [col, row], [col_end, row_end])
}
