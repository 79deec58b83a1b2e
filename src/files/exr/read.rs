//! Reading leans on the `exr` crate, which knows every compression: block by block, so that of many channels only one
//! takes memory.

use std::io::BufReader;

use exr::block::chunk::Chunk;
use exr::block::reader::{ChunksReader, Reader};
use exr::block::{UncompressedBlock, read as open};
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::{MetaData, f16};
use rayon::prelude::*;

use super::super::error::Fault;
use super::super::height::{HeightFile, Limits, Origin, filled};
use super::super::input::{Claim, Input};
use super::super::place::Placement;
use super::super::raw::finite_or_void;
use super::CODEC;
use super::choose::{self, Pick};
use crate::source::Stream;

/// Bytes of blocks that are unpacked at once.
const AT_ONCE: usize = 1 << 25;

type Opened<'a> = Reader<BufReader<Stream<'a>>>;

/// What the header claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    guarded(|| {
        let reader = open_reader(input)?;
        let (pick, frame) = look(input, reader.headers())?;
        let header = &reader.headers()[pick.part];
        // Tables of blocks of all parts, twice while they are sorted; blocks packed, unpacked and put in order.
        let tables: u64 = reader.headers().iter().map(|h| 24 * h.chunk_count as u64).sum();
        let blocks = (3 * header.max_block_byte_size().max(1)).saturating_mul(at_once(header)) as u64;
        Claim::new(input, [frame.cols as u64, frame.rows as u64], tables.saturating_add(blocks))
    })
}

/// Reads the channel that holds heights.
pub(super) fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    guarded(|| read_channel(input))
}

fn read_channel(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let reader = open_reader(input)?;
    let (pick, frame) = look(input, reader.headers())?;
    let header = reader.headers()[pick.part].clone();
    let bands = reader.headers().iter().map(|h| h.channels.list.len()).sum();
    let part = pick.part;
    let full_size = |_: &MetaData, _, block: exr::block::BlockIndex| {
        block.layer == part && block.level.x() == 0 && block.level.y() == 0
    };
    let mut chunks = reader.filter_chunks(false, full_size).map_err(fault)?;
    let meta = chunks.meta_data().clone();
    let total = chunks.expected_chunk_count().max(1);
    let mut data = filled(frame.cols * frame.rows, f32::NAN, &input.work)?;
    let (mut done, batch) = (0, at_once(&header));
    loop {
        let packed: Vec<Chunk> = chunks.by_ref().take(batch).collect::<Result<_, _>>().map_err(fault)?;
        if packed.is_empty() {
            break;
        }
        done += packed.len();
        let unpack = |chunk| {
            input.work.check()?;
            UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(fault)
        };
        let blocks: Vec<_> = packed.into_par_iter().map(unpack).collect::<Result<_, _>>()?;
        for block in &blocks {
            input.work.check()?;
            frame.put(block, &header, &pick, &mut data)?;
        }
        input.work.step(done as f32 / total as f32)?;
    }
    let sample = header.channels.list[pick.channel].sample_type;
    let mut origin = Origin::new(&CODEC, sample_name(sample));
    origin.bands = bands;
    if bands > 1 {
        origin.notes.push(format!("{bands} channels, of which `{}` is read", pick.name));
    }
    origin.notes.extend(frame.notes(&header));
    let (cols, rows) = (frame.cols, frame.rows);
    let mut file = HeightFile { cols, rows, data, metres: true, placement: Placement::default(), origin };
    input.sidecar()?.apply(&mut file, None, input.reading);
    Ok(file)
}

fn open_reader<'a>(input: &Input<'a>) -> Result<Opened<'a>, Fault> {
    open(BufReader::new(Stream::new(input.bytes)), false).map_err(fault)
}

/// The channel to read and where its samples lie, with what they claim held against the limits.
fn look(input: &Input<'_>, headers: &[Header]) -> Result<(Pick, Frame), Fault> {
    let pick = choose::channel(headers, input.reading.channel.as_deref())?;
    let header = &headers[pick.part];
    if header.channels.list.iter().any(|c| c.sampling.x() != 1 || c.sampling.y() != 1) {
        return Err(Fault::unsupported("channels with fewer samples than the picture has pixels"));
    }
    let (cols, rows) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
    input.limits.samples(cols, rows)?;
    Limits::plausible(header.total_pixel_bytes() as u64, input.bytes.len())?;
    let frame = Frame::of(header);
    input.limits.samples(frame.cols as u64, frame.rows as u64)?;
    Ok((pick, frame))
}

/// How many blocks are unpacked at once.
fn at_once(header: &Header) -> usize {
    (AT_ONCE / header.max_block_byte_size().max(1)).clamp(1, 4 * rayon::current_num_threads())
}

