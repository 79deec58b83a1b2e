//! The engine: laws 2 to 9 and 12, with test kinds of every reach and lying ones.

use std::path::Path;
use std::sync::Mutex;

use orograph::engine::{Engine, EngineError, Evaluation, Files, Observer, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::{Field, Grid, Terrain, Value};
use serde_json::json;

use crate::kinds::registry;

pub(crate) fn graph(nodes: serde_json::Value) -> Graph {
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 2048, "base": 129, "seed": 3 },
        "nodes": nodes,
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).expect("a graph")
}

/// A chain through every reach: point, local, a global change, a mask, a statistic of the whole.
pub(crate) fn chain() -> Graph {
    graph(json!({
        "hills": { "kind": "waves", "set": { "height": 200, "seed": 7 } },
        "detail": { "kind": "waves", "set": { "height": 9, "length": 61, "seed": 8 } },
        "rough": { "kind": "sum", "in": { "a": "hills.field", "b": "detail.field" } },
        "soft": { "kind": "smooth", "in": { "field": "rough.field" } },
        "where": { "kind": "stretch", "in": { "field": "hills.field" } },
        "dug": { "kind": "dig", "in": { "field": "soft.field", "mask": "where.field" } },
        "spread": { "kind": "spread", "in": { "field": "dug.field" } },
        "end": { "kind": "sum", "in": { "a": "dug.field", "b": "spread.field", "mask": "where.field" } },
    }))
}

pub(crate) fn engine(threads: usize) -> Engine {
    Engine::new(&Options { threads, ..Options::default() }, Files::default()).expect("an engine")
}

pub(crate) fn want(graph: &Graph, node: &str, grid: Grid) -> Want {
    Want { node: graph.find(node).expect("the node"), port: "field".into(), grid }
}

pub(crate) fn evaluate(engine: &Engine, graph: &Graph, node: &str, grid: Grid) -> Evaluation {
    engine
        .evaluate(graph, &[want(graph, node, grid)], &Unobserved, &Cancel::default())
        .expect("an evaluation")
}

pub(crate) fn field(evaluation: &Evaluation, i: usize) -> Field {
    match &evaluation.values[i] {
        Ok(Value::Field(f)) => f.clone(),
        other => panic!("a field, not {other:?}"),
    }
}

fn bits(field: &Field) -> Vec<u32> {
    field.data().iter().map(|x| x.to_bits()).collect()
}

/// The nodes that ran, without those from the cache.
fn ran(evaluation: &Evaluation) -> Vec<&str> {
    let mut names: Vec<_> =
        evaluation.tasks.iter().filter(|t| t.cached.is_none()).map(|t| t.node.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn grid(graph: &Graph, size: u32) -> Grid {
    graph.terrain().grid(size).expect("a size that fits")
}

#[test]
fn what_is_left_out_does_not_run_and_changes_no_key() {
    let (mut g, e) = (chain(), engine(2));
    let whole = grid(&g, 129);
    let rough = field(&evaluate(&e, &g, "rough", whole), 0);
    let soft = g.find("soft").unwrap();
    g.set_bypass(soft, true).unwrap();
    let passed = evaluate(&e, &g, "soft", whole);
    assert_eq!(bits(&field(&passed, 0)), bits(&rough));
    assert_eq!(ran(&passed), [""; 0], "what passes is in the cache already");
    let dug = g.find("dug").unwrap();
    let left_out = e.key(&g, dug);
    g.remove_bridged(soft).unwrap();
    assert_eq!(e.key(&g, dug), left_out, "as if it were not there");
    let hills = g.find("hills").unwrap();
    assert!(g.set_bypass(hills, true).is_err());
}

#[test]
fn runs_only_what_is_asked_for_and_only_once() {
    let (g, e) = (chain(), engine(2));
    let soft = evaluate(&e, &g, "soft", grid(&g, 129));
    assert_eq!(ran(&soft), ["detail", "hills", "rough", "soft"]);
    assert_eq!(soft.tasks.len(), 4, "each ran once: {:?}", soft.tasks);
    let again = evaluate(&e, &g, "soft", grid(&g, 129));
    assert_eq!(ran(&again), [""; 0]);
    assert_eq!(again.tasks.len(), 1, "what is cached asks for nothing");
    assert_eq!(field(&soft, 0), field(&again, 0));
}

#[test]
fn a_change_runs_only_what_lies_downstream_of_it() {
    let (mut g, e) = (chain(), engine(2));
    evaluate(&e, &g, "end", grid(&g, 129));
    g.assign("dug.depth", "20").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), ["dug", "end", "spread"]);
    g.assign("dug.depth", "50").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), [""; 0], "the old value is still there");
    let hills = g.find("hills").unwrap();
    g.rename(hills, "mountains").unwrap();
    g.move_to(hills, [500.0, -20.0]).unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), [""; 0], "names and places are in no key");
    g.assign("terrain.sea_level", "12").unwrap();
    // `dug` declares that it reads the terrain; nothing else does.
    assert_eq!(ran(&evaluate(&e, &g, "end", grid(&g, 129))), ["dug", "end", "spread"]);
    g.assign("terrain.seed", "4").unwrap();
    assert_eq!(ran(&evaluate(&e, &g, "soft", grid(&g, 129))), ["detail", "mountains", "rough", "soft"]);
}

