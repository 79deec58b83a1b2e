//! Writing: the rows go out in bands, each filtered and deflated by itself and closed with a sync flush, so that the
//! bands put together are one zlib stream, the same for any number of threads.

use std::io;

use super::super::bands::{self, Band};
use super::super::error::WriteError;
use super::super::sheet::{Sheet, Sink};
use super::super::write::Written;
use crate::work::Work;

/// Writes 8 bits a channel.
pub(super) fn eight(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    write(sheet, 1, out)
}

/// Writes 16 bits a channel.
pub(super) fn sixteen(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    write(sheet, 2, out)
}

fn write(sheet: &Sheet<'_>, bytes: usize, out: &mut dyn Sink) -> Result<Written, WriteError> {
    sheet.no_voids()?;
    let (q, written) = sheet.quantizer()?;
    let header = Header { cols: sheet.cols, rows: sheet.rows, channels: sheet.channels, bytes };
    rows(out, header, &sheet.writing.work, |j, line| {
        let row = sheet.row(j);
        match bytes {
            1 => line.iter_mut().zip(row).for_each(|(o, v)| *o = q.level(*v) as u8),
            _ => {
                let (words, _) = line.as_chunks_mut::<2>();
                words.iter_mut().zip(row).for_each(|(o, v)| *o = (q.level(*v) as u16).to_be_bytes());
            }
        }
    })?;
    Ok(written)
}

/// What a PNG holds.
#[derive(Clone, Copy, Debug)]
struct Header {
    cols: usize,
    rows: usize,
    /// 1 for grey, 3 for colour.
    channels: usize,
    /// 1 or 2 bytes a channel.
    bytes: usize,
}

/// How hard rows are pressed: 4 is where height fields stop shrinking much and time starts growing.
const LEVEL: u32 = 4;

/// Writes a picture whose rows `fill` gives, big-endian.
fn rows(
    out: &mut dyn Sink,
    header: Header,
    work: &Work<'_>,
    fill: impl Fn(usize, &mut [u8]) + Sync,
) -> Result<(), WriteError> {
    let Header { cols, rows, channels, bytes } = header;
    let side = |n: usize| {
        u32::try_from(n).ok().filter(|n| *n <= i32::MAX as u32).ok_or_else(|| WriteError::Unfit {
            format: "png",
            what: format!("{n} samples along a side"),
            instead: "write tiles".into(),
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
    bands::in_order(&split, work, deflate, |band, (packed, adler)| {
        sum = sum.then(adler);
        let head: &[u8] = if band.first_row == 0 { &[0x78, 0x5e] } else { &[] };
        let tail = sum.value().to_be_bytes();
        let tail: &[u8] = if band.last { &tail } else { &[] };
        chunk(out, b"IDAT", &[head, &packed, tail])
    })?;
    chunk(out, b"IEND", &[])?;
    Ok(())
}

fn chunk(out: &mut dyn Sink, kind: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
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
