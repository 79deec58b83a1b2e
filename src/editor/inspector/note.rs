//! The panel of a note.

use eframe::egui::{self, Color32, Stroke, Ui};

use super::Panel;
use super::value::named;
use crate::editor::theme::{CHOSEN, note_color};
use crate::graph::NoteColor;

/// The id under which egui stores that the title gets the focus in the next frame.
pub(crate) fn focus_note() -> egui::Id {
    egui::Id::new("title next")
}

/// Shows title, text and colour of a note.
pub(crate) fn note_panel(ui: &mut Ui, panel: &mut Panel<'_>, name: &str) {
    let Some(own) = panel.graph().note(name).cloned() else { return };
    let mut next = own.clone();
    let title = egui::TextEdit::singleline(&mut next.title).hint_text("Title").char_limit(200);
    let title = ui.add(title.desired_width(f32::INFINITY));
    named(&title, egui::WidgetType::TextEdit, "Note title");
    if ui.ctx().data_mut(|d| d.remove_temp::<bool>(focus_note())).is_some() {
        title.request_focus();
        // The initial title is selected, so that typing replaces it.
        if let Some(mut state) = egui::TextEdit::load_state(ui.ctx(), title.id) {
            let end = egui::text::CCursor::new(next.title.chars().count());
            state
                .cursor
                .set_char_range(Some(egui::text::CCursorRange::two(egui::text::CCursor::new(0), end)));
            state.store(ui.ctx(), title.id);
        }
    }
    let text = egui::TextEdit::multiline(&mut next.text).hint_text("Text").desired_rows(6);
    let text = ui.add(text.desired_width(f32::INFINITY).char_limit(4000));
    named(&text, egui::WidgetType::TextEdit, "Note text");
    ui.horizontal(|ui| {
        for color in NoteColor::ALL {
            let stroke = if color == next.color { Stroke::new(2.0, CHOSEN) } else { Stroke::NONE };
            let button = egui::Button::new(egui::RichText::new("    ").color(Color32::WHITE));
            let button = ui.add(button.fill(note_color(color)).stroke(stroke));
            named(&button, egui::WidgetType::Button, color.name());
            if button.on_hover_text(color.name()).clicked() {
                next.color = color;
            }
        }
    });
    if next != own {
        let gesture = format!("note {name}");
        panel.apply("Edit note", &gesture, |g| g.change_note(name, next));
    }
}
