//! The layout of nodes and notes on the canvas, in its units.

use eframe::egui::{Pos2, Rect, Vec2, pos2, vec2};

use crate::graph::{Graph, GraphNode, NodeId, Note};
use crate::ports::Port;

/// Width of a node.
pub(crate) const WIDTH: f32 = 212.0;
/// Height of the title of a node.
pub(crate) const HEAD: f32 = 26.0;
/// Height of a port.
const ROW: f32 = 17.0;
/// Width and height of the thumbnail.
const PICTURE: f32 = 70.0;
/// Margin around the thumbnail and the ports.
const PAD: f32 = 7.0;
/// Height of the title of a note.
pub(crate) const NOTE_HEAD: f32 = 24.0;

/// A port and its place.
pub(crate) type Pin = (Port, Pos2);

/// The places of the parts of a node.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub(crate) rect: Rect,
    pub(crate) picture: Rect,
    pub(crate) inputs: Vec<Pin>,
    pub(crate) outputs: Vec<Pin>,
}

impl Layout {
    pub(crate) fn of(node: &GraphNode) -> Self {
        let kind = node.kind();
        let inputs = kind.map_or(&[][..], |k| &k.inputs);
        let outputs = kind.map_or(&[][..], |k| &k.outputs);
        let rows = inputs.len().max(outputs.len()) as f32;
        let at = place(node.at);
        let body = (rows * ROW).max(PICTURE) + 2.0 * PAD;
        let rect = Rect::from_min_size(at, vec2(WIDTH, HEAD + body));
        let middle = pos2(rect.center().x, at.y + HEAD + 0.5 * body);
        let pins = |ports: &[Port], x: f32| -> Vec<Pin> {
            let y = |i: usize| at.y + HEAD + PAD + (i as f32 + 0.5) * ROW;
            ports.iter().enumerate().map(|(i, port)| (port.clone(), pos2(x, y(i)))).collect()
        };
        Self {
            rect,
            picture: Rect::from_center_size(middle, vec2(PICTURE, PICTURE)),
            inputs: pins(inputs, rect.left()),
            outputs: pins(outputs, rect.right()),
        }
    }

    pub(crate) fn moved(self, by: Vec2) -> Self {
        let pins = |pins: Vec<Pin>| pins.into_iter().map(|(port, at)| (port, at + by)).collect();
        Self {
            rect: self.rect.translate(by),
            picture: self.picture.translate(by),
            inputs: pins(self.inputs),
            outputs: pins(self.outputs),
        }
    }

    pub(crate) fn head(&self) -> Rect {
        Rect::from_min_size(self.rect.min, vec2(WIDTH, HEAD))
    }

    pub(crate) fn input(&self, name: &str) -> Option<Pos2> {
        self.inputs.iter().find(|(p, _)| p.name == name).map(|(_, at)| *at)
    }

    pub(crate) fn output(&self, name: &str) -> Option<Pos2> {
        self.outputs.iter().find(|(p, _)| p.name == name).map(|(_, at)| *at)
    }
}

pub(crate) fn place(at: [f64; 2]) -> Pos2 {
    pos2(at[0] as f32, at[1] as f32)
}

pub(crate) fn note_rect(note: &Note) -> Rect {
    Rect::from_min_size(place(note.at), vec2(note.size[0] as f32, note.size[1] as f32))
}

/// The smallest rectangle around some nodes and notes.
pub(crate) fn covered<'a>(
    graph: &Graph,
    nodes: impl IntoIterator<Item = NodeId>,
    notes: impl IntoIterator<Item = &'a str>,
) -> Rect {
    let nodes = nodes.into_iter().filter_map(|id| graph.get(id)).map(|n| Layout::of(n).rect);
    let notes = notes.into_iter().filter_map(|name| graph.note(name)).map(note_rect);
    nodes.chain(notes).fold(Rect::NOTHING, Rect::union)
}
