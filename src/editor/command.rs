//! The commands. Menus, keys, the palette and the cheat sheet are all made from one list.

use eframe::egui::{self, Button, Key, KeyboardShortcut, Modifiers, Response, Ui, ViewportCommand};

use super::actions::After;
use super::app::{Editor, FileFor};
use super::canvas::arrange::{AlignEdge, align, columns};
use super::dialogs::Dialog;
use super::ops;
use super::panels::Tab;

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// Declares the commands, one a row: the help text as a doc comment, the name in menus, the key, the condition under
/// which it is enabled, whether it is on where it is a switch, and the action.
macro_rules! commands {
    ($(
        #[doc = $help:literal]
        $command:ident = $name:literal $($modifiers:ident $key:ident)? $(, if $can:expr)? $(, on $on:expr)? => $does:expr;
    )*) => {
        /// An action of the editor that has a name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Command {
            $(#[doc = $help] $command,)*
        }

        impl Command {
            /// All commands, in the order of the cheat sheet.
            pub(crate) const ALL: &[Self] = &[$(Self::$command,)*];

            /// The name in menus.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$command => $name,)*
                }
            }

            /// The help text, one sentence.
            pub(crate) fn help(self) -> &'static str {
                match self {
                    $(Self::$command => $help.trim_ascii(),)*
                }
            }

            /// The key, where the command has one.
            pub(crate) fn shortcut(self) -> Option<KeyboardShortcut> {
                match self {
                    $($(Self::$command => Some(KeyboardShortcut::new($modifiers, Key::$key)),)?)*
                    #[allow(unreachable_patterns, reason = "where every command has a key")]
                    _ => None,
                }
            }
        }

        impl Editor {
            pub(super) fn perform(&mut self, ctx: &egui::Context, command: Command) {
                let does: fn(&mut Self, &egui::Context) = match command {
                    $(Command::$command => $does,)*
                };
                does(self, ctx);
            }

            /// Whether a command is enabled.
            pub(super) fn can(&self, command: Command) -> bool {
                let can: fn(&Self) -> bool = match command {
                    $($(Command::$command => $can,)?)*
                    _ => |_| true,
                };
                can(self)
            }

            /// Whether a switch is on.
            pub(super) fn is_on(&self, command: Command) -> bool {
                let is_on: fn(&Self) -> bool = match command {
                    $($(Command::$command => $on,)?)*
                    _ => |_| false,
                };
                is_on(self)
            }
        }
    };
}

