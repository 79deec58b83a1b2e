//! `orograph stats`: figures of a graph's output or of a height file, beside those of real land.

mod models;
mod table;

use std::path::Path;

use serde_json::{Map, Value as Json, json};

use super::args::{EngineArgs, GraphArgs, GridArgs, parse_finite, parse_positive};
use super::exit::{Exit, Stop, print_json, print_lines, tell};
use super::info::is_graph;
use super::open::{self, Opened};
use super::plan::{chosen, want};
use super::progress::{Mode, Progress};
use super::reserve::reserve;
use super::{heed, height};
use crate::engine::{Engine, Options, Want};
use crate::files::HeightFile;
use crate::graph::Graph;
use crate::kit::geomorphometry::{self, Figures, Land, RiverFigures};
use crate::node::Cancel;
use crate::nodes::Registry;
use crate::value::{Object as _, Quantity, Rivers, Value, WireType};
use crate::work::Work;
use models::Models;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A .graph file or a height file
    #[command(flatten)]
    graph: GraphArgs,
    /// The output of the graph to measure [default: the first that is heights]
    #[arg(long = "output", value_name = "NAME")]
    output: Option<String>,
    #[command(flatten)]
    grid: GridArgs,
    /// Prints JSON
    #[arg(long)]
    pub(super) json: bool,
    /// Height of the sea in metres, at and below which nothing is land, or `none` [default: the graph's sea level; none
    /// of a file]
    #[arg(long, value_name = "METRES", value_parser = sea, allow_hyphen_values = true)]
    sea: Option<Sea>,
    /// Averages blocks of cells to about this size first, so that land with other cells can be compared
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    target_cell: Option<f64>,
    /// Drained area, in m², from which a cell is a channel [default: 200 cells]
    #[arg(long, value_name = "AREA", value_parser = parse_positive, allow_hyphen_values = true)]
    channel: Option<f64>,
    /// Factor on the heights of a height file: metres a unit of one that does not say
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    height_scale: Option<f64>,
    /// Metres between the samples of a height file, whatever it says
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    cell: Option<f64>,
    #[command(flatten)]
    read: height::ReadArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// How progress is shown on standard error [default: a bar on a terminal]
    #[arg(long, value_enum)]
    progress: Option<Mode>,
}

/// The level of the sea, where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sea(Option<f64>);

fn sea(text: &str) -> Result<Sea, String> {
    if text.trim() == "none" {
        return Ok(Sea(None));
    }
    parse_finite(text).map(|level| Sea(Some(level))).map_err(|e| format!("{e}; or `none`"))
}

/// What is to be measured.
enum Subject {
    /// Heights, and the level of the sea around them.
    Land { land: Land, sea: Option<f64> },
    /// A network of rivers.
    Rivers(Rivers),
}

/// Figures as JSON, of rounded numbers, with the models to hold them against.
struct Measured {
    figures: Map<String, Json>,
    models: Models,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    args.refuse()?;
    let progress = Progress::new(args.progress);
    let is_graph = is_graph(&args.graph.graph);
    let given = if is_graph {
        from_graph(args, registry, &progress, cancel)
    } else {
        from_file(args, cancel).map(|subject| (subject, None))
    };
    let measured = given.and_then(|(subject, output)| {
        let measured = match subject {
            Subject::Land { land, sea } => measure_land(args, land, sea, is_graph, &progress, cancel),
            Subject::Rivers(rivers) => measure_rivers(args, &rivers),
        };
        measured.map(|measured| (measured, output))
    });
    progress.end();
    let (Measured { figures, models }, output) = measured?;
    let file = args.graph.graph.to_string_lossy();
    let figures = Json::Object(figures);
    if !args.json {
        let title = output.map_or_else(|| file.to_string(), |output| format!("output {output} of {file}"));
        return print_lines(table::lines(&title, &figures, &models));
    }
    let compared = table::compared(&figures, &models);
    let mut all = json!({ "file": file, "output": output });
    let rest = json!({ "models": models.names(), "compared": compared });
    if let (Json::Object(all), Json::Object(figures), Json::Object(rest)) = (&mut all, figures, rest) {
        all.extend(figures);
        all.extend(rest);
    }
    print_json(&all)
}

