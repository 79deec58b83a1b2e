//! Reading: grey values, or Terrarium heights.

use std::io::Cursor;

use png::{BitDepth, ColorType, DecodingError, Transformations};

use super::super::error::Fault;
use super::super::height::{Encoding, HeightFile, Limits, Origin, room};
use super::super::input::{Claim, Input};
use super::super::place::Placement;
use super::CODEC;

/// What Terrarium adds to a height, in metres.
const TERRARIUM_OFFSET: f32 = 32768.0;
/// Heights on Earth, in metres, with room: what makes sense as Terrarium.
const ON_EARTH: [f32; 2] = [-12_000.0, 9_500.0];

/// What the header claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let mut decoder = ::png::Decoder::new(Cursor::new(input.bytes));
    let info = decoder.read_header_info().map_err(fault)?;
    let (cols, rows) = (u64::from(info.width), u64::from(info.height));
    input.limits.samples(cols, rows)?;
    let line = (cols * info.bits_per_pixel() as u64).div_ceil(8);
    Limits::plausible(line * rows, input.bytes.len())?;
    // Rows of the decoder, expanded and not; a whole picture where it is interlaced.
    let expanded = cols * 8;
    let decoder = if info.interlaced { expanded * rows } else { 4 * expanded };
    Claim::new(input, [cols, rows], decoder + (1 << 18))
}

/// Reads heights from a picture.
pub(super) fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let mut decoder = ::png::Decoder::new(Cursor::new(input.bytes));
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // The claim was checked: the decoder needs no limit of its own.
    decoder.set_limits(::png::Limits { bytes: usize::MAX });
    let mut reader = decoder.read_info().map_err(fault)?;
    let (cols, rows) = (reader.info().width as usize, reader.info().height as usize);
    let total = cols * rows;
    let (color, depth) = reader.output_color_type();
    let sample = if depth == BitDepth::Sixteen { "u16" } else { "u8" };
    let levels = if depth == BitDepth::Sixteen { 65535.0 } else { 255.0 };
    let mut pixels = Pixels::new(color, depth, input.reading.encoding, total)?;
    if reader.info().interlaced {
        let size = reader.output_buffer_size().ok_or_else(|| Fault::damaged("a picture too large"))?;
        let mut whole = room(size)?;
        whole.resize(size, 0);
        reader.next_frame(&mut whole).map_err(fault)?;
        pixels.take(&whole);
    } else {
        let mut row = 0;
        while let Some(line) = reader.next_row().map_err(fault)? {
            pixels.take(line.data());
            row += 1;
            input.watch.check(row as f32 / rows as f32)?;
        }
    }
    if pixels.data.len() != total {
        let found = pixels.data.len();
        return Err(Fault::Damaged(format!("{found} pixels of {total}")));
    }
    let (data, terrarium) = pixels.finish()?;
    let mut origin = Origin::new(&CODEC, if terrarium { "terrarium" } else { sample });
    origin.plain = !terrarium;
    origin.bands = color.samples();
    let mut file =
        HeightFile { cols, rows, data, metres: terrarium, placement: Placement::default(), origin };
    input.sidecar()?.apply(&mut file, (!terrarium).then_some(levels));
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
        Ok(Self { channels, wide, terrarium, guess, all_grey: true, data: room(total)? })
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
