//! Work that is abandoned when it is cancelled and does not stop soon.
//!
//! Most work checks for cancellation often. Some cannot, such as a call of a library or a pass over all samples. Work
//! that writes no file can be abandoned at any moment, so that it runs on a thread of its own, which ends with the
//! process.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::exit::{Exit, Stop};
use crate::node::{Cancel, Error};

/// Time that cancelled work has to stop by itself.
const GRACE: Duration = Duration::from_millis(50);
/// Time between two checks for cancellation.
const STEP: Duration = Duration::from_millis(10);
/// Bytes of the stack, as many as that of the main thread.
const STACK: usize = 8 << 20;

/// Does work that writes no file; abandons it when it is cancelled and does not stop soon.
pub(super) fn aside<T: Send + 'static>(
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T, Stop> + Send + 'static,
) -> Result<T, Stop> {
    let slot = Arc::new(Mutex::new(Some(work)));
    let (give, given) = channel();
    let theirs = slot.clone();
    let run = move || {
        // Sending fails when the work was abandoned.
        take(&theirs).map(|work| give.send(work()))
    };
    let Ok(worker) = std::thread::Builder::new().stack_size(STACK).spawn(run) else {
        // Where no thread can be started, the work is done on this one.
        return take(&slot).map_or_else(|| Err(cancelled()), |work| work());
    };
    let mut asked = None;
    loop {
        match given.recv_timeout(STEP) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Err(panic) => resume_unwind(panic),
                Ok(_) => return Err(cancelled()),
            },
            Err(RecvTimeoutError::Timeout) if cancel.is_cancelled() => {
                if asked.get_or_insert_with(Instant::now).elapsed() >= GRACE {
                    return Err(cancelled());
                }
            }
            Err(RecvTimeoutError::Timeout) => (),
        }
    }
}

fn take<F>(slot: &Mutex<Option<F>>) -> Option<F> {
    slot.lock().unwrap_or_else(PoisonError::into_inner).take()
}

fn cancelled() -> Stop {
    Stop::new(Exit::Cancelled, Error::Cancelled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_stop_is_left_behind() {
        let cancel = Cancel::default();
        assert_eq!(aside(&cancel, || Ok(7)).ok(), Some(7));
        let stop = cancel.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(30));
            stop.cancel();
        });
        let begun = Instant::now();
        let endless = || {
            std::thread::sleep(Duration::from_secs(60));
            Ok(())
        };
        let stopped = aside(&cancel, endless).expect_err("was asked to stop");
        assert_eq!(stopped.exit, Exit::Cancelled);
        assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    }

    #[test]
    fn what_stops_by_itself_says_how() {
        let cancel = Cancel::default();
        cancel.cancel();
        let stopped = aside::<()>(&cancel, || Err(Stop::new(Exit::Input, "its own word")));
        assert_eq!(stopped.expect_err("fails").message, "its own word");
    }
}
