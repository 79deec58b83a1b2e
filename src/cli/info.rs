//! `orograph info`: what a graph or a height file holds.

use std::path::PathBuf;

use serde_json::json;

use super::exit::{Exit, Stop, print};
use super::open;
use crate::graph::Graph;
use crate::nodes::Registry;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A .graph file or a height file
    file: PathBuf,
    /// Prints JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args, registry: &Registry) -> Result<Exit, Stop> {
    if !is_graph(&args.file) {
        return height_file(args);
    }
    let graph = open::load(&args.file, registry)?;
    if args.json {
        return print(&format!("{:#}\n", as_json(&graph)));
    }
    print(&text(&graph))
}

/// Whether a file is a graph by its name.
pub(super) fn is_graph(path: &std::path::Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("graph"))
}

fn height_file(args: &Args) -> Result<Exit, Stop> {
    let name = args.file.to_string_lossy();
    let bytes =
        std::fs::read(&args.file).map_err(|e| Stop::new(Exit::Input, format!("cannot read {name}: {e}")))?;
    let sidecar = std::fs::read(crate::files::sidecar_name(&name)).ok();
    let info = crate::files::info(&name, &bytes, sidecar.as_deref(), &crate::files::Limits::default())
        .map_err(|e| Stop::new(Exit::Input, e))?;
    print(&if args.json { format!("{:#}\n", json!(info)) } else { info.to_string() })
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
    let outputs = graph
        .outputs()
        .map(|(name, o)| json!({ "name": name, "from": o.from, "format": o.format, "about": o.about }));
    json!({
        "title": about.title, "author": about.author, "license": about.license, "about": about.about,
        "tags": about.tags, "terrain": graph.terrain(), "nodes": graph.nodes().len(),
        "exposed": exposed.collect::<Vec<_>>(), "outputs": outputs.collect::<Vec<_>>(),
    })
}

fn text(graph: &Graph) -> String {
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
            "{} x {} m, sea level {} m, seed {}, base {}",
            t.width, t.depth, t.sea_level, t.seed, t.base
        ),
    );
    field("nodes", &graph.nodes().len().to_string());
    for (name, e) in graph.exposed() {
        let unit = graph.exposed_param(name).ok().and_then(|p| p.unit).filter(|u| u != "1");
        let unit = unit.map(|u| format!(" {u}")).unwrap_or_default();
        let note = if e.about.is_empty() { &e.label } else { &e.about };
        lines.push(format!("set      {name} = {}{unit}  {note}", e.value));
    }
    for (name, o) in graph.outputs() {
        let format = o.format.map_or("", |f| f.name());
        lines.push(format!("output   {name} from {} {format}  {}", o.from, o.about).trim_end().to_owned());
    }
    lines.join("\n") + "\n"
}
