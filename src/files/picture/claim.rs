//! What the header of a picture says that the content takes.

use std::io::{Read, Seek, SeekFrom};

use super::super::error::{Fault, ReadError, extension_of};
use super::super::height::Limits;
use crate::params::did_you_mean;

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP.
    Webp,
    /// Windows bitmap.
    Bmp,
    /// Truevision TGA.
    Tga,
    /// Photoshop.
    Psd,
}

impl PictureKind {
    /// The extensions of all kinds.
    pub const EXTENSIONS: [&str; 8] = ["png", "jpg", "jpeg", "webp", "bmp", "tga", "psd", "psb"];

    /// The kind of a file: what its first bytes say, whatever it is called; a TGA says nothing there.
    fn of(name: &str, head: &[u8]) -> Result<Self, Fault> {
        let extension = extension_of(name).unwrap_or_default();
        if !Self::EXTENSIONS.contains(&extension.as_str()) {
            let found = if extension.is_empty() {
                "a name without extension".into()
            } else {
                format!("`.{extension}`")
            };
            let hint = did_you_mean(&extension, Self::EXTENSIONS);
            return Err(Fault::Extension { found, known: Self::EXTENSIONS.join(", "), hint });
        }
        match head {
            [0x89, b'P', b'N', b'G', ..] => Ok(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Ok(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Ok(Self::Webp),
            [b'8', b'B', b'P', b'S', ..] => Ok(Self::Psd),
            _ if extension == "tga" => Ok(Self::Tga),
            [b'B', b'M', ..] => Ok(Self::Bmp),
            _ => Err(Fault::unsupported(format!(
                "its content is no picture of a kind that `.{extension}` stands for"
            ))),
        }
    }
}

/// What a picture says of itself before its pixels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureClaim {
    /// What kind of file it is.
    pub kind: PictureKind,
    /// Pixels in a row.
    pub cols: u64,
    /// Rows.
    pub rows: u64,
    /// Bytes of a pixel as it is kept: four components of one or two bytes.
    pub kept: u64,
    /// Bytes of a pixel that reading takes beside.
    pub more: u64,
}

impl PictureClaim {
    /// Reads the header of a picture.
    ///
    /// # Errors
    /// When it is no picture that is read, or claims more than is allowed.
    pub fn of(name: &str, file: &mut (impl Read + Seek), limits: &Limits) -> Result<Self, ReadError> {
        Self::checked(name, file, limits).map_err(|fault| fault.of(name))
    }

    pub(super) fn checked(name: &str, file: &mut (impl Read + Seek), limits: &Limits) -> Result<Self, Fault> {
        let mut head = [0; 64];
        let read = fill(file, &mut head)?;
        let head = &head[..read];
        let kind = PictureKind::of(name, head)?;
        let claim = match kind {
            PictureKind::Png => png(head),
            PictureKind::Jpeg => jpeg(file)?,
            PictureKind::Webp => webp(head),
            PictureKind::Bmp => bmp(head),
            PictureKind::Tga => tga(head),
            PictureKind::Psd => psd(head),
        };
        let [cols, rows, kept, more] =
            claim.ok_or_else(|| Fault::damaged("its header ends early, or holds no size"))?;
        limits.samples(cols, rows)?;
        Ok(Self { kind, cols, rows, kept, more })
    }

    /// Bytes of memory that reading takes at the peak, the content of the file not counted.
    pub fn bytes(&self) -> u64 {
        self.cols.saturating_mul(self.rows).saturating_mul(self.kept + self.more)
    }
}

/// Fills a buffer as far as the file goes.
fn fill(file: &mut impl Read, buffer: &mut [u8]) -> Result<usize, Fault> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => (),
            Err(e) => return Err(Fault::Damaged(format!("cannot be read: {e}"))),
        }
    }
    Ok(filled)
}

fn big16(b: &[u8], at: usize) -> Option<u64> {
    Some(u64::from(u16::from_be_bytes(b.get(at..at + 2)?.try_into().ok()?)))
}

fn big32(b: &[u8], at: usize) -> Option<u64> {
    Some(u64::from(u32::from_be_bytes(b.get(at..at + 4)?.try_into().ok()?)))
}

