//! Drawing on the terrain: curves, lines through points and masks, in the map and in the relief.
//!
//! A drawing is a parameter of the one chosen node ([`sheet`]). Every stroke is a change of the document like any
//! other, so that undo, recovery and evaluation need nothing of their own. A view provides a [`Space`], which converts
//! between places of the world and points of the screen. The state here is the tool, the selection and the gesture in
//! progress.

mod brush;
mod change;
mod curves;
mod grip;
mod menu;
mod paint;
mod pen;
pub(crate) mod sheet;

pub(crate) use paint::plain as plain_lines;

use eframe::egui::{self, Id, Key, Modifiers, Pos2, Rect, Response, Ui};

use super::document::Document;
use super::notices::Notices;
use super::ops;
use crate::graph::NodeId;
use crate::kit::math::decade;
use crate::kit::paint::Stroke;
use crate::value::Curve;
use grip::Part;
use sheet::Sheet;

/// The conversion between places of the world and points of the screen in a view.
pub(crate) trait Space {
    /// The point of the screen that shows a place (east, south, up; metres); `None` behind the eye.
    fn screen(&self, at: [f64; 3]) -> Option<Pos2>;
    /// The place at a given height that a point of the screen shows.
    fn level(&self, pos: Pos2, height: f64) -> Option<[f64; 2]>;
    /// The place on the ground that a point of the screen shows.
    fn ground(&self, pos: Pos2) -> Option<[f64; 2]>;
    /// Height of the ground at a place, in metres.
    fn height(&self, at: [f64; 2]) -> f64;
    /// Metres of height in a pixel upwards, at a place.
    fn rise(&self, at: [f64; 3]) -> f64;
    /// Metres in a pixel sideways, at a place.
    fn across(&self, at: [f64; 3]) -> f64;
    /// Whether the ground hides a place.
    fn hides(&self, at: [f64; 3]) -> bool;
    /// Whether the view is from straight above, so that the height of a place does not change its point.
    fn is_flat(&self) -> bool;
    /// The height between the lowest and the highest ground, in metres.
    fn relief(&self) -> f64;
}

/// What the primary button does on the ground of a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
    /// Chooses and moves existing curves.
    #[default]
    Select,
    /// Draws new curves.
    Draw,
    /// Paints with the brush.
    Brush,
}

/// What drawing borrows for a frame.
pub(crate) struct DrawingContext<'a> {
    pub(crate) document: &'a mut Document,
    pub(crate) notices: &'a mut Notices,
    /// The node whose parameter is drawn.
    pub(crate) node: Option<NodeId>,
}

/// The state of drawing.
#[derive(Default)]
pub(crate) struct Drawing {
    pub(crate) tool: Tool,
    /// The brush: a stroke without points.
    pub(crate) brush: Stroke,
    /// The chosen curve.
    pub(crate) curve: Option<usize>,
    /// The chosen constraint point of the chosen curve.
    pub(crate) point: Option<usize>,
    /// The chosen control point of the chosen curve.
    anchor: Option<usize>,
    grab: Option<Grab>,
    /// The state of the document after the last movement of the grab. In any other state, something else has changed
    /// the document.
    written_state: Option<u64>,
    trace: Option<Trace>,
    /// The first point of a new curve that has no second point yet.
    start: Option<[f64; 2]>,
    /// Whether the pointer is on the chosen curve.
    is_hovered: bool,
    /// Whether the last press of a button was in the view, so that keys go to the drawing.
    receives_keys: bool,
    /// Whether the delete key has removed something since the last press of a button. A key that is held down would
    /// otherwise go on to remove the curve and then the node.
    has_deleted: bool,
    parsed: Option<Parsed>,
    /// The place where the right button was pressed, for the menu.
    menu: Option<menu::Spot>,
}

/// A part that is being dragged.
struct Grab {
    part: Part,
    /// The drawing and the curve before the drag.
    sheet: Sheet,
    curve: Curve,
    /// The places of the part and of the pointer before the drag.
    at: [f64; 3],
    from: Pos2,
}

/// A line that is drawn while the button is down.
struct Trace {
    /// The drawing before the line.
    sheet: Sheet,
    points: Vec<[f64; 2]>,
    /// The number of points that were written to the document.
    written: usize,
}

/// The drawing as parsed from a state of the document.
struct Parsed {
    state: u64,
    node: NodeId,
    param: String,
    sheet: Sheet,
    curves: Vec<Option<Curve>>,
}

impl Drawing {
    /// Whether the primary button acts on the drawing and not on the view.
    pub(crate) fn takes_primary_button(&self) -> bool {
        self.parsed.is_some() && (self.grab.is_some() || self.tool != Tool::Select || self.is_hovered)
    }

    /// The drawing of the chosen node, where it has one.
    pub(crate) fn sheet(&self) -> Option<&Sheet> {
        self.parsed.as_ref().map(|k| &k.sheet)
    }