#[test]
fn parameters_count_by_value_not_by_text() {
    let e = engine(1);
    let make = |set: &str| {
        let text = format!(r#"{{"orograph":1,"nodes":{{"a":{{"kind":"waves","set":{set}}}}}}}"#);
        let g = Graph::from_bytes(text.as_bytes(), &registry()).unwrap();
        e.key(&g, g.find("a").unwrap()).unwrap()
    };
    let plain = make(r#"{"height":0,"length":700}"#);
    for same in
        [r#"{"length":700.0,"height":0.0}"#, r#"{"height":-0.0}"#, r#"{"height":0e5,"length":7e2,"seed":1}"#]
    {
        assert_eq!(make(same), plain, "{same}");
    }
    assert_ne!(make(r#"{"height":1e-9}"#), plain);
}

#[test]
fn tiles_are_cut_from_the_whole_bit_for_bit() {
    let g = chain();
    for size in [65, 129, 257, 513] {
        let whole_grid = grid(&g, size);
        let whole = field(&evaluate(&engine(2), &g, "end", whole_grid), 0);
        let steps = [(whole_grid.cols - 1) / 4, (whole_grid.rows - 1) / 2];
        for (i, j) in [(0, 0), (3, 1), (1, 0), (2, 1)] {
            let tile = Grid {
                col: (i * steps[0]) as i64,
                row: (j * steps[1]) as i64,
                cols: steps[0] + 1,
                rows: steps[1] + 1,
                ..whole_grid
            };
            let alone = field(&evaluate(&engine(2), &g, "end", tile), 0);
            assert_eq!(bits(&alone), bits(&whole.crop(&tile)), "tile {i},{j} of {size}");
        }
    }
}

#[test]
fn the_tile_law_catches_a_kind_that_looks_further_than_it_says() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "peek": { "kind": "peeks", "in": { "field": "hills.field" } },
    }));
    let whole_grid = grid(&g, 129);
    let whole = field(&evaluate(&engine(1), &g, "peek", whole_grid), 0);
    let tile = Grid { col: 32, cols: 33, rows: 33, ..whole_grid };
    let alone = field(&evaluate(&engine(1), &g, "peek", tile), 0);
    assert_ne!(bits(&alone), bits(&whole.crop(&tile)));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let g = chain();
    let of = |threads| bits(&field(&evaluate(&engine(threads), &g, "end", grid(&g, 257)), 0));
    let one = of(1);
    assert_eq!(one, of(2));
    assert_eq!(one, of(7));
}

#[test]
fn point_nodes_are_equal_to_the_bit_at_every_size() {
    let g = chain();
    let coarse = field(&evaluate(&engine(2), &g, "rough", grid(&g, 43)), 0);
    for factor in [2, 3, 5] {
        let fine = field(&evaluate(&engine(2), &g, "rough", grid(&g, 42 * factor + 1)), 0);
        for j in 0..coarse.grid().rows {
            for i in 0..coarse.grid().cols {
                let f = i64::from(factor);
                assert_eq!(coarse.at(i as i64, j as i64), fine.at(i as i64 * f, j as i64 * f));
            }
        }
    }
}

#[test]
fn a_global_change_is_carried_and_leaves_the_rest_bit_for_bit() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "detail": { "kind": "waves", "set": { "height": 5, "length": 40 } },
        "rough": { "kind": "sum", "in": { "a": "hills.field", "b": "detail.field" } },
        "dug": { "kind": "dig", "in": { "field": "rough.field" } },
    }));
    let fine = grid(&g, 1025);
    let e = engine(2);
    let before = field(&evaluate(&e, &g, "rough", fine), 0);
    let after = field(&evaluate(&e, &g, "dug", fine), 0);
    let mut unchanged = 0;
    for j in 0..fine.rows {
        for i in 0..fine.cols {
            let (x, a, b) = (fine.x(i), before.row(j)[i], after.row(j)[i]);
            let wanted = if x < 2048.0 { -50.0 * (1.0 - x / 2048.0) } else { 0.0 };
            // Linear where it acts, with a kink in the middle of the terrain: the spline rounds only that.
            let near = (x - 2048.0).abs() < 4.0 * 32.0;
            assert!((f64::from(b - a) - wanted).abs() < if near { 0.5 } else { 2e-3 }, "at {x}: {a} to {b}");
            if x > 2048.0 + 2.0 * 32.0 {
                assert_eq!(a.to_bits(), b.to_bits());
                unchanged += 1;
            }
        }
    }
    assert!(unchanged > 200_000);
    let base = field(&evaluate(&e, &g, "dug", grid(&g, 129)), 0);
    let direct = field(&evaluate(&e, &g, "rough", grid(&g, 129)), 0);
    assert_eq!(base.at(100, 20), direct.at(100, 20));
    assert_eq!(base.at(0, 20), direct.at(0, 20) - 50.0);
}

