//! `orograph build`: evaluates the outputs of a graph and writes them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::{Value as Json, json};

use super::args::{EngineArgs, GraphArgs, GridArgs};
use super::exit::{Exit, Stop, spare_inputs, tell};
use super::folder::Folder;
use super::job::{self, Job, Tile, jobs, said_of};
use super::open::{self, Opened};
use super::plan::{chosen, warnings};
use super::progress::{Mode, Progress};
use super::report::{REPORT, Report, STDOUT};
use super::reserve::reserve;
use super::shared::Part;
use super::tiles::{TileArgs, tiles};
use crate::engine::{Engine, EngineError, Evaluation, Failure, Want};
use crate::files::Format;
use crate::graph::{Graph, Problem};
use crate::node::Cancel;
use crate::nodes::Registry;
use crate::value::Grid;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    graph: GraphArgs,
    /// The folder to write into; made when it is not there
    #[arg(short = 'o', long = "out", value_name = "DIR")]
    out: PathBuf,
    /// One output; repeatable; all when left out
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    tiles: TileArgs,
    /// Writes every output in this format
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// Where nodes run
    #[arg(long, value_enum, default_value_t = BackendChoice::Cpu)]
    backend: BackendChoice,
    #[command(flatten)]
    engine: EngineArgs,
    /// Replaces files in the folder that no build wrote; an input never
    #[arg(long)]
    overwrite: bool,
    /// Stops at any warning of the graph
    #[arg(long)]
    strict: bool,
    /// Where the report goes, - for standard output [default: report.json in the folder]
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// How progress is shown on standard error [default: a bar on a terminal]
    #[arg(long, value_enum)]
    progress: Option<Mode>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BackendChoice {
    /// The reference, the same bits everywhere
    Cpu,
    /// The GPU where a node has a twin for it
    Auto,
    /// The GPU, or an error
    Gpu,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    if args.backend == BackendChoice::Gpu {
        let message =
            "--backend gpu: no node kind of this version runs on the GPU; use --backend cpu or auto";
        return Err(Stop::new(Exit::Device, message));
    }
    args.engine.refuse()?;
    let Opened { graph, files, problems, variables } = open::open(&args.graph, registry)?;
    for problem in &problems {
        tell(&format!("{}: {problem}", if problem.is_error() { "error" } else { "warning" }));
    }
    if args.strict && !problems.is_empty() {
        return Err(Stop::new(Exit::Graph, format!("--strict: the graph has {} problems", problems.len())));
    }
    let (whole, window) = args.grid.grids(graph.terrain())?;
    let tiles = tiles(&args.tiles, &window)?;
    let names = chosen(&graph, &args.outputs)?;
    let inputs = open::inputs(&args.graph, &graph, &files);
    let report_path = args.report.clone().unwrap_or_else(|| args.out.join(REPORT));
    spare_inputs(&report_path, &inputs)?;
    let folder = Folder::open(&args.out, &inputs, &report_path, args.overwrite)?;
    let head = head(&graph, args, [&whole, &window], &tiles, variables);
    let cut = || tiles.iter().map(|t| t.place).collect();
    // Builds of single tiles share the report in the folder; a report that the user names belongs to one build.
    let part =
        (args.tiles.is_part() && args.report.is_none()).then(|| Part { names: names.clone(), tiles: cut() });
    let mut report = Report::start(&report_path, &folder, head, part)?;
    problems.iter().for_each(|p| report.warning(p.to_string()));
    let mut options = args.engine.options();
    options.reserve = reserve(&graph, &args.engine, tiles.iter().map(|t| &t.grid).max_by_key(|g| g.cols));
    report.reserve(options.reserve);
    let engine = Engine::new(&options, files)?;
    let progress = Progress::new(args.progress);
    let build = Build {
        graph: &graph,
        problems: &problems,
        engine: &engine,
        progress: &progress,
        cancel,
        whole,
        cut: args.tiles.is_cut(),
    };
    let outcome = build.all(&names, args.format, &tiles, &folder, &mut report);
    progress.end();
    let exit = outcome?;
    let wrote = wrote(&args.out, report.outputs());
    report.write()?;
    wrote.iter().for_each(|line| progress.news(line));
    if report_path != Path::new(STDOUT) {
        progress.news(&format!("report {}", report_path.display()));
    }
    Ok(exit)
}

