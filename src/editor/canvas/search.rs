//! The search for kinds. It is opened by a key, a double-click, or a wire dropped on the empty ground.

use std::sync::Arc;

use eframe::egui::{self, Key, Pos2, Rect, RichText, Ui, vec2};

use crate::editor::fuzzy;
use crate::editor::inspector::named_text;
use crate::editor::ops::End;
use crate::graph::Graph;
use crate::name::Name;
use crate::node::Kind;

/// The most kinds in the list.
const SHOWN: usize = 200;

/// An open search.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    /// The point of the screen where the search opened, and the place on the canvas for the new node.
    pub(crate) screen: Pos2,
    pub(crate) at: Pos2,
    /// The fixed end of the wire that the new node is connected to.
    pub(crate) end: Option<End>,
    query: String,
    chosen: usize,
    fresh: bool,
}

/// The outcome of a frame of the search.
pub(crate) enum SearchOutcome {
    Nothing,
    Closed,
    Kind(Arc<Kind>),
}

impl Search {
    pub(crate) fn new(screen: Pos2, at: Pos2, end: Option<End>) -> Self {
        Self { screen, at, end, query: String::new(), chosen: 0, fresh: true }
    }

    /// The kinds that fit the wire and the query, best first.
    pub(crate) fn hits(&self, graph: &Graph) -> Vec<Arc<Kind>> {
        let fits = |k: &&Arc<Kind>| self.end.as_ref().is_none_or(|end| end.port_of(graph, k).is_some());
        let query = self.query.trim();
        let score = |k: &Kind| {
            fuzzy::best(query, &k.id, k.keywords.iter().map(Name::as_str).chain([k.family.as_str()]))
        };
        let kinds = graph.registry().iter().filter(fits);
        let mut found: Vec<_> = kinds.filter_map(|k| Some((score(k)?, k))).collect();
        if query.is_empty() {
            found.sort_by(|(_, a), (_, b)| (&a.family, &a.id).cmp(&(&b.family, &b.id)));
        } else {
            found.sort_by(|(p, a), (q, b)| q.cmp(p).then_with(|| a.id.cmp(&b.id)));
        }
        found.into_iter().map(|(_, k)| k.clone()).take(SHOWN).collect()
    }

    pub(crate) fn show(&mut self, ui: &Ui, bounds: Rect, graph: &Graph) -> SearchOutcome {
        let hits = self.hits(graph);
        self.chosen = self.chosen.min(hits.len().saturating_sub(1));
        let size = vec2(340.0, 330.0);
        let corner = self.screen.min(bounds.max - size - vec2(12.0, 12.0)).max(bounds.min);
        let mut outcome = SearchOutcome::Nothing;
        let area = egui::Area::new(egui::Id::new("search for kinds"));
        let area = area.order(egui::Order::Foreground).fixed_pos(corner).show(ui.ctx(), |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(size.x);
                ui.set_height(size.y);
                outcome = self.contents(ui, &hits, graph);
            });
        });
        let elsewhere = ui.input(|i| {
            i.pointer.any_pressed()
                && i.pointer.interact_pos().is_some_and(|p| !area.response.rect.contains(p))
        });
        if elsewhere && !self.fresh && matches!(outcome, SearchOutcome::Nothing) {
            outcome = SearchOutcome::Closed;
        }
        self.fresh = false;
        outcome
    }

    fn contents(&mut self, ui: &mut Ui, hits: &[Arc<Kind>], graph: &Graph) -> SearchOutcome {
        let pressed = |key| ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, key));
        if pressed(Key::Escape) {
            return SearchOutcome::Closed;
        }
        if pressed(Key::ArrowDown) {
            self.chosen += 1;
        }
        if pressed(Key::ArrowUp) {
            self.chosen = self.chosen.saturating_sub(1);
        }
        if pressed(Key::Enter) {
            return hits.get(self.chosen).map_or(SearchOutcome::Closed, |k| SearchOutcome::Kind(k.clone()));
        }
        let hint = match (&self.end, self.end.as_ref().and_then(|end| end.wire(graph))) {
            (Some(End::From(_)), Some(wire)) => format!("What takes {}", wire.name()),
            (Some(End::To(..)), Some(wire)) => format!("What gives {}", wire.name()),
            _ => "Search nodes".to_owned(),
        };
        let edit = egui::TextEdit::singleline(&mut self.query).hint_text(hint).desired_width(f32::INFINITY);
        let edit = ui.add(edit);
        named_text(&edit, &self.query, "Search nodes");
        if self.fresh {
            edit.request_focus();
        }
        if edit.changed() {
            self.chosen = 0;
        }
        ui.separator();
        if hits.is_empty() {
            ui.weak("No kind fits. Try other words: what it does, or what it is called elsewhere.");
        }
        let scroll = egui::ScrollArea::vertical().auto_shrink([false, false]);
        scroll.show(ui, |ui| self.list(ui, hits)).inner.map_or(SearchOutcome::Nothing, SearchOutcome::Kind)
    }

    fn list(&mut self, ui: &mut Ui, hits: &[Arc<Kind>]) -> Option<Arc<Kind>> {
        let mut picked = None;
        for (i, kind) in hits.iter().enumerate() {
            let own = i == self.chosen;
            let row = ui.horizontal(|ui| {
                let name = ui.selectable_label(own, RichText::new(kind.id.as_str()).strong());
                ui.weak(kind.family.as_str());
                name
            });
            if own {
                ui.indent(("help", i), |ui| ui.label(RichText::new(kind.summary()).small()));
                if ui.input(|i| i.key_pressed(Key::ArrowDown) || i.key_pressed(Key::ArrowUp)) {
                    row.inner.scroll_to_me(None);
                }
            }
            let name = row.inner.on_hover_text(kind.summary());
            if name.clicked() {
                picked = Some(kind.clone());
            }
        }
        picked
    }
}
