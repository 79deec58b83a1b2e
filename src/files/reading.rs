//! What a person says of a height file where the file itself is silent.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::flat::Number;
use super::height::Encoding;

/// What a person says of a height file where the file itself is silent; it goes before what a sidecar says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// How the pixels of a PNG hold heights.
    pub encoding: Encoding,
    /// The channel of an OpenEXR picture, by its name, or the band of a TIFF, by its number from 1.
    pub channel: Option<String>,
    /// A number that marks voids, as the file holds it, beside the one that the file names.
    pub nodata: Option<f64>,
    /// The type of the samples of a raw file.
    pub sample: Option<RawSample>,
    /// Which byte of a sample of a raw file is the first.
    pub byte_order: Option<ByteOrder>,
    /// Samples in a row of a raw file.
    pub cols: Option<u64>,
}

impl Reading {
    /// This word, and another where it is silent.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        let silent = self.encoding == Encoding::default();
        Self {
            encoding: if silent { other.encoding } else { self.encoding },
            channel: self.channel.or_else(|| other.channel.clone()),
            nodata: self.nodata.or(other.nodata),
            sample: self.sample.or(other.sample),
            byte_order: self.byte_order.or(other.byte_order),
            cols: self.cols.or(other.cols),
        }
    }
}

impl From<Encoding> for Reading {
    fn from(encoding: Encoding) -> Self {
        Self { encoding, ..Self::default() }
    }
}

/// The type of the samples of a raw file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RawSample {
    /// 8-bit integers from 0.
    U8,
    /// 16-bit integers from 0.
    U16,
    /// 16-bit integers with a sign.
    I16,
    /// 32-bit integers from 0.
    U32,
    /// 32-bit integers with a sign.
    I32,
    /// 32-bit floats.
    F32,
}

impl RawSample {
    /// Every type, in the order messages list them.
    pub const ALL: [Self; 6] = [Self::U8, Self::U16, Self::I16, Self::U32, Self::I32, Self::F32];

    /// The name in sidecars, graphs and on the command line.
    pub fn name(self) -> &'static str {
        self.number().name()
    }

    /// Bytes of a sample.
    pub fn bytes(self) -> u64 {
        self.number().bytes()
    }

    /// How its bytes are read.
    pub(super) fn number(self) -> Number {
        match self {
            Self::U8 => Number::U8,
            Self::U16 => Number::U16,
            Self::I16 => Number::I16,
            Self::U32 => Number::U32,
            Self::I32 => Number::I32,
            Self::F32 => Number::F32,
        }
    }

    /// The lowest and the highest integer, which the ends of a range stand for.
    pub(super) fn ends(self) -> Option<[f64; 2]> {
        Some(match self {
            Self::U8 => [0.0, 255.0],
            Self::U16 => [0.0, 65535.0],
            Self::I16 => [-32768.0, 32767.0],
            Self::U32 => [0.0, 4_294_967_295.0],
            Self::I32 => [-2_147_483_648.0, 2_147_483_647.0],
            Self::F32 => return None,
        })
    }
}

/// Which byte of a sample comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByteOrder {
    /// The lowest byte, as on a PC (Windows).
    #[default]
    Little,
    /// The highest byte, as on an old Mac (IBM, Motorola).
    Big,
}

impl ByteOrder {
    /// The other one.
    pub(super) fn other(self) -> Self {
        match self {
            Self::Little => Self::Big,
            Self::Big => Self::Little,
        }
    }

    /// The name in sidecars, graphs and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Little => "little",
            Self::Big => "big",
        }
    }
}
