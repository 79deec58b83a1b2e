//! `orograph render`: a shaded picture of a graph's output or of a height file.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::args::{EngineArgs, GraphArgs, GridArgs, parse_positive};
use super::exit::{Exit, Stop, save, spare_inputs, tell};
use super::info::is_graph;
use super::open::{self, Opened};
use super::plan::{chosen, want};
use super::progress::{Mode, Progress};
use super::reserve::reserve;
use super::sidecars::spare_heights;
use super::{heed, height};
use crate::engine::{Engine, Options, Want};
use crate::files::{HeightFile, Limits, Squared, fill_voids};
use crate::graph::Graph;
use crate::node::{Cancel, Cost};
use crate::nodes::Registry;
use crate::render::{
    Camera, Edge, GroundPalette, Picture, Scene, Sun, map, map_cost, perspective, perspective_cost,
};
use crate::value::{Colors, Field, Grid, Lattice, Quantity, Value, WireType};
use crate::work::Work;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A .graph file or a height file
    #[command(flatten)]
    graph: GraphArgs,
    /// The PNG to write
    #[arg(short = 'o', long = "out", value_name = "PNG")]
    out: PathBuf,
    /// The output of the graph to draw [default: the first that is a field]
    #[arg(long = "output", value_name = "NAME")]
    output: Option<String>,
    /// The output of the graph to colour the ground with [default: the first that is colours]
    #[arg(long, value_name = "NAME")]
    color: Option<String>,
    #[command(flatten)]
    grid: GridArgs,
    /// A map from above or a perspective
    #[arg(long, value_enum, default_value_t = ViewKind::Map)]
    view: ViewKind,
    /// Columns of the picture [default: 1280, or the samples of a map up to 2048]
    #[arg(long, value_name = "PIXELS")]
    width: Option<usize>,
    /// Rows of a perspective [default: five eighths of the columns]
    #[arg(long, value_name = "PIXELS")]
    height: Option<usize>,
    /// Colours of the ground instead of the graph's own: satellite, clay, or the name of a ramp
    #[arg(long, value_name = "NAME", conflicts_with = "color")]
    palette: Option<String>,
    /// Compass direction the light comes from, and its height above the horizon, in degrees
    #[arg(long, value_name = "AZIMUTH,ALTITUDE", allow_hyphen_values = true)]
    sun: Option<String>,
    /// Factor on heights
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    exaggeration: f64,
    /// Depth of cast shadows, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    shadow: f64,
    /// Thickness of the air in a perspective [default: 1]
    #[arg(long, value_name = "FACTOR")]
    haze: Option<f64>,
    /// Exposure, in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_hyphen_values = true)]
    exposure: f64,
    /// Height of the water in metres, or `none` [default: the graph's sea level where the terrain reaches below it]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    water: Option<String>,
    /// Metres between contour lines on a map
    #[arg(long, value_name = "METRES")]
    contours: Option<f64>,
    /// Direction, downward pitch and field of view of the camera, in degrees
    #[arg(long, value_name = "AZIMUTH,PITCH,FOV", allow_hyphen_values = true)]
    camera: Option<String>,
    /// Metres from the camera to the point it looks at [default: far enough to see the whole]
    #[arg(long, value_name = "METRES")]
    distance: Option<f64>,
    /// The point the camera looks at, east, south and elevation in metres
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    look_at: Option<String>,
    /// What lies where the terrain ends: block or haze
    #[arg(long, value_name = "EDGE")]
    edge: Option<String>,
    /// Factor on the heights of a height file: metres a unit of one that does not say
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    height_scale: Option<f64>,
    /// Metres between the samples of a height file, whatever it says
    #[arg(long, value_name = "METRES", value_parser = parse_positive, allow_hyphen_values = true)]
    cell: Option<f64>,
    #[command(flatten)]
    read: height::ReadArgs,
    /// Draws over a file that holds heights
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    engine: EngineArgs,
    /// How progress is shown on standard error [default: a bar on a terminal]
    #[arg(long, value_enum)]
    progress: Option<Mode>,
}

/// Bytes for each sample that closing voids and drawing take beside the heights.
const DRAWING: u64 = 24;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ViewKind {
    /// From above, north up
    Map,
    /// From a camera
    Perspective,
}

/// The default palette of land.
const DEFAULT_PALETTE: &str = "satellite";
/// The input of kinds with colours that shades them.
const SHADE: &str = "shade";

/// The values to draw.
struct Subject {
    height: Field,
    color: Option<Colors>,
    sea_level: Option<f64>,
    /// Whether there are only colours and no heights.
    flat: bool,
}

