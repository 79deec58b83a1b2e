//! What a node is: a struct of its parameters, typed ports, and an algorithm.
//!
//! A kind implements [`Node`]; the registry holds it as a [`Kind`], its type erased; a parsed node of a graph is
//! an [`AnyNode`].

mod kind;

use std::fmt::Debug;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Map, Value as Json};

pub use self::kind::{AnyNode, Kind};
pub use crate::context::{Cancel, Context, Row, SourceFile};
pub use crate::cost::{Cost, Margin, Reach, SECONDS_PER_BYTE};
pub use crate::error::{Error, Result};
use crate::ports::Ports;
use crate::source;
use crate::value::{Grid, Object, Quantity, Terrain, Value};

/// What a run is asked for, as far as it is known before it starts: its cost hangs on it.
#[derive(Clone, Copy)]
pub struct Load<'a> {
    /// The grid of the outputs; of a gridless node the base grid, on which it reads fields.
    pub grid: Grid,
    /// The world, with its base grid.
    pub terrain: &'a Terrain,
    /// The values without a grid at its inputs, where they are known.
    pub known: Known<'a>,
}

impl<'a> Load<'a> {
    /// A run on a grid of which no input is known.
    pub fn on(grid: Grid, terrain: &'a Terrain) -> Self {
        Self { grid, terrain, known: &|_| None }
    }

    /// The object at an input, where it is known.
    pub fn object<T: Object>(&self, port: &str) -> Option<T> {
        (self.known)(port)?.object().cloned()
    }
}

/// Numbers about the whole terrain, computed on the base grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary(pub Arc<[f64]>);

/// What a kind reads beside its parameters and inputs; everything named goes into the keys of its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reads(u8);

impl Reads {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// The seed of the graph.
    pub const SEED: Self = Self(1);
    /// Extent, sea level and place on Earth of the terrain.
    pub const TERRAIN: Self = Self(2);
    /// The base cell, as the scale of derivatives.
    pub const BASE: Self = Self(4);
    /// All of it.
    pub const ALL: Self = Self(7);

    /// Both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` is in it.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// How much of the detail that is finer than the base grid an output keeps that the engine carries to other grids
/// (law 3): the factor `keep` of `out = up(out_base) + keep · (in_build − up(in_base))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// All of it, `keep = 1`: the change is added to the input as it is.
    Whole,
    /// The same share everywhere; a gain where it is above 1.
    Times(f64),
    /// What a field among the outputs says, in plain numbers: 0 where the detail is buried, 1 where it stays.
    By(&'static str),
}

/// Rewrites the parameters of one version of a kind into those of the next.
pub type Migration = fn(&mut Map<String, Json>);

/// What does not depend on the parameters.
#[derive(Debug)]
pub struct Meta {
    /// Raised when the same parameters give another result, or a parameter or default changes.
    pub version: u32,
    /// Keys into `docs/references.bib`.
    pub cite: &'static [&'static str],
    /// Words an artist may search for, beside the name.
    pub keywords: &'static [&'static str],
    /// What it reads beside parameters and inputs.
    pub reads: Reads,
    /// Pairs of output and input that the engine mixes by the `mask` input. It adds that input and reads it alone, unless
    /// the kind declares a field of that name among its inputs: then both read it.
    pub mixes: &'static [(&'static str, &'static str)],
    /// Pairs of output and input for a global kind that changes a field: the change is carried to finer grids, with as
    /// much of their detail as [`Node::keep`] says.
    pub carries: &'static [(&'static str, &'static str)],
    /// One step for each version before the current.
    pub migrations: &'static [Migration],
    /// Whether a gridless kind runs in no time, since its parameters and inputs hold what it gives: it is run when a
    /// plan is made, so that the plan knows what those who read it cost.
    pub quick: bool,
}

impl Meta {
    /// The first version of a kind that reads nothing else and mixes nothing.
    pub const fn new() -> Self {
        let (none, pairs): (&[&str], &[(&str, &str)]) = (&[], &[]);
        Self {
            version: 1,
            cite: none,
            keywords: none,
            reads: Reads::NONE,
            mixes: pairs,
            carries: pairs,
            migrations: &[],
            quick: false,
        }
    }

    /// Declares a gridless kind that runs in no time.
    pub const fn quick(self) -> Self {
        Self { quick: true, ..self }
    }

