//! How the samples of a picture are laid out in strips or tiles.

use super::super::error::Fault;
use super::super::height::Limits;
use super::ifd::{Directory, Numbers};
use super::samples::{Row, SampleKind};
use super::tag;
use super::unpack::Compression;

/// How the samples of a picture are laid out.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) cols: usize,
    pub(super) rows: usize,
    pub(super) kind: SampleKind,
    /// Bands of the picture.
    pub(super) bands: usize,
    pub(super) compression: Compression,
    pub(super) predictor: u64,
    /// Columns and rows of a strip or tile.
    pub(super) chunk: [usize; 2],
    pub(super) tiled: bool,
    /// Whether every band has strips or tiles of its own.
    planar: bool,
    /// Whether the lowest bit of a byte is the first.
    pub(super) reversed: bool,
    little: bool,
    /// What a colour picture is; none where it may be heights.
    pub(super) colors: bool,
}

impl Layout {
    pub(super) fn of(directory: &Directory<'_>, limits: &Limits) -> Result<Self, Fault> {
        let need =
            |t: u16, name: &str| directory.number(t)?.ok_or_else(|| Fault::Damaged(format!("no tag {name}")));
        let or = |t: u16, default: u64| Ok::<_, Fault>(directory.number(t)?.unwrap_or(default));
        let (cols, rows) = (need(tag::WIDTH, "ImageWidth")?, need(tag::LENGTH, "ImageLength")?);
        limits.samples(cols, rows)?;
        let bands = or(tag::SAMPLES, 1)?;
        if !(1..=65535).contains(&bands) {
            return Err(Fault::Damaged(format!("{bands} bands")));
        }
        let kind = kind(directory, bands)?;
        let compression = Compression::of(or(tag::COMPRESSION, 1)?)?;
        let predictor = or(tag::PREDICTOR, 1)?;
        let fits = match predictor {
            1 => true,
            2 => !matches!(kind, SampleKind::Packed(_)),
            3 => kind.is_float(),
            _ => false,
        };
        if !fits {
            return Err(Fault::Unsupported(format!("predictor {predictor} on {}", kind.name())));
        }
        let planar = or(tag::PLANAR, 1)? == 2;
        let tiled = directory.count(tag::TILE_OFFSETS).is_some();
        let chunk = if tiled {
            [need(tag::TILE_WIDTH, "TileWidth")?, need(tag::TILE_LENGTH, "TileLength")?]
        } else {
            [cols, or(tag::ROWS_PER_STRIP, rows)?.min(rows)]
        };
        let per_pixel = if planar { 1 } else { bands };
        let in_chunk = chunk[0].saturating_mul(chunk[1]).saturating_mul(per_pixel);
        if !(1..=limits.samples).contains(&in_chunk) {
            return Err(Fault::Damaged(format!("strips or tiles of {} x {}", chunk[0], chunk[1])));
        }
        Ok(Self {
            cols: cols as usize,
            rows: rows as usize,
            kind,
            bands: bands as usize,
            compression,
            predictor,
            chunk: chunk.map(|n| n as usize),
            tiled,
            planar,
            reversed: or(tag::FILL_ORDER, 1)? == 2,
            little: directory.file.little,
            colors: matches!(or(tag::PHOTOMETRIC, 1)?, 2 | 3 | 5 | 6 | 8 | 9),
        })
    }

    /// Samples of one pixel in a row of a chunk.
    fn per_pixel(&self) -> usize {
        if self.planar { 1 } else { self.bands }
    }

    /// How the rows of a chunk of a band are read.
    pub(super) fn row(&self, band: usize) -> Row {
        let (kind, little, per_pixel) = (self.kind, self.little, self.per_pixel());
        Row { kind, little, per_pixel, band: if self.planar { 0 } else { band } }
    }

    /// Bytes of a row of a chunk.
    pub(super) fn line(&self) -> usize {
        (self.chunk[0] * self.per_pixel()).saturating_mul(self.kind.bits() as usize).div_ceil(8)
    }

    /// Chunks side by side, and one above the other.
    pub(super) fn across(&self) -> [usize; 2] {
        [self.cols.div_ceil(self.chunk[0]), self.rows.div_ceil(self.chunk[1])]
    }

    /// Index of the first chunk of a band.
    pub(super) fn first_of(&self, band: usize) -> usize {
        let [across, down] = self.across();
        if self.planar { across * down * band } else { 0 }
    }

    /// The most bytes that reading takes on one thread: a chunk packed, unpacked, and a row of it.
    pub(super) fn working_bytes(&self) -> u64 {
        let rows = self.chunk[1].min(self.rows) as u64;
        let want = (self.line() as u64).saturating_mul(rows);
        2 * want.saturating_add(self.line() as u64) + self.compression.working_bytes(want)
    }
}