pub(super) fn run(args: &Args, registry: &Registry, cancel: &Cancel) -> Result<Exit, Stop> {
    if !args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Err(Stop::usage(format!(
            "-o {}: a picture is written as PNG; end it in .png",
            args.out.display()
        )));
    }
    args.refuse()?;
    spare_heights(&args.out, args.overwrite)?;
    let cannot = |e| Stop::new(Exit::Failed, format!("cannot write {}: {e}", args.out.display()));
    crate::whole::probe(&args.out).map_err(cannot)?;
    let progress = Progress::new(args.progress);
    let subject = if is_graph(&args.graph.graph) {
        from_graph(args, registry, &progress, cancel)
    } else {
        spare_inputs(&args.out, std::slice::from_ref(&args.graph.graph))
            .and_then(|()| from_file(args, cancel))
    };
    let picture = subject.and_then(|s| draw(args, &s, cancel));
    progress.end();
    let png = picture?.to_png().map_err(|e| Stop::new(Exit::Failed, e))?;
    save(&args.out, &png)?;
    progress.news(&format!("wrote {}", args.out.display()));
    Ok(Exit::Done)
}

impl Args {
    /// Refuses options that would be ignored: those of the other view, those of graphs for a height file, and those of
    /// height files for a graph.
    fn refuse(&self) -> Result<(), Stop> {
        self.refuse_of_view()?;
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
            ("--color", self.color.is_some()),
            ("--size", self.grid.size.is_some()),
            ("--region", self.grid.region.is_some()),
            ("--cache", self.engine.cache.is_some()),
            ("--cache-size", self.engine.cache_size.is_some()),
            ("--time", self.engine.time.is_some()),
            ("--threads", self.engine.threads.is_some()),
        ]);
        self.graph.refuse("graphs", self.graph.given().chain(given))
    }

    /// Refuses options that the view would ignore.
    fn refuse_of_view(&self) -> Result<(), Stop> {
        match self.view {
            ViewKind::Map => {
                let given = heed::given([
                    ("--height", self.height.is_some()),
                    ("--haze", self.haze.is_some()),
                    ("--camera", self.camera.is_some()),
                    ("--distance", self.distance.is_some()),
                    ("--look-at", self.look_at.is_some()),
                    ("--edge", self.edge.is_some()),
                ]);
                heed::refuse(given, "a perspective, and a map is drawn; say --view perspective with it")
            }
            ViewKind::Perspective => {
                let given = heed::given([("--contours", self.contours.is_some())]);
                heed::refuse(given, "a map, and a perspective is drawn")
            }
        }
    }
}

