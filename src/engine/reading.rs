//! Files that are read to learn their content, on which the keys of results depend.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use super::cache::Stock;
use super::error::EngineError;
use super::key::Key;
use super::observer::Observer;
use super::plan::Plan;
use super::{Engine, Want};
use crate::graph::{Graph, NodeId};
use crate::node::{Cancel, SourceFile};
use crate::source::SourceError;
use crate::work::Work;

impl Engine {
    /// Reads the files whose content a plan does not know yet, and makes the plan anew with their content. The plan is
    /// checked against the budgets first. A file that cannot be read is a failure in the new plan.
    ///
    /// # Errors
    /// Fails when reading is over a budget or the work is cancelled; the plan is then unchanged.
    pub fn know(
        &self,
        graph: &Graph,
        wants: &[Want],
        plan: &mut Plan,
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<(), EngineError> {
        let unread = plan.unread();
        if unread.is_empty() {
            return Ok(());
        }
        self.admit_reading(plan)?;
        learn(&unread, observer, cancel)?;
        *plan = self.plan_of(graph, wants, (plan.program.sources.clone(), Stock::All), cancel)?;
        Ok(())
    }

    /// The keys of the results of some nodes, without nodes that have a fault. Files whose content is not known are
    /// read where they have at most `most` bytes together; otherwise nodes that depend on them are left out, too.
    ///
    /// # Errors
    /// Fails when the work is cancelled.
    pub fn keys(
        &self,
        graph: &Graph,
        nodes: &[NodeId],
        most: u64,
        observer: &dyn Observer,
        cancel: &Cancel,
    ) -> Result<BTreeMap<NodeId, Key>, EngineError> {
        let sources = self.files.sources();
        let made = || self.program(graph, nodes, sources.clone(), cancel);
        let mut program = made()?;
        let steps = program.steps.iter().flatten();
        let unread: Vec<_> = steps.flat_map(|s| s.unread().map(|f| (s.name(), f))).collect();
        let bytes = unread.iter().fold(0, |sum: u64, (_, f)| sum.saturating_add(f.len()));
        if !unread.is_empty() && bytes <= most {
            learn(&unread, observer, cancel)?;
            program = made()?;
        }
        let key = |id: &NodeId| {
            let step = program.steps.get(program.find(*id)?)?;
            Some((*id, step.as_ref().ok()?.key?))
        };
        Ok(nodes.iter().filter_map(key).collect())
    }
}

/// Reads and hashes files. An error of a file is stored with its hash, where the next program finds it.
fn learn(
    unread: &[(&str, &Arc<SourceFile>)],
    observer: &dyn Observer,
    cancel: &Cancel,
) -> Result<(), EngineError> {
    for (node, file) in unread {
        let last = AtomicU32::new(0);
        let progress = |share: f32| {
            let now = (share * 100.0) as u32;
            if last.fetch_max(now, Ordering::Relaxed) < now {
                observer.reading(node, file.name(), share);
            }
        };
        if file.hash(&Work::new(cancel).telling(&progress)) == Err(SourceError::Cancelled) {
            return Err(EngineError::Cancelled);
        }
    }
    Ok(())
}
