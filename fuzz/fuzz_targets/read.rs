//! Any bytes as any height file, with any bytes beside it: an error or a sound file, within the limits.
//! `cargo +nightly fuzz run read`.
//!
//! The first byte chooses a row of the table of formats, the second how much of the rest lies beside the file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use orograph::files::{Codec, Companion, Encoding, Format, Input, Limits, Reading, encode_file, read_height};
use orograph::work::Work;

fuzz_target!(
    init: {
        // The `exr` crate panics on some damaged blocks and the reader turns that into an error: only other panics count.
        let ours = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !panic.location().is_some_and(|l| l.file().contains("/exr-")) {
                ours(panic);
            }
        }));
    },
    |bytes: &[u8]| {
        let [row, beside, rest @ ..] = bytes else { return };
        let codec = Codec::all()[usize::from(*row) % Codec::all().len()];
        let name = format!("N01E002.{}", codec.extensions[0]);
        let (beside, content) = rest.split_at(usize::from(*beside).min(rest.len()));
        let names = orograph::files::companions(&name);
        let companions: Vec<_> = if beside.is_empty() {
            Vec::new()
        } else {
            names.iter().map(|name| Companion { name, bytes: beside }).collect()
        };
        survive(&name, content, &companions);
    }
);

const LIMITS: Limits = Limits { samples: 1 << 16, side: 1 << 10 };

/// Reads bytes under a name; what can be read can be written and read again.
fn survive(name: &str, bytes: &[u8], companions: &[Companion<'_>]) {
    let reading = Reading::from(Encoding::Auto);
    let input =
        Input { name, bytes: &bytes, companions, reading: &reading, limits: &LIMITS, work: Work::default() };
    let claim = input.claim();
    let file = match input.read() {
        Ok(file) => {
            let claim = claim.expect("what can be read has a sound header");
            assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64]);
            file
        }
        Err(e) => {
            assert!(e.to_string().ends_with(name));
            return;
        }
    };
    assert_eq!(file.data.len(), file.cols * file.rows);
    assert!(file.data.len() as u64 <= LIMITS.samples);
    assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()));
    let mut out = std::io::Cursor::new(Vec::new());
    encode_file(&file, &Format::Tiff.into(), &mut out).expect("floats hold any height");
    let again =
        read_height("again.tif", &out.into_inner(), None, &LIMITS).expect("what was written can be read");
    assert!(again.data.iter().zip(&file.data).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
}
