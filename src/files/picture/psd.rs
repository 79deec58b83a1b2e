//! The merged image of a Photoshop file (Adobe Photoshop File Formats Specification, 2019).
//!
//! Behind the header stand colour table, resources and layers, each led by its length; then come the planes of the
//! merged image, one channel after the other. Photoshop writes them where "maximize compatibility" is on.

use std::io::Read;

use super::super::error::Fault;
use super::super::height::Limits;
use super::claim::PictureClaim;
use super::decode::Pixels;
use crate::work::Work;

/// Reads the merged image.
pub(super) fn read(bytes: &[u8], claim: &PictureClaim, work: &Work<'_>) -> Result<Pixels, Fault> {
    let mut file = Bytes { rest: bytes };
    let header = Header::read(&mut file)?;
    let table = file.block(4)?;
    file.block(4)?;
    file.block(if header.large { 8 } else { 4 })?;
    let pixels = (claim.cols * claim.rows) as usize;
    let planes = header.planes();
    let line = claim.cols as usize * header.depth / 8;
    let claimed = (line as u64).saturating_mul(claim.rows).saturating_mul(planes as u64);
    let data = match file.word(2)? {
        0 => file.take(claimed as usize)?.to_vec(),
        1 => run_lengths(&mut file, &header, [claim.rows as usize, line], work)?,
        method @ (2 | 3) => {
            Limits::plausible(claimed, file.rest.len() as u64)?;
            let mut data = vec![0; claimed as usize];
            let mut inflated = flate2::read::ZlibDecoder::new(file.rest);
            inflated.read_exact(&mut data).map_err(|e| Fault::Damaged(e.to_string()))?;
            if method == 3 {
                data.chunks_exact_mut(line.max(1)).for_each(|row| undo_differences(row, header.depth));
            }
            data
        }
        other => return Err(Fault::Unsupported(format!("compression {other} of a PSD"))),
    };
    Ok(header.pixels(&data, table, pixels))
}

/// What is left of the file.
struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], Fault> {
        let found = self.rest.len() as u64;
        let short = Fault::Short { what: "a part of a PSD", want: n as u64, found };
        let (part, rest) = self.rest.split_at_checked(n).ok_or(short)?;
        self.rest = rest;
        Ok(part)
    }

    /// A number of some bytes, the highest first.
    fn word(&mut self, bytes: usize) -> Result<u64, Fault> {
        Ok(self.take(bytes)?.iter().fold(0, |n, b| n << 8 | u64::from(*b)))
    }

    /// A part led by its length, a number of some bytes.
    fn block(&mut self, bytes: usize) -> Result<&'a [u8], Fault> {
        let length = self.word(bytes)?;
        self.take(usize::try_from(length).unwrap_or(usize::MAX))
    }
}

/// How colours are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Grey,
    Indexed,
    Color,
}

struct Header {
    large: bool,
    channels: usize,
    /// Bits of a component.
    depth: usize,
    mode: Mode,
}

impl Header {
    fn read(file: &mut Bytes<'_>) -> Result<Self, Fault> {
        file.take(4)?;
        let large = match file.word(2)? {
            1 => false,
            2 => true,
            other => return Err(Fault::Unsupported(format!("version {other} of PSD"))),
        };
        file.take(6)?;
        let channels = file.word(2)? as usize;
        file.take(8)?;
        let depth = file.word(2)? as usize;
        let mode = match file.word(2)? {
            // Duotone is kept as grey.
            1 | 8 => Mode::Grey,
            2 => Mode::Indexed,
            3 => Mode::Color,
            other => {
                let name = match other {
                    0 => "bitmap",
                    4 => "CMYK",
                    7 => "multichannel",
                    9 => "Lab",
                    _ => "an unknown mode",
                };
                return Err(Fault::Unsupported(format!("a PSD in {name}; save it in RGB or greyscale")));
            }
        };
        if !matches!(depth, 8 | 16 | 32) || (mode == Mode::Indexed && depth != 8) {
            return Err(Fault::Unsupported(format!("a PSD of {depth} bits a channel")));
        }
        let header = Self { large, channels, depth, mode };
        if channels < header.colors() || channels > 56 {
            return Err(Fault::Damaged(format!("{channels} channels")));
        }
        Ok(header)
    }

    /// Channels of the colour.
    fn colors(&self) -> usize {
        if self.mode == Mode::Color { 3 } else { 1 }
    }

