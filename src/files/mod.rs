//! Readers and writers of height and picture files.
//!
//! [`Codec`] is the table of formats, a row each: how files are recognised, read and written. [`Input`] is a file with
//! what lies beside it; [`read_height`] turns its bytes into heights and the place where they lie; [`encode`] turns a value of a graph into a file, and [`encode_file`] a file that was read
//! into another format. Nothing here opens a path: bytes come in, and [`whole`](crate::whole) writes the files.
//! [`vectors`] reads lines from SVG and `GeoJSON`.
//!
//! Every reader checks what a header claims against [`Limits`] and against the length of the file before it takes
//! memory. Heights are `f32`; a void is NaN until [`fill_voids`] closes it.
//!
//! # Caching
//! Reading and writing keep nothing. A node keeps what it decoded in its
//! [`SourceFile`](crate::node::SourceFile), whose content is part of the node's key.

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
mod lines;
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
pub use codec::{Codec, Form, Format};
pub use error::{Fault, ReadError, WriteError};
pub use fit::Fit;
pub use height::{Encoding, HeightFile, Limits, Origin, read_height, read_height_as};
pub use info::{Info, info};
pub use input::{Claim, Companion, Input, companions};
pub use picture::{
    Channel, Footprint, Kernel, Mixture, Picture, PictureClaim, PictureKind, Texture, TextureColumns,
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
