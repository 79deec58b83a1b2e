//! The desktop editor: a face of the [`graph`](crate::graph) and the [`engine`](crate::engine), behind the default
//! feature `editor`.
//!
//! The document (`document`) is the graph with a history of whole states, so that every change can be undone to the
//! same bytes. The canvas (`canvas`) draws the document itself and keeps no copy. The evaluator (`evaluator`) runs the
//! engine on a thread of its own and puts the results on a board (`board`) that the window reads; a new order cancels
//! work on the order before. The user draws curves and masks on the terrain of either view (`drawing`), which changes
//! parameters as the panels do. Every named action is a `Command`: menus, keys, palette and cheat sheet are made from
//! one list. The panels (`inspector`) are made from the schema of the kinds.

mod actions;
mod app;
mod ask;
mod board;
mod build;
mod canvas;
mod command;
mod dialogs;
mod document;
mod draft;
mod drawing;
mod evaluator;
mod file_watch;
mod fuzzy;
mod history;
mod inspector;
mod node_progress;
mod notices;
mod ops;
mod order;
mod panels;
mod preferences;
mod recovery;
mod session;
mod shade;
mod theme;
mod view_bar;
mod views;
mod welcome;

use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui;

pub use app::{Editor, Setup};
pub use ask::{Answer, Asker, Question};
pub use document::Document;

use crate::render::Picture;

/// Opens the window and edits until it is closed.
///
/// # Errors
/// Fails when there is no display or no graphics device; the message says what to install.
pub fn run(path: Option<PathBuf>) -> Result<(), String> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("Orograph")
        .with_app_id("orograph")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([720.0, 480.0]);
    let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let setup = Setup { path, home: eframe::storage_dir("orograph"), ..Setup::default() };
    let ran = eframe::run_native(
        "orograph",
        options,
        Box::new(|cx| {
            let format = cx.wgpu_render_state.as_ref().map(|state| state.target_format);
            Ok(Box::new(Editor::new(&cx.egui_ctx, Setup { format, ..setup })))
        }),
    );
    ran.map_err(|e| no_window(&e.to_string()))
}

/// The message that the editor cannot open a window, from that of the library.
fn no_window(message: &str) -> String {
    let why = without_sources(message);
    // Some messages end in a full stop, and one follows here.
    let why = why.trim_end_matches('.');
    format!(
        "the editor cannot open a window: {why}. It needs a screen and a graphics driver (on a machine without a \
         graphics card, Mesa's software Vulkan serves: `mesa-vulkan-drivers`); the other commands need neither"
    )
}

/// A message without the source locations that some libraries put into theirs, such as `os error at /…/lib.rs:12: …`.
fn without_sources(message: &str) -> String {
    let is_place = |word: &&str| {
        let word = word.trim_end_matches(':');
        word.rsplit_once(".rs:").is_some_and(|(_, n)| n.bytes().all(|b| b.is_ascii_digit() || b == b':'))
    };
    let words: Vec<&str> = message.split_whitespace().collect();
    let before_place = |i: usize| words[i] == "at" && words.get(i + 1).is_some_and(is_place);
    let kept = (0..words.len()).filter(|i| !is_place(&words[*i]) && !before_place(*i));
    kept.map(|i| words[i]).collect::<Vec<_>>().join(" ")
}

/// A text from a graph or a file name as one printable line.
fn shown(text: &str) -> String {
    crate::text::printable(text).into_owned()
}

/// A picture in the form that egui uploads as a texture.
fn image_of(picture: &Picture) -> egui::ImageData {
    let pixels = picture.rgb.iter().map(|c| egui::Color32::from_rgb(c[0], c[1], c[2])).collect();
    let size = [picture.width, picture.height];
    egui::ImageData::Color(Arc::new(egui::ColorImage::new(size, pixels)))
}

#[cfg(test)]
mod tests {
    use super::{no_window, without_sources};

    #[test]
    fn messages_lose_the_places_in_the_source() {
        let message = "winit EventLoopError: os error at /home/x/.cargo/winit-0.30/src/linux/mod.rs:764: neither WAYLAND_DISPLAY nor DISPLAY is set.";
        let clean = "winit EventLoopError: os error neither WAYLAND_DISPLAY nor DISPLAY is set.";
        assert_eq!(without_sources(message), clean);
        assert_eq!(without_sources("look at a.rs for more"), "look at a.rs for more");
        for message in ["no DISPLAY is set.", "no DISPLAY is set"] {
            assert!(no_window(message).contains("no DISPLAY is set. It needs a screen"), "{message}");
        }
    }
}
