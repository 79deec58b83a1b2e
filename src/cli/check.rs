//! `orograph check` and `orograph fmt`.

use std::path::PathBuf;

use super::args::GraphArgs;
use super::exit::{Exit, Stop, print, save};
use super::open;
use crate::graph::Problem;
use crate::nodes::Registry;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    /// Warnings count as errors
    #[arg(long)]
    strict: bool,
    /// Prints the problems as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct FmtArgs {
    /// The .graph files
    #[arg(required = true)]
    graphs: Vec<PathBuf>,
    /// Writes nothing; fails when a file is not in canonical form
    #[arg(long)]
    check: bool,
}

pub(super) fn run(args: &Args, registry: &Registry) -> Result<Exit, Stop> {
    let opened = open::open(&args.graph, registry)?;
    let errors = opened.problems.iter().filter(|p| p.is_error()).count();
    let warnings = opened.problems.len() - errors;
    if args.json {
        print(&format!("{:#}\n", as_json(&opened.problems)))?;
    } else {
        for problem in &opened.problems {
            print(&format!("{}: {problem}\n", if problem.is_error() { "error" } else { "warning" }))?;
        }
        let nodes = opened.graph.nodes().count();
        print(&format!(
            "{}: {nodes} nodes, {errors} errors, {warnings} warnings\n",
            args.graph.graph.display()
        ))?;
    }
    Ok(if errors > 0 || (args.strict && warnings > 0) { Exit::Graph } else { Exit::Done })
}

pub(super) fn as_json(problems: &[Problem]) -> serde_json::Value {
    let one = |p: &Problem| {
        serde_json::json!({
            "severity": if p.is_error() { "error" } else { "warning" },
            "message": p.to_string(),
        })
    };
    problems.iter().map(one).collect()
}

pub(super) fn fmt(args: &FmtArgs, registry: &Registry) -> Result<Exit, Stop> {
    let mut exit = Exit::Done;
    for path in &args.graphs {
        let graph = open::load(path, registry)?;
        let canonical = graph.canonical();
        if graph.to_bytes() == canonical {
            continue;
        }
        if args.check {
            eprintln!("{}: not in canonical form", path.display());
            exit = Exit::Failed;
            continue;
        }
        save(path, &canonical)?;
        eprintln!("{}: written in canonical form", path.display());
    }
    Ok(exit)
}
