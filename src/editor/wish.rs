//! What the window would like to see, and the order that asks for it.

use super::app::{Editor, Page};
use super::board::{Measured, Scenery};
use super::dialogs::Dialog;
use super::evaluator::Order;
use super::shade::{Light, Mode};
use crate::graph::{NodeId, Source};
use crate::value::{Grid, WireType};

/// The last order, to see whether another is due.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ordered {
    state: u64,
    scene: Option<Scenery>,
    light: Option<Light>,
    detail: Option<Grid>,
    build: Option<Measured>,
    accepted: Option<u64>,
}

impl Editor {
    /// The node that the view shows: the pinned one, else the only chosen one, else the one before.
    pub(super) fn shown_node(&self) -> Option<NodeId> {
        let graph = self.document.graph();
        let all = [self.pinned, self.canvas.chosen.lone(), self.last];
        all.into_iter().flatten().find(|id| graph.get(*id).is_some())
    }

    /// The output that the view shows.
    pub(super) fn target(&self) -> Option<Source> {
        let node = self.shown_node()?;
        let outputs = &self.document.graph().get(node)?.kind()?.outputs;
        let named = self.output.as_ref().and_then(|name| outputs.iter().find(|p| p.name == *name));
        Some(Source { node, port: named.or(outputs.first())?.name.clone() })
    }

    /// What the shown terrain is compared with: the chosen node where another is pinned, else what goes into the shown
    /// one.
    pub(super) fn against(&self) -> Option<Source> {
        let target = self.target().filter(|_| self.wipe.on)?;
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

    pub(super) fn wish(&self) -> Ordered {
        let lit = self.view == Page::Relief && self.map.look.mode == Mode::Relief && !self.map.look.contours;
        let building = matches!(self.dialog, Dialog::Build);
        Ordered {
            state: self.document.state(),
            scene: self.scene(),
            detail: self.map.closer().filter(|_| self.view == Page::Map),
            light: lit.then_some(self.relief.light),
            build: building.then(|| self.build.measured(self.document.state())),
            accepted: self.accepted,
        }
    }

    /// Orders what the window would like to see, when that has changed.
    pub(super) fn order(&mut self) {
        let wish = self.wish();
        if self.ordered.as_ref() == Some(&wish) {
            return;
        }
        let Some(evaluator) = &self.evaluator else { return };
        evaluator.order(Order {
            graph: self.document.shared(),
            state: wish.state,
            scene: wish.scene.clone(),
            light: wish.light,
            detail: wish.detail,
            in_sight: self.canvas.in_sight.clone(),
            build: wish.build.clone(),
            whatever_it_takes: self.accepted == Some(wish.state),
        });
        self.ordered = Some(wish);
    }
}
