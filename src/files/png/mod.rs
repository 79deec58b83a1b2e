//! PNG: grey heights, Terrarium heights, masks and pictures.
//!
//! Reading leans on the `png` crate. Writing is our own, since that crate compresses on one thread.

mod read;
mod write;

use super::codec::{Codec, Form};

pub(super) static CODEC: Codec = Codec {
    name: "PNG",
    extensions: &["png"],
    magic: &[b"\x89PNG"],
    companions: &["json"],
    claim: read::claim,
    read: read::read,
    reads: "8 and 16 bits, grey; transparent pixels are voids. Terrarium tiles: `256 R + G + B / 256 - 32768`",
    metres: "with a sidecar that gives the range, or as Terrarium; else plain numbers",
    place: "from the sidecar",
};

pub(super) static EIGHT: Form = Form {
    name: "png8",
    by_extension: false,
    levels: Some(255.0),
    channels: &[1, 3],
    sidecar: true,
    flips: true,
    voids: false,
    write: write::eight,
    holds: "8 bits grey or colour",
    purpose: "pictures",
};

pub(super) static SIXTEEN: Form = Form {
    name: "png16",
    by_extension: true,
    levels: Some(65535.0),
    channels: &[1, 3],
    sidecar: true,
    flips: true,
    voids: false,
    write: write::sixteen,
    holds: "16 bits grey or colour",
    purpose: "masks, engines",
};
