//! The account of a plan: what tasks cost, what they leave, and the most memory they hold at once.
//!
//! The account counts everything that is alive: the outputs that somebody still reads, what a task takes while it runs,
//! results that are kept for the next evaluation, and the copies that are cut for who asked. The runner keeps the same
//! account and starts nothing that would lead over the peak that is stated here.

use std::collections::BTreeMap;

use super::cache::Found;
use super::foretell::Foretold;
use super::outputs::Outputs;
use super::plan::{Role, Stage, Task, Wanted};
use super::program::Step;
use crate::node::{Cost, Detail, Load};
use crate::ports::MASK;
use crate::value::{Grid, Terrain};

/// The most memory the tasks hold at once.
#[derive(Clone, Debug, Default)]
pub(super) struct Peak {
    /// Bytes, with the room that lets independent tasks run side by side.
    pub bytes: u64,
    /// The task at which they are held.
    pub task: usize,
    /// Bytes that are alive while each task runs, when they run in order.
    pub course: Vec<u64>,
}

/// What a task takes.
pub(super) struct Sizes {
    pub cost: Cost,
    /// Bytes of the outputs that are read, which stay until the last reader is done.
    pub output_bytes: u64,
    /// Bytes of the cost that are for files: their content, and what is decoded from it.
    pub file_bytes: u64,
}

impl Sizes {
    /// Those of a stage of a step on a grid, of whose outputs some are read.
    pub(super) fn new(
        step: &Step,
        stage: Stage,
        grid: &Grid,
        terrain: &Terrain,
        read: Outputs,
        found: Option<&Found>,
        foretold: &Foretold<'_>,
    ) -> Self {
        if let Some(bytes) = found.and_then(Found::bytes) {
            // Reading a file puts pairs and triples together in memory of their own.
            let scratch = if matches!(found, Some(Found::Disk(_))) { bytes } else { 0 };
            let cost = Cost { bytes: scratch, seconds: bytes as f64 * 1e-9 };
            return Self { cost, output_bytes: bytes, file_bytes: 0 };
        }
        let bytes_of = |all: Outputs| {
            let sample: u64 = all.ports(&step.kind).map(|p| p.wire.sample_bytes()).sum();
            sample.saturating_mul(grid.len() as u64)
        };
        let output_bytes = if stage == Stage::Summary { SUMMARY_BYTES } else { bytes_of(read) };
        let mut cost = cost(step, stage, grid, terrain, read, foretold);
        if stage != Stage::Summary {
            let made = if stage == Stage::Lift { read } else { Outputs::all(&step.kind) };
            cost.seconds += bytes_of(made) as f64 / 4.0 * OUTPUT_NUMBER;
        }
        // A node makes all its outputs; those that nobody reads go when it is done.
        if matches!(stage, Stage::Base | Stage::Run) {
            let unread = bytes_of(Outputs::all(&step.kind)).saturating_sub(output_bytes);
            cost.bytes = cost.bytes.saturating_add(unread);
        }
        let reads = matches!(stage, Stage::Gridless | Stage::Base | Stage::Run);
        let file_bytes = if reads { step.reading().bytes } else { 0 };
        Self { cost, output_bytes, file_bytes }
    }
}

/// Seconds a number of an output: fresh memory, and a look whether it is finite.
const OUTPUT_NUMBER: f64 = 4e-9;
/// A statistic of the whole is a few numbers, or the points of a curve.
const SUMMARY_BYTES: u64 = 1 << 14;

fn cost(
    step: &Step,
    stage: Stage,
    grid: &Grid,
    terrain: &Terrain,
    read: Outputs,
    foretold: &Foretold<'_>,
) -> Cost {
    let base = terrain.base_grid();
    let own = match stage {
        Stage::Gridless | Stage::Run | Stage::Base => {
            let known = |port: &str| foretold.input(step, port);
            let grid = if stage == Stage::Gridless { base } else { *grid };
            step.node.cost(&Load { grid, terrain, known: &known }).and(step.reading())
        }
        Stage::Summary => Cost::per_sample(grid, 4.0),
        Stage::Lift => lift_cost(step, grid, &base, read),
    };
    let mixed =
        !matches!(stage, Stage::Gridless | Stage::Base | Stage::Summary) && step.input(&MASK.name).is_some();
    if mixed { with_mixing(own, step, grid) } else { own }
}

/// The cost of carrying the outputs that are read to another grid.
fn lift_cost(step: &Step, grid: &Grid, base: &Grid, read: Outputs) -> Cost {
    if base.contains(grid) {
        return Cost::per_sample(grid, LIFT_COPY);
    }
    let channels: f64 = read.ports(&step.kind).map(|p| p.wire.sample_bytes() as f64 / 4.0).sum();
    let carried = step.kind.carries.iter().filter(|(output, _)| read.has(&step.kind, output));
    let weighed = |output: &str| matches!(step.node.keep(output), Detail::By(_));
    let (mut extra, mut splines) = (0.0, channels);
    for (output, _) in carried {
        extra += LIFT_CHANGE;
        splines += if weighed(output) { 2.0 } else { 0.0 };
    }
    // The change and its spline, the splines of what is weighed, or those of three channels and one of them set apart; a
    // direction has two of each.
    Cost::per_sample(grid, LIFT_SAMPLE * splines + extra)
        .and(Cost::per_sample(base, LIFT_FIT * splines))
        .with_fields(base, 4.1)
}