fn little16(b: &[u8], at: usize) -> Option<u64> {
    Some(u64::from(u16::from_le_bytes(b.get(at..at + 2)?.try_into().ok()?)))
}

fn little32(b: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(b.get(at..at + 4)?.try_into().ok()?))
}

/// Columns, rows, bytes kept of a pixel, bytes more of it while it is read.
type Found = [u64; 4];

fn png(head: &[u8]) -> Option<Found> {
    let wide = *head.get(24)? == 16;
    let interlaced = *head.get(28)? != 0;
    let kept = if wide { 8 } else { 4 };
    // Rows are taken one by one; an interlaced picture is unpacked whole.
    Some([big32(head, 16)?, big32(head, 20)?, kept, if interlaced { kept } else { 0 }])
}

/// Segments that are skipped before a JPEG without a size is given up.
const MOST_SEGMENTS: usize = 4096;

/// Walks the segments of a JPEG to its frame header.
fn jpeg(file: &mut (impl Read + Seek)) -> Result<Option<Found>, Fault> {
    let broken = |e: std::io::Error| Fault::Damaged(format!("cannot be read: {e}"));
    file.seek(SeekFrom::Start(2)).map_err(broken)?;
    for _ in 0..MOST_SEGMENTS {
        let mut marker = [0; 2];
        if fill(file, &mut marker)? < 2 {
            return Ok(None);
        }
        match marker {
            // Fill bytes before a marker.
            [0xff, 0xff] => {
                file.seek(SeekFrom::Current(-1)).map_err(broken)?;
            }
            // Restart markers and the like stand alone.
            [0xff, 0x01 | 0xd0..=0xd8] => (),
            [0xff, 0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf] => {
                let mut frame = [0; 8];
                let read = fill(file, &mut frame)?;
                let frame = &frame[..read];
                let progressive = matches!(marker[1], 0xc2 | 0xc6 | 0xca | 0xce);
                // Three bytes unpacked, and 16-bit coefficients of a progressive one.
                let more = if progressive { 3 + 8 } else { 3 };
                return Ok(big16(frame, 5).zip(big16(frame, 3)).map(|(cols, rows)| [cols, rows, 4, more]));
            }
            [0xff, 0xd9 | 0xda] => return Ok(None),
            [0xff, _] => {
                let mut length = [0; 2];
                fill(file, &mut length)?;
                let rest = i64::from(u16::from_be_bytes(length)) - 2;
                file.seek(SeekFrom::Current(rest.max(0))).map_err(broken)?;
            }
            // Bytes that belong to no segment are passed over.
            _ => {
                file.seek(SeekFrom::Current(-1)).map_err(broken)?;
            }
        }
    }
    Ok(None)
}

fn webp(head: &[u8]) -> Option<Found> {
    let [cols, rows] = match head.get(12..16)? {
        b"VP8 " => [little16(head, 26)? & 0x3fff, little16(head, 28)? & 0x3fff],
        b"VP8L" => {
            let bits = u64::from(little32(head, 21)?);
            [(bits & 0x3fff) + 1, ((bits >> 14) & 0x3fff) + 1]
        }
        b"VP8X" => {
            let word = |at: usize| Some(u64::from(little32(head, at)? & 0x00ff_ffff) + 1);
            [word(24)?, word(27)?]
        }
        _ => return None,
    };
    // Unpacked pixels, and planes or a second picture while they are unpacked.
    Some([cols, rows, 4, 12])
}

fn bmp(head: &[u8]) -> Option<Found> {
    let header = little32(head, 14)?;
    let [cols, rows] = if header == 12 {
        [little16(head, 18)?, little16(head, 20)?]
    } else {
        [little32(head, 18)?, little32(head, 22)?].map(|v| u64::from((v as i32).unsigned_abs()))
    };
    Some([cols, rows, 4, 4])
}

fn tga(head: &[u8]) -> Option<Found> {
    Some([little16(head, 12)?, little16(head, 14)?, 4, 8])
}

fn psd(head: &[u8]) -> Option<Found> {
    let depth = big16(head, 22)?;
    let kept = if depth > 8 { 8 } else { 4 };
    // The planes of the channels that are taken.
    Some([big32(head, 18)?, big32(head, 14)?, kept, 4 * depth.div_ceil(8)])
}
