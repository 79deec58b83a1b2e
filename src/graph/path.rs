//! Dotted paths into parameters: `angle`, `mode.turned.angle`, `points.0.1`.

use std::sync::Arc;

use serde_json::{Map, Value as Json};

use super::problem::{Hints, listed};
use crate::params::packed::{Packed, View, number_of};
use crate::params::{Param, Shape};

/// What stands at the end of a path.
pub(super) struct Spot<'a> {
    /// The innermost named parameter.
    pub(super) param: &'a Param,
    /// The shape of fitting values.
    pub(super) shape: &'a Shape,
    /// The value there.
    pub(super) value: View<'a>,
}

/// Follows a path below a parameter with a value.
///
/// # Errors
/// Returns a sentence without a subject that names the step that does not exist.
pub(super) fn walk<'a>(
    param: &'a Param,
    value: View<'a>,
    path: &[&str],
    hints: &Hints,
) -> Result<Spot<'a>, String> {
    step(param, &param.shape, value, path, hints)
}

fn step<'a>(
    param: &'a Param,
    shape: &'a Shape,
    value: View<'a>,
    path: &[&str],
    hints: &Hints,
) -> Result<Spot<'a>, String> {
    let Some((&first, rest)) = path.split_first() else {
        return Ok(Spot { param, shape, value });
    };
    match shape {
        Shape::Optional(inner) => step(param, inner, value, path, hints),
        Shape::Choice(modes) => {
            let names = || modes.iter().map(|m| m.name.as_str());
            let Some(mode) = modes.iter().find(|m| m.name == first) else {
                let hint = hints.nearest(first, names());
                return Err(format!("has no mode `{first}`; it has {}{hint}", listed(names())));
            };
            let Some(body) = value.member(first) else {
                let current = value.mode().unwrap_or("none");
                return Err(format!("is in the mode `{current}`, not in `{first}`: set the mode first"));
            };
            if rest.is_empty() {
                return Err(format!("has `{first}` as a mode, not as a setting: set one of {} in it", {
                    listed(mode.fields.iter().map(|f| f.name.as_str()))
                }));
            }
            field(&mode.fields, body, rest, hints)
        }
        Shape::Record(fields) => field(fields, value, path, hints),
        Shape::Tuple(shapes) => {
            let (i, item) = item(value, first)?;
            let shape = shapes.get(i).ok_or_else(|| no_item(first, shapes.len()))?;
            step(param, shape, item, rest, hints)
        }
        Shape::List { item: shape, .. } => step(param, shape, item(value, first)?.1, rest, hints),
        Shape::Number { .. } | Shape::Flag | Shape::Text { .. } | Shape::Unknown => {
            Err(format!("has nothing inside it, so no `{first}`"))
        }
    }
}

fn field<'a>(fields: &'a [Param], value: View<'a>, path: &[&str], hints: &Hints) -> Result<Spot<'a>, String> {
    let Some((&name, rest)) = path.split_first() else { return Err("has no name after the dot".to_owned()) };
    let names = || fields.iter().map(|f| f.name.as_str());
    let Some(param) = fields.iter().find(|f| f.name == name) else {
        return Err(format!("has no `{name}`; it has {}{}", listed(names()), hints.nearest(name, names())));
    };
    walk(param, value.member(name).unwrap_or(View::Json(&param.default)), rest, hints)
}

fn item<'a>(value: View<'a>, name: &str) -> Result<(usize, View<'a>), String> {
    let found = name.parse().ok().and_then(|i: usize| Some((i, value.item(i)?)));
    found.ok_or_else(|| no_item(name, value.items().unwrap_or(0)))
}

fn no_item(name: &str, len: usize) -> String {
    format!("has no item `{name}`; it has {len}, counted from 0")
}

/// The value at the end of a path.
pub(super) fn get<'a>(value: View<'a>, path: &[&str]) -> Option<View<'a>> {
    path.iter().try_fold(value, |v, step| match v.items() {
        Some(_) => v.item(step.parse().ok()?),
        None => v.member(step),
    })
}

/// Writes a value at the end of a path, as [`put`] does. What stands beside the path is shared with copies of the value
/// and stays so.
pub(super) fn put_packed(value: &mut Packed, path: &[&str], new: Json) {
    let Some((&first, rest)) = path.split_first() else {
        *value = Packed::from(new);
        return;
    };
    let place = first.parse::<usize>().ok();
    if let Packed::Numbers(numbers) = value
        && let (Some(i), Some(number), []) = (place.filter(|i| *i < numbers.len()), number_of(&new), rest)
    {
        Arc::make_mut(numbers)[i] = number;
        return;
    }
    match value {
        Packed::List(items) => {
            if let Some(i) = place.filter(|i| *i < items.len()) {
                put_packed(&mut Arc::make_mut(items)[i], rest, new);
            }
        }
        Packed::Record(record) => put_packed(record.entry(first, || Packed::from(Json::Null)), rest, new),
        Packed::Numbers(_) | Packed::Other(_) => {
            let mut json = value.json();
            put(&mut json, path, new);
            *value = Packed::from(json);
        }
    }
}

/// Writes a value at the end of a path that [`walk`] has followed; missing objects on the way are made.
pub(super) fn put(value: &mut Json, path: &[&str], new: Json) {
    let Some((&first, rest)) = path.split_first() else {
        *value = new;
        return;
    };
    if let Json::Array(items) = value {
        if let Some(item) = first.parse().ok().and_then(|i: usize| items.get_mut(i)) {
            put(item, rest, new);
        }
        return;
    }
    if !value.is_object() {
        *value = Json::Object(Map::new());
    }
    if let Json::Object(map) = value {
        put(map.entry(first).or_insert(Json::Null), rest, new);
    }
}
