//! The presets: faultless, the same at every size and in tiles, and built within their means.

use std::path::Path;

use orograph::engine::{Engine, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::{Grid, Value};

use crate::rig::bytes::bytes;
use crate::rig::graph::engine;
use crate::rig::{breadth, grid};

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
            preset_output(&engine(2), &g, output, grid(g.terrain(), 33));
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
        // Lines stand on no grid, and are drawn a cell wide at least.
        let is_compared = |name: &str| {
            let source = g.output_source(name).unwrap();
            let up = g.upstream(source.node);
            let is_drawn = up.iter().any(|id| g.node(*id).kind().is_some_and(|k| k.id == "draw_rivers"));
            g.wire_type(&source).unwrap().is_raster() && !is_drawn
        };
        // A bed is a cell and a half wide at least: a build below the base grid has other valleys.
        let has_beds = g.nodes().any(|id| g.node(id).kind().is_some_and(|k| k.id == "carve_rivers"));
        let from = if has_beds { g.terrain().base } else { 0 };
        for (output, _) in g.outputs().filter(|(name, _)| looked_at(name) && is_compared(name)) {
            let [coarse, middle, fine] =
                sizes.map(|size| preset_output(&e, &g, output, grid(g.terrain(), size)));
            for (a, b) in [(&coarse, &middle), (&middle, &fine), (&coarse, &fine)] {
                let off = off(a, b);
                let sizes = [a, b].map(|v| v.grid().unwrap().lattice.intervals + 1);
                if has_beds && base.is_some() && sizes[0] < from {
                    continue;
                }
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

/// The measure of law 3 itself, of heights; of every output with `OROGRAPH_BREADTH=1 cargo test --release own_sizes --
/// --nocapture`, which takes minutes.
#[test]
fn presets_show_the_same_terrain_at_their_own_sizes() {
    let full = breadth();
    // Beds of rivers are a cell and a half wide at least, so that they drain: a hundredth of the range and some more.
    let bad = differences(None, [513, 1025, 2049], 0.012, |name| full || name == "height");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn presets_in_tiles_are_cut_from_the_whole_bit_for_bit() {
    for (name, mut g) in presets() {
        g.assign("terrain.base", "129").unwrap();
        let whole_grid = grid(g.terrain(), 257);
        for (output, _) in g.outputs() {
            let whole = preset_output(&engine(2), &g, output, whole_grid);
            let tile = Grid { col: 64, row: 128, cols: 65, rows: 65, ..whole_grid };
            let alone = preset_output(&engine(2), &g, output, tile);
            assert!(bytes(&alone) == bytes(&whole.crop(&tile)), "{name}: {output}");
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
        let whole = grid(g.terrain(), 16_385);
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
