//! Reading leans on the `exr` crate, which knows every compression.

use std::io::Cursor;

use exr::prelude::{AnyChannel, FlatSamples, MetaData, ReadChannels, ReadLayers};

use super::super::error::Fault;
use super::super::height::{HeightFile, Limits, Origin};
use super::super::input::{Claim, Input};
use super::super::place::Placement;
use super::super::raw::finite_or_void;
use super::CODEC;

/// Names of the channel that holds heights, the likeliest first.
const HEIGHT_CHANNELS: [&str; 7] = ["y", "z", "height", "h", "elevation", "r", "x"];

/// Reads the channel of a picture that holds heights.
pub(super) fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let image = guarded(|| read_first_layer(input.bytes))?;
    let layer = image.layer_data;
    let (cols, rows) = (layer.size.x(), layer.size.y());
    let channels = layer.channel_data.list;
    let bands = channels.len();
    let rank = |c: &AnyChannel<FlatSamples>| {
        let name = c.name.to_string().to_ascii_lowercase();
        HEIGHT_CHANNELS.iter().position(|n| *n == name).unwrap_or(HEIGHT_CHANNELS.len())
    };
    let chosen = channels.into_iter().min_by_key(rank).ok_or_else(|| Fault::damaged("no channel"))?;
    let mut origin = Origin::new(&CODEC, "f32");
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
    input.sidecar()?.apply(&mut file, None);
    Ok(file)
}

/// Turns a panic into an error: the `exr` crate divides and subtracts by what a damaged file says.
fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    // Nothing outlives the closure that could be left half done.
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    result.unwrap_or_else(|_| Err(Fault::damaged("its blocks contradict its header")))
}

/// What the header claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    guarded(|| claim_of(input))
}

fn claim_of(input: &Input<'_>) -> Result<Claim, Fault> {
    let Input { bytes, limits, .. } = *input;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
    let (mut claimed, mut size) = (0u64, [0; 2]);
    for header in &meta.headers {
        if header.deep {
            return Err(Fault::unsupported("deep pictures"));
        }
        if header.channels.list.iter().any(|c| c.sampling.x() != 1 || c.sampling.y() != 1) {
            return Err(Fault::unsupported("channels with fewer samples than the picture has pixels"));
        }
        let (cols, rows) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
        limits.samples(cols, rows)?;
        size = [cols, rows];
        claimed = claimed.saturating_add(header.total_pixel_bytes() as u64);
        // Every channel of a layer is unpacked, so they count together.
        if claimed / 4 > limits.samples {
            let (samples, side) = (limits.samples, limits.side);
            return Err(Fault::Size { cols, rows, samples, side });
        }
    }
    Limits::plausible(claimed, bytes.len())?;
    Claim::new(input, size, claimed)
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
