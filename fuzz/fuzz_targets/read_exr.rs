//! Any bytes as `x.exr`. `cargo +nightly fuzz run read_exr`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| survive::survive("x.exr", bytes, None));