#[test]
fn sizes_agree_within_a_share_of_the_relief() {
    let g = chain();
    let e = engine(2);
    let at = |size| field(&evaluate(&e, &g, "end", grid(&g, size)), 0);
    let base = at(129);
    let (lo, hi) = base.range().unwrap();
    for (size, factor) in [(257, 2), (513, 4)] {
        let fine = at(size);
        let mut errors: Vec<f32> = Vec::new();
        for j in 0..base.grid().rows as i64 {
            for i in 0..base.grid().cols as i64 {
                errors.push((base.at(i, j) - fine.at(i * factor, j * factor)).abs());
            }
        }
        errors.sort_by(f32::total_cmp);
        let worst = errors[errors.len() * 99 / 100];
        assert!(worst <= 0.01 * (hi - lo), "{size}: {worst} of {}", hi - lo);
    }
}

#[test]
fn a_mask_selects_exactly_at_its_ends() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "zero": { "kind": "constant", "set": { "value": 0 } },
        "one": { "kind": "constant", "set": { "value": 1 } },
        "half": { "kind": "constant", "set": { "value": 0.5 } },
        "plain": { "kind": "smooth", "in": { "field": "hills.field" } },
        "none": { "kind": "smooth", "in": { "field": "hills.field", "mask": "zero.field" } },
        "all": { "kind": "smooth", "in": { "field": "hills.field", "mask": "one.field" } },
        "some": { "kind": "smooth", "in": { "field": "hills.field", "mask": "half.field" } },
    }));
    let e = engine(2);
    let of = |node| field(&evaluate(&e, &g, node, grid(&g, 65)), 0);
    assert_eq!(bits(&of("none")), bits(&of("hills")));
    assert_eq!(bits(&of("all")), bits(&of("plain")));
    let (a, b, m) = (of("hills").at(9, 9), of("plain").at(9, 9), of("some").at(9, 9));
    assert!((m - (a + b) / 2.0).abs() < 1e-4);
}

