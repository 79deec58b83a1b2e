//! The order that the window places with the evaluator.

use super::app::{Editor, Page};
use super::board::{BuildRequest, Scenery};
use super::dialogs::Dialog;
use super::evaluator::Order;
use super::shade::{Light, Mode};
use crate::graph::{NodeId, Source};
use crate::value::{Grid, WireType};

/// The contents of an order, compared with those of the last one to see whether a new order is due.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Contents {
    state: u64,
    scene: Option<Scenery>,
    light: Option<Light>,
    detail: Option<Grid>,
    build: Option<BuildRequest>,
    accepted: Option<u64>,
}

impl Editor {
    /// The node that the view shows: the pinned node, else the only chosen node, else the node shown last.
    pub(super) fn shown_node(&self) -> Option<NodeId> {
        let graph = self.document.graph();
        let all = [self.pinned, self.canvas.chosen.lone(), self.last_shown];
        all.into_iter().flatten().find(|id| graph.get(*id).is_some())
    }

    /// The output that the view shows.
    pub(super) fn target(&self) -> Option<Source> {
        let node = self.shown_node()?;
        let outputs = &self.document.graph().get(node)?.kind()?.outputs;
        let named = self.output.as_ref().and_then(|name| outputs.iter().find(|p| p.name == *name));
        Some(Source { node, port: named.or(outputs.first())?.name.clone() })
    }

    /// The output that the shown terrain is compared with: that of the chosen node where another node is pinned, else
    /// the one that the shown node changes.
    pub(super) fn against(&self) -> Option<Source> {
        let target = self.target().filter(|_| self.wipe.is_on)?;
        let graph = self.document.graph();
        let other = self.canvas.chosen.lone().filter(|id| *id != target.node);
        let of_chosen = other.and_then(|node| {
            let port = graph.get(node)?.kind()?.outputs.iter().find(|p| p.wire == WireType::Field)?;
            Some(Source { node, port: port.name.clone() })
        });
        let before = || {
            let input = graph.get(target.node)?.kind()?.bridge(&target.port)?;
            graph.source(target.node, input)
        };
        of_chosen.or_else(before)
    }

    fn scene(&self) -> Option<Scenery> {
        let target = self.target()?;
        let graph = self.document.graph();
        let drape = self.drape.clone().filter(|s| graph.wire_type(s).is_some());
        let size = self.map.wanted(self.map_pixels);
        let tint = self.drawing.painted(graph).filter(|s| *s != target);
        Some(Scenery { target, against: self.against(), drape, tint, size, look: self.map.look })
    }

    pub(super) fn order_contents(&self) -> Contents {
        let lit = self.view == Page::Relief && self.map.look.mode == Mode::Relief && !self.map.look.contours;
        let building = matches!(self.dialog, Dialog::Build);
        Contents {
            state: self.document.state(),
            scene: self.scene(),
            detail: self.map.closer().filter(|_| self.view == Page::Map),
            light: lit.then_some(self.relief.light),
            build: building.then(|| self.build.measured(self.document.state())),
            accepted: self.accepted_state,
        }
    }

    /// Places an order with the evaluator when its contents have changed.
    pub(super) fn send_order(&mut self) {
        let contents = self.order_contents();
        if self.last_order.as_ref() == Some(&contents) {
            return;
        }
        let Some(evaluator) = &self.evaluator else { return };
        evaluator.order(Order {
            graph: self.document.shared(),
            state: contents.state,
            scene: contents.scene.clone(),
            light: contents.light,
            detail: contents.detail,
            in_sight: self.canvas.in_sight.clone(),
            build: contents.build.clone(),
            is_cost_accepted: self.accepted_state == Some(contents.state),
        });
        self.last_order = Some(contents);
    }
}