    /// With papers, as keys into `docs/references.bib`.
    pub const fn cite(self, cite: &'static [&'static str]) -> Self {
        Self { cite, ..self }
    }

    /// With words an artist may search for.
    pub const fn keywords(self, keywords: &'static [&'static str]) -> Self {
        Self { keywords, ..self }
    }

    /// Declares what it reads beside parameters and inputs.
    pub const fn reads(self, reads: Reads) -> Self {
        Self { reads, ..self }
    }

    /// Lets the engine mix outputs with inputs by a mask.
    pub const fn mixes(self, mixes: &'static [(&'static str, &'static str)]) -> Self {
        Self { mixes, ..self }
    }

    /// Lets the engine carry the change of a global kind to finer grids.
    pub const fn carries(self, carries: &'static [(&'static str, &'static str)]) -> Self {
        Self { carries, ..self }
    }

    /// Raises the version by one step for each migration.
    pub const fn migrations(self, migrations: &'static [Migration]) -> Self {
        Self { migrations, version: migrations.len() as u32 + 1, ..self }
    }
}

impl Default for Meta {
    fn default() -> Self {
        Self::new()
    }
}

/// A file that a node wants to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRequest {
    /// The parameter that asks for it.
    pub parameter: &'static str,
    /// Name beside the graph, or below a folder the user allowed.
    pub name: String,
    /// Whether the node can do without it.
    pub optional: bool,
}

/// The value at an input, where it is known before the node runs.
pub type Known<'a> = &'a dyn Fn(&str) -> Option<Value>;

/// What the numbers at an input mean; `None` where it is not connected or has none.
pub type Quantities<'a> = &'a dyn Fn(&str) -> Option<Quantity>;

/// Computes a [`Summary`] from the inputs on the base grid.
pub type Summarize<N> = fn(&N, &Context<'_>, &<N as Node>::In) -> Result<Summary>;

/// One kind of node: its fields are its parameters, its doc comment is its manual page.
pub trait Node:
    Clone + Debug + Default + Serialize + DeserializeOwned + JsonSchema + Send + Sync + 'static
{
    /// The inputs.
    type In: Ports;
    /// The outputs.
    type Out: Ports;
    /// What does not depend on the parameters.
    const META: Meta;

    /// How far the node looks from a point of its output.
    fn reach(&self) -> Reach;

    /// The window of input `port` that an output window needs. The engine may hand over more, and less where the
    /// window leaves the apron of the terrain: there the border value continues, as [`crate::value::Raster::at`] reads it.
    /// It may stand on a refined lattice.
    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid {
        let (_, _) = (port, terrain);
        self.reach().window(window)
    }

    /// Further windows of input `port` that a point or local node reads beside the footprint, each on any lattice:
    /// as a rule that of the base grid, for what lies far and may be read coarser than the build, so that what an
    /// output window needs does not grow with the size of the build. They end at the apron like the footprint, and
    /// the run finds them by their place in the list with [`Context::view`], for which the kind declares
    /// [`Reads::BASE`].
    fn views(&self, port: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid> {
        let (_, _, _) = (port, window, terrain);
        Vec::new()
    }

    /// Whether an input matters to the result with these parameters; one that does not is never evaluated.
    fn uses(&self, port: &str) -> bool {
        let _ = port;
        true
    }

    /// What the numbers of an output whose port leaves it open ([`Meaning::Chosen`](crate::ports::Meaning::Chosen))
    /// mean, given what those of the connected inputs do.
    fn quantity(&self, output: &str, inputs: Quantities<'_>) -> Quantity {
        let (_, _) = (output, inputs);
        Quantity::Number
    }

    /// How much of the finer detail of its input an output keeps that [`Meta::carries`] names. Where nothing changed on
    /// the base grid the input stays whatever is kept, to the bit.
    fn keep(&self, output: &str) -> Detail {
        let _ = output;
        Detail::Whole
    }

    /// What a run needs beyond inputs and outputs.
    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 2.0)
    }

    /// Checks what the schema cannot say: parameters that must fit each other.
    ///
    /// # Errors
    /// Names the parameter, the limit and the value found.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// The files to read.
    fn files(&self) -> Vec<FileRequest> {
        Vec::new()
    }

    /// What reading and decoding the files takes: bytes at the peak, the content among them, and seconds on one core.
    /// Headers may be looked at; the content may not, unless its hash is known, so that somebody has gone through it before.
    ///
    /// # Errors
    /// What is wrong with a file, as far as it shows there: then nobody has to go through its content.
    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost> {
        Ok(source::reading(files))
    }

    /// Width in metres of the narrowest feature that a global kind makes; below two base cells it is lost.
    fn narrowest(&self) -> Option<f64> {
        None
    }

    /// How to compute the statistic of the whole that the node needs, if it needs one with these parameters.
    fn summary(&self) -> Option<Summarize<Self>> {
        None
    }

    /// Computes the outputs on the grid of the context.
    ///
    /// # Errors
    /// When an input or file is not what it should be, or the work is cancelled.
    fn run(&self, cx: &Context<'_>, input: Self::In) -> Result<Self::Out>;
}
