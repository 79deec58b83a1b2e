//! PNG: grey heights, Terrarium heights, masks and pictures.
//!
//! Reading leans on the `png` crate. Writing is our own, since that crate compresses on one thread: the rows go out
//! in bands, each filtered and deflated by itself and closed with a sync flush, so that the bands put together are
//! one zlib stream, the same for any number of threads.

use std::io::{self, Cursor, Write};

use png::{BitDepth, ColorType, DecodingError, Transformations};

use super::bands::{self, Band};
use super::error::{Fault, WriteError};
use super::format::Source;
use super::height::{Encoding, HeightFile, Limits, Origin};
use super::place::Placement;
use super::sidecar::Sidecar;

/// What Terrarium adds to a height, in metres.
const TERRARIUM_OFFSET: f32 = 32768.0;
/// Heights on Earth, in metres, with room: what makes sense as Terrarium.
const ON_EARTH: [f32; 2] = [-12_000.0, 9_500.0];

/// Reads heights from a picture.
pub(super) fn read(
    bytes: &[u8],
    sidecar: &Sidecar,
    limits: &Limits,
    encoding: Encoding,
) -> Result<HeightFile, Fault> {
    let mut decoder = ::png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(fault)?;
    let (cols, rows) = (u64::from(info.width), u64::from(info.height));
    let total = limits.samples(cols, rows)?;
    let line = u64::from(info.width) * info.bits_per_pixel() as u64 / 8;
    Limits::plausible(line * rows, bytes.len())?;
    // Room for the decoder's own rows and for a whole picture where it is interlaced.
    decoder.set_limits(::png::Limits { bytes: usize::MAX });
    let mut reader = decoder.read_info().map_err(fault)?;
    let (color, depth) = reader.output_color_type();
    let sample = if depth == BitDepth::Sixteen { "u16" } else { "u8" };
    let levels = if depth == BitDepth::Sixteen { 65535.0 } else { 255.0 };
    let mut pixels = Pixels::new(color, depth, encoding, total)?;
    if reader.info().interlaced {
        let size = reader.output_buffer_size().ok_or_else(|| Fault::damaged("a picture too large"))?;
        let mut whole = vec![0; size];
        reader.next_frame(&mut whole).map_err(fault)?;
        pixels.take(&whole);
    } else {
        while let Some(row) = reader.next_row().map_err(fault)? {
            pixels.take(row.data());
        }
    }
    if pixels.data.len() != total {
        let found = pixels.data.len();
        return Err(Fault::Damaged(format!("{found} pixels of {total}")));
    }
    let bands = color.samples();
    let (data, terrarium) = pixels.finish()?;
    let mut origin = Origin::new(Source::Png, if terrarium { "terrarium" } else { sample });
    origin.plain = !terrarium;
    origin.bands = bands;
    let (cols, rows) = (cols as usize, rows as usize);
    let mut file =
        HeightFile { cols, rows, data, metres: terrarium, placement: Placement::default(), origin };
    sidecar.apply(&mut file, (!terrarium).then_some(levels));
    Ok(file)
}

fn fault(e: DecodingError) -> Fault {
    Fault::Damaged(e.to_string())
}

/// Collects pixels as heights.
struct Pixels {
    channels: usize,
    wide: bool,
    /// Whether pixels are read as Terrarium; grey ones are turned back at the end where that was a guess.
    terrarium: bool,
    guess: bool,
    all_grey: bool,
    data: Vec<f32>,
}

impl Pixels {
    fn new(color: ColorType, depth: BitDepth, encoding: Encoding, total: usize) -> Result<Self, Fault> {
        let channels = color.samples();
        let wide = depth == BitDepth::Sixteen;
        let colored = channels >= 3;
        if encoding == Encoding::Terrarium && (!colored || wide) {
            return Err(Fault::unsupported("a Terrarium tile has three channels of 8 bits"));
        }
        let terrarium = colored && !wide && encoding != Encoding::Grey;
        let guess = terrarium && encoding == Encoding::Auto;
        Ok(Self { channels, wide, terrarium, guess, all_grey: true, data: Vec::with_capacity(total) })
    }

