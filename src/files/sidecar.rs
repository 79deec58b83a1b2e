//! Sidecars: JSON files beside files whose format cannot hold the place, the unit or the range of the samples.

use serde::{Deserialize, Serialize};

use super::epsg;
use super::height::HeightFile;
use super::place::{Affine, Anchor, Placement, Units};
use super::reading::{ByteOrder, RawSample, Reading};
use super::voids::strike;
use crate::value::Geo;

/// The content of a sidecar. Readers need at most `cols`, `rows` and `range`, and use each field that is present.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sidecar {
    /// Version of this description.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orograph: Option<u32>,
    /// The name of the file it describes, without folders.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// The format of the file it describes.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub format: String,
    /// Samples in a row.
    #[serde(alias = "width", skip_serializing_if = "Option::is_none")]
    pub cols: Option<u64>,
    /// Rows.
    #[serde(alias = "height", skip_serializing_if = "Option::is_none")]
    pub rows: Option<u64>,
    /// The quantity of the samples.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub quantity: String,
    /// The unit of the samples.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The values that the lowest and the highest integer stand for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// The value of a step of one, in sidecars of other programs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// The value of the number 0, in sidecars of other programs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// The type of the samples of a raw file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<RawSample>,
    /// Which byte of a sample of a raw file is the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_order: Option<ByteOrder>,
    /// The number in the file that marks a void.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodata: Option<f64>,
    /// The side of the terrain on which the first row lies.
    pub rows_from: FirstRow,
    /// Distance between samples, in metres, where it is the same both ways.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
    /// Distance from column to column and from row to row, in metres, where they differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<[f64; 2]>,
    /// Where the north-west sample stands in the terrain, in metres, x to the east and y to the south.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 2]>,
    /// Height of the water, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sea_level: Option<f64>,
    /// Projected coordinates of the north-west sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geo: Option<Geo>,
    /// The window of the whole terrain's grid that the file holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<FileWindow>,
    /// The tile of the build, where the file is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile: Option<super::write::Tile>,
    /// The hash of the graph from which the file was built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub graph_key: Option<String>,
    /// A note for the user about the companions of the file.
    #[serde(skip)]
    pub(super) note: Option<String>,
}

/// The side of the terrain on which the first row of a file lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FirstRow {
    /// Rows run from north to south.
    #[default]
    North,
    /// Rows run from south to north, as Unity reads them.
    South,
}

/// The window of the grid of the whole terrain that a file holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FileWindow {
    /// First column.
    pub col: i64,
    /// First row.
    pub row: i64,
    /// Columns of the whole terrain.
    pub whole_cols: usize,
    /// Rows of the whole terrain.
    pub whole_rows: usize,
}

/// The name of the sidecar of a file: `dir/name.json` beside `dir/name.r16`.
pub fn sidecar_name(file: &str) -> String {
    let stem = match file.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains(['/', '\\']) => stem,
        _ => file,
    };
    format!("{stem}.json")
}

impl Sidecar {
    /// The fault of the numbers, as a sentence without a subject.
    pub(super) fn fault(&self) -> Option<String> {
        if let Some([lo, hi]) = self.range
            && !(lo.is_finite() && hi.is_finite() && lo < hi)
        {
            return Some(format!("gives the range [{lo}, {hi}]; it must go upwards"));
        }
        let numbers = [self.scale, self.offset, self.geo.map(|g| g.east), self.geo.map(|g| g.north)];
        if numbers.into_iter().flatten().any(|v| !v.is_finite()) {
            return Some("gives numbers that are not finite".into());
        }
        let cells = self.cell.into_iter().chain(self.cells.into_iter().flatten());
        let bad = cells.into_iter().find(|c| !(c.is_finite() && *c > 0.0));
        bad.map(|cell| format!("gives a cell of {cell} m; it must be above 0"))
    }

    /// Steps from column to column and from row to row, in metres.
    pub(super) fn steps(&self) -> Option<[f64; 2]> {
        self.cells.or(self.cell.map(|c| [c, c]))
    }

    /// The sidecar with the steps of a file, as one number where both are the same.
    pub(super) fn with_steps(self, steps: Option<[f64; 2]>) -> Self {
        let square = steps.filter(|[x, y]| x == y).map(|[x, _]| x);
        Self { cell: square, cells: steps.filter(|_| square.is_none()), ..self }
    }

    /// The factor and the summand that turn integers into values, where the sidecar has a range or a scale.
    fn scaling(&self, [lowest, highest]: [f64; 2]) -> Option<(f64, f64)> {
        match self.range {
            Some([lo, hi]) => {
                let factor = (hi - lo) / (highest - lowest);
                Some((factor, lo - lowest * factor))
            }
            None if self.scale.is_some() || self.offset.is_some() => {
                Some((self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0)))
            }
            None => None,
        }
    }

    /// The length of the unit of the values in metres, with a note where this is not 1.
    fn unit(&self, notes: &mut Vec<String>) -> f64 {
        let unit = &self.unit;
        let mut unknown = Vec::new();
        let metres = epsg::unit_of("the sidecar", unit, &mut unknown);
        if let Some(metres) = metres.filter(|m| *m != 1.0) {
            notes.push(format!("the sidecar gives heights in \"{unit}\": they are {metres} m each"));
        }
        // Sidecars of this program may have shares or degrees, which are no lengths and need no note.
        if self.orograph.is_none() {
            notes.extend(unknown);
        }
        metres.unwrap_or(1.0)
    }

    /// Completes a file that was read by what the sidecar and the user say: its voids, the values of its integers, its
    /// place and its row order. `ends` are the lowest and the highest integer.
    pub(super) fn apply(&self, file: &mut HeightFile, ends: Option<[f64; 2]>, reading: &Reading) {
        file.origin.notes.extend(self.note.clone());
        let size = (Some(file.cols as u64), Some(file.rows as u64));
        let other_size = self.cols.is_some() && self.rows.is_some() && (self.cols, self.rows) != size;
        if other_size {
            let [cols, rows] = [self.cols, self.rows].map(Option::unwrap_or_default);
            let what = if self.orograph.is_some() { "its cell and place are" } else { "it is" };
            file.origin.notes.push(format!(
                "the sidecar speaks of {cols} x {rows} samples, the file has {} x {}: {what} not read",
                file.cols, file.rows
            ));
        }
        let believed = !other_size || self.orograph.is_some();
        let nodata = self.nodata.filter(|_| believed);
        file.origin.nodata = nodata.or(file.origin.nodata);
        for code in [nodata, reading.nodata] {
            strike(&mut file.data, code);
        }
        if !believed {
            return;
        }
        let unit = self.unit(&mut file.origin.notes);
        let scaling = ends.and_then(|e| self.scaling(e));
        if scaling.is_some() || unit != 1.0 {
            let (factor, summand) = scaling.unwrap_or((1.0, 0.0));
            for v in &mut file.data {
                *v = ((f64::from(*v) * factor + summand) * unit) as f32;
            }
            file.metres = true;
            file.origin.plain = false;
            file.origin.range = self.range.map(|ends| ends.map(|v| v * unit));
        }
        if self.rows_from == FirstRow::South {
            file.flip();
            file.origin.turned = true;
        }
        if let Some(step) = self.steps().filter(|_| !other_size) {
            file.placement = match self.geo {
                Some(Geo { epsg, east, north }) => {
                    let affine = Affine::upright([east, north], step);
                    let units = Units::of_epsg(epsg).unwrap_or(Units::Length(1.0));
                    Placement::new(affine, Anchor::Point, Some(epsg), units, [file.cols, file.rows])
                }
                None => Placement::of_cell(step),
            };
        }
    }
}
