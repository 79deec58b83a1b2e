//! What the view shows: a draft at once where the exact result takes long, then that, then its light, then what is
//! looked at closely.

use std::sync::Arc;

use super::{Order, Shared, Stopped, UNASKED_BYTES, lock};
use crate::context::Cancel;
use crate::editor::board::{Held, Made, NodeState, Scenery, Shown};
use crate::editor::draft::{COARSER, draft_of, preview};
use crate::editor::shade::{self, Light};
use crate::editor::watcher::Watcher;
use crate::engine::{Engine, EngineError, Want};
use crate::graph::{Graph, Source};
use crate::render::{Picture, Scene, map};
use crate::value::{Colors, Field, Grid, Quantity, Value};
use crate::work::Work;

/// Estimated seconds from which a draft is shown before the exact result.
const DRAFT_ABOVE: f64 = 0.08;
/// Estimated seconds that a draft may take; the coarsest is taken whatever it takes.
const DRAFT: f64 = 0.06;
/// Estimated seconds up to which new orders wait for a draft.
const SOON: f64 = 0.25;

/// Samples along the longer side up to which the light is soon there: views wait for it, and new orders, too.
const LIT_SOON: usize = 530;

/// What the view is made of, once it was evaluated.
#[derive(Clone)]
pub(super) struct Found {
    value: Value,
    against: Option<Value>,
    drape: Option<Value>,
    tint: Option<Value>,
    effective_cell: Option<f64>,
    /// Why something beside the value is missing.
    fault: Option<String>,
}

/// A stand-in for the exact view.
struct Draft {
    graph: Graph,
    grid: Grid,
    /// Estimated seconds.
    seconds: f64,
}

impl Shared {
    /// Makes what the view shows.
    pub(super) fn view(
        &self,
        engine: &Engine,
        order: &Order,
        scene: &Scenery,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let made = Made { state: order.state, scene: scene.clone() };
        let (stands, is_made) = {
            let board = lock(&self.board);
            (board.stands(&made, order.light), board.is_made(&made))
        };
        if stands {
            return Ok(());
        }
        let last = lock(&self.found).clone().filter(|(m, _)| is_made && *m == made);
        if let Some((_, found)) = last {
            // Only the light is another; where it is soon there, a hand that moves it sees it.
            let small = found.value.grid().is_some_and(|g| g.cols.max(g.rows) <= LIT_SOON);
            let light = || self.lit(order, Some(found), cancel);
            return if small { self.soon(light) } else { light() };
        }
        let graph = &order.graph;
        let Some(grid) = preview(graph.terrain(), scene.size) else { return Ok(()) };
        let threads = engine.pool().current_num_threads() as f64;
        let plan = engine.plan(graph, &wants(scene, grid));
        let over = engine.admit(&plan).err().map(|e| (e.to_string(), plan.peak_bytes()));
        let (seconds, unread) = (plan.seconds(), plan.unread_bytes());
        let long = (seconds > self.patience || unread > UNASKED_BYTES) && !order.whatever_it_takes;
        if over.is_some() || long {
            self.tell(|board| board.hold(Held { over, seconds, unread }));
            return Err(Stopped);
        }
        let show = |graph: &Graph, grid, draft| self.show(engine, order, scene, graph, grid, draft, cancel);
        let found = if plan.seconds() / threads <= DRAFT_ABOVE {
            self.soon(|| show(graph, grid, false))?
        } else {
            if let Some(Draft { graph, grid, seconds }) = self.draft(engine, order, scene) {
                let draft = || show(&graph, grid, true).map(drop);
                if seconds <= SOON { self.soon(draft) } else { draft() }?;
            }
            show(graph, grid, false)?
        };
        *lock(&self.found) = found.clone().map(|found| (made, found));
        self.lit(order, found, cancel)
    }

    /// The finest stand-in that is quick enough.
    fn draft(&self, engine: &Engine, order: &Order, scene: &Scenery) -> Option<Draft> {
        let threads = engine.pool().current_num_threads() as f64;
        let all = COARSER.iter().filter_map(|c| draft_of(&order.graph, scene.size, *c));
        let mut coarsest = None;
        for (graph, grid) in all {
            let seconds = engine.plan(&graph, &wants(scene, grid)).seconds() / threads;
            coarsest = Some(Draft { graph, grid, seconds });
            if seconds <= DRAFT {
                break;
            }
        }
        coarsest
    }

