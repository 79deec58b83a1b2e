//! Writing: blocks of sixteen lines, pressed with ZIP in parallel on the caller's threads.

use std::io::SeekFrom;

use super::super::bands::{self, Band};
use super::super::error::WriteError;
use super::super::sheet::{Sheet, Sink};
use super::super::write::Written;
use crate::value::Quantity;
use crate::work::Work;

/// Writes floats.
pub(super) fn floats(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    // Channels stand in alphabetical order.
    let (names, order): (&[&str], &[usize]) = match sheet.channels {
        1 => (&["Y"], &[0]),
        2 => (&["G", "R"], &[1, 0]),
        _ => (&["B", "G", "R"], &[2, 1, 0]),
    };
    let linear = sheet.quantity == Quantity::Color;
    rows(out, [sheet.cols, sheet.rows], names, &sheet.writing.work, |j, line| {
        let row = sheet.row(j);
        for (&channel, line) in order.iter().zip(line.chunks_exact_mut(sheet.cols * 4)) {
            let (floats, _) = line.as_chunks_mut::<4>();
            let values = row.iter().skip(channel).step_by(sheet.channels);
            for (o, &v) in floats.iter_mut().zip(values) {
                *o = (if linear { linear_light(v) } else { v }).to_le_bytes();
            }
        }
    })?;
    Ok(Written::default())
}

/// Light of an sRGB encoded number (IEC 61966-2-1): what OpenEXR holds.
fn linear_light(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { libm::powf((v + 0.055) / 1.055, 2.4) }
}

/// Lines of a ZIP block.
const BLOCK: usize = 16;
/// How hard blocks are pressed, as OpenEXR does by default.
const LEVEL: u32 = 4;

/// Writes a picture; `fill` gives the lines of one channel after the other, little-endian, channels in
/// alphabetical order.
fn rows(
    out: &mut dyn Sink,
    [cols, rows]: [usize; 2],
    channels: &[&str],
    work: &Work<'_>,
    fill: impl Fn(usize, &mut [u8]) + Sync,
) -> Result<(), WriteError> {
    out.write_all(&header(cols, rows, channels)?)?;
    let split = bands::Split::every(rows, BLOCK);
    let table = out.stream_position()?;
    out.write_all(&vec![0; split.count() * 8])?;
    let mut offsets = Vec::with_capacity(split.count() * 8);
    let mut at = table + split.count() as u64 * 8;
    let line = cols * channels.len() * 4;
    let press = |band: Band| {
        let mut raw = vec![0; band.rows * line];
        for (j, line) in raw.chunks_exact_mut(line).enumerate() {
            fill(band.first_row + j, line);
        }
        let packed = bands::zlib(&interleave(&raw), LEVEL);
        if packed.len() < raw.len() { packed } else { raw }
    };
    bands::in_order(&split, work, press, |band, block| {
        offsets.extend(at.to_le_bytes());
        // Both were checked to fit when the header was made.
        out.write_all(&(band.first_row as i32).to_le_bytes())?;
        out.write_all(&(block.len() as i32).to_le_bytes())?;
        out.write_all(&block)?;
        at += 8 + block.len() as u64;
        Ok(())
    })?;
    out.seek(SeekFrom::Start(table))?;
    out.write_all(&offsets)?;
    out.seek(SeekFrom::Start(at))?;
    Ok(())
}

/// Magic number, version and attributes, as in the OpenEXR file layout.
fn header(cols: usize, rows: usize, channels: &[&str]) -> Result<Vec<u8>, WriteError> {
    let too_large = || WriteError::Unfit {
        format: "exr",
        what: format!("{cols} x {rows} samples"),
        instead: "write tiles".into(),
    };
    let block = cols.checked_mul(channels.len() * 4 * BLOCK).and_then(|n| i32::try_from(n).ok());
    let (width, height) = (i32::try_from(cols), i32::try_from(rows));
    let (Ok(width), Ok(height), Some(_)) = (width, height, block) else { return Err(too_large()) };
    let mut out = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            out.extend_from_slice(text.as_bytes());
            out.push(0);
        }
        out.extend_from_slice(&(value.len() as i32).to_le_bytes());
        out.extend_from_slice(value);
    };
    let mut list = Vec::new();
    for name in channels {
        list.extend_from_slice(name.as_bytes());
        list.push(0);
        // Type f32, not linear in perception, three bytes of padding, sampled at every pixel.
        for word in [2u32, 0, 1, 1] {
            list.extend(word.to_le_bytes());
        }
    }
    list.push(0);
    let window: Vec<u8> = [0, 0, width - 1, height - 1].iter().flat_map(|v: &i32| v.to_le_bytes()).collect();
    let zip = [3];
    attribute("channels", "chlist", &list);
    attribute("compression", "compression", &zip);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    out.push(0);
    Ok(out)
}

/// What ZIP blocks do to bytes before they are deflated: even ones first, then odd ones, each as the difference to
/// the one before.
fn interleave(raw: &[u8]) -> Vec<u8> {
    let half = raw.len().div_ceil(2);
    let mut out = vec![0; raw.len()];
    let (even, odd) = out.split_at_mut(half);
    for (pair, (e, o)) in raw.chunks_exact(2).zip(even.iter_mut().zip(odd)) {
        (*e, *o) = (pair[0], pair[1]);
    }
    if let ([.., last], [.., e]) = (raw, &mut *even)
        && raw.len() % 2 == 1
    {
        *e = *last;
    }
    let mut before = out.first().copied().unwrap_or(0);
    for v in out.iter_mut().skip(1) {
        let here = *v;
        *v = here.wrapping_sub(before).wrapping_add(128);
        before = here;
    }
    out
}
