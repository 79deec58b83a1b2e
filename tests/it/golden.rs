//! Law 7: a result that changes while its kind keeps its version is a fault, since caches would mix old and new.
//!
//! `golden/kinds.txt` has a line for each kind, parameter set and output: the version, the hash of the samples, and
//! three numbers for a person who reads the difference. `OROGRAPH_BLESS=1 cargo test golden` writes the file anew; it
//! refuses lines whose hash changed and whose version did not.

use std::collections::BTreeMap;
use std::path::PathBuf;

use orograph::node::Kind;
use orograph::params::Shape;
use orograph::value::Value;
use serde_json::{Map, Value as Json};

use crate::fed::{bits, engine, extremes, fed, grid, outputs, shipped};
use crate::kinds::registry;

/// What stands before the first difference of two lines of one result: kind, parameters, output.
type Name = String;

/// A result: the version of its kind, its hash, and what a person may look at.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    version: String,
    rest: String,
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/kinds.txt")
}

/// The defaults, and each mode of each choice.
fn sets(kind: &Kind) -> Vec<Map<String, Json>> {
    let choices = kind.params().iter().filter(|p| matches!(p.shape, Shape::Choice(_)));
    let one = |name: &str, value: Json| [(name.to_owned(), value)].into_iter().collect();
    let modes = choices.flat_map(|p| extremes(&p.shape, &p.default).into_iter().map(|v| one(&p.name, v)));
    [Map::new()].into_iter().chain(modes).collect()
}

fn line(version: u32, value: &Value) -> Line {
    let samples = value.components();
    let mut hasher = blake3::Hasher::new();
    for x in bits(value) {
        hasher.update(&x.to_le_bytes());
    }
    let (version, hash) = (format!("v{version}"), hasher.finalize().to_hex()[..16].to_owned());
    if samples.is_empty() {
        return Line { version, rest: hash };
    }
    let mean = samples.iter().map(|x| f64::from(*x)).sum::<f64>() / samples.len() as f64;
    let (lo, hi) = samples.iter().fold((f32::MAX, f32::MIN), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
    Line { version, rest: format!("{hash}  {lo:.6} {mean:.6} {hi:.6}") }
}

fn results(kinds: &[&Kind]) -> BTreeMap<Name, Line> {
    let e = engine(2);
    let mut all = BTreeMap::new();
    for kind in kinds {
        for set in sets(kind) {
            let graph = fed(kind, &set, None);
            // Between the sizes of the base grid, so that what is carried from it is seen.
            let Ok(values) = outputs(&e, &graph, kind, grid(&graph, 97)) else { continue };
            for (port, value) in values {
                let name = format!("{} {} {port}", kind.id, Json::from(set.clone()));
                all.insert(name, line(kind.version, &value));
            }
        }
    }
    all
}

fn read(text: &str) -> BTreeMap<Name, Line> {
    let parse = |l: &str| {
        let (name, rest) = l.split_once("  ")?;
        let (version, rest) = rest.split_once(' ')?;
        Some((name.to_owned(), Line { version: version.to_owned(), rest: rest.to_owned() }))
    };
    text.lines().filter_map(parse).collect()
}

fn write(lines: &BTreeMap<Name, Line>) -> String {
    lines.iter().map(|(name, l)| format!("{name}  {} {}\n", l.version, l.rest)).collect()
}

/// Results that changed under an unchanged version.
fn silent_changes(old: &BTreeMap<Name, Line>, new: &BTreeMap<Name, Line>) -> Vec<String> {
    let changed = |(name, was): (&Name, &Line)| {
        let is = new.get(name)?;
        (is.version == was.version && is.rest != was.rest)
            .then(|| format!("{name}: {} {} was {}", is.version, is.rest, was.rest))
    };
    old.iter().filter_map(changed).collect()
}

#[test]
fn a_changed_result_raises_the_version_of_its_kind() {
    let new = results(&shipped());
    let old = read(&std::fs::read_to_string(path()).unwrap_or_default());
    let silent = silent_changes(&old, &new);
    assert!(
        silent.is_empty(),
        "these results changed: raise the version of their kinds (Meta::migrations), then run with \
         OROGRAPH_BLESS=1\n{}",
        silent.join("\n")
    );
    if std::env::var_os("OROGRAPH_BLESS").is_some() {
        std::fs::create_dir_all(path().parent().unwrap()).unwrap();
        std::fs::write(path(), write(&new)).unwrap();
    } else {
        assert!(old == new, "tests/golden/kinds.txt is not up to date: run once with OROGRAPH_BLESS=1");
    }
    assert!(new.len() > 100, "{}", new.len());
}

#[test]
fn a_silent_change_is_found() {
    let registry = registry();
    let kind = registry.find("smooth").cloned().unwrap();
    let old = results(&[&kind]);
    assert_eq!(silent_changes(&old, &results(&[&kind])), Vec::<String>::new());
    assert_eq!(read(&write(&old)), old);
    // As if `smooth` had become another algorithm: first silently, then with a version of its own.
    let other = results(&[registry.find("peeks").unwrap()]);
    let (name, changed) = (old.keys().next().unwrap(), other.values().next().unwrap());
    let mut new: BTreeMap<_, _> = [(name.clone(), changed.clone())].into();
    assert_eq!(silent_changes(&old, &new).len(), 1);
    new.get_mut(name).unwrap().version = "v2".into();
    assert_eq!(silent_changes(&old, &new), Vec::<String>::new());
}
