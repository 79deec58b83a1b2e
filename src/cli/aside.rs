//! Work that nobody waits for any longer once it was asked to stop.
//!
//! Most work looks at the signal often enough, and some cannot: one call of a library, one pass over all samples. What
//! writes no file may be left behind at any moment, so it is done on a thread of its own, which ends with the process.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::exit::{Exit, Stop};
use crate::node::{Cancel, Error};

/// How long work may take to stop by itself and to say where it was.
const GRACE: Duration = Duration::from_millis(50);
/// How often the signal is looked at.
const STEP: Duration = Duration::from_millis(10);
/// Bytes of the stack: as many as the first thread has.
const STACK: usize = 8 << 20;

/// Does work that writes no file, and leaves it behind when it does not stop soon.
pub(super) fn aside<T: Send + 'static>(
    cancel: &Cancel,
    work: impl FnOnce() -> Result<T, Stop> + Send + 'static,
) -> Result<T, Stop> {
    let slot = Arc::new(Mutex::new(Some(work)));
    let (give, given) = channel();
    let theirs = slot.clone();
    let run = move || {
        // Nobody takes what comes too late.
        take(&theirs).map(|work| give.send(work()))
    };
    let Ok(worker) = std::thread::Builder::new().stack_size(STACK).spawn(run) else {
        // A system that has no thread left still has this one.
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
