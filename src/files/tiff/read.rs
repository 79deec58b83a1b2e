//! Reading: strips or tiles, unpacked in parallel straight into heights.

use exr::prelude::f16;
use flate2::{Decompress, FlushDecompress};
use rayon::prelude::*;

use super::super::error::Fault;
use super::super::height::{HeightFile, Limits, Origin, room};
use super::super::input::{Claim, Input};
use super::ifd::{Directory, Numbers};
use super::{CODEC, geo, tag};

/// What the first directory claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let directory = Directory::first(input.bytes)?;
    let layout = Layout::of(&directory, input.bytes.len(), input.limits)?;
    // Every thread unpacks a strip or tile of its own, and undoes the predictor on a row of it.
    let threads = rayon::current_num_threads() as u64;
    let line = (layout.chunk[0] * layout.per_pixel * layout.kind.bytes()) as u64;
    let unpacked = line.saturating_mul(layout.chunk[1].min(layout.rows) as u64 + 1);
    Claim::new(input, [layout.cols as u64, layout.rows as u64], unpacked.saturating_mul(threads))
}

/// Reads the first picture of a file.
pub(super) fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let bytes = input.bytes;
    let directory = Directory::first(bytes)?;
    let layout = Layout::of(&directory, bytes.len(), input.limits)?;
    let mut data = room(layout.cols * layout.rows)?;
    data.resize(layout.cols * layout.rows, 0f32);
    let rows_of_chunk = layout.chunk[1].min(layout.rows);
    let chunks = data.par_chunks_mut(layout.cols * rows_of_chunk).enumerate();
    let scratch = || Scratch { unpacked: Vec::new(), row: Vec::new() };
    chunks.try_for_each_init(scratch, |scratch, (j, out)| {
        input.watch.go_on()?;
        layout.read_chunks(bytes, j, out, scratch)
    })?;
    let placement = geo::placement(&directory, [layout.cols, layout.rows]);
    let mut origin = Origin::new(&CODEC, layout.kind.name());
    origin.nodata = layout.nodata;
    origin.bands = layout.samples;
    if layout.samples > 1 {
        origin.notes.push(format!("{} bands, of which the first is read", layout.samples));
    }
    let (factor, summand) = geo::scaling(&directory);
    if (factor, summand) != (1.0, 0.0) {
        origin.plain = false;
        origin.notes.push(format!("heights are {factor} times what the file holds, plus {summand} m"));
        let top = layout.kind.levels();
        origin.range = top.map(|top| [summand, summand + factor * top]).filter(|[lo, hi]| lo < hi);
        data.par_iter_mut().for_each(|v| *v = (f64::from(*v) * factor + summand) as f32);
    }
    let mut file = HeightFile { cols: layout.cols, rows: layout.rows, data, metres: true, placement, origin };
    north_up(&mut file);
    Ok(file)
}

/// Turns a file around whose rows run from south to north by its own coordinates.
fn north_up(file: &mut HeightFile) {
    if let Some(a) = &mut file.placement.affine
        && a.is_upright()
        && a.row[1] > 0.0
    {
        a.origin = a.at(0.0, (file.rows - 1) as f64);
        a.row[1] = -a.row[1];
        file.flip();
        file.origin.notes.push("its rows run from south to north; they were turned around".into());
    }
}

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SampleKind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F16,
    F32,
    F64,
}

