//! A type of wire that only this file knows: made, wired, planned, cached, drawn like those of the program.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use orograph::engine::{Engine, Evaluation, Files, Keep, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use orograph::nodes::Registry;
use orograph::prelude::*;
use orograph::render::thumbnail;
use orograph::value::{ObjectType, Pin, Sketch, SketchLine, WireType};
use serde_json::json;

/// Pegs in the ground: east, south and height of each.
#[derive(Clone, Debug, PartialEq)]
struct Pegs(Arc<[[f64; 3]]>);

impl Object for Pegs {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "pegs",
        color: [200, 30, 40],
        pin: Pin::Polygon { corners: 5, turn: 0.5 },
        sample_bytes: 0,
        load: Some(|bytes| {
            let pegs = Self(bytemuck::try_cast_slice(bytes).ok()?.into());
            pegs.fault().is_none().then(|| pegs.into())
        }),
        guessed_bytes: 1000,
        has_features: true,
    };

    fn bytes(&self) -> u64 {
        size_of_val(&*self.0) as u64
    }

    fn fault(&self) -> Option<String> {
        let bad = self.0.iter().position(|peg| peg.iter().any(|x| !x.is_finite()))?;
        Some(format!("is not finite at peg {bad}"))
    }

    fn sketch(&self) -> Sketch {
        let peg = |&[x, y, z]: &[f64; 3]| -> SketchLine { vec![([x, y], Some(0.0)), ([x, y], Some(z))] };
        Sketch::Lines(self.0.iter().map(peg).collect())
    }

    fn say(&self, at: [f64; 2]) -> Option<String> {
        let near = self.0.iter().find(|[x, y, _]| (x - at[0]).abs() + (y - at[1]).abs() < 10.0)?;
        Some(format!("a peg of {} m", near[2]))
    }

    fn save(&self) -> Vec<u8> {
        bytemuck::cast_slice(&self.0).to_vec()
    }
}

/// Drives pegs into the ground along a diagonal of the terrain.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Drive {
    /// How many.
    #[schemars(range(min = 0, max = 2_000_000))]
    count: u32,
    /// Whether the last is broken.
    broken: bool,
}

impl Default for Drive {
    fn default() -> Self {
        Self { count: 3, broken: false }
    }
}

mod drive {
    use super::{Pegs, ports};
    ports! {
        pub(super) struct Inputs {}
        pub(super) struct Outputs {
            /// The pegs.
            pegs: Pegs,
        }
    }
}

impl Node for Drive {
    type In = drive::Inputs;
    type Out = drive::Outputs;
    const META: Meta = Meta::new().reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, _: &Load<'_>) -> Cost {
        Cost { bytes: 24 * u64::from(self.count), seconds: f64::from(self.count) * 1e-8 }
    }

    fn run(&self, cx: &Context<'_>, _: drive::Inputs) -> Result<drive::Outputs> {
        let terrain = cx.terrain()?;
        let peg = |i: u32| {
            let share = (f64::from(i) + 0.5) / f64::from(self.count);
            let height = if self.broken && i + 1 == self.count { f64::NAN } else { f64::from(i) };
            [share * terrain.width, share * terrain.depth, height]
        };
        Ok(drive::Outputs { pegs: Pegs((0..self.count).map(peg).collect()) })
    }
}

/// Stretches a cloth over pegs: everywhere the mean of their heights.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Cloth {}

mod cloth {
    use super::{Field, Meaning, Pegs, Quantity, ports};
    ports! {
        pub(super) struct Inputs {
            /// The pegs.
            pegs: Pegs,
        }
        pub(super) struct Outputs {
            /// The cloth.
            height: Field = Meaning::Fixed(Quantity::Elevation),
        }
    }
}

impl Node for Cloth {
    type In = cloth::Inputs;
    type Out = cloth::Outputs;
    const META: Meta = Meta::new();

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let pegs = load.object::<Pegs>("pegs").map_or(0, |pegs| pegs.0.len());
        Cost { bytes: 8 * pegs as u64, ..Cost::per_sample(&load.grid, 2.0) }
    }

    fn run(&self, cx: &Context<'_>, cloth::Inputs { pegs }: cloth::Inputs) -> Result<cloth::Outputs> {
        let mean = pegs.0.iter().map(|peg| peg[2]).sum::<f64>() / pegs.0.len().max(1) as f64;
        Ok(cloth::Outputs { height: Field::constant(cx.grid, Quantity::Elevation, mean as f32) })
    }
}

fn registry() -> Registry {
    static KINDS: LazyLock<Registry> = LazyLock::new(|| {
        let kinds = [Kind::of::<Drive>("test", "drive"), Kind::of::<Cloth>("test", "cloth")];
        Registry::standard().with(kinds)
    });
    KINDS.clone()
}

fn graph(count: u32, broken: bool) -> Graph {
    let file = json!({ "orograph": 1, "terrain": { "width": 1000, "depth": 1000, "base": 33 }, "nodes": {
        "pegs": { "kind": "drive", "set": { "count": count, "broken": broken } },
        "cloth": { "kind": "cloth", "in": { "pegs": "pegs.pegs" } },
    }, "outputs": { "height": { "from": "cloth.height" } } });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).unwrap()
}