#[test]
fn a_failure_stops_only_what_needs_it_and_names_the_node() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "bad": { "kind": "not_a_number" },
        "mixed": { "kind": "sum", "in": { "a": "hills.field", "b": "bad.field" } },
        "loose": { "kind": "sum", "in": { "a": "hills.field" } },
        "strange": { "kind": "erode_by_magic" },
        "over": { "kind": "copy", "in": { "field": "strange.field" } },
        "panics": { "kind": "panics" },
        "secret": { "kind": "secret_seed" },
        "wrong": { "kind": "wrong_grid" },
        "other": { "kind": "wrong_quantity" },
        "steep": { "kind": "waves", "set": { "height": 1e99 } },
    }));
    let names = ["hills", "bad", "mixed", "loose", "over", "panics", "secret", "wrong", "steep", "other"];
    let wants: Vec<_> = names.iter().map(|n| want(&g, n, grid(&g, 65))).collect();
    let all = engine(2).evaluate(&g, &wants, &Unobserved, &Cancel::default()).unwrap();
    assert!(all.values[0].is_ok(), "what does not need them is made");
    let says = |i: usize, words: &str| {
        let message = all.values[i].as_ref().unwrap_err().to_string();
        assert!(message.contains(words), "{}: {message}", names[i]);
    };
    says(1, "node `bad`: output `field` is not finite at column 0, row 3");
    says(2, "node `bad`");
    says(9, "output `field` is slope, and the kind says number");
    says(3, "node `loose`: input `b` is not connected");
    says(4, "erode_by_magic");
    says(5, "node `panics`: stopped by a bug of its kind: the kind has a bug");
    says(6, "node `secret`: the kind asks for `SEED` and does not declare it");
    says(7, "node `wrong`: output `field` stands on");
    says(8, "node `steep`: parameter `height` must be a number from");
}

#[test]
fn over_a_budget_nothing_starts() {
    let g = chain();
    let options = Options { memory: 1 << 20, threads: 1, ..Options::default() };
    let e = Engine::new(&options, Files::default()).unwrap();
    let wants = [want(&g, "end", grid(&g, 2049))];
    match e.evaluate(&g, &wants, &Unobserved, &Cancel::default()) {
        Err(EngineError::Memory { need, budget, at, .. }) => {
            assert!(need > 30 << 20 && budget == 1 << 20, "{need}");
            assert!(at.starts_with("node `"), "{at}");
        }
        other => panic!("refused, not {other:?}"),
    }
    let options = Options { seconds: 1e-6, threads: 1, ..Options::default() };
    let e = Engine::new(&options, Files::default()).unwrap();
    let refused = e.evaluate(&g, &wants, &Unobserved, &Cancel::default());
    assert!(matches!(refused, Err(EngineError::Time { .. })));
}

#[test]
fn a_tight_budget_gives_the_same_bits_within_it() {
    let g = chain();
    let wide = evaluate(&engine(2), &g, "end", grid(&g, 513));
    let options = Options { memory: wide.planned_bytes / 10 * 11 + 10, threads: 2, ..Options::default() };
    let tight = Engine::new(&options, Files::default()).unwrap();
    let narrow = evaluate(&tight, &g, "end", grid(&g, 513));
    assert_eq!(bits(&field(&wide, 0)), bits(&field(&narrow, 0)));
    assert!(narrow.peak_bytes <= options.memory, "{} of {}", narrow.peak_bytes, options.memory);
    assert!(tight.cached_bytes() <= options.memory);
}

/// Cancels at the first sign of work.
struct Stop<'a>(&'a Cancel, Mutex<usize>);

impl Observer for Stop<'_> {
    fn started(&self, _: usize) {
        *self.1.lock().unwrap() += 1;
        self.0.cancel();
    }
}

#[test]
fn the_plan_names_features_that_the_base_grid_cannot_hold() {
    let too_narrow = |metres: f64| {
        let g = graph(json!({
            "hills": { "kind": "waves" },
            "dug": { "kind": "dig", "set": { "narrowest": metres }, "in": { "field": "hills.field" } },
        }));
        let plan = engine(1).plan(&g, &[want(&g, "dug", grid(&g, 33))]);
        plan.too_narrow().into_iter().map(|(node, width)| (node.to_owned(), width)).collect::<Vec<_>>()
    };
    // Cells of the base grid are 32 m.
    assert_eq!(too_narrow(63.0), [("dug".to_owned(), 63.0)]);
    assert_eq!(too_narrow(64.0), []);
}

