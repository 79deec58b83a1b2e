//! `orograph plan`: what a build would run.

use serde_json::json;

use super::args::{EngineArgs, GraphArgs, GridArgs};
use super::exit::{Exit, Stop, print, tell};
use super::open::{self, Opened};
use crate::engine::{Engine, Plan, Want, bytes};
use crate::graph::Graph;
use crate::nodes::Registry;
use crate::value::Grid;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// One output; all when left out
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
    /// Prints JSON
    #[arg(long)]
    json: bool,
}

/// The outputs of a graph with those names, or all.
pub(super) fn chosen(graph: &Graph, names: &[String]) -> Result<Vec<String>, Stop> {
    let all: Vec<&str> = graph.outputs().map(|(name, _)| name).collect();
    if let Some(unknown) = names.iter().find(|n| !all.contains(&n.as_str())) {
        let hint = crate::params::did_you_mean(unknown, all.iter().copied());
        return Err(Stop::usage(format!(
            "the graph has no output `{unknown}`; it has {}{hint}",
            all.join(", ")
        )));
    }
    if all.is_empty() {
        return Err(Stop::new(Exit::Graph, "the graph has no outputs; add some under \"outputs\""));
    }
    Ok(if names.is_empty() { all.into_iter().map(str::to_owned).collect() } else { names.to_vec() })
}

/// What an output wants on a grid; the problem when its source does not resolve.
pub(super) fn want(graph: &Graph, output: &str, grid: Grid) -> Result<Want, crate::graph::Problem> {
    let source = graph.output_source(output)?;
    Ok(Want { node: source.node, port: source.port, grid })
}

pub(super) fn run(args: &Args, registry: &Registry) -> Result<Exit, Stop> {
    let Opened { graph, files, .. } = open::open(&args.graph, registry)?;
    let (_, window) = args.grid.grids(graph.terrain())?;
    let names = chosen(&graph, &args.outputs)?;
    let wants: Result<Vec<_>, _> = names.iter().map(|n| want(&graph, n, window)).collect();
    let wants = wants.map_err(|e| Stop::new(Exit::Graph, e))?;
    let engine = Engine::new(&args.engine.options(), files)?;
    let plan = engine.plan(&graph, &wants);
    let text = if args.json { json_of(&plan, &names, &window) } else { table(&plan, &names, &window) };
    print(&text)?;
    for line in warnings(&plan, &names, &window) {
        tell(&format!("warning: {line}"));
    }
    engine.admit(&plan)?;
    Ok(Exit::Done)
}

/// What a person should know of a plan before it runs.
pub(super) fn warnings(plan: &Plan, names: &[String], window: &Grid) -> Vec<String> {
    let coarser = |(i, name): (usize, &String)| {
        let cell = plan.effective_cell(i)?;
        (cell > window.cell() * 1.000_001).then(|| {
            format!(
                "output `{name}` holds detail down to {cell:.4} m, the grid has cells of {:.4} m: a global node runs \
                 on the base grid; --base sharpens it",
                window.cell()
            )
        })
    };
    let narrow = plan.too_narrow().into_iter().map(|(node, width)| {
        let cell = 2.0 * plan.base_cell();
        format!(
            "node `{node}` makes features of {width:.4} m; two base cells are {cell:.4} m: --base sharpens it"
        )
    });
    names.iter().enumerate().filter_map(coarser).chain(narrow).collect()
}

fn table(plan: &Plan, names: &[String], window: &Grid) -> String {
    let mut rows =
        vec![["node", "kind", "stage", "grid", "detail m", "memory", "seconds", "cached"].map(String::from)];
    for t in plan.tasks() {
        rows.push([
            t.node,
            t.kind.to_owned(),
            t.stage.name().to_owned(),
            t.grid.map_or_else(|| "none".into(), |g| format!("{} x {}", g.cols, g.rows)),
            format!("{:.3}", t.effective_cell),
            bytes(t.output_bytes + t.cost.bytes),
            if t.cached.is_some() { String::from("-") } else { format!("{:.3}", t.cost.seconds) },
            t.cached.unwrap_or("no").to_owned(),
        ]);
    }
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..8).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let line: Vec<String> = row.iter().zip(&widths).map(|(cell, w)| format!("{cell:w$}")).collect();
        text += line.join("  ").trim_end();
        text.push('\n');
    }
    for (i, name) in names.iter().enumerate() {
        let detail =
            plan.effective_cell(i).map_or("cannot be made".into(), |c| format!("detail down to {c:.3} m"));
        text += &format!("output {name}: {} x {}, {detail}\n", window.cols, window.rows);
    }
    text += &format!("peak memory {}, {:.2} s on one core\n", bytes(plan.peak_bytes()), plan.seconds());
    text
}

fn json_of(plan: &Plan, names: &[String], window: &Grid) -> String {
    let tasks = plan.tasks().into_iter().map(|t| {
        json!({
            "node": t.node, "kind": t.kind, "stage": t.stage.name(), "cols": t.grid.map(|g| g.cols), "rows": t.grid.map(|g| g.rows),
            "cell": t.grid.map(|g| g.cell()), "effective_cell": t.effective_cell, "backend": "cpu",
            "bytes": t.output_bytes + t.cost.bytes, "seconds": t.cost.seconds, "cached": t.cached,
        })
    });
    let tasks: Vec<_> = tasks.collect();
    let outputs = names.iter().enumerate().map(|(i, name)| {
        json!({ "name": name, "cols": window.cols, "rows": window.rows, "effective_cell": plan.effective_cell(i) })
    });
    let outputs: Vec<_> = outputs.collect();
    let whole = json!({ "tasks": tasks, "outputs": outputs, "peak_bytes": plan.peak_bytes(), "seconds": plan.seconds() });
    format!("{whole:#}\n")
}
