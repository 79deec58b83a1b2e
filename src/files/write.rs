//! Writing of files: values of a graph, and files that were read.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::codec::Format;
use super::error::WriteError;
use super::height::HeightFile;
use super::place::{Affine, Anchor, Placement, Units};
use super::sheet::{Sheet, Sink, unfit};
use super::sidecar::{FileWindow, Sidecar};
use super::target::Target;
use crate::value::{Geo, Grid, Quantity, Terrain, Value};
use crate::work::Work;

/// The place of a file among the tiles of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Tile {
    /// Column of the tile, from 0 in the west.
    pub col: u32,
    /// Row of the tile, from 0 in the north.
    pub row: u32,
    /// Number of tiles from west to east.
    pub cols: u32,
    /// Number of tiles from north to south.
    pub rows: u32,
}

/// The options with which a file is written.
#[derive(Clone, Copy)]
pub struct Writing<'a> {
    /// The name of the file, for its sidecar.
    pub file: &'a str,
    /// The format of the file.
    pub format: Format,
    /// The values that the lowest and highest integer stand for, one range for the whole terrain. Needed where the
    /// format holds integers and the quantity has no range of its own, as masks, directions and slopes have. A file
    /// that was read keeps whole numbers without one, and takes the range of its heights for others.
    pub range: Option<[f64; 2]>,
    /// Whether values outside the range may be clipped.
    pub clip: bool,
    /// Whether the southernmost row comes first.
    pub flip: bool,
    /// The engine the file is meant for.
    pub target: Option<Target>,
    /// Progress, cancellation and warnings.
    pub work: Work<'a>,
}

impl From<Format> for Writing<'_> {
    fn from(format: Format) -> Self {
        Self { file: "", format, range: None, clip: false, flip: false, target: None, work: Work::default() }
    }
}

/// A value to write.
#[derive(Clone, Copy)]
pub struct WriteJob<'a> {
    /// The value.
    pub value: &'a Value,
    /// The world the value is from.
    pub terrain: &'a Terrain,
    /// The grid of the whole terrain at this size.
    pub whole: Grid,
    /// The tile of the build, in a build of tiles.
    pub tile: Option<Tile>,
    /// The hash of the graph, for the sidecar.
    pub graph_key: Option<&'a str>,
    /// The options of the file.
    pub writing: Writing<'a>,
}

impl<'a> WriteJob<'a> {
    /// A job for the whole terrain.
    pub fn new(value: &'a Value, writing: impl Into<Writing<'a>>, terrain: &'a Terrain, whole: Grid) -> Self {
        Self { value, terrain, whole, tile: None, graph_key: None, writing: writing.into() }
    }
}

/// What a writer returns about a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// The content of the sidecar, where the format needs one.
    pub sidecar: Option<Json>,
    /// Notes for the user, such as the numbers to type into a game engine, or a size that it does not accept.
    pub notes: Vec<String>,
    /// The number of values that were clipped.
    pub clipped: u64,
    /// The values that the lowest and highest integer stand for.
    pub range: Option<[f64; 2]>,
}

/// Writes a value of a graph.
///
/// # Errors
/// Fails when the format cannot hold the value, values are outside the range, or writing fails.
pub fn encode(job: &WriteJob<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    let WriteJob { value, terrain, whole, .. } = *job;
    let Some((grid, quantity)) = value.grid().zip(value.quantity()) else {
        return Err(unfit(
            job.writing.format,
            value.wire_type().name(),
            "fields, vectors and colours can be written",
        ));
    };
    let bounds = grid.bounds();
    let [x, y] = bounds.min;
    let corner = |g: Geo| [g.east + (x - terrain.origin[0]), g.north - (y - terrain.origin[1])];
    let geo = terrain.geo.map(|g| {
        let [east, north] = corner(g);
        Geo { epsg: g.epsg, east, north }
    });
    // Without a place on Earth the coordinates are those of the terrain in metres, with y to the north.
    let origin = geo.map_or([x, 0.0 - y], |g| [g.east, g.north]);
    let step = [grid.cell(), grid.cell()];
    let placement = Placement {
        affine: Some(Affine::upright(origin, step)),
        anchor: Anchor::Point,
        epsg: geo.map(|g| g.epsg),
        units: Units::Length(1.0),
        cell: Some(step),
    };
    let window = FileWindow { col: grid.col, row: grid.row, whole_cols: whole.cols, whole_rows: whole.rows };
    let sidecar = Sidecar {
        position: Some([x, y]),
        sea_level: terrain.sea_level,
        geo,
        grid: Some(window),
        tile: job.tile,
        graph_key: job.graph_key.map(str::to_owned),
        ..Sidecar::default()
    };
    Sheet {
        cols: grid.cols,
        rows: grid.rows,
        channels: value.wire_type().channels(),
        samples: value.components(),
        quantity,
        placement,
        nodata: None,
        sidecar,
        writing: job.writing,
    }
    .write(out)
}

