//! Widgets of values, chosen by their shape; values inside a value have widgets of their own.

use eframe::egui::{self, ComboBox, Response, RichText, Ui, WidgetText};
use serde_json::{Map, Value as Json, json};

use super::{curve, gradient, list, number};
use crate::editor::shown;
use crate::params::{Choice, Param, Shape};
use crate::text::printable_lines;
use crate::widget::Widget;

/// How the user changed a value in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edited {
    /// The value is unchanged.
    No,
    /// The value has changed and the gesture may go on.
    Going,
    /// The value has changed in one step.
    Done,
}

impl Edited {
    pub(super) fn of(response: &Response) -> Self {
        match (response.changed(), response.dragged()) {
            (true, true) => Self::Going,
            (true, false) => Self::Done,
            _ => Self::No,
        }
    }

    pub(super) fn or(self, other: Self) -> Self {
        if self == Self::No { other } else { self }
    }
}

/// The description of a value that is edited.
pub(super) struct Field<'a> {
    pub(super) name: &'a str,
    pub(super) doc: &'a str,
    pub(super) shape: &'a Shape,
    pub(super) unit: Option<&'a str>,
    pub(super) soft: Option<[f64; 2]>,
    pub(super) widget: Option<Widget>,
    /// The value before the last change, where a widget offers to restore it.
    pub(super) previous: Option<&'a Json>,
    pub(super) pick_file: &'a dyn Fn(&str),
}

impl<'a> Field<'a> {
    /// The description of a parameter.
    pub(super) fn of(param: &'a Param, pick_file: &'a dyn Fn(&str)) -> Self {
        Self {
            name: &param.name,
            doc: &param.doc,
            shape: &param.shape,
            unit: param.unit.as_deref(),
            soft: param.soft,
            widget: param.widget,
            previous: None,
            pick_file,
        }
    }

    /// The description of a part of this value, which has a shape of its own and no name.
    pub(super) fn part(&self, shape: &'a Shape) -> Self {
        Self { shape, previous: None, widget: None, soft: None, ..*self }
    }

    fn is_tall(&self) -> bool {
        match self.shape {
            // A list of a fixed number of numbers fits beside its name.
            Shape::List { item, min, max } => min != max || !matches!(**item, Shape::Number { .. }),
            Shape::Record(_) => true,
            Shape::Choice(modes) => modes.iter().any(|m| !m.fields.is_empty()),
            Shape::Optional(inner) => self.part(inner).is_tall(),
            _ => false,
        }
    }
}

/// Shows a label and a widget in a row; returns the response of the label, which has the help text and the menu.
pub(super) fn labelled(
    ui: &mut Ui,
    field: &Field<'_>,
    label: impl Into<WidgetText>,
    widget: impl FnOnce(&mut Ui),
) -> Response {
    let show = |ui: &mut Ui| {
        let label = egui::Label::new(label.into()).truncate().sense(egui::Sense::click());
        ui.add(label).on_hover_text(format!("{}\n\n{}", shown(field.name), printable_lines(field.doc)))
    };
    if field.is_tall() {
        let label = show(ui);
        ui.indent(field.name, widget);
        return label;
    }
    let shown = ui.horizontal(|ui| {
        let width = (ui.available_width() * 0.36).clamp(70.0, 150.0);
        let height = ui.spacing().interact_size.y;
        let label = ui.allocate_ui_with_layout(
            egui::vec2(width, height),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_width(width);
                show(ui)
            },
        );
        widget(ui);
        label.inner
    });
    shown.inner
}