    fn take(&mut self, line: &[u8]) {
        let room = self.data.capacity() - self.data.len();
        if self.wide {
            let (words, _) = line.as_chunks::<2>();
            let pixels = words.chunks_exact(self.channels).take(room);
            let of = |w: [u8; 2]| f32::from(u16::from_be_bytes(w));
            for p in pixels {
                self.all_grey &= p.len() < 3 || (p[0] == p[1] && p[1] == p[2]);
                let clear = p.len() % 2 == 0 && p[p.len() - 1] == [0, 0];
                self.data.push(if clear { f32::NAN } else { of(p[0]) });
            }
            return;
        }
        for p in line.chunks_exact(self.channels).take(room) {
            self.all_grey &= p.len() < 3 || (p[0] == p[1] && p[1] == p[2]);
            let clear = p.len() % 2 == 0 && p[p.len() - 1] == 0;
            let v = if self.terrarium {
                f32::from(p[0]) * 256.0 + f32::from(p[1]) + f32::from(p[2]) / 256.0 - TERRARIUM_OFFSET
            } else {
                f32::from(p[0])
            };
            self.data.push(if clear { f32::NAN } else { v });
        }
    }

    /// The samples, and whether they are Terrarium metres.
    fn finish(mut self) -> Result<(Vec<f32>, bool), Fault> {
        let colored = self.channels >= 3;
        if self.guess && self.all_grey {
            // A grey value v was taken for v (256 + 1 + 1 / 256) - 32768, which f32 holds exactly.
            for v in &mut self.data {
                *v = ((*v + TERRARIUM_OFFSET) / 257.003_9).round();
            }
            return Ok((self.data, false));
        }
        if colored && !self.terrarium && !self.all_grey {
            return Err(Fault::unsupported("a colour picture holds no heights"));
        }
        if self.guess {
            let off = |v: &&f32| !v.is_nan() && !(ON_EARTH[0]..=ON_EARTH[1]).contains(*v);
            if let Some(v) = self.data.iter().find(off) {
                return Err(Fault::Unsupported(format!(
                    "a colour picture that is no Terrarium tile either: it would be {v} m high"
                )));
            }
        }
        Ok((self.data, self.terrarium))
    }
}

/// What a PNG holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub(super) cols: usize,
    pub(super) rows: usize,
    /// 1 for grey, 3 for colour.
    pub(super) channels: usize,
    /// 1 or 2 bytes a channel.
    pub(super) bytes: usize,
}

/// How hard rows are pressed: 4 is where height fields stop shrinking much and time starts growing.
const LEVEL: u32 = 4;

/// Writes a picture whose rows `fill` gives, big-endian.
pub(super) fn write(
    out: &mut impl Write,
    header: Header,
    watch: &bands::Watch<'_>,
    fill: impl Fn(usize, &mut [u8]) + Sync,
) -> Result<(), WriteError> {
    let Header { cols, rows, channels, bytes } = header;
    let side = |n: usize| {
        u32::try_from(n).ok().filter(|n| *n <= i32::MAX as u32).ok_or_else(|| WriteError::Unfit {
            format: "png",
            what: format!("{n} samples along a side"),
            instead: "write tiles",
        })
    };
    let mut ihdr = Vec::with_capacity(13);
    ihdr.extend(side(cols)?.to_be_bytes());
    ihdr.extend(side(rows)?.to_be_bytes());
    ihdr.extend([bytes as u8 * 8, if channels == 3 { 2 } else { 0 }, 0, 0, 0]);
    out.write_all(&[0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a])?;
    chunk(out, b"IHDR", &[&ihdr])?;
    if channels == 3 {
        // Rendering intent: perceptual. The colours of a graph are sRGB encoded.
        chunk(out, b"sRGB", &[&[0]])?;
    }
    let (line, pixel) = (cols * channels * bytes, channels * bytes);
    let split = bands::Split::new(rows, line + 1);
    let mut sum = bands::Adler::default();
    let deflate = |band: Band| {
        let filtered = filter(&band, line, pixel, &fill);
        let adler = bands::Adler::of(&filtered);
        (bands::deflate_part(&filtered, LEVEL, band.last), adler)
    };
    bands::in_order(&split, watch, deflate, |band, (packed, adler)| {
        sum = sum.then(adler);
        let head: &[u8] = if band.first_row == 0 { &[0x78, 0x5e] } else { &[] };
        let tail = sum.value().to_be_bytes();
        let tail: &[u8] = if band.last { &tail } else { &[] };
        chunk(out, b"IDAT", &[head, &packed, tail])
    })?;
    chunk(out, b"IEND", &[])?;
    Ok(())
}

