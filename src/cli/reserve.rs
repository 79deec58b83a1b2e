//! What a command takes beside its evaluation: the program itself and its writers.

use super::args::EngineArgs;
use crate::graph::Graph;
use crate::value::Grid;

/// Bytes the program takes before it evaluates anything: itself, its threads, what the allocator holds back.
const PROGRAM_BYTES: u64 = 48 << 20;
/// Bytes a sample that the writers take beside the value: integers or blocks, and what they are pressed into.
const WRITER_BYTES: u64 = 12;

/// Bytes beside the evaluation: for the program, and for writing where there is something to write. `plan` and `build`
/// ask here, so that they need the same.
pub(super) fn reserve(_: &Graph, _: &EngineArgs, written: Option<&Grid>) -> u64 {
    PROGRAM_BYTES + WRITER_BYTES * written.map_or(0, |grid| grid.len() as u64)
}
