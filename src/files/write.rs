//! Values of a graph, and files that were read, as files.

use std::io::{Seek, Write};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::bands::{self, Band, Split, Watch};
use super::error::WriteError;
use super::format::Format;
use super::height::HeightFile;
use super::place::{Affine, Anchor, Placement, Units};
use super::quantize::Quantizer;
use super::sidecar::{Side, Sidecar, Window};
use super::target::{Target, target_warnings};
use super::{asc, exr, png, tiff};
use crate::node::Cancel;
use crate::value::{Geo, Grid, Quantity, Terrain, Value};

/// Which tile of a build a file is.
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

/// A value to write.
#[derive(Clone, Copy)]
pub struct WriteJob<'a> {
    /// The value.
    pub value: &'a Value,
    /// The format of the file.
    pub format: Format,
    /// The values that the lowest and highest integer stand for, one range for the whole terrain. Needed where the
    /// format holds integers and the quantity has no range of its own, as masks, directions and slopes have.
    pub range: Option<[f64; 2]>,
    /// Whether values outside the range may be clipped.
    pub clip: bool,
    /// Whether the southernmost row comes first.
    pub flip: bool,
    /// The world the value is from.
    pub terrain: &'a Terrain,
    /// The grid of the whole terrain at this size.
    pub whole: Grid,
    /// Which tile it is, in a build of tiles.
    pub tile: Option<Tile>,
    /// The engine the file is meant for.
    pub target: Option<Target>,
    /// Stops the writing.
    pub cancel: Option<&'a Cancel>,
    /// Told the finished share.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
}

impl<'a> WriteJob<'a> {
    /// A job without range, tile or target.
    pub fn new(value: &'a Value, format: Format, terrain: &'a Terrain, whole: Grid) -> Self {
        let (range, clip, flip, tile, target) = (None, false, false, None, None);
        Self { value, format, range, clip, flip, terrain, whole, tile, target, cancel: None, progress: None }
    }
}

/// A file to write in another format.
#[derive(Clone, Copy)]
pub struct FileJob<'a> {
    /// The file as it was read; its place and its nodata are kept where the format can hold them.
    pub file: &'a HeightFile,
    /// The format to write.
    pub format: Format,
    /// As in [`WriteJob`]; without one whole numbers stay as they are, and others take the range of the file.
    pub range: Option<[f64; 2]>,
    /// Whether values outside the range may be clipped.
    pub clip: bool,
    /// Whether the southernmost row comes first.
    pub flip: bool,
    /// The engine the file is meant for.
    pub target: Option<Target>,
    /// Stops the writing.
    pub cancel: Option<&'a Cancel>,
    /// Told the finished share.
    pub progress: Option<&'a (dyn Fn(f32) + Sync)>,
}

