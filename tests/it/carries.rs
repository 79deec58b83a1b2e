//! What a global change keeps of the detail that only a finer grid has, and masks that kind and engine read together.

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Detail, Kind};
use orograph::nodes::Registry;
use orograph::prelude::*;
use orograph::value::Value;
use serde_json::{Value as Json, json};

/// Samples of the base grid, a cell of 64 m and a build four times as fine.
const BASE: u32 = 33;
const CELL: f64 = 64.0;
const FINE: u32 = 129;

/// A plane with a comb on it whose teeth stand between the samples of the base grid, so that the base sees the plane.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Comb {
    /// Height of the teeth.
    teeth: Number,
    /// Height of the plane in the west.
    level: Number,
}

fn plane(level: f64, x: f64) -> f64 {
    level + 0.25 * x
}

fn tooth(height: f64, x: f64) -> f64 {
    height * (x / CELL - (x / CELL).round()).abs()
}

/// Sets a reference with a gain and a step of 100 m into a source, where the mask that it reads is above a half.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Graft {
    /// Factor on the reference.
    gain: Number,
}

impl Default for Graft {
    fn default() -> Self {
        Self { gain: Number(1.0) }
    }
}

/// Buries the west of a field under 50 m of sand, the less of its detail stays the farther west it is.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Bury {
    /// Names an output that is not there.
    astray: bool,
}

mod ports_of {
    use super::{Field, Meaning, Quantity, ports};
    ports! {
        pub(super) struct None {}
        pub(super) struct Land {
            /// Height, in metres.
            field: Field = Meaning::Fixed(Quantity::Elevation),
        }
        pub(super) struct One {
            /// Height, in metres.
            field: Field,
        }
        pub(super) struct Grafted {
            /// What surrounds.
            source: Field,
            /// What is set in.
            reference: Field,
            /// Where.
            mask: Option<Field>,
        }
        pub(super) struct Buried {
            /// Height, in metres.
            field: Field = Meaning::Fixed(Quantity::Elevation),
            /// What is kept of the detail.
            keep: Field = Meaning::Fixed(Quantity::Mask),
        }
    }
}

impl Node for Comb {
    type In = ports_of::None;
    type Out = ports_of::Land;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, _: ports_of::None) -> Result<ports_of::Land> {
        let xs = cx.grid.xs();
        let field = cx.fill(Quantity::Elevation, |_, out| {
            for (o, &x) in out.iter_mut().zip(&xs) {
                *o = (plane(self.level.0, x) + tooth(self.teeth.0, x)) as f32;
            }
        })?;
        Ok(ports_of::Land { field })
    }
}

impl Node for Graft {
    type In = ports_of::Grafted;
    type Out = ports_of::Land;
    const META: Meta = Meta::new().carries(&[("field", "reference")]).mixes(&[("field", "source")]);
    fn reach(&self) -> Reach {
        Reach::Global
    }
    fn keep(&self, _: &str) -> Detail {
        Detail::Times(self.gain.0)
    }
    fn run(&self, cx: &Context<'_>, input: ports_of::Grafted) -> Result<ports_of::Land> {
        let ports_of::Grafted { source, reference, mask } = input;
        let (source, reference) = (source.crop(&cx.grid), reference.crop(&cx.grid));
        let mask = mask.ok_or(Error::Missing { port: "mask".into() })?.crop(&cx.grid);
        let gain = self.gain.0 as f32;
        let field = cx.fill(Quantity::Elevation, |row, out| {
            let parts = source.row(row.j).iter().zip(reference.row(row.j)).zip(mask.row(row.j));
            for (o, ((s, r), m)) in out.iter_mut().zip(parts) {
                *o = if *m > 0.5 { gain * r + 100.0 } else { *s };
            }
        })?;
        Ok(ports_of::Land { field })
    }
}

