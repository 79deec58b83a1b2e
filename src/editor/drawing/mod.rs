//! Drawing on the terrain: curves, lines through points and masks, in the map as in the relief.
//!
//! What is drawn is the parameter of the one chosen node ([`sheet`]); every stroke of the hand is a change of the
//! document like any other, so that undo, recovery and evaluation follow by themselves. A view lends its [`Space`]: where
//! places stand on the screen and which place a hand points at. All that is held here is what is chosen and what a hand
//! is doing.

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

/// How a view shows the world.
pub(crate) trait Space {
    /// Where a place (east, south, up; metres) stands on the screen; `None` behind the eye.
    fn screen(&self, at: [f64; 3]) -> Option<Pos2>;
    /// The place at a height that a point of the screen shows.
    fn level(&self, pos: Pos2, height: f64) -> Option<[f64; 2]>;
    /// The place of the ground that a point of the screen shows.
    fn ground(&self, pos: Pos2) -> Option<[f64; 2]>;
    /// Height of the ground.
    fn height(&self, at: [f64; 2]) -> f64;
    /// Metres of height that a pixel upwards stands for.
    fn rise(&self, at: [f64; 3]) -> f64;
    /// Metres that a pixel across stands for.
    fn across(&self, at: [f64; 3]) -> f64;
    /// Whether the ground hides a place.
    fn hides(&self, at: [f64; 3]) -> bool;
    /// Whether it is seen from straight above, so that heights have no place of their own.
    fn is_flat(&self) -> bool;
    /// From the lowest to the highest ground, in metres.
    fn relief(&self) -> f64;
}

/// What a hand does on the ground of a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
    /// Chooses and moves what is there.
    #[default]
    Select,
    /// Draws new curves.
    Draw,
    /// Paints with the brush.
    Brush,
}

/// What drawing works with for a frame.
pub(crate) struct Pad<'a> {
    pub(crate) document: &'a mut Document,
    pub(crate) notices: &'a mut Notices,
    /// The node whose drawing it is.
    pub(crate) node: Option<NodeId>,
}

/// The state of drawing.
#[derive(Default)]
pub(crate) struct Drawing {
    pub(crate) tool: Tool,
    /// The brush: a stroke without a line.
    pub(crate) brush: Stroke,
    /// The chosen curve.
    pub(crate) curve: Option<usize>,
    /// The chosen constraint point of it.
    pub(crate) point: Option<usize>,
    /// The chosen control point of it.
    anchor: Option<usize>,
    grab: Option<Grab>,
    /// The state of the document that the last pull left: another means that others have changed it.
    wrote: Option<u64>,
    trace: Option<Trace>,
    /// Where a curve begins that has no second point yet.
    start: Option<[f64; 2]>,
    /// Whether the chosen curve is under the pointer.
    over: bool,
    /// Whether the last press was in the view, so that keys are meant for the drawing.
    touched: bool,
    /// Whether the key that deletes has done so since the last press, so that a held key does not go on to the curve and
    /// the node.
    spent: bool,
    known: Option<Known>,
    /// Where the right button was pressed, for the menu.
    menu: Option<menu::Spot>,
}

/// A part in the hand.
struct Grab {
    part: Part,
    /// The drawing and the curve as they were.
    sheet: Sheet,
    curve: Curve,
    /// Where the part was, and where the pointer was.
    at: [f64; 3],
    from: Pos2,
}

/// A line that is being drawn with the button down.
struct Trace {
    /// The drawing as it was.
    sheet: Sheet,
    points: Vec<[f64; 2]>,
    /// How many of its points the document has.
    written: usize,
}

/// What was made of a state of the document.
struct Known {
    state: u64,
    node: NodeId,
    param: String,
    sheet: Sheet,
    curves: Vec<Option<Curve>>,
}

impl Drawing {
    /// Whether the first button is meant for the drawing and not for the view.
    pub(crate) fn holds(&self) -> bool {
        self.known.is_some() && (self.grab.is_some() || self.tool != Tool::Select || self.over)
    }

    /// What is drawn now, if anything.
    pub(crate) fn sheet(&self) -> Option<&Sheet> {
        self.known.as_ref().map(|k| &k.sheet)
    }

