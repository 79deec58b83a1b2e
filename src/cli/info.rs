//! `orograph info`: what a graph or a height file holds.

use std::path::Path;

use serde_json::json;

use super::args::GraphArgs;
use super::exit::{Exit, Stop, print_json, print_lines};
use super::{height, open};
use crate::files::{Format, Info};
use crate::graph::{Graph, GraphQuantities, Output};
use crate::node::Cancel;
use crate::nodes::Registry;
use crate::params::Shape;
use crate::value::Quantity;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    /// Prints JSON
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    read: height::ReadArgs,
    #[command(flatten)]
    memory: height::MemoryArgs,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    if !is_graph(&args.graph.graph) {
        args.graph.refuse("graphs", args.graph.given())?;
        return height_file(args, cancel);
    }
    args.graph.refuse("height files", args.read.given().chain(args.memory.given()))?;
    let graph = open::open(&args.graph, registry)?.graph;
    if args.json {
        return print_json(&as_json(&graph));
    }
    print_lines(lines(&graph))
}

/// Whether a file is a graph by its name; standard input is one.
pub(super) fn is_graph(path: &Path) -> bool {
    path == Path::new(open::STDIN) || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("graph"))
}

fn height_file(args: &Args, cancel: &Cancel) -> Result<Exit, Stop> {
    let path = &args.graph.graph;
    let file = height::read(path, &args.read.reading(path)?, args.memory.budget(), 0, cancel)?;
    let info = Info::of(&path.to_string_lossy(), &file);
    if args.json { print_json(&json!(info)) } else { print_lines(info.to_string().lines()) }
}

fn as_json(graph: &Graph) -> serde_json::Value {
    let about = graph.about();
    let exposed = graph.exposed().map(|(name, e)| {
        let unit = graph.exposed_param(name).ok().and_then(|p| p.unit);
        json!({
            "name": name, "value": e.value, "bind": e.bind, "min": e.min, "max": e.max, "unit": unit,
            "label": e.label, "about": e.about,
        })
    });
    let quantities = graph.quantities();
    let outputs = graph.outputs().map(|(name, o)| {
        let (quantity, format) = written(graph, &quantities, o);
        json!({
            "name": name, "from": o.from, "format": format.map(Format::name),
            "quantity": quantity.map(Quantity::name), "unit": quantity.map(Quantity::unit), "about": o.about,
        })
    });
    json!({
        "title": about.title, "author": about.author, "license": about.license, "about": about.about,
        "tags": about.tags, "terrain": graph.terrain(), "nodes": graph.nodes().len(),
        "exposed": exposed.collect::<Vec<_>>(), "outputs": outputs.collect::<Vec<_>>(),
    })
}

/// What the numbers of an output mean, and the format in which a build writes it; nothing where a fault leaves them
/// open.
fn written(
    graph: &Graph,
    quantities: &GraphQuantities,
    output: &Output,
) -> (Option<Quantity>, Option<Format>) {
    let source = graph.resolved(&output.from);
    let quantity = source.and_then(|source| quantities.get(graph, &source));
    (quantity, output.format.or(quantity.map(|quantity| output.format_for(quantity))))
}

fn lines(graph: &Graph) -> Vec<String> {
    let (about, t) = (graph.about(), graph.terrain());
    let mut lines = Vec::new();
    let mut field = |name: &str, value: &str| {
        if !value.is_empty() {
            lines.push(format!("{name:9}{value}"));
        }
    };
    field("title", &about.title);
    field("author", &about.author);
    field("license", &about.license);
    field("about", &about.about);
    field("tags", &about.tags.join(", "));
    field(
        "terrain",
        &format!(
            "{} x {} m, {}, seed {}, base {}",
            t.width,
            t.depth,
            t.sea_level.map_or("no water".to_owned(), |level| format!("sea level {level} m")),
            t.seed,
            t.base
        ),
    );
    field("nodes", &graph.nodes().len().to_string());
    for (name, e) in graph.exposed() {
        let param = graph.exposed_param(name).ok();
        let unit = param.as_ref().and_then(|p| p.unit.as_deref()).filter(|u| *u != "1");
        let unit = unit.map(|u| format!(" {u}")).unwrap_or_default();
        let range = match param.map(|p| p.shape) {
            Some(Shape::Number { min, max, .. }) => format!(" ({min} to {max})"),
            _ => String::new(),
        };
        let note = if e.about.is_empty() { &e.label } else { &e.about };
        lines.push(format!("set      {name} = {}{unit}{range}  {note}", e.value).trim_end().to_owned());
    }
    let quantities = graph.quantities();
    for (name, o) in graph.outputs() {
        let (quantity, format) = written(graph, &quantities, o);
        let parts = [format.map(|f| f.name().to_owned()), quantity.map(Quantity::described)];
        let what: Vec<String> = parts.into_iter().flatten().collect();
        let line = format!("output   {name} from {}: {}  {}", o.from, what.join(", "), o.about);
        lines.push(line.trim_end().trim_end_matches(':').to_owned());
    }
    lines
}
