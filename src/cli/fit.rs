//! `orograph fit`: makes the terrain of a graph one that a height file fits.

use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use super::args::parse_positive;
use super::exit::{Exit, Stop, print_lines, save_known};
use super::height::{self, MemoryArgs, ReadArgs};
use super::{heed, open};
use crate::files::{Fit, HeightFile, Placed, Placing, Units};
use crate::graph::{Graph, NodeId, Place, Problem};
use crate::node::Cancel;
use crate::nodes::Registry;
use crate::nodes::files::import_height::ImportHeight;
use crate::units::{Degrees, Metres};
use crate::whole::Known;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The .graph file
    graph: PathBuf,
    /// The height file
    file: PathBuf,
    /// A node that imports the file; repeatable [default: those that name it, or the only one]
    #[arg(long = "node", value_name = "NAME")]
    nodes: Vec<String>,
    /// Samples along the longer side of the base grid, about [default: as the graph has]
    #[arg(long, value_name = "N")]
    base: Option<u32>,
    /// Metres between the samples, whatever the file says
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    cell: Option<f64>,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Writes another graph and leaves the first as it is
    #[arg(short = 'o', long = "out", value_name = "GRAPH")]
    out: Option<PathBuf>,
    /// Replaces that graph when it is there
    #[arg(long)]
    overwrite: bool,
    /// Prints what would be set, in the graph of -o where one is named, and writes nothing
    #[arg(long)]
    pub(super) dry_run: bool,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    let (dry, other) = (args.dry_run, args.out.is_some());
    let of_writing = heed::given([("--overwrite", dry && args.overwrite)]);
    heed::refuse(of_writing, "a graph that is written, and --dry-run writes none")?;
    let of_other = heed::given([("--overwrite", args.overwrite && !other)]);
    heed::refuse(of_other, "another graph; name it with -o")?;
    let target = args.out.as_ref().unwrap_or(&args.graph);
    let is_other = target != &args.graph && target.symlink_metadata().is_ok();
    if is_other && !args.overwrite && !dry {
        return Err(Stop::usage(format!("{} is there already; say --overwrite", target.display())));
    }
    let cannot =
        |e: std::io::Error| Stop::new(Exit::Input, format!("cannot read {}: {e}", args.graph.display()));
    let mut graph = open::load(&args.graph, registry)?;
    let before = std::fs::read(&args.graph).map_err(cannot)?;
    let nodes = nodes(&graph, args)?;
    let reading = nodes.iter().fold(args.read.reading(&args.file)?, |r, (_, node)| r.or(&node.reading_as()));
    let file = height::read(&args.file, &reading, args.memory.budget(), 0, cancel)?;
    let mut fitting = Fitting { graph: &mut graph, lines: Vec::new(), refused: None };
    fitting.terrain(&file, args, &nodes)?;
    fitting.names(&nodes, &args.file, target);
    let Fitting { mut lines, refused, .. } = fitting;
    if let Some(problem) = refused {
        return Err(Stop::new(Exit::Graph, problem));
    }
    let wrong = graph.problems().into_iter().find(|p| p.is_error() && matches!(p.place, Place::Terrain(_)));
    if let Some(problem) = wrong {
        return Err(Stop::new(Exit::Graph, problem));
    }
    if lines.is_empty() {
        lines.push("the file fits already".into());
    }
    let bytes = graph.to_bytes();
    if !args.dry_run && (is_other || args.out.is_some() || bytes != before) {
        let known = if args.out.is_some() { Known::Anything } else { Known::Bytes(&before) };
        save_known(target, &bytes, known)?;
    }
    print_lines(lines)
}

