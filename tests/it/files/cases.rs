//! What files of the field hold beside plain heights: masks, alpha, units, layers, windows, narrow tiles, files beside
//! them. The fixtures were written by GDAL 3.10 (rasterio) and OpenEXR 3.5, with the samples of `foreign.rs`.

// The modules below use these macros, which therefore come first.

macro_rules! fixture {
    ($name:literal) => {
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/files/fixtures/", $name))
    };
}

macro_rules! open {
    ($name:literal) => {
        read($name, fixture!($name))
    };
}

mod beside;
mod damage;
mod exr;
mod grids;
mod tiff;

use orograph::files::{Companion, HeightFile, Input, Limits, ReadError, Reading};
use orograph::work::Work;

const COLS: usize = 21;
const ROWS: usize = 13;

fn floats(i: usize, j: usize) -> f32 {
    100.0 + 3.0 * i as f32 - 2.0 * j as f32 + ((i * j) % 7) as f32 / 2.0
}

fn integers(i: usize, j: usize) -> f32 {
    7.0 * i as f32 - 5.0 * j as f32 + ((i * j) % 11) as f32
}

fn moved(i: usize, j: usize) -> f32 {
    integers(i, j) + 100.0
}

/// Reads a file as a person says, with what lies beside it; what it claims must be what it has.
pub(super) fn try_read(
    name: &str,
    bytes: &[u8],
    beside: &[(&str, &[u8])],
    reading: &Reading,
) -> Result<HeightFile, ReadError> {
    let companions: Vec<_> = beside.iter().map(|&(name, bytes)| Companion { name, bytes }).collect();
    let limits = Limits::default();
    let input = Input {
        name,
        bytes: &bytes,
        companions: &companions,
        reading,
        limits: &limits,
        work: Work::default(),
    };
    let file = input.read()?;
    let claim = input.claim().expect("what can be read has a sound header");
    assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64], "{name}");
    assert!(claim.bytes >= 4 * claim.cols * claim.rows, "{name}");
    Ok(file)
}

fn read(name: &str, bytes: &[u8]) -> HeightFile {
    try_read(name, bytes, &[], &Reading::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn channel(name: &str) -> Reading {
    Reading { channel: Some(name.into()), ..Reading::default() }
}

/// Checks every sample; `None` is a void.
fn holds(file: &HeightFile, sample: &str, f: impl Fn(usize, usize) -> Option<f32>) {
    assert_eq!((file.cols, file.rows, file.origin.sample), (COLS, ROWS, sample));
    for (k, v) in file.data.iter().enumerate() {
        let (i, j) = (k % COLS, k / COLS);
        match f(i, j) {
            Some(want) => {
                assert!((v - want).abs() <= 1e-6 * want.abs(), "column {i}, row {j}: {v}, not {want}")
            }
            None => assert!(v.is_nan(), "column {i}, row {j}: {v}, not a void"),
        }
    }
}

fn outside_the_hole(i: usize, j: usize) -> Option<()> {
    (!((5..9).contains(&i) && (2..4).contains(&j))).then_some(())
}

fn notes(file: &HeightFile) -> String {
    file.origin.notes.join("; ")
}