impl<'a> FileJob<'a> {
    /// A job without range or target.
    pub fn new(file: &'a HeightFile, format: Format) -> Self {
        let (range, clip, flip, target) = (None, false, false, None);
        Self { file, format, range, clip, flip, target, cancel: None, progress: None }
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// What goes into the JSON file of the same name, where the format needs one.
    pub sidecar: Option<Json>,
    /// What a person should know: the numbers to type into an engine, a size it will not take.
    pub notes: Vec<String>,
    /// How many values were clipped.
    pub clipped: u64,
    /// The values that the lowest and highest integer stand for.
    pub range: Option<[f64; 2]>,
}

/// Writes a value of a graph.
///
/// # Errors
/// When the format cannot hold the value, its values lie outside the range, or the disk refuses.
pub fn encode(job: &WriteJob<'_>, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
    let WriteJob { value, terrain, whole, .. } = *job;
    let Some((grid, quantity)) = value.grid().zip(value.quantity()) else {
        return Err(unfit(
            job.format,
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
    // Without a place on Earth the terrain's own metres will do, y turned to the north.
    let origin = geo.map_or([x, 0.0 - y], |g| [g.east, g.north]);
    let step = [grid.cell(), grid.cell()];
    let placement = Placement {
        affine: Some(Affine::upright(origin, step)),
        anchor: Anchor::Point,
        epsg: geo.map(|g| g.epsg),
        units: Units::Length(1.0),
        cell: Some(step),
    };
    let window = Window { col: grid.col, row: grid.row, whole_cols: whole.cols, whole_rows: whole.rows };
    let sidecar = Sidecar {
        position: Some([x, y]),
        sea_level: Some(terrain.sea_level),
        geo,
        grid: Some(window),
        tile: job.tile,
        ..Sidecar::default()
    };
    Sheet {
        cols: grid.cols,
        rows: grid.rows,
        channels: (value.wire_type().sample_bytes() / 4) as usize,
        samples: value.components(),
        quantity,
        placement,
        nodata: None,
        sidecar,
        range: job.range,
        clip: job.clip,
        flip: job.flip,
        target: job.target,
        watch: Watch { cancel: job.cancel, progress: job.progress },
    }
    .write(job.format, out)
}

/// Writes a file that was read in another format: place, EPSG code, what a sample stands for and nodata are kept
/// where the format can hold them.
///
/// # Errors
/// As [`encode`].
pub fn encode_file(job: &FileJob<'_>, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
    let file = job.file;
    let placement = file.placement;
    let metres = placement.units == Units::Length(1.0);
    let geo = placement.affine.filter(|a| metres && a.is_upright()).zip(placement.epsg);
    let geo = geo.map(|(a, epsg)| Geo { epsg, east: a.origin[0], north: a.origin[1] });
    Sheet {
        cols: file.cols,
        rows: file.rows,
        channels: 1,
        samples: &file.data,
        quantity: if file.metres { Quantity::Elevation } else { Quantity::Number },
        placement,
        nodata: file.origin.nodata,
        sidecar: Sidecar { geo, ..Sidecar::default() },
        range: job.range.or_else(|| range_of_file(job)),
        clip: job.clip,
        flip: job.flip,
        target: job.target,
        watch: Watch { cancel: job.cancel, progress: job.progress },
    }
    .write(job.format, out)
}

/// The range for a file that is written in integers, where none is asked for.
fn range_of_file(job: &FileJob<'_>) -> Option<[f64; 2]> {
    let file = job.file;
    let levels = job.format.levels()?;
    let [lo, hi] = file.range().unwrap_or([0.0, 0.0]).map(f64::from);
    if let Some(target) = job.target {
        return Some(target.range([lo, hi]));
    }
    let whole = file.origin.plain && !file.origin.sample.starts_with('f');
    let whole = whole && file.data.par_iter().all(|v| v.is_nan() || v.fract() == 0.0);
    if whole && job.format == Format::Tiff16 && lo < 0.0 && (lo > -32768.0 && hi <= 32767.0) {
        return None;
    }
    if whole && hi - lo.min(0.0) <= levels {
        return Some(if lo < 0.0 { [lo, lo + levels] } else { [0.0, levels] });
    }
    let stated = file.origin.range.filter(|r| r[0] <= lo && hi <= r[1]);
    stated.or(Some([lo, if hi > lo { hi } else { lo + 1.0 }]))
}

/// Samples on the way into a file.
struct Sheet<'a> {
    cols: usize,
    rows: usize,
    channels: usize,
    samples: &'a [f32],
    quantity: Quantity,
    placement: Placement,
    nodata: Option<f64>,
    sidecar: Sidecar,
    range: Option<[f64; 2]>,
    clip: bool,
    flip: bool,
    target: Option<Target>,
    watch: Watch<'a>,
}

impl Sheet<'_> {
    fn write(&self, format: Format, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
        if self.cols == 0 || self.rows == 0 {
            return Err(unfit(format, "no samples at all", "ask for a size of at least 1 x 1"));
        }
        if !format.takes(self.channels) {
            let what = format!("{} numbers a sample", self.channels);
            return Err(unfit(format, &what, "exr and tiff can"));
        }
        if self.flip && matches!(format, Format::Tiff | Format::Tiff16 | Format::Asc) {
            return Err(unfit(format, "rows from south to north", "png16, r16, r32 and exr can"));
        }
        let mut written = match format {
            Format::Png8 => self.png(format, 1, out)?,
            Format::Png16 => self.png(format, 2, out)?,
            Format::Tiff => self.tiff(out)?,
            Format::Tiff16 => self.tiff16(out)?,
            Format::Exr => self.exr(out)?,
            Format::R16 => self.r16(out)?,
            Format::R32 => self.r32(out)?,
            Format::Asc => self.asc(out)?,
        };
        if format.has_sidecar(self.channels) {
            let sidecar = self.sidecar(format, written.range);
            // A struct of numbers and names turns into JSON without fail.
            written.sidecar = Some(serde_json::to_value(sidecar).unwrap_or_default());
        }
        if let Some(target) = self.target {
            let cell = self.placement.cell.map_or(1.0, |[x, _]| x);
            written.notes.extend(target_warnings(target, format, self.cols, self.rows));
            written.notes.extend(target.notes(written.range, cell, [self.cols, self.rows]));
        }
        Ok(written)
    }

    fn sidecar(&self, format: Format, range: Option<[f64; 2]>) -> Sidecar {
        Sidecar {
            orograph: Some(1),
            format: format.name().into(),
            cols: Some(self.cols as u64),
            rows: Some(self.rows as u64),
            quantity: self.quantity.name().into(),
            unit: self.quantity.unit().into(),
            range,
            rows_from: if self.flip { Side::South } else { Side::North },
            cell: self.placement.cell.map(|[x, _]| x),
            ..self.sidecar
        }
    }

    /// The samples of a row of the file.
    fn row(&self, j: usize) -> &[f32] {
        let j = if self.flip { self.rows - 1 - j } else { j };
        let line = self.cols * self.channels;
        &self.samples[j * line..][..line]
    }

    fn has_voids(&self) -> bool {
        self.samples.par_chunks(1 << 16).any(|c| c.iter().any(|v| v.is_nan()))
    }

    fn no_voids(&self, format: Format) -> Result<(), WriteError> {
        let instead = "fill them, or write tiff, exr, r32 or asc";
        if self.has_voids() { Err(unfit(format, "voids", instead)) } else { Ok(()) }
    }

    /// The range that was asked for, or that of the quantity.
    fn own_range(&self) -> Option<[f64; 2]> {
        match self.quantity {
            Quantity::Color => Some([0.0, 1.0]),
            Quantity::Mask => self.range.or(Some([0.0, 1.0])),
            Quantity::Direction => self.range.or(Some([0.0, 360.0])),
            Quantity::Slope => self.range.or(Some([0.0, 90.0])),
            _ => self.range,
        }
    }

    /// Integers for the samples, all of them checked, and how many are clipped.
    fn quantizer(&self, format: Format) -> Result<(Quantizer, Written), WriteError> {
        let unit = if self.quantity.unit() == "1" { "value" } else { self.quantity.unit() };
        let range = self.own_range().ok_or(WriteError::NoRange { format: format.name(), unit })?;
        let q = Quantizer::new(range, format.levels().unwrap_or(65535.0))?;
        let clipped = q.check(self.samples, self.clip)?;
        Ok((q, Written { clipped, range: Some(range), ..Written::default() }))
    }

    fn png(&self, format: Format, bytes: usize, out: &mut impl Write) -> Result<Written, WriteError> {
        self.no_voids(format)?;
        let (q, written) = self.quantizer(format)?;
        let header = png::Header { cols: self.cols, rows: self.rows, channels: self.channels, bytes };
        png::write(out, header, &self.watch, |j, line| {
            let row = self.row(j);
            match bytes {
                1 => line.iter_mut().zip(row).for_each(|(o, v)| *o = q.level(*v) as u8),
                _ => {
                    let (words, _) = line.as_chunks_mut::<2>();
                    words.iter_mut().zip(row).for_each(|(o, v)| *o = (q.level(*v) as u16).to_be_bytes());
                }
            }
        })?;
        Ok(written)
    }

    fn r16(&self, out: &mut impl Write) -> Result<Written, WriteError> {
        self.no_voids(Format::R16)?;
        let (q, written) = self.quantizer(Format::R16)?;
        self.raw(out, 2, |row, line| little_words(line, row, |v| q.level(v) as u16))?;
        Ok(written)
    }

    fn r32(&self, out: &mut impl Write) -> Result<Written, WriteError> {
        self.raw(out, 4, |row, line| floats(line, row, f32::NAN))?;
        Ok(Written::default())
    }

    fn raw(
        &self,
        out: &mut impl Write,
        bytes: usize,
        fill: impl Fn(&[f32], &mut [u8]) + Sync,
    ) -> Result<(), WriteError> {
        let line = self.cols * bytes;
        let make = |band: Band| {
            let mut block = vec![0; band.rows * line];
            for (j, line) in block.chunks_exact_mut(line).enumerate() {
                fill(self.row(band.first_row + j), line);
            }
            block
        };
        bands::in_order(&Split::new(self.rows, line), &self.watch, make, |_, block| out.write_all(&block))
    }

    fn tiff(&self, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
        let nodata = match self.nodata {
            Some(v) if (v as f32).is_finite() => Some(f64::from(v as f32)),
            _ => self.has_voids().then_some(f64::NAN),
        };
        let fill = nodata.map_or(f32::NAN, |v| v as f32);
        let layout = self.layout(tiff::Kind::F32, nodata, None);
        tiff::write(out, &layout, &self.watch, |j, line| floats(line, self.row(j), fill))?;
        Ok(Written::default())
    }

    /// 16-bit integers: of a range where there is one, whole metres with a sign where there is none.
    fn tiff16(&self, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
        if self.own_range().is_none() {
            return self.tiff_metres(out);
        }
        let (q, written) = self.quantizer(Format::Tiff16)?;
        let scaling =
            written.range.map(|[lo, _]| (q.step(), lo)).filter(|_| self.quantity != Quantity::Color);
        let plain = scaling == Some((1.0, 0.0));
        let code = self.nodata.filter(|v| plain && v.fract() == 0.0 && (0.0..=65535.0).contains(v));
        if code.is_none() {
            self.no_voids(Format::Tiff16)?;
        }
        let layout = self.layout(tiff::Kind::U16, code, scaling);
        let void = code.unwrap_or(0.0) as u16;
        let of = |v: f32| if v.is_nan() { void } else { q.level(v) as u16 };
        tiff::write(out, &layout, &self.watch, |j, line| little_words(line, self.row(j), of))?;
        Ok(written)
    }

    fn tiff_metres(&self, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
        // The lowest number is left to mark voids.
        let q = Quantizer::new([-32767.0, 32767.0], 65534.0)?;
        let clipped = q.check(self.samples, self.clip)?;
        let mut written = Written { clipped, ..Written::default() };
        if self.samples.par_iter().any(|v| v.fract() != 0.0 && !v.is_nan()) {
            written
                .notes
                .push("tiff16 without a range holds whole metres; give a range for finer steps".into());
        }
        let voids = self.nodata.is_some() || self.has_voids();
        let layout = self.layout(tiff::Kind::I16, voids.then_some(-32768.0), None);
        let of = |v: f32| if v.is_nan() { i16::MIN as u16 } else { (q.level(v) - 32767) as i16 as u16 };
        tiff::write(out, &layout, &self.watch, |j, line| little_words(line, self.row(j), of))?;
        Ok(written)
    }

    fn layout(&self, kind: tiff::Kind, nodata: Option<f64>, scaling: Option<(f64, f64)>) -> tiff::Layout<'_> {
        let Self { cols, rows, channels: bands, ref placement, .. } = *self;
        tiff::Layout { cols, rows, bands, kind, placement, nodata, scaling }
    }

    fn exr(&self, out: &mut (impl Write + Seek)) -> Result<Written, WriteError> {
        // Channels stand in alphabetical order.
        let (names, order): (&[&str], &[usize]) = match self.channels {
            1 => (&["Y"], &[0]),
            2 => (&["G", "R"], &[1, 0]),
            _ => (&["B", "G", "R"], &[2, 1, 0]),
        };
        let linear = self.quantity == Quantity::Color;
        exr::write(out, [self.cols, self.rows], names, &self.watch, |j, line| {
            let row = self.row(j);
            for (&channel, line) in order.iter().zip(line.chunks_exact_mut(self.cols * 4)) {
                let (floats, _) = line.as_chunks_mut::<4>();
                let values = row.iter().skip(channel).step_by(self.channels);
                for (o, &v) in floats.iter_mut().zip(values) {
                    *o = (if linear { linear_light(v) } else { v }).to_le_bytes();
                }
            }
        })?;
        Ok(Written::default())
    }

    fn asc(&self, out: &mut impl Write) -> Result<Written, WriteError> {
        let upright =
            self.placement.affine.is_none_or(|a| a.is_upright() && a.col[0] > 0.0 && a.row[1] < 0.0);
        if !upright {
            return Err(unfit(Format::Asc, "a grid that is turned", "tiff can"));
        }
        let nodata = match self.nodata {
            Some(v) if v.is_finite() => Some(v),
            _ => self.has_voids().then_some(-9999.0),
        };
        let void = nodata.unwrap_or(-9999.0);
        out.write_all(asc::header([self.cols, self.rows], &self.placement, nodata).as_bytes())?;
        let make = |band: Band| {
            let mut text = Vec::with_capacity(band.rows * self.cols * 9);
            (band.first_row..band.first_row + band.rows)
                .for_each(|j| asc::append_row(self.row(j), void, &mut text));
            text
        };
        bands::in_order(&Split::new(self.rows, self.cols * 9), &self.watch, make, |_, text| {
            out.write_all(&text)
        })?;
        let lost = self.placement.epsg.map(|epsg| format!("an .asc cannot say that it lies in EPSG:{epsg}"));
        Ok(Written { notes: lost.into_iter().collect(), ..Written::default() })
    }
}

fn unfit(format: Format, what: &str, instead: &'static str) -> WriteError {
    WriteError::Unfit { format: format.name(), what: what.into(), instead }
}

fn little_words(line: &mut [u8], row: &[f32], of: impl Fn(f32) -> u16) {
    let (words, _) = line.as_chunks_mut::<2>();
    words.iter_mut().zip(row).for_each(|(o, v)| *o = of(*v).to_le_bytes());
}

fn floats(line: &mut [u8], row: &[f32], void: f32) {
    let (words, _) = line.as_chunks_mut::<4>();
    words.iter_mut().zip(row).for_each(|(o, &v)| *o = (if v.is_nan() { void } else { v }).to_le_bytes());
}

/// Light of an sRGB encoded number (IEC 61966-2-1): what OpenEXR holds.
fn linear_light(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { libm::powf((v + 0.055) / 1.055, 2.4) }
}
