//! The end of gestures: what lies under the pointer when the button is released.

use std::collections::BTreeMap;

use eframe::egui::{Color32, Stroke, StrokeKind, Ui, vec2};

use super::camera::Viewport;
use super::gesture::Gesture;
use super::layout::Layout;
use super::search::Search;
use super::wire::Course;
use super::{Canvas, CanvasContext, paint, wires};
use crate::editor::ops::{self, End};
use crate::editor::theme;
use crate::graph::{Graph, NodeId, Problem};
use crate::name::Name;
use crate::ports::Port;

/// Distance within which the pointer is on a port, in points of the screen.
const NEAR: f32 = 16.0;

/// The wire that would be made if the button were released now.
struct Landing {
    /// The output's node and port, then the input's.
    wire: (NodeId, Name, NodeId, Name),
    fits: Result<(), Problem>,
}

impl Canvas {
    /// Draws the gesture in progress over everything else.
    pub(super) fn overlay(
        &self,
        ui: &Ui,
        view: &Viewport,
        layouts: &BTreeMap<NodeId, Layout>,
        courses: &[Course],
        cx: &CanvasContext<'_>,
    ) {
        match &self.gesture {
            Gesture::Box { from, .. } => {
                let area = view.rect(eframe::egui::Rect::from_two_pos(*from, self.pointer));
                ui.painter().rect_filled(area, 0.0, theme::CHOSEN.gamma_multiply(0.08));
                ui.painter().rect_stroke(area, 0.0, Stroke::new(1.0, theme::CHOSEN), StrokeKind::Inside);
            }
            Gesture::Wire { end, .. } => self.wire_in_hand(ui, view, layouts, end, cx),
            Gesture::Move { .. } => {
                if let Some(course) = self.wire_below(view, courses, cx.graph()) {
                    let stroke = Stroke::new(4.0, theme::CHOSEN);
                    ui.painter().extend(super::wire::shapes(&course.points, view, stroke));
                }
            }
            _ => (),
        }
        if let Some(search) = &self.search
            && let Some(end) = &search.end
            && let Some((from, forward)) = port_of(end, layouts)
        {
            let points = if forward { [from, search.at] } else { [search.at, from] };
            let stroke = Stroke::new(2.0, Color32::from_white_alpha(120));
            ui.painter().extend(super::wire::shapes(&points, view, stroke));
        }
    }

    fn wire_in_hand(
        &self,
        ui: &Ui,
        view: &Viewport,
        layouts: &BTreeMap<NodeId, Layout>,
        end: &End,
        cx: &CanvasContext<'_>,
    ) {
        let Some((from, forward)) = port_of(end, layouts) else { return };
        let color = end.wire(cx.graph()).map_or(Color32::GRAY, theme::wire_color);
        let landing = self.landing(view, layouts, end, cx.graph());
        match landing.map(|l| l.fits) {
            Some(Err(problem)) => {
                self.pulled(ui, view, from, forward, theme::ERROR);
                let at = view.pos(self.pointer) + vec2(16.0, 16.0);
                paint::bubble(ui, at, &problem.to_string(), theme::ERROR);
            }
            Some(Ok(())) => self.pulled(ui, view, from, forward, theme::CHOSEN),
            None => self.pulled(ui, view, from, forward, color),
        }
    }

    /// The port or node under the pointer that the dragged wire would be connected to.
    fn landing(
        &self,
        view: &Viewport,
        layouts: &BTreeMap<NodeId, Layout>,
        end: &End,
        graph: &Graph,
    ) -> Option<Landing> {
        let reach = NEAR / view.zoom();
        let pins = layouts.iter().flat_map(|(id, l)| {
            let pins = if matches!(end, End::From(_)) { &l.inputs } else { &l.outputs };
            pins.iter().map(move |(port, at)| (at.distance(self.pointer), *id, &port.name))
        });
        let near = pins.filter(|(away, ..)| *away < reach).min_by(|a, b| a.0.total_cmp(&b.0));
        let (id, port) = match near {
            Some((_, id, port)) => (id, port.clone()),
            None => self.body(layouts, end, graph)?,
        };
        let wire = match end {
            End::From(source) => (source.node, source.port.clone(), id, port),
            End::To(node, input) => (id, port, *node, input.clone()),
        };
        let fits = graph.can_connect(wire.0, &wire.1, wire.2, &wire.3);
        Some(Landing { wire, fits })
    }

