//! Kinds to build test graphs of, and a graph of them.

use std::sync::LazyLock;

use orograph::graph::{Graph, NodeId, Problem};
use orograph::node::{Kind, Migration};
use orograph::nodes::Registry;
use orograph::prelude::*;

macro_rules! kind {
    ($name:ident, $module:ident, $meta:expr, { $($inputs:tt)* }, { $($outputs:tt)* }) => {
        mod $module {
            use super::*;
            ports! {
                pub(in super::super) struct Inputs { $($inputs)* }
                pub(in super::super) struct Outputs { $($outputs)* }
            }
        }
        impl Node for $name {
            type In = $module::Inputs;
            type Out = $module::Outputs;
            const META: Meta = $meta;
            fn reach(&self) -> Reach {
                Reach::Point
            }
            fn check(&self) -> Result<()> {
                self.check_all()
            }
            fn uses(&self, port: &str) -> bool {
                self.uses_port(port)
            }
            fn run(&self, _: &Context<'_>, _: Self::In) -> Result<Self::Out> {
                Err(Error::Undeclared { what: "the graph's tests run nothing" })
            }
        }
    };
}

/// Makes hills.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Hills {
    /// Height.
    #[schemars(range(min = 0.0, max = 5000.0))]
    pub amplitude: Metres,
    /// Layers.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub octaves: u32,
    /// How it lies.
    pub mode: Mode,
    /// The scale; the base cell when it is null.
    #[schemars(range(min = 0.1, max = 1.0e6))]
    pub scale: Option<Metres>,
    /// Points of a curve.
    #[schemars(length(min = 0, max = 16))]
    pub points: Vec<[Ratio; 2]>,
    /// The seed.
    pub seed: Seed,
}

/// How the hills lie.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Mode {
    /// As they come.
    Plain,
    /// Turned.
    Turned {
        /// By so much.
        angle: Degrees,
    },
}

impl Default for Hills {
    fn default() -> Self {
        let points = vec![[Ratio(0.0), Ratio(0.0)], [Ratio(1.0), Ratio(1.0)]];
        Self { amplitude: Metres(100.0), octaves: 8, mode: Mode::Plain, scale: None, points, seed: Seed(0) }
    }
}

impl Hills {
    #[allow(clippy::unused_self, reason = "all kinds of the macro have it")]
    fn uses_port(&self, _: &str) -> bool {
        true
    }
    fn check_all(&self) -> Result<()> {
        if self.amplitude.0 > 4000.0 && self.octaves > 12 {
            let message = format!("must be at most 12 above 4000 m, got {}", self.octaves);
            return Err(Error::Parameter { name: "octaves".into(), message });
        }
        Ok(())
    }
}

kind!(Hills, hills, Meta::new().reads(Reads::SEED), {}, {
    /// The hills.
    field: Field,
});

/// Adds two fields.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Sum {
    /// Whether the second counts negative.
    pub minus: bool,
    /// Whether the first is left out.
    pub only_second: bool,
}

impl Sum {
    fn uses_port(&self, port: &str) -> bool {
        port != "a" || !self.only_second
    }
    #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "all kinds of the macro have it")]
    fn check_all(&self) -> Result<()> {
        Ok(())
    }
}

kind!(Sum, sum, Meta::new().mixes(&[("field", "a")]), {
    /// The first.
    a: Field,
    /// The second.
    b: Option<Field>,
}, {
    /// The sum.
    field: Field,
});

/// Gives directions.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Flow {}

impl Flow {
    #[allow(clippy::unused_self, reason = "all kinds of the macro have it")]
    fn uses_port(&self, _: &str) -> bool {
        true
    }
    #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "all kinds of the macro have it")]
    fn check_all(&self) -> Result<()> {
        Ok(())
    }
}

kind!(Flow, flow, Meta::new(), {
    /// What flows.
    field: Field,
}, {
    /// Where it flows.
    direction: Vectors,
});

/// Changed twice: its size was in kilometres, then its name was `extent`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Aged {
    /// Its size.
    #[schemars(range(min = 0.0, max = 1.0e6))]
    pub size: Metres,
}

