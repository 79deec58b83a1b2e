//! TIFF, BigTIFF and GeoTIFF.
//!
//! Both directions are our own. The `tiff` crate takes memory on the word of a header before limits can be set, reads
//! neither LZMA nor packed integers nor ZSTD without a library in C, fills the parts that a sparse file leaves out with
//! zeros, knows no nodata, no mask and no alpha, and compresses on one thread. `tests/it/files/crates.rs` holds this
//! module against it: what both read is the same to the bit, and what the crate does not read is a list that fails when
//! it gets shorter.

mod gdal;
mod geo;
mod ifd;
mod layout;
mod read;
mod samples;
mod unpack;
mod write;

pub(super) use read::{mask_bytes, strike_mask};

use super::codec::{Codec, FormatSpec};

pub(super) static CODEC: Codec = Codec {
    name: "TIFF",
    extensions: &["tif", "tiff", "gtiff"],
    magic: &[b"II\x2a\0", b"II\x2b\0", b"MM\0\x2a", b"MM\0\x2b"],
    companions: &["tfw", "tifw", "wld", "prj"],
    claims_early: true,
    claim: read::claim,
    read: read::read,
    reads: "TIFF, BigTIFF, GeoTIFF: f16 f32 f64, u8 to u64, i8 to i64, packed integers of 1 to 31 bits; strips or tiles; \
            bands together or apart (the first, or the one whose number `channel` gives); no compression, deflate, LZW, \
            PackBits, ZSTD, LZMA; predictors 2 and 3; both byte and bit orders; sparse files; of several pictures \
            (overviews) the first; a mask inside and an alpha band make voids",
    metres: "yes; GDAL's scale and offset are applied, and units of height: GDAL's word for the band, the unit of the \
             vertical system, or the system's code",
    place: "pixel scale with tie point, or transformation; point or area; EPSG code",
};

pub(super) static FLOATS: FormatSpec = FormatSpec {
    name: "tiff",
    by_extension: true,
    levels: None,
    channels: &[1, 2, 3],
    sidecar: false,
    flips: false,
    voids: true,
    write: write::floats,
    nanoseconds: 100.0,
    holds: "GeoTIFF f32, deflate with predictor 3, pixel is point; colours too",
    purpose: "heights, to the bit, with their place",
};

pub(super) static INTEGERS: FormatSpec = FormatSpec {
    name: "tiff16",
    by_extension: false,
    levels: Some(65535.0),
    channels: &[1, 3],
    sidecar: true,
    flips: false,
    voids: true,
    write: write::integers,
    nanoseconds: 70.0,
    holds: "GeoTIFF of 16 bits, deflate with predictor 2. With a range: unsigned, GDAL's scale and offset give metres \
            back. Without: signed whole metres",
    purpose: "GIS that wants integers",
};

/// Tags, by the names of TIFF 6.0, GeoTIFF 1.1 and GDAL.
mod tag {
    pub(super) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(super) const WIDTH: u16 = 256;
    pub(super) const LENGTH: u16 = 257;
    pub(super) const BITS: u16 = 258;
    pub(super) const COMPRESSION: u16 = 259;
    pub(super) const PHOTOMETRIC: u16 = 262;
    pub(super) const FILL_ORDER: u16 = 266;
    pub(super) const STRIP_OFFSETS: u16 = 273;
    pub(super) const SAMPLES: u16 = 277;
    pub(super) const ROWS_PER_STRIP: u16 = 278;
    pub(super) const STRIP_COUNTS: u16 = 279;
    pub(super) const PLANAR: u16 = 284;
    pub(super) const PREDICTOR: u16 = 317;
    pub(super) const TILE_WIDTH: u16 = 322;
    pub(super) const TILE_LENGTH: u16 = 323;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_COUNTS: u16 = 325;
    pub(super) const EXTRA_SAMPLES: u16 = 338;
    pub(super) const SAMPLE_FORMAT: u16 = 339;
    pub(super) const PIXEL_SCALE: u16 = 33550;
    pub(super) const TIE_POINTS: u16 = 33922;
    pub(super) const TRANSFORMATION: u16 = 34264;
    pub(super) const GEO_KEYS: u16 = 34735;
    pub(super) const GEO_DOUBLES: u16 = 34736;
    pub(super) const GEO_TEXT: u16 = 34737;
    pub(super) const GDAL_METADATA: u16 = 42112;
    pub(super) const GDAL_NODATA: u16 = 42113;
}
