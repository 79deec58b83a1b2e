//! What a running node may ask of the engine.

use std::sync::Arc;

use crate::kit::{hash, stats};
use crate::name::Name;
use crate::node::{Error, Reads, Result, Summary};
use crate::ports::Wire;
pub use crate::source::SourceFile;
use crate::units::{FilePath, Metres, Seed};
pub use crate::value::Row;
use crate::value::{Field, Grid, Lattice, Quantity, Raster, Sample, Terrain, Value, fill};
pub use crate::work::Cancel;
use crate::work::Work;

/// What a running node may ask of the engine: grid, terrain, seed, files, progress, cancellation.
///
/// A node that asks for something its [`Meta`](crate::node::Meta) does not declare gets an error, since the key of
/// its result would not depend on it.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The grid of the asked-for outputs.
    pub grid: Grid,
    /// What the kind declared to read.
    pub reads: Reads,
    /// The world; nodes ask [`terrain`](Self::terrain).
    pub world: &'a Terrain,
    /// The statistic of the whole; nodes ask [`summary`](Self::summary).
    pub whole: Option<&'a Summary>,
    /// The further windows of inputs, by port in the order of their list; nodes ask [`view`](Self::view).
    pub views: &'a [(Name, Value)],
    /// The files the node named; nodes ask [`file`](Self::file).
    pub files: &'a [Arc<SourceFile>],
    /// Asked inside loops, told the finished share and what a person should know.
    pub work: Work<'a>,
    /// Who may look at the state of a running node; nodes call [`show`](Self::show).
    pub onlooker: Option<Onlooker<'a>>,
}

/// Who may look at the state of a running node.
#[derive(Clone, Copy)]
pub struct Onlooker<'a> {
    /// Whether somebody looks at an output.
    pub looks: &'a (dyn Fn(&str) -> bool + Sync),
    /// Is given an output as it stands.
    pub take: &'a (dyn Fn(&str, Value) + Sync),
}

impl<'a> Context<'a> {
    /// A context on a grid with nothing declared, for tests and benches of single nodes.
    pub fn bare(grid: Grid, world: &'a Terrain, cancel: &'a Cancel) -> Self {
        let reads = Reads::ALL;
        Self {
            grid,
            reads,
            world,
            whole: None,
            views: &[],
            files: &[],
            work: Work::new(cancel),
            onlooker: None,
        }
    }

