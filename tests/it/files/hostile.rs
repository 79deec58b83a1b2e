//! Files that lie, and files that were cut: an error, never a panic, never memory on their word.

use orograph::files::{Codec, Encoding, Fault, Format, Limits, Writing, read_height, read_height_as};
use orograph::kit::hash;
use orograph::value::Terrain;

use super::tiffs::{grey, tiff};
use super::{heights, job, write};

/// A small file of every format, and its sidecar where it has one.
fn samples() -> Vec<(String, Vec<u8>, Option<Vec<u8>>)> {
    let terrain = Terrain::default();
    let value = heights(9, 7, |k| (k * 37 % 1000) as f32);
    let mut all: Vec<_> = Format::of_samples()
        .map(|format| {
            let (bytes, sidecar) =
                write(&job(&value, Writing { range: Some([0.0, 1000.0]), ..format.into() }, &terrain));
            (format!("a.{}", format.extension()), bytes, sidecar)
        })
        .collect();
    let tile: Vec<u8> = (0..50i16).chain([0; 31]).flat_map(|v| v.to_be_bytes()).collect();
    all.push(("N01E002.hgt".into(), tile, None));
    for fixture in [
        &include_bytes!("fixtures/tiled_lzw_p2_i16.tif")[..],
        include_bytes!("fixtures/big_tiled_f32.tif"),
        include_bytes!("fixtures/motorola_p3_f32.tif"),
        include_bytes!("fixtures/packbits_u8.tif"),
        include_bytes!("fixtures/sparse_i16.tif"),
    ] {
        all.push(("b.tif".into(), fixture.to_vec(), None));
    }
    all.push(("bands.tif".into(), include_bytes!("fixtures/band_deflate_p2_u16.tif").to_vec(), None));
    all.push(("c.png".into(), include_bytes!("fixtures/interlaced_u16.png").to_vec(), None));
    all
}

/// Small limits: what comes back must keep them.
const TIGHT: Limits = Limits { samples: 4096, side: 256 };

fn survives(name: &str, bytes: &[u8], sidecar: Option<&[u8]>) -> bool {
    match read_height(name, bytes, sidecar, &TIGHT) {
        Ok(file) => {
            assert_eq!(file.data.len(), file.cols * file.rows, "{name}");
            assert!(file.data.len() as u64 <= TIGHT.samples, "{name}");
            assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()), "{name}");
            true
        }
        Err(e) => {
            assert!(e.to_string().ends_with(name), "the file stands last: {e}");
            false
        }
    }
}

