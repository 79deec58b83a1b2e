//! What a command takes beside its evaluation: the program itself, the document, the writers.

use super::args::EngineArgs;
use crate::files::writer_cost;
use crate::files::{Format, WriterCost};
use crate::graph::Graph;
use crate::value::Grid;

/// Bytes the program takes before it evaluates anything: itself, and what the allocator holds back.
const PROGRAM_BYTES: u64 = 20 << 20;
/// Bytes a thread takes by being there: its stack as far as it is used, and an arena of the allocator.
const THREAD_BYTES: u64 = 1 << 20;
/// Bytes a node takes in the document, the program, the plan and the report.
const NODE_BYTES: u64 = 5 << 10;
/// Numbers a sample of the widest value that is written: colours.
const WIDEST: usize = 3;

/// Bytes beside the evaluation: for the program and the graph, and for writing where there is something to write.
pub(super) fn reserve(graph: &Graph, engine: &EngineArgs, written: Option<&Grid>) -> u64 {
    let threads = engine.threads();
    let writer = |grid: &Grid| writer_cost(Format::Exr, [grid.cols, grid.rows], WIDEST, threads);
    let WriterCost { bytes, .. } = written.map(writer).unwrap_or_default();
    PROGRAM_BYTES + THREAD_BYTES * threads as u64 + NODE_BYTES * graph.nodes().len() as u64 + bytes
}