    /// Parses the drawing of the chosen node, where the document or the choice of the node has changed.
    pub(crate) fn read(&mut self, cx: &DrawingContext<'_>) {
        let state = cx.document.state();
        if self.parsed.as_ref().is_some_and(|k| k.state == state && Some(k.node) == cx.node) {
            return;
        }
        let found = cx.node.and_then(|id| Some((id, Sheet::of(cx.document.graph(), id)?)));
        let Some((node, (param, sheet))) = found else {
            let receives_keys = self.receives_keys;
            self.forget();
            self.receives_keys = receives_keys;
            return;
        };
        let mut old = self.parsed.take().filter(|k| k.node == node);
        if old.is_none() {
            (self.tool, self.curve, self.point, self.anchor) = (Tool::Select, None, None, None);
            (self.grab, self.trace, self.start) = (None, None, None);
        }
        // Building a curve takes time, so that unchanged curves are taken over.
        let mut curve = |i: usize| match &mut old {
            Some(old) if old.sheet.spec(i).is_some() && old.sheet.spec(i) == sheet.spec(i) => {
                old.curves.get_mut(i).and_then(Option::take)
            }
            _ => sheet.build(i),
        };
        let curves: Vec<_> = (0..sheet.len()).map(&mut curve).collect();
        self.curve = self.curve.filter(|i| *i < curves.len());
        let points = self.curve.and_then(|i| curves[i].as_ref()).map_or(0, |c| c.points().len());
        self.point = self.point.filter(|k| *k < points);
        let anchors = self.curve.map_or(0, |i| sheet.places(i).len());
        self.anchor = self.anchor.filter(|k| *k < anchors);
        if matches!(sheet, Sheet::Trail(_)) {
            self.curve = Some(0);
        }
        self.parsed = Some(Parsed { state, node, param, sheet, curves });
    }

    /// Paints the drawing over a view and handles its input; `ground` is the response of the whole view.
    pub(crate) fn show(
        &mut self,
        ui: &Ui,
        space: &dyn Space,
        ground: &Response,
        cx: &mut DrawingContext<'_>,
    ) {
        if ui.input(|i| i.pointer.any_pressed()) {
            let at = ui.input(|i| i.pointer.interact_pos());
            self.receives_keys = at.is_some_and(|p| ground.rect.contains(p)) && ground.contains_pointer();
            self.has_deleted = false;
        }
        self.read(cx);
        let Some(parsed) = &self.parsed else { return };
        let step = step(cx);
        let hint = match self.tool {
            Tool::Select => "",
            Tool::Draw => "Click for each point, or drag freely; double-click, Enter or Esc ends",
            Tool::Brush => "Drag paints, with Alt it erases; [ and ] change the radius, Esc ends",
        };
        paint::hint(ui, hint);
        match parsed.sheet {
            Sheet::Strokes(_) => self.brushing(ui, space, ground, cx, step),
            _ => self.curving(ui, space, ground, cx, step),
        }
    }

    /// Writes a drawing to the document; returns whether the change was accepted.
    fn write(&self, cx: &mut DrawingContext<'_>, label: &str, gesture: Option<&str>, sheet: &Sheet) -> bool {
        let Some(Parsed { node, param, state, sheet: before, .. }) = &self.parsed else { return false };
        let node = *node;
        let is_exposed = ops::exposed_as(cx.document.graph(), node, param).is_some();
        let (path, value) = if is_exposed || *state != cx.document.state() {
            (param.clone(), sheet.json())
        } else {
            sheet.change(before, param)
        };
        let change = |graph: &mut crate::graph::Graph| ops::set(graph, &[node], &path, value);
        let done = match gesture {
            Some(gesture) => cx.document.gesture(label, gesture, change),
            None => cx.document.edit(label, change),
        };
        match done {
            Ok(()) => true,
            Err(problem) => {
                cx.notices.problem(&problem);
                false
            }
        }
    }

    /// Removes the chosen part or curve. Returns false where the key is not for the drawing.
    pub(crate) fn delete(&mut self, cx: &mut DrawingContext<'_>) -> bool {
        self.read(cx);
        let applies = self.parsed.is_some() && self.receives_keys;
        if applies && (self.has_deleted || self.grab.is_some()) {
            return true;
        }
        self.has_deleted = applies && self.remove_chosen(cx);
        self.has_deleted
    }

    /// Resets everything but the brush, when the document is replaced.
    pub(crate) fn forget(&mut self) {
        *self = Self { brush: self.brush.clone(), ..Self::default() };
    }

    /// Ends the tool and its gesture.
    pub(crate) fn end_tool(&mut self) {
        (self.tool, self.start, self.trace, self.grab) = (Tool::Select, None, None, None);
    }
}

/// The step to which coordinates are rounded, in metres: a decimal power far below what is visible, at most 1 m.
fn step(cx: &DrawingContext<'_>) -> f64 {
    let terrain = cx.document.graph().terrain();
    let long = terrain.width.max(terrain.depth).max(1.0);
    decade(long / 20_000.0).min(1.0)
}

/// Whether a key for a tool was pressed while no dialog and no text field takes keys.
fn pressed(ui: &Ui, keys: &[Key]) -> bool {
    let dialog = ui.ctx().memory(|m| m.top_modal_layer().is_some());
    !dialog
        && !ui.ctx().egui_wants_keyboard_input()
        && keys.iter().any(|key| ui.input_mut(|i| i.consume_key(Modifiers::NONE, *key)))
}

/// A named area around a point that can be clicked and dragged.
fn grip_area(ui: &Ui, at: Pos2, size: f32, id: Id, name: &str) -> Response {
    let rect = Rect::from_center_size(at, egui::vec2(size, size));
    let response = ui.interact(rect, id, egui::Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name));
    response
}
