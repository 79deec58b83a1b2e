//! The manual pages say what stands in every list and object, from the schema.

use orograph::params::page::{rows, sections};
use orograph::params::{Param, Shape};
use serde_json::{Value as Json, json};

use crate::rig::shipped;

/// Whether a shape holds objects, or lists of lists.
fn is_structured(shape: &Shape) -> bool {
    match shape {
        Shape::Optional(inner) => is_structured(inner),
        Shape::List { .. } | Shape::Record(_) | Shape::Tuple(_) => true,
        _ => false,
    }
}

/// What a page leaves open about some parameters and all that stands in them.
fn gaps(place: &str, params: &[Param], top: bool, gaps: &mut Vec<String>) {
    for p in params {
        let place = format!("{place}.{}", p.name);
        let mut say = |what: &str| gaps.push(format!("{place}: {what}"));
        if p.doc.len() < 10 {
            say("no words");
        }
        if !top
            && p.default.is_null()
            && !p.required
            && !matches!(p.shape, Shape::List { .. } | Shape::Text { .. })
        {
            say("neither required nor with a default");
        }
        inner(&place, &p.shape, p, gaps);
    }
}

fn inner(place: &str, shape: &Shape, p: &Param, all: &mut Vec<String>) {
    match shape {
        Shape::Optional(shape) => inner(place, shape, p, all),
        Shape::Record(fields) => gaps(place, fields, false, all),
        Shape::Choice(modes) => {
            for mode in modes {
                if mode.doc.len() < 10 {
                    all.push(format!("{place}: {}: no words", mode.name));
                }
                gaps(&format!("{place}.{}", mode.name), &mode.fields, false, all);
            }
        }
        Shape::List { item, min, max } => match &**item {
            Shape::Number { .. } => {
                // Nobody can guess what a number of a list is.
                if p.items.is_empty() || (min == max && p.items.len() != *max) || max % p.items.len() != 0 {
                    all.push(format!("{place}: {max} numbers, named {:?}", p.items));
                }
            }
            item => inner(place, item, p, all),
        },
        Shape::Tuple(_) | Shape::Unknown => all.push(format!("{place}: a form that pages cannot tell")),
        Shape::Number { .. } | Shape::Flag | Shape::Text { .. } => (),
    }
}

/// The parameter of a path such as `palette.custom.stops`, set to a value.
fn set(path: &str, value: &Json) -> Json {
    path.rsplit('.').fold(value.clone(), |value, name| json!({ name: value }))
}

#[test]
fn pages_say_what_stands_in_every_list_and_object() {
    let (mut all, mut told) = (Vec::new(), 0);
    for kind in shipped() {
        gaps(&kind.id, kind.params(), true, &mut all);
        let sections = sections(kind.params());
        for p in kind.params().iter().filter(|p| is_structured(&p.shape)) {
            if !sections.iter().any(|s| s.name == p.name) {
                all.push(format!("{}.{}: no section", kind.id, p.name));
            }
        }
        for section in &sections {
            told += 1;
            if section.form.len() < 10 || section.form.contains("  ") {
                all.push(format!("{}.{}: {:?}", kind.id, section.name, section.form));
            }
            // The example is one: it parses, and the kind takes it.
            let example = set(&section.name, &section.example);
            let map = example.as_object().unwrap().clone();
            if section.example.is_null() {
                all.push(format!("{}.{}: no example", kind.id, section.name));
            } else if let Err(e) = kind.parse(&map) {
                all.push(format!("{}.{}: its example: {e}", kind.id, section.name));
            }
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
    assert!(told >= 10, "{told}");
}

#[test]
fn a_member_without_words_or_names_is_found() {
    let schema = json!({ "properties": {
        "good": { "description": "Words that say it.", "type": "number", "minimum": 0, "maximum": 1, "default": 0 },
        "mute": { "type": "number", "default": 0 },
        "flat": { "description": "Words that say it.", "type": "array", "items": { "type": "number" } },
        "open": { "description": "Words that say it.", "type": "number" },
    } });
    let list = json!({ "properties": { "all": {
        "description": "Words that say it.", "type": "array", "items": { "type": "object", "properties": schema["properties"] }
    } } });
    let params = orograph::params::of_schema(&list, &json!({}));
    let mut found = Vec::new();
    gaps("kind", &params, true, &mut found);
    let named: Vec<&str> = found.iter().filter_map(|g| g.split(':').next()).collect();
    assert_eq!(named, ["kind.all.mute", "kind.all.flat", "kind.all.open"], "{found:?}");
}

#[test]
fn pages_name_what_people_look_for() {
    let page = |id: &str| {
        let kind = shipped().into_iter().find(|k| k.id == id).unwrap();
        let rows = rows(kind.params()).into_iter();
        let inner = sections(kind.params()).into_iter().flat_map(|s| {
            let head = format!("{} {}", s.name, s.form);
            s.rows
                .into_iter()
                .map(|r| format!("{} {} {} {}", r.name, r.default, r.range, r.doc))
                .chain([head])
        });
        rows.map(|r| format!("{} {} {} {}", r.name, r.default, r.range, r.doc))
            .chain(inner)
            .collect::<Vec<_>>()
            .join("\n")
    };
    for (id, words) in [
        (
            "paint_mask",
            &[
                "softness `0.7` 0 to 1",
                "strength `1.0` 0 to 1",
                "value `1.0` 0 to 1",
                "path",
                "radius `300.0` m",
            ][..],
        ),
        (
            "feature_curves",
            &[
                "`[u, height, radius, u, height, radius, …]`",
                "through",
                "rise `\"monotone\"`",
                "4096 objects",
            ],
        ),
        (
            "import_curves",
            &[
                "height: property",
                "`{\"property\": {\"name\": …, \"factor\": …}}`",
                "`{\"z\": {\"factor\": …}}`",
                "right_blend `\"none\"` as `height`",
            ],
        ),
        (
            "colorize",
            &["palette.custom.stops A list of 1 to 64, each `[position, red, green, blue]`, 0 to 1."],
        ),
        ("curve", &["points A list of 2 to 32, each `[share, becomes]`, 0 to 1."]),
        ("ridge_line", &["through A list of 2 to 1024, each `[east, south, height]`"]),
        ("gradient", &["center `[east, south]`"]),
    ] {
        let page = page(id);
        for word in words {
            assert!(page.contains(word), "{id} does not say {word:?}:\n{page}");
        }
    }
}
