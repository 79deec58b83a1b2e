//! Dotted paths into parameters: `angle`, `mode.turned.angle`, `points.0.1`.

use serde_json::{Map, Value as Json};

use super::problem::{Hints, listed};
use crate::params::{Param, Shape};

/// What stands at the end of a path.
pub(super) struct Spot<'a> {
    /// The innermost named parameter.
    pub(super) param: &'a Param,
    /// The shape of fitting values.
    pub(super) shape: &'a Shape,
    /// The value there.
    pub(super) value: Json,
}

/// Follows a path below a parameter with a value.
///
/// # Errors
/// Returns a sentence without a subject that names the step that does not exist.
pub(super) fn walk<'a>(
    param: &'a Param,
    value: &Json,
    path: &[&str],
    hints: &Hints,
) -> Result<Spot<'a>, String> {
    step(param, &param.shape, value, path, hints)
}

fn step<'a>(
    param: &'a Param,
    shape: &'a Shape,
    value: &Json,
    path: &[&str],
    hints: &Hints,
) -> Result<Spot<'a>, String> {
    let Some((&first, rest)) = path.split_first() else {
        return Ok(Spot { param, shape, value: value.clone() });
    };
    match shape {
        Shape::Optional(inner) => step(param, inner, value, path, hints),
        Shape::Choice(modes) => {
            let names = || modes.iter().map(|m| m.name.as_str());
            let Some(mode) = modes.iter().find(|m| m.name == first) else {
                let hint = hints.nearest(first, names());
                return Err(format!("has no mode `{first}`; it has {}{hint}", listed(names())));
            };
            let Some(body) = value.get(first) else {
                let current =
                    value.as_str().or(value.as_object().and_then(|o| o.keys().next()).map(String::as_str));
                let current = current.unwrap_or("none");
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

fn field<'a>(fields: &'a [Param], value: &Json, path: &[&str], hints: &Hints) -> Result<Spot<'a>, String> {
    let Some((&name, rest)) = path.split_first() else { return Err("has no name after the dot".to_owned()) };
    let names = || fields.iter().map(|f| f.name.as_str());
    let Some(param) = fields.iter().find(|f| f.name == name) else {
        return Err(format!("has no `{name}`; it has {}{}", listed(names()), hints.nearest(name, names())));
    };
    walk(param, value.get(name).unwrap_or(&param.default), rest, hints)
}

fn item<'a>(value: &'a Json, name: &str) -> Result<(usize, &'a Json), String> {
    let items = value.as_array().map_or(&[][..], Vec::as_slice);
    let found = name.parse().ok().and_then(|i: usize| Some((i, items.get(i)?)));
    found.ok_or_else(|| no_item(name, items.len()))
}

fn no_item(name: &str, len: usize) -> String {
    format!("has no item `{name}`; it has {len}, counted from 0")
}

/// The value at the end of a path.
pub(super) fn get<'a>(value: &'a Json, path: &[&str]) -> Option<&'a Json> {
    path.iter().try_fold(value, |v, step| match v {
        Json::Array(items) => items.get(step.parse::<usize>().ok()?),
        other => other.get(step),
    })
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
