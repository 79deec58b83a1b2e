//! Our own TIFF reader against the `tiff` crate: what both read is the same, and what the crate does not read is known,
//! so that the day it does is noticed.

use std::io::Cursor;

use orograph::files::{Limits, read_height};
use tiff::decoder::{Decoder, DecodingResult};

/// What the crate makes of the first band of a file; `None` where it does not read it.
fn by_crate(bytes: &[u8]) -> Option<Vec<f32>> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).ok()?;
    let bands = decoder.colortype().ok()?.num_samples() as usize;
    let [cols, rows] = <[u32; 2]>::from(decoder.dimensions().ok()?);
    let all: Vec<f32> = match decoder.read_image().ok()? {
        DecodingResult::U8(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::U32(v) => v.into_iter().map(|x| x as f32).collect(),
        DecodingResult::U64(v) => v.into_iter().map(|x| x as f32).collect(),
        DecodingResult::I8(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::I16(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::I32(v) => v.into_iter().map(|x| x as f32).collect(),
        DecodingResult::I64(v) => v.into_iter().map(|x| x as f32).collect(),
        DecodingResult::F16(v) => v.into_iter().map(|x| x.to_f32()).collect(),
        DecodingResult::F32(v) => v,
        DecodingResult::F64(v) => v.into_iter().map(|x| x as f32).collect(),
    };
    let count = (cols * rows) as usize;
    let step = if all.len() == count { 1 } else { bands };
    Some(all.into_iter().step_by(step).take(count).collect())
}

macro_rules! fixtures {
    ($($name:literal)*) => { [$(($name, &include_bytes!(concat!("fixtures/", $name))[..])),*] };
}

#[test]
fn the_tiff_crate_does_not_read_all_that_we_read() {
    let mut not_read = Vec::new();
    for (name, bytes) in fixtures! {
        "alpha_band_f32.tif" "alpha_pixel_f32.tif" "band_deflate_p2_u16.tif" "big_tiled_f32.tif" "i64.tif"
        "lzma_f32.tif" "lzma_i16.tif" "mask_inside_f32.tif" "motorola_p2_i16.tif" "motorola_p3_f32.tif"
        "motorola_u32.tif" "nodata_f32.tif" "overviews_mask_i16.tif" "packbits_u8.tif" "packed_u12.tif"
        "packed_u12_deflate_bands.tif" "pixel_lzw_p2_i32.tif" "point_f32.tif" "sparse_i16.tif" "strip_lzw_p3_f64.tif"
        "tiled_deflate_p3_f32.tif" "tiled_lzw_p2_i16.tif" "turned_f32.tif" "u64_motorola.tif" "zstd_p2_i16.tif"
        "zstd_tiled_p3_f32.tif"
    } {
        let own = read_height(name, bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
        // Voids are ours: the crate knows no nodata and no mask.
        let same = |theirs: Vec<f32>| {
            own.data.len() == theirs.len() && own.data.iter().zip(&theirs).all(|(a, b)| a.is_nan() || a == b)
        };
        if !by_crate(bytes).is_some_and(same) {
            not_read.push(name);
        }
    }
    assert_eq!(not_read, NOT_READ);
}

/// What the crate does not read, or reads otherwise: LZMA, packed integers, and ZSTD, for which it wants a library in C.
const NOT_READ: [&str; 6] = [
    "lzma_f32.tif",
    "lzma_i16.tif",
    "packed_u12.tif",
    "packed_u12_deflate_bands.tif",
    "zstd_p2_i16.tif",
    "zstd_tiled_p3_f32.tif",
];
