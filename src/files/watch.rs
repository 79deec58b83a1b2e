//! Who wants to know how far the reading or writing of a file is, and may stop it.

use std::fmt;

use crate::node::Cancel;

/// Somebody who watches: told the finished share, and asked whether to go on.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Stops the work.
    pub cancel: Option<&'a Cancel>,
    /// Told the finished share.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
}

/// The work was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

impl Watch<'_> {
    /// Tells the finished share and asks whether to go on.
    pub(super) fn check(&self, done: f32) -> Result<(), Stopped> {
        if let Some(progress) = self.progress {
            progress(done);
        }
        self.go_on()
    }

    /// Asks whether to go on.
    pub(super) fn go_on(&self) -> Result<(), Stopped> {
        match self.cancel {
            Some(cancel) if cancel.is_cancelled() => Err(Stopped),
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}
