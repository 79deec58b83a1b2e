//! Law 7: a result that changes while its kind keeps its version is a fault, since caches would mix old and new.
//!
//! `golden/FAMILY.txt` has an entry for each kind, parameter set and output: the version and the hash of the samples,
//! and a picture for a person who reads the difference; see [`text`]. `OROGRAPH_BLESS=1 cargo test golden` writes the
//! files anew; it refuses entries whose hash changed and whose version did not.

mod text;

use std::collections::BTreeMap;
use std::path::PathBuf;

use orograph::node::Kind;
use orograph::value::Value;
use serde_json::Value as Json;

use self::text::{Entry, picture_of, read, write};
use crate::kinds::registry;
use crate::rig::bytes::bytes;
use crate::rig::graph::{engine, fed, outputs};
use crate::rig::{grid, sets, shipped};

/// What an entry is of: kind, parameters, output.
type Name = String;
type Entries = BTreeMap<Name, Entry>;

fn path(family: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{family}.txt"))
}

fn entry(kind: &Kind, value: &Value) -> Entry {
    let hash = blake3::hash(&bytes(value)).to_hex()[..16].to_owned();
    let (line, picture) = picture_of(value);
    Entry { version: kind.version, hash, line, picture }
}

/// A set with which a kind fails, and why: as an entry it is seen when it comes and when it goes.
fn failure(kind: &Kind, why: &str) -> Entry {
    Entry { version: kind.version, hash: "fails".into(), line: why.replace('\n', " "), picture: vec![] }
}

fn results(kind: &Kind) -> Entries {
    let e = engine(2);
    let mut all = Entries::new();
    let mut known: BTreeMap<(String, String), String> = BTreeMap::new();
    for set in sets::usual(kind) {
        let graph = fed(kind, &set, None);
        let set = Json::from(set);
        // Between the sizes of the base grid, so that what is carried from it is seen.
        let values = match outputs(&e, &graph, kind, grid(graph.terrain(), 97)) {
            Ok(values) => values,
            Err(why) => {
                all.insert(format!("{} {set}", kind.id), failure(kind, &why));
                continue;
            }
        };
        let name = set.to_string();
        for (port, value) in values {
            let mut entry = entry(kind, &value);
            // One picture of what is the same.
            let first = known.entry((port.to_owned(), entry.hash.clone())).or_insert_with(|| name.clone());
            if *first != name {
                (entry.line, entry.picture) = (format!("as {first}"), Vec::new());
            }
            all.insert(format!("{} {set} {port}", kind.id), entry);
        }
    }
    all
}

/// Results that changed under an unchanged version, with how far.
fn silent_changes(old: &Entries, new: &Entries) -> Vec<String> {
    let changed = |(name, was): (&Name, &Entry)| {
        let is = new.get(name)?;
        let silent = is.version == was.version && (is.hash != was.hash || is.fails() && is.line != was.line);
        silent.then(|| format!("{name}: {}", is.beside(was)))
    };
    old.iter().filter_map(changed).collect()
}

fn families() -> BTreeMap<String, Entries> {
    let mut all: BTreeMap<_, Entries> = BTreeMap::new();
    for kind in shipped() {
        all.entry(kind.family.to_string()).or_default().extend(results(kind));
    }
    all
}

#[test]
fn a_changed_result_raises_the_version_of_its_kind() {
    let mut stale = Vec::new();
    let (mut silent, mut seen) = (Vec::new(), 0);
    let bless = std::env::var_os("OROGRAPH_BLESS").is_some();
    for (family, new) in families() {
        let text = std::fs::read_to_string(path(&family)).unwrap_or_default();
        let changed = silent_changes(&read(&text), &new);
        if bless && changed.is_empty() {
            std::fs::write(path(&family), write(&new)).unwrap();
        } else if text != write(&new) {
            stale.push(family);
        }
        silent.extend(changed);
        seen += new.len();
    }
    assert!(
        silent.is_empty(),
        "these results changed: raise the version of their kinds (Meta::migrations), then run with \
         OROGRAPH_BLESS=1\n{}",
        silent.join("\n")
    );
    assert!(bless || stale.is_empty(), "not up to date, run once with OROGRAPH_BLESS=1: {stale:?}");
    assert!(seen > 300, "{seen}");
}

#[test]
fn a_silent_change_is_found_and_told_how_far() {
    let registry = registry();
    let of = |id: &str| results(registry.find(id).unwrap());
    let old = of("smooth");
    assert_eq!(silent_changes(&old, &of("smooth")), Vec::<String>::new());
    assert_eq!(read(&write(&old)), old);
    // As if `smooth` had become another algorithm: first silently, then with a version of its own.
    let (name, changed) = (old.keys().next().unwrap(), of("peeks").into_values().next().unwrap());
    let mut new: Entries = [(name.clone(), changed)].into();
    let said = silent_changes(&old, &new);
    assert!(said.len() == 1 && said[0].contains("blocks differ, by up to"), "{said:?}");
    new.get_mut(name).unwrap().version = 2;
    assert_eq!(silent_changes(&old, &new), Vec::<String>::new());
    // As if a rounding were another: the same picture under another hash.
    let mut rounded = old.clone();
    rounded.get_mut(name).unwrap().hash = "0".repeat(16);
    let said = silent_changes(&old, &rounded);
    assert!(said.len() == 1 && said[0].contains("within a hundredth of the range"), "{said:?}");
}

#[test]
fn a_kind_that_begins_to_fail_is_a_line() {
    let registry = registry();
    let (old, broken) =
        (results(registry.find("smooth").unwrap()), results(registry.find("panics").unwrap()));
    let (name, entry) = broken.first_key_value().unwrap();
    assert!(name == "panics {}" && entry.fails() && entry.line.contains("the kind has a bug"), "{broken:?}");
    assert_eq!(read(&write(&broken)), broken);
    assert_ne!(write(&old).replace("smooth", "panics"), write(&broken));
    // One that fails in another way than before has changed, too.
    let mut other = broken.clone();
    other.get_mut(name).unwrap().line = "for another reason".into();
    assert_eq!(silent_changes(&broken, &other).len(), 1);
}
