//! Law 12: long work tells how far it is, looks often whether it should stop, and stops.

use std::time::Duration;

use orograph::engine::Stage;
use orograph::graph::Graph;
use orograph::node::Kind;
use serde_json::Value as Json;

use crate::kinds::registry;
use crate::rig::graph::{fed, is_refusal};
use crate::rig::sets::{self, Set};
use crate::rig::watch::{Seen, stopped, watched};
use crate::rig::{breadth, grid, part, shipped};

/// Samples along the longer side of build and base grid: 2049 where the whole is tried.
fn size() -> u32 {
    if breadth() { 2049 } else { 1025 }
}

/// Most time of the processor between two looks: a tenth of a second at 2049 on a quiet machine. A busy one shares the
/// units and caches of its cores and takes up to twice as long, and the development profile four times as long again; a
/// grid of 1025 has a quarter of the samples.
fn limit() -> Duration {
    let slow = if cfg!(debug_assertions) { 8 } else { 2 };
    Duration::from_millis(100) * slow * (size() - 1) * (size() - 1) / (2048 * 2048)
}

fn graph(kind: &Kind, set: &Set) -> Graph {
    let mut g = fed(kind, set, None);
    g.assign("terrain.base", &size().to_string()).unwrap();
    g
}

/// What is wrong with how the tasks of a node look and tell. The best of three counts: a busy machine takes the caches of
/// the processor.
fn faults(kind: &Kind, set: &Set) -> Vec<String> {
    let mut bad = Vec::new();
    for _ in 0..3 {
        bad = faults_once(kind, set, limit());
        if bad.is_empty() {
            break;
        }
    }
    bad
}

fn faults_once(kind: &Kind, set: &Set, limit: Duration) -> Vec<String> {
    let (g, label) = (graph(kind, set), format!("{} {}", kind.id, Json::from(set.clone())));
    let at = grid(g.terrain(), size());
    match watched(&g, kind, at) {
        Err(e) if is_refusal(&e) => Vec::new(),
        Err(e) => vec![format!("{label}: {e}")],
        Ok(tasks) => tasks.iter().flat_map(|(stage, seen)| of_task(&label, *stage, seen, limit)).collect(),
    }
}

fn of_task(label: &str, stage: Stage, seen: &Seen, limit: Duration) -> Vec<String> {
    let label = format!("{label}, {}", stage.name());
    let mut bad = Vec::new();
    if seen.longest > limit {
        let Seen { longest, total, looks, .. } = seen;
        bad.push(format!("{label}: {longest:.0?} of {total:.0?} without a look; {looks} looks"));
    }
    if seen.total > 3 * limit && seen.told < 3 {
        bad.push(format!("{label}: {:.0?} of work, and a share was told {} times", seen.total, seen.told));
    }
    bad
}

/// What is wrong with how the tasks of a node stop.
fn stubborn(kind: &Kind, set: &Set, limit: Duration) -> Vec<String> {
    let g = graph(kind, set);
    let at = grid(g.terrain(), size());
    let tasks = watched(&g, kind, at).unwrap_or_default();
    let stop = |(stage, seen): &(Stage, Seen)| {
        let took = stopped(&g, kind, at, *stage, seen.looks.div_ceil(2));
        let label = format!("{} {}, {}", kind.id, Json::from(set.clone()), stage.name());
        match took {
            Ok(took) if took <= limit => None,
            Ok(took) => Some(format!("{label}: {took:.0?} from the word to the end")),
            Err(e) => Some(format!("{label}: {e}")),
        }
    };
    // What never looks has no look to be stopped at; what is long and never looks is a fault of its own.
    tasks.iter().filter(|(_, seen)| seen.looks > 0).filter_map(stop).collect()
}

fn some(kind: &Kind) -> Vec<Set> {
    let others = part(sets::usual(kind).into_iter().skip(1).collect(), 5, &kind.id);
    [sets::defaults()].into_iter().chain(others).collect()
}

#[test]
fn every_kind_tells_and_looks_often() {
    let faults = |kind| some(kind).iter().flat_map(|set| faults(kind, set)).collect::<Vec<_>>();
    let bad: Vec<_> = shipped().into_iter().flat_map(faults).collect();
    assert!(bad.is_empty(), "more than {:?} at {}:\n{}", limit(), size(), bad.join("\n"));
}

#[test]
fn every_kind_stops_when_it_is_asked_to() {
    let bad: Vec<_> =
        shipped().into_iter().flat_map(|kind| stubborn(kind, &sets::defaults(), limit())).collect();
    assert!(bad.is_empty(), "more than {:?} at {}:\n{}", limit(), size(), bad.join("\n"));
}

#[test]
fn kinds_that_do_not_look_tell_or_stop_are_found() {
    let (registry, limit) = (registry(), Duration::from_millis(100));
    let faults = |id: &str| faults_once(registry.find(id).unwrap(), &sets::defaults(), limit);
    let stubborn = |id: &str| stubborn(registry.find(id).unwrap(), &sets::defaults(), limit);
    let deaf = faults("deaf");
    assert!(deaf.len() == 2 && deaf[0].contains("without a look"), "{deaf:?}");
    assert!(deaf[1].contains("a share was told 0 times"), "{deaf:?}");
    let goes_on = stubborn("goes_on");
    assert!(goes_on.len() == 1 && goes_on[0].contains("from the word to the end"), "{goes_on:?}");
    assert_eq!(faults("goes_on"), [""; 0], "it looks, and does not heed");
    assert_eq!((faults("copy"), stubborn("copy")), (vec![], vec![]));
}
