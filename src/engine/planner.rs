//! From what is wanted to tasks: each node collects what its consumers need before it asks its own sources.

use std::borrow::Cow;

use super::account::Sizes;
use super::cache::{Found, Stock, Store};
use super::error::SharedFailure;
use super::foretell::Foretold;
use super::key::Key;
use super::outputs::Outputs;
use super::plan::{Role, Stage, Target, Task, Wanted};
use super::program::{Input, Program, Step};
use crate::node::{Cancel, Detail, Reach};
use crate::ports::{MASK, Wires};
use crate::value::{Grid, Terrain};

/// A task before its dependencies have numbers.
struct Draft {
    step: usize,
    stage: Stage,
    grid: Grid,
    read: Outputs,
    key: Option<Key>,
    found: Option<Found>,
    asks: Vec<(Role, Ask)>,
}

/// A result that a draft depends on.
#[derive(Clone, Copy)]
enum Ask {
    /// An output that a step gives its consumers on a grid.
    Result { step: usize, read: Outputs, grid: Grid },
    /// Another stage of the same step.
    Own(Stage),
}

/// A window of a step and the outputs that are read on it.
#[derive(Clone, Copy)]
struct Window {
    grid: Grid,
    read: Outputs,
}

/// Makes tasks of what is wanted.
pub(super) struct Planner<'a> {
    program: &'a Program,
    store: &'a Store,
    stock: Stock,
    base: Grid,
    /// Windows asked of each step, one per lattice.
    windows: Vec<Vec<Window>>,
    drafts: Vec<Draft>,
}

impl<'a> Planner<'a> {
    pub(super) fn new(program: &'a Program, store: &'a Store, stock: Stock) -> Self {
        let base = program.terrain.base_grid();
        let windows = vec![Vec::new(); program.steps.len()];
        let drafts = Vec::with_capacity(program.steps.len());
        Self { program, store, stock, base, windows, drafts }
    }

    /// The tasks in the order in which they run, for each want its task, and the bytes that cutting the wanted windows out
    /// of what was computed takes. Nothing when it is cancelled.
    pub(super) fn plan(
        mut self,
        wants: &[Result<Target, SharedFailure>],
        cancel: &Cancel,
    ) -> Option<(Vec<Task>, Vec<Wanted>, u64)> {
        let program = self.program;
        for (step, from, grid) in wants.iter().flatten() {
            if let Ok(kind) = program.steps[*step].as_ref().map(|s| &s.kind) {
                self.ask(*step, Outputs::one(kind, from), *grid);
            }
        }
        for step in (0..program.steps.len()).rev() {
            if cancel.is_cancelled() {
                return None;
            }
            self.visit(step);
        }
        let (tasks, results) = self.number(cancel)?;
        let mut cut_bytes = 0;
        let mut find = |(step, from, grid): Target| match &program.steps[step] {
            Ok(s) => {
                let grid = program.place(step, grid);
                let task = results.find(step, &grid);
                let port = s.kind.output(&from);
                if tasks[task].grid != grid
                    && let Some(port) = port
                {
                    cut_bytes += port.wire.sample_bytes() * grid.len() as u64;
                }
                Ok(task)
            }
            Err(failure) => Err(failure.clone()),
        };
        let wanted = wants.iter().map(|w| w.clone().and_then(&mut find)).collect();
        Some((tasks, wanted, cut_bytes))
    }

    fn ask(&mut self, step: usize, read: Outputs, grid: Grid) {
        let grid = self.program.place(step, grid);
        let windows = &mut self.windows[step];
        match windows.iter_mut().find(|w| w.grid.lattice == grid.lattice) {
            Some(window) => {
                *window = Window { grid: window.grid.union(&grid), read: window.read.union(read) };
            }
            None => {
                // Few steps have a second.
                windows.reserve_exact(1);
                windows.push(Window { grid, read });
            }
        }
    }