    /// The node whose body is under the pointer, with the port that fits best; free ports come before those in use.
    fn body(&self, layouts: &BTreeMap<NodeId, Layout>, end: &End, graph: &Graph) -> Option<(NodeId, Name)> {
        let (&id, _) = layouts.iter().rev().find(|(_, l)| l.rect.contains(self.pointer))?;
        let own = match end {
            End::From(source) => source.node,
            End::To(node, _) => *node,
        };
        let kind = graph.get(id).filter(|_| id != own)?.kind()?;
        let wire = end.wire(graph)?;
        let free = |p: &&Port| graph.source(id, &p.name).is_none();
        let port = match end {
            End::From(_) => {
                let fitting = || kind.inputs.iter().filter(|p| p.wire == wire);
                fitting().find(free).or_else(|| fitting().next()).or_else(|| kind.inputs.first())
            }
            End::To(..) => kind.outputs.iter().find(|p| p.wire == wire).or(kind.outputs.first()),
        };
        Some((id, port?.name.clone()))
    }

    /// The wire into which the node that is being moved would be inserted at its present place.
    fn wire_below<'a>(&self, view: &Viewport, courses: &'a [Course], graph: &Graph) -> Option<&'a Course> {
        let Gesture::Move { nodes, .. } = &self.gesture else { return None };
        let (Some(&id), 1) = (nodes.iter().next(), nodes.len()) else { return None };
        let lonely = graph.inputs(id).next().is_none() && graph.consumers(id).next().is_none();
        let (course, _) = wires::under(courses, view, self.pointer).filter(|_| lonely)?;
        ops::between(graph, id, &course.source, course.to).map(|_| course)
    }

    /// Ends the gesture when the button is released.
    pub(super) fn finish(
        &mut self,
        ui: &Ui,
        view: &Viewport,
        layouts: &BTreeMap<NodeId, Layout>,
        courses: &[Course],
        cx: &mut CanvasContext<'_>,
    ) {
        let (down, escape) =
            ui.input(|i| (i.pointer.primary_down(), i.key_pressed(eframe::egui::Key::Escape)));
        if escape {
            self.gesture = Gesture::None;
        }
        if down {
            return;
        }
        let below = self.wire_below(view, courses, cx.graph()).cloned();
        match std::mem::take(&mut self.gesture) {
            Gesture::None | Gesture::Box { .. } => (),
            Gesture::Move { by, nodes, notes, .. } => {
                let by = [f64::from(by.x), f64::from(by.y)];
                let label =
                    if nodes.len() > 1 { format!("Move {} nodes", nodes.len()) } else { "Move".into() };
                cx.edit(&label, |g| {
                    ops::shift(g, &nodes, &notes, by)?;
                    match (below, nodes.first()) {
                        (Some(c), Some(&id)) => ops::insert(g, id, &c.source, c.to, &c.input),
                        _ => Ok(()),
                    }
                });
            }
            Gesture::Wire { end, taken } => {
                let landing = self.landing(view, layouts, &end, cx.graph());
                self.land(view, end, taken, landing, cx);
            }
            Gesture::Bend { node, input, index } => {
                let at = self.snapped(self.pointer);
                let mut bends = cx.graph().bends(node, &input).to_vec();
                if let Some(bend) = bends.get_mut(index) {
                    *bend = [f64::from(at.x), f64::from(at.y)];
                }
                cx.edit("Move bend", |g| g.set_bends(node, &input, bends));
            }
            Gesture::Resize { name, size } => {
                let Some(note) = cx.graph().note(&name).cloned() else { return };
                let size = [f64::from(size.x), f64::from(size.y)];
                cx.edit("Resize note", |g| g.change_note(&name, crate::graph::Note { size, ..note }));
            }
        }
    }

    fn land(
        &mut self,
        view: &Viewport,
        end: End,
        taken: Option<(NodeId, Name)>,
        landing: Option<Landing>,
        cx: &mut CanvasContext<'_>,
    ) {
        match landing {
            Some(Landing { wire: (from, output, to, input), fits: Ok(()) }) => {
                if taken.as_ref() == Some(&(to, input.clone())) {
                    return;
                }
                cx.edit("Connect", |g| {
                    if let Some((node, old)) = taken {
                        g.disconnect(node, &old)?;
                    }
                    g.connect(from, &output, to, &input)
                });
            }
            Some(Landing { fits: Err(problem), .. }) => cx.notices.problem(&problem),
            None => match taken {
                Some((node, input)) => _ = cx.edit("Cut wire", |g| g.disconnect(node, &input)),
                None => self.search = Some(Search::new(view.pos(self.pointer), self.pointer, Some(end))),
            },
        }
    }
}

/// The place of the port at the fixed end of a wire, and whether this is an output.
fn port_of(end: &End, layouts: &BTreeMap<NodeId, Layout>) -> Option<(eframe::egui::Pos2, bool)> {
    match end {
        End::From(source) => Some((layouts.get(&source.node)?.output(&source.port)?, true)),
        End::To(node, input) => Some((layouts.get(node)?.input(input)?, false)),
    }
}
