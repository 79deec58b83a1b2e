//! Readers and writers of height and picture files.
//!
//! [`read_height`] turns the bytes of a PNG, TIFF, OpenEXR, r16, r32, `.asc` or `.hgt` file into heights and the
//! place where they lie; [`encode`] turns a value of a graph into a file, and [`encode_file`] a file that was read
//! into another format. Nothing here opens a path: bytes come in, and [`write_atomic`] writes whole files or none
//! into a folder that the caller opened.
//!
//! Every reader checks what a header claims against [`Limits`] and against the length of the file before it takes
//! memory. Heights are `f32`; a void is NaN until [`fill_voids`] closes it.
//!
//! # Caching
//! Reading and writing keep nothing. A node keeps what it decoded in its
//! [`SourceFile`](crate::node::SourceFile), whose content is part of the node's key.

mod apart;
mod asc;
mod atomic;
mod bands;
mod error;
mod exr;
mod format;
mod height;
mod hgt;
mod info;
mod place;
mod png;
mod quantize;
mod raw;
mod relief;
mod sidecar;
mod target;
mod tiff;
mod voids;
mod write;

pub use apart::apart;
pub use atomic::{Stamp, passing_name_of, write_atomic};
pub use error::{Fault, ReadError, WriteError};
pub use format::{Format, Source};
pub use height::{Encoding, HeightFile, Limits, Origin, claimed_size, read_height, read_height_as};
pub use info::{Info, info};
pub use place::{Affine, Anchor, Placement, Units};
pub use relief::{Closing, Relief, Reliefs, Request};
pub use sidecar::{Sidecar, sidecar_name};
pub use target::{Target, target_warnings};
pub use voids::fill_voids;
pub use write::{FileJob, Tile, WriteJob, Written, encode, encode_file};