    /// Evaluates and shows; what could not be evaluated is told and gives nothing.
    #[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
    fn show(
        &self,
        engine: &Engine,
        order: &Order,
        scene: &Scenery,
        graph: &Graph,
        grid: Grid,
        draft: bool,
        cancel: &Cancel,
    ) -> Result<Option<Found>, Stopped> {
        let Some(found) = self.evaluate(engine, order, graph, &wants(scene, grid), scene, cancel)? else {
            return Ok(None);
        };
        let (terrain, bounds) = (graph.terrain(), graph.terrain().bounds());
        let shown = |value: &Value, range| {
            let drape = found.drape.as_ref();
            let picture = shade::picture(value, &scene.look, range, drape, terrain, cancel);
            let picture = shade::tinted(picture.map_err(|_| Stopped)?, found.tint.as_ref());
            let (picture, effective_cell) = (Arc::new(picture), found.effective_cell);
            Ok(Shown { id: Shown::next_id(), value: value.clone(), picture, draft, effective_cell, bounds })
        };
        let main = shown(&found.value, None)?;
        // Two of a kind that are compared have their colours from one range.
        let like = |v: &Value| v.quantity() == found.value.quantity();
        let range = |v: &Value| value_range(&found.value).filter(|_| like(v));
        let against = found.against.as_ref().map(|v| shown(v, range(v))).transpose()?;
        let made = (!draft).then_some(Made { state: order.state, scene: scene.clone() });
        // Where the light is soon there, the picture comes with it and not before it.
        let small = grid.cols.max(grid.rows) <= LIT_SOON;
        let lit = order.light.filter(|_| small).map(|light| pictures(&found, light, cancel)).transpose()?;
        self.tell(|board| {
            board.show(scene.clone(), main, against, made);
            if let (Some(light), Some(lit)) = (order.light, lit) {
                board.take_light(light, lit);
            }
            if let Some(fault) = &found.fault {
                board.view_fails(order.state, fault.clone());
            }
        });
        Ok(Some(found))
    }

    fn evaluate(
        &self,
        engine: &Engine,
        order: &Order,
        graph: &Graph,
        wants: &[Want],
        scene: &Scenery,
        cancel: &Cancel,
    ) -> Result<Option<Found>, Stopped> {
        let tell = |node, state| self.tell(|board| board.node(node, state));
        let watch = Watcher::new(graph, &tell);
        let evaluation = match engine.evaluate(graph, wants, &watch, cancel) {
            Ok(evaluation) => evaluation,
            Err(EngineError::Cancelled) => return Err(Stopped),
            Err(other) => {
                self.tell(|board| board.view_fails(order.state, other.to_string()));
                return Ok(None);
            }
        };
        let effective_cell = evaluation.effective_cells.first().copied().flatten();
        let (mut values, mut fault) = (Vec::new(), None);
        for value in evaluation.values {
            match value {
                Ok(value) => values.push(Some(value)),
                Err(failure) => {
                    let at = failure.node().and_then(|name| graph.find(name));
                    self.tell(|board| {
                        if let Some(node) = at {
                            board.node(node, NodeState::Failed(failure.to_string()));
                        }
                        board.view_fails(order.state, failure.to_string());
                    });
                    fault = Some(failure.to_string());
                    values.push(None);
                }
            }
        }
        let mut values = values.into_iter();
        let Some(value) = values.next().flatten() else { return Ok(None) };
        let mut next = |wanted: &Option<Source>| wanted.as_ref().and_then(|_| values.next().flatten());
        let [against, drape, tint] = [&scene.against, &scene.drape, &scene.tint].map(&mut next);
        Ok(Some(Found { value, against, drape, tint, effective_cell, fault }))
    }

    /// Makes the pictures under sun and sky of what is shown, where they are not there yet.
    fn lit(&self, order: &Order, found: Option<Found>, cancel: &Cancel) -> Result<(), Stopped> {
        let (Some(light), Some(found)) = (order.light, found) else { return Ok(()) };
        if lock(&self.board).is_lit(light) {
            return Ok(());
        }
        let lit = pictures(&found, light, cancel)?;
        self.tell(|board| board.take_light(light, lit));
        Ok(())
    }