#[test]
fn cancelling_stops_inside_a_node_and_the_engine_goes_on_after() {
    let g =
        graph(json!({ "slow": { "kind": "slow", "set": { "seconds": 60 } }, "hills": { "kind": "waves" } }));
    let e = engine(1);
    let cancel = Cancel::default();
    let stop = Stop(&cancel, Mutex::new(0));
    let start = std::time::Instant::now();
    let ended = e.evaluate(&g, &[want(&g, "slow", grid(&g, 65))], &stop, &cancel);
    assert!(matches!(ended, Err(EngineError::Cancelled)));
    assert!(start.elapsed().as_secs() < 30);
    assert_eq!(*stop.1.lock().unwrap(), 1);
    assert!(evaluate(&e, &g, "hills", grid(&g, 65)).values[0].is_ok());
}

fn with_cache(folder: &Path) -> Engine {
    let options = Options { threads: 2, cache: Some(folder.to_owned()), ..Options::default() };
    Engine::new(&options, Files::default()).unwrap()
}

fn cache_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    files
}

#[test]
fn a_cache_folder_starts_the_next_process_warm() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let cold = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 257));
    let warm = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 257));
    assert_eq!(ran(&warm), [""; 0]);
    assert_eq!(warm.tasks[0].cached, Some("disk"));
    assert_eq!(bits(&field(&cold, 0)), bits(&field(&warm, 0)));
}

#[test]
fn a_cache_folder_serves_windows_that_are_part_of_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    // Both read `hills`, one of them further around: what `hills` is asked for hangs on which of them runs.
    let wide_and_near = |radius: f64| {
        graph(json!({
            "hills": { "kind": "waves", "set": { "height": 200, "seed": 7 } },
            "wide": { "kind": "smooth", "set": { "radius": 400 }, "in": { "field": "hills.field" } },
            "near": { "kind": "smooth", "set": { "radius": radius }, "in": { "field": "hills.field" } },
            "end": { "kind": "sum", "in": { "a": "wide.field", "b": "near.field" } },
        }))
    };
    let first = wide_and_near(100.0);
    let window = Grid { col: 20, row: 10, cols: 33, rows: 33, ..grid(&first, 129) };
    evaluate(&with_cache(folder.path()), &first, "end", window);
    let second = wide_and_near(150.0);
    let warm = evaluate(&with_cache(folder.path()), &second, "end", window);
    assert_eq!(ran(&warm), ["end", "near"]);
    let cold = evaluate(&engine(2), &second, "end", window);
    assert_eq!(bits(&field(&warm, 0)), bits(&field(&cold, 0)));
}

#[test]
fn damaged_entries_are_noticed_and_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let cold = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    for (i, path) in cache_files(folder.path()).into_iter().enumerate() {
        let mut bytes = std::fs::read(&path).unwrap();
        match i % 4 {
            0 => bytes.truncate(bytes.len() / 2),
            1 => bytes.clear(),
            2 => *bytes.last_mut().unwrap() ^= 1,
            _ => {
                let middle = bytes.len() / 2;
                bytes[middle] ^= 0x40;
            }
        }
        std::fs::write(&path, bytes).unwrap();
    }
    let again = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    assert_eq!(bits(&field(&cold, 0)), bits(&field(&again, 0)));
    assert!(ran(&again).contains(&"end"));
    let warm = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    assert_eq!(ran(&warm), [""; 0], "the folder is whole again");
}

#[test]
fn many_engines_share_a_cache_folder() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let alone = bits(&field(&evaluate(&engine(1), &g, "end", grid(&g, 129)), 0));
    std::thread::scope(|scope| {
        let run = || {
            (0..5)
                .map(|_| bits(&field(&evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129)), 0)))
                .collect::<Vec<_>>()
        };
        let all: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        for one in all.into_iter().flat_map(|t| t.join().unwrap()) {
            assert_eq!(one, alone);
        }
    });
    let left = cache_files(folder.path());
    assert!(left.iter().all(|p| !p.file_name().unwrap().to_string_lossy().starts_with(".tmp")), "{left:?}");
}