fn chunk(out: &mut impl Write, kind: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
    let length: usize = parts.iter().map(|p| p.len()).sum();
    let length = u32::try_from(length).map_err(|_| io::Error::other("a chunk too long"))?;
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    out.write_all(&length.to_be_bytes())?;
    out.write_all(kind)?;
    for part in parts {
        crc.update(part);
        out.write_all(part)?;
    }
    out.write_all(&crc.sum().to_be_bytes())
}

/// The rows of a band, each behind its filter's number.
///
/// The filter is Paeth where it pays, Sub or Up where the sum of absolute differences is smaller: the usual
/// heuristic of the PNG specification, chapter 12.8.
fn filter(band: &Band, line: usize, pixel: usize, fill: &(impl Fn(usize, &mut [u8]) + Sync)) -> Vec<u8> {
    let mut out = Vec::with_capacity(band.rows * (line + 1));
    let (mut above, mut here) = (vec![0; line], vec![0; line]);
    let mut tries = [vec![0; line], vec![0; line], vec![0; line]];
    if band.first_row > 0 {
        fill(band.first_row - 1, &mut above);
    }
    for j in band.first_row..band.first_row + band.rows {
        fill(j, &mut here);
        let best = best_filter(&mut tries, &above, &here, pixel);
        out.push([1, 2, 4][best]);
        out.extend_from_slice(&tries[best]);
        std::mem::swap(&mut above, &mut here);
    }
    out
}

/// Filters a row by Sub, Up and Paeth and says which to take.
fn best_filter(tries: &mut [Vec<u8>; 3], above: &[u8], here: &[u8], pixel: usize) -> usize {
    let n = here.len();
    let [sub, up, paeth] = tries;
    let head = pixel.min(n);
    sub[..head].copy_from_slice(&here[..head]);
    for (o, (x, a)) in sub[head..].iter_mut().zip(here[head..].iter().zip(here)) {
        *o = x.wrapping_sub(*a);
    }
    for (o, (x, b)) in up.iter_mut().zip(here.iter().zip(above)) {
        *o = x.wrapping_sub(*b);
    }
    paeth[..head].copy_from_slice(&up[..head]);
    let left = here.iter().zip(above);
    let right = here[head..].iter().zip(&above[head..]);
    for (o, ((x, b), (a, c))) in paeth[head..].iter_mut().zip(right.zip(left)) {
        *o = x.wrapping_sub(predict(*a, *b, *c));
    }
    let cost = |row: &[u8]| -> u64 {
        // Sums of one chunk fit 32 bits, in which the loop runs vectorised.
        let part = |c: &[u8]| c.iter().map(|v| u32::from((*v as i8).unsigned_abs())).sum::<u32>();
        row.chunks(1 << 16).map(|c| u64::from(part(c))).sum()
    };
    let costs = [cost(sub), cost(up), cost(paeth)];
    if costs[2] <= costs[0].min(costs[1]) { 2 } else { usize::from(costs[1] < costs[0]) }
}

/// The Paeth predictor: whichever of left, above and above left is nearest to left + above - above left.
fn predict(a: u8, b: u8, c: u8) -> u8 {
    let (ia, ib, ic) = (i16::from(a), i16::from(b), i16::from(c));
    let (pa, pb, pc) = ((ib - ic).abs(), (ia - ic).abs(), (ia + ib - 2 * ic).abs());
    let bc = if pb <= pc { b } else { c };
    if pa <= pb && pa <= pc { a } else { bc }
}
