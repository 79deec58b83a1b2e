//! OpenEXR: 32-bit float heights and pictures.
//!
//! Reading leans on the `exr` crate, which knows every compression. Writing is our own: blocks of sixteen lines,
//! pressed with ZIP in parallel on the caller's threads.

use std::io::{Cursor, Seek, SeekFrom, Write};

use exr::prelude::{AnyChannel, FlatSamples, MetaData, ReadChannels, ReadLayers};

use super::bands::{self, Band};
use super::error::{Fault, WriteError};
use super::format::Source;
use super::height::{HeightFile, Limits, Origin};
use super::place::Placement;
use super::raw::finite_or_void;
use super::sidecar::Sidecar;

/// Names of the channel that holds heights, the likeliest first.
const HEIGHT_CHANNELS: [&str; 7] = ["y", "z", "height", "h", "elevation", "r", "x"];

/// Reads the channel of a picture that holds heights.
pub(super) fn read(bytes: &[u8], sidecar: &Sidecar, limits: &Limits) -> Result<HeightFile, Fault> {
    guarded(|| check(bytes, limits))?;
    let image = guarded(|| read_first_layer(bytes))?;
    let layer = image.layer_data;
    let (cols, rows) = (layer.size.x(), layer.size.y());
    let channels = layer.channel_data.list;
    let bands = channels.len();
    let rank = |c: &AnyChannel<FlatSamples>| {
        let name = c.name.to_string().to_ascii_lowercase();
        HEIGHT_CHANNELS.iter().position(|n| *n == name).unwrap_or(HEIGHT_CHANNELS.len())
    };
    let chosen = channels.into_iter().min_by_key(rank).ok_or_else(|| Fault::damaged("no channel"))?;
    let mut origin = Origin::new(Source::Exr, "f32");
    origin.bands = bands;
    if bands > 1 {
        origin.notes.push(format!("{bands} channels, of which `{}` is read", chosen.name));
    }
    let data: Vec<f32> = match chosen.sample_data {
        FlatSamples::F32(v) => v.into_iter().map(finite_or_void).collect(),
        FlatSamples::F16(v) => {
            origin.sample = "f16";
            v.into_iter().map(|h| finite_or_void(h.to_f32())).collect()
        }
        FlatSamples::U32(v) => {
            origin.sample = "u32";
            v.into_iter().map(|u| u as f32).collect()
        }
    };
    if data.len() != cols * rows {
        return Err(Fault::damaged("a channel of the wrong size"));
    }
    let mut file = HeightFile { cols, rows, data, metres: true, placement: Placement::default(), origin };
    sidecar.apply(&mut file, None);
    Ok(file)
}

/// Turns a panic into an error: the `exr` crate divides and subtracts by what a damaged file says.
fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    // Nothing outlives the closure that could be left half done.
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    result.unwrap_or_else(|_| Err(Fault::damaged("its blocks contradict its header")))
}

/// Checks what the header claims.
fn check(bytes: &[u8], limits: &Limits) -> Result<(), Fault> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
    let mut claimed = 0u64;
    for header in &meta.headers {
        if header.deep {
            return Err(Fault::unsupported("deep pictures"));
        }
        if header.channels.list.iter().any(|c| c.sampling.x() != 1 || c.sampling.y() != 1) {
            return Err(Fault::unsupported("channels with fewer samples than the picture has pixels"));
        }
        let (cols, rows) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
        limits.samples(cols, rows)?;
        claimed = claimed.saturating_add(header.total_pixel_bytes() as u64);
        // Every channel of a layer is unpacked, so they count together.
        if claimed / 4 > limits.samples {
            let (samples, side) = (limits.samples, limits.side);
            return Err(Fault::Size { cols, rows, samples, side });
        }
    }
    Limits::plausible(claimed, bytes.len())
}

type FirstLayer = exr::image::Image<exr::image::Layer<exr::image::AnyChannels<FlatSamples>>>;

fn read_first_layer(bytes: &[u8]) -> Result<FirstLayer, Fault> {
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let reader = reader.first_valid_layer().all_attributes().non_parallel();
    reader.from_buffered(Cursor::new(bytes)).map_err(fault)
}

fn fault(e: exr::error::Error) -> Fault {
    match e {
        exr::error::Error::NotSupported(what) => Fault::Unsupported(what.into_owned()),
        other => Fault::Damaged(other.to_string()),
    }
}

/// Lines of a ZIP block.
const BLOCK: usize = 16;
/// How hard blocks are pressed, as OpenEXR does by default.
const LEVEL: u32 = 4;

/// Writes a picture; `fill` gives the lines of one channel after the other, little-endian, channels in
/// alphabetical order.
pub(super) fn write(
    out: &mut (impl Write + Seek),
    [cols, rows]: [usize; 2],
    channels: &[&str],
    watch: &bands::Watch<'_>,
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
    bands::in_order(&split, watch, press, |band, block| {
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
        instead: "write tiles",
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
