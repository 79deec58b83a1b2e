//! Everything that can be done by name: menus, keys, the palette and the cheat sheet all come from this list.

use eframe::egui::{self, Button, Key, KeyboardShortcut, Modifiers, Response, Ui};

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// A line a command: what it does as its doc comment, its name in menus, its key.
macro_rules! commands {
    ($(#[doc = $help:literal] $command:ident = $name:literal $($modifiers:ident $key:ident)?;)*) => {
        /// Something the editor can do.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Command {
            $(#[doc = $help] $command,)*
        }

        impl Command {
            /// All commands, in the order of the cheat sheet.
            pub(crate) const ALL: &[Self] = &[$(Self::$command,)*];

            /// Its name in menus.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$command => $name,)*
                }
            }

            /// What it does, in a sentence.
            pub(crate) fn help(self) -> &'static str {
                match self {
                    $(Self::$command => $help.trim_ascii(),)*
                }
            }

            /// Its key.
            pub(crate) fn shortcut(self) -> Option<KeyboardShortcut> {
                match self {
                    $($(Self::$command => Some(KeyboardShortcut::new($modifiers, Key::$key)),)?)*
                    #[allow(unreachable_patterns, reason = "where every command has a key")]
                    _ => None,
                }
            }
        }
    };
}

commands! {
    /// Starts an empty graph
    New = "New graph" COMMAND N;
    /// Begins with one of the presets that come with the program
    Start = "Presets to begin with";
    /// Opens a .graph file
    Open = "Open…" COMMAND O;
    /// Writes the file, whole or not at all
    Save = "Save" COMMAND S;
    /// Writes the graph to another file and goes on with that
    SaveAs = "Save as…" COMMAND_SHIFT S;
    /// Writes the outputs at any size, as `orograph build` does
    Build = "Build…" COMMAND B;
    /// Closes the editor; unsaved changes are asked about
    Quit = "Quit" COMMAND Q;
    /// Takes the last change back
    Undo = "Undo" COMMAND Z;
    /// Does what was undone again
    Redo = "Redo" COMMAND_SHIFT Z;
    /// Copies what is selected and removes it
    Cut = "Cut" COMMAND X;
    /// Copies what is selected as the text of a .graph file
    Copy = "Copy" COMMAND C;
    /// Pastes a graph or a part of one where the pointer is
    Paste = "Paste" COMMAND V;
    /// Copies what is selected beside itself
    Duplicate = "Duplicate" COMMAND D;
    /// Selects all nodes and notes
    SelectAll = "Select all" COMMAND A;
    /// Removes what is selected and keeps its wires bridged where possible
    RemoveBridged = "Delete and bridge" NONE Delete;
    /// Removes what is selected with its wires
    Remove = "Delete with wires" SHIFT Delete;
    /// Finds a node by its name or kind
    Find = "Find in graph" COMMAND F;
    /// Searches the kinds and adds a node where the pointer is
    AddNode = "Add node" NONE Tab;
    /// Puts a note around what is selected, or where the pointer is
    AddFrame = "Add note" NONE N;
    /// Leaves the selected nodes out: what they would change passes through
    Bypass = "Bypass" NONE B;
    /// Keeps this node in the view whatever is selected
    Pin = "Pin in view" NONE P;
    /// Renames the selected node
    Rename = "Rename" NONE F2;
    /// Brings the selected nodes into columns from sources to results
    ArrangeTree = "Arrange selected" NONE L;
    /// Brings all nodes into columns from sources to results
    ArrangeAll = "Arrange all" SHIFT L;
    /// Brings the left sides of the selected nodes to one line
    AlignLeft = "Align left";
    /// Brings the upper sides of the selected nodes to one line
    AlignTop = "Align top";
    /// Draws feature curves onto the terrain, on the selected node or on new ones
    Draw = "Draw curves" NONE K;
    /// Paints a mask onto the terrain with a brush, on the selected node or on a new one
    Paint = "Paint mask" NONE M;
    /// Compares what is shown with the selected node, or with what goes into it
    Compare = "Compare" NONE C;
    /// Shows what is selected, or everything
    FrameView = "Zoom to selection or all" NONE F;
    /// Moves nodes in steps of the grid
    Snap = "Snap to grid";
    /// Shows on each node how long it took
    Times = "Times on nodes";
    /// Finds a command by name
    Palette = "Command palette" COMMAND_SHIFT P;
    /// Shows all keys
    Help = "Keyboard shortcuts" NONE F1;
    /// Shows all changes and goes back to any of them
    History = "History" COMMAND H;
    /// Changes between the dark and the light theme
    Theme = "Dark or light theme";
}

impl Command {
    /// Whether its key is the system's own for the clipboard, which arrives as an event of its own.
    fn is_clipboard(self) -> bool {
        matches!(self, Self::Cut | Self::Copy | Self::Paste)
    }

    /// A button with its name and key; of a switch also whether it is on.
    pub(crate) fn button(self, ui: &mut Ui, enabled: bool, on: bool) -> Response {
        let mut button = Button::new(self.name()).selected(on);
        if let Some(shortcut) = self.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
        }
        ui.add_enabled(enabled, button).on_hover_text(self.help())
    }

    /// The command whose key was pressed; keys that write text are left to a text field that has the focus.
    pub(crate) fn pressed(ctx: &egui::Context) -> Option<Self> {
        let typing = ctx.egui_wants_keyboard_input();
        let mut keyed: Vec<(Self, KeyboardShortcut)> =
            Self::ALL.iter().filter_map(|c| Some((*c, c.shortcut()?))).collect();
        // The key with more modifiers first: Ctrl+Shift+Z is also Ctrl+Z to egui.
        keyed.sort_by_key(|(_, s)| {
            std::cmp::Reverse(u8::from(s.modifiers.shift) + u8::from(s.modifiers.command))
        });
        let free = |c: Self, s: &KeyboardShortcut| {
            let works_in_text =
                matches!(c, Self::Save | Self::SaveAs | Self::Help | Self::Palette | Self::Quit);
            let function = matches!(s.logical_key, Key::F1);
            !c.is_clipboard() && (!typing || works_in_text || function)
        };
        let found = keyed.into_iter().filter(|(c, s)| free(*c, s));
        let mut found = found.filter(|(_, s)| ctx.input_mut(|i| i.consume_shortcut(s)));
        let key = found.next().map(|(c, _)| c);
        key.or_else(|| if typing { None } else { extra_key(ctx) })
    }
}

/// Second keys of some commands, as other programs have them.
fn extra_key(ctx: &egui::Context) -> Option<Command> {
    let pressed = |m, k| ctx.input_mut(|i| i.consume_key(m, k));
    if pressed(COMMAND, Key::Y) {
        return Some(Command::Redo);
    }
    if pressed(NONE, Key::Backspace) {
        return Some(Command::RemoveBridged);
    }
    if pressed(NONE, Key::Home) {
        return Some(Command::FrameView);
    }
    let event = |e: &egui::Event| match e {
        egui::Event::Copy => Some(Command::Copy),
        egui::Event::Cut => Some(Command::Cut),
        _ => None,
    };
    ctx.input(|i| i.events.iter().find_map(event))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_commands() {
        let keys: Vec<_> = Command::ALL.iter().filter_map(|c| c.shortcut()).collect();
        for (i, key) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(key), "{key:?}");
        }
    }
}
