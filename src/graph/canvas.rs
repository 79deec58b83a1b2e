//! Notes and bends of wires, which a graph has on the canvas beside its nodes. They are no part of any key.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use super::parts::Part;
use super::problem::{Place, Problem};
use super::validate::name_fault;
use super::{Graph, MAX_NAMED, NodeId};

/// The largest coordinate on the canvas.
const FARTHEST: f64 = 1e9;
/// The most bends of a wire.
const MAX_BENDS: usize = 100;

/// A coloured box with a title and a text, behind the nodes: a frame around some of them, or a comment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Note {
    /// Place of its corner on the canvas.
    #[schemars(inner(range(min = -1.0e9, max = 1.0e9)))]
    pub at: [f64; 2],
    /// Width and height on the canvas.
    #[schemars(inner(range(min = 1.0, max = 1.0e9)))]
    pub size: [f64; 2],
    /// Title.
    #[schemars(length(max = 1024))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// What it says.
    #[schemars(length(max = 65536))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub text: String,
    /// Colour.
    pub color: NoteColor,
    /// What the file says beyond that, kept as it was written.
    #[serde(skip)]
    pub extra: Map<String, Json>,
}

impl Default for Note {
    fn default() -> Self {
        Self {
            at: [0.0; 2],
            size: [360.0, 240.0],
            title: String::new(),
            text: String::new(),
            color: NoteColor::default(),
            extra: Map::new(),
        }
    }
}

/// The colours of notes; the editor's theme says how each looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NoteColor {
    /// Quiet.
    #[default]
    Grey,
    /// Blue.
    Blue,
    /// Green.
    Green,
    /// Yellow.
    Yellow,
    /// Orange.
    Orange,
    /// Red.
    Red,
    /// Violet.
    Violet,
}

impl NoteColor {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Grey, Self::Blue, Self::Green, Self::Yellow, Self::Orange, Self::Red, Self::Violet];

    /// Its name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grey => "grey",
            Self::Blue => "blue",
            Self::Green => "green",
            Self::Yellow => "yellow",
            Self::Orange => "orange",
            Self::Red => "red",
            Self::Violet => "violet",
        }
    }
}

/// Where the wire into an input bends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Bends {
    /// The input.
    #[schemars(length(max = 64))]
    #[serde(rename = "in")]
    pub input: String,
    /// Points that the wire goes through, from its source on.
    #[schemars(length(max = 100), inner(inner(range(min = -1.0e9, max = 1.0e9))))]
    pub at: Vec<[f64; 2]>,
}

impl Graph {
    /// Adds a note and returns its name.
    ///
    /// # Errors
    /// Fails when a coordinate is too large, or there are too many notes.
    pub fn add_note(&mut self, note: Note) -> Result<String, Problem> {
        let free = (1..).map(|n| format!("note_{n}")).find(|name| self.note(name).is_none());
        let name = free.unwrap_or_default();
        if self.notes.len() >= MAX_NAMED {
            let message = format!("would be one more than the limit of {MAX_NAMED} notes");
            return Err(Problem::error(Place::Note(name), message));
        }
        let note = checked(&name, note)?;
        self.notes.push((name.clone(), note));
        self.touch();
        Ok(name)
    }

    /// Changes a note.
    ///
    /// # Errors
    /// Fails when there is no note of the name, or a coordinate is too large.
    pub fn change_note(&mut self, name: &str, note: Note) -> Result<(), Problem> {
        let i = self.note_index(name)?;
        let note = checked(name, note)?;
        if self.notes[i].1 != note {
            self.notes[i].1 = note;
            self.touch();
        }
        Ok(())
    }

    /// Removes a note.
    ///
    /// # Errors
    /// Fails when there is no note of the name.
    pub fn remove_note(&mut self, name: &str) -> Result<Note, Problem> {
        let i = self.note_index(name)?;
        self.touch();
        Ok(self.notes.remove(i).1)
    }

    fn note_index(&self, name: &str) -> Result<usize, Problem> {
        let missing = || Problem::error(Place::Note(name.to_owned()), "is not a note of this graph");
        self.notes.iter().position(|(n, _)| n == name).ok_or_else(missing)
    }

    /// The bends of the wire into an input of a node.
    pub fn bends(&self, id: NodeId, input: &str) -> &[[f64; 2]] {
        let own = self.get(id).and_then(|n| n.bends.iter().find(|b| b.input == input));
        own.map_or(&[], |b| &b.at)
    }

    /// Sets the bends of the wire into an input of a node.
    ///
    /// # Errors
    /// Fails when the input has no wire, a coordinate is too large, or there are too many bends.
    pub fn set_bends(&mut self, id: NodeId, input: &str, at: Vec<[f64; 2]>) -> Result<(), Problem> {
        self.live(id)?;
        let bad = |message: String| {
            let node = self.node(id).name.clone();
            Err(Problem::error(Place::Input { node, port: input.to_owned() }, message))
        };
        if at.len() > MAX_BENDS {
            return bad(format!("has a wire with {} bends, the limit is {MAX_BENDS}", at.len()));
        }
        if at.iter().flatten().any(|v| !on_canvas(*v)) {
            return bad("has a wire with a bend too far out".to_owned());
        }
        if !at.is_empty() && self.source(id, input).is_none() {
            return bad("has no wire that could bend".to_owned());
        }
        if self.bends(id, input) != at {
            let bends = &mut self.dag[id].bends;
            bends.retain(|b| b.input != input);
            if !at.is_empty() {
                let at = at.into_iter().map(|p| p.map(|v| v + 0.0)).collect();
                bends.push(Bends { input: input.to_owned(), at });
            }
            self.touch();
        }
        Ok(())
    }

    /// Sets or ends the bypass of a node, by which its input passes through unchanged.
    ///
    /// # Errors
    /// Fails when the kind has no input that can pass through.
    pub fn set_bypass(&mut self, id: NodeId, bypass: bool) -> Result<(), Problem> {
        self.live(id)?;
        let node = self.node(id);
        let passes = node.kind().is_some_and(|k| k.outputs.iter().any(|o| k.bridge(&o.name).is_some()));
        if bypass && !passes {
            let message = format!("cannot be bypassed: `{}` changes no input", node.kind.id());
            return Err(Problem::error(Place::Node(node.name.clone()), message).of(id));
        }
        let node = &mut self.dag[id];
        if node.extra.shift_remove("bypass").is_some() || node.bypass != bypass {
            node.bypass = bypass;
            self.settle();
        }
        Ok(())
    }
}

fn on_canvas(v: f64) -> bool {
    v.is_finite() && v.abs() <= FARTHEST
}

fn checked(name: &str, mut note: Note) -> Result<Note, Problem> {
    Note::forget_known(&mut note.extra);
    let bad = |message: &str| Err(Problem::error(Place::Note(name.to_owned()), message));
    if let Some(fault) = name_fault(name) {
        return bad(&fault);
    }
    if !note.at.iter().all(|v| on_canvas(*v)) {
        return bad("must stand within 1e9 of the middle of the canvas");
    }
    if !note.size.iter().all(|v| (1.0..=FARTHEST).contains(v)) {
        return bad("must have a width and a height from 1 to 1e9");
    }
    // The file has no −0.
    note.at = note.at.map(|v| v + 0.0);
    Ok(note)
}
