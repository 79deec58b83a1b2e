//! The menus of the right button.

use eframe::egui::Ui;

use crate::editor::command::Command;

fn entries(ui: &mut Ui, groups: &[&[Command]]) -> Option<Command> {
    let mut chosen = None;
    ui.set_min_width(190.0);
    for (i, group) in groups.iter().enumerate() {
        if i > 0 {
            ui.separator();
        }
        for &command in *group {
            if command.button(ui, true, false).clicked() {
                chosen = Some(command);
                ui.close();
            }
        }
    }
    chosen
}

/// The menu of a node.
pub(super) fn node(ui: &mut Ui) -> Option<Command> {
    use Command::*;
    entries(
        ui,
        &[
            &[Pin, Bypass, Rename],
            &[Cut, Copy, Duplicate],
            &[RemoveBridged, Remove],
            &[AddFrame, ArrangeTree],
        ],
    )
}

/// The menu of the empty canvas.
pub(super) fn ground(ui: &mut Ui) -> Option<Command> {
    use Command::*;
    entries(ui, &[&[AddNode, AddFrame, Paste], &[SelectAll, Find], &[FrameView, ArrangeAll]])
}
