//! `orograph plan`: what a build would run.

use serde_json::json;

use super::args::{EngineArgs, GraphArgs, GridArgs};
use super::exit::{Exit, Stop, print_json, print_lines, tell};
use super::job::{Job, jobs, said_of};
use super::open::{self, Opened};
use super::progress::{Mode, Progress};
use super::reserve::reserve;
use super::tiles::{TileArgs, tiles};
use crate::engine::{Engine, Options, Plan, Want, bytes};
use crate::graph::{Graph, Problem};
use crate::node::Cancel;
use crate::nodes::Registry;
use crate::text::printable;
use crate::value::Grid;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    tiles: TileArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// One output; all when left out
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
    /// Prints JSON
    #[arg(long)]
    pub(super) json: bool,
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

/// The want of an output on a grid; fails when its source does not resolve.
pub(super) fn want(graph: &Graph, output: &str, grid: Grid) -> Result<Want, crate::graph::Problem> {
    let source = graph.output_source(output)?;
    Ok(Want { node: source.node, port: source.port, grid })
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    args.engine.refuse()?;
    let Opened { graph, files, problems, .. } = open::open(&args.graph, registry)?;
    let (whole, window) = args.grid.grids(graph.terrain())?;
    // Tiles need about the same; a build is admitted by its largest one.
    let tiles = tiles(&args.tiles, &window)?;
    let tile = tiles.iter().map(|t| t.grid).max_by_key(Grid::len).unwrap_or(window);
    let names = chosen(&graph, &args.outputs)?;
    let (jobs, broken) = jobs(&graph, &names, None, &problems);
    let wants: Vec<_> = jobs.iter().map(|j| j.want(tile)).collect();
    let reserve = reserve(&graph, &args.engine, Some(&tile));
    let engine = Engine::new(&Options { reserve, ..args.engine.options() }, files)?;
    let mut plan = engine.plan(&graph, &wants);
    let known = engine.know(&graph, &wants, &mut plan, &Progress::new(Some(Mode::None)), cancel);
    let refused = known.and_then(|()| engine.admit(&plan)).err();
    let made: Vec<String> = jobs.iter().map(|j| j.name.clone()).collect();
    let failures = failures(&plan, &made, broken);
    let need = engine.need(plan.peak_bytes());
    let writing = jobs.iter().map(|j| j.writing_seconds(&tile)).sum();
    let planned =
        Planned { plan: &plan, jobs: &jobs, window: &tile, reserve, need, writing, failures: &failures };
    if args.json {
        print_json(&json_of(&planned))?;
    } else {
        print_lines(table(&planned))?;
    }
    for line in warnings(&plan, &made, &whole) {
        tell(&format!("warning: {line}"));
    }
    for f in &failures {
        tell(&format!("error: output `{}`: {}", f.output, f.message));
    }
    match refused {
        Some(e) => Err(Stop { printed: true, ..e.into() }),
        None => Ok(failures.first().map_or(Exit::Done, |f| f.exit)),
    }
}

/// An output that will fail.
struct Failed {
    output: String,
    message: String,
    exit: Exit,
}

/// The outputs that will fail, in the order in which a build finds them.
fn failures(plan: &Plan, names: &[String], broken: Vec<(String, Problem)>) -> Vec<Failed> {
    let broken = broken.into_iter().map(|(output, problem)| {
        let message = said_of(problem);
        Failed { output, message, exit: Exit::Graph }
    });
    let planned = names.iter().zip(plan.failures()).filter_map(|(output, failure)| {
        let failure = failure?;
        Some(Failed { output: output.clone(), message: failure.to_string(), exit: Exit::of(&failure) })
    });
    broken.chain(planned).collect()
}

/// A plan with the data that is printed with it.
struct Planned<'a> {
    plan: &'a Plan,
    jobs: &'a [Job],
    window: &'a Grid,
    /// Bytes of the budget that are not for the evaluation.
    reserve: u64,
    /// Bytes that must fit the budget.
    need: u64,
    /// Estimated seconds of writing the outputs.
    writing: f64,
    failures: &'a [Failed],
}

/// The warnings about a plan.
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

fn table(planned: &Planned<'_>) -> Vec<String> {
    let &Planned { plan, jobs, window, reserve, need, writing, failures } = planned;
    let mut rows =
        vec![["node", "kind", "stage", "grid", "detail m", "memory", "seconds", "cached"].map(String::from)];
    for t in plan.tasks() {
        rows.push([
            printable(&t.node).into_owned(),
            t.kind.to_string(),
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
    let mut lines = Vec::new();
    for row in &rows {
        let line: Vec<String> = row.iter().zip(&widths).map(|(cell, w)| format!("{cell:w$}")).collect();
        lines.push(line.join("  ").trim_end().to_owned());
    }
    for (i, job) in jobs.iter().enumerate() {
        if let Some(cell) = plan.effective_cell(i) {
            let (name, what) = (&job.name, job.summary());
            lines.push(format!(
                "output {name}: {} x {}, {what}, detail down to {cell:.3} m",
                window.cols, window.rows
            ));
        }
    }
    for f in failures {
        lines.push(format!("output {}: cannot be made", f.output));
    }
    lines.push(format!(
        "memory {}: {} for nodes, {} that the allocator holds back, {} for the program and its writers; {:.2} s on one core, \
         {writing:.2} s of them for writing",
        bytes(need),
        bytes(plan.peak_bytes()),
        bytes(need.saturating_sub(plan.peak_bytes()).saturating_sub(reserve)),
        bytes(reserve),
        plan.seconds() + writing
    ));
    lines
}

fn json_of(planned: &Planned<'_>) -> serde_json::Value {
    let &Planned { plan, jobs, window, reserve, need, writing, failures } = planned;
    let tasks = plan.tasks().into_iter().map(|t| {
        json!({
            "node": t.node, "kind": t.kind.as_str(), "stage": t.stage.name(), "cols": t.grid.map(|g| g.cols), "rows": t.grid.map(|g| g.rows),
            "cell": t.grid.map(|g| g.cell()), "effective_cell": t.effective_cell, "backend": "cpu",
            "bytes": t.output_bytes + t.cost.bytes, "seconds": t.cost.seconds, "cached": t.cached,
        })
    });
    let tasks: Vec<_> = tasks.collect();
    let outputs = jobs.iter().enumerate().map(|(i, job)| job.planned(window, plan.effective_cell(i)));
    let outputs: Vec<_> = outputs.collect();
    let failed = |f: &Failed| json!({ "output": f.output, "error": f.message, "exit": f.exit.code() });
    json!({
        "tasks": tasks, "outputs": outputs, "failures": failures.iter().map(failed).collect::<Vec<_>>(),
        "peak_bytes": plan.peak_bytes(), "reserve_bytes": reserve,
        "need_bytes": need, "unread_bytes": plan.unread_bytes(),
        "seconds": plan.seconds() + writing, "writing_seconds": writing,
    })
}
