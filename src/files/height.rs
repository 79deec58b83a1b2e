//! A height file in memory, and which reader reads it.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::codec::Codec;
use super::error::{Fault, ReadError};
use super::input::{Companion, Input};
use super::place::Placement;
use super::reading::Reading;
use crate::work::Work;

/// The most that a file may claim before memory is taken for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most samples.
    pub samples: u64,
    /// Most samples along a side.
    pub side: u32,
}

impl Default for Limits {
    /// 2³⁰ samples, which take 4 GiB, and 2¹⁸ along a side.
    fn default() -> Self {
        Self { samples: 1 << 30, side: 1 << 18 }
    }
}

/// More than deflate, run lengths and JPEG can squeeze out of a byte; a TIFF says what its own compression can.
const MOST_COMPRESSED: u64 = 4096;

impl Limits {
    /// The number of samples of a size, when it is allowed.
    pub(super) fn samples(&self, cols: u64, rows: u64) -> Result<usize, Fault> {
        if cols == 0 || rows == 0 {
            return Err(Fault::Damaged(format!("a size of {cols} x {rows} samples")));
        }
        let side = u64::from(self.side);
        let too_large = Fault::Size { cols, rows, samples: self.samples, side: self.side };
        match cols.checked_mul(rows) {
            Some(n) if n <= self.samples && cols <= side && rows <= side => {
                usize::try_from(n).map_err(|_| too_large)
            }
            _ => Err(too_large),
        }
    }

    /// Checks that a compressed file of some length can hold some bytes.
    pub(super) fn plausible(claimed: u64, bytes: u64) -> Result<(), Fault> {
        if claimed / MOST_COMPRESSED > bytes { Err(Fault::Overclaim { claimed, bytes }) } else { Ok(()) }
    }
}

/// How the pixels of a PNG hold heights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// Grey where red, green and blue are the same, Terrarium where they are the digits of heights.
    #[default]
    Auto,
    /// One number, the grey value.
    Grey,
    /// Metres, as `256 red + green + blue / 256 - 32768`.
    Terrarium,
    /// Metres, as `(65536 red + 256 green + blue) / 10 - 10000`: Mapbox's Terrain-RGB.
    TerrainRgb,
}

/// The heights of a file and where they lie.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightFile {
    /// Samples in a row.
    pub cols: usize,
    /// Rows, the northernmost first.
    pub rows: usize,
    /// All samples, row by row: metres, or the file's own numbers where [`metres`](Self::metres) is false. A void
    /// is NaN.
    pub data: Vec<f32>,
    /// Whether the samples are metres by the word of the file or its sidecar.
    pub metres: bool,
    /// Where the samples lie.
    pub placement: Placement,
    /// What the file held.
    pub origin: Origin,
}

/// How a file held its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The format.
    pub format: &'static Codec,
    /// The type of its samples: `u8 u16 i16 u32 i32 f16 f32 f64`, `text` or `terrarium`.
    pub sample: &'static str,
    /// Whether each sample is one number of the type, neither scaled nor moved.
    pub plain: bool,
    /// The values that its lowest and highest integer stand for, where a sidecar said so.
    pub range: Option<[f64; 2]>,
    /// The number that marks a void.
    pub nodata: Option<f64>,
    /// Bands or channels, of which the first or the fitting one was read.
    pub bands: usize,
    /// What a person should know about the reading.
    pub notes: Vec<String>,
    /// Whether the rows of the file, as other programs count them, were turned upside down.
    pub(super) turned: bool,
}

impl Origin {
    pub(super) fn new(format: &'static Codec, sample: &'static str) -> Self {
        Self {
            format,
            sample,
            plain: true,
            range: None,
            nodata: None,
            bands: 1,
            notes: Vec::new(),
            turned: false,
        }
    }
}

impl HeightFile {
    /// Lowest and highest height; `None` when all are void.
    pub fn range(&self) -> Option<[f32; 2]> {
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let [lo, hi] = self.data.iter().fold(none, |[lo, hi], &v| [lo.min(v), hi.max(v)]);
        (lo <= hi).then_some([lo, hi])
    }

    /// Number of voids.
    pub fn voids(&self) -> usize {
        self.data.iter().filter(|v| v.is_nan()).count()
    }

    /// Makes metres of the numbers of the file by a factor and a summand.
    pub(super) fn scale(&mut self, factor: f64, summand: f64) {
        if (factor, summand) == (1.0, 0.0) {
            return;
        }
        self.origin.plain = false;
        let plus = if summand == 0.0 { String::new() } else { format!(", plus {summand} m") };
        self.origin.notes.push(format!("heights are {factor} times what the file holds{plus}"));
        self.data.par_iter_mut().for_each(|v| *v = (f64::from(*v) * factor + summand) as f32);
    }

    /// Turns the rows upside down.
    pub(super) fn flip(&mut self) {
        for j in 0..self.rows / 2 {
            let (upper, lower) = self.data.split_at_mut((self.rows - 1 - j) * self.cols);
            upper[j * self.cols..][..self.cols].swap_with_slice(&mut lower[..self.cols]);
        }
    }
}

/// Reads a height file: the extension of its name says which reader, the content is checked against it.
///
/// `sidecar` is the content of the JSON file of the same name beside it, if there is one: PNG, r16, r32 and OpenEXR
/// take from it what they cannot say themselves.
///
/// # Errors
/// What is wrong with the file; a size over the limits is refused before memory is taken.
pub fn read_height(
    name: &str,
    bytes: &[u8],
    sidecar: Option<&[u8]>,
    limits: &Limits,
) -> Result<HeightFile, ReadError> {
    read_height_as(name, bytes, sidecar, limits, Encoding::Auto)
}

/// Reads a height file as a person says; else as [`read_height`].
///
/// # Errors
/// Those of [`read_height`].
pub fn read_height_as(
    name: &str,
    bytes: &[u8],
    sidecar: Option<&[u8]>,
    limits: &Limits,
    reading: impl Into<Reading>,
) -> Result<HeightFile, ReadError> {
    let companions: Vec<_> = sidecar.map(|bytes| Companion { name: ".json", bytes }).into_iter().collect();
    let reading = reading.into();
    let work = Work::default();
    Input { name, bytes: &bytes, companions: &companions, reading: &reading, limits, work }.read()
}

/// An empty vector with room for some values, or the word that there is none.
pub(super) fn room<T>(count: usize) -> Result<Vec<T>, Fault> {
    let mut values = Vec::new();
    match values.try_reserve_exact(count) {
        Ok(()) => Ok(values),
        Err(_) => Err(Fault::NoMemory { bytes: (count as u64).saturating_mul(size_of::<T>() as u64) }),
    }
}

/// So many values that are the same, or the word that there is no room for them.
pub(super) fn filled(count: usize, value: f32, work: &Work<'_>) -> Result<Vec<f32>, Fault> {
    /// Values between two looks at the signal: fresh memory is slow.
    const PIECE: usize = 1 << 22;
    let mut values = room(count)?;
    while values.len() < count {
        work.check()?;
        values.resize(count.min(values.len() + PIECE), value);
    }
    Ok(values)
}
