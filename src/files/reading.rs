//! What a person says of a height file where the file itself is silent.

use super::height::Encoding;

/// What a person says of a height file where the file itself is silent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// How the pixels of a PNG hold heights.
    pub encoding: Encoding,
    /// The channel of an OpenEXR picture, by its name, or the band of a TIFF, by its number from 1.
    pub channel: Option<String>,
}

impl From<Encoding> for Reading {
    fn from(encoding: Encoding) -> Self {
        Self { encoding, ..Self::default() }
    }
}