/// What is kept at an x: nothing in the west, all from a quarter of the terrain on.
fn kept(x: f64) -> f64 {
    (x / 512.0).clamp(0.0, 1.0)
}

impl Node for Bury {
    type In = ports_of::One;
    type Out = ports_of::Buried;
    const META: Meta = Meta::new().carries(&[("field", "field")]);
    fn reach(&self) -> Reach {
        Reach::Global
    }
    fn keep(&self, _: &str) -> Detail {
        Detail::By(if self.astray { "sand" } else { "keep" })
    }
    fn run(&self, cx: &Context<'_>, ports_of::One { field }: ports_of::One) -> Result<ports_of::Buried> {
        let (xs, field) = (cx.grid.xs(), field.crop(&cx.grid));
        let buried = cx.fill(Quantity::Elevation, |row, out| {
            for ((o, z), &x) in out.iter_mut().zip(field.row(row.j)).zip(&xs) {
                *o = if x < 1024.0 { z + 50.0 } else { *z };
            }
        })?;
        let keep = cx.fill(Quantity::Mask, |_, out| {
            out.iter_mut().zip(&xs).for_each(|(o, &x)| *o = kept(x) as f32);
        })?;
        Ok(ports_of::Buried { field: buried, keep })
    }
}

/// 1 east of a place and 0 west of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct East {
    /// The place.
    from: Number,
}

impl Node for East {
    type In = ports_of::None;
    type Out = ports_of::Land;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, _: ports_of::None) -> Result<ports_of::Land> {
        let xs = cx.grid.xs();
        let field = cx.fill(Quantity::Elevation, |_, out| {
            out.iter_mut().zip(&xs).for_each(|(o, &x)| *o = f32::from(u8::from(x >= self.from.0)));
        })?;
        Ok(ports_of::Land { field })
    }
}

fn registry() -> Registry {
    Registry::standard().with([
        Kind::of::<Comb>("test", "comb"),
        Kind::of::<Graft>("test", "graft"),
        Kind::of::<Bury>("test", "bury"),
        Kind::of::<East>("test", "east"),
    ])
}

fn graph(nodes: &Json) -> Graph {
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 2048, "depth": 1024, "base": BASE },
        "nodes": nodes,
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).expect("a graph")
}

fn field(engine: &Engine, graph: &Graph, node: &str, size: u32) -> Result<Field, String> {
    let grid = graph.terrain().grid(size).expect("a size");
    let want = Want { node: graph.find(node).expect("the node"), port: "field".into(), grid };
    let cancel = Cancel::default();
    let mut done = engine.evaluate(graph, &[want], &Unobserved, &cancel).expect("an evaluation");
    match done.values.remove(0) {
        Ok(Value::Field(field)) => Ok(field),
        Ok(other) => panic!("a field, not {other:?}"),
        Err(failure) => Err(failure.to_string()),
    }
}

fn engine() -> Engine {
    Engine::new(&Options { threads: 2, ..Options::default() }, Files::default()).expect("an engine")
}

fn grafting(gain: f64) -> Graph {
    graph(&json!({
        "source": { "kind": "comb", "set": { "teeth": 3, "level": 900 } },
        "reference": { "kind": "comb", "set": { "teeth": 8 } },
        "where": { "kind": "east", "set": { "from": 1024 } },
        "end": {
            "kind": "graft",
            "set": { "gain": gain },
            "in": { "source": "source.field", "reference": "reference.field", "mask": "where.field" },
        },
    }))
}

