//! Any bytes as `x.r16` and `x.r32`, the first of them as a sidecar. `cargo +nightly fuzz run read_raw`.
#![no_main]

mod survive;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&n, rest)) = bytes.split_first() else { return };
    let (sidecar, samples) = rest.split_at(usize::from(n).min(rest.len()));
    let sidecar = (n > 0).then_some(sidecar);
    for name in ["x.r16", "x.r32"] {
        survive::survive(name, samples, sidecar);
    }
});
