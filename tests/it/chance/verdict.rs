//! What every graph owes, whatever it is: finite values or a clear refusal, the same bits in tiles, on any number of
//! threads and asked again, and no more memory than was planned, by account.
//!
//! The tests and the fuzz target `evaluate` share this file.

use std::collections::BTreeMap;

use orograph::engine::{Engine, EngineError, Evaluation, Failure, Files, Keep, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Error};
use orograph::value::{Grid, Value};

/// What a graph by chance may take; what is over it is refused, which is right.
const MEMORY: u64 = 256 << 20;
const SECONDS: f64 = 0.2;

/// How a graph ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// Values that were made.
    pub(super) made: usize,
    /// Values that were refused, by name.
    pub(super) refused: usize,
}

/// Evaluates all outputs of all nodes on the base grid and on a finer one.
///
/// # Panics
/// When the graph breaks a promise.
pub(super) fn judge(graph: &Graph) -> Tally {
    let again = Graph::from_bytes(&graph.to_bytes(), graph.registry()).expect("what is saved can be opened");
    let mut tally = Tally::default();
    let base = graph.terrain().base;
    for size in [base, 2 * base - 1] {
        let Ok(grid) = graph.terrain().grid(size) else { continue };
        let wants = wants(graph, grid);
        let engine = engine(1, Keep::Nothing);
        let Some(whole) = evaluate(&engine, graph, &wants) else { continue };
        let (account, planned) = (whole.peak_bytes, whole.planned_bytes);
        assert!(account <= planned, "{account} bytes by account, {planned} planned");
        let values = values(&wants, &whole, &mut tally);
        // Its nodes are others, with the same names in the same order.
        let renewed = self::wants(&again, grid);
        same(&values, &self::engine(3, Keep::Nothing), &again, &renewed, "on three threads");
        let keeps = self::engine(2, Keep::Everything);
        same(&values, &keeps, graph, &wants, "by an engine that keeps results");
        same(&values, &keeps, graph, &wants, "of results that were kept");
        tiles(&values, graph, grid);
    }
    tally
}

fn engine(threads: usize, keep: Keep) -> Engine {
    let options = Options { threads, keep, memory: MEMORY, seconds: SECONDS, ..Options::default() };
    Engine::new(&options, Files::default()).expect("threads start")
}

fn wants(graph: &Graph, grid: Grid) -> Vec<Want> {
    let outputs = |node| graph.node(node).kind().map_or(&[][..], |k| &k.outputs);
    let all = graph.nodes().flat_map(|node| outputs(node).iter().map(move |p| (node, p.name.clone())));
    all.map(|(node, port)| Want { node, port, grid }).collect()
}

/// Nothing where the whole is over a budget.
fn evaluate(engine: &Engine, graph: &Graph, wants: &[Want]) -> Option<Evaluation> {
    match engine.evaluate(graph, wants, &Unobserved, &Cancel::default()) {
        Ok(all) => Some(all),
        Err(EngineError::Memory { .. } | EngineError::Time { .. }) => None,
        Err(other) => panic!("{other}"),
    }
}

/// What was made, by its place among the wants: another graph has other ids for the same nodes.
type Values = BTreeMap<usize, Value>;

fn values(wants: &[Want], all: &Evaluation, tally: &mut Tally) -> Values {
    let mut values = Values::new();
    for (place, (want, value)) in wants.iter().zip(&all.values).enumerate() {
        match value {
            Ok(value) => {
                let bits = bits(value);
                let raster = value.grid().is_some();
                let finite = !raster || bits.iter().all(|&b| f32::from_bits(b).is_finite());
                assert!(finite, "{:?}.{} is not finite", want.node, want.port);
                values.insert(place, value.clone());
                tally.made += 1;
            }
            Err(failure) => {
                assert!(is_clear(failure), "{failure}");
                tally.refused += 1;
            }
        }
    }
    values
}

/// Whether a failure is the graph's own: of its wires, parameters and files, or numbers that grow beyond f32.
fn is_clear(failure: &Failure) -> bool {
    match failure {
        Failure::Document { .. } | Failure::Graph(_) | Failure::File { .. } => true,
        Failure::Run { error, .. } => {
            matches!(error, Error::Parameter { .. } | Error::Input { .. } | Error::NotFinite { .. })
        }
        Failure::Cancelled | Failure::Cache(_) | Failure::Engine(_) => false,
    }
}

fn same(values: &Values, engine: &Engine, graph: &Graph, wants: &[Want], how: &str) {
    let Some(again) = evaluate(engine, graph, wants) else { return };
    let again = self::values(wants, &again, &mut Tally::default());
    assert_eq!(values.len(), again.len(), "{how}");
    for (place, value) in values {
        let Want { node, port, .. } = &wants[*place];
        let made = again.get(place).is_some_and(|again| bits(value) == bits(again));
        assert!(made, "`{}.{port}` {how}", graph.node(*node).name);
    }
}

/// A tile in the middle and one in the corner, each by itself.
fn tiles(values: &Values, graph: &Graph, grid: Grid) {
    let (cols, rows) = (grid.cols.div_ceil(3), grid.rows.div_ceil(2));
    let corner = [(grid.cols - cols) as i64, (grid.rows - rows) as i64];
    for [col, row] in [[1, 2], corner] {
        let tile = Grid { col, row, cols, rows, ..grid };
        if !grid.contains(&tile) {
            continue;
        }
        let wants = wants(graph, tile);
        let Some(all) = evaluate(&engine(2, Keep::Nothing), graph, &wants) else { continue };
        for (place, (want, value)) in wants.iter().zip(&all.values).enumerate() {
            let Some(whole) = values.get(&place) else { continue };
            let value = value.as_ref().expect("what the whole can do a tile can");
            let cut = if whole.grid().is_some() { whole.crop(&tile) } else { whole.clone() };
            assert!(bits(value) == bits(&cut), "{:?}.{} at {tile:?}", want.node, want.port);
        }
    }
}

/// The samples of a raster to the bit; what else a value holds as its text.
fn bits(value: &Value) -> Vec<u32> {
    match value {
        Value::Object(object) => format!("{object:?}").bytes().map(u32::from).collect(),
        raster => raster.components().iter().map(|x| x.to_bits()).collect(),
    }
}
