//! The pixels of a picture.

use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};

use image::{ColorType, ImageDecoder};
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;

use super::super::error::{Fault, ReadError};
use super::super::height::Limits;
use super::claim::{PictureClaim, PictureKind};
use super::psd;
use crate::work::Work;

/// The pixels of a picture: red, green, blue and alpha, sRGB encoded, the colours not multiplied by alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub cols: usize,
    /// Rows, the uppermost first.
    pub rows: usize,
    /// Whether the file has an alpha channel that is not 1 everywhere.
    pub has_alpha: bool,
    /// What a person should know about the reading.
    pub notes: Vec<String>,
    pub(super) pixels: Pixels,
}

/// Pixels row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Pixels {
    Eight(Vec<[u8; 4]>),
    Sixteen(Vec<[u16; 4]>),
}

impl Picture {
    /// Reads a picture.
    ///
    /// # Errors
    /// What is wrong with the file; a size over the limits is refused before memory is taken.
    pub fn read(name: &str, bytes: &[u8], limits: &Limits, work: &Work<'_>) -> Result<Self, ReadError> {
        Self::checked(name, bytes, limits, work).map_err(|fault| fault.of(name))
    }

    /// Bytes of the pixels.
    pub fn bytes(&self) -> u64 {
        match &self.pixels {
            Pixels::Eight(p) => size_of_val(&p[..]) as u64,
            Pixels::Sixteen(p) => size_of_val(&p[..]) as u64,
        }
    }

    fn checked(name: &str, bytes: &[u8], limits: &Limits, work: &Work<'_>) -> Result<Self, Fault> {
        let claim = PictureClaim::checked(name, &mut Cursor::new(bytes), limits)?;
        let mut notes = Vec::new();
        let pixels = guarded(|| match claim.kind {
            PictureKind::Png => png(bytes, &claim, work),
            PictureKind::Jpeg => jpeg(bytes, &claim, work, &mut notes),
            PictureKind::Webp => {
                image::codecs::webp::WebPDecoder::new(watched(bytes, work)).map_err(fault).and_then(unpack)
            }
            PictureKind::Bmp => {
                image::codecs::bmp::BmpDecoder::new(watched(bytes, work)).map_err(fault).and_then(unpack)
            }
            PictureKind::Tga => {
                image::codecs::tga::TgaDecoder::new(watched(bytes, work)).map_err(fault).and_then(unpack)
            }
            PictureKind::Psd => psd::read(bytes, &claim, work),
        })?;
        let (cols, rows) = (claim.cols as usize, claim.rows as usize);
        let (found, has_alpha) = match &pixels {
            Pixels::Eight(p) => (p.len(), p.iter().any(|p| p[3] != u8::MAX)),
            Pixels::Sixteen(p) => (p.len(), p.iter().any(|p| p[3] != u16::MAX)),
        };
        if found != cols * rows {
            return Err(Fault::Damaged(format!("{found} pixels where its header says {cols} x {rows}")));
        }
        Ok(Self { cols, rows, has_alpha, notes, pixels })
    }
}

/// The word to stop; whoever gave it knows better than to show it as a fault of the file.
/// Turns a panic of a library into an error.
fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    // Nothing outlives the closure that could be left half done.
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
    result.unwrap_or_else(|_| Err(Fault::damaged("its content contradicts its header")))
}

/// A file that fails once the work was asked to stop: the decoders of libraries know no other way.
struct Watched<'a> {
    file: Cursor<&'a [u8]>,
    work: &'a Work<'a>,
}

fn watched<'a>(bytes: &'a [u8], work: &'a Work<'a>) -> BufReader<Watched<'a>> {
    BufReader::with_capacity(1 << 14, Watched { file: Cursor::new(bytes), work })
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.work.is_cancelled() {
            return Err(std::io::Error::other("cancelled"));
        }
        self.file.read(buffer)
    }
}

impl Seek for Watched<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(to)
    }
}

fn fault(e: image::ImageError) -> Fault {
    match e {
        image::ImageError::Unsupported(e) => Fault::Unsupported(e.to_string()),
        other => Fault::Damaged(other.to_string()),
    }
}

/// Unpacks what a decoder of the `image` crate reads.
fn unpack(decoder: impl ImageDecoder) -> Result<Pixels, Fault> {
    let color = decoder.color_type();
    let size = usize::try_from(decoder.total_bytes()).map_err(|_| Fault::damaged("a picture too large"))?;
    let mut raw = vec![0; size];
    decoder.read_image(&mut raw).map_err(fault)?;
    match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            Ok(eight(&raw, usize::from(color.channel_count())))
        }
        other => Err(Fault::Unsupported(format!("pixels of the kind {other:?}"))),
    }
}

