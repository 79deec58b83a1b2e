//! The account of a plan: the cost of tasks, the bytes of their results, and the peak of memory.
//!
//! The account counts everything that is alive: outputs that will still be read, the scratch memory of running tasks,
//! results that stay for the next evaluation, and the wanted windows that are copied at the end. The runner keeps the
//! same account and starts no task that would exceed the peak that is computed here.

use std::collections::BTreeMap;

use super::cache::Found;
use super::foretell::Foretold;
use super::outputs::Outputs;
use super::plan::{Role, Stage, Task, Wanted};
use super::program::Step;
use crate::node::{Cost, Detail, Load};
use crate::ports::{MASK, Port};
use crate::value::{Grid, Terrain};

/// The peak of memory of a plan.
#[derive(Clone, Debug, Default)]
pub(super) struct Peak {
    /// Bytes at the peak, with some room for independent tasks that run side by side.
    pub bytes: u64,
    /// The task at which the peak is reached.
    pub task: usize,
    /// For each task, the bytes that are alive while it runs, when tasks run in order.
    pub course: Vec<u64>,
}

/// The cost of a task and the bytes of its outputs.
pub(super) struct Sizes {
    pub cost: Cost,
    /// Bytes of the outputs that are read; they are alive until the last reader is done.
    pub output_bytes: u64,
    /// The part of the bytes of the cost that is for files: their content and the decoded values.
    pub file_bytes: u64,
}

impl Sizes {
    /// The sizes of a stage of a step on a grid, of which the outputs in `read` are read.
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
            // Reading a file of pairs or triples needs scratch memory in which they are put together.
            let scratch = if matches!(found, Some(Found::Disk(_))) { bytes } else { 0 };
            let cost = Cost { bytes: scratch, seconds: bytes as f64 * 1e-9 };
            return Self { cost, output_bytes: bytes, file_bytes: 0 };
        }
        let bytes_of = |all: Outputs| {
            let bytes = |p: &Port| {
                p.wire.sample_bytes().saturating_mul(grid.len() as u64).saturating_add(p.wire.guessed_bytes())
            };
            all.ports(&step.kind).map(bytes).fold(0, u64::saturating_add)
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

/// Seconds for each number of an output, for fresh memory and the check that it is finite.
const OUTPUT_NUMBER: f64 = 4e-9;
/// The assumed bytes of a summary, which is a few numbers or the points of a curve.
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

/// The cost of lifting or carrying the outputs that are read to another grid.
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

/// Nanoseconds a sample for four parts of a lift: copying a window of the base grid, evaluating a spline, finding
/// whether there is a change, and fitting a spline.
const LIFT_COPY: f64 = 1.0;
const LIFT_SAMPLE: f64 = 3.5;
const LIFT_CHANGE: f64 = 4.0;
const LIFT_FIT: f64 = 7.0;
/// Nanoseconds for each channel of a sample that is mixed by a mask.
const MIX_SAMPLE: f64 = 2.5;

/// A cost with that of mixing outputs with inputs added; outputs are mixed one after the other into new memory.
fn with_mixing(cost: Cost, step: &Step, grid: &Grid) -> Cost {
    let channels =
        |output: &str| step.kind.output(output).map_or(0.0, |p| p.wire.sample_bytes() as f64 / 4.0);
    let mixes = step.kind.mixes.iter().map(|(output, _)| channels(output));
    let (widest, all) = mixes.fold((0.0, 0.0), |(widest, all): (f64, f64), c| (widest.max(c), all + c));
    cost.and(Cost::per_sample(grid, MIX_SAMPLE * all)).with_fields(grid, widest)
}

/// Marks the results that stay for the next evaluation: those on the base grid, or without a grid, that every tile
/// reads. A network that a kind found on the base grid is read by tiles as it is, without a lift. Values decoded from files stay, too; returns their bytes, which no longer count in the tasks.
pub(super) fn mark_lasting(tasks: &mut [Task]) -> u64 {
    let mut lasting: Vec<usize> = Vec::new();
    for task in tasks.iter() {
        for (role, need) in &task.needs {
            let is_of_all_tiles = matches!(tasks[*need].stage, Stage::Gridless | Stage::Base);
            let reads_as_it_is = is_of_all_tiles && matches!(task.stage, Stage::Run | Stage::Lift);
            if reads_as_it_is || matches!(role, Role::Base | Role::Before(_) | Role::Summary) {
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

/// Marks the results whose size is not known before they are there: they are made first, all of them stay until the rest
/// is planned with what they hold, and the guess counts them so.
pub(super) fn mark_guessed(tasks: &mut [Task]) {
    tasks.iter_mut().filter(|task| task.guessed).for_each(|task| task.lasting = true);
}

/// Bytes that count as alive before any task runs: results in memory, and results that will stay.
pub(super) fn standing_bytes(tasks: &[Task]) -> u64 {
    tasks.iter().filter(|t| t.held() || t.lasting).map(|t| t.output_bytes).fold(0, u64::saturating_add)
}

/// Bytes of the results that stay for the next evaluation.
pub(super) fn lasting_bytes(tasks: &[Task]) -> u64 {
    tasks.iter().filter(|t| t.lasting).map(|t| t.output_bytes).fold(0, u64::saturating_add)
}

/// For each task, how often its result is read.
pub(super) fn uses(tasks: &[Task], wanted: &[Wanted]) -> Vec<usize> {
    let mut uses = vec![0; tasks.len()];
    let needs = tasks.iter().flat_map(|t| &t.needs).map(|(_, need)| need);
    needs.chain(wanted.iter().flatten()).for_each(|t| uses[*t] += 1);
    uses
}

/// The peak of memory when the tasks run in order. `file_bytes` of decoded files are alive throughout, and `cut_bytes`
/// are copied at the end for the wanted windows.
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

/// The room that is added to the peak for small tasks that run ahead: a number of bytes, and a share of the peak.
/// Larger tasks run ahead where the plan is below its peak.
const ROOM: u64 = 1 << 20;
const ROOM_SHARE: u64 = 32;