fn sample_name(sample: SampleType) -> &'static str {
    match sample {
        SampleType::F32 => "f32",
        SampleType::F16 => "f16",
        SampleType::U32 => "u32",
    }
}

/// What is shown of a picture, and where its samples lie in that.
struct Frame {
    cols: usize,
    rows: usize,
    /// Column and row of the first sample; below zero where samples lie beyond.
    first: [i64; 2],
    /// Whether the window of samples and the one that is shown have something in common.
    meets: bool,
}

impl Frame {
    /// The display window; that of the samples where the two have nothing in common.
    fn of(header: &Header) -> Self {
        let shown = header.shared_attributes.display_window;
        let at = header.own_attributes.layer_position;
        let first = [0, 1].map(|k| {
            let [at, shown] = [at, shown.position].map(|p| if k == 0 { p.x() } else { p.y() });
            i64::from(at) - i64::from(shown)
        });
        let (cols, rows) = (shown.size.x(), shown.size.y());
        let size = [header.layer_size.x() as i64, header.layer_size.y() as i64];
        let meets = first[0] < cols as i64 && first[1] < rows as i64;
        let meets = meets && first[0] + size[0] > 0 && first[1] + size[1] > 0;
        if meets {
            Self { cols, rows, first, meets }
        } else {
            Self { cols: header.layer_size.x(), rows: header.layer_size.y(), first: [0, 0], meets }
        }
    }

    /// What a person should know of the windows.
    fn notes(&self, header: &Header) -> Vec<String> {
        let mut notes = Vec::new();
        let [x, y] = self.first;
        let (cols, rows) = (header.layer_size.x(), header.layer_size.y());
        if !self.meets {
            notes.push("its display window shows none of the samples; all of them are read".into());
        } else if (cols, rows) != (self.cols, self.rows) || self.first != [0, 0] {
            notes.push(format!(
                "its {cols} x {rows} samples begin at column {x}, row {y} of a display window of {} x {}; what is \
                 outside of them is void, what is outside of it is left out",
                self.cols, self.rows
            ));
        }
        let aspect = header.shared_attributes.pixel_aspect;
        if aspect.is_normal() && aspect != 1.0 {
            notes.push(format!("its pixels are {aspect} times as wide as they are high"));
        }
        notes
    }

    /// Puts the samples of a block into their places.
    fn put(
        &self,
        block: &UncompressedBlock,
        header: &Header,
        pick: &Pick,
        data: &mut [f32],
    ) -> Result<(), Fault> {
        let width = block.index.pixel_size.x();
        let channels = &header.channels.list;
        let bytes = |channel: usize| channels[channel].sample_type.bytes_per_sample();
        let start = |channel: usize| width * (0..channel).map(bytes).sum::<usize>();
        let line = start(channels.len()).max(1);
        let samples = |row: &[u8], channel: usize| row[start(channel)..][..width * bytes(channel)].to_vec();
        for (j, row) in block.data.chunks_exact(line).enumerate() {
            let own = samples(row, pick.channel);
            if pick.same.iter().any(|&other| samples(row, other) != own) {
                return Err(Fault::unsupported(
                    "a colour picture holds no heights; `channel` chooses one of `R`, `G`, `B`",
                ));
            }
            let [x, y] = self.first;
            let y = y + (block.index.pixel_position.y() + j) as i64;
            let Some(y) = usize::try_from(y).ok().filter(|y| *y < self.rows) else { continue };
            let out = &mut data[y * self.cols..][..self.cols];
            let x = x + block.index.pixel_position.x() as i64;
            let (skip, first) = ((-x).max(0) as usize, x.max(0) as usize);
            let values = numbers(&own, channels[pick.channel].sample_type);
            for (o, v) in out.iter_mut().skip(first).zip(values.skip(skip)) {
                *o = v;
            }
        }
        Ok(())
    }
}

/// The samples of a line, in the byte order of this machine.
fn numbers(bytes: &[u8], sample: SampleType) -> impl Iterator<Item = f32> {
    bytes.chunks_exact(sample.bytes_per_sample()).map(move |b| {
        let quad = || [b[0], b[1], b[2], b[3]];
        match sample {
            SampleType::F32 => finite_or_void(f32::from_ne_bytes(quad())),
            SampleType::F16 => finite_or_void(f16::from_ne_bytes([b[0], b[1]]).to_f32()),
            SampleType::U32 => u32::from_ne_bytes(quad()) as f32,
        }
    })
}

/// Turns a panic into an error: the `exr` crate divides and subtracts by what a damaged file says.
fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    // Nothing outlives the closure that could be left half done.
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    result.unwrap_or_else(|_| Err(Fault::damaged("its blocks contradict its header")))
}

fn fault(e: exr::error::Error) -> Fault {
    match e {
        exr::error::Error::NotSupported(what) => Fault::Unsupported(what.into_owned()),
        other => Fault::Damaged(other.to_string()),
    }
}
