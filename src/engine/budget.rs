//! The budgets of memory and time: plans that exceed one are refused.

use super::Engine;
use super::error::EngineError;
use super::plan::Plan;

/// Number of bytes that are alive for each further byte that the allocator holds, in gaps and in freed blocks that are
/// not given back to the system. In the builds of docs/budgets.md the allocator holds up to an eleventh.
const HELD_BACK: u64 = 10;

impl Engine {
    /// Checks a plan against the budgets of memory and time.
    ///
    /// # Errors
    /// Fails when the plan exceeds a budget; the error has the budget, the estimate and the node at its peak.
    pub fn admit(&self, plan: &Plan) -> Result<(), EngineError> {
        self.admit_bytes(plan.peak_bytes(), || plan.peak_node())?;
        // Tasks share the threads, while a file is hashed by one thread.
        self.admit_seconds(
            plan.run_seconds() / self.pool.current_num_threads() as f64 + plan.unread_seconds(),
        )
    }

    fn admit_bytes(&self, bytes: u64, at: impl FnOnce() -> String) -> Result<(), EngineError> {
        let (need, reserve, budget) = (self.need(bytes), self.reserve, self.memory);
        if need > budget {
            return Err(EngineError::Memory { need, reserve, budget, at: at() });
        }
        Ok(())
    }

    /// Bytes that the whole process takes when an evaluation takes `bytes`; they must fit the memory budget.
    pub fn need(&self, bytes: u64) -> u64 {
        bytes.saturating_add(bytes / HELD_BACK).saturating_add(self.reserve)
    }

    fn admit_seconds(&self, need: f64) -> Result<(), EngineError> {
        let budget = self.seconds;
        // The comparison is false for a budget of NaN, which thus allows nothing.
        if need <= budget { Ok(()) } else { Err(EngineError::Time { need, budget }) }
    }

    /// Checks a plan against the budgets before its files are read. Where there is a cache folder, it may hold results
    /// that the plan counts as computed; then only the files themselves are counted.
    pub(super) fn admit_reading(&self, plan: &Plan) -> Result<(), EngineError> {
        if self.store.disk.is_none() {
            return self.admit(plan);
        }
        let (bytes, node) = plan.largest_reading();
        self.admit_bytes(bytes, || format!("node `{node}`"))?;
        self.admit_seconds(plan.unread_seconds())
    }
}
