//! Counter-based random numbers: a value is a pure function of seed and position, whatever the order of evaluation.

/// Mixes 64 bits into 64 bits, every input bit into every output bit (the finaliser of SplitMix64).
pub const fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The `index`-th number of the stream of a seed.
pub const fn nth(seed: u64, index: u64) -> u64 {
    mix(seed ^ mix(index))
}

/// The `index`-th number of the stream of a seed as a number in [0, 1).
pub const fn unit(seed: u64, index: u64) -> f64 {
    (nth(seed, index) >> 11) as f64 / (1u64 << 53) as f64
}
