//! Any bytes as `x.asc`. `cargo +nightly fuzz run read_asc`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| survive::survive("x.asc", bytes, None));
