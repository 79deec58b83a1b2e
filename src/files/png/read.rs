//! Reading: grey values, or Terrarium heights.

use std::io::BufReader;

use png::{BitDepth, ColorType, DecodingError, InterlaceInfo, Transformations};

use super::super::error::Fault;
use super::super::height::{Encoding, HeightFile, Limits, Origin, room};
use super::super::input::{Claim, Input};
use super::super::world;
use super::{CODEC, colors};
use crate::source::Stream;

/// What the header claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let mut decoder = ::png::Decoder::new(BufReader::new(Stream::new(input.bytes)));
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
    let mut decoder = ::png::Decoder::new(BufReader::new(Stream::new(input.bytes)));
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
        let (line, bits) =
            (size / rows, 8 * color.samples() * if depth == BitDepth::Sixteen { 2 } else { 1 });
        while let Some(row) = reader.next_interlaced_row().map_err(fault)? {
            if let InterlaceInfo::Adam7(pass) = row.interlace() {
                ::png::expand_interlaced_row(&mut whole, line, row.data(), pass, bits as u8);
            }
            input.work.check()?;
        }
        pixels.take(&whole);
    } else {
        let mut row = 0;
        while let Some(line) = reader.next_row().map_err(fault)? {
            pixels.take(line.data());
            row += 1;
            input.work.step(row as f32 / rows as f32)?;
        }
    }
    if pixels.data.len() != total {
        let found = pixels.data.len();
        return Err(Fault::Damaged(format!("{found} pixels of {total}")));
    }
    let (data, colors) = pixels.finish(cols)?;
    let sample = match colors {
        None => sample,
        Some(Encoding::TerrainRgb) => "terrain_rgb",
        Some(_) => "terrarium",
    };
    let mut origin = Origin::new(&CODEC, sample);
    origin.plain = colors.is_none();
    origin.bands = color.samples();
    let metres = colors.is_some();
    let placement = world::placement(input, [cols, rows], &mut origin.notes);
    let mut file = HeightFile { cols, rows, data, metres, placement, origin };
    input.sidecar()?.apply(&mut file, (!metres).then_some([0.0, levels]), input.reading);
    Ok(file)
}

fn fault(e: DecodingError) -> Fault {
    Fault::Damaged(e.to_string())
}

/// Collects pixels as heights.
struct Pixels {
    channels: usize,
    wide: bool,
    /// How colours hold heights; none where the grey value does.
    colors: Option<Encoding>,
    /// Whether that is a guess, which the whole picture is held against at the end.
    guess: bool,
    all_grey: bool,
    data: Vec<f32>,
}

impl Pixels {
    fn new(color: ColorType, depth: BitDepth, encoding: Encoding, total: usize) -> Result<Self, Fault> {
        let channels = color.samples();
        let wide = depth == BitDepth::Sixteen;
        let fits = channels >= 3 && !wide;
        let colors = match encoding {
            Encoding::Grey => None,
            Encoding::Auto => fits.then_some(Encoding::Terrarium),
            Encoding::Terrarium | Encoding::TerrainRgb if fits => Some(encoding),
            Encoding::Terrarium | Encoding::TerrainRgb => {
                return Err(Fault::unsupported("a tile of heights in colours has three channels of 8 bits"));
            }
        };
        let guess = colors.is_some() && encoding == Encoding::Auto;
        Ok(Self { channels, wide, colors, guess, all_grey: true, data: room(total)? })
    }

    fn take(&mut self, line: &[u8]) {
        let room = self.data.capacity() - self.data.len();
        if self.wide {
            let (words, _) = line.as_chunks::<2>();
            let of = |w: [u8; 2]| f32::from(u16::from_be_bytes(w));
            for p in words.chunks_exact(self.channels).take(room) {
                self.all_grey &= p.len() < 3 || (p[0] == p[1] && p[1] == p[2]);
                let clear = p.len() % 2 == 0 && p[p.len() - 1] == [0, 0];
                self.data.push(if clear { f32::NAN } else { of(p[0]) });
            }
            return;
        }
        for p in line.chunks_exact(self.channels).take(room) {
            self.all_grey &= p.len() < 3 || (p[0] == p[1] && p[1] == p[2]);
            let clear = p.len() % 2 == 0 && p[p.len() - 1] == 0;
            let v = match self.colors {
                Some(encoding) => colors::metres(colors::number([p[0], p[1], p[2]]), encoding),
                None => f32::from(p[0]),
            };
            self.data.push(if clear { f32::NAN } else { v });
        }
    }

    /// The samples, and how colours held them.
    fn finish(mut self, cols: usize) -> Result<(Vec<f32>, Option<Encoding>), Fault> {
        if self.guess && self.all_grey {
            let grey = |v: &f32| if v.is_nan() { f32::NAN } else { f32::from(colors::color_of(*v)[0]) };
            self.data.iter_mut().for_each(|v| *v = grey(v));
            return Ok((self.data, None));
        }
        let doubt = match self.colors {
            Some(_) if self.guess => colors::doubt(cols, &self.data),
            None if !self.all_grey => Some("its channels differ".into()),
            _ => None,
        };
        match doubt {
            Some(why) => Err(Fault::Unsupported(format!(
                "a colour picture holds no heights: {why}; `encoding` says it where it is a Terrarium or Terrain-RGB tile"
            ))),
            None => Ok((self.data, self.colors)),
        }
    }
}
