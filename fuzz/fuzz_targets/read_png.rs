//! Any bytes as `x.png`. `cargo +nightly fuzz run read_png`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| survive::survive("x.png", bytes, None));
