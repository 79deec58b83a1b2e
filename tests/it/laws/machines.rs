//! Law 5: the same bits for any number of threads and on every instruction set that the machine has.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use orograph::kit::simd::Level;
use orograph::node::Kind;
use serde_json::Value as Json;

use crate::kinds::registry;
use crate::rig::bytes::bytes;
use crate::rig::graph::{engine, fed, outputs};
use crate::rig::sets::{self, Set};
use crate::rig::skip::skip;
use crate::rig::{grid, part, shipped};

/// The defaults, and some of the other sets.
fn some(kind: &Kind, one_in: usize) -> Vec<Set> {
    let others = part(sets::all(kind).into_iter().skip(1).collect(), one_in, &kind.id);
    [sets::defaults()].into_iter().chain(others).collect()
}

/// Results by output, on a grid of several bands of work, the base grid as well.
fn on(threads: usize, kind: &Kind, set: &Set, size: u32) -> Option<BTreeMap<String, Vec<u8>>> {
    let mut g = fed(kind, set, None);
    g.assign("terrain.base", &size.to_string()).unwrap();
    let all = outputs(&engine(threads), &g, kind, grid(g.terrain(), size)).ok()?;
    Some(all.iter().map(|(port, value)| (port.clone(), bytes(value))).collect())
}

fn differs(kind: &Kind, set: &Set) -> Option<String> {
    let one = on(1, kind, set, 257);
    let other = [2, 7].into_iter().find(|threads| on(*threads, kind, set, 257) != one)?;
    Some(format!("{} {} on {other} threads", kind.id, Json::from(set.clone())))
}

#[test]
fn every_kind_gives_the_same_bits_on_any_number_of_threads() {
    let bad: Vec<String> = (shipped().into_iter())
        .flat_map(|kind| some(kind, 8).iter().filter_map(|set| differs(kind, set)).collect::<Vec<_>>())
        .collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(differs(registry().find("crowd").unwrap(), &sets::defaults()).is_some(), "a lie is found");
}

/// Where a process that runs this test once more puts its hashes.
const HASHES: &str = "OROGRAPH_TEST_HASHES";

/// A line for each kind and set: the hash of what it gives on a grid of odd width.
fn hashes() -> Vec<String> {
    let registry = registry();
    let lie: &Kind = registry.find("lanes").unwrap();
    let hash = |kind: &Kind, set: &Set| {
        let all = on(1, kind, set, 97)?;
        let mut hasher = blake3::Hasher::new();
        for bytes in all.values() {
            hasher.update(bytes);
        }
        Some(format!("{} {} {}", kind.id, Json::from(set.clone()), hasher.finalize().to_hex()))
    };
    let of = |kind: &Kind| some(kind, 3).iter().filter_map(|set| hash(kind, set)).collect::<Vec<_>>();
    shipped().into_iter().chain([lie]).flat_map(of).collect()
}

/// What this test gives in a process of its own that is held to an instruction set.
fn hashes_at(level: Level, path: &Path) -> Vec<String> {
    let status = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "laws::machines::instruction_sets_do_not_change_a_bit_of_any_kind"])
        .env(HASHES, path)
        .env("OROGRAPH_SIMD", level.name())
        .stdout(Stdio::null())
        .status();
    assert!(status.unwrap().success(), "{level:?}");
    std::fs::read_to_string(path).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn instruction_sets_do_not_change_a_bit_of_any_kind() {
    if let Some(path) = std::env::var_os(HASHES) {
        return std::fs::write(path, hashes().join("\n")).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let own = hashes();
    let others = Level::available().into_iter().filter(|level| *level != Level::best());
    let mut compared = 0;
    for level in others {
        let other = hashes_at(level, &folder.path().join(level.name()));
        assert_eq!(own.len(), other.len());
        let bad: Vec<_> = own.iter().zip(&other).filter(|(a, b)| a != b).map(|(a, _)| a.as_str()).collect();
        // The kind that gives away what it runs on must be found, and no other.
        let lies = bad.iter().filter(|line| line.starts_with("lanes ")).count();
        assert!(lies > 0 && lies == bad.len(), "{level:?}:\n{}", bad.join("\n"));
        compared += 1;
    }
    if compared == 0 {
        let reason = "this machine has the baseline alone, nothing to compare";
        skip("instruction_sets_do_not_change_a_bit_of_any_kind", reason, Path::new(""));
    }
}
