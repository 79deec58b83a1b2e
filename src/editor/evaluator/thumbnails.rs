//! Thumbnails of the nodes.

use super::view::value_range;
use super::{Order, Shared, Stopped, UNASKED_BYTES, lock};
use crate::context::Cancel;
use crate::editor::board::{NodeState, Thumbnail};
use crate::editor::draft::preview;
use crate::editor::node_progress::NodeProgress;
use crate::engine::{Engine, EngineError, Key, Want};
use crate::graph::{Graph, NodeId, Source};
use crate::value::Grid;

/// Samples along the longer side of a thumbnail.
const SIZE: u32 = 97;
/// Estimated seconds above which no thumbnail is made.
const SECONDS: f64 = 4.0;

impl Shared {
    /// Makes the thumbnails of nodes whose results have changed, visible nodes first.
    pub(super) fn thumbnails(&self, engine: &Engine, order: &Order, cancel: &Cancel) -> Result<(), Stopped> {
        let graph = &order.graph;
        let all: Vec<NodeId> = graph.nodes().collect();
        let most = if order.is_cost_accepted { u64::MAX } else { UNASKED_BYTES };
        let tell = |node, state| self.tell(|board| board.set_node(node, state));
        let progress = NodeProgress::new(graph, &tell);
        let keys = engine.keys(graph, &all, most, &progress, cancel).map_err(|_| Stopped)?;
        self.tell(|board| board.retain_thumbnails(&keys));
        let Some(grid) = preview(graph.terrain(), SIZE) else { return Ok(()) };
        let hidden = all.iter().filter(|id| !order.in_sight.contains(id));
        for &id in order.in_sight.iter().chain(hidden) {
            if cancel.is_cancelled() {
                return Err(Stopped);
            }
            // A bypassed node shows the value that it passes on.
            let port = graph.get(id).and_then(|n| n.kind()?.outputs.first());
            let passed = port.and_then(|p| graph.passed(Source { node: id, port: p.name.clone() }));
            let Some(key) = passed.and_then(|s| keys.get(&s.node)) else { continue };
            if lock(&self.board).needs_thumbnail(id, *key) {
                self.thumbnail(engine, graph, id, *key, grid, cancel)?;
            }
        }
        Ok(())
    }

    fn thumbnail(
        &self,
        engine: &Engine,
        graph: &Graph,
        id: NodeId,
        key: Key,
        grid: Grid,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let Some(port) = graph.get(id).and_then(|n| n.kind()?.outputs.first()) else { return Ok(()) };
        let want = [Want { node: id, port: port.name.clone(), grid }];
        let plan = engine.plan(graph, &want);
        if plan.run_seconds() > SECONDS || engine.admit(&plan).is_err() {
            return Ok(());
        }
        let tell = |node, state| self.tell(|board| board.set_node(node, state));
        let progress = NodeProgress::new(graph, &tell);
        let evaluation = match engine.evaluate(graph, &want, &progress, cancel) {
            Err(EngineError::Cancelled) => return Err(Stopped),
            Err(_) => return Ok(()),
            Ok(evaluation) => evaluation,
        };
        for value in evaluation.values {
            match value {
                Ok(value) => {
                    let picture = crate::render::thumbnail(&value, SIZE as usize, cancel);
                    let range = value_range(&value);
                    let picture = picture.map_err(|_| Stopped)?;
                    self.tell(|board| board.set_thumbnail(id, Thumbnail { key, picture, range }));
                }
                Err(failure) => {
                    // The failure is shown at the node that failed, not at those downstream of it.
                    let at = failure.node().and_then(|name| graph.find(name)).unwrap_or(id);
                    self.tell(|board| board.set_node(at, NodeState::Failed(failure.to_string())));
                }
            }
        }
        Ok(())
    }
}
