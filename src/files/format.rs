//! The names of file formats, and what each may hold.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::params::did_you_mean;

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// PNG with 8 bits a channel.
    Png8,
    /// PNG with 16 bits a channel.
    Png16,
    /// GeoTIFF of 32-bit floats.
    Tiff,
    /// GeoTIFF of 16-bit integers.
    Tiff16,
    /// OpenEXR of 32-bit floats.
    Exr,
    /// 16-bit integers without a header, little-endian.
    R16,
    /// 32-bit floats without a header, little-endian.
    R32,
    /// Esri ASCII grid.
    Asc,
}

impl Format {
    /// Every format, in the order messages list them.
    pub const ALL: [Self; 8] =
        [Self::Png8, Self::Png16, Self::Tiff, Self::Tiff16, Self::Exr, Self::R16, Self::R32, Self::Asc];

    /// The name in graphs and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png8 => "png8",
            Self::Png16 => "png16",
            Self::Tiff => "tiff",
            Self::Tiff16 => "tiff16",
            Self::Exr => "exr",
            Self::R16 => "r16",
            Self::R32 => "r32",
            Self::Asc => "asc",
        }
    }

    /// The extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png8 | Self::Png16 => "png",
            Self::Tiff | Self::Tiff16 => "tif",
            Self::Exr => "exr",
            Self::R16 => "r16",
            Self::R32 => "r32",
            Self::Asc => "asc",
        }
    }

    /// The format that an output file's name asks for: 16 bits where PNG is all it says.
    pub fn of_name(name: &str) -> Option<Self> {
        Some(match super::error::extension_of(name)?.as_str() {
            "png" => Self::Png16,
            "tif" | "tiff" | "gtiff" => Self::Tiff,
            "exr" => Self::Exr,
            "r16" | "raw" => Self::R16,
            "r32" => Self::R32,
            "asc" => Self::Asc,
            _ => return None,
        })
    }

    /// Whether it holds integers, so that values need a range.
    pub fn is_integer(self) -> bool {
        self.levels().is_some()
    }

    /// The highest integer of a range, where it holds integers.
    pub fn levels(self) -> Option<f64> {
        match self {
            Self::Png8 => Some(255.0),
            Self::Png16 | Self::Tiff16 | Self::R16 => Some(65535.0),
            Self::Tiff | Self::Exr | Self::R32 | Self::Asc => None,
        }
    }

    /// Whether a JSON sidecar goes with it, for what the file itself cannot say: place, unit, range. TIFF of floats
    /// and `.asc` say it themselves; pictures of colours need none.
    pub fn has_sidecar(self, channels: usize) -> bool {
        channels == 1 && !matches!(self, Self::Tiff | Self::Asc)
    }

    /// Whether it takes values of some components: fields have one, vectors two, colours three.
    pub fn takes(self, channels: usize) -> bool {
        match self {
            Self::Png8 | Self::Png16 => channels == 1 || channels == 3,
            Self::Tiff | Self::Exr => (1..=3).contains(&channels),
            Self::Tiff16 => channels == 1 || channels == 3,
            Self::R16 | Self::R32 | Self::Asc => channels == 1,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    /// # Errors
    /// A sentence that lists the names, and the nearest.
    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|f| f.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("must be one of {}, got \"{name}\"{}", names.join(", "), did_you_mean(name, names))
        })
    }
}

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// PNG, grey or Terrarium.
    Png,
    /// TIFF, GeoTIFF and BigTIFF.
    Tiff,
    /// OpenEXR.
    Exr,
    /// 16-bit integers without a header.
    R16,
    /// 32-bit floats without a header.
    R32,
    /// Esri ASCII grid.
    Asc,
    /// SRTM tile.
    Hgt,
}

impl Source {
    /// The extensions of all readers.
    pub const EXTENSIONS: [&str; 10] =
        ["png", "tif", "tiff", "gtiff", "exr", "r16", "raw", "r32", "asc", "hgt"];

    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Tiff => "TIFF",
            Self::Exr => "OpenEXR",
            Self::R16 => "r16",
            Self::R32 => "r32",
            Self::Asc => "Esri ASCII grid",
            Self::Hgt => "SRTM .hgt",
        }
    }

    /// The reader that a file name asks for.
    pub(super) fn of_name(name: &str) -> Option<Self> {
        Some(match super::error::extension_of(name)?.as_str() {
            "png" => Self::Png,
            "tif" | "tiff" | "gtiff" => Self::Tiff,
            "exr" => Self::Exr,
            "r16" | "raw" => Self::R16,
            "r32" => Self::R32,
            "asc" => Self::Asc,
            "hgt" => Self::Hgt,
            _ => return None,
        })
    }

    /// The format that the first bytes give away, with a name for messages.
    pub(super) fn of_content(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            _ => None,
        }
    }

    /// Whether its first bytes always give it away.
    pub(super) fn has_magic(self) -> bool {
        matches!(self, Self::Png | Self::Tiff | Self::Exr)
    }
}
