//! Kinds and nodes with their types erased: what the registry holds and the engine runs.

use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

use schemars::Schema;
use serde_json::{Map, Value as Json};

use super::{Context, Cost, Error, FileRequest, Known, Meta, Node, Reach, Result, SourceFile, Summary};
use crate::params::{self, Param};
use crate::ports::{self, Port, Ports, Wires};
use crate::value::{Grid, Terrain};

/// A node of a graph with its parameters parsed and its type erased; see [`Node`].
pub trait AnyNode: Debug + Send + Sync {
    /// See [`Node::reach`].
    fn reach(&self) -> Reach;
    /// See [`Node::footprint`].
    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid;
    /// See [`Node::views`].
    fn views(&self, port: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid>;
    /// See [`Node::uses`].
    fn uses(&self, port: &str) -> bool;
    /// See [`Node::cost`].
    fn cost(&self, grid: &Grid) -> Cost;
    /// See [`Node::cost_with`].
    fn cost_with(&self, grid: &Grid, known: Known<'_>) -> Cost;
    /// See [`Node::cost_with_base`].
    fn cost_with_base(&self, grid: &Grid, base: &Grid, known: Known<'_>) -> Cost;
    /// See [`Node::check`].
    ///
    /// # Errors
    /// Those of [`Node::check`].
    fn check(&self) -> Result<()>;
    /// See [`Node::files`].
    fn files(&self) -> Vec<FileRequest>;
    /// See [`Node::reading`].
    ///
    /// # Errors
    /// Those of [`Node::reading`].
    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost>;
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
    fn views(&self, port: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid> {
        Node::views(self, port, window, terrain)
    }
    fn uses(&self, port: &str) -> bool {
        Node::uses(self, port)
    }
    fn cost(&self, grid: &Grid) -> Cost {
        Node::cost(self, grid)
    }
    fn cost_with(&self, grid: &Grid, known: Known<'_>) -> Cost {
        Node::cost_with(self, grid, known)
    }
    fn cost_with_base(&self, grid: &Grid, base: &Grid, known: Known<'_>) -> Cost {
        Node::cost_with_base(self, grid, base, known)
    }
    fn check(&self) -> Result<()> {
        Node::check(self)
    }
    fn files(&self) -> Vec<FileRequest> {
        Node::files(self)
    }
    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost> {
        Node::reading(self, files)
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

    /// The input that an output is a change of, if there is one: what passes through where a node is left out.
    pub fn bridge(&self, output: &str) -> Option<&'static str> {
        let own = self.output(output)?;
        let pairs = self.meta.mixes.iter().chain(self.meta.carries);
        let paired = pairs.filter(|(o, _)| *o == own.name).map(|(_, input)| *input);
        let twin = self.inputs.iter().map(|p| p.name).filter(|name| *name == own.name);
        paired.chain(twin).find(|name| self.input(name).is_some_and(|p| p.wire == own.wire))
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

    /// The first sentence of the manual page, which stands alone.
    pub fn summary(&self) -> String {
        let doc = self.doc();
        let first: Vec<&str> = doc.lines().take_while(|l| !l.trim().is_empty()).collect();
        first.join(" ")
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

    /// Whether it has a parameter that names a file.
    pub fn names_files(&self) -> bool {
        self.files().next().is_some()
    }

    fn files(&self) -> impl Iterator<Item = &Param> {
        self.params().iter().filter(|p| p.widget.as_deref() == Some("file"))
    }

    /// A hash of a node's parameters in canonical form, for keys. Names of files are not in it: a file counts by its
    /// content and the last part of its name, which keys hold beside it.
    pub fn digest(&self, node: &dyn AnyNode) -> [u8; 32] {
        let mut json = node.canonical();
        if let Some(object) = json.as_object_mut() {
            self.files().for_each(|p| {
                object.remove(&p.name);
            });
        }
        *blake3::hash(json.to_string().as_bytes()).as_bytes()
    }
}

impl Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.family, self.id)
    }
}