commands! {
    /// Starts an empty graph
    New = "New graph" COMMAND N => |e, ctx| e.leave(ctx, After::New);
    /// Begins with one of the presets that come with the program
    Start = "Presets to begin with" => |e, ctx| e.leave(ctx, After::Start);
    /// Opens a .graph file
    Open = "Open…" COMMAND O => |e, ctx| e.leave(ctx, After::Open);
    /// Writes the file, whole or not at all
    Save = "Save" COMMAND S => |e, ctx| e.save(ctx);
    /// Writes the graph to another file and goes on with that
    SaveAs = "Save as…" COMMAND_SHIFT S => |e, ctx| e.ask(ctx, FileFor::SaveAs);
    /// Writes the outputs at any size, as `orograph build` does
    Build = "Build…" COMMAND B, if |e| e.graph().outputs().len() > 0 => |e, _| e.open_build();
    /// Closes the editor; unsaved changes are asked about
    Quit = "Quit" COMMAND Q => |e, ctx| e.leave(ctx, After::Quit);
    /// Takes the last change back
    Undo = "Undo" COMMAND Z, if |e| e.document.undo_labels()[0].is_some() => |e, _| _ = e.document.undo();
    /// Does what was undone again
    Redo = "Redo" COMMAND_SHIFT Z, if |e| e.document.undo_labels()[1].is_some() => |e, _| _ = e.document.redo();
    /// Copies what is selected and removes it
    Cut = "Cut" COMMAND X, if has_chosen => |e, ctx| {
        e.copy(ctx);
        e.remove_nodes(false);
    };
    /// Copies what is selected as the text of a .graph file
    Copy = "Copy" COMMAND C, if has_chosen => |e, ctx| e.copy(ctx);
    /// Pastes a graph or a part of one where the pointer is
    Paste = "Paste" COMMAND V => |_, ctx| ctx.send_viewport_cmd(ViewportCommand::RequestPaste);
    /// Copies what is selected beside itself
    Duplicate = "Duplicate" COMMAND D, if has_chosen => |e, _| e.duplicate();
    /// Selects all nodes and notes
    SelectAll = "Select all" COMMAND A => |e, _| e.select_all();
    /// Removes what is selected and keeps its wires bridged where possible
    RemoveBridged = "Delete and bridge" NONE Delete, if has_chosen => |e, _| e.remove(true);
    /// Removes what is selected with its wires
    Remove = "Delete with wires" SHIFT Delete, if has_chosen => |e, _| e.remove(false);
    /// Finds a node by its name or kind
    Find = "Find in graph" COMMAND F => |e, _| e.dialog = Dialog::find();
    /// Searches the kinds and adds a node where the pointer is
    AddNode = "Add node" NONE Tab => |e, _| e.canvas.open_search();
    /// Puts a note around what is selected, or where the pointer is
    AddFrame = "Add note" NONE N => |e, ctx| e.add_note(ctx);
    /// Leaves the selected nodes out: what they would change passes through
    Bypass = "Bypass" NONE B, if has_nodes => |e, _| e.on_chosen("Bypass", ops::toggle_bypass);
    /// Keeps this node in the view whatever is selected
    Pin = "Pin in view" NONE P => |e, _| e.pin();
    /// Renames the selected node
    Rename = "Rename" NONE F2, if |e| e.canvas.chosen.nodes.len() == 1 => |e, ctx| {
        e.tab = Tab::Node;
        e.rename_next(ctx);
    };
    /// Brings the selected nodes into columns from sources to results
    ArrangeTree = "Arrange selected" NONE L, if has_nodes => |e, _| e.on_chosen("Arrange", columns);
    /// Brings all nodes into columns from sources to results
    ArrangeAll = "Arrange all" SHIFT L => |e, _| e.arrange_all();
    /// Brings the left sides of the selected nodes to one line
    AlignLeft = "Align left", if |e| e.canvas.chosen.nodes.len() > 1 => |e, _| e.on_chosen("Align left", |g, ids| align(g, ids, AlignEdge::Left));
    /// Brings the upper sides of the selected nodes to one line
    AlignTop = "Align top", if |e| e.canvas.chosen.nodes.len() > 1 => |e, _| e.on_chosen("Align top", |g, ids| align(g, ids, AlignEdge::Top));
    /// Draws feature curves onto the terrain, on the selected node or on new ones
    Draw = "Draw curves" NONE K => |e, _| e.draw();
    /// Paints a mask onto the terrain with a brush, on the selected node or on a new one
    Paint = "Paint mask" NONE M => |e, _| e.paint();
    /// Compares what is shown with the selected node, or with what goes into it
    Compare = "Compare" NONE C, on |e| e.wipe.is_on => |e, _| e.wipe.is_on = !e.wipe.is_on;
    /// Shows what is selected, or everything
    FrameView = "Zoom to selection or all" NONE F => |e, _| e.canvas.frame(e.document.graph());
    /// Moves nodes in steps of the grid
    Snap = "Snap to grid", on |e| e.canvas.snap => |e, _| {
        e.canvas.snap = !e.canvas.snap;
        e.write_preferences();
    };
    /// Shows on each node how long it took
    Times = "Times on nodes", on |e| e.preferences.times => |e, _| {
        e.preferences.times = !e.preferences.times;
        e.write_preferences();
    };
    /// Finds a command by name
    Palette = "Command palette" COMMAND_SHIFT P => |e, _| e.dialog = Dialog::palette();
    /// Shows all keys
    Help = "Keyboard shortcuts" NONE F1 => |e, _| e.dialog = Dialog::Help;
    /// Shows all changes and goes back to any of them
    History = "History" COMMAND H => |e, _| e.tab = Tab::History;
    /// Changes between the dark and the light theme
    Theme = "Dark or light theme" => |e, ctx| {
        e.preferences.dark = !e.preferences.dark;
        e.set_theme(ctx);
        e.write_preferences();
    };
}

fn has_chosen(editor: &Editor) -> bool {
    !editor.canvas.chosen.is_empty()
}

fn has_nodes(editor: &Editor) -> bool {
    !editor.canvas.chosen.nodes.is_empty()
}

impl Command {
    /// Whether the key is one of the system's keys for the clipboard, which arrive as events of their own.
    fn is_clipboard(self) -> bool {
        matches!(self, Self::Cut | Self::Copy | Self::Paste)
    }

    /// Shows a button with the name and the key, and for a switch whether it is on.
    pub(crate) fn button(self, ui: &mut Ui, enabled: bool, on: bool) -> Response {
        let mut button = Button::new(self.name()).selected(on);
        if let Some(shortcut) = self.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
        }
        ui.add_enabled(enabled, button).on_hover_text(self.help())
    }

    /// The command whose key was pressed. Keys that type text are left to a text field that has the focus.
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

/// The command of a second key, as other programs have it.
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
