//! Results are finite for all that is allowed, and a mask mixes exactly at its ends.

use orograph::engine::{Unobserved, Want};
use orograph::node::{Cancel, Kind};
use orograph::ports::MASK;
use orograph::value::{Field, Grid, Quantity, Terrain, Value, WireType};
use serde_json::Value as Json;

use crate::kinds::registry;
use crate::rig::bench::Bench;
use crate::rig::bytes::bytes;
use crate::rig::graph::{alone, engine, fed, is_refusal, outputs};
use crate::rig::sets::{self, Set};
use crate::rig::{grid, shipped};

/// Sets that give neither finite fields nor a refusal that names the parameter.
fn faults(kind: &Kind, sets: &[Set]) -> Vec<String> {
    let e = engine(2);
    let fault = |set: &Set| {
        let g = fed(kind, set, None);
        let failure = outputs(&e, &g, kind, grid(g.terrain(), 17)).err().filter(|f| !is_refusal(f))?;
        Some(format!("{} {}: {failure}", kind.id, Json::from(set.clone())))
    };
    sets.iter().filter_map(fault).collect()
}

#[test]
fn every_allowed_parameter_gives_finite_fields_or_a_clear_refusal() {
    let mut tried = 0;
    let mut bad = Vec::new();
    for kind in shipped() {
        let sets = sets::all(kind);
        tried += sets.len();
        bad.extend(faults(kind, &sets));
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried > 500, "{tried}");
}

#[test]
fn a_kind_that_is_not_finite_is_found() {
    for (id, said) in [("not_a_number", "not finite"), ("panics", "bug")] {
        let found = faults(registry().find(id).unwrap(), &[sets::defaults()]);
        assert!(found.len() == 1 && found[0].contains(said), "{found:?}");
    }
}

type Pattern = fn(i64, i64) -> f32;

/// Fields that no terrain looks like.
const HOSTILE: [(&str, Pattern); 5] = [
    ("huge", |c, r| if (c + r) % 2 == 0 { 1e9 } else { -1e9 }),
    ("tiny", |c, _| if c % 3 == 0 { 1e-40 } else { -1e-40 }),
    ("flat", |_, _| 1e9),
    ("zero", |_, _| 0.0),
    ("steps", |c, r| (c * r % 7) as f32),
];

/// Fields of a pattern for all inputs of a kind that takes no other; the port that it can do without is left out.
fn hostile(f: Pattern) -> impl Fn(&str, &Grid) -> Option<Value> + Sync {
    move |port, g| {
        let make = |i: usize| f(g.col + (i % g.cols) as i64, g.row + (i / g.cols) as i64);
        let data = (0..g.len()).map(make).collect();
        (port != "vectors").then(|| Value::Field(Field::new(*g, Quantity::Elevation, data)))
    }
}

fn upset(
    kind: &'static Kind,
    set: &Set,
    (name, f): (&str, Pattern),
    terrain: &Terrain,
    at: Grid,
) -> Option<String> {
    // What does not fit each other is refused before a run.
    let bench = Bench::set(kind, set).ok()?;
    let said = |what: String| Some(format!("{}, {name}: {what}", bench.label));
    match bench.run(terrain, at, &hostile(f)) {
        Err(e) => said(e.to_string()),
        Ok(wires) => wires.iter().find_map(|(port, value)| {
            let (col, row) = value.first_not_finite()?;
            said(format!("`{port}` is not finite at {col}, {row}"))
        }),
    }
}

#[test]
fn fields_that_no_terrain_looks_like_give_finite_results() {
    // Cells of 100 m keep the windows of reaches of 50 km small.
    let terrain =
        Terrain { origin: [300.0, -200.0], width: 6400.0, depth: 4800.0, base: 65, ..Terrain::default() };
    let coarse = Grid { col: -3, row: 5, cols: 19, rows: 13, ..grid(&terrain, 65) };
    let fine = Grid { col: 30, row: 50, cols: 17, rows: 15, ..grid(&terrain, 257) };
    let fields = |kind: &&Kind| {
        kind.family != "files"
            && kind.inputs.iter().all(|p| p.wire == WireType::Field || !p.required)
            && kind.inputs.iter().any(|p| p.wire == WireType::Field)
    };
    let (mut kinds, mut bad) = (0, Vec::new());
    for kind in shipped().into_iter().filter(fields) {
        kinds += 1;
        for set in sets::all(kind) {
            for (pattern, at) in HOSTILE.into_iter().zip([coarse, fine].into_iter().cycle()) {
                bad.extend(upset(kind, &set, pattern, &terrain, at));
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(kinds >= 20, "{kinds} kinds");
}

#[test]
fn every_mixing_kind_keeps_its_input_where_the_mask_is_0_and_takes_the_result_where_it_is_1() {
    let mut tried = 0;
    for kind in shipped().into_iter().filter(|k| !k.mixes.is_empty()) {
        let run = |mask| {
            let g = fed(kind, &sets::defaults(), mask);
            alone(&g, kind, grid(g.terrain(), 65)).unwrap_or_else(|e| panic!("{}: {e}", kind.id))
        };
        let (plain, none, all) = (run(None), run(Some("zero.field")), run(Some("one.field")));
        for (output, input) in &kind.mixes {
            let g = fed(kind, &sets::defaults(), None);
            let source = g.source(g.find("node").unwrap(), input).unwrap();
            let want = Want { node: source.node, port: source.port, grid: grid(g.terrain(), 65) };
            let before = engine(1).evaluate(&g, &[want], &Unobserved, &Cancel::default()).unwrap();
            assert!(
                bytes(&none[output.as_str()]) == bytes(before.values[0].as_ref().unwrap()),
                "{} where the mask is 0",
                kind.id
            );
            // What a kind makes of a mask that it reads itself is no mix of what it makes without one.
            assert!(
                kind.hands_over(&MASK.name) || bytes(&all[output.as_str()]) == bytes(&plain[output.as_str()]),
                "{} where the mask is 1",
                kind.id
            );
        }
        tried += 1;
    }
    assert!(tried >= 10, "{tried}");
}
