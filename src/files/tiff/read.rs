//! Reading: strips or tiles, unpacked in parallel straight into heights.

use rayon::prelude::*;

use super::super::error::{Fault, known_bands};
use super::super::height::{HeightFile, Limits, Origin, filled};
use super::super::input::{Claim, Input};
use super::super::place::Placement;
use super::super::voids::strike;
use super::super::{wkt, world};
use super::ifd::Directory;
use super::layout::{Chunks, Layout};
use super::{CODEC, gdal, geo, tag};
use crate::source::ReadAt;
use crate::work::Work;

/// What the first directory claims.
pub(super) fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let directory = Directory::first(input.bytes)?;
    let layout = Layout::of(&directory, input.limits)?;
    let chunks = Chunks::check(&directory, &layout)?;
    Chunks::plausible(&directory, &layout)?;
    let working = layout.working_bytes().saturating_mul(rayon::current_num_threads() as u64);
    Claim::new(
        input,
        [layout.cols as u64, layout.rows as u64],
        working.saturating_add(chunks.saturating_mul(16)),
    )
}

/// Reads the first picture of a file.
pub(super) fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let picture = Picture::open(Directory::first(input.bytes)?, input.limits, input.work)?;
    let layout = &picture.layout;
    let band = band(layout, input.reading.channel.as_deref())?;
    let mut data = filled(layout.cols * layout.rows, 0.0, &input.work)?;
    let metadata = gdal::Metadata::of(&picture.directory)?;
    let nodata = picture.directory.text(tag::GDAL_NODATA)?.and_then(|t| gdal::number(&t));
    picture.heights(band, nodata, &mut data)?;
    let mut origin = Origin::new(&CODEC, layout.kind.name());
    origin.nodata = nodata;
    origin.bands = layout.bands;
    if layout.bands > 1 {
        origin.notes.push(format!("{} bands, of which number {} is read", layout.bands, band + 1));
    }
    picture.clear(input.limits, band, &mut data, &mut origin)?;
    strike(&mut data, input.reading.nodata);
    let keys = geo::Keys::of(&picture.directory)?;
    let size = [layout.cols, layout.rows];
    let mut placement = geo::placement(&picture.directory, &keys, size, &mut origin.notes)?;
    let mut unit = geo::unit_of_heights(&keys, &metadata, band, &mut origin.notes);
    if placement.affine.is_none() {
        let beside = world::placement(input, size, &mut origin.notes);
        if beside.affine.is_some() {
            // The file's own word on the system goes before that of a file beside it.
            placement = Placement { epsg: placement.epsg.or(beside.epsg), ..beside };
            let system = world::system(input, &mut Vec::new());
            unit = unit.or_else(|| wkt::unit_of_heights(system.as_ref(), &mut origin.notes));
        }
    }
    let unit = unit.unwrap_or(1.0);
    let (scale, offset) = metadata.scaling(band);
    let (factor, summand) = (scale * unit, offset * unit);
    if (factor, summand) != (1.0, 0.0) {
        let top = layout.kind.levels();
        origin.range = top.map(|top| [summand, summand + factor * top]).filter(|[lo, hi]| lo < hi);
    }
    let mut file = HeightFile { cols: layout.cols, rows: layout.rows, data, metres: true, placement, origin };
    file.scale(factor, summand);
    north_up(&mut file);
    Ok(file)
}

/// The most bytes that a mask beside a file of some samples takes: its voids, and strips or tiles of it.
pub(in super::super) fn mask_bytes(samples: u64) -> u64 {
    samples.saturating_mul(8).saturating_add(1 << 24)
}

