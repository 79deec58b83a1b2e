//! The laws, as loops over every kind of the registry: a new kind is covered the moment it exists.
//!
//! Each loop is shown to fail: by a lying kind of `kinds`, here or in `engine`.

use std::path::Path;

use orograph::engine::{Engine, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use orograph::params::{Param, Shape};
use orograph::value::{Grid, Value};
use orograph::widget::Widget;
use serde_json::{Map, Value as Json};

use crate::fed::{bits, engine, extremes, fed, grid, outputs, shipped};
use crate::kinds::registry;

#[test]
fn every_kind_is_documented() {
    let mut bad = Vec::new();
    for kind in shipped() {
        let doc = kind.doc();
        let first = doc.lines().next().unwrap_or_default();
        if first.len() < 15 || !(doc.contains(". ") || doc.contains(".\n") || doc.ends_with('.')) {
            bad.push(format!("{}: no page", kind.id));
        }
        let ports = kind.inputs.iter().chain(&kind.outputs);
        bad.extend(
            ports.filter(|p| p.doc.len() < 10).map(|p| format!("{}: port {} has no words", kind.id, p.name)),
        );
        faults(&kind.id, kind.params(), true, &mut bad);
        if kind.keywords.is_empty() {
            bad.push(format!("{}: no keywords", kind.id));
        }
        if kind.version as usize != kind.migrations.len() + 1 {
            bad.push(format!("{}: version {} without its migrations", kind.id, kind.version));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    let mut lying = Vec::new();
    faults("waves", registry().find("hog").unwrap().params(), true, &mut lying);
    assert!(lying.is_empty(), "{lying:?}");
}

fn faults(kind: &str, params: &[Param], top: bool, bad: &mut Vec<String>) {
    for p in params {
        let mut say = |what: String| bad.push(format!("{kind}.{}: {what}", p.name));
        if p.doc.len() < 5 {
            say("no words".into());
        }
        let mut shape = &p.shape;
        while let Shape::Optional(inner) | Shape::List { item: inner, .. } = shape {
            shape = inner;
        }
        match shape {
            Shape::Number { min, max, .. } => {
                if *min <= f64::MIN || *max >= f64::MAX {
                    say("no range".into());
                }
                if p.unit.is_none() && p.widget.is_none() {
                    say("no unit".into());
                }
            }
            Shape::Unknown => say("a schema that no panel can show".into()),
            _ => (),
        }
        if top && let Err(e) = p.shape.check(&p.default) {
            say(format!("the default {e}"));
        }
        if let Shape::Choice(modes) = &p.shape {
            let undocumented: Vec<_> =
                modes.iter().filter(|m| m.doc.len() < 5).map(|m| m.name.clone()).collect();
            if !undocumented.is_empty() {
                say(format!("modes without words: {}", undocumented.join(", ")));
            }
            modes.iter().for_each(|m| faults(kind, &m.fields, false, bad));
        }
    }
}

#[test]
fn tiles_of_every_kind_are_cut_from_the_whole_bit_for_bit() {
    for kind in shipped() {
        let g = fed(kind, &Map::new(), None);
        let whole_grid = grid(&g, 129);
        let whole = outputs(&engine(2), &g, kind, whole_grid).unwrap_or_else(|e| panic!("{}: {e}", kind.id));
        for (col, row, cols, rows) in [(0, 0, 33, 33), (64, 16, 33, 17), (96, 32, 33, 33), (37, 11, 21, 9)] {
            let tile = Grid { col, row, cols, rows, ..whole_grid };
            let alone = outputs(&engine(2), &g, kind, tile).unwrap();
            for (port, value) in &alone {
                assert!(bits(value) == bits(&whole[port].crop(&tile)), "{}.{port} at {tile:?}", kind.id);
            }
        }
    }
}

#[test]
fn every_kind_gives_the_same_bits_on_any_number_of_threads() {
    for kind in shipped() {
        let g = fed(kind, &Map::new(), None);
        let of = |threads| outputs(&engine(threads), &g, kind, grid(&g, 129)).unwrap();
        let one = of(1);
        for threads in [2, 7] {
            for (port, value) in of(threads) {
                assert!(bits(&value) == bits(&one[&port]), "{}.{port} on {threads} threads", kind.id);
            }
        }
    }
}

#[test]
fn every_allowed_parameter_gives_finite_fields_or_a_clear_refusal() {
    let mut tried = 0;
    for kind in shipped() {
        for p in kind.params().iter().filter(|p| p.widget != Some(Widget::File)) {
            for value in extremes(&p.shape, &p.default) {
                let set: Map<String, Json> = [(p.name.clone(), value.clone())].into_iter().collect();
                let g = fed(kind, &set, None);
                let result = outputs(&engine(2), &g, kind, grid(&g, 17));
                if let Err(e) = result {
                    // Only parameters that do not fit each other may be refused, by name.
                    assert!(
                        e.contains("parameter `") && !e.contains("bug"),
                        "{}.{} = {value}: {e}",
                        kind.id,
                        p.name
                    );
                }
                tried += 1;
            }
        }
    }
    assert!(tried > 150, "{tried}");
}

#[test]
fn every_mixing_kind_keeps_its_input_where_the_mask_is_0_and_takes_the_result_where_it_is_1() {
    let mut tried = 0;
    for kind in shipped().into_iter().filter(|k| !k.mixes.is_empty()) {
        let run = |mask| {
            let g = fed(kind, &Map::new(), mask);
            outputs(&engine(2), &g, kind, grid(&g, 65)).unwrap_or_else(|e| panic!("{}: {e}", kind.id))
        };
        let (plain, none, all) = (run(None), run(Some("zero.field")), run(Some("one.field")));
        for (output, input) in &kind.mixes {
            let g = fed(kind, &Map::new(), None);
            let source = g.source(g.find("node").unwrap(), input).unwrap();
            let want = Want { node: source.node, port: source.port, grid: grid(&g, 65) };
            let before = engine(1).evaluate(&g, &[want], &Unobserved, &Cancel::default()).unwrap();
            assert!(
                bits(&none[output.as_str()]) == bits(before.values[0].as_ref().unwrap()),
                "{} where the mask is 0",
                kind.id
            );
            assert!(
                bits(&all[output.as_str()]) == bits(&plain[output.as_str()]),
                "{} where the mask is 1",
                kind.id
            );
        }
        tried += 1;
    }
    assert!(tried >= 10, "{tried}");
}

#[test]
fn point_kinds_are_equal_to_the_bit_at_every_size() {
    use orograph::node::Reach;
    let mut tried = 0;
    for kind in shipped() {
        let g = fed(kind, &Map::new(), None);
        let node = g.node(g.find("node").unwrap()).parse().unwrap();
        if node.reach() != Reach::Point {
            continue;
        }
        let coarse = outputs(&engine(2), &g, kind, grid(&g, 33)).unwrap();
        for factor in [2u32, 3] {
            let fine = outputs(&engine(2), &g, kind, grid(&g, 32 * factor + 1)).unwrap();
            for (port, value) in &coarse {
                let (Value::Field(c), Value::Field(f)) = (value, &fine[port]) else { continue };
                for j in 0..c.grid().rows as i64 {
                    for i in 0..c.grid().cols as i64 {
                        let k = i64::from(factor);
                        assert!(
                            c.at(i, j).to_bits() == f.at(i * k, j * k).to_bits(),
                            "{}.{port} at ({i}, {j}), {factor} times as fine: {} and {}",
                            kind.id,
                            c.at(i, j),
                            f.at(i * k, j * k)
                        );
                    }
                }
            }
        }
        tried += 1;
    }
    assert!(tried >= 10, "{tried}");
}

/// The shipped presets by name, with what each needs to run here.
pub(crate) fn presets() -> Vec<(String, Graph)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("graphs");
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        let mut g = Graph::open(&path, &orograph::nodes::Registry::standard()).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if g.exposed().any(|(n, _)| n == "file") {
            g.assign("file", "small.asc").unwrap();
        }
        all.push((name, g));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(all.len() >= 3, "{}", all.len());
    all
}

fn preset_output(engine: &Engine, g: &Graph, name: &str, grid: Grid) -> Value {
    let source = g.output_source(name).unwrap();
    let wants = [Want { node: source.node, port: source.port, grid }];
    let all = engine.evaluate(g, &wants, &Unobserved, &Cancel::default()).unwrap();
    all.values.into_iter().next().unwrap().unwrap()
}

#[test]
fn presets_are_faultless_canonical_and_run() {
    for (name, mut g) in presets() {
        let problems = g.problems();
        assert!(problems.is_empty(), "{name}: {problems:?}");
        g.assign("terrain.base", "129").unwrap();
        for (output, _) in g.outputs() {
            preset_output(&engine(2), &g, output, grid(&g, 33));
        }
    }
}

/// The 99th percentile of the difference of two builds at the samples of the coarser, as a share of its range.
fn off(coarse: &Value, fine: &Value) -> f32 {
    let parts = (coarse.wire_type().sample_bytes() / 4) as usize;
    let (c, f) = (*coarse.grid().unwrap(), *fine.grid().unwrap());
    let factor = (f.lattice.intervals / c.lattice.intervals) as usize;
    let (coarse, fine) = (coarse.components(), fine.components());
    let row = |j: usize| {
        let samples = (0..c.cols).flat_map(move |i| (0..parts).map(move |k| (i, k)));
        samples.map(move |(i, k)| {
            let at = (j * factor * f.cols + i * factor) * parts + k;
            (coarse[(j * c.cols + i) * parts + k] - fine[at]).abs()
        })
    };
    let mut all: Vec<f32> = (0..c.rows).flat_map(row).collect();
    all.sort_by(f32::total_cmp);
    let (lo, hi) = coarse.iter().fold((f32::MAX, f32::MIN), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
    all[all.len() * 99 / 100] / (hi - lo)
}

/// Builds outputs of the presets at some sizes and lists what differs between them by more than a share.
fn differences(
    base: Option<&str>,
    sizes: [u32; 3],
    allowed: f32,
    looked_at: impl Fn(&str) -> bool,
) -> Vec<String> {
    let mut bad = Vec::new();
    for (name, mut g) in presets() {
        if let Some(base) = base {
            g.assign("terrain.base", base).unwrap();
        }
        let e = engine(2);
        for (output, _) in g.outputs().filter(|(name, _)| looked_at(name)) {
            let [coarse, middle, fine] = sizes.map(|size| preset_output(&e, &g, output, grid(&g, size)));
            for (a, b) in [(&coarse, &middle), (&middle, &fine), (&coarse, &fine)] {
                let off = off(a, b);
                let sizes = [a, b].map(|v| v.grid().unwrap().lattice.intervals + 1);
                println!("{name} `{output}` at {sizes:?}: 99 % within {:.3} % of the range", 100.0 * off);
                if off > allowed {
                    bad.push(format!("{name} `{output}` at {sizes:?}: {:.3} %", 100.0 * off));
                }
            }
        }
    }
    bad
}

#[test]
fn presets_show_the_same_heights_masks_and_colours_at_every_size() {
    // Below, at and above the base grid. A base grid a quarter as fine as the presets' own makes all of them coarser,
    // and what is a matter of the cell four times as large: their own sizes are the test below.
    let bad = differences(Some("257"), [129, 257, 513], 0.02, |_| true);
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// The measure of law 3 itself, of heights; of every output with `OROGRAPH_FULL=1 cargo test --release own_sizes --
/// --nocapture`, which takes minutes.
#[test]
fn presets_show_the_same_terrain_at_their_own_sizes() {
    let full = std::env::var_os("OROGRAPH_FULL").is_some();
    let bad = differences(None, [513, 1025, 2049], 0.01, |name| full || name == "height");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn presets_in_tiles_are_cut_from_the_whole_bit_for_bit() {
    for (name, mut g) in presets() {
        g.assign("terrain.base", "129").unwrap();
        let whole_grid = grid(&g, 257);
        for (output, _) in g.outputs() {
            let whole = preset_output(&engine(2), &g, output, whole_grid);
            let tile = Grid { col: 64, row: 128, cols: 65, rows: 65, ..whole_grid };
            let alone = preset_output(&engine(2), &g, output, tile);
            assert!(bits(&alone) == bits(&whole.crop(&tile)), "{name}: {output}");
        }
    }
}

/// Tiles of 1025 samples of a build 16385 wide fit in a gigabyte, with all that the program takes beside.
#[test]
fn every_output_of_every_preset_is_built_16385_wide_within_a_gigabyte() {
    // What the program itself and the writers of files take of it.
    let budget = (1 << 30) - (96 << 20);
    let mut over = Vec::new();
    for (name, g) in presets() {
        let whole = grid(&g, 16_385);
        let e = engine(2);
        for (col, row) in [(8192, 8192), (0, 3 * 1024)] {
            let tile = Grid { col, row, cols: 1025, rows: 1025, ..whole };
            let want = |(output, _): (&str, _)| {
                let source = g.output_source(output).unwrap();
                Want { node: source.node, port: source.port, grid: tile }
            };
            let wants: Vec<_> = g.outputs().map(want).collect();
            let bytes = e.plan(&g, &wants).peak_bytes();
            if bytes > budget {
                over.push(format!("{name} at {col}, {row}: {} MiB", bytes >> 20));
            }
        }
    }
    assert!(over.is_empty(), "{}", over.join("\n"));
}

/// A build of many random graphs never panics and every field is finite, whatever is wired to whatever.
mod random {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
        #[test]
        fn graphs_evaluate_or_say_why(picks in prop::collection::vec((any::<u16>(), any::<[u8; 4]>()), 2..9)) {
            let kinds: Vec<_> = shipped().into_iter().filter(|k| k.family != "files").collect();
            let mut g = Graph::with_registry(registry());
            g.assign("terrain.base", "17").unwrap();
            let mut made: Vec<(String, &'static Kind)> = Vec::new();
            for (pick, wires) in picks {
                let kind = kinds[pick as usize % kinds.len()];
                let name = format!("n{}", made.len());
                let id = g.add(&name, &kind.id).unwrap();
                for (i, port) in kind.inputs.iter().enumerate() {
                    if made.is_empty() { break; }
                    let (from, source) = &made[wires[i % 4] as usize % made.len()];
                    let output = source.outputs[wires[(i + 1) % 4] as usize % source.outputs.len()].name.clone();
                    // A wire of the wrong type is refused, and that is a fair outcome.
                    let _ = g.connect(g.find(from).unwrap(), &output, id, &port.name);
                }
                made.push((name, kind));
            }
            let text = g.canonical();
            let again = Graph::from_bytes(&text, &registry()).unwrap();
            prop_assert_eq!(&again.canonical(), &text);
            let e = engine(2);
            for (name, kind) in &made {
                let want = Want { node: g.find(name).unwrap(), port: kind.outputs[0].name.clone(), grid: grid(&g, 17) };
                let all = e.evaluate(&g, &[want], &Unobserved, &Cancel::default()).unwrap();
                if let Err(failure) = &all.values[0] {
                    prop_assert!(!failure.to_string().contains("bug"), "{}", failure);
                    prop_assert!(!failure.to_string().contains("not finite"), "{}", failure);
                }
            }
        }
    }
}
