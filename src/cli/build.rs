//! `orograph build`: evaluates the outputs of a graph and writes them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::ValueEnum;
use serde_json::{Value as Json, json};

use super::args::{EngineArgs, GraphArgs, GridArgs};
use super::exit::{Exit, Stop, spare_inputs, tell};
use super::folder::Folder;
use super::job::{Job, Tile, jobs, said_of};
use super::open::{self, Opened};
use super::plan::{chosen, warnings};
use super::progress::{Mode, Progress};
use super::report::Report;
use super::reserve::reserve;
use super::tiles::{TileArgs, tiles};
use crate::engine::{Engine, EngineError, Evaluation, Stage, TaskReport, Want};
use crate::files::Format;
use crate::graph::Graph;
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
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
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
enum Backend {
    /// The reference, the same bits everywhere
    Cpu,
    /// The GPU where a node has a twin for it
    Auto,
    /// The GPU, or an error
    Gpu,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    if args.backend == Backend::Gpu {
        let message =
            "--backend gpu: no node kind of this version runs on the GPU; use --backend cpu or auto";
        return Err(Stop::new(Exit::Device, message));
    }
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
    let inputs = open::inputs(&args.graph, &graph);
    let report_path = args.report.clone().unwrap_or_else(|| args.out.join("report.json"));
    spare_inputs(&report_path, &inputs)?;
    let folder = Folder::open(&args.out, &inputs, &report_path, args.overwrite)?;
    let head = head(&graph, args, &whole, variables);
    let mut report = Report::start(&report_path, head)?;
    problems.iter().for_each(|p| report.warning(p.to_string()));
    let mut options = args.engine.options();
    options.reserve = reserve(&graph, &args.engine, tiles.iter().map(|t| &t.grid).max_by_key(|g| g.len()));
    let engine = Engine::new(&options, files)?;
    let progress = Progress::new(args.progress);
    let build =
        Build { graph: &graph, engine: &engine, progress: &progress, cancel, whole, many: tiles.len() > 1 };
    let outcome = build.all(&names, args.format, &tiles, folder, &mut report);
    progress.end();
    let exit = outcome?;
    report.write()?;
    Ok(exit)
}

fn head(
    graph: &Graph,
    args: &Args,
    whole: &Grid,
    variables: serde_json::Map<String, Json>,
) -> serde_json::Map<String, Json> {
    let mut head = serde_json::Map::new();
    let mut put = |name: &str, value: Json| head.insert(name.to_owned(), value);
    put("orograph", json!(env!("CARGO_PKG_VERSION")));
    put("graph", json!(args.graph.graph.display().to_string()));
    put("graph_key", json!(blake3::hash(&graph.canonical()).to_hex().as_str()));
    put("seed", json!(graph.terrain().seed));
    put("variables", Json::from(variables));
    put("backend", json!("cpu"));
    put("terrain", serde_json::to_value(graph.terrain()).unwrap_or_default());
    put("size", json!(whole.cols.max(whole.rows)));
    put("cell", json!(whole.cell()));
    put("base_cell", json!(graph.terrain().base_cell()));
    head
}

struct Build<'a> {
    graph: &'a Graph,
    engine: &'a Engine,
    progress: &'a Progress,
    cancel: &'a Cancel,
    whole: Grid,
    many: bool,
}

