//! The evaluation of the view, in this order: a draft where the exact result takes long, the exact result, its picture
//! under a light, and the part that the user has zoomed in to.

use std::sync::Arc;

use super::{Order, Shared, Stopped, UNASKED_BYTES, lock};
use crate::context::Cancel;
use crate::editor::board::{Board, NodeState, Scenery, Shown, Unstarted, ViewContents};
use crate::editor::draft::{COARSER, draft_of, preview};
use crate::editor::node_progress::{NodeProgress, Watched};
use crate::editor::shade::{self, Light};
use crate::engine::{Engine, EngineError, Want};
use crate::graph::{Graph, Source};
use crate::render::{Picture, Scene, map};
use crate::value::{Colors, Field, Grid, Quantity, Value};
use crate::work::Work;

/// Estimated seconds of the exact result above which a draft is shown first.
const DRAFT_ABOVE: f64 = 0.08;
/// Estimated seconds that a draft may take; the coarsest draft is used even if it takes longer.
const DRAFT: f64 = 0.06;
/// Estimated seconds up to which a draft is not cancelled by a new order.
const UNINTERRUPTED: f64 = 0.25;

/// Samples along the longer side up to which shading is so quick that views and new orders wait for it.
const QUICKLY_LIT: usize = 530;

/// The values of a view.
#[derive(Clone)]
pub(super) struct Evaluated {
    value: Value,
    against: Option<Value>,
    drape: Option<Value>,
    tint: Option<Value>,
    effective_cell: Option<f64>,
    /// Why one of the other values is missing.
    fault: Option<String>,
}

/// A coarser graph and grid, whose result stands in for the exact one.
struct Draft {
    graph: Graph,
    grid: Grid,
    /// Estimated seconds.
    seconds: f64,
}

impl Shared {
    /// Evaluates and shows the scene of an order, unless the board shows it already.
    pub(super) fn view(
        &self,
        engine: &Engine,
        order: &Order,
        scene: &Scenery,
        cancel: &Cancel,
    ) -> Result<(), Stopped> {
        let contents = ViewContents { state: order.state, scene: scene.clone() };
        let (is_current, shows) = {
            let board = lock(&self.board);
            (board.is_current(&contents, order.light), board.shows(&contents))
        };
        if is_current {
            return Ok(());
        }
        let last = lock(&self.evaluated).clone().filter(|(m, _)| shows && *m == contents);
        if let Some((_, evaluated)) = last {
            // Only the light has changed. Quick shading is not cancelled, so that the view follows the sun as it is
            // moved.
            let small = evaluated.value.grid().is_some_and(|g| g.cols.max(g.rows) <= QUICKLY_LIT);
            let light = || self.lit(order, Some(evaluated), cancel);
            return if small { self.uninterrupted(light) } else { light() };
        }
        let graph = &order.graph;
        let Some(grid) = preview(graph.terrain(), scene.size) else { return Ok(()) };
        let threads = engine.pool().current_num_threads() as f64;
        let plan = engine.plan(graph, &wants(scene, grid));
        let over_budget = engine.admit(&plan).err().map(|e| (e.to_string(), plan.peak_bytes()));
        let (seconds, unread) = (plan.seconds(), plan.unread_bytes());
        let long = (seconds > self.patience || unread > UNASKED_BYTES) && !order.is_cost_accepted;
        if over_budget.is_some() || long {
            self.tell(|board| board.refuse(Unstarted { over_budget, seconds, unread }));
            return Err(Stopped);
        }
        let show =
            |graph: &Graph, grid, is_draft| self.show(engine, order, scene, graph, grid, is_draft, cancel);
        let evaluated = if plan.seconds() / threads <= DRAFT_ABOVE {
            self.uninterrupted(|| show(graph, grid, false))?
        } else {
            if let Some(Draft { graph, grid, seconds }) = self.draft(engine, order, scene) {
                let draft = || show(&graph, grid, true).map(drop);
                if seconds <= UNINTERRUPTED { self.uninterrupted(draft) } else { draft() }?;
            }
            show(graph, grid, false)?
        };
        *lock(&self.evaluated) = evaluated.clone().map(|evaluated| (contents, evaluated));
        self.lit(order, evaluated, cancel)
    }