/// A line for each file that was written, or the number of files where they are many.
fn wrote(out: &Path, outputs: &[Json]) -> Vec<String> {
    const SHOWN: usize = 16;
    if outputs.len() > SHOWN {
        return vec![format!("wrote {} files to {}", outputs.len(), out.display())];
    }
    let line = |o: &Json| {
        let path = out.join(o["path"].as_str().unwrap_or_default());
        format!("wrote {}: {} x {} samples", path.display(), o["cols"], o["rows"])
    };
    outputs.iter().map(line).collect()
}

fn head(
    graph: &Graph,
    args: &Args,
    [whole, window]: [&Grid; 2],
    tiles: &[Tile],
    variables: serde_json::Map<String, Json>,
) -> serde_json::Map<String, Json> {
    let graph_key = blake3::hash(&graph.canonical()).to_hex();
    let grid = |g: &Grid| json!({ "col": g.col, "row": g.row, "cols": g.cols, "rows": g.rows });
    let cut = tiles.first().filter(|_| args.tiles.is_cut());
    let cut = cut.map(|t| json!({ "cols": t.place.cols, "rows": t.place.rows }));
    let format = args.format.map(Format::name);
    // Builds of parts that agree in this belong to one build.
    let build =
        json!([env!("CARGO_PKG_VERSION"), graph_key.as_str(), grid(whole), grid(window), cut, format]);
    let mut head = serde_json::Map::new();
    let mut put = |name: &str, value: Json| head.insert(name.to_owned(), value);
    put("orograph", json!(env!("CARGO_PKG_VERSION")));
    put("graph", json!(args.graph.graph.display().to_string()));
    put("graph_key", json!(graph_key.as_str()));
    put("build_key", json!(blake3::hash(build.to_string().as_bytes()).to_hex().as_str()));
    put("seed", json!(graph.terrain().seed));
    put("variables", Json::from(variables));
    put("backend", json!("cpu"));
    put("terrain", serde_json::to_value(graph.terrain()).unwrap_or_default());
    put("size", json!(whole.cols.max(whole.rows)));
    put("cell", json!(whole.cell()));
    put("whole", grid(whole));
    put("window", grid(window));
    put("tiles", json!(cut));
    put("base_cell", json!(graph.terrain().base_cell()));
    head
}

/// An output that failed, with the message and the exit code.
fn fault(job: &Job, failure: &Failure) -> (String, String, Exit) {
    (job.name.clone(), failure.to_string(), Exit::of(failure))
}

struct Build<'a> {
    graph: &'a Graph,
    problems: &'a [Problem],
    engine: &'a Engine,
    progress: &'a Progress,
    cancel: &'a Cancel,
    whole: Grid,
    /// Whether the terrain is cut into tiles.
    cut: bool,
}