fn from_graph(
    args: &Args,
    registry: &Registry,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Subject, Stop> {
    let Opened { graph, files, problems, .. } = open::open(&args.graph, registry)?;
    spare_inputs(&args.out, &open::inputs(&args.graph, &graph, &files))?;
    problems.iter().filter(|p| p.is_error()).for_each(|p| progress.say(&format!("error: {p}")));
    let (_, window) = args.grid.grids(graph.terrain())?;
    let wanted = |name: &String| want(&graph, name, window).map_err(|e| Stop::new(Exit::Graph, e));
    let named = |name: &String| chosen(&graph, std::slice::from_ref(name)).and_then(|_| wanted(name));
    let height = match &args.output {
        Some(name) => named(name)?,
        None => {
            let fields = chosen(&graph, &[])?.into_iter().filter_map(|name| wanted(&name).ok());
            let mut fields = fields.filter(|w| graph.wire_type(&w.source()) == Some(WireType::Field));
            fields.next().ok_or_else(|| Stop::usage("the graph has no output that is a field"))?
        }
    };
    let color = match &args.color {
        Some(name) => Some((name.clone(), named(name)?)),
        None => None,
    };
    let drawing = drawing([window.cols, window.rows], args)?;
    let reserve = reserve(&graph, &args.engine, None) + drawing.bytes;
    let engine = Engine::new(&Options { reserve, ..args.engine.options() }, files)?;
    let evaluated = |graph: &Graph, want: Want| {
        let evaluation = engine.evaluate(graph, &[want], progress, cancel)?;
        evaluation.notices.iter().for_each(|notice| progress.say(&format!("warning: {notice}")));
        for task in &evaluation.tasks {
            let named = |warning| format!("warning: node `{}`: {warning}", task.node);
            task.warnings.iter().map(named).for_each(|line| progress.say(&line));
        }
        let value = evaluation.values.into_iter().next();
        let value = value.ok_or_else(|| Stop::new(Exit::Failed, "the output gives nothing"))?;
        value.map_err(|f| Stop::new(Exit::of(&f), f))
    };
    let height = evaluated(&graph, height)?;
    let is_land = matches!(&height, Value::Field(f) if f.quantity() == Quantity::Elevation);
    // The colours of the graph are for land; a mask is drawn as it is.
    let own = || own_colors(&graph, window).filter(|_| is_land && args.palette.is_none());
    let color = match (color, own()) {
        (Some((name, want)), _) => Some((name, evaluated(&graph, want)?)),
        (None, Some((name, plain, want))) => {
            let given = evaluated(&plain, want);
            given.map(|value| Some((name, value))).or_else(|stop| without(stop, progress))?
        }
        (None, None) => None,
    };
    match &color {
        Some((name, _)) => {
            progress.news(&format!("coloured by the output `{name}`; --palette NAME draws other colours"))
        }
        None if is_land => {
            let palette = args.palette.as_deref().unwrap_or(DEFAULT_PALETTE);
            progress.news(&format!("coloured by the palette `{palette}`"));
        }
        None => (),
    }
    subject(graph.terrain().sea_level, height, color.map(|(_, value)| value))
}

/// The cost of drawing, with the memory of the values and of the colours of the graph.
fn drawing(grid: [usize; 2], args: &Args) -> Result<Cost, Stop> {
    let colored = args.color.is_some() || args.palette.is_none();
    Ok(match args.view {
        ViewKind::Map => map_cost(grid, map_width(args, grid[0]), colored),
        ViewKind::Perspective => perspective_cost(grid, &camera(args)?, colored),
    })
}

/// The width of a map: that of the option, or one pixel for each sample up to the width of a screen.
fn map_width(args: &Args, cols: usize) -> Option<usize> {
    args.width.or_else(|| (cols > 2048).then_some(2048))
}

/// The first output of a graph that is colours, with its want, and the graph without the shade of these colours, since
/// the picture has its own light.
fn own_colors(graph: &Graph, window: Grid) -> Option<(String, Graph, Want)> {
    let outputs = graph.outputs().filter_map(|(name, _)| Some((name, graph.output_source(name).ok()?)));
    let (name, source) = outputs.into_iter().find(|(_, s)| graph.wire_type(s) == Some(WireType::Colors))?;
    let mut plain = graph.clone();
    if graph.source(source.node, SHADE).is_some() {
        plain.disconnect(source.node, SHADE).ok()?;
    }
    Some((name.to_owned(), plain, Want { node: source.node, port: source.port, grid: window }))
}

/// Goes on without the colours of the graph where they fail; fails itself when the work is cancelled.
fn without<T>(stop: Stop, progress: &Progress) -> Result<Option<T>, Stop> {
    if matches!(stop.exit, Exit::Cancelled | Exit::Budget) {
        return Err(stop);
    }
    progress.say(&format!("warning: the graph's own colours are left out: {}", stop.message));
    Ok(None)
}

/// The values to draw, from the value of the first output and that of the colour output where there is one.
fn subject(sea: Option<f64>, first: Value, color: Option<Value>) -> Result<Subject, Stop> {
    let color = match color {
        Some(Value::Colors(c)) => Some(c),
        None => None,
        _ => return Err(Stop::usage("--color must name an output that is colours")),
    };
    match first {
        Value::Field(height) if height.quantity() == Quantity::Elevation => {
            // A terrain that is above the sea everywhere is drawn without water.
            let low = height.range().map_or(f64::MAX, |(lo, _)| f64::from(lo));
            Ok(Subject { height, color, sea_level: sea.filter(|sea| low < *sea), flat: false })
        }
        Value::Field(values) => Ok(flat(color.unwrap_or_else(|| greys(&values)))),
        Value::Colors(colors) => Ok(flat(color.unwrap_or(colors))),
        _ => Err(Stop::usage("--output must name an output that is a field or colours")),
    }
}

/// Colours without heights, to be drawn on a plain.
fn flat(color: Colors) -> Subject {
    let height = Field::constant(*color.grid(), Quantity::Elevation, 0.0);
    Subject { height, color: Some(color), sea_level: None, flat: true }
}

/// The greys of a field: masks from 0 to 1, other values from their lowest to their highest.
fn greys(values: &Field) -> Colors {
    let own = if values.quantity() == Quantity::Mask { Some((0.0, 1.0)) } else { values.range() };
    let (lo, hi) = own.filter(|(lo, hi)| hi > lo).unwrap_or((0.0, 1.0));
    let grey = |v: &f32| [((v - lo) / (hi - lo)).clamp(0.0, 1.0); 3];
    Colors::new(*values.grid(), Quantity::Color, values.data().iter().map(grey).collect())
}

fn from_file(args: &Args, cancel: &Cancel) -> Result<Subject, Stop> {
    let path: &Path = &args.graph.graph;
    let budget = args.engine.options().memory;
    let (height_scale, own_cell) = (args.height_scale, args.cell);
    let width = args.width.filter(|_| args.view == ViewKind::Map);
    let work = move |mut file: HeightFile| {
        file.origin.notes.iter().for_each(|n| tell(&format!("note: {n}")));
        fill_voids(file.cols, file.rows, &mut file.data);
        file = height::scaled(file, height_scale.unwrap_or(1.0), 0.0)?;
        if let Some(cell) = own_cell {
            file.placement.cell = Some([cell; 2]);
        }
        if !file.metres && height_scale.is_none() {
            tell("note: the file holds plain numbers; drawn as metres, --height-scale says otherwise");
        }
        Squared::of(file, width, &Limits::default()).map_err(Stop::usage)
    };
    let squared = height::read_with(path, &args.read.reading(path)?, budget, DRAWING, cancel, work)?;
    let cell = squared.cell.unwrap_or_else(|| {
        tell("note: the file does not say how far apart its samples are; drawn 1 m apart, --cell says otherwise");
        1.0
    });
    let intervals = (squared.cols.max(squared.rows) - 1).max(1) as u32;
    let lattice = Lattice { origin: [0.0, 0.0], span: cell * f64::from(intervals), intervals };
    let grid = Grid { lattice, col: 0, row: 0, cols: squared.cols, rows: squared.rows };
    let height = Field::new(grid, Quantity::Elevation, squared.data);
    Ok(Subject { height, color: None, sea_level: None, flat: false })
}

fn draw(args: &Args, subject: &Subject, cancel: &Cancel) -> Result<Picture, Stop> {
    let mut scene = Scene::new(&subject.height);
    scene.color = subject.color.as_ref();
    scene.sea_level = match args.water.as_deref() {
        None => subject.sea_level,
        Some("none") => None,
        Some(text) => Some(numbers::<1>("--water", text)?[0]),
    };
    if let Some(name) = &args.palette {
        scene.palette = GroundPalette::named(name).ok_or_else(|| {
            let names: Vec<_> = GroundPalette::names().collect();
            let hint = crate::params::did_you_mean(name, names.iter().copied());
            Stop::usage(format!("--palette must be one of {}, got `{name}`{hint}", names.join(", ")))
        })?;
    }
    if let Some(text) = &args.sun {
        let [azimuth, altitude] = numbers("--sun", text)?;
        scene.sun = Sun { azimuth, altitude };
    }
    scene.exaggeration = args.exaggeration;
    scene.shadow = args.shadow;
    scene.haze = args.haze.unwrap_or(scene.haze);
    scene.exposure = args.exposure;
    scene.contours = args.contours;
    if subject.flat {
        scene.sun.altitude = 90.0;
        scene.shadow = 0.0;
    }
    let watch = Work::new(cancel);
    let drawn = match args.view {
        ViewKind::Map => map(&scene, map_width(args, subject.height.grid().cols), &watch),
        ViewKind::Perspective => perspective(&scene, &camera(args)?, &watch),
    };
    drawn.map_err(|e| match e {
        crate::node::Error::Cancelled => Stop::new(Exit::Cancelled, e),
        crate::node::Error::Parameter { .. } => Stop::usage(e),
        _ => Stop::new(Exit::Failed, e),
    })
}

fn camera(args: &Args) -> Result<Camera, Stop> {
    let mut camera = Camera::default();
    camera.width = args.width.unwrap_or(camera.width);
    camera.height = args.height.unwrap_or(camera.width * 5 / 8);
    camera.distance = args.distance;
    if let Some(text) = &args.camera {
        let [azimuth, pitch, field_of_view] = numbers("--camera", text)?;
        camera = Camera { azimuth, pitch, field_of_view, ..camera };
    }
    camera.look_at = args.look_at.as_deref().map(|t| numbers("--look-at", t)).transpose()?;
    if let Some(name) = &args.edge {
        let edge = Edge::named(name);
        camera.edge =
            edge.ok_or_else(|| Stop::usage(format!("--edge must be block or haze, got `{name}`")))?;
    }
    Ok(camera)
}

/// Parses `N` numbers that are separated by commas.
fn numbers<const N: usize>(option: &str, text: &str) -> Result<[f64; N], Stop> {
    let parsed: Option<Vec<f64>> = text.split(',').map(|t| t.trim().parse().ok()).collect();
    let finite = parsed.filter(|v| v.iter().all(|x| x.is_finite()));
    finite
        .and_then(|v| v.try_into().ok())
        .ok_or_else(|| Stop::usage(format!("{option} takes {N} numbers separated by commas, got `{text}`")))
}