/// The nodes that are to be fitted.
fn nodes(graph: &Graph, args: &Args) -> Result<Vec<(NodeId, ImportHeight)>, Stop> {
    let import = |id: NodeId| {
        let node = graph.node(id);
        let is_import = node.kind().is_some_and(|k| k.id == "import_height");
        let parsed = node.parse().ok().filter(|_| is_import)?;
        serde_json::from_value::<ImportHeight>(parsed.canonical()).ok().map(|node| (id, node))
    };
    if !args.nodes.is_empty() {
        let named = |name: &String| {
            let id = graph
                .find(name)
                .ok_or_else(|| Stop::usage(format!("--node: the graph has no node `{name}`")));
            import(id?)
                .ok_or_else(|| Stop::usage(format!("--node: `{name}` is no import_height that can be read")))
        };
        return args.nodes.iter().map(named).collect();
    }
    let all: Vec<_> = graph.nodes().filter_map(import).collect();
    let folder = folder_of(&args.graph);
    let file = args.file.canonicalize().ok();
    let names_it = |(_, node): &&(NodeId, ImportHeight)| {
        let named = open::found(folder, &node.file.0);
        !node.file.0.is_empty() && named.is_some() && named == file
    };
    let naming: Vec<_> = all.iter().filter(names_it).cloned().collect();
    match (&naming[..], &all[..]) {
        ([], [only]) => Ok(vec![only.clone()]),
        ([], []) => Ok(Vec::new()),
        ([], _) => Err(Stop::usage(format!(
            "none of the nodes that import heights names {}; say which with --node",
            args.file.display()
        ))),
        _ => Ok(naming),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The placing at true size, upright, in the middle of the terrain.
const MIDDLE: Placing = Placing::TrueSize { x: Metres(0.0), y: Metres(0.0), rotation: Degrees(0.0) };

/// A graph that is being fitted, and what was set in it.
struct Fitting<'a> {
    graph: &'a mut Graph,
    lines: Vec<String>,
    refused: Option<Problem>,
}

impl Fitting<'_> {
    /// Sets the sides, the base grid and the place on Earth, and places the nodes in them.
    fn terrain(
        &mut self,
        file: &HeightFile,
        args: &Args,
        nodes: &[(NodeId, ImportHeight)],
    ) -> Result<(), Stop> {
        // A node that is placed by its georeference has the steps of the file and ignores its own cell.
        let by_cell = nodes.iter().filter(|(_, node)| node.placement != Placing::Georeference);
        if args.cell.is_some() && by_cell.clone().count() < nodes.len() {
            return Err(Stop::usage(
                "--cell is for nodes that are stretched or placed at true size, and a georeference has the steps of the file",
            ));
        }
        let of_node = by_cell.into_iter().find_map(|(_, node)| node.cell);
        let steps_at = |cell: Option<Metres>| {
            Placed { cols: file.cols, rows: file.rows, placement: file.placement, cell }.steps()
        };
        let [dx, dy] = steps_at(args.cell.map(Metres).or(of_node)).ok_or_else(|| {
            Stop::usage("the file does not say how far apart its samples are; say it with --cell METRES")
        })?;
        let extent = [dx * (file.cols - 1) as f64, dy * (file.rows - 1) as f64];
        let fit = Fit::of(extent, args.base.unwrap_or(self.graph.terrain().base)).map_err(Stop::usage)?;
        self.put("terrain.width", json!(fit.width));
        self.put("terrain.depth", json!(fit.depth));
        self.put("terrain.base", json!(fit.base));
        self.lines.extend(fit.loss().map(|loss| format!("note: {loss}")));
        for (id, node) in nodes {
            let name = self.graph.node(*id).name.clone();
            match node.placement {
                Placing::Georeference => self.geo(file)?,
                Placing::Stretch if fit.is_exact() => (),
                // A file that is stretched over a slightly smaller terrain is not cropped.
                Placing::Stretch | Placing::TrueSize { .. } => {
                    if node.placement != MIDDLE {
                        let middle = json!({ "true_size": { "x": 0, "y": 0, "rotation": 0 } });
                        self.put(&format!("{name}.placement"), middle);
                    }
                    // The terrain has the size of the file at these steps, so that the node needs them, too.
                    if steps_at(node.cell) != Some([dx, dy]) {
                        self.put(&format!("{name}.cell"), json!(dx));
                    }
                }
            }
        }
        Ok(())
    }

    /// Sets the place of the terrain on Earth so that its north-west corner is that of the file.
    fn geo(&mut self, file: &HeightFile) -> Result<(), Stop> {
        let place = file.placement;
        let upright = place.affine.filter(|a| a.is_north_up());
        let metres = matches!(place.units, Units::Length(1.0));
        let (Some(affine), Some(epsg), true) = (upright, place.epsg, metres) else {
            return Err(Stop::usage(
                "the node is placed by georeference, and the file has no upright coordinates in metres of a system with \
                 an EPSG code",
            ));
        };
        let [east, north] = affine.origin;
        self.put("terrain.geo", json!({ "epsg": epsg, "east": east, "north": north }));
        Ok(())
    }

    /// Sets the file in the nodes that have none, where the graph may read it from the place where it is written.
    fn names(&mut self, nodes: &[(NodeId, ImportHeight)], file: &Path, target: &Path) {
        let folder = folder_of(target).canonicalize().ok();
        let inside = folder.zip(file.canonicalize().ok());
        let inside = inside.and_then(|(folder, file)| file.strip_prefix(&folder).ok().map(Path::to_owned));
        let empty = nodes.iter().filter(|(_, node)| node.file.0.is_empty());
        let empty: Vec<String> = empty.map(|(id, _)| self.graph.node(*id).name.clone()).collect();
        for name in empty {
            let parts = inside.as_ref().map(|p| p.iter().map(|s| s.to_str()).collect::<Option<Vec<_>>>());
            match parts.flatten() {
                Some(parts) => self.put(&format!("{name}.file"), json!(parts.join("/"))),
                None => self.lines.push(format!(
                    "note: `{name}` names no file; build with --set {}={}",
                    self.outside(&format!("{name}.file")),
                    file.display()
                )),
            }
        }
    }

    /// The name by which a parameter is set: its exposed name, or its path.
    fn outside(&self, path: &str) -> String {
        let bound = self.graph.exposed().find(|(_, e)| e.bind.iter().any(|b| b == path));
        bound.map_or_else(|| path.to_owned(), |(name, _)| name.to_owned())
    }

    fn put(&mut self, path: &str, value: Json) {
        let name = self.outside(path);
        let before = self.graph.canonical();
        match self.graph.assign_json(&name, &value) {
            Ok(()) if self.graph.canonical() != before => self.lines.push(format!("{name} = {value}")),
            Ok(()) => (),
            Err(problem) => self.refused = self.refused.take().or(Some(problem)),
        }
    }
}