/// Shows the widget of a value.
pub(super) fn edit(ui: &mut Ui, field: &Field<'_>, value: &mut Json) -> Edited {
    match (field.widget, field.shape) {
        (Some(Widget::Curve), _) => return curve::edit(ui, field.name, value),
        (Some(Widget::Gradient), _) => return gradient::edit(ui, field.name, value),
        (Some(Widget::Seed), _) => return number::seed(ui, field, value),
        (Some(Widget::File), _) => return file(ui, field, value),
        _ => (),
    }
    match field.shape {
        Shape::Number { .. } => number::edit(ui, field, value),
        Shape::Flag => flag(ui, field.name, value),
        Shape::Text { max_length } => text(ui, field.name, *max_length, value),
        Shape::Choice(modes) => choice(ui, field, modes, value),
        Shape::List { item, min, max } => list::edit(ui, field, item, [*min, *max], value),
        Shape::Tuple(parts) => tuple(ui, field, parts, value),
        Shape::Record(fields) => record(ui, field, fields, value),
        Shape::Optional(inner) => optional(ui, field, inner, value),
        Shape::Unknown => {
            ui.weak(shown(&value.to_string()));
            Edited::No
        }
    }
}

fn flag(ui: &mut Ui, name: &str, value: &mut Json) -> Edited {
    let mut on = value.as_bool().unwrap_or_default();
    let toggled = ui.checkbox(&mut on, "");
    named(&toggled, egui::WidgetType::Checkbox, name);
    *value = Json::from(on);
    Edited::of(&toggled)
}

/// Gives a text field a name, beside its text.
pub(crate) fn named_text(response: &Response, text: &str, name: &str) {
    response.widget_info(|| egui::WidgetInfo {
        label: Some(name.to_owned()),
        ..egui::WidgetInfo::text_edit(true, text, text, name)
    });
}

/// Gives a widget without a text a name, for assistive technology and for tests.
pub(crate) fn named(response: &Response, kind: egui::WidgetType, name: &str) {
    response.widget_info(|| egui::WidgetInfo::labeled(kind, true, name));
}

fn text(ui: &mut Ui, name: &str, max: usize, value: &mut Json) -> Edited {
    let mut text = value.as_str().unwrap_or_default().to_owned();
    let edit = if max > 2000 {
        egui::TextEdit::multiline(&mut text).desired_rows(2)
    } else {
        egui::TextEdit::singleline(&mut text)
    };
    let changed = ui.add(edit.char_limit(max).desired_width(f32::INFINITY));
    named(&changed, egui::WidgetType::TextEdit, name);
    *value = Json::from(text);
    // All typing until the field is left is one change.
    match (changed.changed(), changed.lost_focus()) {
        (true, _) => Edited::Going,
        (false, true) => Edited::Done,
        _ => Edited::No,
    }
}

fn file(ui: &mut Ui, field: &Field<'_>, value: &mut Json) -> Edited {
    let row = ui.horizontal(|ui| {
        if ui.button("…").on_hover_text("Choose a file").clicked() {
            (field.pick_file)(field.name);
        }
        text(ui, field.name, 1024, value)
    });
    row.inner
}

fn choice(ui: &mut Ui, field: &Field<'_>, modes: &[Choice], value: &mut Json) -> Edited {
    let own = mode_of(value).unwrap_or_default().to_owned();
    let mut edited = Edited::No;
    let combo = ComboBox::from_id_salt(field.name).selected_text(own.replace('_', " ")).width(150.0);
    let shown = combo.show_ui(ui, |ui| {
        for mode in modes {
            let label = ui.selectable_label(mode.name == own, mode.name.replace('_', " "));
            if label.on_hover_text(&mode.doc).clicked() && mode.name != own {
                *value = made(mode);
                edited = Edited::Done;
            }
        }
    });
    named(&shown.response, egui::WidgetType::ComboBox, field.name);
    if let Some(mode) = modes.iter().find(|m| m.name == own) {
        shown.response.on_hover_text(&mode.doc);
        if !mode.fields.is_empty() && edited == Edited::No {
            let inner = ui.indent(("mode", field.name), |ui| {
                let body = value.as_object_mut().and_then(|o| o.get_mut(&own));
                let Some(body) = body.and_then(Json::as_object_mut) else { return Edited::No };
                fields(ui, field, &mode.fields, body)
            });
            edited = inner.inner;
        }
    }
    edited
}