    /// Reads the drawing of the chosen node, where the document or the choice has changed.
    pub(crate) fn look(&mut self, pad: &Pad<'_>) {
        let state = pad.document.state();
        if self.known.as_ref().is_some_and(|k| k.state == state && Some(k.node) == pad.node) {
            return;
        }
        let found = pad.node.and_then(|id| Some((id, Sheet::of(pad.document.graph(), id)?)));
        let Some((node, (param, sheet))) = found else {
            let touched = self.touched;
            self.forget();
            self.touched = touched;
            return;
        };
        let mut old = self.known.take().filter(|k| k.node == node);
        if old.is_none() {
            (self.tool, self.curve, self.point, self.anchor) = (Tool::Select, None, None, None);
            (self.grab, self.trace, self.start) = (None, None, None);
        }
        // Measuring a curve takes time: those that are as they were stay.
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
        self.known = Some(Known { state, node, param, sheet, curves });
    }

    /// Draws over a view and does what hands do; `ground` answers for all of it.
    pub(crate) fn show(&mut self, ui: &Ui, space: &dyn Space, ground: &Response, pad: &mut Pad<'_>) {
        if ui.input(|i| i.pointer.any_pressed()) {
            let at = ui.input(|i| i.pointer.interact_pos());
            self.touched = at.is_some_and(|p| ground.rect.contains(p)) && ground.contains_pointer();
            self.spent = false;
        }
        self.look(pad);
        let Some(known) = &self.known else { return };
        let step = step(pad);
        let hint = match self.tool {
            Tool::Select => "",
            Tool::Draw => "Click for each point, or drag freely; double-click, Enter or Esc ends",
            Tool::Brush => "Drag paints, with Alt it erases; [ and ] change the radius, Esc ends",
        };
        paint::hint(ui, hint);
        match known.sheet {
            Sheet::Strokes(_) => self.brushing(ui, space, ground, pad, step),
            _ => self.curving(ui, space, ground, pad, step),
        }
    }

    /// Puts a new drawing into the document; true when it was taken.
    fn write(&self, pad: &mut Pad<'_>, label: &str, gesture: Option<&str>, sheet: &Sheet) -> bool {
        let Some(Known { node, param, .. }) = &self.known else { return false };
        let (node, value) = (*node, sheet.json());
        let change = |graph: &mut crate::graph::Graph| ops::set(graph, &[node], param, value);
        let done = match gesture {
            Some(gesture) => pad.document.gesture(label, gesture, change),
            None => pad.document.edit(label, change),
        };
        match done {
            Ok(()) => true,
            Err(problem) => {
                pad.notices.problem(&problem);
                false
            }
        }
    }

    /// Removes what is chosen; false when that is nothing, so that the key means something else.
    pub(crate) fn delete(&mut self, pad: &mut Pad<'_>) -> bool {
        self.look(pad);
        let known = self.known.is_some() && self.touched;
        if known && (self.spent || self.grab.is_some()) {
            return true;
        }
        self.spent = known && self.remove_chosen(pad);
        self.spent
    }

    /// Forgets a document that is no longer on the desk.
    pub(crate) fn forget(&mut self) {
        *self = Self { brush: self.brush.clone(), ..Self::default() };
    }

    /// Ends what a tool is doing.
    pub(crate) fn rest(&mut self) {
        (self.tool, self.start, self.trace, self.grab) = (Tool::Select, None, None, None);
    }
}

/// Places are rounded to this, in metres: far below what is seen.
fn step(pad: &Pad<'_>) -> f64 {
    let terrain = pad.document.graph().terrain();
    let long = terrain.width.max(terrain.depth).max(1.0);
    decade(long / 20_000.0).min(1.0)
}

/// Whether a key for a tool was pressed, and is not meant for a dialog over the window or a field with text.
fn pressed(ui: &Ui, keys: &[Key]) -> bool {
    let dialog = ui.ctx().memory(|m| m.top_modal_layer().is_some());
    !dialog
        && !ui.ctx().egui_wants_keyboard_input()
        && keys.iter().any(|key| ui.input_mut(|i| i.consume_key(Modifiers::NONE, *key)))
}

/// Something to hold, of a size that a hand finds.
fn hold(ui: &Ui, at: Pos2, size: f32, id: Id, name: &str) -> Response {
    let rect = Rect::from_center_size(at, egui::vec2(size, size));
    let response = ui.interact(rect, id, egui::Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name));
    response
}