    /// The finest draft that is quick enough, or the coarsest one.
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

    /// Evaluates a scene on a grid and shows it. Returns `None` where the evaluation failed, which the board then says.
    #[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
    fn show(
        &self,
        engine: &Engine,
        order: &Order,
        scene: &Scenery,
        graph: &Graph,
        grid: Grid,
        is_draft: bool,
        cancel: &Cancel,
    ) -> Result<Option<Evaluated>, Stopped> {
        let frame = Frame { scene, graph, is_draft, cancel };
        let state = |value: Value| self.show_state(&frame, value);
        let watched = (!is_draft).then_some(Watched {
            node: scene.target.node,
            port: &scene.target.port,
            take: &state,
        });
        let wants = wants(scene, grid);
        let Some(evaluated) = self.evaluate(engine, order, graph, &wants, scene, watched, cancel)? else {
            return Ok(None);
        };
        let shown = |value: &Value, range| frame.shown(value, range, Some(&evaluated));
        let main = shown(&evaluated.value, None)?;
        // Two values of one quantity are compared in colours of one range.
        let like = |v: &Value| v.quantity() == evaluated.value.quantity();
        let range = |v: &Value| value_range(&evaluated.value).filter(|_| like(v));
        let against = evaluated.against.as_ref().map(|v| shown(v, range(v))).transpose()?;
        let contents = (!is_draft).then_some(ViewContents { state: order.state, scene: scene.clone() });
        // Where shading is quick, the view shows the shaded picture at once and no plain one before it.
        let small = grid.cols.max(grid.rows) <= QUICKLY_LIT;
        let lit =
            order.light.filter(|_| small).map(|light| pictures(&evaluated, light, cancel)).transpose()?;
        self.tell(|board| {
            board.show(scene.clone(), main, against, contents);
            if let (Some(light), Some(lit)) = (order.light, lit) {
                board.set_lit(light, lit);
            }
            if let Some(fault) = &evaluated.fault {
                board.fail_view(order.state, fault.clone());
            }
        });
        Ok(Some(evaluated))
    }

    /// Shows the output of a node that still runs, unless the board shows a finer draft of it.
    fn show_state(&self, frame: &Frame<'_>, value: Value) {
        let columns = |value: &Value| value.grid().map_or(0, |grid| grid.cols);
        let is_behind = |board: &Board| {
            board.draft_of(frame.scene).is_none_or(|draft| columns(&draft.value) < columns(&value))
        };
        if !is_behind(&lock(&self.board)) {
            return;
        }
        let Ok(shown) = (Frame { is_draft: true, ..*frame }).shown(&value, None, None) else { return };
        self.tell(|board| board.show(frame.scene.clone(), shown, None, None));
    }

    #[allow(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
    fn evaluate(
        &self,
        engine: &Engine,
        order: &Order,
        graph: &Graph,
        wants: &[Want],
        scene: &Scenery,
        watched: Option<Watched<'_>>,
        cancel: &Cancel,
    ) -> Result<Option<Evaluated>, Stopped> {
        let tell = |node, state| self.tell(|board| board.set_node(node, state));
        let progress = NodeProgress::new(graph, &tell).watching(watched);
        let evaluation = match engine.evaluate(graph, wants, &progress, cancel) {
            Ok(evaluation) => evaluation,
            Err(EngineError::Cancelled) => return Err(Stopped),
            Err(other) => {
                self.tell(|board| board.fail_view(order.state, other.to_string()));
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
                            board.set_node(node, NodeState::Failed(failure.to_string()));
                        }
                        board.fail_view(order.state, failure.to_string());
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
        Ok(Some(Evaluated { value, against, drape, tint, effective_cell, fault }))
    }

    /// Makes the shaded pictures of the view, unless the board has them.
    fn lit(&self, order: &Order, evaluated: Option<Evaluated>, cancel: &Cancel) -> Result<(), Stopped> {
        let (Some(light), Some(evaluated)) = (order.light, evaluated) else { return Ok(()) };
        if lock(&self.board).is_lit(light) {
            return Ok(());
        }
        let lit = pictures(&evaluated, light, cancel)?;
        self.tell(|board| board.set_lit(light, lit));
        Ok(())
    }

    /// Evaluates and shows the part that the user has zoomed in to.
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
        let tell = |node, state| self.tell(|board| board.set_node(node, state));
        let progress = NodeProgress::new(&order.graph, &tell);
        let evaluation = match engine.evaluate(&order.graph, &wants, &progress, cancel) {
            Ok(evaluation) => evaluation,
            Err(_) if cancel.is_cancelled() => return Err(Stopped),
            // The view keeps the picture of the whole terrain.
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
        let shown = Shown { id: Shown::next_id(), value, picture, is_draft: false, effective_cell, bounds };
        self.tell(|board| board.show_detail(shown));
        Ok(())
    }
}

/// What a value is shown in.
#[derive(Clone, Copy)]
struct Frame<'a> {
    scene: &'a Scenery,
    graph: &'a Graph,
    is_draft: bool,
    cancel: &'a Cancel,
}