impl Default for Aged {
    fn default() -> Self {
        Self { size: Metres(1000.0) }
    }
}

impl Aged {
    #[allow(clippy::unused_self, reason = "all kinds of the macro have it")]
    fn uses_port(&self, _: &str) -> bool {
        true
    }
    #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "all kinds of the macro have it")]
    fn check_all(&self) -> Result<()> {
        Ok(())
    }
}

const AGES: &[Migration] = &[
    |set| {
        if let Some(size) = set.get("extent").and_then(serde_json::Value::as_f64) {
            set.insert("extent".into(), (size * 1000.0).into());
        }
    },
    |set| {
        if let Some(size) = set.shift_remove("extent") {
            set.insert("size".into(), size);
        }
    },
];

kind!(Aged, aged, Meta::new().migrations(AGES), {}, {
    /// A field.
    field: Field,
});

/// The kinds of this file beside those of the program.
pub(super) fn registry() -> Registry {
    static KINDS: LazyLock<Registry> = LazyLock::new(|| {
        Registry::standard().with([
            Kind::of::<Hills>("test", "hills"),
            Kind::of::<Sum>("test", "sum"),
            Kind::of::<Flow>("test", "flow"),
            Kind::of::<Aged>("test", "aged"),
        ])
    });
    KINDS.clone()
}

pub(super) fn load(text: &str) -> Graph {
    Graph::from_bytes(text.as_bytes(), &registry()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A graph of some nodes, in the text of a file.
pub(super) fn with_nodes(nodes: &str) -> Graph {
    load(&format!(r#"{{"orograph": 1, "nodes": {{{nodes}}}}}"#))
}

pub(super) fn id(graph: &Graph, name: &str) -> NodeId {
    graph.find(name).unwrap_or_else(|| panic!("no node {name}"))
}

pub(super) fn canonical(graph: &Graph) -> String {
    String::from_utf8(graph.canonical()).unwrap()
}

/// The errors and warnings, as text.
pub(super) fn told(graph: &Graph) -> Vec<String> {
    graph.problems().iter().map(Problem::to_string).collect()
}

pub(super) fn errors(graph: &Graph) -> Vec<String> {
    graph.problems().iter().filter(|p| p.is_error()).map(Problem::to_string).collect()
}

/// Asserts that one of some texts has all of some words, and gives it.
pub(super) fn has<'a>(texts: &'a [String], words: &[&str]) -> &'a str {
    let fits = |t: &&String| words.iter().all(|w| t.contains(w));
    texts.iter().find(fits).unwrap_or_else(|| panic!("{words:?} is in none of {texts:#?}"))
}

/// The example of the file's description, with the kinds of this file; its lines are those of the canonical form.
pub(super) const EXAMPLE: &str = r#"{
  "orograph": 1,
  "kinds": { "constant": 1, "hills": 1, "sum": 1 },
  "title": "Hills on a plain",
  "author": "A. Nobody",
  "license": "CC0-1.0",
  "tags": ["hills", "plain"],
  "terrain": { "origin": [0, 0], "width": 8192, "depth": 8192, "sea_level": 0, "seed": 1, "base": 1025 },
  "expose": {
    "ruggedness": { "bind": ["hills.amplitude"], "value": 120, "min": 0, "max": 400, "label": "Ruggedness" }
  },
  "nodes": {
    "hills": { "kind": "hills", "at": [0, 0], "set": { "amplitude": 120, "seed": 7041 } },
    "plain": { "kind": "constant", "at": [0, 120], "set": { "value": 12.5 } },
    "height": {
      "kind": "sum",
      "at": [240, 0],
      "in": { "a": "hills.field", "b": "plain.field" },
      "set": { "minus": true },
      "backend": "cpu"
    }
  },
  "outputs": {
    "height": { "from": "height.field", "format": "exr" },
    "for_unreal": { "from": "height.field", "format": "png16", "range": [-256, 1792], "target": "unreal" }
  }
}
"#;