/// The type of the samples, which all bands share.
fn kind(directory: &Directory<'_>, bands: u64) -> Result<SampleKind, Fault> {
    let same = |t: u16| Ok::<_, Fault>(directory.numbers(t)?.is_none_or(|n| n.same()));
    if !same(tag::BITS)? || !same(tag::SAMPLE_FORMAT)? {
        return Err(Fault::Unsupported(format!("{bands} bands of several types")));
    }
    let (bits, format) =
        (directory.number(tag::BITS)?.unwrap_or(1), directory.number(tag::SAMPLE_FORMAT)?.unwrap_or(1));
    SampleKind::of(bits, format)
        .ok_or_else(|| Fault::Unsupported(format!("samples of {bits} bits and format {format}")))
}

/// Beginning and length of a chunk that a sparse file leaves out.
const LEFT_OUT: (u64, u64) = (0, 0);

/// Where the strips or tiles of a picture lie.
#[derive(Clone, Debug)]
pub(super) struct Chunks {
    offsets: Numbers,
    counts: Option<Numbers>,
    what: &'static str,
}

impl Chunks {
    /// How many strips or tiles there must be, and are.
    pub(super) fn check(directory: &Directory<'_>, layout: &Layout) -> Result<u64, Fault> {
        let (offsets, counts) = Self::tags(layout.tiled);
        let found = directory.count(offsets).ok_or_else(|| Fault::damaged("no strips and no tiles"))?;
        let found = found.min(directory.count(counts).unwrap_or(u64::MAX));
        let [across, down] = layout.across().map(|n| n as u64);
        let want = across * down * if layout.planar { layout.bands as u64 } else { 1 };
        // Of bands apart those that are not read may be missing.
        if found < across * down {
            return Err(Fault::Damaged(format!("{found} strips or tiles where {want} should be")));
        }
        Ok(found)
    }

    /// Checks that strips or tiles of their lengths can hold what the picture claims, however well compressed. Those
    /// that a sparse file leaves out take no bytes.
    pub(super) fn plausible(directory: &Directory<'_>, layout: &Layout) -> Result<(), Fault> {
        // Of a tile that juts out over the border only the inside counts: it may be mostly filling.
        let claimed = ((layout.cols * layout.rows) as u64).saturating_mul(layout.kind.bits()) / 8;
        let (bytes, most) = (directory.file.bytes.len(), layout.compression.most());
        if claimed / most <= bytes {
            return Ok(());
        }
        let chunks = Self::of(directory, layout)?;
        let whole = (layout.line() as u64).saturating_mul(layout.chunk[1].min(layout.rows) as u64);
        let holds = |(offset, count): (u64, u64)| {
            if (offset, count) == LEFT_OUT {
                return whole;
            }
            // A length is a claim as well: no strip goes on behind the end of the file.
            let there = count.min(bytes.saturating_sub(offset));
            whole.min(most.saturating_mul(there))
        };
        let all = (0..chunks.offsets.len()).filter_map(|i| chunks.place(directory, i)).map(holds);
        if all.fold(0, u64::saturating_add) < claimed {
            return Err(Fault::Overclaim { claimed, bytes });
        }
        Ok(())
    }

    pub(super) fn of(directory: &Directory<'_>, layout: &Layout) -> Result<Self, Fault> {
        let (offsets, counts) = Self::tags(layout.tiled);
        let missing = || Fault::damaged("no strips and no tiles");
        let what = if layout.tiled { "a tile" } else { "a strip" };
        let offsets = directory.numbers(offsets)?.ok_or_else(missing)?;
        Ok(Self { offsets, counts: directory.numbers(counts)?, what })
    }

    fn tags(tiled: bool) -> (u16, u16) {
        if tiled { (tag::TILE_OFFSETS, tag::TILE_COUNTS) } else { (tag::STRIP_OFFSETS, tag::STRIP_COUNTS) }
    }

    /// Where a chunk begins, and how many bytes it takes.
    fn place(&self, directory: &Directory<'_>, i: usize) -> Option<(u64, u64)> {
        let offset = self.offsets.get(i)?;
        let count = match &self.counts {
            Some(counts) => counts.get(i).unwrap_or(0),
            None => directory.file.bytes.len().saturating_sub(offset),
        };
        Some((offset, count))
    }

    /// Reads the packed bytes of a chunk; `false` where a sparse file leaves it out.
    pub(super) fn read(
        &self,
        directory: &Directory<'_>,
        i: usize,
        packed: &mut Vec<u8>,
    ) -> Result<bool, Fault> {
        let Some((offset, count)) = self.place(directory, i) else {
            return Err(Fault::Damaged(format!("no {} {i}", self.what)));
        };
        if (offset, count) == LEFT_OUT {
            return Ok(false);
        }
        directory.file.read(offset, count.max(1), self.what, packed)?;
        Ok(true)
    }
}
