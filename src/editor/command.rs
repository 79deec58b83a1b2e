//! Everything that can be done by name: menus, keys, the palette and the cheat sheet all come from this list.

use eframe::egui::{self, Button, Key, KeyboardShortcut, Modifiers, Response, Ui};

/// Something the editor can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Command {
    /// An empty graph.
    New,
    /// Another file.
    Open,
    /// Writes the file.
    Save,
    /// Writes another file.
    SaveAs,
    /// Builds the outputs.
    Build,
    /// Ends the program.
    Quit,
    /// Takes the last change back.
    Undo,
    /// Does it again.
    Redo,
    /// Copies what is chosen and removes it.
    Cut,
    /// Copies what is chosen to the clipboard.
    Copy,
    /// Pastes from the clipboard.
    Paste,
    /// Copies in place.
    Duplicate,
    /// Chooses everything.
    SelectAll,
    /// Removes what is chosen and joins what it changed to what read it.
    RemoveBridged,
    /// Removes what is chosen with its wires.
    Remove,
    /// Looks for a node of the graph.
    Find,
    /// Opens the search for kinds.
    AddNode,
    /// Puts a note around what is chosen.
    AddFrame,
    /// Leaves the chosen nodes out.
    Bypass,
    /// Keeps a node in the view.
    Pin,
    /// Renames the chosen node.
    Rename,
    /// Brings the chosen nodes, or all, into columns.
    ArrangeTree,
    /// Brings all nodes into columns.
    ArrangeAll,
    /// Brings left sides to one line.
    AlignLeft,
    /// Brings upper sides to one line.
    AlignTop,
    /// Shows what is chosen, or everything.
    FrameView,
    /// Whether nodes snap to lines.
    Snap,
    /// The list of all commands.
    Palette,
    /// The cheat sheet.
    Help,
    /// The history.
    History,
    /// Light or dark.
    Theme,
}

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Command {
    /// All commands, in the order of the cheat sheet.
    pub(crate) const ALL: [Self; 31] = {
        use Command::*;
        [
            New,
            Open,
            Save,
            SaveAs,
            Build,
            Quit,
            Undo,
            Redo,
            Cut,
            Copy,
            Paste,
            Duplicate,
            SelectAll,
            RemoveBridged,
            Remove,
            Find,
            AddNode,
            AddFrame,
            Bypass,
            Pin,
            Rename,
            ArrangeTree,
            ArrangeAll,
            AlignLeft,
            AlignTop,
            FrameView,
            Snap,
            Palette,
            Help,
            History,
            Theme,
        ]
    };

    /// Its name in menus.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::New => "New graph",
            Self::Open => "Open…",
            Self::Save => "Save",
            Self::SaveAs => "Save as…",
            Self::Build => "Build…",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::Cut => "Cut",
            Self::Copy => "Copy",
            Self::Paste => "Paste",
            Self::Duplicate => "Duplicate",
            Self::SelectAll => "Select all",
            Self::RemoveBridged => "Delete and bridge",
            Self::Remove => "Delete with wires",
            Self::Find => "Find in graph",
            Self::AddNode => "Add node",
            Self::AddFrame => "Add note",
            Self::Bypass => "Bypass",
            Self::Pin => "Pin in view",
            Self::Rename => "Rename",
            Self::ArrangeTree => "Arrange selected",
            Self::ArrangeAll => "Arrange all",
            Self::AlignLeft => "Align left",
            Self::AlignTop => "Align top",
            Self::FrameView => "Zoom to selection or all",
            Self::Snap => "Snap to grid",
            Self::Palette => "Command palette",
            Self::Help => "Keyboard shortcuts",
            Self::History => "History",
            Self::Theme => "Dark or light theme",
        }
    }

    /// What it does, in a sentence.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::New => "Starts an empty graph",
            Self::Open => "Opens a .graph file",
            Self::Save => "Writes the file, whole or not at all",
            Self::SaveAs => "Writes the graph to another file and goes on with that",
            Self::Build => "Writes the outputs at any size, as `orograph build` does",
            Self::Quit => "Closes the editor; unsaved changes are asked about",
            Self::Undo => "Takes the last change back",
            Self::Redo => "Does what was undone again",
            Self::Cut => "Copies what is selected and removes it",
            Self::Copy => "Copies what is selected as the text of a .graph file",
            Self::Paste => "Pastes a graph or a part of one where the pointer is",
            Self::Duplicate => "Copies what is selected beside itself",
            Self::SelectAll => "Selects all nodes and notes",
            Self::RemoveBridged => "Removes what is selected and keeps its wires bridged where possible",
            Self::Remove => "Removes what is selected with its wires",
            Self::Find => "Finds a node by its name or kind",
            Self::AddNode => "Searches the kinds and adds a node where the pointer is",
            Self::AddFrame => "Puts a note around what is selected, or where the pointer is",
            Self::Bypass => "Leaves the selected nodes out: what they would change passes through",
            Self::Pin => "Keeps this node in the view whatever is selected",
            Self::Rename => "Renames the selected node",
            Self::ArrangeTree => "Brings the selected nodes into columns from sources to results",
            Self::ArrangeAll => "Brings all nodes into columns from sources to results",
            Self::AlignLeft => "Brings the left sides of the selected nodes to one line",
            Self::AlignTop => "Brings the upper sides of the selected nodes to one line",
            Self::FrameView => "Shows what is selected, or everything",
            Self::Snap => "Moves nodes in steps of the grid",
            Self::Palette => "Finds a command by name",
            Self::Help => "Shows all keys",
            Self::History => "Shows all changes and goes back to any of them",
            Self::Theme => "Changes between the dark and the light theme",
        }
    }

    /// Its key.
    pub(crate) fn shortcut(self) -> Option<KeyboardShortcut> {
        let (modifiers, key) = match self {
            Self::New => (COMMAND, Key::N),
            Self::Open => (COMMAND, Key::O),
            Self::Save => (COMMAND, Key::S),
            Self::SaveAs => (COMMAND_SHIFT, Key::S),
            Self::Build => (COMMAND, Key::B),
            Self::Quit => (COMMAND, Key::Q),
            Self::Undo => (COMMAND, Key::Z),
            Self::Redo => (COMMAND_SHIFT, Key::Z),
            Self::Cut => (COMMAND, Key::X),
            Self::Copy => (COMMAND, Key::C),
            Self::Paste => (COMMAND, Key::V),
            Self::Duplicate => (COMMAND, Key::D),
            Self::SelectAll => (COMMAND, Key::A),
            Self::RemoveBridged => (NONE, Key::Delete),
            Self::Remove => (SHIFT, Key::Delete),
            Self::Find => (COMMAND, Key::F),
            Self::AddNode => (NONE, Key::Tab),
            Self::AddFrame => (NONE, Key::N),
            Self::Bypass => (NONE, Key::B),
            Self::Pin => (NONE, Key::P),
            Self::Rename => (NONE, Key::F2),
            Self::ArrangeTree => (NONE, Key::L),
            Self::ArrangeAll => (SHIFT, Key::L),
            Self::FrameView => (NONE, Key::F),
            Self::Palette => (COMMAND_SHIFT, Key::P),
            Self::Help => (NONE, Key::F1),
            Self::History => (COMMAND, Key::H),
            Self::AlignLeft | Self::AlignTop | Self::Snap | Self::Theme => return None,
        };
        Some(KeyboardShortcut::new(modifiers, key))
    }

    /// Whether its key is the system's own for the clipboard, which arrives as an event of its own.
    fn is_clipboard(self) -> bool {
        matches!(self, Self::Cut | Self::Copy | Self::Paste)
    }

    /// A button with its name and key.
    pub(crate) fn button(self, ui: &mut Ui, enabled: bool) -> Response {
        let mut button = Button::new(self.name());
        if let Some(shortcut) = self.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
        }
        ui.add_enabled(enabled, button).on_hover_text(self.help())
    }

    /// The command whose key was pressed; keys that write text are left to a text field that has the focus.
    pub(crate) fn pressed(ctx: &egui::Context) -> Option<Self> {
        let typing = ctx.egui_wants_keyboard_input();
        let mut keyed: Vec<(Self, KeyboardShortcut)> =
            Self::ALL.into_iter().filter_map(|c| Some((c, c.shortcut()?))).collect();
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