impl SampleKind {
    fn of(bits: u64, format: u64) -> Option<Self> {
        Some(match (format, bits) {
            (1 | 4, 8) => Self::U8,
            (1 | 4, 16) => Self::U16,
            (1 | 4, 32) => Self::U32,
            (2, 8) => Self::I8,
            (2, 16) => Self::I16,
            (2, 32) => Self::I32,
            (3, 16) => Self::F16,
            (3, 32) => Self::F32,
            (3, 64) => Self::F64,
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F16 => "f16",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    fn levels(self) -> Option<f64> {
        match self {
            Self::U8 => Some(255.0),
            Self::U16 => Some(65535.0),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
}

/// How the samples of a picture are laid out.
struct Layout<'a> {
    little: bool,
    cols: usize,
    rows: usize,
    kind: SampleKind,
    /// Bands of the picture.
    samples: usize,
    /// Samples of one pixel in a chunk: 1 where every band has chunks of its own.
    per_pixel: usize,
    compression: Compression,
    predictor: u64,
    /// Columns and rows of a strip or tile.
    chunk: [usize; 2],
    tiled: bool,
    /// Chunks side by side.
    across: usize,
    offsets: Numbers<'a>,
    counts: Option<Numbers<'a>>,
    nodata: Option<f64>,
}

struct Scratch {
    unpacked: Vec<u8>,
    row: Vec<u8>,
}

impl<'a> Layout<'a> {
    fn of(directory: &Directory<'a>, length: usize, limits: &Limits) -> Result<Self, Fault> {
        let need =
            |t: u16, name: &str| directory.number(t).ok_or_else(|| Fault::Damaged(format!("no tag {name}")));
        let or = |t: u16, default: u64| directory.number(t).unwrap_or(default);
        let (cols, rows) = (need(tag::WIDTH, "ImageWidth")?, need(tag::LENGTH, "ImageLength")?);
        limits.samples(cols, rows)?;
        let samples = or(tag::SAMPLES, 1);
        let same = |t: u16| directory.numbers(t).is_none_or(|n| (1..n.len()).all(|i| n.get(i) == n.get(0)));
        if !(1..=64).contains(&samples) || !same(tag::BITS) || !same(tag::SAMPLE_FORMAT) {
            return Err(Fault::Unsupported(format!("{samples} bands, or bands of several types")));
        }
        let (bits, format) = (or(tag::BITS, 1), or(tag::SAMPLE_FORMAT, 1));
        let kind = SampleKind::of(bits, format)
            .ok_or_else(|| Fault::Unsupported(format!("samples of {bits} bits and format {format}")))?;
        if matches!(or(tag::PHOTOMETRIC, 1), 2 | 3 | 5 | 6) && kind == SampleKind::U8 {
            return Err(Fault::unsupported("a colour picture holds no heights"));
        }
        let compression = match or(tag::COMPRESSION, 1) {
            1 => Compression::None,
            5 => Compression::Lzw,
            8 | 32946 => Compression::Deflate,
            32773 => Compression::PackBits,
            other => {
                return Err(Fault::Unsupported(format!(
                    "compression {other}; none, LZW, deflate and PackBits are"
                )));
            }
        };
        let predictor = or(tag::PREDICTOR, 1);
        let fits = match predictor {
            1 | 2 => true,
            3 => kind.is_float(),
            _ => false,
        };
        if !fits || or(tag::FILL_ORDER, 1) != 1 {
            return Err(Fault::Unsupported(format!("predictor {predictor} on {}", kind.name())));
        }
        let planar = or(tag::PLANAR, 1) == 2;
        let per_pixel = if planar { 1 } else { samples as usize };
        let tiled = directory.numbers(tag::TILE_OFFSETS).is_some();
        let (chunk, offsets, counts) = if tiled {
            let size = [need(tag::TILE_WIDTH, "TileWidth")?, need(tag::TILE_LENGTH, "TileLength")?];
            (size, tag::TILE_OFFSETS, tag::TILE_COUNTS)
        } else {
            let size = [cols, or(tag::ROWS_PER_STRIP, rows).min(rows)];
            (size, tag::STRIP_OFFSETS, tag::STRIP_COUNTS)
        };
        let in_chunk = chunk[0].saturating_mul(chunk[1]).saturating_mul(per_pixel as u64);
        if !(1..=limits.samples).contains(&in_chunk) {
            return Err(Fault::Damaged(format!("strips or tiles of {} x {}", chunk[0], chunk[1])));
        }
        let offsets = directory.numbers(offsets).ok_or_else(|| Fault::damaged("no strips and no tiles"))?;
        let counts = directory.numbers(counts);
        let (across, down) = (cols.div_ceil(chunk[0]), rows.div_ceil(chunk[1]));
        if (offsets.len() as u64) < across * down || counts.is_some_and(|c| (c.len() as u64) < across * down)
        {
            let found = offsets.len().min(counts.map_or(usize::MAX, |c| c.len()));
            return Err(Fault::Damaged(format!("{found} strips or tiles where {} should be", across * down)));
        }
        // Of a tile that juts out over the border only the inside counts: it may be mostly filling.
        let claimed = cols * rows * kind.bytes() as u64;
        Limits::plausible(claimed, length)?;
        let nodata = directory.text(tag::GDAL_NODATA).and_then(|t| t.trim().parse().ok());
        Ok(Self {
            little: directory.little(),
            cols: cols as usize,
            rows: rows as usize,
            kind,
            samples: samples as usize,
            per_pixel,
            compression,
            predictor,
            chunk: chunk.map(|n| n as usize),
            tiled,
            across: across as usize,
            offsets,
            counts,
            nodata,
        })
    }

    /// Fills the rows of the `j`-th line of chunks.
    fn read_chunks(
        &self,
        bytes: &[u8],
        j: usize,
        out: &mut [f32],
        scratch: &mut Scratch,
    ) -> Result<(), Fault> {
        let rows = out.len() / self.cols;
        for i in 0..self.across {
            let first = i * self.chunk[0];
            let width = self.chunk[0].min(self.cols - first);
            let Some(packed) = self.packed(bytes, j * self.across + i)? else {
                let fill = self.nodata.map_or(0.0, |_| f32::NAN);
                out.chunks_exact_mut(self.cols).for_each(|row| row[first..first + width].fill(fill));
                continue;
            };
            let line = self.chunk[0] * self.per_pixel * self.kind.bytes();
            let Scratch { unpacked, row } = scratch;
            let lines = self.unpack(packed, line * rows, unpacked)?;
            for (line, out) in lines.chunks_exact(line).zip(out.chunks_exact_mut(self.cols)) {
                row.clear();
                row.extend_from_slice(line);
                self.unpredict(row);
                self.heights(row, &mut out[first..first + width]);
            }
        }
        Ok(())
    }

    /// The bytes of a chunk; `None` where a sparse file leaves it out.
    fn packed<'b>(&self, bytes: &'b [u8], i: usize) -> Result<Option<&'b [u8]>, Fault> {
        let offset = self.offsets.get(i).unwrap_or(0);
        let found = bytes.len() as u64;
        let count = match self.counts {
            Some(counts) => counts.get(i).unwrap_or(0),
            None => found.saturating_sub(offset),
        };
        if offset == 0 && count == 0 {
            return Ok(None);
        }
        let end = offset.checked_add(count).filter(|e| *e <= found && count > 0);
        let what = if self.tiled { "a tile" } else { "a strip" };
        let short = Fault::Short { what, want: offset.saturating_add(count.max(1)), found };
        end.map(|e| Some(&bytes[offset as usize..e as usize])).ok_or(short)
    }

    /// The first `want` bytes of a chunk.
    fn unpack<'b>(&self, packed: &'b [u8], want: usize, buffer: &'b mut Vec<u8>) -> Result<&'b [u8], Fault> {
        let got = match self.compression {
            Compression::None => return packed.get(..want).ok_or_else(|| self.short(want, packed.len())),
            Compression::Deflate => {
                buffer.resize(want, 0);
                let mut inflate = Decompress::new(true);
                let status = inflate.decompress(packed, buffer, FlushDecompress::Finish);
                status.map_err(|e| Fault::Damaged(format!("a strip or tile does not inflate: {e}")))?;
                inflate.total_out() as usize
            }
            Compression::Lzw => {
                buffer.resize(want, 0);
                let order = weezl::BitOrder::Msb;
                let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(order, 8);
                lzw(&mut decoder, packed, buffer)?
            }
            Compression::PackBits => {
                buffer.clear();
                unpack_bits(packed, want, buffer);
                buffer.len()
            }
        };
        if got < want { Err(self.short(want, got)) } else { Ok(&buffer[..want]) }
    }

    fn short(&self, want: usize, found: usize) -> Fault {
        let what = if self.tiled { "an unpacked tile" } else { "an unpacked strip" };
        Fault::Short { what, want: want as u64, found: found as u64 }
    }

    /// Undoes the predictor; after predictor 3 the samples of a row are big-endian planes put back together.
    fn unpredict(&self, row: &mut Vec<u8>) {
        let (n, step) = (self.per_pixel, self.kind.bytes());
        match self.predictor {
            2 => match step {
                1 => (n..row.len()).for_each(|i| row[i] = row[i].wrapping_add(row[i - n])),
                2 => sum_up::<2>(row, n, self.little),
                4 => sum_up::<4>(row, n, self.little),
                _ => sum_up::<8>(row, n, self.little),
            },
            3 => {
                (n..row.len()).for_each(|i| row[i] = row[i].wrapping_add(row[i - n]));
                let count = row.len() / step;
                let planes = std::mem::take(row);
                row.resize(planes.len(), 0);
                for (b, plane) in planes.chunks_exact(count).enumerate() {
                    let at = if self.little { step - 1 - b } else { b };
                    for (i, v) in plane.iter().enumerate() {
                        row[i * step + at] = *v;
                    }
                }
            }
            _ => (),
        }
    }

    /// The first band of a row as heights, voids as NaN.
    fn heights(&self, row: &[u8], out: &mut [f32]) {
        let (n, little) = (self.per_pixel, self.little);
        match self.kind {
            SampleKind::U8 => self.convert(row, n, out, |[b]: [u8; 1]| f64::from(b)),
            SampleKind::I8 => self.convert(row, n, out, |[b]: [u8; 1]| f64::from(b as i8)),
            SampleKind::U16 => {
                self.convert(row, n, out, |b| f64::from(u16::from_le_bytes(native(b, little))))
            }
            SampleKind::I16 => {
                self.convert(row, n, out, |b| f64::from(i16::from_le_bytes(native(b, little))))
            }
            SampleKind::U32 => {
                self.convert(row, n, out, |b| f64::from(u32::from_le_bytes(native(b, little))))
            }
            SampleKind::I32 => {
                self.convert(row, n, out, |b| f64::from(i32::from_le_bytes(native(b, little))))
            }
            SampleKind::F16 => {
                let of = |b| f64::from(f16::from_bits(u16::from_le_bytes(native(b, little))).to_f32());
                self.convert(row, n, out, of);
            }
            SampleKind::F32 => {
                self.convert(row, n, out, |b| f64::from(f32::from_le_bytes(native(b, little))))
            }
            SampleKind::F64 => self.convert(row, n, out, |b| f64::from_le_bytes(native(b, little))),
        }
    }

    fn convert<const N: usize>(&self, row: &[u8], n: usize, out: &mut [f32], of: impl Fn([u8; N]) -> f64) {
        // A float nodata is written with fewer digits than it has, so floats are compared as f32.
        let nodata = match self.nodata {
            Some(v) if self.kind.is_float() => f64::from(v as f32),
            Some(v) => v,
            None => f64::NAN,
        };
        let (samples, _) = row.as_chunks::<N>();
        for (o, b) in out.iter_mut().zip(samples.iter().step_by(n)) {
            let v = of(*b);
            let narrow = if self.kind == SampleKind::F64 { f64::from(v as f32) } else { v };
            let void = v == nodata || narrow == nodata;
            *o = if void { f32::NAN } else { v as f32 };
        }
    }
}

/// Bytes of a number in little-endian order.
fn native<const N: usize>(mut b: [u8; N], little: bool) -> [u8; N] {
    if !little {
        b.reverse();
    }
    b
}

/// Adds up differences of numbers of `N` bytes, `n` to a pixel.
fn sum_up<const N: usize>(row: &mut [u8], n: usize, little: bool) {
    let (numbers, _) = row.as_chunks_mut::<N>();
    let of = |b: [u8; N]| native(b, little).iter().rev().fold(0u64, |sum, b| sum << 8 | u64::from(*b));
    for i in n..numbers.len() {
        let sum = of(numbers[i]).wrapping_add(of(numbers[i - n])).to_le_bytes();
        let mut bytes = [0; N];
        bytes.copy_from_slice(&sum[..N]);
        numbers[i] = native(bytes, little);
    }
}

fn lzw(decoder: &mut weezl::decode::Decoder, mut packed: &[u8], out: &mut [u8]) -> Result<usize, Fault> {
    let mut filled = 0;
    while filled < out.len() {
        let step = decoder.decode_bytes(packed, &mut out[filled..]);
        packed = &packed[step.consumed_in..];
        filled += step.consumed_out;
        match step.status {
            Ok(weezl::LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => (),
            Ok(_) => break,
            Err(e) => return Err(Fault::Damaged(format!("a strip or tile does not unpack: {e}"))),
        }
    }
    Ok(filled)
}

/// Undoes run-length packing (TIFF 6.0, section 9).
fn unpack_bits(mut packed: &[u8], want: usize, out: &mut Vec<u8>) {
    while out.len() < want {
        let [code, rest @ ..] = packed else { return };
        let code = *code as i8;
        if code >= 0 {
            let n = (code as usize + 1).min(rest.len());
            out.extend_from_slice(&rest[..n]);
            packed = &rest[n..];
        } else if code == -128 {
            packed = rest;
        } else {
            let [value, rest @ ..] = rest else { return };
            out.resize(out.len() + (1 - i16::from(code)) as usize, *value);
            packed = rest;
        }
    }
}