fn engine(cache: Option<&Path>) -> Engine {
    let cache = cache.map(Path::to_owned);
    Engine::new(&Options { threads: 1, cache, ..Options::default() }, Files::default()).unwrap()
}

fn wants(graph: &Graph) -> [Want; 2] {
    let grid = graph.terrain().grid(17).unwrap();
    let want = |node: &str, port: &str| Want { node: graph.find(node).unwrap(), port: port.into(), grid };
    [want("cloth", "height"), want("pegs", "pegs")]
}

fn evaluate(engine: &Engine, graph: &Graph) -> Evaluation {
    engine.evaluate(graph, &wants(graph), &Unobserved, &Cancel::default()).unwrap()
}

#[test]
fn they_are_wired_evaluated_and_drawn() {
    let graph = graph(3, false);
    assert!(graph.problems().iter().all(|p| !p.is_error()), "{:?}", graph.problems());
    let values = evaluate(&engine(None), &graph).values;
    assert_eq!(values[0].as_ref().unwrap().components()[0], 1.0);
    let pegs = values[1].as_ref().unwrap();
    assert_eq!(pegs.object::<Pegs>().unwrap().0.len(), 3);
    assert_eq!((pegs.bytes(), pegs.grid(), pegs.quantity()), (72, None, None));
    assert_eq!(pegs.object::<Curves>(), None);
    let wire = pegs.wire_type();
    assert_eq!((wire, wire.name(), wire.color()), (WireType::Object(Pegs::TYPE), "pegs", [200, 30, 40]));
    let Value::Object(object) = pegs else { panic!("an object") };
    assert_eq!(object.say([500.0, 500.0]).as_deref(), Some("a peg of 1 m"));
    let picture = thumbnail(pegs, 16, &Cancel::default()).unwrap();
    // They stand on a diagonal, so that the other corners are ground.
    let drawn = picture.rgb.iter().filter(|c| **c != picture.rgb[15]).count();
    assert_eq!(drawn, 3);
}

#[test]
fn wires_of_other_types_are_refused_by_name() {
    let mut graph = graph(3, false);
    let blur = graph.add("blur", "blur").unwrap();
    let refused = graph.connect(graph.find("pegs").unwrap(), "pegs", blur, "field").unwrap_err();
    assert!(refused.to_string().contains("takes field, but `pegs.pegs` gives pegs"), "{refused}");
}

#[test]
fn what_is_not_finite_is_an_error_of_its_node() {
    let failure = evaluate(&engine(None), &graph(3, true)).values[0].clone().unwrap_err().to_string();
    assert!(failure.contains("node `pegs`: output `pegs` is not finite at peg 2"), "{failure}");
}

#[test]
fn what_they_hold_is_planned_once_it_is_known() {
    let (graph, engine) = (graph(1_000_000, false), engine(None));
    let bytes = |node: &str| {
        let plan = engine.plan(&graph, &wants(&graph));
        let task = plan.tasks().into_iter().find(|t| t.node == node).unwrap();
        (task.output_bytes, task.cost.bytes)
    };
    assert_eq!(bytes("cloth").1, 0, "nobody knows the pegs");
    let evaluation = evaluate(&engine, &graph);
    assert!(evaluation.planned_bytes >= 24_000_000 + 8_000_000, "{}", evaluation.planned_bytes);
    assert_eq!(bytes("pegs").0, 24_000_000);
    assert_eq!(evaluation.effective_cells[1], Some(0.0));
}

#[test]
fn the_cache_folder_keeps_them() {
    let folder = tempfile::tempdir().unwrap();
    let graph = graph(1000, false);
    let cached = |evaluation: &Evaluation| {
        let task = evaluation.tasks.iter().find(|t| t.node == "pegs").unwrap();
        task.cached
    };
    let first = evaluate(&engine(Some(folder.path())), &graph);
    assert_eq!(cached(&first), None);
    let again = evaluate(&engine(Some(folder.path())), &graph);
    assert_eq!(cached(&again), Some("disk"));
    assert_eq!(again.values[1].as_ref().unwrap(), first.values[1].as_ref().unwrap());
    // A build, which keeps nothing in memory, reads them as well.
    let options = Options {
        threads: 1,
        keep: Keep::Nothing,
        cache: Some(folder.path().to_owned()),
        ..Options::default()
    };
    let build = Engine::new(&options, Files::default()).unwrap();
    assert_eq!(evaluate(&build, &graph).values[0].as_ref().unwrap().components()[0], 499.5);
    for entry in walk(folder.path()) {
        let mut bytes = std::fs::read(&entry).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&entry, bytes).unwrap();
    }
    let mended = evaluate(&engine(Some(folder.path())), &graph);
    assert_ne!(cached(&mended), Some("disk"), "what is damaged is made again");
    assert_eq!(mended.values[1].as_ref().unwrap(), first.values[1].as_ref().unwrap());
}

/// The files below a folder.
fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}
