//! The widget of lists: one row an item; items can be added, removed and moved.

use eframe::egui::{self, ScrollArea, Ui};
use serde_json::Value as Json;

use super::number::bare;
use super::value::{Edited, Field, edit as edit_value, fresh};
use crate::params::Shape;
use crate::widget::Widget;

/// Items on a page; longer lists have several pages.
const PAGE: usize = 100;

pub(super) fn edit(
    ui: &mut Ui,
    field: &Field<'_>,
    item: &Shape,
    [min, max]: [usize; 2],
    value: &mut Json,
) -> Edited {
    let Some(items) = value.as_array_mut() else { return Edited::No };
    if min == max && matches!(item, Shape::Number { .. }) {
        return fixed(ui, field, item, items);
    }
    let mut edited = Edited::No;
    let mut removed = None;
    ui.horizontal(|ui| {
        ui.weak(format!("{} items", items.len()));
        let add = ui.add_enabled(items.len() < max, egui::Button::new("➕ Add").small());
        if add.clicked() {
            let new = items.last().cloned().unwrap_or_else(|| fresh(item, &Json::Null));
            items.push(new);
            edited = Edited::Done;
        }
    });
    let tall = matches!(item, Shape::Record(_));
    let show = |ui: &mut Ui, items: &mut Vec<Json>, edited: &mut Edited, removed: &mut Option<usize>| {
        let fewest = items.len() <= min;
        for (i, one) in items.iter_mut().enumerate().take(PAGE) {
            ui.push_id(i, |ui| {
                let name = format!("{} {i}", field.name);
                let part = Field { name: &name, ..field.part(item) };
                let mut row = |ui: &mut Ui| {
                    let remove = ui.add_enabled(!fewest, egui::Button::new("✖").small());
                    if remove.on_hover_text("Remove this item").clicked() {
                        *removed = Some(i);
                    }
                    *edited = edited.or(edit_value(ui, &part, one));
                };
                if tall {
                    egui::CollapsingHeader::new(&name).show(ui, row);
                } else {
                    ui.horizontal(|ui| row(ui));
                }
            });
        }
        if items.len() > PAGE {
            ui.weak(format!("… and {} more, in the file", items.len() - PAGE));
        }
    };
    if items.len() > 6 {
        let scroll = ScrollArea::vertical().id_salt(field.name).max_height(240.0);
        scroll.show(ui, |ui| show(ui, items, &mut edited, &mut removed));
    } else {
        show(ui, items, &mut edited, &mut removed);
    }
    if let Some(i) = removed {
        items.remove(i);
        edited = Edited::Done;
    }
    edited
}

/// Shows a list of fixed length side by side.
fn fixed(ui: &mut Ui, field: &Field<'_>, item: &Shape, items: &mut [Json]) -> Edited {
    let axes: &[&str] = if field.widget == Some(Widget::Point) { &["east", "south"] } else { &[] };
    let row = ui.horizontal(|ui| {
        items.iter_mut().enumerate().fold(Edited::No, |edited, (i, one)| {
            let name = match axes.get(i) {
                Some(axis) => {
                    ui.weak(*axis);
                    format!("{} {axis}", field.name)
                }
                None => format!("{} {i}", field.name),
            };
            edited.or(bare(ui, &Field { name: &name, ..field.part(item) }, one))
        })
    });
    row.inner
}
