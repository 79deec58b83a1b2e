//! Kinds and nodes with their types erased: what the registry holds and the engine runs.

mod digest;

use std::fmt::Debug;
use std::sync::{Arc, OnceLock};

use serde_json::{Map, Value as Json, json};

use super::{
    Context, Cost, Detail, Error, FileRequest, Load, Meta, Migration, Node, Quantities, Reach, Reads, Result,
    SourceFile, Summary,
};
use crate::name::Name;
use crate::params::packed::{self, Record};
use crate::params::{self, Param};
use crate::ports::{self, Meaning, Port, Ports, Wires};
use crate::source;
use crate::value::{Grid, Quantity, Terrain};
use crate::widget::Widget;

/// A node of a graph with its parameters parsed and its type erased; see [`Node`], whose defaults it has.
pub trait AnyNode: Debug + Send + Sync {
    /// See [`Node::reach`].
    fn reach(&self) -> Reach;
    /// See [`Node::footprint`].
    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid {
        let (_, _) = (port, terrain);
        self.reach().window(window)
    }
    /// See [`Node::views`].
    fn views(&self, port: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid> {
        let (_, _, _) = (port, window, terrain);
        Vec::new()
    }
    /// See [`Node::uses`].
    fn uses(&self, port: &str) -> bool {
        let _ = port;
        true
    }
    /// See [`Node::quantity`].
    fn quantity(&self, output: &str, inputs: Quantities<'_>) -> Quantity {
        let (_, _) = (output, inputs);
        Quantity::Number
    }
    /// See [`Node::keep`].
    fn keep(&self, output: &str) -> Detail {
        let _ = output;
        Detail::Whole
    }
    /// See [`Node::cost`].
    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 2.0)
    }
    /// See [`Node::check`].
    ///
    /// # Errors
    /// Those of [`Node::check`].
    fn check(&self) -> Result<()> {
        Ok(())
    }
    /// See [`Node::files`].
    fn files(&self) -> Vec<FileRequest> {
        Vec::new()
    }
    /// See [`Node::reading`].
    ///
    /// # Errors
    /// Those of [`Node::reading`].
    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost> {
        Ok(source::reading(files))
    }
    /// See [`Node::narrowest`].
    fn narrowest(&self) -> Option<f64> {
        None
    }
    /// Whether the node needs a summary.
    fn needs_summary(&self) -> bool {
        false
    }
    /// Computes the summary from inputs on the base grid.
    ///
    /// # Errors
    /// Those of the kind.
    fn summarize(&self, cx: &Context<'_>, wires: Wires) -> Result<Summary> {
        let (_, _) = (cx, wires);
        Err(Error::Undeclared { what: "summary" })
    }
    /// See [`Node::run`].
    ///
    /// # Errors
    /// Those of the kind.
    fn run(&self, cx: &Context<'_>, wires: Wires) -> Result<Wires>;
    /// The parameters in canonical form: all of them, in declaration order, −0 as 0.
    fn canonical(&self) -> Json;
    /// The hash of the canonical form.
    fn digest(&self) -> [u8; 32] {
        digest::of(&self.canonical())
    }
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
    fn quantity(&self, output: &str, inputs: Quantities<'_>) -> Quantity {
        Node::quantity(self, output, inputs)
    }
    fn keep(&self, output: &str) -> Detail {
        Node::keep(self, output)
    }
    fn cost(&self, load: &Load<'_>) -> Cost {
        Node::cost(self, load)
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
    fn digest(&self) -> [u8; 32] {
        digest::of_node(self).unwrap_or_else(|_| digest::of(&self.canonical()))
    }
}

/// Makes a node of its parameters, an object that may leave out what has its default.
type Parser = Box<dyn Fn(&Record) -> Result<Arc<dyn AnyNode>> + Send + Sync>;
/// Makes a JSON document, when it is first asked for: most programs ask for few kinds.
type Document = Box<dyn Fn() -> Json + Send + Sync>;

/// What a node is to the outside: its ports, its parameters, its page, and how a node is made of it. The registry holds
/// those of the structs of this program; others may be made while it runs.
pub struct Kind {
    /// Its name in graph files.
    pub id: Name,
    /// The family it stands in: `generate`, `filter` …
    pub family: Name,
    /// See [`Meta::version`].
    pub version: u32,
    /// See [`Meta::cite`].
    pub cite: Vec<Name>,
    /// See [`Meta::keywords`].
    pub keywords: Vec<Name>,
    /// See [`Meta::reads`].
    pub reads: Reads,
    /// See [`Meta::mixes`].
    pub mixes: Vec<(Name, Name)>,
    /// See [`Meta::carries`].
    pub carries: Vec<(Name, Name)>,
    /// See [`Meta::migrations`].
    pub migrations: Vec<Migration>,
    /// See [`Meta::quick`].
    pub quick: bool,
    /// The inputs, `mask` among them where the kind mixes.
    pub inputs: Vec<Port>,
    /// The outputs.
    pub outputs: Vec<Port>,
    schema: Document,
    defaults: Document,
    parse: Parser,
    params: OnceLock<Vec<Param>>,
    /// The names of the parameters that name files.
    files: OnceLock<Vec<String>>,
    /// Whether the last input is a mask that the engine alone reads.
    has_engine_mask: bool,
}

impl Kind {
    /// The kind of a struct of this program.
    pub fn of<N: Node>(family: &'static str, id: &'static str) -> Self {
        let parse = |set: &Record| -> Result<Arc<dyn AnyNode>> {
            let node = N::deserialize(set).map_err(|e| unreadable(&e))?;
            Ok(Arc::new(node))
        };
        let schema = || schemars::schema_for!(N).to_value();
        let defaults = || serde_json::to_value(N::default()).unwrap_or(Json::Null);
        let kind = Self::bare(Name::new_static(family), Name::new_static(id), Box::new(parse));
        let kind = Self { schema: Box::new(schema), defaults: Box::new(defaults), ..kind };
        kind.declared(N::META, N::In::PORTS, N::Out::PORTS)
    }

    /// What does not depend on the type of the node: one body for all kinds.
    fn declared(self, meta: Meta, inputs: &[Port], outputs: &[Port]) -> Self {
        let names = |all: &[&'static str]| all.iter().copied().map(Name::new_static).collect();
        let pairs = |all: &[(&'static str, &'static str)]| {
            let named = |(output, input): &(&'static str, &'static str)| {
                (Name::new_static(output), Name::new_static(input))
            };
            all.iter().map(named).collect()
        };
        let kind = Self {
            version: meta.version,
            cite: names(meta.cite),
            keywords: names(meta.keywords),
            reads: meta.reads,
            carries: pairs(meta.carries),
            migrations: meta.migrations.to_vec(),
            quick: meta.quick,
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            ..self
        };
        kind.mixing(pairs(meta.mixes))
    }

    /// A kind without ports and parameters, in its first version, whose nodes are made by `parse`.
    pub fn new(
        family: impl Into<Name>,
        id: impl Into<Name>,
        parse: impl Fn(&Map<String, Json>) -> Result<Arc<dyn AnyNode>> + Send + Sync + 'static,
    ) -> Self {
        Self::bare(family.into(), id.into(), Box::new(move |set: &Record| parse(&set.json())))
    }

    fn bare(family: Name, id: Name, parse: Parser) -> Self {
        Self {
            id,
            family,
            version: 1,
            cite: Vec::new(),
            keywords: Vec::new(),
            reads: Reads::NONE,
            mixes: Vec::new(),
            carries: Vec::new(),
            migrations: Vec::new(),
            quick: false,
            inputs: Vec::new(),
            outputs: Vec::new(),
            schema: Box::new(|| json!({ "type": "object" })),
            defaults: Box::new(|| json!({})),
            parse,
            params: OnceLock::new(),
            files: OnceLock::new(),
            has_engine_mask: false,
        }
    }

    /// The kind with parameters: the JSON schema of an object, whose description is the manual page, and an object that
    /// has the default of each.
    #[must_use]
    pub fn with_parameters(self, schema: Json, defaults: Json) -> Self {
        Self {
            schema: Box::new(move || schema.clone()),
            defaults: Box::new(move || defaults.clone()),
            params: OnceLock::new(),
            files: OnceLock::new(),
            ..self
        }
    }

    /// The kind with pairs of output and input that the engine mixes, and an input for the mask by which it does unless
    /// the kind has one of that name: then the node reads it, too.
    #[must_use]
    pub fn mixing(mut self, pairs: Vec<(Name, Name)>) -> Self {
        let has_engine_mask = !pairs.is_empty() && self.input(&ports::MASK.name).is_none();
        if has_engine_mask {
            self.inputs.push(ports::MASK);
        }
        Self { mixes: pairs, has_engine_mask, ..self }
    }

    /// Whether the node itself reads an input, rather than the engine alone, which mixes by it.
    pub fn hands_over(&self, port: &str) -> bool {
        !self.has_engine_mask || port != ports::MASK.name
    }

    /// Whether an input matters to the result of a node; the mask by which the engine mixes always does.
    pub fn uses(&self, node: &dyn AnyNode, port: &str) -> bool {
        (port == ports::MASK.name && !self.mixes.is_empty()) || node.uses(port)
    }

    /// The input of a name.
    pub fn input(&self, name: &str) -> Option<&Port> {
        self.inputs.iter().find(|p| p.name == name)
    }

    /// The output of a name.
    pub fn output(&self, name: &str) -> Option<&Port> {
        self.outputs.iter().find(|p| p.name == name)
    }

    /// The input that an output is a change of, if there is one: what passes through where a node is left out.
    pub fn bridge(&self, output: &str) -> Option<&Name> {
        let own = self.output(output)?;
        let pairs = self.mixes.iter().chain(&self.carries);
        let paired = pairs.filter(|(o, _)| *o == own.name).map(|(_, input)| input);
        let twin = self.inputs.iter().map(|p| &p.name).filter(|name| **name == own.name);
        paired.chain(twin).find(|name| self.input(name).is_some_and(|p| p.wire == own.wire))
    }

    /// What the numbers of an output of a node mean, given what those of its connected inputs do; `None` where it has
    /// none, or its node decides and there is none.
    pub fn quantity(
        &self,
        node: Option<&dyn AnyNode>,
        output: &str,
        inputs: Quantities<'_>,
    ) -> Option<Quantity> {
        match &self.output(output)?.meaning {
            Meaning::Fixed(quantity) => Some(*quantity),
            Meaning::Like(input) => Some(inputs(input).unwrap_or(Quantity::Number)),
            Meaning::Chosen => Some(node?.quantity(output, inputs)),
            Meaning::Nothing => None,
        }
    }

    /// The JSON schema of the parameters.
    pub fn schema(&self) -> Json {
        (self.schema)()
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
        self.parse_packed(&set.clone().into())
    }

    /// Parses parameters whose lists of numbers are packed.
    pub(crate) fn parse_packed(&self, set: &Record) -> Result<Arc<dyn AnyNode>> {
        packed::check(self.params(), set)?;
        let parsed = (self.parse)(set)?;
        parsed.check()?;
        Ok(parsed)
    }

    /// Whether it has a parameter that names a file.
    pub fn names_files(&self) -> bool {
        !self.files().is_empty()
    }

    fn files(&self) -> &[String] {
        let named = |p: &Param| (p.widget == Some(Widget::File)).then(|| p.name.clone());
        self.files.get_or_init(|| self.params().iter().filter_map(named).collect())
    }

    /// A hash of a node's parameters in canonical form, for keys. Names of files are not in it: a file counts by its
    /// content and the last part of its name, which keys hold beside it.
    pub fn digest(&self, node: &dyn AnyNode) -> [u8; 32] {
        if !self.names_files() {
            return node.digest();
        }
        let mut json = node.canonical();
        if let Some(object) = json.as_object_mut() {
            self.files().iter().for_each(|name| {
                object.remove(name);
            });
        }
        digest::of(&json)
    }
}

fn unreadable(e: &serde_json::Error) -> Error {
    Error::Parameter { name: "set".into(), message: format!("cannot be read: {e}") }
}

impl Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.family, self.id)
    }
}