/// The mode of a choice: the string itself, or the only key of an object.
pub(super) fn mode_of(value: &Json) -> Option<&str> {
    match value {
        Json::String(name) => Some(name),
        Json::Object(map) => map.keys().next().map(String::as_str),
        _ => None,
    }
}

/// A mode with the default values of its fields.
fn made(mode: &Choice) -> Json {
    if mode.fields.is_empty() {
        return Json::from(mode.name.as_str());
    }
    let fields = mode.fields.iter().map(|p| (p.name.clone(), fresh(&p.shape, &p.default)));
    json!({ mode.name.as_str(): fields.collect::<Map<_, _>>() })
}

/// The initial value: the default, or the least value that the shape allows.
pub(super) fn fresh(shape: &Shape, default: &Json) -> Json {
    if !default.is_null() {
        return default.clone();
    }
    match shape {
        Shape::Number { min, max, integer } => {
            let at = if *min <= 0.0 && *max >= 0.0 { 0.0 } else { *min };
            if *integer { Json::from(at as i64) } else { Json::from(at) }
        }
        Shape::Flag => Json::from(false),
        Shape::Text { .. } => Json::from(""),
        Shape::Choice(modes) => modes.first().map_or(Json::Null, made),
        Shape::List { item, min, .. } => Json::from(vec![fresh(item, &Json::Null); *min]),
        Shape::Tuple(parts) => parts.iter().map(|p| fresh(p, &Json::Null)).collect(),
        Shape::Record(fields) => {
            let all = fields.iter().map(|p| (p.name.clone(), fresh(&p.shape, &p.default)));
            Json::Object(all.collect())
        }
        Shape::Optional(_) | Shape::Unknown => Json::Null,
    }
}

fn tuple(ui: &mut Ui, field: &Field<'_>, parts: &[Shape], value: &mut Json) -> Edited {
    let Some(items) = value.as_array_mut() else { return Edited::No };
    let row = ui.horizontal(|ui| {
        let each = parts.iter().zip(items.iter_mut()).enumerate();
        each.fold(Edited::No, |edited, (i, (shape, item))| {
            let name = format!("{} {i}", field.name);
            let part = Field { name: &name, ..field.part(shape) };
            let own = if matches!(shape, Shape::Number { .. }) {
                number::bare(ui, &part, item)
            } else {
                edit(ui, &part, item)
            };
            edited.or(own)
        })
    });
    row.inner
}

fn record(ui: &mut Ui, field: &Field<'_>, params: &[Param], value: &mut Json) -> Edited {
    match value.as_object_mut() {
        Some(object) => fields(ui, field, params, object),
        None => Edited::No,
    }
}

/// Shows the named values inside a value.
pub(super) fn fields(
    ui: &mut Ui,
    field: &Field<'_>,
    params: &[Param],
    object: &mut Map<String, Json>,
) -> Edited {
    params.iter().fold(Edited::No, |edited, param| {
        let inner = Field::of(param, field.pick_file);
        let mut value =
            object.get(&param.name).cloned().unwrap_or_else(|| fresh(&param.shape, &param.default));
        let mut own = Edited::No;
        let label = RichText::new(param.name.replace('_', " ")).size(12.5);
        labelled(ui, &inner, label, |ui| {
            ui.push_id(&param.name, |ui| own = edit(ui, &inner, &mut value));
        });
        if own != Edited::No {
            object.insert(param.name.clone(), value);
        }
        edited.or(own)
    })
}

fn optional(ui: &mut Ui, field: &Field<'_>, inner: &Shape, value: &mut Json) -> Edited {
    let mut on = !value.is_null();
    let toggled = ui.checkbox(&mut on, "");
    named(&toggled, egui::WidgetType::Checkbox, &format!("{} is set", field.name));
    if toggled.changed() {
        *value = if on { fresh(inner, &Json::Null) } else { Json::Null };
        return Edited::Done;
    }
    if on { edit(ui, &Field { soft: field.soft, ..field.part(inner) }, value) } else { Edited::No }
}
