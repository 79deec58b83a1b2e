//! A node alone: run as the engine runs it, on inputs that a function gives.

use std::sync::Arc;

use orograph::graph::Graph;
use orograph::name::Name;
use orograph::node::{AnyNode, Cancel, Context, Error, Kind, Node, Reads, Summary};
use orograph::ports::{Ports, Wires};
use orograph::value::{Field, Grid, Terrain, Value};
use serde_json::Value as Json;

use super::sets::{Set, brief};

/// What lies on the wire of a port on a window; an input for which there is nothing is left open.
pub(crate) type Source<'a> = &'a (dyn Fn(&str, &Grid) -> Option<Value> + Sync);

/// A node to be run, and what its kind says of it.
pub(crate) struct Bench {
    pub node: Arc<dyn AnyNode>,
    /// Its inputs, without the mask that is the engine's to mix by.
    pub ports: Vec<Name>,
    pub label: String,
    reads: Reads,
}

/// All that a run needs.
pub(crate) struct Given {
    pub wires: Wires,
    pub views: Vec<(Name, Value)>,
    pub summary: Option<Summary>,
    at: Grid,
}

impl Bench {
    /// A node as it is written in Rust.
    pub(crate) fn of<N: Node>(node: &N) -> Self {
        let ports = N::In::PORTS.iter().map(|p| p.name.clone()).collect();
        Self { node: Arc::new(node.clone()), ports, label: format!("{node:?}"), reads: N::META.reads }
    }

    /// A node as a graph sets it.
    pub(crate) fn set(kind: &Kind, set: &Set) -> Result<Self, Error> {
        let own = |name: &&Name| kind.hands_over(name);
        let ports = kind.inputs.iter().map(|p| &p.name).filter(own).cloned().collect();
        let label = format!("{} {}", kind.id, Json::from(set.clone()));
        Ok(Self { node: kind.parse(&brief(kind, set))?, ports, label, reads: kind.reads })
    }

    /// The node of a graph of the rig, with all that the graph sets of it.
    pub(crate) fn in_graph(graph: &Graph, kind: &Kind) -> Result<Self, Error> {
        let node = graph.node(graph.find("node").expect("the rig's node")).parse()?;
        Ok(Self { node, ..Self::set(kind, &Set::new())? })
    }

    /// The same by the name of a shipped kind; parameters that it refuses are a fault of the test.
    pub(crate) fn named(id: &str, set: &Json) -> Self {
        let registry = orograph::nodes::Registry::standard();
        let kind = registry.find(id).unwrap_or_else(|| panic!("no kind `{id}`"));
        let object = set.as_object().expect("parameters are an object");
        Self::set(kind, object).unwrap_or_else(|e| panic!("{id} {set}: {e}"))
    }

    /// Inputs on windows.
    pub(crate) fn inputs(&self, source: Source<'_>, window: &dyn Fn(&str) -> Grid) -> Wires {
        let value = |p: &Name| Some((p.clone(), source(p, &window(p))?));
        self.ports.iter().filter(|p| self.node.uses(p)).filter_map(value).collect()
    }

    /// What a run on a window is given; `wider` makes windows of inputs larger than asked for.
    pub(crate) fn given(
        &self,
        terrain: &Terrain,
        at: Grid,
        source: Source<'_>,
        wider: &dyn Fn(Grid) -> Grid,
    ) -> Given {
        let clipped = |window: Grid| clipped(&wider(window), terrain);
        let wires = self.inputs(source, &|port| clipped(self.node.footprint(port, &at, terrain)));
        let seen = |p: &Name| {
            let windows = self.node.views(p, &at, terrain).into_iter().map(clipped);
            windows.filter_map(|window| Some((p.clone(), source(p, &window)?))).collect::<Vec<_>>()
        };
        let views = self.ports.iter().flat_map(seen).collect();
        Given { wires, views, summary: self.summary(terrain, source), at }
    }

    fn summary(&self, terrain: &Terrain, source: Source<'_>) -> Option<Summary> {
        let (cancel, base) = (Cancel::default(), terrain.base_grid());
        let cx = Context { reads: self.reads, ..Context::bare(base, terrain, &cancel) };
        let wires = || self.inputs(source, &|_| base);
        self.node.needs_summary().then(|| self.node.summarize(&cx, wires()).expect("a summary"))
    }

    pub(crate) fn start(&self, terrain: &Terrain, given: &Given, cancel: &Cancel) -> Result<Wires, Error> {
        let bare = Context::bare(given.at, terrain, cancel);
        let cx = Context { whole: given.summary.as_ref(), views: &given.views, reads: self.reads, ..bare };
        self.node.run(&cx, given.wires.clone())
    }

    /// Runs on a window, on inputs that are exactly what the node asks for.
    pub(crate) fn run(&self, terrain: &Terrain, at: Grid, source: Source<'_>) -> Result<Wires, Error> {
        let given = self.given(terrain, at, source, &|window| window);
        self.start(terrain, &given, &Cancel::default())
    }

    /// A field that comes of it.
    pub(crate) fn field(&self, terrain: &Terrain, at: Grid, source: Source<'_>, port: &str) -> Field {
        let mut out = self.run(terrain, at, source).unwrap_or_else(|e| panic!("{}: {e}", self.label));
        match out.take(port) {
            Some(Value::Field(field)) => field,
            other => panic!("{}: `{port}` is {other:?}", self.label),
        }
    }
}

/// A window cut to the apron as the engine cuts it, never to nothing.
pub(crate) fn clipped(window: &Grid, terrain: &Terrain) -> Grid {
    let apron = terrain.apron(window.lattice);
    let cut = |from: i64, end: i64, [lo, hi]: [i64; 2]| {
        let from = from.clamp(lo, hi - 1);
        [from, end.clamp(from + 1, hi)]
    };
    let [col, col_end] = cut(window.col, window.col_end(), [apron.col, apron.col_end()]);
    let [row, row_end] = cut(window.row, window.row_end(), [apron.row, apron.row_end()]);
    Grid::between(window.lattice, [col, row], [col_end, row_end])
}

/// A field with a huge value wherever a window does not reach.
pub(crate) fn poisoned(value: Value, keep: &Grid) -> Value {
    let Value::Field(field) = value else { return value };
    let grid = *field.grid();
    let inside = |i: usize| {
        let (col, row) = (grid.col + (i % grid.cols) as i64, grid.row + (i / grid.cols) as i64);
        (keep.col..keep.col_end()).contains(&col) && (keep.row..keep.row_end()).contains(&row)
    };
    let data = field.data().iter().enumerate().map(|(i, &v)| if inside(i) { v } else { 1e30 }).collect();
    Value::Field(Field::new(grid, field.quantity(), data))
}
