//! What a node is: a struct of its parameters, typed ports, and an algorithm.
//!
//! A kind implements [`Node`]; the registry holds it as a [`Kind`], its type erased; a parsed node of a graph is
//! an [`AnyNode`].

use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

use schemars::{JsonSchema, Schema};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Map, Value as Json};

pub use crate::context::{Cancel, Context, Row, SourceFile};
use crate::params::{self, Param};
use crate::ports::{self, Port, Ports, Wires};
use crate::value::curves::CurveError;
use crate::value::{Grid, Terrain, WireType};

/// The result of a node.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a node could not run. The graph adds which node it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A required input has no wire.
    #[error("input `{port}` is not connected")]
    Missing {
        /// The input.
        port: &'static str,
    },
    /// A wire of the wrong type arrived.
    #[error("input `{port}` takes {}, got {}", want.name(), got.name())]
    WireType {
        /// The input.
        port: &'static str,
        /// What it takes.
        want: WireType,
        /// What came.
        got: WireType,
    },
    /// An input carries something the node cannot work on.
    #[error("input `{port}` {message}")]
    Input {
        /// The input.
        port: &'static str,
        /// What is wrong with it.
        message: String,
    },
    /// A parameter, or several together, make no sense.
    #[error("parameter `{name}` {message}")]
    Parameter {
        /// The parameter.
        name: String,
        /// What is wrong, with the limit and the value found.
        message: String,
    },
    /// A file is missing, unreadable or not what it should be.
    #[error("parameter `{parameter}`: {message}: {file}")]
    File {
        /// The parameter that names it.
        parameter: &'static str,
        /// The file, as the graph names it.
        file: String,
        /// What is wrong with it.
        message: String,
    },
    /// The kind asked its context for something its [`Meta`] does not declare: a bug of the kind.
    #[error("the kind asks for `{what}` and does not declare it")]
    Undeclared {
        /// What it asked for.
        what: &'static str,
    },
    /// An output has a number that is not finite: a bug of the kind, or parameters at their limit.
    #[error("output `{port}` is not finite at column {col}, row {row}")]
    NotFinite {
        /// The output.
        port: &'static str,
        /// Column in the window.
        col: usize,
        /// Row in the window.
        row: usize,
    },
    /// An output stands on another grid, or is missing: a bug of the kind.
    #[error("output `{port}` {message}")]
    Output {
        /// The output.
        port: &'static str,
        /// What is wrong with it.
        message: String,
    },
    /// The kind panicked: a bug of the kind.
    #[error("stopped by a bug of its kind: {message}")]
    Panic {
        /// What the panic said.
        message: String,
    },
    /// The work was asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl Error {
    /// What is wrong with curves, as a fault of the node that made or read them.
    pub fn of_curves(e: CurveError) -> Self {
        match e {
            CurveError::Cancelled => Self::Cancelled,
            CurveError::Parameter { name, message } => Self::Parameter { name: name.into(), message },
            other => Self::Parameter { name: "curves".into(), message: other.to_string() },
        }
    }
}

/// How far a node looks from a point of its output: decides on which grid it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// No grid at all: curves, rivers, points. The node runs once; fields that it reads come from the base grid.
    Gridless,
    /// A value depends on its own point alone.
    Point,
    /// A value depends on a window around its point; see [`Node::footprint`].
    Local(Margin),
    /// A value depends on the whole terrain: the node runs on the base grid.
    Global,
}

impl Reach {
    /// A local reach of some metres.
    pub fn local(metres: f64) -> Self {
        Self::Local(Margin { metres, cells: 0 })
    }

    /// The reach with some cells more.
    pub fn plus_cells(self, n: i64) -> Self {
        match self {
            Self::Point => Self::Local(Margin { metres: 0.0, cells: n }),
            Self::Local(m) => Self::Local(Margin { cells: m.cells + n, ..m }),
            Self::Gridless | Self::Global => self,
        }
    }
}