/// Nanoseconds a sample: a window cut out of the base grid, a spline evaluated, a change looked for, a spline fitted.
const LIFT_COPY: f64 = 1.0;
const LIFT_SAMPLE: f64 = 3.5;
const LIFT_CHANGE: f64 = 4.0;
const LIFT_FIT: f64 = 7.0;
/// Nanoseconds a channel and sample of mixing by a mask.
const MIX_SAMPLE: f64 = 2.5;

/// With what the engine takes to mix outputs with inputs: one after the other into memory of its own.
fn with_mixing(cost: Cost, step: &Step, grid: &Grid) -> Cost {
    let channels =
        |output: &str| step.kind.output(output).map_or(0.0, |p| p.wire.sample_bytes() as f64 / 4.0);
    let mixes = step.kind.mixes.iter().map(|(output, _)| channels(output));
    let (widest, all) = mixes.fold((0.0, 0.0), |(widest, all): (f64, f64), c| (widest.max(c), all + c));
    cost.and(Cost::per_sample(grid, MIX_SAMPLE * all)).with_fields(grid, widest)
}

/// What stays until the engine is asked again: results on the base grid, or on none, that every tile reads, and what is
/// decoded from files; the bytes of the latter, which no longer count in the tasks.
pub(super) fn mark_lasting(tasks: &mut [Task]) -> u64 {
    let mut lasting: Vec<usize> = Vec::new();
    for task in tasks.iter() {
        for (role, need) in &task.needs {
            let gridless =
                tasks[*need].stage == Stage::Gridless && matches!(task.stage, Stage::Run | Stage::Lift);
            if gridless || matches!(role, Role::Base | Role::Before(_) | Role::Summary) {
                lasting.push(*need);
            }
        }
    }
    for need in lasting {
        tasks[need].lasting = true;
    }
    let mut files = BTreeMap::new();
    for task in tasks.iter_mut() {
        task.lasting |= task.held();
        if task.file_bytes > 0 {
            files.insert(task.step, task.file_bytes);
            task.cost.bytes = task.cost.bytes.saturating_sub(task.file_bytes);
        }
    }
    files.into_values().fold(0, u64::saturating_add)
}

/// Bytes that are alive before anything runs, or counted as such: what is in memory, and what is to stay.
pub(super) fn standing_bytes(tasks: &[Task]) -> u64 {
    tasks.iter().filter(|t| t.held() || t.lasting).map(|t| t.output_bytes).fold(0, u64::saturating_add)
}

/// Bytes that stay when all is done, beside what was asked for.
pub(super) fn lasting_bytes(tasks: &[Task]) -> u64 {
    tasks.iter().filter(|t| t.lasting).map(|t| t.output_bytes).fold(0, u64::saturating_add)
}

/// How often each task's result is read.
pub(super) fn uses(tasks: &[Task], wanted: &[Wanted]) -> Vec<usize> {
    let mut uses = vec![0; tasks.len()];
    let needs = tasks.iter().flat_map(|t| &t.needs).map(|(_, need)| need);
    needs.chain(wanted.iter().flatten()).for_each(|t| uses[*t] += 1);
    uses
}

/// Walks the tasks in order and keeps account of what is alive, decoded files that stay among it; at the end `cut_bytes`
/// are copied for who asked.
pub(super) fn peak(tasks: &[Task], wanted: &[Wanted], file_bytes: u64, cut_bytes: u64) -> Peak {
    let mut uses = uses(tasks, wanted);
    let mut alive = standing_bytes(tasks).saturating_add(file_bytes);
    let mut peak = Peak { bytes: alive, task: 0, course: Vec::with_capacity(tasks.len()) };
    for (i, task) in tasks.iter().enumerate() {
        let now = alive.saturating_add(task.bytes());
        if now > peak.bytes {
            (peak.bytes, peak.task) = (now, i);
        }
        peak.course.push(now);
        alive = now.saturating_sub(task.scratch_bytes());
        for (_, need) in &task.needs {
            uses[*need] -= 1;
            if uses[*need] == 0 {
                alive = alive.saturating_sub(tasks[*need].released_bytes());
            }
        }
        if uses[i] == 0 {
            alive = alive.saturating_sub(task.released_bytes());
        }
    }
    let last = alive.saturating_add(cut_bytes);
    if last > peak.bytes {
        (peak.bytes, peak.task) = (last, tasks.len().saturating_sub(1));
    }
    peak.bytes = peak.bytes.saturating_add(peak.bytes / ROOM_SHARE + ROOM);
    peak
}

/// Bytes beside the peak, and the share of it on top, in which small tasks run ahead: larger ones find their room where the
/// plan is below its peak.
const ROOM: u64 = 1 << 20;
const ROOM_SHARE: u64 = 32;
