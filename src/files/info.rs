//! What a height file is, for people and programs.

use std::fmt;

use serde::Serialize;

use super::error::ReadError;
use super::fit::Fit;
use super::height::{HeightFile, Limits, read_height};
use super::place::{Anchor, Units};
use crate::text::printable;

/// What `orograph info FILE` tells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// The file.
    pub file: String,
    /// The format.
    pub format: &'static str,
    /// The type of its samples.
    pub sample: &'static str,
    /// Bands or channels.
    pub bands: usize,
    /// Samples in a row.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Whether heights are metres by the file's word, or plain numbers.
    pub metres: bool,
    /// Lowest and highest height; none where all are void.
    pub range: Option<[f32; 2]>,
    /// Number of voids.
    pub voids: usize,
    /// The number that marks a void.
    pub nodata: Option<f64>,
    /// Steps on the ground, in metres.
    pub cell: Option<[f64; 2]>,
    /// Extent from the first to the last sample on the ground, in metres.
    pub extent: Option<[f64; 2]>,
    /// The terrain that the file fits, with a base grid near that of a new terrain.
    pub fit: Option<Fit>,
    /// EPSG code of the coordinates.
    pub epsg: Option<u32>,
    /// `metres`, `degrees`, `web mercator`, or another unit of length.
    pub units: Option<String>,
    /// Coordinates of the north-west sample.
    pub north_west: Option<[f64; 2]>,
    /// Coordinates of the south-east sample.
    pub south_east: Option<[f64; 2]>,
    /// `area` or `point`: what a sample stands for.
    pub anchor: &'static str,
    /// What a person should know about the reading.
    pub notes: Vec<String>,
}

/// Reads a height file and tells what it is.
///
/// # Errors
/// Those of [`read_height`].
pub fn info(name: &str, bytes: &[u8], sidecar: Option<&[u8]>, limits: &Limits) -> Result<Info, ReadError> {
    read_height(name, bytes, sidecar, limits).map(|f| Info::of(name, &f))
}

impl Info {
    /// What a file is that was read.
    pub fn of(name: &str, file: &HeightFile) -> Self {
        let HeightFile { cols, rows, placement, origin, .. } = file;
        let corner = |i: usize, j: usize| placement.affine.map(|a| a.at(i as f64, j as f64));
        let units = placement.affine.map(|_| match placement.units {
            Units::Degrees => "degrees".to_owned(),
            Units::WebMercator => "web mercator".to_owned(),
            Units::Length(1.0) => "metres".to_owned(),
            Units::Length(size) => format!("{size} m"),
        });
        Self {
            file: name.to_owned(),
            format: origin.format.name,
            sample: origin.sample,
            bands: origin.bands,
            cols: *cols,
            rows: *rows,
            metres: file.metres,
            range: file.range(),
            voids: file.voids(),
            nodata: origin.nodata,
            cell: placement.cell,
            extent: placement.extent(*cols, *rows),
            fit: placement.extent(*cols, *rows).and_then(|extent| Fit::of(extent, BASE).ok()),
            epsg: placement.epsg,
            units,
            north_west: corner(0, 0),
            south_east: corner(cols - 1, rows - 1),
            anchor: if placement.anchor == Anchor::Point { "point" } else { "area" },
            notes: origin.notes.clone(),
        }
    }

    /// The same as JSON.
    pub fn to_json(&self) -> serde_json::Value {
        // A struct of numbers and texts turns into JSON without fail.
        serde_json::to_value(self).unwrap_or_default()
    }
}

/// Samples along the longer side of the base grid that a terrain has where nobody says.
const BASE: u32 = 1025;

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, format, sample, cols, rows, .. } = self;
        writeln!(f, "{}: {format}, {cols} x {rows} samples of {sample}", printable(file))?;
        let unit = if self.metres { " m" } else { " (plain numbers: give a scale to make metres of them)" };
        match self.range {
            Some([lo, hi]) => writeln!(f, "  heights   {lo} to {hi}{unit}")?,
            None => writeln!(f, "  heights   none, all are void")?,
        }
        if self.voids > 0 {
            let share = 100.0 * self.voids as f64 / (*cols as f64 * *rows as f64);
            writeln!(f, "  voids     {} ({share:.2} %)", self.voids)?;
        }
        match (self.cell, self.extent) {
            (Some([dx, dy]), Some([x, y])) => {
                writeln!(f, "  cell      {dx:.4} x {dy:.4} m on the ground")?;
                writeln!(f, "  extent    {x:.1} x {y:.1} m")?;
                if let Some(Fit { width, depth, base, .. }) = self.fit {
                    let set =
                        format!("--set terrain.width={width} --set terrain.depth={depth} --base {base}");
                    writeln!(f, "  terrain   {set}")?;
                }
                if let Some(loss) = self.fit.and_then(|fit| fit.loss()) {
                    writeln!(f, "            {loss}; place it at true size, or let `orograph fit` do it")?;
                }
            }
            _ => writeln!(f, "  cell      not known")?,
        }
        if let (Some(units), Some(nw), Some(se)) = (&self.units, self.north_west, self.south_east) {
            let epsg = self.epsg.map_or("no EPSG code".to_owned(), |e| format!("EPSG:{e}"));
            writeln!(f, "  lies at   {epsg}, {units}, {}, {} to {}, {}", nw[0], nw[1], se[0], se[1])?;
            writeln!(
                f,
                "  a sample  stands for {}",
                if self.anchor == "point" { "a point" } else { "an area" }
            )?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "  note      {}", printable(note)))
    }
}
