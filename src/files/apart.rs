//! Work on threads of its own.

use std::sync::Mutex;

/// Runs parallel work on threads of its own while this one waits.
///
/// A worker of a pool that waits for its own pool picks up other work meanwhile. Under a lock that is a trap: the
/// other work may want the same lock, and the thread waits for itself. Threads apart do nothing but this.
pub fn apart<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let threads = rayon::current_num_threads();
    let slot = Mutex::new(Some(work));
    let take = || slot.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
    let run = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
        take().map(|work| pool.install(work))
    };
    let result = std::thread::scope(|scope| {
        let spawned = std::thread::Builder::new().spawn_scoped(scope, run).ok()?;
        spawned.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    match result {
        Some(result) => result,
        // A system that has no thread left still has this one.
        None => match take() {
            Some(work) => work(),
            None => unreachable!("the work is taken only to be done"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// Without threads apart this hangs: a worker inside the lock picks up another item that wants it.
    #[test]
    fn parallel_work_under_a_lock_ends() {
        let lock = Mutex::new(0u64);
        (0..64u64).into_par_iter().for_each(|i| {
            let mut sum = lock.lock().expect("nobody panics");
            *sum += apart(|| (0..1000u64).into_par_iter().map(|k| k * i).sum::<u64>());
        });
        assert_eq!(*lock.lock().expect("nobody panics"), 499_500 * 2016);
    }
}
