//! Readers and writers of height and picture files.
//!
//! [`Codec`] is a row of the table of formats: it says how files are recognised, read and written. [`Input`] is a file
//! with its companions. [`read_height`] turns the bytes of a file into heights with their place, [`encode`] turns a
//! value of a graph into a file, and [`encode_file`] converts a file to another format. Nothing here opens a path:
//! readers take bytes, and [`whole`](crate::whole) writes the files. [`vectors`] reads lines from SVG and `GeoJSON`.
//!
//! Every reader checks the claims of a header against [`Limits`] and the length of the file before it allocates memory.
//! Heights are `f32`; a void is NaN until [`fill_voids`] closes it.
//!
//! # Caching
//! Readers and writers cache nothing. Decoded values are stored with the [`SourceFile`](crate::node::SourceFile) of a
//! node, whose content is part of the key of the node.

mod apart;
mod asc;
mod bands;
mod beside;
mod codec;
mod epsg;
mod error;
mod esri;
mod exr;
mod fit;
mod flat;
mod height;
mod hgt;
mod info;
mod input;
mod pam;
mod pfm;
mod picture;
mod place;
mod placing;
mod png;
mod price;
mod quantize;
mod raw;
mod reading;
mod relief;
mod sheet;
mod sidecar;
mod square;
mod suspect;
mod target;
mod terragen;
mod tiff;
pub mod vectors;
mod voids;
mod wkt;
mod world;
mod write;
mod xyz;

pub use apart::apart;
pub use beside::{LONGEST_SIDECAR, Owner, last_name};
pub use codec::{Codec, Format, FormatSpec};
pub use error::{Fault, ReadError, WriteError};
pub use fit::Fit;
pub use height::{Encoding, HeightFile, Limits, Origin, read_height, read_height_as};
pub use info::{Info, info};
pub use input::{Claim, Companion, Input, companions};
pub use picture::{
    Channel, Kernel, Mixture, Picture, PictureClaim, PictureKind, PixelSpan, Texture, TextureColumns,
};
pub use place::{Affine, Anchor, Placement, Units};
pub use placing::{Placed, Placing, Pose};
pub use price::{WriterCost, writer_cost};
pub use reading::{ByteOrder, RawSample, Reading};
pub use relief::{Closing, Relief, Request};
pub use sheet::Sink;
pub use sidecar::{Sidecar, sidecar_name};
pub use square::Squared;
pub use target::{Target, target_warnings};
pub use voids::fill_voids;
pub use write::{Tile, WriteJob, Writing, Written, encode, encode_file};