/// Makes voids of the heights where a picture of the same size, a mask beside their file, is 0.
pub(in super::super) fn strike_mask(
    mask: &dyn ReadAt,
    input: &Input<'_>,
    file: &mut HeightFile,
) -> Result<(), Fault> {
    let directory = Directory::first(mask)?;
    let layout = Layout::of(&directory, input.limits)?;
    let (found, want) = ([layout.cols, layout.rows], [file.cols, file.rows]);
    if found != want {
        return Err(Fault::Unsupported(format!(
            "it is {} x {}, the file {} x {}",
            found[0], found[1], want[0], want[1]
        )));
    }
    let at_once = layout.across()[1].min(rayon::current_num_threads()) as u64;
    let samples = file.data.len() as u64;
    if layout.working_bytes().saturating_mul(at_once) > mask_bytes(samples) - 4 * samples {
        return Err(Fault::unsupported("its strips or tiles are far larger than it"));
    }
    let picture = Picture::open(directory, input.limits, input.work)?;
    Chunks::plausible(&picture.directory, &picture.layout)?;
    // GDAL gives each band a mask of its own, or all the first.
    let band = input.reading.channel.as_deref().and_then(|c| c.parse::<usize>().ok()).unwrap_or(1);
    let band = if (1..=picture.layout.bands).contains(&band) { band - 1 } else { 0 };
    // The heights are as they were until the mask was read to its end.
    let mut clear = filled(file.data.len(), 0.0, &input.work)?;
    picture.each(
        band,
        &mut clear,
        |v, o| *o = if v == 0.0 { f32::NAN } else { 0.0 },
        |out| out.fill(f32::NAN),
    )?;
    file.data.par_iter_mut().zip(&clear).filter(|(_, c)| c.is_nan()).for_each(|(v, _)| *v = f32::NAN);
    Ok(())
}

/// The band that is read: the first, or the one whose number is asked for.
fn band(layout: &Layout, asked: Option<&str>) -> Result<usize, Fault> {
    let Some(asked) = asked else {
        return if layout.colors {
            Err(Fault::unsupported(
                "a colour picture holds no heights; `channel` chooses one of its bands by number",
            ))
        } else {
            Ok(0)
        };
    };
    let number = asked.parse().ok().filter(|n| (1..=layout.bands).contains(n));
    number
        .map(|n: usize| n - 1)
        .ok_or_else(|| Fault::Channel { asked: asked.to_owned(), known: known_bands(layout.bands as u64) })
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
        file.origin.turned = true;
        file.origin.notes.push("its rows run from south to north; they were turned around".into());
    }
}

/// A picture of a file.
struct Picture<'a> {
    directory: Directory<'a>,
    layout: Layout,
    chunks: Chunks,
    work: Work<'a>,
}

/// What a thread unpacks into.
#[derive(Default)]
struct Scratch {
    packed: Vec<u8>,
    unpacked: Vec<u8>,
    row: Vec<u8>,
}

impl<'a> Picture<'a> {
    fn open(directory: Directory<'a>, limits: &Limits, work: Work<'a>) -> Result<Self, Fault> {
        let layout = Layout::of(&directory, limits)?;
        Chunks::check(&directory, &layout)?;
        let chunks = Chunks::of(&directory, &layout)?;
        Ok(Self { directory, layout, chunks, work })
    }

    /// Reads the heights of a band, voids as NaN.
    fn heights(&self, band: usize, nodata: Option<f64>, data: &mut [f32]) -> Result<(), Fault> {
        // A float nodata is written with fewer digits than it has, so floats are compared as f32.
        let code = match nodata {
            Some(v) if self.layout.kind.is_float() => f64::from(v as f32),
            Some(v) => v,
            None => f64::NAN,
        };
        let missing = if nodata.is_some() { f32::NAN } else { 0.0 };
        let put = |v: f64, o: &mut f32| {
            let void = v == code || f64::from(v as f32) == code;
            *o = if void { f32::NAN } else { v as f32 };
        };
        self.each(band, data, put, |out| out.fill(missing))
    }

    /// Makes voids where a mask or an alpha band of the file says that there is nothing.
    fn clear(
        &self,
        limits: &Limits,
        band: usize,
        data: &mut [f32],
        origin: &mut Origin,
    ) -> Result<(), Fault> {
        let zero_is_void = |v: f64, o: &mut f32| {
            if v == 0.0 {
                *o = f32::NAN;
            }
        };
        let all_void = |out: &mut [f32]| out.fill(f32::NAN);
        if let Some(alpha) = self.alpha()?.filter(|a| *a != band) {
            self.each(alpha, data, zero_is_void, all_void)?;
            origin.notes.push(format!("band {} is alpha: what is clear in it is void", alpha + 1));
        }
        let Some(mask) = self.mask(limits) else { return Ok(()) };
        let mask = mask?;
        mask.each(0, data, zero_is_void, all_void)?;
        origin.notes.push("a mask in the file says where it is void".into());
        Ok(())
    }

