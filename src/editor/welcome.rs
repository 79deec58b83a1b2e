//! The first-run page, which offers three presets.

use std::io::Cursor;

use eframe::egui::{self, Color32, ColorImage, Context, Id, RichText, TextureHandle, Ui, vec2};

use super::app::{Editor, FileFor};
use super::dialogs::{Dialog, modal};
use super::document::Document;
use crate::graph::Graph;

/// A preset that comes with the program.
struct Preset {
    name: &'static str,
    about: &'static str,
    graph: &'static [u8],
    /// Drawn by `orograph render graphs/NAME.graph --view perspective --width 320 --height 180 --color map`.
    picture: &'static [u8],
}

const PRESETS: [Preset; 3] = [
    Preset {
        name: "First light",
        about: "Noise, terraces and colours: a whole graph to look around in",
        graph: include_bytes!("../../graphs/first_light.graph"),
        picture: include_bytes!("welcome/first_light.png"),
    },
    Preset {
        name: "Mountain",
        about: "A massif drawn with 59 feature curves: select the node `curves` and pull",
        graph: include_bytes!("../../graphs/mountain.graph"),
        picture: include_bytes!("welcome/mountain.png"),
    },
    Preset {
        name: "Volcanic island",
        about: "Curves, diffusion and noise around a crater",
        graph: include_bytes!("../../graphs/volcanic_island.graph"),
        picture: include_bytes!("welcome/volcanic_island.png"),
    },
];

impl Editor {
    pub(super) fn welcome(&mut self, ctx: &Context) -> Option<Dialog> {
        let mut chosen = None;
        let mut stays = true;
        let closed = modal(ctx, "welcome", 700.0, |ui| {
            ui.heading("Orograph");
            ui.label("Terrain from a graph of nodes: the same at any size, in metres, to the bit.");
            ui.add_space(10.0);
            ui.columns(PRESETS.len(), |columns| {
                for (ui, preset) in columns.iter_mut().zip(&PRESETS) {
                    if shown(ui, preset) {
                        chosen = Some(preset);
                    }
                }
            });
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                if ui.button("Empty graph").clicked() {
                    stays = false;
                }
                if ui.button("Open…").clicked() {
                    self.ask(ctx, FileFor::Open);
                    stays = false;
                }
                ui.weak("Tab adds a node, K draws on the terrain, F1 shows all keys.");
            });
        });
        if let Some(preset) = chosen {
            if let Ok(graph) = Graph::from_bytes(preset.graph, &self.registry) {
                self.adopt(ctx, Document::adopted(graph, "Preset"));
            }
        } else if stays && !closed {
            return Some(Dialog::Welcome);
        }
        self.preferences.welcomed = true;
        self.write_preferences();
        None
    }
}

/// Shows a preset as a picture with its name; returns whether it was clicked.
fn shown(ui: &mut Ui, preset: &Preset) -> bool {
    let width = ui.available_width();
    let size = vec2(width, width * 9.0 / 16.0);
    let clicked = match picture(ui.ctx(), preset) {
        Some(texture) => {
            let image = egui::Image::new((texture.id(), size)).corner_radius(4);
            let button = ui.add(egui::Button::image(image).frame(false));
            super::inspector::named(
                &button,
                egui::WidgetType::Button,
                &format!("picture of {}", preset.name),
            );
            button.clicked()
        }
        None => false,
    };
    let named = ui.add(egui::Button::new(RichText::new(preset.name).strong())).clicked();
    ui.add(egui::Label::new(RichText::new(preset.about).weak()).wrap());
    clicked || named
}

/// The texture of a preset's picture, which is decoded once.
fn picture(ctx: &Context, preset: &Preset) -> Option<TextureHandle> {
    let id = Id::new(("welcome", preset.name));
    if let Some(found) = ctx.data(|d| d.get_temp::<TextureHandle>(id)) {
        return Some(found);
    }
    let texture = ctx.load_texture(preset.name, decoded(preset.picture)?, egui::TextureOptions::LINEAR);
    ctx.data_mut(|d| d.insert_temp(id, texture.clone()));
    Some(texture)
}

fn decoded(bytes: &[u8]) -> Option<ColorImage> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let mut data = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut data).ok()?;
    let (pixels, _) = data.as_chunks::<3>();
    let pixels: Vec<Color32> = pixels.iter().map(|[r, g, b]| Color32::from_rgb(*r, *g, *b)).collect();
    let size = [info.width as usize, info.height as usize];
    (pixels.len() == size[0] * size[1]).then(|| ColorImage::new(size, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::Registry;

    #[test]
    fn every_preset_can_be_read_and_seen() {
        for preset in &PRESETS {
            assert!(decoded(preset.picture).is_some(), "{}", preset.name);
            let graph = Graph::from_bytes(preset.graph, &Registry::standard()).expect("a graph");
            assert!(graph.outputs().len() > 0, "{}", preset.name);
        }
    }
}