#[test]
fn a_deep_chain_and_a_wide_fan_evaluate() {
    let mut nodes = serde_json::Map::new();
    nodes.insert("n0".into(), json!({ "kind": "waves" }));
    for i in 1..1000 {
        nodes.insert(
            format!("n{i}"),
            json!({ "kind": "copy", "in": { "field": format!("n{}.field", i - 1) } }),
        );
    }
    let g = graph(nodes.into());
    let deep = evaluate(&engine(2), &g, "n999", grid(&g, 17));
    assert_eq!(deep.tasks.len(), 1000);
    assert!(deep.values[0].is_ok());
}

#[test]
fn a_window_outside_the_apron_continues_the_border() {
    let terrain = Terrain { width: 1000.0, depth: 500.0, base: 101, ..Terrain::default() };
    let apron = terrain.apron(terrain.base_grid().lattice);
    assert_eq!((apron.col, apron.row, apron.cols, apron.rows), (-50, -50, 201, 151));
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "wide": { "kind": "smooth", "set": { "radius": 100_000 }, "in": { "field": "hills.field" } },
    }));
    let e = engine(1);
    let whole = evaluate(&e, &g, "wide", grid(&g, 65));
    assert!(
        whole.planned_bytes < 4 << 20,
        "the apron bounds what a wide filter asks for: {}",
        whole.planned_bytes
    );
    let tile = Grid { col: 16, cols: 17, rows: 17, ..grid(&g, 65) };
    let alone = field(&evaluate(&engine(1), &g, "wide", tile), 0);
    assert_eq!(bits(&alone), bits(&field(&whole, 0).crop(&tile)));
}

mod files {
    //! What a graph may read (law 10).

    use super::*;

    fn reads(folder: &Path, name: &str) -> Result<f32, String> {
        let mut files = Files::default();
        files.allow_folder(folder).unwrap();
        let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
        read_with(&e, name)
    }

    fn read_with(e: &Engine, name: &str) -> Result<f32, String> {
        let g = graph(json!({ "file": { "kind": "bytes", "set": { "file": name } } }));
        let evaluation = evaluate(e, &g, "file", grid(&g, 5));
        match &evaluation.values[0] {
            Ok(Value::Field(f)) => Ok(f.at(0, 0)),
            Ok(other) => panic!("a field, not {other:?}"),
            Err(failure) => Err(failure.to_string()),
        }
    }

    #[test]
    fn stay_below_the_folder() {
        let top = tempfile::tempdir().unwrap();
        let folder = top.path().join("graphs");
        std::fs::create_dir_all(folder.join("data")).unwrap();
        std::fs::write(top.path().join("secret"), "1234567").unwrap();
        std::fs::write(folder.join("data/a.bin"), "123").unwrap();
        assert_eq!(reads(&folder, "data/a.bin"), Ok(3.0));
        assert_eq!(reads(&folder, "./data/a.bin"), Ok(3.0));
        let secret = top.path().join("secret").to_string_lossy().into_owned();
        for name in ["../secret", "data/../../secret", "../../../../../etc/passwd", "/etc/passwd", &secret] {
            let refused = reads(&folder, name).unwrap_err();
            assert!(refused.contains("node `file`") && refused.contains("refused"), "{name}: {refused}");
        }
        assert!(reads(&folder, "data").unwrap_err().contains("not a regular file"));
        assert!(reads(&folder, "CON").unwrap_err().contains("device"));
        assert!(reads(&folder, "data/nul.tif").unwrap_err().contains("device"));
        assert!(reads(&folder, "missing.tif").unwrap_err().contains("no such file"));
    }