    /// The band that tells how opaque a pixel is.
    fn alpha(&self) -> Result<Option<usize>, Fault> {
        let Some(extra) = self.directory.numbers(tag::EXTRA_SAMPLES)? else { return Ok(None) };
        let first = self.layout.bands.saturating_sub(extra.len());
        let alpha = (0..extra.len()).find(|i| matches!(extra.get(*i), Some(1 | 2)));
        Ok(alpha.map(|i| first + i).filter(|band| *band < self.layout.bands))
    }

    /// The mask of this picture among the pictures behind it: of its size, and of no smaller version of it.
    fn mask(&self, limits: &Limits) -> Option<Result<Self, Fault>> {
        const MASK: u64 = 4;
        const REDUCED: u64 = 1;
        let is_mask = |d: &Directory<'_>| {
            let number = |t: u16| d.number(t).ok().flatten();
            let kind = number(tag::NEW_SUBFILE_TYPE).unwrap_or(0);
            let kind_is = kind & MASK != 0 || number(tag::PHOTOMETRIC) == Some(4);
            let size = [number(tag::WIDTH), number(tag::LENGTH)];
            kind_is
                && kind & REDUCED == 0
                && size == [self.layout.cols, self.layout.rows].map(|n| Some(n as u64))
        };
        let found = self.directory.others().into_iter().find(is_mask)?;
        Some(Self::open(found, limits, self.work))
    }

    /// Gives each sample of a band to `put`, with its place in the data, and each run of samples that the file leaves
    /// out to `miss`.
    fn each(
        &self,
        band: usize,
        data: &mut [f32],
        put: impl Fn(f64, &mut f32) + Sync,
        miss: impl Fn(&mut [f32]) + Sync,
    ) -> Result<(), Fault> {
        let layout = &self.layout;
        let rows_of_chunk = layout.chunk[1].min(layout.rows);
        let lines = data.par_chunks_mut(layout.cols * rows_of_chunk).enumerate();
        lines.try_for_each_init(Scratch::default, |scratch, (j, out)| {
            for i in 0..layout.across()[0] {
                self.work.check()?;
                self.chunk(band, [i, j], scratch, out, &put, &miss)?;
            }
            Ok(())
        })
    }

    fn chunk(
        &self,
        band: usize,
        [i, j]: [usize; 2],
        scratch: &mut Scratch,
        out: &mut [f32],
        put: &impl Fn(f64, &mut f32),
        miss: &impl Fn(&mut [f32]),
    ) -> Result<(), Fault> {
        let layout = &self.layout;
        let Scratch { packed, unpacked, row } = scratch;
        let first = i * layout.chunk[0];
        let width = layout.chunk[0].min(layout.cols - first);
        let index = layout.first_of(band) + j * layout.across()[0] + i;
        let outs = out.chunks_exact_mut(layout.cols).map(|line| &mut line[first..first + width]);
        if !self.chunks.read(&self.directory, index, packed)? {
            outs.for_each(miss);
            return Ok(());
        }
        if layout.reversed {
            packed.iter_mut().for_each(|b| *b = b.reverse_bits());
        }
        let (line, rows) = (layout.line(), outs.len());
        let want = line * rows;
        let found = layout.compression.unpack(packed, want, unpacked, &self.work)?;
        if found < want {
            let what = if layout.tiled { "an unpacked tile" } else { "an unpacked strip" };
            return Err(Fault::Short { what, want: want as u64, found: found as u64 });
        }
        let how = layout.row(band);
        for (line, out) in unpacked.chunks_exact(line).zip(outs) {
            self.work.check()?;
            row.clear();
            row.extend_from_slice(line);
            how.unpredict(layout.predictor, row);
            how.each(row, out, put);
        }
        Ok(())
    }
}