/// A distance in metres and some cells more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margin {
    /// Metres.
    pub metres: f64,
    /// Cells of the grid the node runs on.
    pub cells: i64,
}

/// What a run needs beyond its inputs and outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Bytes of scratch memory at the peak, inputs and outputs not counted.
    pub bytes: u64,
    /// Seconds on one core.
    pub seconds: f64,
}

impl Cost {
    /// A cost of some nanoseconds a sample and no scratch memory.
    pub fn per_sample(grid: &Grid, nanoseconds: f64) -> Self {
        Self { bytes: 0, seconds: grid.len() as f64 * nanoseconds * 1e-9 }
    }

    /// The cost with scratch memory for some f32 per sample of a grid.
    pub fn with_fields(self, grid: &Grid, fields: f64) -> Self {
        Self { bytes: self.bytes + (grid.len() as f64 * 4.0 * fields) as u64, ..self }
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
    /// Pairs of output and input that the engine mixes by the `mask` input.
    pub mixes: &'static [(&'static str, &'static str)],
    /// Pairs of output and input for a global kind that changes a field: the change is carried to finer grids.
    pub carries: &'static [(&'static str, &'static str)],
    /// One step for each version before the current.
    pub migrations: &'static [Migration],
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
        }
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
        match self.reach() {
            Reach::Local(m) => window.grow_metres(m.metres).grow_cells(m.cells),
            Reach::Gridless | Reach::Point | Reach::Global => *window,
        }
    }

    /// Whether an input matters to the result with these parameters; one that does not is never evaluated.
    fn uses(&self, port: &str) -> bool {
        let _ = port;
        true
    }

    /// What a run on an output grid needs beyond inputs and outputs.
    fn cost(&self, grid: &Grid) -> Cost {
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

    /// Bytes that the decoded content of the files takes while it is read and after, for the budget of memory.
    fn decoded_bytes(&self, files: &[Arc<SourceFile>]) -> u64 {
        let _ = files;
        0
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

/// A node of a graph with its parameters parsed and its type erased; see [`Node`].
pub trait AnyNode: Debug + Send + Sync {
    /// See [`Node::reach`].
    fn reach(&self) -> Reach;
    /// See [`Node::footprint`].
    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid;
    /// See [`Node::uses`].
    fn uses(&self, port: &str) -> bool;
    /// See [`Node::cost`].
    fn cost(&self, grid: &Grid) -> Cost;
    /// See [`Node::check`].
    ///
    /// # Errors
    /// Those of [`Node::check`].
    fn check(&self) -> Result<()>;
    /// See [`Node::files`].
    fn files(&self) -> Vec<FileRequest>;
    /// See [`Node::decoded_bytes`].
    fn decoded_bytes(&self, files: &[Arc<SourceFile>]) -> u64;
    /// See [`Node::narrowest`].
    fn narrowest(&self) -> Option<f64>;
    /// Whether the node needs a summary.
    fn needs_summary(&self) -> bool;
    /// Computes the summary from inputs on the base grid.
    ///
    /// # Errors
    /// Those of the kind.
    fn summarize(&self, cx: &Context<'_>, wires: Wires) -> Result<Summary>;
    /// See [`Node::run`].
    ///
    /// # Errors
    /// Those of the kind.
    fn run(&self, cx: &Context<'_>, wires: Wires) -> Result<Wires>;
    /// The parameters in canonical form: all of them, in declaration order, −0 as 0.
    fn canonical(&self) -> Json;
}

impl<N: Node> AnyNode for N {
    fn reach(&self) -> Reach {
        Node::reach(self)
    }
    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid {
        Node::footprint(self, port, window, terrain)
    }
    fn uses(&self, port: &str) -> bool {
        Node::uses(self, port)
    }
    fn cost(&self, grid: &Grid) -> Cost {
        Node::cost(self, grid)
    }
    fn check(&self) -> Result<()> {
        Node::check(self)
    }
    fn files(&self) -> Vec<FileRequest> {
        Node::files(self)
    }
    fn decoded_bytes(&self, files: &[Arc<SourceFile>]) -> u64 {
        Node::decoded_bytes(self, files)
    }
    fn narrowest(&self) -> Option<f64> {
        Node::narrowest(self)
    }
    fn needs_summary(&self) -> bool {
        self.summary().is_some()
    }
    fn summarize(&self, cx: &Context<'_>, mut wires: Wires) -> Result<Summary> {
        let summarize = self.summary().ok_or(Error::Undeclared { what: "summary" })?;
        summarize(self, cx, &N::In::take(&mut wires)?)
    }
    fn run(&self, cx: &Context<'_>, mut wires: Wires) -> Result<Wires> {
        Ok(Node::run(self, cx, N::In::take(&mut wires)?)?.give())
    }
    fn canonical(&self) -> Json {
        let mut json = serde_json::to_value(self).unwrap_or(Json::Null);
        params::drop_negative_zero(&mut json);
        json
    }
}

/// A node kind with its type erased: what the registry holds.
pub struct Kind {
    /// Its name in graph files.
    pub id: &'static str,
    /// The family it stands in: `generate`, `filter` …
    pub family: &'static str,
    /// What does not depend on the parameters.
    pub meta: &'static Meta,
    /// The outputs.
    pub outputs: &'static [Port],
    inputs: &'static [Port],
    schema: fn() -> Schema,
    defaults: fn() -> Json,
    parse: fn(&Json) -> Result<Arc<dyn AnyNode>, serde_json::Error>,
    params: OnceLock<Vec<Param>>,
}

impl Kind {
    /// Erases the type of a node kind.
    pub const fn of<N: Node>(family: &'static str, id: &'static str) -> Self {
        Self {
            id,
            family,
            meta: &N::META,
            inputs: N::In::PORTS,
            outputs: N::Out::PORTS,
            schema: || schemars::schema_for!(N),
            defaults: || serde_json::to_value(N::default()).unwrap_or(Json::Null),
            parse: |json| Ok(Arc::new(N::deserialize(json)?)),
            params: OnceLock::new(),
        }
    }

    /// The inputs, the engine's `mask` included where the kind mixes.
    pub fn inputs(&self) -> impl Iterator<Item = &'static Port> + use<> {
        let mask = (!self.meta.mixes.is_empty()).then_some(&ports::MASK);
        self.inputs.iter().chain(mask)
    }

    /// The input of a name.
    pub fn input(&self, name: &str) -> Option<&'static Port> {
        self.inputs().find(|p| p.name == name)
    }

    /// The output of a name.
    pub fn output(&self, name: &str) -> Option<&'static Port> {
        self.outputs.iter().find(|p| p.name == name)
    }

    /// The JSON schema of the parameters.
    pub fn schema(&self) -> Json {
        (self.schema)().to_value()
    }

    /// The manual page: the doc comment of the struct.
    pub fn doc(&self) -> String {
        // Citations are escaped in the source, where rustdoc would take them for links.
        self.schema()["description"].as_str().unwrap_or_default().replace("\\[", "[").replace("\\]", "]")
    }

    /// The parameters as data, read from the schema once.
    pub fn params(&self) -> &[Param] {
        self.params.get_or_init(|| params::of_schema(&self.schema(), &(self.defaults)()))
    }

    /// The parameter of a name.
    pub fn param(&self, name: &str) -> Option<&Param> {
        self.params().iter().find(|p| p.name == name)
    }

    /// Parses parameters: a JSON object that may leave out what has its default.
    ///
    /// # Errors
    /// Names the parameter, what was found and what was expected; the nearest name where one is unknown.
    pub fn parse(&self, set: &Map<String, Json>) -> Result<Arc<dyn AnyNode>> {
        params::check_all(self.params(), set)?;
        let whole = Json::Object(set.clone());
        let parsed = (self.parse)(&whole)
            .map_err(|e| Error::Parameter { name: "set".into(), message: format!("cannot be read: {e}") })?;
        parsed.check()?;
        Ok(parsed)
    }
}

impl Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.family, self.id)
    }
}
