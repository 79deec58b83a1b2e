//! Rows in bands, pressed in parallel and written in order.
//!
//! How rows are split depends on their length alone, so the bytes are the same for any number of threads.

use std::io;

use flate2::{Compress, Compression, FlushCompress, Status};
use rayon::prelude::*;

use super::error::WriteError;
use crate::work::Work;

/// Bytes of a band before it is pressed: long enough that closing it costs nothing, short enough to share out.
const BAND_BYTES: usize = 1 << 18;

/// Bands a thread that are in memory at once: enough that no thread waits for the disk.
const AT_ONCE: usize = 8;
/// Rows of the tallest band that a format prescribes, whatever their length: the blocks of EXR.
const TALLEST: usize = 16;

/// Bytes that a writer takes beside what it writes: the bands that are in memory at once, and those at work with what
/// they are pressed into.
pub(super) fn held_bytes(cols: usize, channels: usize, threads: usize) -> u64 {
    let band = (TALLEST * cols * channels * size_of::<f32>()).max(BAND_BYTES);
    ((AT_ONCE + 3) * threads * band) as u64
}

/// Some rows that are pressed together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// First row.
    pub(super) first_row: usize,
    /// Rows.
    pub(super) rows: usize,
    /// Whether it is the last one.
    pub(super) last: bool,
}

/// Rows split into bands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    rows: usize,
    /// Rows in every band but the last.
    pub(super) band: usize,
}

impl Split {
    /// Bands of about [`BAND_BYTES`].
    pub(super) fn new(rows: usize, row_bytes: usize) -> Self {
        Self { rows, band: (BAND_BYTES / row_bytes.max(1)).clamp(1, rows.max(1)) }
    }

    /// Bands of a number of rows.
    pub(super) fn every(rows: usize, band: usize) -> Self {
        Self { rows, band: band.max(1) }
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.rows.div_ceil(self.band)
    }

    fn band(&self, index: usize) -> Band {
        let first_row = index * self.band;
        let rows = self.band.min(self.rows - first_row);
        Band { first_row, rows, last: first_row + rows == self.rows }
    }
}

/// Makes something of every band in parallel and takes the results in order, a few bands in memory at a time.
pub(super) fn in_order<T: Send>(
    split: &Split,
    work: &Work<'_>,
    make: impl Fn(Band) -> T + Sync,
    mut take: impl FnMut(Band, T) -> io::Result<()>,
) -> Result<(), WriteError> {
    let (count, batch) = (split.count(), AT_ONCE * rayon::current_num_threads());
    for first in (0..count).step_by(batch) {
        work.step(first as f32 / count as f32)?;
        let made: Vec<_> =
            (first..count.min(first + batch)).into_par_iter().map(|i| make(split.band(i))).collect();
        for (i, made) in made.into_iter().enumerate() {
            take(split.band(first + i), made)?;
        }
    }
    Ok(work.step(1.0)?)
}

/// Deflates a part of a stream: the parts one after the other are one stream.
pub(super) fn deflate_part(data: &[u8], level: u32, last: bool) -> Vec<u8> {
    deflate(data, Compress::new(Compression::new(level), false), last)
}

/// Deflates into a zlib stream of its own.
pub(super) fn zlib(data: &[u8], level: u32) -> Vec<u8> {
    deflate(data, Compress::new(Compression::new(level), true), true)
}

fn deflate(mut data: &[u8], mut press: Compress, last: bool) -> Vec<u8> {
    let flush = if last { FlushCompress::Finish } else { FlushCompress::Sync };
    let mut out = Vec::with_capacity(data.len() / 2 + 1024);
    loop {
        let (before_in, before_out) = (press.total_in(), out.len());
        // The only error of deflate is a state that this loop never brings about.
        let status = press.compress_vec(data, &mut out, flush).unwrap_or(Status::StreamEnd);
        data = &data[(press.total_in() - before_in) as usize..];
        let full = out.len() == out.capacity();
        let done = status == Status::StreamEnd || (!last && data.is_empty() && !full);
        if done || (!full && before_out == out.len()) {
            return out;
        }
        out.reserve(out.capacity().max(1024));
    }
}

/// The Adler-32 sum of some bytes, which can be put together from parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adler {
    a: u32,
    b: u32,
    len: u64,
}

impl Default for Adler {
    fn default() -> Self {
        Self { a: 1, b: 0, len: 0 }
    }
}

const ADLER_BASE: u32 = 65521;

impl Adler {
    pub(super) fn of(data: &[u8]) -> Self {
        let (mut a, mut b) = (1u64, 0u64);
        // In a block the second sum is the first times the length, plus each byte times its distance to the end.
        for block in data.chunks(1 << 12) {
            let n = block.len() as u32;
            let sum: u32 = block.iter().map(|&v| u32::from(v)).sum();
            let far: u64 = block
                .chunks(256)
                .enumerate()
                .map(|(k, part)| {
                    let weigh = |(i, &v): (usize, &u8)| (n - (k * 256 + i) as u32) * u32::from(v);
                    u64::from(part.iter().enumerate().map(weigh).sum::<u32>())
                })
                .sum();
            b = (b + u64::from(n) * a + far) % u64::from(ADLER_BASE);
            a = (a + u64::from(sum)) % u64::from(ADLER_BASE);
        }
        Self { a: a as u32, b: b as u32, len: data.len() as u64 }
    }

    /// The sum of these bytes and then those of `next`.
    pub(super) fn then(self, next: Self) -> Self {
        let base = u64::from(ADLER_BASE);
        let (a1, b1) = (u64::from(self.a), u64::from(self.b));
        let (a2, b2) = (u64::from(next.a), u64::from(next.b));
        let a = (a1 + a2 + base - 1) % base;
        let b = (b1 + b2 + (next.len % base) * (a1 + base - 1)) % base;
        Self { a: a as u32, b: b as u32, len: self.len + next.len }
    }

    pub(super) fn value(self) -> u32 {
        self.b << 16 | self.a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn noise(n: usize) -> Vec<u8> {
        (0..n).map(|i| (crate::kit::hash::nth(3, i as u64) & 0x3f) as u8).collect()
    }

    /// RFC 1950, section 9, computed the slow way.
    fn adler(data: &[u8]) -> u32 {
        let (mut a, mut b) = (1, 0);
        for &v in data {
            a = (a + u32::from(v)) % ADLER_BASE;
            b = (b + a) % ADLER_BASE;
        }
        b << 16 | a
    }

    #[test]
    fn adler_sums_are_right_and_join() {
        let data = [noise(70_001), vec![255; 9000]].concat();
        for cut in [0, 1, 4096, 5000, 65_521, 79_001] {
            let (head, tail) = data.split_at(cut);
            assert_eq!(Adler::of(head).value(), adler(head));
            assert_eq!(Adler::default().then(Adler::of(head)).then(Adler::of(tail)).value(), adler(&data));
        }
    }

    #[test]
    fn parts_make_one_stream() {
        let data = noise(300_000);
        for sizes in [vec![300_000], vec![1, 299_999], vec![100_000, 0, 200_000]] {
            let (mut stream, mut at) = (vec![0x78, 0x5e], 0);
            for (i, n) in sizes.iter().enumerate() {
                stream.extend(deflate_part(&data[at..at + n], 6, i + 1 == sizes.len()));
                at += n;
            }
            stream.extend(adler(&data).to_be_bytes());
            let mut back = Vec::new();
            flate2::read::ZlibDecoder::new(&stream[..]).read_to_end(&mut back).expect("inflates");
            assert!(back == data, "parts of {sizes:?}");
        }
    }
}
