//! Every kind has a page: words, units and ranges for all that it takes and gives.

use orograph::node::Kind;
use orograph::params::{Param, Shape};

use crate::kinds::registry;
use crate::rig::shipped;

#[test]
fn every_kind_is_documented() {
    let bad: Vec<String> = shipped().into_iter().flat_map(gaps).collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn a_kind_without_words_is_found() {
    let found = gaps(registry().find("mute").unwrap());
    for gap in [
        "mute: no page",
        "mute: port field has no words",
        "mute: no keywords",
        "mute.silent: no words",
        "mute.silent: no unit",
        "mute.endless: no range",
        "mute.mode: modes without words: loud",
        "mute.mode.quiet.level: no words",
    ] {
        assert!(found.iter().any(|f| f == gap), "{gap} is not among {found:#?}");
    }
    // And where there are words nothing is found.
    assert!(!found.iter().any(|f| f.contains("mute.told")), "{found:#?}");
}

/// What the page of a kind lacks.
fn gaps(kind: &Kind) -> Vec<String> {
    let mut bad = Vec::new();
    let doc = kind.doc();
    let first = doc.lines().next().unwrap_or_default();
    if first.len() < 15 || !(doc.contains(". ") || doc.contains(".\n") || doc.ends_with('.')) {
        bad.push(format!("{}: no page", kind.id));
    }
    let ports = kind.inputs.iter().chain(&kind.outputs).filter(|p| p.doc.len() < 10);
    bad.extend(ports.map(|p| format!("{}: port {} has no words", kind.id, p.name)));
    of_params(&kind.id, kind.params(), true, &mut bad);
    if kind.keywords.is_empty() {
        bad.push(format!("{}: no keywords", kind.id));
    }
    if kind.version as usize != kind.migrations.len() + 1 {
        bad.push(format!("{}: version {} without its migrations", kind.id, kind.version));
    }
    bad
}

fn of_params(path: &str, params: &[Param], top: bool, bad: &mut Vec<String>) {
    for p in params {
        let path = format!("{path}.{}", p.name);
        of_param(&path, p, top, bad);
        if let Shape::Choice(modes) = &p.shape {
            modes.iter().for_each(|m| of_params(&format!("{path}.{}", m.name), &m.fields, false, bad));
        }
    }
}

fn of_param(path: &str, p: &Param, top: bool, bad: &mut Vec<String>) {
    let mut say = |what: String| bad.push(format!("{path}: {what}"));
    if p.doc.len() < 5 {
        say("no words".into());
    }
    let mut shape = &p.shape;
    while let Shape::Optional(inner) | Shape::List { item: inner, .. } = shape {
        shape = inner;
    }
    match shape {
        Shape::Number { min, max, .. } => {
            if *min <= f64::MIN || *max >= f64::MAX {
                say("no range".into());
            }
            if p.unit.is_none() && p.widget.is_none() {
                say("no unit".into());
            }
        }
        Shape::Choice(modes) => {
            let mute: Vec<_> = modes.iter().filter(|m| m.doc.len() < 5).map(|m| m.name.as_str()).collect();
            if !mute.is_empty() {
                say(format!("modes without words: {}", mute.join(", ")));
            }
        }
        Shape::Unknown => say("a schema that no panel can show".into()),
        _ => (),
    }
    if top && let Err(e) = p.shape.check(&p.default) {
        say(format!("the default {e}"));
    }
}
