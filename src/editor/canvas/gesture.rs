//! Gestures: what the user does between pressing and releasing a button.

use std::collections::BTreeSet;

use eframe::egui::{Pos2, Vec2, vec2};

use super::{Chosen, GRID};
use crate::editor::ops::End;
use crate::graph::{Graph, NodeId};
use crate::name::Name;

/// A gesture in progress; the document changes when it ends.
#[derive(Clone, Debug, Default)]
pub(super) enum Gesture {
    /// No gesture.
    #[default]
    None,
    /// Chooses what a box touches, in addition to what was chosen before.
    Box { from: Pos2, before: Chosen },
    /// Moves what is chosen; the corner of the grabbed node snaps to the grid.
    Move { from: Pos2, corner: Pos2, by: Vec2, nodes: BTreeSet<NodeId>, notes: BTreeSet<String> },
    /// Drags a wire; `taken` is the input from which an existing wire was taken.
    Wire { end: End, taken: Option<(NodeId, Name)> },
    /// Moves a bend of a wire.
    Bend { node: NodeId, input: Name, index: usize },
    /// Moves the lower right corner of a note.
    Resize { name: String, size: Vec2 },
}

impl Gesture {
    /// Updates the gesture to a position of the pointer.
    pub(super) fn follow(&mut self, pointer: Pos2, snap: bool, graph: &Graph) {
        let snapped = |at: Pos2| if snap { (at / GRID).round() * GRID } else { at };
        match self {
            Self::Move { from, corner, by, .. } => {
                let wanted = *corner + (pointer - *from);
                *by = snapped(wanted) - *corner;
            }
            Self::Resize { name, size } => {
                let Some(note) = graph.note(name) else { return };
                let corner = super::layout::place(note.at);
                *size = (snapped(pointer) - corner).max(vec2(80.0, 40.0));
            }
            _ => (),
        }
    }

    /// The distance by which nodes and notes are being moved.
    pub(super) fn shift(&self) -> Vec2 {
        match self {
            Self::Move { by, .. } => *by,
            _ => Vec2::ZERO,
        }
    }

    pub(super) fn moves(&self, id: NodeId) -> bool {
        matches!(self, Self::Move { nodes, .. } if nodes.contains(&id))
    }

    pub(super) fn moves_note(&self, name: &str) -> bool {
        matches!(self, Self::Move { notes, .. } if notes.contains(name))
    }
}