#[test]
fn a_gain_weighs_the_detail_and_outside_the_mask_every_bit_stays() {
    let e = engine();
    for gain in [0.0, 0.3, 1.0, 2.5] {
        let g = grafting(gain);
        let (end, source) = (field(&e, &g, "end", FINE).unwrap(), field(&e, &g, "source", FINE).unwrap());
        let grid = *end.grid();
        let mut teeth = 0;
        for (i, x) in grid.xs().into_iter().enumerate() {
            let (found, outside) = (f64::from(end.row(5)[i]), source.row(5)[i]);
            if x < 1024.0 {
                assert_eq!(found as f32, outside, "west of the mask, at {x}");
            } else if (1024.0 + 10.0 * CELL..2048.0 - CELL).contains(&x) {
                // Nearer to the step at the mask a spline swings.
                let wanted = gain * (plane(0.0, x) + tooth(8.0, x)) + 100.0;
                assert!((found - wanted).abs() < 0.01, "gain {gain}, at {x}: {found}, not {wanted}");
                teeth += usize::from(tooth(8.0, x) > 3.0);
            }
        }
        assert!(teeth >= 4, "{teeth}");
        // On the base grid nothing is interpolated.
        let (end, source) = (field(&e, &g, "end", BASE).unwrap(), field(&e, &g, "source", BASE).unwrap());
        assert_eq!(end.at(3, 2), source.at(3, 2));
        assert_eq!(end.at(20, 2), gain as f32 * plane(0.0, 20.0 * CELL) as f32 + 100.0);
    }
}

#[test]
fn a_kind_that_the_engine_mixes_reads_a_mask_of_its_own() {
    let registry = registry();
    let graft = registry.find("graft").unwrap();
    assert_eq!(graft.inputs.iter().filter(|p| p.name == "mask").count(), 1, "the engine adds no other");
    assert!(graft.hands_over("mask"));
    let dig = registry.find("blur").unwrap();
    assert!(dig.input("mask").is_some() && !dig.hands_over("mask") && dig.hands_over("field"));
}

#[test]
fn a_field_weighs_the_detail_and_where_nothing_changed_every_bit_stays() {
    let g = graph(&json!({
        "land": { "kind": "comb", "set": { "teeth": 8, "level": 100 } },
        "end": { "kind": "bury", "in": { "field": "land.field" } },
    }));
    let e = engine();
    let (end, land) = (field(&e, &g, "end", FINE).unwrap(), field(&e, &g, "land", FINE).unwrap());
    let (mut buried, mut untouched) = (0, 0);
    for (i, x) in end.grid().xs().into_iter().enumerate() {
        let found = end.row(9)[i];
        // A spline rounds the kink of the weight and the step of the sand, for some cells.
        if (4.0 * CELL..512.0 - 3.0 * CELL).contains(&x) {
            let wanted = plane(100.0, x) + 50.0 + kept(x) * tooth(8.0, x);
            assert!((f64::from(found) - wanted).abs() < 0.05, "at {x}: {found}, not {wanted}");
            buried += usize::from(tooth(8.0, x) > 3.0);
        } else if x > 1024.0 + 2.0 * CELL {
            assert_eq!(found.to_bits(), land.row(9)[i].to_bits(), "at {x}");
            untouched += 1;
        }
    }
    assert!(buried > 0 && untouched > 30, "{buried}, {untouched}");
    // The weight itself is an output like any other, and may be wanted alone or with the rest.
    let grid = g.terrain().grid(FINE).unwrap();
    let want = |port: &str| Want { node: g.find("end").unwrap(), port: port.into(), grid };
    let done = e.evaluate(&g, &[want("keep"), want("field")], &Unobserved, &Cancel::default()).unwrap();
    assert_eq!(done.values[1].as_ref().unwrap().components(), end.data());
}

#[test]
fn a_weight_that_is_no_output_is_named() {
    let g = graph(&json!({
        "land": { "kind": "comb", "set": { "teeth": 8 } },
        "end": { "kind": "bury", "set": { "astray": true }, "in": { "field": "land.field" } },
    }));
    let e = engine();
    let said = field(&e, &g, "end", FINE).unwrap_err();
    assert!(said.contains("sand") && said.contains("`field`"), "{said}");
    assert!(field(&e, &g, "end", BASE).is_ok(), "on the base grid nothing is carried");
}