impl Build<'_> {
    fn all(
        &self,
        names: &[String],
        format: Option<Format>,
        tiles: &[Tile],
        mut folder: Folder,
        report: &mut Report,
    ) -> Result<Exit, Stop> {
        let mut exit = Exit::Done;
        let mut failed = |output: &str, message: String, code: Exit, report: &mut Report| {
            self.progress.say(&format!("error: output `{output}`: {message}"));
            report.failure(output, &message, code);
            if exit == Exit::Done {
                exit = code;
            }
        };
        let (mut jobs, broken) = jobs(self.graph, names, format);
        for (name, problem) in broken {
            failed(&name, said_of(problem), Exit::Graph, report);
        }
        // Refused before anything runs: what follows asks for less.
        if let Some(largest) = tiles.iter().max_by_key(|t| t.grid.len()) {
            let wants: Vec<Want> = jobs.iter().map(|j| j.want(largest.grid)).collect();
            let mut plan = self.engine.plan(self.graph, &wants);
            self.engine.know(self.graph, &wants, &mut plan, self.progress, self.cancel)?;
            self.engine.admit(&plan)?;
        }
        // A few samples tell what each output is, and so its format and range, before anything large runs.
        self.resolve(&mut jobs, tiles, &mut failed, report)?;
        let files: Vec<String> =
            jobs.iter().flat_map(|j| tiles.iter().flat_map(|t| j.files(t, self.many))).collect();
        folder.claim(&files)?;
        if let Some(tile) = tiles.first() {
            let (names, wants): (Vec<String>, Vec<Want>) =
                jobs.iter().map(|j| (j.name.clone(), j.want(tile.grid))).unzip();
            for warning in warnings(&self.engine.plan(self.graph, &wants), &names, &self.whole) {
                self.progress.say(&format!("warning: {warning}"));
                report.warning(warning);
            }
        }
        // Most notes hold for every tile alike.
        let mut said = BTreeSet::new();
        for tile in tiles {
            if jobs.is_empty() {
                break;
            }
            let evaluation = self.evaluate(&jobs, tile, report)?;
            let mut dropped = Vec::new();
            for (i, (job, value)) in jobs.iter().zip(&evaluation.values).enumerate() {
                let written = match value {
                    Ok(value) => {
                        job.write(value, tile, self.many, self.graph.terrain(), &self.whole, folder.dir())
                    }
                    Err(failure) => Err(Stop::new(Exit::of(failure), failure)),
                };
                match written {
                    Ok(mut entry) => {
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
                        failed(&job.name, stop.message, stop.exit, report);
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

    /// Finds format and range of each output; those that fail are taken out.
    fn resolve(
        &self,
        jobs: &mut Vec<Job>,
        tiles: &[Tile],
        failed: &mut impl FnMut(&str, String, Exit, &mut Report),
        report: &mut Report,
    ) -> Result<(), Stop> {
        let Some(first) = tiles.first() else { return Ok(()) };
        let corner = Grid { cols: 2.min(first.grid.cols), rows: 2.min(first.grid.rows), ..first.grid };
        self.progress.label("first look");
        let wants: Vec<_> = jobs.iter().map(|j| j.want(corner)).collect();
        let looks = self.engine.evaluate(self.graph, &wants, self.progress, self.cancel)?;
        // What runs on the base grid or on none runs here and not again; the few samples themselves are no news.
        let lasting = |t: &&TaskReport| !matches!(t.stage, Stage::Run | Stage::Lift);
        let lasting: Vec<TaskReport> = looks.tasks.iter().filter(lasting).cloned().collect();
        self.enter(&lasting, &looks, report);
        let mut ranged = Vec::new();
        for (job, value) in jobs.iter_mut().zip(&looks.values) {
            if let Ok(value) = value {
                job.settle(value);
                if job.needs_range() {
                    ranged.push(job.name.clone());
                }
            }
        }
        let mut failures: Vec<(String, String, Exit)> = Vec::new();
        let fault = |job: &Job, f: &crate::engine::Failure| (job.name.clone(), f.to_string(), Exit::of(f));
        failures.extend(
            jobs.iter().zip(&looks.values).filter_map(|(j, v)| v.as_ref().err().map(|f| fault(j, f))),
        );
        // One range for the whole terrain, never one a tile: that of the base grid.
        let base = self.graph.terrain().base_grid();
        self.progress.label("range");
        for job in jobs.iter_mut().filter(|j| ranged.contains(&j.name)) {
            let wants = [job.want(base)];
            let evaluation = self.engine.evaluate(self.graph, &wants, self.progress, self.cancel)?;
            self.enter(&evaluation.tasks, &evaluation, report);
            match &evaluation.values[0] {
                Ok(value) => job.take_range(value),
                Err(f) => failures.push(fault(job, f)),
            }
        }
        jobs.retain(|j| !failures.iter().any(|(name, ..)| *name == j.name));
        for (name, message, exit) in failures {
            failed(&name, message, exit, report);
        }
        Ok(())
    }

    fn evaluate(&self, jobs: &[Job], tile: &Tile, report: &mut Report) -> Result<Evaluation, Stop> {
        self.progress.label(if self.many {
            format!("tile {},{}", tile.place.col, tile.place.row)
        } else {
            String::new()
        });
        Ok(self.values(jobs, &tile.grid, report)?)
    }

    fn values(&self, jobs: &[Job], grid: &Grid, report: &mut Report) -> Result<Evaluation, EngineError> {
        let wants: Vec<_> = jobs.iter().map(|j| j.want(*grid)).collect();
        let evaluation = self.engine.evaluate(self.graph, &wants, self.progress, self.cancel)?;
        self.enter(&evaluation.tasks, &evaluation, report);
        Ok(evaluation)
    }

    /// Enters tasks of an evaluation in the report, and says what their nodes warn of.
    fn enter(&self, tasks: &[TaskReport], of: &Evaluation, report: &mut Report) {
        for warning in report.tasks(tasks, of.peak_bytes, of.planned_bytes) {
            self.progress.say(&format!("warning: {warning}"));
        }
        for notice in &of.notices {
            self.progress.say(&format!("warning: {notice}"));
            report.warning(notice.clone());
        }
    }
}
