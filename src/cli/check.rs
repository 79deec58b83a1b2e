//! `orograph check` and `orograph fmt`.

use std::path::PathBuf;

use super::args::GraphArgs;
use super::exit::{Exit, Stop, print, save, tell};
use super::open::{self, Opened};
use crate::graph::{Place, Problem};
use crate::node::Error;
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
    let files = file_problems(&opened);
    // What is wrong with the graph itself counts before what is wrong around it.
    let exit = match opened.problems.iter().any(Problem::is_error) {
        true => Exit::Graph,
        false if files.iter().any(Problem::is_error) => Exit::Input,
        false => Exit::Done,
    };
    let problems: Vec<Problem> = opened.problems.iter().cloned().chain(files).collect();
    let errors = problems.iter().filter(|p| p.is_error()).count();
    let warnings = problems.len() - errors;
    if args.json {
        print(&format!("{:#}\n", as_json(&problems)))?;
    } else {
        for problem in &problems {
            print(&format!("{}: {problem}\n", if problem.is_error() { "error" } else { "warning" }))?;
        }
        let nodes = opened.graph.nodes().count();
        print(&format!(
            "{}: {nodes} nodes, {errors} errors, {warnings} warnings\n",
            args.graph.graph.display()
        ))?;
    }
    Ok(if exit == Exit::Done && args.strict && warnings > 0 { Exit::Graph } else { exit })
}

/// Files that the nodes name and that cannot be read, and nodes for which none is chosen.
fn file_problems(opened: &Opened) -> Vec<Problem> {
    let (graph, mut found) = (&opened.graph, Vec::new());
    for id in graph.nodes() {
        let (node, name) = (graph.node(id), || graph.node(id).name.clone());
        let (Some(kind), Ok(parsed)) = (node.kind(), node.parse()) else { continue };
        let place = |parameter: &str| Place::Parameter { node: name(), parameter: parameter.to_owned() };
        if let Err(Error::File { parameter, file, message }) = opened.files.look(&parsed.files()) {
            found.push(Problem::error(place(parameter), format!("{message}: {file}")).of(id));
        }
        let canonical = parsed.canonical();
        for p in kind.params().iter().filter(|p| p.widget.as_deref() == Some("file")) {
            if canonical[&p.name] == "" {
                found.push(Problem::warning(place(&p.name), "no file is chosen").of(id));
            }
        }
    }
    found
}

pub(super) fn as_json(problems: &[Problem]) -> serde_json::Value {
    let one = |p: &Problem| {
        serde_json::json!({
            "severity": if p.is_error() { "error" } else { "warning" },
            "place": p.place,
            "message": p.message,
            "text": p.to_string(),
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
            tell(&format!("{}: not in canonical form", path.display()));
            exit = Exit::Failed;
            continue;
        }
        // Through a link to the file it leads to.
        save(&path.canonicalize().unwrap_or_else(|_| path.clone()), &canonical)?;
        tell(&format!("{}: written in canonical form", path.display()));
    }
    Ok(exit)
}
