//! Damage and cancellation.

use orograph::files::{Companion, Fault, Input, Limits, Reading};
use orograph::work::Work;

#[test]
fn reading_stops_when_it_is_cancelled() {
    let cancel = orograph::node::Cancel::default();
    cancel.cancel();
    let work = Work::new(&cancel);
    let hdr: &[u8] = fixture!("gdal.hdr");
    let companions = [Companion { name: "a.hdr", bytes: hdr }];
    for (name, bytes) in [
        ("a.tif", &fixture!("zstd_p2_i16.tif")[..]),
        ("a.exr", fixture!("layers_f32.exr")),
        ("a.png", fixture!("interlaced_u16.png")),
        ("a.flt", fixture!("gdal.flt")),
        ("a.xyz", fixture!("gdal.xyz")),
        ("a.ter", fixture!("gdal.ter")),
        ("a.asc", b"ncols 1\nnrows 1\n7"),
        ("a.hgt", &[0; 32]),
        ("a.r16", &[0; 32]),
        ("a.r32", &[0; 64]),
    ] {
        let (limits, reading) = (Limits::default(), Reading::default());
        let input =
            Input { name, bytes: &bytes, companions: &companions, reading: &reading, limits: &limits, work };
        assert_eq!(input.read().expect_err(name).fault, Fault::Cancelled, "{name}");
    }
}

/// A file of every new kind, with what lies beside it.
fn samples() -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
    let hdr = fixture!("gdal.hdr");
    let pfm = [b"Pf\n5 4\n-1\n".to_vec(), vec![63; 80]].concat();
    vec![
        ("a.tif", fixture!("mask_inside_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("overviews_mask_i16.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("alpha_pixel_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("packed_u12_deflate_bands.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("lzma_i16.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("zstd_tiled_p3_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("vertical_codes.tif").to_vec(), Vec::new()),
        ("a.exr", fixture!("layers_f32.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("parts_f16.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("tiled_f32.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("window_f32.exr").to_vec(), Vec::new()),
        ("a.flt", fixture!("gdal.flt").to_vec(), hdr.to_vec()),
        ("a.bil", fixture!("gdal_i16.bil").to_vec(), fixture!("gdal_i16.hdr").to_vec()),
        ("a.xyz", fixture!("gdal.xyz").to_vec(), fixture!("gdal.prj").to_vec()),
        ("a.ter", fixture!("gdal.ter").to_vec(), Vec::new()),
        ("a.pfm", pfm, Vec::new()),
    ]
}

/// Reads with small limits; what comes back keeps them, and has the size that its header claims.
fn survives(name: &str, bytes: &[u8], beside: &[u8]) {
    const TIGHT: Limits = Limits { samples: 4096, side: 256 };
    let reading = Reading::default();
    let companions = ["a.hdr", "a.prj", "a.tfw", "a.json"].map(|name| Companion { name, bytes: beside });
    let companions = if beside.is_empty() { &companions[..0] } else { &companions[..3] };
    let input =
        Input { name, bytes: &bytes, companions, reading: &reading, limits: &TIGHT, work: Work::default() };
    let claim = input.claim();
    match input.read() {
        Ok(file) => {
            let claim = claim.expect("what can be read has a sound header");
            assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64], "{name}");
            assert!(claim.cols * claim.rows <= TIGHT.samples, "{name}");
            assert_eq!(file.data.len(), file.cols * file.rows, "{name}");
            assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()), "{name}");
        }
        Err(e) => assert!(e.to_string().ends_with(name), "the file stands last: {e}"),
    }
}

#[test]
fn damaged_files_do_no_harm() {
    use orograph::kit::hash;
    for (name, bytes, beside) in samples() {
        survives(name, &bytes, &beside);
        for n in (0..bytes.len()).step_by(3) {
            survives(name, &bytes[..n], &beside);
        }
        for at in 0..bytes.len().min(900) {
            for change in [0xff, 0x01, 0x80] {
                let mut bad = bytes.clone();
                bad[at] ^= change;
                survives(name, &bad, &beside);
            }
        }
        for at in 0..beside.len() {
            let mut bad = beside.clone();
            bad[at] ^= 0x11;
            survives(name, &bytes, &bad);
        }
        for round in 0..300u64 {
            let mut bad = bytes.clone();
            let random = |i: u64| hash::nth(round, i);
            for i in 0..1 + random(0) % 8 {
                let at = (random(3 * i + 1) % bad.len() as u64) as usize;
                bad[at] = random(3 * i + 3) as u8;
            }
            survives(name, &bad, &beside);
        }
    }
}
