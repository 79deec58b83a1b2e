//! `orograph check` and `orograph fmt`.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use super::args::GraphArgs;
use super::exit::{Exit, Stop, print, print_json, print_lines, save_known, tell};
use super::open::{self, Opened, is_stdin};
use super::report::REPORT;
use crate::files::{Format, sidecar_name};
use crate::graph::{Graph, Output, Place, Problem};
use crate::node::Error;
use crate::nodes::Registry;
use crate::text::printable_json;
use crate::whole::Known;
use crate::widget::Widget;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    /// Warnings count as errors
    #[arg(long)]
    strict: bool,
    /// Prints the problems as JSON
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct FmtArgs {
    /// The .graph files; - reads standard input and writes standard output
    #[arg(required = true)]
    graphs: Vec<PathBuf>,
    /// Writes nothing; fails when a file is not in canonical form
    #[arg(long)]
    pub(super) check: bool,
}

pub(super) fn run(args: &Args, registry: &Registry) -> Result<Exit, Stop> {
    let mut opened = open::open(&args.graph, registry)?;
    opened.problems.extend(report_problems(&opened.graph));
    let files = file_problems(&opened);
    // Faults of the graph itself decide the exit code before those of its files.
    let exit = match opened.problems.iter().any(Problem::is_error) {
        true => Exit::Graph,
        false if files.iter().any(Problem::is_error) => Exit::Input,
        false => Exit::Done,
    };
    let problems: Vec<Problem> = opened.problems.iter().cloned().chain(files).collect();
    let errors = problems.iter().filter(|p| p.is_error()).count();
    let warnings = problems.len() - errors;
    if args.json {
        print_json(&as_json(&problems))?;
    } else {
        let line = |p: &Problem| format!("{}: {p}", if p.is_error() { "error" } else { "warning" });
        let [nodes, errors, warnings] = [
            counted(opened.graph.nodes().count(), "node"),
            counted(errors, "error"),
            counted(warnings, "warning"),
        ];
        let sum = format!("{}: {nodes}, {errors}, {warnings}", args.graph.graph.display());
        print_lines(problems.iter().map(line).chain([sum]))?;
    }
    Ok(if exit == Exit::Done && args.strict && warnings > 0 { Exit::Graph } else { exit })
}

/// The text of a number of things, such as "1 node" or "2 nodes".
fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Problems of outputs whose files would have the name of the report.
fn report_problems(graph: &Graph) -> Vec<Problem> {
    let collides = |(name, output): &(&str, &Output)| {
        let names = |format: Format| {
            let file = format!("{name}.{}", format.extension());
            let sidecar = format.has_sidecar(1).then(|| sidecar_name(&file));
            sidecar.into_iter().chain([file]).collect::<Vec<_>>()
        };
        // An output without a format has one with a sidecar, unless it is colours.
        let names = output.format.map_or_else(|| names(Format::Exr), names);
        names.iter().any(|n| n.eq_ignore_ascii_case(REPORT))
    };
    let message = format!("is written to the name of a build's report, {REPORT}; give it another name");
    let problem = |(name, _)| Problem::error(Place::Output(String::from(name)), message.clone());
    graph.outputs().filter(collides).map(problem).collect()
}

/// Problems of nodes whose files cannot be read, or that have no file.
fn file_problems(opened: &Opened) -> Vec<Problem> {
    let (graph, mut found) = (&opened.graph, Vec::new());
    for id in graph.nodes() {
        let (node, name) = (graph.node(id), || graph.node(id).name.clone());
        let (Some(kind), Ok(parsed)) = (node.kind(), node.parse()) else { continue };
        let place = |parameter: &str| Place::Parameter { node: name(), parameter: parameter.to_owned() };
        if let Err(Error::File { parameter, file, message }) = opened.files.look(&*parsed) {
            found.push(Problem::error(place(parameter), format!("{message}: {file}")).of(id));
        }
        let canonical = parsed.canonical();
        for p in kind.params().iter().filter(|p| p.widget == Some(Widget::File)) {
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
        // A graph from standard input is written to standard output, even if it is canonical already.
        if is_stdin(path) && !args.check {
            let text = String::from_utf8_lossy(&canonical);
            // On a terminal, control characters in texts are escaped, since a terminal would obey them.
            print(&if std::io::stdout().is_terminal() { printable_json(&text) } else { text })?;
            continue;
        }
        if graph.to_bytes() == canonical {
            continue;
        }
        if args.check {
            tell(&format!("{}: not in canonical form", path.display()));
            exit = Exit::Failed;
            continue;
        }
        save_known(path, &canonical, Known::Bytes(&graph.to_bytes()))?;
        tell(&format!("{}: written in canonical form", path.display()));
    }
    Ok(exit)
}
