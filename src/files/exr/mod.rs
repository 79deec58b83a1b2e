//! OpenEXR: 32-bit float heights and pictures.

mod choose;
mod read;
mod write;

use super::codec::{Codec, FormatSpec};

pub(super) static CODEC: Codec = Codec {
    name: "OpenEXR",
    extensions: &["exr"],
    magic: &[&[0x76, 0x2f, 0x31, 0x01]],
    companions: &["json"],
    claims_early: true,
    claim: read::claim,
    read: read::read,
    reads: "f16, f32, u32; any compression of the `exr` crate; parts, layers, tiles, the finest of several levels; the \
            channel `height`, `elevation`, `Z`, `depth`, `Y` by what follows the last dot of its name, grey in `R`, `G`, \
            `B`, the only one, or the one that `channel` names; never alpha. What the display window shows and holds no \
            samples is void",
    metres: "yes",
    place: "from the sidecar",
};

pub(super) static FLOATS: FormatSpec = FormatSpec {
    name: "exr",
    by_extension: true,
    levels: None,
    channels: &[1, 2, 3],
    sidecar: true,
    flips: true,
    voids: true,
    write: write::floats,
    nanoseconds: 180.0,
    holds: "f32, ZIP; channel `Y`; colours as linear light",
    purpose: "heights, to the bit",
};