    fn visit(&mut self, i: usize) {
        let program = self.program;
        let Ok(step) = &program.steps[i] else { return };
        let first = self.drafts.len();
        // What is read of the same step's results on the base grid, where they are needed.
        let mut on_base: Option<Outputs> = None;
        for Window { grid, read } in std::mem::take(&mut self.windows[i]) {
            let stage = match step.reach {
                Reach::Gridless => Stage::Gridless,
                Reach::Global => Stage::Lift,
                Reach::Point | Reach::Local(_) => Stage::Run,
            };
            let (key, found) = self.found(step, stage, &grid, read);
            let mut asks = Vec::new();
            if found.is_none() {
                asks = match stage {
                    Stage::Lift => self.lift_asks(step, &grid, read),
                    Stage::Gridless => Self::input_asks(step, |_| self.base),
                    _ => self.run_asks(step, &grid),
                };
                if stage == Stage::Lift || step.node.needs_summary() {
                    let weights = self.weights(step, &grid, read);
                    on_base = Some(on_base.unwrap_or_default().union(read).union(weights));
                }
            }
            self.drafts.push(Draft { step: i, stage, grid, read, key, found, asks });
        }
        if let Some(read) = on_base {
            let stage = if step.reach == Reach::Global { Stage::Base } else { Stage::Summary };
            let grid = self.base;
            let (key, found) = self.found(step, stage, &grid, read);
            let asks = if found.is_none() { Self::input_asks(step, |_| self.base) } else { Vec::new() };
            self.drafts.push(Draft { step: i, stage, grid, read, key, found, asks });
        }
        for draft in first..self.drafts.len() {
            for ask in 0..self.drafts[draft].asks.len() {
                if let (_, Ask::Result { step, read, grid }) = self.drafts[draft].asks[ask] {
                    self.ask(step, read, grid);
                }
            }
        }
    }

    /// The key of a result, and where the store has it. What has no key yet is taken for not there.
    fn found(&self, step: &Step, stage: Stage, grid: &Grid, read: Outputs) -> (Option<Key>, Option<Found>) {
        let on = |key: Key| key.on(&named(step, stage, read), &grid.lattice);
        let key = step.key.map(|key| step.key_on((stage, read, grid.lattice), || on(key)));
        (key, key.and_then(|key| self.store.find(&key, grid, (&step.kind, read), self.stock)))
    }

    fn input_asks(step: &Step, window: impl Fn(&str) -> Grid) -> Vec<(Role, Ask)> {
        let own = step.inputs.iter().enumerate().filter(|(_, input)| step.kind.hands_over(&input.port));
        let mut asks = Vec::with_capacity(step.inputs.len());
        asks.extend(own.map(|(i, input)| (Role::Input(i), asked(input, window(&input.port)))));
        asks
    }

    fn run_asks(&self, step: &Step, grid: &Grid) -> Vec<(Role, Ask)> {
        let terrain = &self.program.terrain;
        let mut asks =
            Self::input_asks(step, |port| clip(&step.node.footprint(port, grid, terrain), terrain));
        asks.extend(Self::view_asks(step, grid, terrain));
        if step.node.needs_summary() {
            asks.push((Role::Summary, Ask::Own(Stage::Summary)));
        }
        Self::mix_asks(step, grid, Outputs::all(&step.kind), &mut asks);
        asks
    }

    /// What an input is read on besides its footprint, each window for itself.
    fn view_asks(step: &Step, grid: &Grid, terrain: &Terrain) -> Vec<(Role, Ask)> {
        let mut asks = Vec::new();
        let own = step.inputs.iter().enumerate().filter(|(_, input)| step.kind.hands_over(&input.port));
        for (i, input) in own {
            let windows = step.node.views(&input.port, grid, terrain).into_iter();
            asks.extend(windows.map(|window| (Role::View(i), asked(input, clip(&window, terrain)))));
        }
        asks
    }

    fn lift_asks(&self, step: &Step, grid: &Grid, read: Outputs) -> Vec<(Role, Ask)> {
        let mut asks = vec![(Role::Base, Ask::Own(Stage::Base))];
        if !self.base.contains(grid) {
            let carries = step.kind.carries.iter().filter(|(output, _)| read.has(&step.kind, output));
            for i in carries.filter_map(|(_, input)| step.index(input)) {
                asks.push((Role::Before(i), asked(&step.inputs[i], self.base)));
                asks.push((Role::Fine(i), asked(&step.inputs[i], *grid)));
            }
        }
        Self::mix_asks(step, grid, read, &mut asks);
        asks
    }

