//! PNG: grey heights, Terrarium heights, masks and pictures.
//!
//! Reading leans on the `png` crate. Writing is our own, since that crate compresses on one thread.

mod colors;
mod read;
mod write;

use super::codec::{Codec, FormatSpec};

pub(super) static CODEC: Codec = Codec {
    name: "PNG",
    extensions: &["png"],
    magic: &[b"\x89PNG"],
    companions: &["json", "pgw", "pngw", "wld", "prj"],
    claims_early: true,
    claim: read::claim,
    read: read::read,
    reads: "8 and 16 bits, grey; transparent pixels are voids. Tiles of colours: Terrarium (`256 R + G + B / 256 - 32768`, \
            known by its digits or by `encoding`) and Mapbox Terrain-RGB (`(65536 R + 256 G + B) / 10 - 10000`, by `encoding`)",
    metres: "with a sidecar that gives the range, or as a tile of colours; else plain numbers",
    place: "from the sidecar, or `.pgw` and `.prj`",
};

pub(super) static EIGHT: FormatSpec = FormatSpec {
    name: "png8",
    by_extension: false,
    levels: Some(255.0),
    channels: &[1, 3],
    sidecar: true,
    flips: true,
    voids: false,
    write: write::eight,
    nanoseconds: 30.0,
    holds: "8 bits grey or colour",
    purpose: "pictures",
};

pub(super) static SIXTEEN: FormatSpec = FormatSpec {
    name: "png16",
    by_extension: true,
    levels: Some(65535.0),
    channels: &[1, 3],
    sidecar: true,
    flips: true,
    voids: false,
    write: write::sixteen,
    nanoseconds: 70.0,
    holds: "16 bits grey or colour",
    purpose: "masks, engines",
};
