//! The parts of a graph: nodes, outputs, exposed parameters and the texts about the graph.
//!
//! The keys of a part are declared once, in its struct: reading, checking, writing and the published schema all follow
//! from its JSON schema. A key that is unknown, or whose value does not fit, stays in `extra` as it was written and is
//! reported as a problem.

use std::sync::{Arc, LazyLock};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::{Map, Value as Json};

use super::canvas::{Bends, Note};
use super::problem::{Hints, Severity, listed};
use super::set::Settings;
use crate::files::{Format, Target};
use crate::node::{self, AnyNode, Kind};
use crate::params::packed::View;
use crate::params::{self, Param};
use crate::value::{Quantity, WireType};

/// The kind of a node in a graph.
#[derive(Clone, Debug)]
pub enum KindRef {
    /// A kind of this program.
    Known(Arc<Kind>),
    /// A kind that this program does not have, or only in an older version; the node is kept as it was written.
    Unknown(String),
}

impl KindRef {
    /// The name in the file.
    pub fn id(&self) -> &str {
        match self {
            Self::Known(kind) => &kind.id,
            Self::Unknown(id) => id,
        }
    }
}

/// Where a node should run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Backend {
    /// Where the build says.
    #[default]
    Auto,
    /// On the processor.
    Cpu,
    /// On the graphics card, if there is one and the kind can.
    Gpu,
}

/// One node of a graph.
#[derive(Clone, Debug)]
pub struct GraphNode {
    /// Name, unique in the graph.
    pub name: String,
    /// The kind of the node.
    pub kind: KindRef,
    /// The parameters that are set, including exposed ones; the others have their defaults.
    pub set: Settings,
    /// Place on the canvas.
    pub at: [f64; 2],
    /// Where it should run.
    pub backend: Backend,
    /// Whether it is left out: what it would change passes through as it is.
    pub bypass: bool,
    /// Where the wires into its inputs bend on the canvas.
    pub bends: Vec<Bends>,
    /// What the file says beyond that, kept as it was written.
    pub extra: Map<String, Json>,
    /// Inputs that do not resolve, as they were written.
    pub(super) loose: Map<String, Json>,
}

impl GraphNode {
    /// The kind of the node, if this program has it.
    pub fn kind(&self) -> Option<&Arc<Kind>> {
        match &self.kind {
            KindRef::Known(kind) => Some(kind),
            KindRef::Unknown(_) => None,
        }
    }

    /// The node with parsed parameters, ready to run. It is parsed once, and again after a change.
    ///
    /// # Errors
    /// Fails when a parameter does not fit or the kind is unknown.
    pub fn parse(&self) -> node::Result<Arc<dyn AnyNode>> {
        self.set.parse(self.known()?)
    }

    /// The hash of the parameters that is part of keys, see [`Kind::digest`].
    ///
    /// # Errors
    /// Returns the errors of [`parse`](Self::parse).
    pub fn digest(&self) -> node::Result<[u8; 32]> {
        self.set.digest(self.known()?)
    }

    fn known(&self) -> node::Result<&Arc<Kind>> {
        match &self.kind {
            KindRef::Known(kind) => Ok(kind),
            KindRef::Unknown(id) => Err(node::Error::Parameter {
                name: "kind".to_owned(),
                message: format!("is `{id}`, which this version does not know"),
            }),
        }
    }

    /// The inputs that do not resolve, as they were written.
    pub fn unresolved(&self) -> impl Iterator<Item = (&str, &Json)> {
        self.loose.iter().map(|(port, written)| (port.as_str(), written))
    }

    /// The parameters that differ from their defaults, in the order of the kind, then those that the kind does not
    /// know.
    pub(super) fn changed(&self) -> Map<String, Json> {
        let params = self.kind().map_or(&[][..], |kind| kind.params());
        let same = |value: View<'_>, p: &Param| value.equals(&p.default, super::json::same);
        let known = params.iter().filter_map(|p| Some((p, self.set.view(&p.name)?)));
        let known =
            known.filter(|(p, value)| !same(*value, p)).map(|(p, value)| (p.name.clone(), value.json()));
        let is_param = |name: &str| params.iter().any(|p| p.name == name);
        let rest = self.set.record().iter().filter(|(name, _)| !is_param(name));
        known.chain(rest.map(|(name, value)| (name.to_owned(), value.json()))).collect()
    }
}

/// One output of a graph: a file to write.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Output {
    /// The output of a node, as `node.port`.
    #[schemars(length(max = 512))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub from: String,
    /// File format; by default one that suits the values: `exr` for heights and fields, `png16` for masks, `png8` for
    /// colours, `geojson` for lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<Format>,
    /// The values that the lowest and the highest integer of the file stand for; by default those found on the base
    /// grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Lets values beyond the range be cut off instead of stopping the build.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub clip: bool,
    /// The program that the file is meant for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<Target>,
    /// Writes the rows from south to north.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flip: bool,
    /// What it is for.
    #[schemars(length(max = 65536))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// What the file says beyond that, kept as it was written.
    #[serde(skip)]
    pub extra: Map<String, Json>,
}

