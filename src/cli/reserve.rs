//! The memory of a command beside its evaluation: that of the program, the document and the writers.

use super::args::EngineArgs;
use crate::files::writer_cost;
use crate::files::{Format, WriterCost};
use crate::graph::Graph;
use crate::value::Grid;

/// Bytes that the program takes before an evaluation, with those that the allocator holds.
const PROGRAM_BYTES: u64 = 20 << 20;
/// Bytes of a thread: the used part of its stack, and an arena of the allocator.
const THREAD_BYTES: u64 = 1 << 20;
/// Bytes of a node in the document, the program, the plan and the report.
const NODE_BYTES: u64 = 5 << 10;
/// Numbers in a sample of the widest value that is written, which is colours.
const WIDEST: usize = 3;

/// Bytes beside the evaluation: those of the program and the graph, and those of writing where a grid is written.
pub(super) fn reserve(graph: &Graph, engine: &EngineArgs, written: Option<&Grid>) -> u64 {
    let threads = engine.threads();
    let writer = |grid: &Grid| writer_cost(Format::Exr, [grid.cols, grid.rows], WIDEST, threads);
    let WriterCost { bytes, .. } = written.map(writer).unwrap_or_default();
    PROGRAM_BYTES + THREAD_BYTES * threads as u64 + NODE_BYTES * graph.nodes().len() as u64 + bytes
}
