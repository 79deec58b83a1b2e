//! The cost of a build, for its dialog.

use super::{Order, Shared, lock};
use crate::editor::board::Estimate;
use crate::engine::{Engine, Want};

impl Shared {
    /// Estimates the build of an order, unless the board has its estimate already.
    pub(super) fn estimate(&self, engine: &Engine, order: &Order) {
        let Some(build) = &order.build else { return };
        if lock(&self.board).estimate.as_ref().is_some_and(|e| e.of == *build) {
            return;
        }
        let graph = &order.graph;
        let Ok(grid) = graph.terrain().grid(build.size) else { return };
        let sources = build.outputs.iter().filter_map(|name| graph.output_source(name).ok());
        let wants: Vec<_> = sources.map(|s| Want { node: s.node, port: s.port, grid }).collect();
        let plan = engine.plan(graph, &wants);
        let estimate = Estimate {
            of: build.clone(),
            seconds: plan.seconds() / engine.pool().current_num_threads() as f64,
            bytes: plan.peak_bytes(),
            refusal: engine.admit(&plan).err().map(|e| e.to_string()),
        };
        self.tell(|board| board.set_estimate(estimate));
    }
}
