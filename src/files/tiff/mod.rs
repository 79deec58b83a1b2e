//! TIFF, BigTIFF and GeoTIFF.
//!
//! Both directions are our own. The `tiff` crate takes up to 256 MiB on the word of a header before limits can be set,
//! knows neither sparse files nor one that does not say how it is to be shown, and compresses on one thread;
//! the tests hold this module against it.

mod geo;
mod ifd;
mod read;
mod write;

use super::codec::{Codec, Form};

pub(super) static CODEC: Codec = Codec {
    name: "TIFF",
    extensions: &["tif", "tiff", "gtiff"],
    magic: &[b"II\x2a\0", b"II\x2b\0", b"MM\0\x2a", b"MM\0\x2b"],
    companions: &[],
    claim: read::claim,
    read: read::read,
    reads: "TIFF, BigTIFF, GeoTIFF: f16 f32 f64, u8 u16 u32, i8 i16 i32; strips or tiles; bands together or apart (the \
            first is read); no compression, deflate, LZW, PackBits; predictors 2 and 3; both byte orders; sparse files; \
            of several pictures (overviews) the first",
    metres: "yes; GDAL's scale and offset and a vertical unit of feet are applied",
    place: "pixel scale with tie point, or transformation; point or area; EPSG code",
};

pub(super) static FLOATS: Form = Form {
    name: "tiff",
    by_extension: true,
    levels: None,
    channels: &[1, 2, 3],
    sidecar: false,
    flips: false,
    voids: true,
    write: write::floats,
    holds: "GeoTIFF f32, deflate with predictor 3, pixel is point; colours too",
    purpose: "heights, to the bit, with their place",
};

pub(super) static INTEGERS: Form = Form {
    name: "tiff16",
    by_extension: false,
    levels: Some(65535.0),
    channels: &[1, 3],
    sidecar: true,
    flips: false,
    voids: true,
    write: write::integers,
    holds: "GeoTIFF of 16 bits, deflate with predictor 2. With a range: unsigned, GDAL's scale and offset give metres \
            back. Without: signed whole metres",
    purpose: "GIS that wants integers",
};

/// Tags, by the names of TIFF 6.0, GeoTIFF 1.1 and GDAL.
mod tag {
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
    pub(super) const GDAL_METADATA: u16 = 42112;
    pub(super) const GDAL_NODATA: u16 = 42113;

    /// All that the reader looks at.
    pub(super) const READ: [u16; 25] = [
        WIDTH,
        LENGTH,
        BITS,
        COMPRESSION,
        PHOTOMETRIC,
        FILL_ORDER,
        STRIP_OFFSETS,
        SAMPLES,
        ROWS_PER_STRIP,
        STRIP_COUNTS,
        PLANAR,
        PREDICTOR,
        TILE_WIDTH,
        TILE_LENGTH,
        TILE_OFFSETS,
        TILE_COUNTS,
        EXTRA_SAMPLES,
        SAMPLE_FORMAT,
        PIXEL_SCALE,
        TIE_POINTS,
        TRANSFORMATION,
        GEO_KEYS,
        GEO_DOUBLES,
        GDAL_METADATA,
        GDAL_NODATA,
    ];
}
