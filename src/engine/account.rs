//! The account of a plan: what tasks cost, what they leave, and the most memory they hold at once.

use super::cache::Found;
use super::foretell::Foretold;
use super::plan::{Stage, Task, Wanted};
use super::program::Step;
use crate::node::Cost;
use crate::value::Grid;

/// The most memory the tasks hold at once when run in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Peak {
    pub bytes: u64,
    pub task: usize,
}

pub(super) fn cost(step: &Step, stage: Stage, grid: &Grid, base: &Grid, foretold: &Foretold<'_>) -> Cost {
    match stage {
        Stage::Gridless | Stage::Run | Stage::Base => {
            let known = |port: &str| foretold.input(step, port);
            let own = step.node.cost_with_base(grid, base, &known).and(step.reading());
            // Mixing and cropping hold a copy of what they mix.
            let mixed = step.kind.meta.mixes.len() as f64 * 3.0;
            if step.input(crate::ports::MASK.name).is_some() { own.with_fields(grid, mixed) } else { own }
        }
        Stage::Summary => Cost::per_sample(grid, 4.0).with_fields(grid, 1.0),
        Stage::Lift => {
            let fields: u64 = step.kind.outputs.iter().map(|p| p.wire.sample_bytes() / 4).sum();
            Cost::per_sample(grid, 3.0 * fields as f64).with_fields(base, 3.0).with_fields(grid, 2.0)
        }
    }
}

pub(super) fn output_bytes(step: &Step, stage: Stage, grid: &Grid, found: Option<&Found>) -> u64 {
    if let Some(bytes) = found.and_then(Found::bytes) {
        return bytes;
    }
    let sample: u64 = step.kind.outputs.iter().map(|p| p.wire.sample_bytes()).sum();
    if stage == Stage::Summary { 4096 } else { sample.saturating_mul(grid.len() as u64) }
}

pub(super) fn held_bytes(tasks: &[Task]) -> u64 {
    tasks.iter().filter(|t| t.held()).map(|t| t.output_bytes).sum()
}

/// How often each task's result is read.
pub(super) fn uses(tasks: &[Task], wanted: &[Wanted]) -> Vec<usize> {
    let mut uses = vec![0; tasks.len()];
    let needs = tasks.iter().flat_map(|t| &t.needs).map(|(_, need)| need);
    needs.chain(wanted.iter().flatten()).for_each(|t| uses[*t] += 1);
    uses
}

/// Walks the tasks in order and keeps account of what is alive.
pub(super) fn peak(tasks: &[Task], wanted: &[Wanted]) -> Peak {
    let mut uses = uses(tasks, wanted);
    let mut alive = held_bytes(tasks);
    let mut peak = Peak { bytes: alive, task: 0 };
    for (i, task) in tasks.iter().enumerate() {
        let now = alive.saturating_add(task.bytes());
        if now > peak.bytes {
            peak = Peak { bytes: now, task: i };
        }
        alive = now.saturating_sub(task.scratch_bytes());
        for (_, need) in &task.needs {
            uses[*need] -= 1;
            if uses[*need] == 0 {
                alive = alive.saturating_sub(tasks[*need].output_bytes);
            }
        }
        if uses[i] == 0 {
            alive = alive.saturating_sub(task.output_bytes);
        }
    }
    peak
}
