//! How long work tells and stops.

use crate::node::Context;

/// Told of progress and asked whether to go on: the context of a node is one.
pub trait Watch: Sync {
    /// Whether the work shall stop.
    fn cancelled(&self) -> bool;
    /// The finished share of the work, 0 to 1, never falling.
    fn progress(&self, done: f32);

    /// # Errors
    /// [`Cancelled`] when the work shall stop.
    fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The work was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// Tells nobody and never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Watch for Silent {
    fn cancelled(&self) -> bool {
        false
    }

    fn progress(&self, _done: f32) {}
}

impl Watch for Context<'_> {
    fn cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    fn progress(&self, done: f32) {
        self.report(done);
    }
}