impl Args {
    /// Refuses options for graphs with a height file, and the other way round.
    fn refuse(&self) -> Result<(), Stop> {
        self.engine.refuse()?;
        if is_graph(&self.graph.graph) {
            let given = heed::given([
                ("--height-scale", self.height_scale.is_some()),
                ("--cell", self.cell.is_some()),
            ]);
            return self.graph.refuse("height files", given.chain(self.read.given()));
        }
        let given = heed::given([
            ("--output", self.output.is_some()),
            ("--size", self.grid.size.is_some()),
            ("--region", self.grid.region.is_some()),
            ("--cache", self.engine.cache.is_some()),
            ("--cache-size", self.engine.cache_size.is_some()),
            ("--time", self.engine.time.is_some()),
            ("--threads", self.engine.threads.is_some()),
        ]);
        self.graph.refuse("graphs", self.graph.given().chain(given))
    }

    /// The level of the sea that was asked for, or else another.
    fn sea_or(&self, other: Option<f64>) -> Option<f64> {
        self.sea.map_or(other, |Sea(level)| level)
    }
}

/// The figures of land, after the averaging and without the sea.
fn measure_land(
    args: &Args,
    land: Land,
    sea: Option<f64>,
    is_graph: bool,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Measured, Stop> {
    let averaged = args.target_cell.map_or(1, |target| land.block(target));
    if let Some(target) = args.target_cell.filter(|_| averaged == 1) {
        let cell = land.cell();
        progress.say(&format!(
            "note: cells of {cell} m are left as they are: twice that is too far from {target} m"
        ));
    }
    let mut land = land.averaged(averaged);
    let (cols, rows, most) = (land.cols(), land.rows(), geomorphometry::MOST_CELLS);
    if cols * rows > most {
        let message =
            format!("{cols} x {rows} cells are over the limit of {most}; --target-cell makes them fewer");
        return Err(Stop::new(Exit::Input, message));
    }
    if let Some(level) = sea {
        land = land.above_sea(level);
    }
    let share = |share: f32| progress.share("measures the land", share);
    let work = Work::new(cancel).telling(&share);
    let figures = Figures::of(&land, args.channel, &work).map_err(|e| Stop::new(Exit::Cancelled, e))?;
    let figures = figures.ok_or_else(|| {
        let exit = if is_graph { Exit::Failed } else { Exit::Input };
        let sunk = sea.map_or_else(String::new, |level| format!(" or not above the sea at {level} m"));
        Stop::new(exit, format!("there is no land to measure: every cell is void{sunk}"))
    })?;
    let models = Models::near(figures.cell);
    Ok(Measured::new(json!({ "sea": sea, "averaged": averaged }), json!(figures), models))
}

/// The figures of rivers.
fn measure_rivers(args: &Args, rivers: &Rivers) -> Result<Measured, Stop> {
    let given = heed::given([
        ("--sea", args.sea.is_some()),
        ("--target-cell", args.target_cell.is_some()),
        ("--channel", args.channel.is_some()),
    ]);
    heed::refuse(given, "heights, and the output is rivers")?;
    let figures = RiverFigures::of(rivers);
    let figures = figures.ok_or_else(|| Stop::new(Exit::Failed, "there is no river to measure"))?;
    Ok(Measured::new(json!({}), json!(figures), Models::all()))
}

impl Measured {
    fn new(about: Json, figures: Json, models: Models) -> Self {
        let all = [about, rounded(figures)].into_iter().filter_map(|part| match part {
            Json::Object(part) => Some(part),
            _ => None,
        });
        Self { figures: all.flatten().collect(), models }
    }
}

fn from_graph(
    args: &Args,
    registry: &Registry,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<(Subject, Option<String>), Stop> {
    let Opened { graph, files, problems, .. } = open::open(&args.graph, registry)?;
    problems.iter().filter(|p| p.is_error()).for_each(|p| progress.say(&format!("error: {p}")));
    let (_, window) = args.grid.grids(graph.terrain())?;
    let wanted = |name: &str| want(&graph, name, window).map_err(|e| Stop::new(Exit::Graph, e));
    let (name, want) = match &args.output {
        Some(name) => {
            chosen(&graph, std::slice::from_ref(name))?;
            (name.clone(), wanted(name)?)
        }
        None => first(&graph, |name| wanted(name).ok())?,
    };
    let own = geomorphometry::BYTES * window.len() as u64;
    let reserve = reserve(&graph, &args.engine, None) + own;
    let engine = Engine::new(&Options { reserve, ..args.engine.options() }, files)?;
    let evaluation = engine.evaluate(&graph, &[want], progress, cancel)?;
    evaluation.notices.iter().for_each(|notice| progress.say(&format!("warning: {notice}")));
    for task in &evaluation.tasks {
        let named = |warning| format!("warning: node `{}`: {warning}", task.node);
        task.warnings.iter().map(named).for_each(|line| progress.say(&line));
    }
    let value = evaluation.values.into_iter().next();
    let value = value.ok_or_else(|| Stop::new(Exit::Failed, "the output gives nothing"))?;
    let value = value.map_err(|f| Stop::new(Exit::of(&f), f))?;
    let subject = subject(&name, &value, args.sea_or(graph.terrain().sea_level))?;
    Ok((subject, Some(name)))
}

/// The first output of a graph that is heights, or else the first that is rivers.
fn first(graph: &Graph, wanted: impl Fn(&str) -> Option<Want>) -> Result<(String, Want), Stop> {
    let quantities = graph.quantities();
    let names = chosen(graph, &[])?;
    let all: Vec<_> = names.into_iter().filter_map(|name| wanted(&name).map(|want| (name, want))).collect();
    let is_height = |want: &Want| quantities.get(graph, &want.source()) == Some(Quantity::Elevation);
    let is_rivers = |want: &Want| graph.wire_type(&want.source()) == Some(WireType::Object(Rivers::TYPE));
    let found = all.iter().find(|(_, want)| is_height(want));
    let found = found.or_else(|| all.iter().find(|(_, want)| is_rivers(want)));
    found.cloned().ok_or_else(|| Stop::usage("the graph has no output that is heights or rivers"))
}

/// What an output gives to be measured.
fn subject(name: &str, value: &Value, sea: Option<f64>) -> Result<Subject, Stop> {
    if let Some(rivers) = value.object::<Rivers>() {
        return Ok(Subject::Rivers(rivers.clone()));
    }
    match value {
        Value::Field(field) if field.quantity() == Quantity::Elevation => {
            let grid = field.grid();
            let land = Land::new(grid.cols, grid.rows, grid.cell(), field.data().to_vec());
            Ok(Subject::Land { land, sea })
        }
        other => {
            let what =
                other.quantity().map_or_else(|| other.wire_type().name().to_owned(), Quantity::described);
            Err(Stop::usage(format!("--output must name heights or rivers, and `{name}` is {what}")))
        }
    }
}

fn from_file(args: &Args, cancel: &Cancel) -> Result<Subject, Stop> {
    let path: &Path = &args.graph.graph;
    let budget = args.engine.options().memory;
    let (height_scale, own_cell) = (args.height_scale, args.cell);
    let work = move |file: HeightFile| {
        file.origin.notes.iter().for_each(|n| tell(&format!("note: {n}")));
        let file = height::scaled(file, height_scale.unwrap_or(1.0), 0.0)?;
        if !file.metres && height_scale.is_none() {
            tell("note: the file holds plain numbers; measured as metres, --height-scale says otherwise");
        }
        let cell = match (own_cell, file.placement.cell) {
            (Some(cell), _) => cell,
            (None, Some(sides)) => square(sides),
            (None, None) => {
                return Err(Stop::usage(
                    "the file does not say how far apart its samples are: give --cell METRES",
                ));
            }
        };
        Ok(Land::new(file.cols, file.rows, cell, file.data))
    };
    let land =
        height::read_with(path, &args.read.reading(path)?, budget, geomorphometry::BYTES, cancel, work)?;
    Ok(Subject::Land { land, sea: args.sea_or(None) })
}

/// The side of a square as large as a cell.
fn square([x, y]: [f64; 2]) -> f64 {
    let side = (x * y).sqrt();
    if (x / y - 1.0).abs() > 0.005 {
        tell(&format!("note: cells of {x:.4} x {y:.4} m are measured as squares of {side:.4} m"));
    }
    side
}

/// The same with numbers of six significant digits: what lies behind them hangs on the machine.
fn rounded(value: Json) -> Json {
    match value {
        Json::Number(number) if number.is_f64() => {
            let text = number.as_f64().map(|x| format!("{x:.5e}"));
            json!(text.and_then(|text| text.parse::<f64>().ok()))
        }
        Json::Array(all) => Json::Array(all.into_iter().map(rounded).collect()),
        Json::Object(all) => {
            Json::Object(all.into_iter().map(|(key, value)| (key, rounded(value))).collect())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        let given = json!({ "a": [1234567.0, 0.123_456_78, -2.5], "b": 7, "c": null, "d": "1.23456789" });
        let want = json!({ "a": [1_234_570.0, 0.123_457, -2.5], "b": 7, "c": null, "d": "1.23456789" });
        assert_eq!(rounded(given), want);
    }

    #[test]
    fn the_sea_is_a_level_or_none() {
        assert_eq!(sea(" -3.5"), Ok(Sea(Some(-3.5))));
        assert_eq!(sea("none"), Ok(Sea(None)));
        assert!(sea("").is_err() && sea("nan").is_err() && sea("deep").is_err());
    }
}