impl Build<'_> {
    fn all(
        &self,
        names: &[String],
        format: Option<Format>,
        tiles: &[Tile],
        folder: &Folder,
        report: &mut Report<'_>,
    ) -> Result<Exit, Stop> {
        let mut exit = Exit::Done;
        let mut failed =
            |output: &str, message: String, code: Exit, report: &mut Report<'_>, on: Option<&Tile>| {
                self.progress.say(&format!("error: output `{output}`: {message}"));
                report.failure(output, &message, code, on.filter(|_| self.cut).map(|t| t.place));
                if exit == Exit::Done {
                    exit = code;
                }
            };
        let (mut jobs, broken) = jobs(self.graph, names, format, self.problems);
        for (name, problem) in broken {
            failed(&name, said_of(problem), Exit::Graph, report, None);
        }
        // The largest tile is checked against the budgets before anything runs; the others need less.
        let largest = tiles.iter().max_by_key(|t| t.grid.len());
        let mut foreseen = Vec::new();
        if let Some(largest) = largest {
            let wants: Vec<Want> = jobs.iter().map(|j| j.want(largest.grid)).collect();
            let mut plan = self.engine.plan_until(self.graph, &wants, self.cancel)?;
            self.engine.know(self.graph, &wants, &mut plan, self.progress, self.cancel)?;
            self.engine.admit(&plan)?;
            let failures = jobs.iter().zip(plan.failures());
            let mut failures: Vec<_> = failures.filter_map(|(j, f)| Some(fault(j, &*f?))).collect();
            failures.extend(self.take_ranges(&mut jobs, report)?);
            for (name, message, code) in &failures {
                failed(name, message.clone(), *code, report, None);
            }
            let names: Vec<String> = jobs.iter().map(|j| j.name.clone()).collect();
            foreseen = warnings(&plan, &names, &self.whole);
            jobs.retain(|j| !failures.iter().any(|(name, ..)| *name == j.name));
        }
        let files: Vec<String> =
            jobs.iter().flat_map(|j| tiles.iter().flat_map(|t| j.files(t, self.cut))).collect();
        let with_sidecars =
            jobs.iter().flat_map(|j| tiles.iter().filter_map(|t| j.with_sidecar(t, self.cut)));
        with_sidecars.into_iter().try_for_each(|file| folder.spare_sidecar(&file))?;
        folder.claim(&files)?;
        for warning in foreseen {
            self.progress.say(&format!("warning: {warning}"));
            report.warning(warning);
        }
        let graph_key = report.graph_key().to_owned();
        let to = job::Common {
            cut: self.cut,
            terrain: self.graph.terrain(),
            whole: self.whole,
            graph_key: &graph_key,
            folder: folder.dir(),
        };
        // Most notes are the same for all tiles and are printed once.
        let mut said = BTreeSet::new();
        for tile in tiles {
            if jobs.is_empty() {
                break;
            }
            let evaluation = self.evaluate(&jobs, tile, report)?;
            let mut dropped = Vec::new();
            for (i, (job, value)) in jobs.iter().zip(&evaluation.values).enumerate() {
                let written = match value {
                    // Files are written on the threads of the engine, whose number the user set and whose memory is
                    // counted.
                    Ok(value) => self.engine.pool().install(|| job.write(value, tile, &to)),
                    Err(failure) => Err(Stop::new(Exit::of(failure), failure)),
                };
                match written {
                    Ok(mut entry) => {
                        report.planned_seconds(entry.planned_seconds);
                        entry.json["effective_cell"] = json!(evaluation.effective_cells[i]);
                        for note in entry.notes {
                            let line = format!("note: output `{}`: {note}", job.name);
                            if said.insert(line.clone()) {
                                self.progress.say(&line);
                            }
                        }
                        report.output(entry.json);
                    }
                    Err(stop) => {
                        failed(&job.name, stop.message, stop.exit, report, Some(tile));
                        dropped.push(i);
                    }
                }
            }
            let mut i = 0;
            jobs.retain(|_| {
                i += 1;
                !dropped.contains(&(i - 1))
            });
        }
        Ok(exit)
    }

    /// Finds the ranges that are not set. A range is that of the values on the base grid, one for the whole terrain and
    /// not one for each tile. Returns the outputs that failed.
    fn take_ranges(
        &self,
        jobs: &mut [Job],
        report: &mut Report<'_>,
    ) -> Result<Vec<(String, String, Exit)>, Stop> {
        let base = self.graph.terrain().base_grid();
        let mut failures = Vec::new();
        self.progress.label("range");
        for job in jobs.iter_mut().filter(|j| j.needs_range()) {
            let evaluation = self.values(std::slice::from_ref(job), &base, report)?;
            match &evaluation.values[0] {
                Ok(value) => job.take_range(value),
                Err(f) => failures.push(fault(job, f)),
            }
        }
        Ok(failures)
    }

    fn evaluate(&self, jobs: &[Job], tile: &Tile, report: &mut Report<'_>) -> Result<Evaluation, Stop> {
        self.progress.label(if self.cut {
            format!("tile {},{}", tile.place.col, tile.place.row)
        } else {
            String::new()
        });
        Ok(self.values(jobs, &tile.grid, report)?)
    }

    fn values(&self, jobs: &[Job], grid: &Grid, report: &mut Report<'_>) -> Result<Evaluation, EngineError> {
        let wants: Vec<_> = jobs.iter().map(|j| j.want(*grid)).collect();
        let evaluation = self.engine.evaluate(self.graph, &wants, self.progress, self.cancel)?;
        self.enter(&evaluation, report);
        Ok(evaluation)
    }

    /// Adds an evaluation to the report and prints the warnings of its nodes.
    fn enter(&self, of: &Evaluation, report: &mut Report<'_>) {
        for warning in report.evaluation(of) {
            self.progress.say(&format!("warning: {warning}"));
        }
        for notice in &of.notices {
            self.progress.say(&format!("warning: {notice}"));
            report.warning(notice.clone());
        }
    }
}
