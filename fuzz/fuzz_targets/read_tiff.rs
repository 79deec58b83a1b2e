//! Any bytes as `x.tif`. `cargo +nightly fuzz run read_tiff`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| survive::survive("x.tif", bytes, None));