impl Frame<'_> {
    /// A value with its picture, in colours of a range if there is one, under what was evaluated with it.
    fn shown(
        &self,
        value: &Value,
        range: Option<(f32, f32)>,
        with: Option<&Evaluated>,
    ) -> Result<Shown, Stopped> {
        let terrain = self.graph.terrain();
        let drape = with.and_then(|evaluated| evaluated.drape.as_ref());
        let picture = shade::picture(value, &self.scene.look, range, drape, terrain, self.cancel);
        let tint = with.and_then(|evaluated| evaluated.tint.as_ref());
        let picture = Arc::new(shade::tinted(picture.map_err(|_| Stopped)?, tint));
        let effective_cell = with.and_then(|evaluated| evaluated.effective_cell);
        let (is_draft, bounds) = (self.is_draft, terrain.bounds());
        Ok(Shown { id: Shown::next_id(), value: value.clone(), picture, is_draft, effective_cell, bounds })
    }
}

/// The outputs of a scene on a grid, in the order target, comparison, drape, tint.
fn wants(scene: &Scenery, grid: Grid) -> Vec<Want> {
    let others = [&scene.against, &scene.drape, &scene.tint].into_iter().flatten();
    let all = std::iter::once(&scene.target).chain(others);
    all.map(|s| Want { node: s.node, port: s.port.clone(), grid }).collect()
}

/// The shaded pictures of the target and of the value it is compared with; `None` where the target is no height.
fn pictures(
    evaluated: &Evaluated,
    light: Light,
    cancel: &Cancel,
) -> Result<Option<(Picture, Option<Picture>)>, Stopped> {
    let under = |value: &Value| {
        let picture = under(value, evaluated.drape.as_ref(), light, cancel)?;
        Ok(picture.map(|p| shade::tinted(p, evaluated.tint.as_ref())))
    };
    let Some(picture) = under(&evaluated.value)? else { return Ok(None) };
    let against = evaluated.against.as_ref().map(under).transpose()?.flatten();
    Ok(Some((picture, against)))
}

/// The shaded picture of a value; `None` where it is no height.
fn under(
    value: &Value,
    drape: Option<&Value>,
    light: Light,
    cancel: &Cancel,
) -> Result<Option<Picture>, Stopped> {
    let Some(height) = field_to_light(value) else { return Ok(None) };
    let colors = drape.and_then(|d| shade::colors(d, height.grid(), cancel));
    let color: Option<&Colors> = colors.as_ref();
    // The view draws the water itself.
    let scene = Scene { color, sun: light.sun(), ..Scene::new(height) };
    match map(&scene, None, &Work::new(cancel)) {
        Ok(picture) => Ok(Some(picture)),
        Err(_) if cancel.is_cancelled() => Err(Stopped),
        // The view keeps the plain picture.
        Err(_) => Ok(None),
    }
}

/// The heights of a value, where it has some and at least 2 × 2 samples.
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