/// Pixels of one to four components of a byte each.
pub(super) fn eight(raw: &[u8], channels: usize) -> Pixels {
    let of = |p: &[u8]| match *p {
        [v] => [v, v, v, u8::MAX],
        [v, a] => [v, v, v, a],
        [r, g, b] => [r, g, b, u8::MAX],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    };
    Pixels::Eight(raw.chunks_exact(channels.max(1)).map(of).collect())
}

/// Reads a PNG row by row; colours in text and profiles are passed over unread.
fn png(bytes: &[u8], claim: &PictureClaim, work: &Work<'_>) -> Result<Pixels, Fault> {
    let broken = |e: png::DecodingError| Fault::Damaged(e.to_string());
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(broken)?;
    let line = u64::from(info.width).saturating_mul(info.bits_per_pixel() as u64) / 8;
    Limits::plausible(line.saturating_mul(claim.rows), bytes.len() as u64)?;
    // Room for the decoder's own rows, and for a whole picture where it is interlaced.
    decoder.set_limits(png::Limits { bytes: usize::MAX });
    let mut reader = decoder.read_info().map_err(broken)?;
    let (color, depth) = reader.output_color_type();
    let wide = depth == png::BitDepth::Sixteen;
    let mut rows = Rows::new(color.samples(), wide, (claim.cols * claim.rows) as usize);
    if reader.info().interlaced {
        let size = reader.output_buffer_size().ok_or_else(|| Fault::damaged("a picture too large"))?;
        let mut whole = vec![0; size];
        reader.next_frame(&mut whole).map_err(broken)?;
        rows.take(&whole);
    } else {
        while let Some(row) = reader.next_row().map_err(broken)? {
            work.check()?;
            rows.take(row.data());
        }
    }
    Ok(rows.pixels)
}

/// Collects rows of a PNG.
struct Rows {
    channels: usize,
    room: usize,
    pixels: Pixels,
}

impl Rows {
    fn new(channels: usize, wide: bool, room: usize) -> Self {
        let pixels = match wide {
            true => Pixels::Sixteen(Vec::with_capacity(room)),
            false => Pixels::Eight(Vec::with_capacity(room)),
        };
        Self { channels, room, pixels }
    }

    fn take(&mut self, line: &[u8]) {
        match &mut self.pixels {
            Pixels::Eight(pixels) => {
                let left = self.room - pixels.len();
                let Pixels::Eight(fresh) = eight(line, self.channels) else { return };
                pixels.extend(fresh.into_iter().take(left));
            }
            Pixels::Sixteen(pixels) => {
                let left = self.room - pixels.len();
                let (words, _) = line.as_chunks::<2>();
                let of = |p: &[[u8; 2]]| {
                    let word = |i: usize| p.get(i).map(|w| u16::from_be_bytes(*w));
                    let [v, a] = [word(0).unwrap_or_default(), u16::MAX];
                    match p.len() {
                        0 | 1 => [v, v, v, a],
                        2 => [v, v, v, word(1).unwrap_or(a)],
                        _ => [v, word(1).unwrap_or(v), word(2).unwrap_or(v), word(3).unwrap_or(a)],
                    }
                };
                pixels.extend(words.chunks_exact(self.channels).take(left).map(of));
            }
        }
    }
}

/// Reads a JPEG. One that is damaged behind its header is read as far as it goes.
fn jpeg(
    bytes: &[u8],
    claim: &PictureClaim,
    work: &Work<'_>,
    notes: &mut Vec<String>,
) -> Result<Pixels, Fault> {
    let size = claim.cols.saturating_mul(claim.rows).saturating_mul(3);
    Limits::plausible(size, bytes.len() as u64)?;
    // Without the instructions of some machines, whose results are not said to be the same to the bit.
    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let decode = |strict: bool| {
        let options = options.set_strict_mode(strict);
        let mut decoder = zune_jpeg::JpegDecoder::new_with_options(watched(bytes, work), options);
        decoder.decode().map_err(|e| Fault::Damaged(e.to_string()))
    };
    let raw = decode(true).or_else(|strict| {
        let raw = decode(false)?;
        notes.push(format!("the picture is not whole ({strict}); what can be read of it is used"));
        Ok::<_, Fault>(raw)
    })?;
    Ok(eight(&raw, 3))
}