impl Output {
    /// The format in which a value of a type is written: what is asked for, where that holds what the value consists of,
    /// lines or samples; else its own; else one that suits what its numbers mean.
    pub fn format_for(&self, asked: Option<Format>, wire: WireType, quantity: Option<Quantity>) -> Format {
        let suits = |f: &Format| f.holds_lines() != wire.is_raster();
        asked.filter(suits).or(self.format).unwrap_or(match (quantity, self.target) {
            _ if !wire.is_raster() => Format::Geojson,
            (Some(Quantity::Elevation), Some(target)) => target.format(),
            (Some(Quantity::Color), _) => Format::Png8,
            (Some(Quantity::Mask), _) => Format::Png16,
            _ => Format::Exr,
        })
    }
}

/// One exposed parameter: a name for parameters of nodes, or settings of the terrain, that share a value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Exposed {
    /// What it sets: `node.parameter` or `terrain.setting`; deeper paths lead into modes, as `node.mode.turned.angle`.
    #[schemars(length(min = 1, max = 1000))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bind: Vec<String>,
    /// The value; it takes the place of what the nodes themselves say. Null is not written: what is left out is
    /// taken from the first bind, which then has it.
    #[serde(skip_serializing_if = "Json::is_null")]
    pub value: Json,
    /// Lowest value, where it is higher than what the parameters allow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Highest value, where it is lower than what the parameters allow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Name for people.
    #[schemars(length(max = 200))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// What it does.
    #[schemars(length(max = 65536))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// What the file says beyond that, kept as it was written.
    #[serde(skip)]
    pub extra: Map<String, Json>,
}

impl Exposed {
    /// An exposed parameter with one bind, whose value it takes over.
    pub fn of(bind: &str) -> Self {
        Self { bind: vec![bind.to_owned()], ..Self::default() }
    }
}

/// What a graph says about itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct About {
    /// Name for people.
    #[schemars(length(max = 1024))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Who made it.
    #[schemars(length(max = 1024))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub author: String,
    /// Under which licence, as an SPDX expression.
    #[schemars(length(max = 1024))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub license: String,
    /// What it is.
    #[schemars(length(max = 65536))]
    #[serde(skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Words to find it by.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
}

/// The keys of a node apart from its kind, its inputs and its parameters.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(super) struct NodeKeys {
    /// Place on the canvas.
    #[schemars(inner(range(min = -1.0e9, max = 1.0e9)))]
    pub(super) at: [f64; 2],
    /// Where it should run.
    #[serde(skip_serializing_if = "is_auto")]
    pub(super) backend: Backend,
    /// Leaves it out: what it would change passes through as it is.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) bypass: bool,
    /// Where the wires into its inputs bend on the canvas.
    #[schemars(length(max = 1000))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) bends: Vec<Bends>,
}

fn is_auto(backend: &Backend) -> bool {
    *backend == Backend::Auto
}

/// A part whose keys are read from its own JSON schema.
pub(super) trait Part: Default + Serialize + DeserializeOwned + JsonSchema {
    /// The keys of the part.
    fn keys() -> &'static [Param];

    /// Takes the keys with fitting values out of an object; the others stay in it.
    fn take(written: &mut Map<String, Json>) -> Self {
        let fits = |p: &&Param| written.get(&p.name).is_some_and(|v| p.shape.check(v).is_ok());
        let keys: Vec<&Param> = Self::keys().iter().filter(fits).collect();
        let pairs = keys.iter().filter_map(|p| Some((p.name.clone(), written.get(&p.name)?.clone())));
        let Ok(part) = Self::deserialize(Json::Object(pairs.collect())) else { return Self::default() };
        for key in keys {
            written.shift_remove(&key.name);
        }
        part
    }

    /// The object to write, with keys in the order of declaration. Values in `extra` take precedence.
    fn give(&self, extra: &Map<String, Json>) -> Map<String, Json> {
        let mut map = match serde_json::to_value(self) {
            Ok(Json::Object(map)) => map,
            _ => Map::new(),
        };
        map.extend(extra.iter().map(|(k, v)| (k.clone(), v.clone())));
        map
    }

    /// Drops what would hide a key that is known.
    fn forget_known(extra: &mut Map<String, Json>) {
        extra.retain(|key, _| !Self::keys().iter().any(|p| p.name == *key));
    }
}

macro_rules! parts {
    ($($name:ident),+) => {$(
        impl Part for $name {
            fn keys() -> &'static [Param] {
                static KEYS: LazyLock<Vec<Param>> = LazyLock::new(|| {
                    params::of_schema(&schemars::schema_for!($name).to_value(), &Json::Null)
                });
                &KEYS
            }
        }
    )+};
}
parts!(Output, Exposed, About, NodeKeys, Note);

/// The faults of the keys in `extra`: known keys whose values do not fit, and unknown ones.
pub(super) fn faults(
    keys: &[Param],
    more: &[&'static str],
    extra: &Map<String, Json>,
    hints: &Hints,
) -> Vec<(Severity, String)> {
    let names = || keys.iter().map(|k| k.name.as_str()).chain(more.iter().copied());
    let fault = |(name, value): (&String, &Json)| match keys.iter().find(|k| k.name == *name) {
        Some(key) => {
            let why = key.shape.check(value).err().unwrap_or_else(|| "cannot be read".to_owned());
            (Severity::Error, format!("`{name}` {why}"))
        }
        None if more.contains(&name.as_str()) => (Severity::Error, format!("`{name}` must be an object")),
        None => {
            let (known, hint) = (listed(names()), hints.nearest(name, names()));
            let message = format!("the key `{name}` is not known and kept as it is; known are {known}{hint}");
            (Severity::Warning, message)
        }
    };
    extra.iter().map(fault).collect()
}
