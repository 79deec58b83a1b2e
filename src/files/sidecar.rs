//! The JSON file beside a file that cannot say what its numbers mean.

use serde::{Deserialize, Serialize};

use super::error::Fault;
use super::height::HeightFile;
use super::place::{Affine, Anchor, Placement, Units};
use crate::value::Geo;

/// Longest sidecar that is read, in bytes.
const LONGEST: usize = 1 << 20;

/// What a sidecar says. Readers need `cols`, `rows` and `range` at most, and take each where it is there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sidecar {
    /// Version of this description.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orograph: Option<u32>,
    /// The format of the file it describes.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub format: String,
    /// Samples in a row.
    #[serde(alias = "width", skip_serializing_if = "Option::is_none")]
    pub cols: Option<u64>,
    /// Rows.
    #[serde(alias = "height", skip_serializing_if = "Option::is_none")]
    pub rows: Option<u64>,
    /// What the numbers mean.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub quantity: String,
    /// Their unit.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The values that the lowest and the highest integer stand for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Value of a step of one, in files by other hands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Value of the number 0, in files by other hands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Which row is the first.
    pub rows_from: Side,
    /// Distance between samples, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
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
    pub grid: Option<Window>,
    /// Which tile it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile: Option<super::write::Tile>,
    /// The hash of the graph that the file was built of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub graph_key: Option<String>,
}

/// A side of a terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Rows run from north to south.
    #[default]
    North,
    /// Rows run from south to north, as Unity reads them.
    South,
}

/// A window of the grid of the whole terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Window {
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
    /// Reads a sidecar.
    ///
    /// # Errors
    /// When it is not JSON of the right shape, or its numbers make no sense.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        if bytes.len() > LONGEST {
            let found = bytes.len();
            return Err(Fault::Sidecar(format!("is {found} bytes long; the limit is {LONGEST}")));
        }
        let parsed: Self =
            serde_json::from_slice(bytes).map_err(|e| Fault::Sidecar(format!("cannot be read: {e}")))?;
        if let Some([lo, hi]) = parsed.range
            && !(lo.is_finite() && hi.is_finite() && lo < hi)
        {
            return Err(Fault::Sidecar(format!("gives the range [{lo}, {hi}]; it must go upwards")));
        }
        let numbers = [parsed.scale, parsed.offset, parsed.geo.map(|g| g.east), parsed.geo.map(|g| g.north)];
        if numbers.into_iter().flatten().any(|v| !v.is_finite()) {
            return Err(Fault::Sidecar("gives numbers that are not finite".into()));
        }
        if let Some(cell) = parsed.cell
            && !(cell.is_finite() && cell > 0.0)
        {
            return Err(Fault::Sidecar(format!("gives a cell of {cell} m; it must be above 0")));
        }
        Ok(parsed)
    }

    /// Factor and summand that make values of integers up to `levels`, where the sidecar says so.
    fn scaling(&self, levels: f64) -> Option<(f64, f64)> {
        match self.range {
            Some([lo, hi]) => Some(((hi - lo) / levels, lo)),
            None if self.scale.is_some() || self.offset.is_some() => {
                Some((self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0)))
            }
            None => None,
        }
    }

    /// Gives a file that was read what the sidecar knows: the values of its integers, its place, its row order.
    pub(super) fn apply(&self, file: &mut HeightFile, levels: Option<f64>) {
        if let Some((factor, summand)) = levels.and_then(|l| self.scaling(l)) {
            for v in &mut file.data {
                *v = (f64::from(*v) * factor + summand) as f32;
            }
            file.metres = true;
            file.origin.plain = false;
            file.origin.range = self.range;
        }
        if self.rows_from == Side::South {
            file.flip();
        }
        if let Some(cell) = self.cell {
            let step = [cell, cell];
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