    /// Planes that are read: those of the colour, and the first behind it as alpha.
    fn planes(&self) -> usize {
        self.channels.min(self.colors() + 1)
    }

    fn pixels(&self, data: &[u8], table: &[u8], count: usize) -> Pixels {
        let (colors, bytes) = (self.colors(), self.depth / 8);
        let plane = count * bytes;
        let at = |channel: usize, k: usize| &data[channel * plane + k * bytes..][..bytes];
        let has_alpha = self.planes() > colors;
        if self.depth == 8 {
            let one = |k: usize| {
                let first = at(0, k)[0];
                let alpha = if has_alpha { at(colors, k)[0] } else { u8::MAX };
                let [r, g, b] = match self.mode {
                    Mode::Grey => [first; 3],
                    Mode::Color => [first, at(1, k)[0], at(2, k)[0]],
                    // 256 reds, then greens, then blues.
                    Mode::Indexed => {
                        [0, 256, 512].map(|c| table.get(c + usize::from(first)).copied().unwrap_or_default())
                    }
                };
                [r, g, b, alpha]
            };
            return Pixels::Eight((0..count).map(one).collect());
        }
        let level = |bytes: &[u8], is_color: bool| match *bytes {
            [a, b] => u16::from_be_bytes([a, b]),
            [a, b, c, d] => {
                // Floats hold light.
                let v = f32::from_be_bytes([a, b, c, d]);
                let v = if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 };
                let v = if is_color { crate::kit::color::srgb_from_linear(v) } else { v };
                (v * 65535.0 + 0.5) as u16
            }
            _ => 0,
        };
        let one = |k: usize| {
            let color = |c: usize| level(at(c.min(colors - 1), k), true);
            let alpha = if has_alpha { level(at(colors, k), false) } else { u16::MAX };
            [color(0), color(1), color(2), alpha]
        };
        Pixels::Sixteen((0..count).map(one).collect())
    }
}

/// Unpacks rows of run lengths (`PackBits`), whose lengths stand before them, row by row of every channel.
fn run_lengths(
    file: &mut Bytes<'_>,
    header: &Header,
    [rows, line]: [usize; 2],
    work: &Work<'_>,
) -> Result<Vec<u8>, Fault> {
    let word = if header.large { 4 } else { 2 };
    let mut lengths = Bytes { rest: file.take(header.channels.saturating_mul(rows).saturating_mul(word))? };
    let wanted = header.planes() * rows;
    // A byte of the file makes 64 at most.
    let most = file.rest.len().saturating_mul(64);
    if wanted.saturating_mul(line) > most {
        return Err(Fault::Overclaim {
            claimed: wanted.saturating_mul(line) as u64,
            bytes: file.rest.len() as u64,
        });
    }
    let mut data = Vec::with_capacity(wanted * line);
    for row in 1..=wanted {
        work.check()?;
        let mut packed = file.take(lengths.word(word)? as usize)?;
        let end = row * line;
        while data.len() < end {
            let Some((&head, rest)) = packed.split_first() else { break };
            let left = end - data.len();
            packed = match head as i8 {
                n @ 0.. => {
                    let n = (n as usize + 1).min(rest.len());
                    data.extend_from_slice(&rest[..n.min(left)]);
                    &rest[n..]
                }
                -128 => rest,
                n => {
                    let Some((&value, rest)) = rest.split_first() else { break };
                    data.extend(std::iter::repeat_n(value, (1 - n as isize) as usize).take(left));
                    rest
                }
            };
        }
        if data.len() < end {
            return Err(Fault::damaged("a row of run lengths that ends early"));
        }
    }
    Ok(data)
}

/// Undoes the differences between a component and the one before it; floats are split into bytes first.
fn undo_differences(row: &mut [u8], depth: usize) {
    match depth {
        16 => {
            let (words, _) = row.as_chunks_mut::<2>();
            let mut before = 0u16;
            for word in words {
                before = before.wrapping_add(u16::from_be_bytes(*word));
                *word = before.to_be_bytes();
            }
        }
        _ => {
            let mut before = 0u8;
            for byte in row.iter_mut() {
                before = before.wrapping_add(*byte);
                *byte = before;
            }
            if depth == 32 {
                let (planes, n) = (row.to_vec(), row.len() / 4);
                for (i, word) in row.chunks_exact_mut(4).enumerate() {
                    word.iter_mut().enumerate().for_each(|(p, byte)| *byte = planes[p * n + i]);
                }
            }
        }
    }
}