/// Writes a file that was read in another format: place, EPSG code, what a sample stands for and nodata are kept
/// where the format can hold them.
///
/// # Errors
/// Returns the errors of [`encode`].
pub fn encode_file(
    file: &HeightFile,
    writing: &Writing<'_>,
    out: &mut dyn Sink,
) -> Result<Written, WriteError> {
    let placement = file.placement;
    let metres = placement.units == Units::Length(1.0);
    let geo = placement.affine.filter(|a| metres && a.is_upright()).zip(placement.epsg);
    let geo = geo.map(|(a, epsg)| Geo { epsg, east: a.origin[0], north: a.origin[1] });
    let lost = lost_place(&placement, writing.format, geo.is_some());
    let mut written = Sheet {
        cols: file.cols,
        rows: file.rows,
        channels: 1,
        samples: &file.data,
        quantity: if file.metres { Quantity::Elevation } else { Quantity::Number },
        // Formats with coordinates store the cell in these.
        placement: Placement { affine: placement.affine.or(local_affine(file)), ..placement },
        nodata: file.origin.nodata,
        sidecar: Sidecar { geo, ..Sidecar::default() },
        writing: Writing { range: writing.range.or_else(|| range_of_file(file, writing)), ..*writing },
    }
    .write(out)?;
    written.notes.extend(lost);
    Ok(written)
}

/// The note about a placement that a format cannot store, as a sentence. Sidecars can store places in metres of a
/// coordinate system with a code; `kept` says whether the placement is one.
fn lost_place(placement: &Placement, format: Format, kept: bool) -> Option<String> {
    // TIFF and Esri grids store coordinates themselves, and their writers have notes about what they cannot store.
    if kept || matches!(format, Format::Tiff | Format::Tiff16 | Format::Asc) {
        return None;
    }
    let affine = placement.affine?;
    let why = match placement.units {
        Units::Degrees => "in degrees".to_owned(),
        Units::WebMercator => "in web Mercator".to_owned(),
        Units::Length(_) if !affine.is_upright() => "turned".to_owned(),
        Units::Length(1.0) => "in a system without an EPSG code".to_owned(),
        Units::Length(metres) => format!("in units of {metres} m"),
    };
    Some(format!(
        "the place of the file is lost: a sidecar holds one that is upright, in metres and in a system with an EPSG code, \
         and this one is {why}"
    ))
}

/// Coordinates from the south-west sample, where nothing but the cell is known.
fn local_affine(file: &HeightFile) -> Option<Affine> {
    let step = file.placement.cell?;
    Some(Affine::upright([0.0, step[1] * (file.rows - 1) as f64], step))
}

/// The range for a file that is written in integers, where none is asked for.
fn range_of_file(file: &HeightFile, writing: &Writing<'_>) -> Option<[f64; 2]> {
    let levels = writing.format.levels()?;
    let [lo, hi] = file.range().unwrap_or([0.0, 0.0]).map(f64::from);
    if let Some(target) = writing.target {
        return Some(target.range([lo, hi]));
    }
    let whole = file.origin.plain && !file.origin.sample.starts_with('f');
    let whole = whole && file.data.par_iter().all(|v| v.is_nan() || v.fract() == 0.0);
    if whole && writing.format == Format::Tiff16 && lo < 0.0 && (lo > -32768.0 && hi <= 32767.0) {
        return None;
    }
    if whole && hi - lo.min(0.0) <= levels {
        return Some(if lo < 0.0 { [lo, lo + levels] } else { [0.0, levels] });
    }
    let stated = file.origin.range.filter(|r| r[0] <= lo && hi <= r[1]);
    stated.or(Some([lo, if hi > lo { hi } else { lo + 1.0 }]))
}
