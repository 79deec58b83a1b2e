//! Sound heights with any bytes beside them, as a sidecar, a world file, a projection, a header: an error, or all heights,
//! within the limits. `cargo +nightly fuzz run sidecar`.
//!
//! The first byte chooses the format of the heights, the second the file beside them.
#![no_main]

use std::io::Cursor;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use orograph::files::{
    Companion, Encoding, Format, HeightFile, Input, Limits, Owner, Reading, Writing, companions, encode_file,
};
use orograph::work::Work;

const COLS: usize = 12;
const ROWS: usize = 8;
const LIMITS: Limits = Limits { samples: 1 << 12, side: 1 << 8 };

/// A file of each format, from one of heights.
static FILES: LazyLock<Vec<(String, Vec<u8>)>> = LazyLock::new(|| {
    let mut text = format!("ncols {COLS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize 10\n");
    (0..COLS * ROWS).for_each(|k| text += &format!("{}\n", k * k % 97));
    let reading = Reading::from(Encoding::Auto);
    let read = |name: &str, bytes: &[u8]| -> HeightFile {
        let input = Input {
            name,
            bytes: &bytes,
            companions: &[],
            reading: &reading,
            limits: &LIMITS,
            work: Work::default(),
        };
        input.read().expect("heights")
    };
    let file = read("a.asc", text.as_bytes());
    let encode = |format: Format| {
        let mut out = Cursor::new(Vec::new());
        encode_file(&file, &Writing { range: Some([0.0, 100.0]), ..format.into() }, &mut out)
            .expect("heights can be written");
        (format!("N01E002.{}", format.extension()), out.into_inner())
    };
    let written = Format::of_samples().map(encode);
    let flat = |extension: &str| {
        let numbers: Vec<u8> = (0..COLS * ROWS).flat_map(|k| (k as f32).to_le_bytes()).collect();
        (format!("a.{extension}"), numbers)
    };
    written.chain(["flt", "bil", "raw"].map(flat)).collect()
});

fuzz_target!(|bytes: &[u8]| {
    let [row, beside, text @ ..] = bytes else { return };
    let (name, content) = &FILES[usize::from(*row) % FILES.len()];
    let names = companions(name);
    if names.is_empty() {
        return;
    }
    let first = Companion { name: &names[usize::from(*beside) % names.len()], bytes: text };
    // With the top bit set all that may lie beside the file have this content.
    let all: Vec<_> = names.iter().map(|name| Companion { name, bytes: text }).collect();
    let companions = if *beside < 128 { std::slice::from_ref(&first) } else { &all[..] };
    let reading = Reading::from(Encoding::Auto);
    let bytes = &&content[..];
    let input = Input { name, bytes, companions, reading: &reading, limits: &LIMITS, work: Work::default() };
    let claim = input.claim();
    let _ = Owner::of(text, name);
    match input.read() {
        Ok(file) => {
            let claim = claim.expect("what can be read has a sound header");
            assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64]);
            assert_eq!(file.data.len(), file.cols * file.rows);
            assert!(file.data.len() as u64 <= LIMITS.samples);
            assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()));
        }
        Err(e) => assert!(e.to_string().ends_with(name.as_str()), "{e}"),
    }
});
