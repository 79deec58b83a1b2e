//! The options of an engine.

use std::path::PathBuf;

use super::disk::DEFAULT_LIMIT;
use super::memory::default_budget;

/// The default limit of the estimated seconds of an evaluation: a day.
pub const DEFAULT_SECONDS: f64 = 86_400.0;

/// Threads, memory, time and disk space that an engine may use.
#[derive(Clone, Debug)]
pub struct Options {
    /// Worker threads; 0 for one per processor.
    pub threads: usize,
    /// The memory budget of the whole process, in bytes.
    pub memory: u64,
    /// The part of the budget that is not for evaluations, in bytes: the program itself, and the writers of its files.
    pub reserve: u64,
    /// The limit of the estimated seconds of one evaluation.
    pub seconds: f64,
    /// Which results stay in memory for the next evaluation.
    pub keep: Keep,
    /// The cache folder, in which results outlive the process.
    pub cache: Option<PathBuf>,
    /// The most bytes that the cache folder holds.
    pub cache_bytes: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            threads: 0,
            memory: default_budget(),
            reserve: 0,
            seconds: DEFAULT_SECONDS,
            keep: Keep::Everything,
            cache: None,
            cache_bytes: DEFAULT_LIMIT,
        }
    }
}

/// Which results stay in memory for the next evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// As many as the budget leaves room for. It serves editing, where a graph is changed and evaluated again.
    Everything,
    /// Results on the base grid, which every tile of a graph reads. It serves builds of one tile after the other, whose
    /// plans count these results.
    Lasting,
    /// None. It serves a single evaluation.
    Nothing,
}