    /// Makes the part that is looked at closely.
    pub(super) fn detail(
        &self,
        engine: &Engine,
        order: &Order,
        scene: &Scenery,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let Some(grid) = order.detail else { return Ok(()) };
        let whole = lock(&self.board).shown.as_ref().and_then(|s| value_range(&s.value));
        let Some(range) = whole else { return Ok(()) };
        let alone = Scenery { against: None, ..scene.clone() };
        let wants = wants(&alone, grid);
        let plan = engine.plan(&order.graph, &wants);
        if engine.admit(&plan).is_err()
            || plan.seconds() > self.patience
            || plan.unread_bytes() > UNASKED_BYTES
        {
            return Ok(());
        }
        let tell = |node, state| self.tell(|board| board.node(node, state));
        let watch = Watcher::new(&order.graph, &tell);
        let evaluation = match engine.evaluate(&order.graph, &wants, &watch, cancel) {
            Ok(evaluation) => evaluation,
            Err(_) if cancel.is_cancelled() => return Err(Stopped),
            // The whole view stays.
            Err(_) => return Ok(()),
        };
        let effective_cell = evaluation.effective_cells.first().copied().flatten();
        let mut values = evaluation.values.into_iter().map(Result::ok);
        let Some(value) = values.next().flatten() else { return Ok(()) };
        let [drape, tint] =
            [&scene.drape, &scene.tint].map(|s| s.as_ref().and_then(|_| values.next().flatten()));
        let terrain = order.graph.terrain();
        let picture = shade::picture(&value, &scene.look, Some(range), drape.as_ref(), terrain, cancel);
        let picture = shade::tinted(picture.map_err(|_| Stopped)?, tint.as_ref());
        let (picture, bounds) = (Arc::new(picture), terrain.bounds());
        let shown = Shown { id: Shown::next_id(), value, picture, draft: false, effective_cell, bounds };
        self.tell(|board| board.refine(shown));
        Ok(())
    }
}

/// What a view needs: what it shows, what that is compared with, what colours it, what is painted over it.
fn wants(scene: &Scenery, grid: Grid) -> Vec<Want> {
    let others = [&scene.against, &scene.drape, &scene.tint].into_iter().flatten();
    let all = std::iter::once(&scene.target).chain(others);
    all.map(|s| Want { node: s.node, port: s.port.clone(), grid }).collect()
}

/// The pictures under sun and sky of what is shown and of what it is compared with; none where it is no height.
fn pictures(
    found: &Found,
    light: Light,
    cancel: &Cancel,
) -> Result<Option<(Picture, Option<Picture>)>, Stopped> {
    let under = |value: &Value| {
        let picture = under(value, found.drape.as_ref(), light, cancel)?;
        Ok(picture.map(|p| shade::tinted(p, found.tint.as_ref())))
    };
    let Some(picture) = under(&found.value)? else { return Ok(None) };
    let against = found.against.as_ref().map(under).transpose()?.flatten();
    Ok(Some((picture, against)))
}

/// The picture of heights under a light; none of what is no height.
fn under(
    value: &Value,
    drape: Option<&Value>,
    light: Light,
    cancel: &Cancel,
) -> Result<Option<Picture>, Stopped> {
    let Some(height) = field_to_light(value) else { return Ok(None) };
    let colors = drape.and_then(|d| shade::colors(d, height.grid(), cancel));
    let color: Option<&Colors> = colors.as_ref();
    // The water is drawn by the view itself.
    let scene = Scene { color, sun: light.sun(), ..Scene::new(height) };
    match map(&scene, None, &Work::new(cancel)) {
        Ok(picture) => Ok(Some(picture)),
        Err(_) if cancel.is_cancelled() => Err(Stopped),
        // The quick picture stays.
        Err(_) => Ok(None),
    }
}

/// The heights of a value that can be lit.
fn field_to_light(value: &Value) -> Option<&Field> {
    match value {
        Value::Field(f) if f.quantity() == Quantity::Elevation && f.grid().cols > 1 && f.grid().rows > 1 => {
            Some(f)
        }
        _ => None,
    }
}

pub(super) fn value_range(value: &Value) -> Option<(f32, f32)> {
    match value {
        Value::Field(field) => field.range(),
        _ => None,
    }
}