    /// Extent, sea level and base grid of the terrain.
    ///
    /// # Errors
    /// When the kind did not declare [`Reads::TERRAIN`].
    pub fn terrain(&self) -> Result<&'a Terrain> {
        self.declared(Reads::TERRAIN, "TERRAIN").map(|()| self.world)
    }

    /// Distance between samples of the base grid, in metres: the scale of derivatives where none is given.
    ///
    /// # Errors
    /// When the kind declared neither [`Reads::BASE`] nor [`Reads::TERRAIN`].
    pub fn base_cell(&self) -> Result<f64> {
        self.declared(Reads::BASE, "BASE").map(|()| self.world.base_cell())
    }

    /// The lattice of the base grid, on which [`view`](Self::view)s stand as a rule.
    ///
    /// # Errors
    /// When the kind declared neither [`Reads::BASE`] nor [`Reads::TERRAIN`].
    pub fn base_lattice(&self) -> Result<Lattice> {
        self.declared(Reads::BASE, "BASE").map(|()| self.world.base_lattice())
    }

    /// The node's seed mixed with the graph's.
    ///
    /// # Errors
    /// When the kind did not declare [`Reads::SEED`].
    pub fn seed(&self, node: Seed) -> Result<u64> {
        self.declared(Reads::SEED, "SEED")?;
        Ok(hash::mix(u64::from(self.world.seed) << 32 | u64::from(node.0)))
    }

    /// The statistic that the kind's summary computed on the base grid.
    ///
    /// # Errors
    /// When the node asked for no summary.
    pub fn summary(&self) -> Result<&'a Summary> {
        self.whole.ok_or(Error::Undeclared { what: "summary" })
    }

    /// The range of a field on the context's grid, as a summary of two numbers; see [`range`](crate::kit::stats::range).
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the work was asked to stop.
    pub fn range_summary(&self, field: &Field, clip: f64) -> Result<Summary> {
        self.check()?;
        Ok(Summary(stats::range(&field.crop(&self.grid), clip).into()))
    }

    /// The range that [`range_summary`](Self::range_summary) found.
    ///
    /// # Errors
    /// When the node asked for no summary.
    pub fn summary_range(&self) -> Result<[f64; 2]> {
        let numbers = &self.summary()?.0;
        Ok([0, 1].map(|i| numbers.get(i).copied().unwrap_or(0.0)))
    }

    /// The scale that derivatives are taken at: the node's own, or the base cell.
    ///
    /// # Errors
    /// When there is none and the kind does not declare [`Reads::BASE`].
    pub fn scale(&self, own: Option<Metres>) -> Result<f64> {
        own.map_or_else(|| self.base_cell(), |m| Ok(m.0))
    }

    /// An input on the window that stands at `index` in the list of [`Node::views`](crate::node::Node::views).
    ///
    /// # Errors
    /// When the kind did not declare [`Reads::BASE`], or the list has no such window.
    pub fn view<T: Wire>(&self, port: &'static str, index: usize) -> Result<T> {
        self.declared(Reads::BASE, "BASE")?;
        let mut views = self.views.iter().filter(|(name, _)| *name == port);
        T::take(port, views.nth(index).map(|(_, value)| value.clone()))
    }

    /// A file that the node listed in [`Node::files`](crate::node::Node::files); `None` for an optional one that
    /// is not there.
    pub fn file(&self, name: &FilePath) -> Option<&'a Arc<SourceFile>> {
        self.files.iter().find(|f| f.name() == name.0)
    }

    /// The whole content of a file that a parameter names, held against the hash in the node's key; progress goes
    /// from 0 to 1.
    ///
    /// # Errors
    /// When it is gone, cannot be read, or has changed since the plan; when the work was asked to stop.
    pub fn read(&self, parameter: &'static str, file: &SourceFile) -> Result<Vec<u8>> {
        let read = file.read(&self.work);
        read.map_err(|e| e.of(parameter, file.name()))
    }

    /// # Errors
    /// [`Error::Cancelled`] when the work was asked to stop.
    pub fn check(&self) -> Result<()> {
        Ok(self.work.check()?)
    }

    /// Reports the finished share of this context's work, 0 to 1.
    pub fn report(&self, done: f32) {
        self.work.report(done);
    }

    /// Shows how an output stands while the node works on it, on any grid of the terrain. The value is made only if somebody
    /// looks; it is part of no result, no key and no cache.
    pub fn show<T: Wire>(&self, port: &str, make: impl FnOnce() -> T) {
        if let Some(onlooker) = self.onlooker.filter(|onlooker| (onlooker.looks)(port))
            && let Some(value) = make().give()
        {
            (onlooker.take)(port, value);
        }
    }

    /// Says what a person should know of the result, in a sentence without a full stop: what was left out, what may not be
    /// meant. It must depend on nothing but what the result depends on. The engine names the node, says a sentence once,
    /// and says it again for a result that it has in memory.
    pub fn warn(&self, message: impl Into<String>) {
        self.work.warn(message);
    }

    /// A context for the part of the work from one share to another: two passes use `stage(0.0, 0.5)` and
    /// `stage(0.5, 1.0)`.
    pub fn stage(&self, from: f32, to: f32) -> Self {
        Self { work: self.work.stage(from, to), ..*self }
    }

    /// Fills a raster on the context's grid, rows in parallel, with progress and cancellation.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the work was asked to stop.
    pub fn fill<T: Sample>(&self, quantity: Quantity, f: impl Fn(Row, &mut [T]) + Sync) -> Result<Raster<T>> {
        Ok(fill(&self.work, self.grid, quantity, f)?)
    }

    /// Applies a function to every sample of the context's grid; the input may be a larger window.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the work was asked to stop.
    pub fn map<S: Sample, T: Sample>(
        &self,
        input: &Raster<S>,
        quantity: Quantity,
        f: impl Fn(S) -> T + Sync,
    ) -> Result<Raster<T>> {
        let input = input.crop(&self.grid);
        self.fill(quantity, |row, out| {
            for (o, &x) in out.iter_mut().zip(input.row(row.j)) {
                *o = f(x);
            }
        })
    }

    fn declared(&self, what: Reads, name: &'static str) -> Result<()> {
        if self.reads.has(what) { Ok(()) } else { Err(Error::Undeclared { what: name }) }
    }
}