    #[cfg(unix)]
    #[test]
    fn follow_no_link_out_and_wait_for_no_pipe() {
        let top = tempfile::tempdir().unwrap();
        let folder = top.path().join("graphs");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(top.path().join("secret"), "1234567").unwrap();
        std::fs::write(folder.join("inside"), "12").unwrap();
        std::os::unix::fs::symlink("../secret", folder.join("out")).unwrap();
        std::os::unix::fs::symlink("/etc/passwd", folder.join("far")).unwrap();
        std::os::unix::fs::symlink("inside", folder.join("in")).unwrap();
        assert_eq!(reads(&folder, "in"), Ok(2.0));
        for name in ["out", "far"] {
            assert!(reads(&folder, name).is_err(), "{name}");
        }
        let made = std::process::Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap();
        assert!(made.success());
        assert!(reads(&folder, "pipe").unwrap_err().contains("not a regular file"));
        assert!(reads(&folder, "/dev/zero").is_err());
    }

    #[test]
    fn are_read_again_when_they_change_and_only_then() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.bin"), "123").unwrap();
        let mut files = Files::default();
        files.allow_folder(folder.path()).unwrap();
        let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
        assert_eq!(read_with(&e, "a.bin"), Ok(3.0));
        std::fs::write(folder.path().join("a.bin"), "12345").unwrap();
        assert_eq!(read_with(&e, "a.bin"), Ok(5.0));
        // The content and the last part of the name count, not the folder.
        std::fs::create_dir(folder.path().join("else")).unwrap();
        std::fs::copy(folder.path().join("a.bin"), folder.path().join("else/a.bin")).unwrap();
        let g = graph(json!({ "file": { "kind": "bytes", "set": { "file": "else/a.bin" } } }));
        assert_eq!(ran(&evaluate(&e, &g, "file", grid(&g, 5))), [""; 0]);
    }

    #[test]
    fn named_by_the_user_may_lie_anywhere() {
        let top = tempfile::tempdir().unwrap();
        let path = top.path().join("dem.bin");
        std::fs::write(&path, "1234").unwrap();
        let mut files = Files::default();
        files.allow_file(&path);
        let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
        assert_eq!(read_with(&e, &path.to_string_lossy()), Ok(4.0));
        assert!(read_with(&e, &top.path().join("other.bin").to_string_lossy()).is_err());
    }
}

#[test]
fn what_a_node_does_not_use_is_neither_run_nor_in_its_key() {
    let mut g = graph(json!({
        "hills": { "kind": "waves" },
        "bad": { "kind": "not_a_number" },
        "either": { "kind": "switch", "in": { "a": "hills.field", "b": "bad.field" } },
    }));
    let e = engine(1);
    let taken = evaluate(&e, &g, "either", grid(&g, 65));
    assert_eq!(ran(&taken), ["either", "hills"]);
    let key = e.key(&g, g.find("either").unwrap());
    let (either, other) = (g.find("either").unwrap(), g.find("hills").unwrap());
    g.connect(other, "field", either, "b").unwrap();
    assert_eq!(e.key(&g, either), key);
    g.assign("either.choice", "1").unwrap();
    assert_ne!(e.key(&g, either), key);
}

/// A result says the same whether it was computed or is in memory, for any number of threads; what was warned of is
/// never found on disk.
#[test]
fn warnings_stay_with_a_result() {
    let g = graph(json!({ "a": { "kind": "grumbles" } }));
    let folder = tempfile::tempdir().expect("a folder");
    let grid = g.terrain().grid(65).expect("a grid");
    let run = |e: &Engine| {
        let want = Want { node: g.find("a").expect("a node"), port: "field".into(), grid };
        let all = e.evaluate(&g, &[want], &Unobserved, &Cancel::default()).expect("an evaluation");
        all.tasks.into_iter().map(|t| (t.cached, t.warnings)).collect::<Vec<_>>()
    };
    let said = vec!["row 0".to_owned(), "row 1".to_owned(), "row 2".to_owned()];
    for threads in [1, 3] {
        let cache = Some(folder.path().to_owned());
        let e = Engine::new(&Options { threads, cache, ..Options::default() }, Files::default());
        let e = e.expect("an engine");
        assert_eq!(run(&e), [(None, said.clone())]);
        assert_eq!(run(&e), [(Some("memory"), said.clone())]);
    }
}
