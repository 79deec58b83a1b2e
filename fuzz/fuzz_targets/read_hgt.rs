//! Any bytes as `N01E002.hgt`. `cargo +nightly fuzz run read_hgt`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| survive::survive("N01E002.hgt", bytes, None));
