//! The parameter sets that every kind is tried with.

use orograph::kit::hash;
use orograph::node::Kind;
use orograph::params::{Param, Shape};
use orograph::widget::Widget;
use serde_json::{Map, Value as Json, json};

/// What a graph sets of a node; the rest has its defaults.
pub(crate) type Set = Map<String, Json>;

/// Where in the range of a number the rig looks beside its ends: about a third of the way, at no round number.
const THIRD: f64 = 0.37;

/// Longest time in hours that a node of the rig works through.
const BRIEF: f64 = 0.03;

/// A set with times in hours cut short: a day of rain takes the machine minutes, and two minutes of it show the laws as well.
pub(crate) fn brief(kind: &Kind, set: &Set) -> Set {
    let mut set = set.clone();
    for p in kind.params().iter().filter(|p| p.unit.as_deref() == Some("h")) {
        let hours = set.get(&p.name).and_then(Json::as_f64).unwrap_or(BRIEF);
        set.insert(p.name.clone(), json!(hours.min(BRIEF)));
    }
    set
}

/// The defaults alone.
pub(crate) fn defaults() -> Set {
    Set::new()
}

/// The defaults, each mode of each choice, each number at a third.
pub(crate) fn usual(kind: &Kind) -> Vec<Set> {
    let mut all = vec![defaults()];
    for p in tried(kind) {
        let values = match p.shape {
            Shape::Number { .. } | Shape::Optional(_) => third(&p.shape).into_iter().collect(),
            Shape::Choice(_) | Shape::Flag => extremes(&p.shape, &p.default),
            _ => Vec::new(),
        };
        all.extend(values.into_iter().map(|v| one(&p.name, v)));
    }
    all
}

/// The usual ones, each number at its ends, three random pairs, and the lowest and the highest of everything.
pub(crate) fn all(kind: &Kind) -> Vec<Set> {
    let mut all = usual(kind);
    for p in tried(kind).filter(|p| !matches!(p.shape, Shape::Choice(_) | Shape::Flag)) {
        let ends = extremes(&p.shape, &p.default).into_iter().filter(|v| Some(v) != third(&p.shape).as_ref());
        all.extend(ends.filter(|v| *v != p.default).map(|v| one(&p.name, v)));
    }
    all.extend((0..3).filter_map(|k| pair(kind, k)));
    for last in [false, true] {
        let end = |p: &Param| {
            let values = extremes(&p.shape, &p.default);
            Some((p.name.clone(), if last { values.last() } else { values.first() }?.clone()))
        };
        all.push(tried(kind).filter_map(end).collect());
    }
    let mut once: Vec<Set> = Vec::new();
    for set in all {
        if !once.contains(&set) {
            once.push(set);
        }
    }
    once
}

/// The parameters that have values to try: what names a file and what is drawn come from the rig, and what has no range,
/// as in kinds of the tests, has no ends.
fn tried(kind: &Kind) -> impl Iterator<Item = &Param> {
    let given = |p: &&Param| matches!(p.widget, Some(Widget::File | Widget::Strokes));
    let endless = |p: &&Param| matches!(p.shape, Shape::Number { min, max, .. } if !(max - min).is_finite());
    kind.params().iter().filter(move |p| !given(p) && !endless(p))
}

fn one(name: &str, value: Json) -> Set {
    [(name.to_owned(), value)].into_iter().collect()
}

/// The `k`-th of the random pairs of a kind: two parameters with any values that they may have.
fn pair(kind: &Kind, k: u64) -> Option<Set> {
    let params: Vec<_> = tried(kind).filter(|p| any(&p.shape, 0).is_some()).collect();
    let seed = hash::nth(super::number(&kind.id), k);
    let n = params.len() as u64;
    if n < 2 {
        return None;
    }
    let first = hash::nth(seed, 0) % n;
    let second = (first + 1 + hash::nth(seed, 1) % (n - 1)) % n;
    let value = |i: u64| Some((params[i as usize].name.clone(), any(&params[i as usize].shape, seed ^ i)?));
    Some([value(first)?, value(second)?].into_iter().collect())
}