#[test]
fn every_beginning_of_a_file_is_an_error() {
    for (name, bytes, sidecar) in samples() {
        assert!(survives(&name, &bytes, sidecar.as_deref()), "{name} is whole");
        // What follows the last sample may be missing: the end mark of a PNG, a blank, filling, a second band.
        let last = match name.rsplit('.').next() {
            _ if name == "bands.tif" => 620,
            Some("png") => bytes.len() - 12,
            Some("asc") => bytes.len() - 4,
            _ => bytes.len(),
        };
        for n in 0..bytes.len() {
            let read = survives(&name, &bytes[..n], sidecar.as_deref());
            let square = name.ends_with("hgt");
            assert!(!read || n >= last || square, "{name} reads with {n} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn no_flipped_byte_does_harm() {
    for (name, bytes, sidecar) in samples() {
        for at in 0..bytes.len().min(1200) {
            for change in [0xff, 0x01, 0x80, 0x7f] {
                let mut bad = bytes.clone();
                bad[at] ^= change;
                survives(&name, &bad, sidecar.as_deref());
            }
        }
        let sidecar = sidecar.unwrap_or_default();
        for at in 0..sidecar.len() {
            let mut bad = sidecar.clone();
            bad[at] ^= 0x11;
            survives(&name, &bytes, Some(&bad));
        }
    }
}

#[test]
fn no_shuffled_file_does_harm() {
    let all = samples();
    for round in 0..4000u64 {
        let (name, bytes, sidecar) = &all[(round % all.len() as u64) as usize];
        let mut bad = bytes.clone();
        let random = |i: u64| hash::nth(round, i);
        for i in 0..1 + random(0) % 8 {
            let at = (random(3 * i + 1) % bad.len() as u64) as usize;
            let from = (random(3 * i + 2) % bad.len() as u64) as usize;
            bad[at] = if random(3 * i + 3) % 2 == 0 { bad[from] } else { random(3 * i + 3) as u8 };
        }
        survives(name, &bad, sidecar.as_deref());
    }
}

/// A deflated TIFF that says what it likes about its size and the length of its strip.
fn claiming_tiff(size: [u32; 2], bits: u16, strip: u32) -> Vec<u8> {
    tiff(&[0; 8], &grey(size, (bits, 1), 8, strip))
}

fn claiming_png(cols: u32, rows: u32) -> Vec<u8> {
    let mut ihdr = b"IHDR".to_vec();
    ihdr.extend(cols.to_be_bytes());
    ihdr.extend(rows.to_be_bytes());
    ihdr.extend([16, 0, 0, 0, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(&ihdr);
    [&b"\x89PNG\r\n\x1a\n\0\0\0\x0d"[..], &ihdr, &crc.sum().to_be_bytes(), b"\0\0\0\0IDAT"].concat()
}

fn claiming_exr(cols: i32, rows: i32) -> Vec<u8> {
    let terrain = Terrain::default();
    let (mut bytes, _) = write(&job(&heights(9, 7, |k| k as f32), Format::Exr, &terrain));
    for name in [&b"dataWindow"[..], b"displayWindow"] {
        let at = bytes.windows(name.len()).position(|w| w == name).expect("has one");
        // Name, zero, "box2i", zero, length, minimum.
        let max = at + name.len() + 1 + 6 + 4 + 8;
        bytes[max..max + 4].copy_from_slice(&(cols - 1).to_le_bytes());
        bytes[max + 4..max + 8].copy_from_slice(&(rows - 1).to_le_bytes());
    }
    bytes
}

#[test]
fn headers_that_claim_a_million_squared_are_refused() {
    let million = 1_000_000;
    for (name, bytes) in [
        ("a.tif", claiming_tiff([million; 2], 16, 8)),
        ("a.png", claiming_png(million, million)),
        ("a.exr", claiming_exr(1_000_000, 1_000_000)),
        ("a.asc", b"ncols 1000000\nnrows 1000000\n1 2 3".to_vec()),
    ] {
        let error = read_height(name, &bytes, None, &Limits::default()).expect_err(name);
        let size = Fault::Size { cols: 1_000_000, rows: 1_000_000, samples: 1 << 30, side: 1 << 18 };
        assert_eq!(error.fault, size, "{name}");
    }
}

/// Within the limits, and yet more than a short file can hold.
#[test]
fn headers_that_claim_more_than_the_file_can_hold_are_refused() {
    for (name, bytes) in [
        ("a.tif", claiming_tiff([30_000; 2], 16, 8)),
        ("a.tif", claiming_tiff([30_000; 2], 32, u32::MAX)),
        ("a.tif", claiming_tiff([30_000; 2], 16, 4 << 20)),
        ("a.png", claiming_png(30_000, 30_000)),
        ("a.exr", claiming_exr(30_000, 30_000)),
    ] {
        let error = read_height(name, &bytes, None, &Limits::default()).expect_err(name);
        assert!(matches!(error.fault, Fault::Overclaim { .. }), "{error}");
    }
}

#[test]
fn any_bytes_under_any_name_are_an_error_at_worst() {
    for round in 0..300u64 {
        let n = (hash::nth(round, 0) % 300) as usize;
        let bytes: Vec<u8> = (0..n).map(|i| hash::nth(round, i as u64 + 1) as u8).collect();
        for extension in Codec::all_extensions() {
            survives(&format!("x.{extension}"), &bytes, Some(&bytes));
            let text: Vec<u8> = bytes.iter().map(|b| b"ncolsrw 0123456789.-e\n"[*b as usize % 22]).collect();
            survives(&format!("x.{extension}"), &text, None);
        }
        let _ = read_height_as("x.png", &bytes, None, &TIGHT, Encoding::Terrarium);
    }
}

/// Found by fuzzing: a number past the farthest height was a void in one format and a height in another, and one that
/// reached it by rounding was a void only when it was read again.
#[test]
fn numbers_past_any_height_are_voids_in_every_format() {
    let voids = |name: &str, bytes: &[u8], sidecar: Option<&[u8]>| {
        let file = read_height(name, bytes, sidecar, &Limits::default()).unwrap();
        file.data.iter().map(|v| v.is_nan()).collect::<Vec<_>>()
    };
    let text =
        b"ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n6 999999999999999909999999999999 2e30\n";
    assert_eq!(voids("a.asc", text, None), [false, false, true]);
    let raw: Vec<u8> = [6.0f32, 1e30, 2e30, f32::INFINITY].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(voids("a.r32", &raw, Some(br#"{"cols": 4, "rows": 1}"#)), [false, false, true, true]);
}