    /// The outputs that weigh the detail of those that are read and carried.
    fn weights(&self, step: &Step, grid: &Grid, read: Outputs) -> Outputs {
        if self.base.contains(grid) {
            return Outputs::default();
        }
        let carried = step.kind.carries.iter().filter(|(output, _)| read.has(&step.kind, output));
        let weight = |output: &str| match step.node.keep(output) {
            Detail::By(field) => Outputs::one(&step.kind, field),
            Detail::Whole | Detail::Times(_) => Outputs::default(),
        };
        carried.fold(Outputs::default(), |all, (output, _)| all.union(weight(output)))
    }

    fn mix_asks(step: &Step, grid: &Grid, read: Outputs, asks: &mut Vec<(Role, Ask)>) {
        let mixes = step.kind.mixes.iter().filter(|(output, _)| read.has(&step.kind, output));
        let Some(mask) = step.index(&MASK.name).filter(|_| !step.kind.mixes.is_empty()) else { return };
        for i in mixes.filter_map(|(_, input)| step.index(input)).chain([mask]) {
            let role = Role::Fine(i);
            if !asks.iter().any(|(r, _)| *r == role) {
                asks.push((role, asked(&step.inputs[i], *grid)));
            }
        }
    }

    /// Turns drafts into tasks in the order of the steps, sources first; nothing when it is cancelled.
    fn number(self, cancel: &Cancel) -> Option<(Vec<Task>, Results)> {
        let Self { program, mut drafts, .. } = self;
        drafts.sort_by_key(|d| (d.step, d.stage));
        let mut results = Results::default();
        let mut tasks: Vec<Task> = Vec::with_capacity(drafts.len());
        let mut foretold = Foretold::new(program);
        for draft in drafts {
            if cancel.is_cancelled() {
                return None;
            }
            let Draft { step, stage, grid, read, key, found, asks } = draft;
            // Windows that are wider than what was asked for are cut, into memory of their own.
            let mut cut_bytes = 0;
            let needs = asks.into_iter().map(|(role, ask)| {
                let task = match ask {
                    Ask::Result { step, read, grid } => {
                        let grid = program.place(step, grid);
                        let task = results.find(step, &grid);
                        if tasks[task].grid != grid
                            && let Ok(source) = &program.steps[step]
                        {
                            let sample: u64 = read.ports(&source.kind).map(|p| p.wire.sample_bytes()).sum();
                            cut_bytes += sample * grid.len() as u64;
                        }
                        task
                    }
                    Ask::Own(stage) => results.own(step, stage),
                };
                (role, task)
            });
            let needs = needs.collect();
            let Ok(planned) = &program.steps[step] else { continue };
            let known = foretold.take(step, stage, found.as_ref()).map(Wires::bytes);
            let guessed = stage == Stage::Gridless && known.is_none();
            let Sizes { mut cost, output_bytes, file_bytes } =
                Sizes::new(planned, stage, &grid, &program.terrain, read, found.as_ref(), &foretold);
            let output_bytes = known.unwrap_or(output_bytes);
            cost.bytes = cost.bytes.saturating_add(cut_bytes);
            results.0.push((step, stage, grid, tasks.len()));
            tasks.push(Task {
                step,
                stage,
                grid,
                key,
                cost,
                read,
                output_bytes,
                file_bytes,
                found,
                needs,
                guessed,
                lasting: false,
            });
        }
        Some((tasks, results))
    }
}

/// What an input asks for on a grid.
fn asked(input: &Input, grid: Grid) -> Ask {
    Ask::Result { step: input.step, read: input.read, grid }
}

/// The name of a stage in keys. A lift makes what is read and nothing else, so that its key says what.
fn named(step: &Step, stage: Stage, read: Outputs) -> Cow<'static, str> {
    if stage != Stage::Lift || read == Outputs::all(&step.kind) {
        return stage.name().into();
    }
    let ports: Vec<&str> = read.ports(&step.kind).map(|p| p.name.as_str()).collect();
    format!("{} of {}", stage.name(), ports.join(" ")).into()
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
fn clip(window: &Grid, terrain: &Terrain) -> Grid {
    let apron = terrain.apron(window.lattice);
    let clamp = |start: i64, end: i64, lo: i64, hi: i64| {
        let start = start.clamp(lo, hi - 1);
        (start, end.clamp(start + 1, hi))
    };
    let (col, col_end) = clamp(window.col, window.col_end(), apron.col, apron.col_end());
    let (row, row_end) = clamp(window.row, window.row_end(), apron.row, apron.row_end());
    Grid::between(window.lattice, [col, row], [col_end, row_end])
}