/// Any value of a shape; of numbers rather small ones, so that wide ranges do not give huge values alone.
fn any(shape: &Shape, seed: u64) -> Option<Json> {
    let share = hash::unit(seed, 9);
    Some(match shape {
        Shape::Number { min, max, integer: true } => {
            json!((min + (max - min) * share * share).floor() as i64)
        }
        Shape::Number { min, max, .. } => json!(rounded(min + (max - min) * share * share)),
        Shape::Flag => json!(share < 0.5),
        Shape::Optional(inner) => any(inner, seed)?,
        Shape::Choice(modes) => {
            let mode = modes.get((share * modes.len() as f64) as usize)?;
            let field = |f: &Param| Some((f.name.clone(), any(&f.shape, hash::mix(seed))?));
            match mode.fields.as_slice() {
                [] => json!(mode.name),
                fields => json!({ &mode.name: fields.iter().filter_map(field).collect::<Set>() }),
            }
        }
        _ => return None,
    })
}

/// A number of few digits, so that lines with it stay short.
fn rounded(v: f64) -> f64 {
    format!("{v:.3e}").parse().unwrap_or(v)
}

/// A third of the way through the range of a number.
fn third(shape: &Shape) -> Option<Json> {
    match shape {
        Shape::Number { min, max, integer: true } => {
            Some(json!((min + (max - min) * THIRD).floor() as i64)).filter(|_| max - min < 1e9)
        }
        Shape::Number { min, max, .. } => Some(json!(min + (max - min) * THIRD)),
        Shape::Optional(inner) => third(inner),
        _ => None,
    }
}

/// Values at the ends of what a parameter allows and a third of the way, each of its modes with those of their fields.
pub(crate) fn extremes(shape: &Shape, default: &Json) -> Vec<Json> {
    match shape {
        Shape::Number { min, max, integer: true } => vec![json!(*min as i64), json!(*max as i64)],
        Shape::Number { min, max, .. } => vec![json!(min), json!(max), json!(min + (max - min) * THIRD)],
        Shape::Flag => vec![json!(true), json!(false)],
        Shape::Optional(inner) => extremes(inner, default).into_iter().chain([Json::Null]).collect(),
        Shape::Choice(modes) => modes.iter().flat_map(|m| mode_extremes(&m.name, &m.fields)).collect(),
        Shape::List { item, min, max } if min == max && matches!(**item, Shape::Number { .. }) => {
            extremes(item, default).into_iter().map(|v| json!(vec![v; *min])).collect()
        }
        _ => vec![default.clone()],
    }
}

fn mode_extremes(name: &str, fields: &[Param]) -> Vec<Json> {
    if fields.is_empty() {
        return vec![json!(name)];
    }
    let at = |pick: usize| {
        let field = |f: &Param| {
            let ends = extremes(&f.shape, &f.default);
            let value = ends.get(pick.min(ends.len().saturating_sub(1))).cloned().unwrap_or(Json::Null);
            (f.name.clone(), value)
        };
        json!({ name: fields.iter().map(field).collect::<Set>() })
    };
    (0..3).map(at).collect()
}

#[test]
fn sets_hold_each_mode_each_end_and_three_pairs() {
    let registry = orograph::nodes::Registry::standard();
    let kind = registry.find("combine").unwrap();
    let (usual, all) = (usual(kind), all(kind));
    let has = |sets: &[Set], set: Json| sets.iter().any(|s| json!(s) == set);
    assert!(has(&usual, json!({})) && has(&usual, json!({ "mode": "power" })));
    assert!(has(&usual, json!({ "mode": { "smooth_max": { "width": 370_000.0 } } })));
    assert!(usual.iter().all(|set| all.contains(set)));
    let blur = registry.find("sharpen").unwrap();
    let sets = super::sets::all(blur);
    for p in blur.params() {
        let Shape::Number { min, max, .. } = p.shape else { panic!("{p:?}") };
        for end in [min, max].into_iter().filter(|end| p.default != json!(end)) {
            assert!(has(&sets, json!({ &p.name: end })), "{} at {end}", p.name);
        }
    }
    assert!(sets.iter().filter(|s| s.len() == 2).count() >= 3, "pairs: {sets:?}");
}
