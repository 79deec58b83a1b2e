//! Opening a graph and applying the changes of the command line.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde_json::Value as Json;

use super::args::GraphArgs;
use super::exit::{Exit, Stop};
use crate::engine::{Files, on_this_system};
use crate::graph::{Graph, LoadError, MAX_FILE, Problem};
use crate::node::FileRequest;
use crate::nodes::Registry;

/// The most bytes of a file of variables.
const MAX_VARIABLES: u64 = MAX_FILE;

/// A graph ready to evaluate, and the files it may read.
pub(super) struct Opened {
    pub graph: Graph,
    pub files: Files,
    pub problems: Vec<Problem>,
    /// The values that were set, for the report.
    pub variables: serde_json::Map<String, Json>,
}

/// The path that stands for standard input.
pub(super) const STDIN: &str = "-";

/// Reads the file of a graph without changes.
pub(super) fn load(path: &Path, registry: &Registry) -> Result<Graph, Stop> {
    let (graph, name) = if is_stdin(path) {
        (from_stdin(registry), "standard input".into())
    } else {
        (Graph::open(path, registry), path.to_string_lossy())
    };
    graph.map_err(|e| {
        let exit =
            if matches!(e, LoadError::Read(_) | LoadError::NotAFile) { Exit::Input } else { Exit::Graph };
        Stop::new(exit, format!("{e}: {name}"))
    })
}

pub(super) fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN)
}

fn from_stdin(registry: &Registry) -> Result<Graph, LoadError> {
    let mut bytes = Vec::new();
    std::io::stdin().lock().take(MAX_FILE + 1).read_to_end(&mut bytes)?;
    Graph::from_bytes(&bytes, registry)
}

/// The folder whose files a graph may read: its own, or the current folder.
fn folder_of(graph: &Path) -> &Path {
    graph.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Reads the graph and applies `--set`, `--vars`, `--seed` and `--base`.
pub(super) fn open(args: &GraphArgs, registry: &Registry) -> Result<Opened, Stop> {
    args.refuse_doubles()?;
    let mut graph = load(&args.graph, registry)?;
    let mut files = Files::default();
    files
        .allow_folder(folder_of(&args.graph))
        .map_err(|e| Stop::new(Exit::Input, format!("cannot open the graph's folder: {e}")))?;
    for folder in args.allow.iter().cloned().chain(crate::engine::kept_folders()) {
        let opened = files.allow_folder(&folder);
        opened.map_err(|e| Stop::usage(format!("cannot open the folder {}: {e}", folder.display())))?;
    }
    let mut variables = serde_json::Map::new();
    if let Some(path) = &args.vars {
        for (name, value) in variables_of(path)? {
            let set = match value.as_str() {
                Some(text) => assign(&mut graph, &mut files, &name, text),
                None => graph.assign_json(&name, &value),
            };
            set.map_err(|e| Stop::usage(format!("--vars: {e}")))?;
            variables.insert(name, value);
        }
    }
    for pair in &args.set {
        let (name, value) = pair
            .split_once('=')
            .ok_or_else(|| Stop::usage(format!("--set takes NAME=VALUE, got `{pair}`")))?;
        assign(&mut graph, &mut files, name, value).map_err(|e| Stop::usage(format!("--set {name}: {e}")))?;
        variables.insert(name.to_owned(), Json::from(value));
    }
    let settings = [("seed", args.seed), ("base", args.base)];
    for (name, value) in settings.into_iter().filter_map(|(n, v)| Some((n, v?))) {
        graph
            .assign(&format!("terrain.{name}"), &value.to_string())
            .map_err(|e| Stop::usage(format!("--{name}: {e}")))?;
    }
    let problems = graph.problems();
    // A command uses the same content of files throughout.
    let files = files.pinned();
    Ok(Opened { graph, files, problems, variables })
}

fn variables_of(path: &Path) -> Result<serde_json::Map<String, Json>, Stop> {
    let unreadable =
        |e: &dyn std::fmt::Display| Stop::new(Exit::Input, format!("--vars: {e}: {}", path.display()));
    // A pipe will do, as a shell makes of `<(…)`; what has no end is not read to it.
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(|e| unreadable(&e))?;
    file.take(MAX_VARIABLES + 1).read_to_string(&mut text).map_err(|e| unreadable(&e))?;
    if text.len() as u64 > MAX_VARIABLES {
        return Err(unreadable(&format!("is larger than {MAX_VARIABLES} bytes")));
    }
    let wrong = |e: &dyn std::fmt::Display| Stop::usage(format!("--vars: {e}: {}", path.display()));
    match crate::graph::strict_json(text.strip_prefix('\u{feff}').unwrap_or(&text)).map_err(|e| wrong(&e))? {
        Json::Object(map) => Ok(map),
        _ => Err(wrong(&"must hold a JSON object of names and values")),
    }
}

/// Sets a parameter from the command line. A file that the user names there is relative to the current folder and may
/// be anywhere.
fn assign(graph: &mut Graph, files: &mut Files, name: &str, text: &str) -> Result<(), Problem> {
    graph.assign(name, text)?;
    if requests(graph).any(|r| r.name == text)
        && let Some(path) = found(Path::new(""), text)
    {
        graph.assign(name, &path.to_string_lossy())?;
        let beside = |r: &FileRequest| Path::new(&r.name).parent() == path.parent();
        requests(graph).filter(beside).for_each(|r| files.allow_file(Path::new(&r.name)));
    }
    Ok(())
}

/// The path of a file in a folder, where it exists; the name may be written as on Windows.
pub(super) fn found(folder: &Path, name: &str) -> Option<PathBuf> {
    let there = |name: &str| folder.join(name).canonicalize().ok();
    there(name).or_else(|| there(&on_this_system(name)?))
}

/// The files that are read: the graph, the variables, and existing files that the nodes name.
pub(super) fn inputs(args: &GraphArgs, graph: &Graph, files: &Files) -> Vec<PathBuf> {
    let folder = folder_of(&args.graph);
    let sources = requests(graph).map(|f| files.locate(&f.name).unwrap_or_else(|| folder.join(f.name)));
    let own = (!is_stdin(&args.graph)).then(|| args.graph.clone());
    own.into_iter().chain(args.vars.clone()).chain(sources).collect()
}

/// The files that the nodes of a graph ask for.
fn requests(graph: &Graph) -> impl Iterator<Item = FileRequest> {
    graph.nodes().filter_map(|id| graph.node(id).parse().ok()).flat_map(|node| node.files())
}
