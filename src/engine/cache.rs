//! The cache of results by key: in memory up to a limit, and in a folder that several processes may share.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::disk::Disk;
use super::key::Key;
use super::outputs::Outputs;
use crate::node::{Kind, Summary};
use crate::ports::{Port, Wires};
use crate::value::Grid;

/// The result of a task.
#[derive(Clone, Debug)]
pub(super) enum Given {
    /// Values by output port.
    Wires(Wires),
    /// Numbers about the whole terrain.
    Summary(Summary),
}

impl Given {
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Wires(wires) => wires.bytes(),
            Self::Summary(summary) => size_of_val(&*summary.0) as u64,
        }
    }

    /// Whether the result can be stored in a file of the cache folder.
    pub(super) fn is_kept(&self) -> bool {
        self.wires().is_none_or(|wires| wires.iter().all(|(_, value)| value.wire_type().is_kept()))
    }

    pub(super) fn wires(&self) -> Option<&Wires> {
        match self {
            Self::Wires(wires) => Some(wires),
            Self::Summary(_) => None,
        }
    }

    /// Whether the result has all of these outputs, apart from optional ones.
    fn has(&self, kind: &Kind, outputs: Outputs) -> bool {
        let given = |port: &Port| !port.required || self.wires().is_some_and(|w| w.get(&port.name).is_some());
        matches!(self, Self::Summary(_)) || outputs.ports(kind).all(given)
    }

    /// Whether the result has every output that another result has.
    fn covers(&self, other: &Self) -> bool {
        let ports =
            |given| Self::wires(given).into_iter().flat_map(Wires::iter).map(|(port, _)| port.as_str());
        let own: BTreeSet<&str> = ports(self).collect();
        ports(other).all(|port| own.contains(port))
    }

    /// The result reduced to these outputs.
    pub(super) fn only(self, kind: &Kind, outputs: Outputs) -> Self {
        match self {
            Self::Wires(wires) => {
                let read = wires.iter().filter(|(port, _)| outputs.has(kind, port));
                Self::Wires(read.map(|(port, value)| (port.clone(), value.clone())).collect())
            }
            summary @ Self::Summary(_) => summary,
        }
    }
}

/// The warnings of a node about its result, sorted.
pub(super) type Warnings = Arc<[String]>;

/// A result that the cache has.
#[derive(Clone, Debug)]
pub(super) enum Found {
    /// A result in memory, with its warnings.
    Memory(Given, Warnings),
    /// The path of a file in the cache folder.
    Disk(PathBuf),
}

impl Found {
    pub(super) fn place(&self) -> &'static str {
        match self {
            Self::Memory(..) => "memory",
            Self::Disk(_) => "disk",
        }
    }

    pub(super) fn bytes(&self) -> Option<u64> {
        match self {
            Self::Memory(given, _) => Some(given.bytes()),
            // The size of the file is that of its samples and a little more. Its window may be wider than the wanted
            // one.
            Self::Disk(path) => Some(std::fs::metadata(path).ok()?.len()),
        }
    }

    /// Takes the result out, where it is in memory.
    pub(super) fn take(&mut self) -> Option<(Given, Warnings)> {
        match self {
            Self::Memory(given, warnings) => {
                let given = std::mem::replace(given, Given::Wires(Wires::default()));
                Some((given, std::mem::take(warnings)))
            }
            Self::Disk(_) => None,
        }
    }
}

/// The part of the cache that is searched for results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stock {
    /// The memory and the folder.
    All,
    /// The memory only.
    Memory,
}

/// The cache: memory, which is searched first, and the folder.
#[derive(Debug)]
pub(super) struct Store {
    memory: Mutex<Memory>,
    pub(super) disk: Option<Disk>,
}

#[derive(Debug, Default)]
struct Memory {
    entries: BTreeMap<Key, Vec<Entry>>,
    bytes: u64,
    limit: u64,
    clock: u64,
}

#[derive(Debug)]
struct Entry {
    grid: Grid,
    given: Given,
    warnings: Warnings,
    used: u64,
}

impl Store {
    pub(super) fn new(limit: u64, disk: Option<Disk>) -> Self {
        Self { memory: Mutex::new(Memory { limit, ..Memory::default() }), disk }
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A result whose window contains the wanted one and which has the outputs that are read.
    pub(super) fn find(
        &self,
        key: &Key,
        grid: &Grid,
        (kind, read): (&Kind, Outputs),
        stock: Stock,
    ) -> Option<Found> {
        if let Some((given, warnings)) = self.memory().get(key, grid, kind, read) {
            return Some(Found::Memory(given, warnings));
        }
        if stock == Stock::Memory {
            return None;
        }
        self.disk.as_ref()?.find(key, grid).map(Found::Disk)
    }

    /// Stores a result in memory, as far as the limit allows.
    pub(super) fn keep(&self, key: Key, grid: Grid, given: &Given, warnings: &Warnings) {
        self.memory().put(key, grid, given.clone(), warnings.clone());
    }

    /// Sets the limit of the bytes in memory, and drops the least recently used results beyond it.
    pub(super) fn limit(&self, bytes: u64) {
        let mut memory = self.memory();
        memory.limit = bytes;
        memory.shrink();
    }

    /// Bytes of the results in memory.
    pub(super) fn bytes(&self) -> u64 {
        self.memory().bytes
    }
}

impl Memory {
    fn get(&mut self, key: &Key, grid: &Grid, kind: &Kind, read: Outputs) -> Option<(Given, Warnings)> {
        self.clock += 1;
        let serves = |e: &&mut Entry| e.grid.contains(grid) && e.given.has(kind, read);
        let entry = self.entries.get_mut(key)?.iter_mut().find(serves)?;
        entry.used = self.clock;
        Some((entry.given.clone(), entry.warnings.clone()))
    }

    fn put(&mut self, key: Key, grid: Grid, given: Given, warnings: Warnings) {
        let bytes = given.bytes();
        if bytes > self.limit {
            return;
        }
        self.clock += 1;
        let entries = self.entries.entry(key).or_default();
        // Results on a window inside the new one are no longer needed.
        let before = self.bytes;
        entries.retain(|e| {
            let kept = !(grid.contains(&e.grid) && given.covers(&e.given));
            if !kept {
                self.bytes -= e.given.bytes();
            }
            kept
        });
        debug_assert!(self.bytes <= before);
        entries.push(Entry { grid, given, warnings, used: self.clock });
        self.bytes += bytes;
        self.shrink();
    }

    /// Drops the least recently used results until the rest fits the limit.
    fn shrink(&mut self) {
        if self.bytes <= self.limit {
            return;
        }
        let mut by_age: Vec<_> = self
            .entries
            .iter()
            .flat_map(|(k, es)| es.iter().map(|e| (e.used, *k, e.given.bytes())))
            .collect();
        by_age.sort_by_key(|(used, ..)| *used);
        for (used, key, bytes) in by_age {
            if self.bytes <= self.limit {
                break;
            }
            if let Some(entries) = self.entries.get_mut(&key) {
                entries.retain(|e| e.used != used);
                if entries.is_empty() {
                    self.entries.remove(&key);
                }
                self.bytes -= bytes;
            }
        }
    }
}
