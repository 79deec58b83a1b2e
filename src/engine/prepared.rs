//! The programs made last. In the editor one node changes at a time, and the next program takes over the others; keys,
//! plans and evaluations of one graph share a program.

use std::sync::{Arc, Mutex, PoisonError};

use super::program::Program;

/// Number of programs that are kept. A session has a few graphs at once, such as that of the window, its drafts and one
/// that is being opened.
const KEPT: usize = 6;

/// The programs made last, the latest first.
#[derive(Debug, Default)]
pub(super) struct Prepared(Mutex<Vec<Arc<Program>>>);

impl Prepared {
    pub(super) fn programs(&self) -> Vec<Arc<Program>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Stores a program, in place of those whose nodes it has, unless one of the same graph has all of its own.
    pub(super) fn keep(&self, program: &Arc<Program>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !kept.iter().any(|other| program.is_of_graph(other) && program.is_within(other)) {
            kept.retain(|other| !other.is_within(program));
            kept.insert(0, program.clone());
            kept.truncate(KEPT);
        }
    }
}
