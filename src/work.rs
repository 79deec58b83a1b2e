//! Long work: who may stop it, and who is told how far it is.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

/// A switch that stops work: cheap to clone, all clones are one switch.
#[derive(Clone, Default)]
pub struct Cancel(Arc<Switch>);

#[derive(Default)]
struct Switch {
    off: AtomicBool,
    /// Who is asked at each look.
    asked: Option<Box<dyn Fn() -> bool + Send + Sync>>,
}

impl fmt::Debug for Cancel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Cancel").field(&self.0.off).finish()
    }
}

impl Cancel {
    /// A switch that asks somebody at each look whether to stop. Who is asked sees how often work looks, on which thread:
    /// so the tests hold every kind to law 12.
    pub fn asking(stop: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(Switch { off: AtomicBool::new(false), asked: Some(Box::new(stop)) }))
    }

    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.0.off.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        if self.0.asked.as_ref().is_some_and(|stop| stop()) {
            self.cancel();
        }
        self.0.off.load(Ordering::Relaxed)
    }

    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The work was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What a piece of long work is given: the switch that stops it, and whom it tells of its progress and of what a person
/// should know. By default nobody stops it and nobody is told.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    cancel: Option<&'a Cancel>,
    progress: &'a (dyn Fn(f32) + Sync),
    warnings: &'a (dyn Fn(String) + Sync),
    /// The part of the whole that this piece is.
    share: (f32, f32),
}

impl Default for Work<'_> {
    fn default() -> Self {
        Self { cancel: None, progress: &|_| (), warnings: &|_| (), share: (0.0, 1.0) }
    }
}

impl fmt::Debug for Work<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Work")
            .field("cancel", &self.cancel)
            .field("share", &self.share)
            .finish_non_exhaustive()
    }
}

impl<'a> Work<'a> {
    /// Work that a switch stops, and that tells nobody.
    pub fn new(cancel: &'a Cancel) -> Self {
        Self { cancel: Some(cancel), ..Self::default() }
    }

    /// The same work, which tells its finished share, 0 to 1.
    #[must_use]
    pub fn telling(self, progress: &'a (dyn Fn(f32) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// The same work, which tells what a person should know.
    #[must_use]
    pub fn warning(self, warnings: &'a (dyn Fn(String) + Sync)) -> Self {
        Self { warnings, ..self }
    }

    /// The same work, which tells nobody.
    #[must_use]
    pub fn quiet(&self) -> Self {
        Self { cancel: self.cancel, ..Self::default() }
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }

    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.map_or(Ok(()), Cancel::check)
    }

    /// Tells the finished share of this piece, 0 to 1.
    pub fn report(&self, done: f32) {
        let (from, to) = self.share;
        (self.progress)(from + (to - from) * done.clamp(0.0, 1.0));
    }

    /// Tells the finished share and asks whether to go on.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn step(&self, done: f32) -> Result<(), Cancelled> {
        self.report(done);
        self.check()
    }

    /// Says what a person should know of the result, in a sentence without a full stop.
    pub fn warn(&self, message: impl Into<String>) {
        (self.warnings)(message.into());
    }

    /// The piece from one share of this one to another: two passes use `stage(0.0, 0.5)` and `stage(0.5, 1.0)`.
    #[must_use]
    pub fn stage(&self, from: f32, to: f32) -> Self {
        let (a, b) = self.share;
        Self { share: (a + (b - a) * from, a + (b - a) * to), ..*self }
    }

    /// Fills rows of so many columns in parallel, in bands of so many rows, with progress; `f` is given the number of the
    /// row.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn rows<T: Send>(
        &self,
        data: &mut [T],
        cols: usize,
        band: usize,
        f: impl Fn(usize, &mut [T]) + Sync,
    ) -> Result<(), Cancelled> {
        // One body for all callers: the machinery of threads is long, and a call a row is nothing.
        self.each_row(data, cols, band, &f)
    }

    fn each_row<T: Send>(
        &self,
        data: &mut [T],
        cols: usize,
        band: usize,
        f: &(dyn Fn(usize, &mut [T]) + Sync),
    ) -> Result<(), Cancelled> {
        let (cols, band) = (cols.max(1), band.max(1));
        let (count, done) = (data.len().div_ceil(cols), AtomicUsize::new(0));
        data.par_chunks_mut(cols * band).enumerate().try_for_each(|(b, rows)| {
            self.check()?;
            rows.chunks_mut(cols).enumerate().for_each(|(i, row)| f(b * band + i, row));
            let finished = done.fetch_add(band, Ordering::Relaxed) + band;
            self.report(finished as f32 / count as f32);
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn stages_are_parts_of_the_whole() {
        let told = Mutex::new(Vec::new());
        let tell = |share: f32| told.lock().expect("no panic").push(share);
        let whole = Work::default().telling(&tell);
        let second = whole.stage(0.5, 1.0);
        second.stage(0.5, 1.0).report(0.5);
        second.report(7.0);
        whole.quiet().report(0.1);
        assert_eq!(*told.lock().expect("no panic"), [0.875, 1.0]);
    }

    #[test]
    fn who_is_asked_sees_each_look_and_stops_the_work_for_good() {
        let looks = Arc::new(AtomicUsize::new(0));
        let counted = looks.clone();
        let cancel = Cancel::asking(move || counted.fetch_add(1, Ordering::Relaxed) == 2);
        let work = Work::new(&cancel);
        assert_eq!([work.check(), work.step(0.5), work.check()], [Ok(()), Ok(()), Err(Cancelled)]);
        assert_eq!((cancel.clone().check(), looks.load(Ordering::Relaxed)), (Err(Cancelled), 4));
    }

    #[test]
    fn rows_are_filled_until_somebody_stops_them() {
        let cancel = Cancel::default();
        let work = Work::new(&cancel);
        let mut data = vec![0; 17];
        work.rows(&mut data, 5, 2, |j, row| row.fill(j)).expect("nobody stops it");
        assert_eq!(data, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3]);
        cancel.cancel();
        assert_eq!(work.rows(&mut data, 5, 2, |_, _| ()), Err(Cancelled));
        assert_eq!((work.check(), work.step(1.0)), (Err(Cancelled), Err(Cancelled)));
    }
}
