//! Writing: strips, deflated with a predictor in parallel, the directory behind them.

use std::io::SeekFrom;

use rayon::prelude::*;

use super::super::bands::{self, Band};
use super::super::error::WriteError;
use super::super::place::Placement;
use super::super::quantize::Quantizer;
use super::super::sheet::{Sheet, Sink, little_floats, little_words};
use super::super::write::Written;
use super::{geo, tag};
use crate::value::Quantity;
use crate::work::Work;

/// Writes floats.
pub(super) fn floats(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    let nodata = match sheet.nodata {
        Some(v) if (v as f32).is_finite() => Some(f64::from(v as f32)),
        _ => sheet.has_voids().then_some(f64::NAN),
    };
    let fill = nodata.map_or(f32::NAN, |v| v as f32);
    let layout = Layout::of(sheet, SampleType::F32, nodata, None);
    write(out, &layout, &sheet.writing.work, |j, line| little_floats(line, sheet.row(j), fill))?;
    Ok(Written::default())
}

/// Writes 16-bit integers: of a range where there is one, whole metres with a sign where there is none.
pub(super) fn integers(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    if sheet.own_range().is_none() {
        return whole_metres(sheet, out);
    }
    let (q, written) = sheet.quantizer()?;
    let scaling = written.range.map(|[lo, _]| (q.step(), lo)).filter(|_| sheet.quantity != Quantity::Color);
    let plain = scaling == Some((1.0, 0.0));
    let code = sheet.nodata.filter(|v| plain && v.fract() == 0.0 && (0.0..=65535.0).contains(v));
    if code.is_none() {
        sheet.no_voids()?;
    }
    let layout = Layout::of(sheet, SampleType::U16, code, scaling);
    let void = code.unwrap_or(0.0) as u16;
    let of = |v: f32| if v.is_nan() { void } else { q.level(v) as u16 };
    write(out, &layout, &sheet.writing.work, |j, line| little_words(line, sheet.row(j), of))?;
    Ok(written)
}

fn whole_metres(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    // The lowest number is left to mark voids.
    let q = Quantizer::new([-32767.0, 32767.0], 65534.0)?;
    let clipped = q.check(sheet.samples, sheet.writing.clip)?;
    let mut written = Written { clipped, ..Written::default() };
    if sheet.samples.par_iter().any(|v| v.fract() != 0.0 && !v.is_nan()) {
        written.notes.push("tiff16 without a range holds whole metres; give a range for finer steps".into());
    }
    let voids = sheet.nodata.is_some() || sheet.has_voids();
    let layout = Layout::of(sheet, SampleType::I16, voids.then_some(-32768.0), None);
    let of = |v: f32| if v.is_nan() { i16::MIN as u16 } else { (q.level(v) - 32767) as i16 as u16 };
    write(out, &layout, &sheet.writing.work, |j, line| little_words(line, sheet.row(j), of))?;
    Ok(written)
}

/// The type of the samples that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SampleType {
    /// 16-bit integers from 0.
    U16,
    /// 16-bit integers with a sign.
    I16,
    /// 32-bit floats.
    F32,
}

impl SampleType {
    /// Bytes of a sample.
    fn bytes(self) -> usize {
        if self == Self::F32 { 4 } else { 2 }
    }
}

/// What a file holds.
#[derive(Clone, Copy, Debug)]
struct Layout<'a> {
    cols: usize,
    rows: usize,
    /// 1 for heights, 2 for vectors, 3 for colours.
    bands: usize,
    kind: SampleType,
    placement: &'a Placement,
    /// The number that marks a void.
    nodata: Option<f64>,
    /// Factor and summand that make values of integers.
    scaling: Option<(f64, f64)>,
}

impl<'a> Layout<'a> {
    fn of(sheet: &'a Sheet<'_>, kind: SampleType, nodata: Option<f64>, scaling: Option<(f64, f64)>) -> Self {
        let Sheet { cols, rows, channels: bands, ref placement, .. } = *sheet;
        Self { cols, rows, bands, kind, placement, nodata, scaling }
    }
}

/// How hard strips are pressed.
const LEVEL: u32 = 4;
/// Bytes of samples from which offsets may not fit 32 bits.
const CLASSIC: u64 = 4_000_000_000;

/// Writes a file whose rows `fill` gives, little-endian.
fn write(
    out: &mut dyn Sink,
    layout: &Layout<'_>,
    work: &Work<'_>,
    fill: impl Fn(usize, &mut [u8]) + Sync,
) -> Result<(), WriteError> {
    let Layout { cols, rows, bands, kind, .. } = *layout;
    let line = cols * bands * kind.bytes();
    let big = (line * rows) as u64 > CLASSIC;
    let start = out.stream_position()?;
    let header: &[u8] = if big { &[b'I', b'I', 43, 0, 8, 0, 0, 0] } else { &[b'I', b'I', 42, 0] };
    out.write_all(header)?;
    out.write_all(&[0; 8][..if big { 8 } else { 4 }])?;
    let split = bands::Split::new(rows, line);
    let press = |band: Band| {
        let mut raw = vec![0; band.rows * line];
        let mut planes = vec![0; line];
        for (j, row) in raw.chunks_exact_mut(line).enumerate() {
            fill(band.first_row + j, row);
            match kind {
                SampleType::F32 => predict_floats(row, bands, &mut planes),
                SampleType::U16 | SampleType::I16 => predict_integers(row, bands),
            }
        }
        bands::zlib(&raw, LEVEL)
    };
    let mut at = header.len() as u64 + if big { 8 } else { 4 };
    let (mut offsets, mut counts) = (Vec::new(), Vec::new());
    bands::in_order(&split, work, press, |_, strip| {
        offsets.push(at);
        counts.push(strip.len() as u64);
        at += strip.len() as u64;
        out.write_all(&strip)
    })?;
    if at % 2 == 1 {
        out.write_all(&[0])?;
        at += 1;
    }
    let mut directory = Writer { big, entries: Vec::new() };
    directory.describe(layout, split.band);
    directory.whole(tag::STRIP_OFFSETS, &offsets);
    directory.whole(tag::STRIP_COUNTS, &counts);
    out.write_all(&directory.finish(at))?;
    let end = out.stream_position()?;
    out.seek(SeekFrom::Start(start + header.len() as u64))?;
    // A file that is not big holds less than 4 GB: nothing is cut off.
    if big {
        out.write_all(&at.to_le_bytes())?
    } else {
        out.write_all(&(at as u32).to_le_bytes())?
    }
    out.seek(SeekFrom::Start(end))?;
    Ok(())
}

/// Differences between a pixel and the one before it (predictor 2).
fn predict_integers(row: &mut [u8], bands: usize) {
    let (samples, _) = row.as_chunks_mut::<2>();
    for i in (bands..samples.len()).rev() {
        let (here, before) = (u16::from_le_bytes(samples[i]), u16::from_le_bytes(samples[i - bands]));
        samples[i] = here.wrapping_sub(before).to_le_bytes();
    }
}

/// All highest bytes, then all next ones, as differences (predictor 3, TIFF technical note 3).
fn predict_floats(row: &mut [u8], bands: usize, planes: &mut [u8]) {
    let n = row.len() / 4;
    let (samples, _) = row.as_chunks::<4>();
    let (p0, rest) = planes.split_at_mut(n);
    let (p1, rest) = rest.split_at_mut(n);
    let (p2, p3) = rest.split_at_mut(n);
    for ((((b, p0), p1), p2), p3) in samples.iter().zip(p0).zip(p1).zip(p2).zip(p3) {
        [*p3, *p2, *p1, *p0] = *b;
    }
    let head = bands.min(planes.len());
    row[..head].copy_from_slice(&planes[..head]);
    for ((o, here), before) in row[head..].iter_mut().zip(&planes[head..]).zip(planes.iter()) {
        *o = here.wrapping_sub(*before);
    }
}

/// A directory in the making.
struct Writer {
    big: bool,
    /// Tag, type, count, bytes.
    entries: Vec<(u16, u16, u64, Vec<u8>)>,
}

impl Writer {
    fn describe(&mut self, layout: &Layout<'_>, rows_per_strip: usize) {
        let Layout { cols, rows, bands, kind, placement, nodata, scaling } = *layout;
        let format = match kind {
            SampleType::U16 => 1,
            SampleType::I16 => 2,
            SampleType::F32 => 3,
        };
        self.long(tag::WIDTH, cols);
        self.long(tag::LENGTH, rows);
        self.shorts(tag::BITS, &vec![kind.bytes() as u16 * 8; bands]);
        self.shorts(tag::COMPRESSION, &[8]);
        self.shorts(tag::PHOTOMETRIC, &[if bands == 3 { 2 } else { 1 }]);
        self.shorts(tag::SAMPLES, &[bands as u16]);
        self.long(tag::ROWS_PER_STRIP, rows_per_strip);
        self.shorts(tag::PLANAR, &[1]);
        self.shorts(tag::PREDICTOR, &[if kind == SampleType::F32 { 3 } else { 2 }]);
        if bands == 2 {
            self.shorts(tag::EXTRA_SAMPLES, &[0]);
        }
        self.shorts(tag::SAMPLE_FORMAT, &vec![format; bands]);
        let place = geo::Tags::of(placement);
        self.doubles(tag::PIXEL_SCALE, &place.scale);
        self.doubles(tag::TIE_POINTS, &place.tie);
        self.doubles(tag::TRANSFORMATION, &place.transformation);
        self.shorts(tag::GEO_KEYS, &place.keys);
        self.doubles(tag::GEO_DOUBLES, &place.doubles);
        if let Some((scale, offset)) = scaling.filter(|s| *s != (1.0, 0.0)) {
            self.text(
                tag::GDAL_METADATA,
                &format!(
                    "<GDALMetadata>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">{offset}</Item>\n  \
                     <Item name=\"SCALE\" sample=\"0\" role=\"scale\">{scale}</Item>\n</GDALMetadata>\n"
                ),
            );
        }
        match nodata {
            Some(v) if v.is_nan() => self.text(tag::GDAL_NODATA, "nan"),
            Some(v) => self.text(tag::GDAL_NODATA, &v.to_string()),
            None => (),
        }
    }

    fn put(&mut self, tag: u16, kind: u16, count: usize, bytes: Vec<u8>) {
        if count > 0 {
            self.entries.push((tag, kind, count as u64, bytes));
        }
    }

    fn shorts(&mut self, tag: u16, values: &[u16]) {
        self.put(tag, 3, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect());
    }

    fn long(&mut self, tag: u16, value: usize) {
        // A side is below 2³², or no one could have held the samples.
        self.put(tag, 4, 1, (value as u32).to_le_bytes().to_vec());
    }

    fn doubles(&mut self, tag: u16, values: &[f64]) {
        self.put(tag, 12, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect());
    }

    fn text(&mut self, tag: u16, text: &str) {
        self.put(tag, 2, text.len() + 1, [text.as_bytes(), &[0]].concat());
    }

    /// Offsets and lengths, as wide as the file needs them.
    fn whole(&mut self, tag: u16, values: &[u64]) {
        let bytes = |v: &u64| v.to_le_bytes()[..if self.big { 8 } else { 4 }].to_vec();
        let (kind, bytes) = (if self.big { 16 } else { 4 }, values.iter().flat_map(bytes).collect());
        self.put(tag, kind, values.len(), bytes);
    }

    /// The bytes of the directory and of the values that do not fit into it, for a place in the file.
    fn finish(mut self, at: u64) -> Vec<u8> {
        self.entries.sort_by_key(|e| e.0);
        let (count_len, entry_len, word) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let n = self.entries.len();
        let mut directory = (n as u64).to_le_bytes()[..count_len].to_vec();
        let mut values: Vec<u8> = Vec::new();
        let values_at = at + (count_len + n * entry_len + word) as u64;
        for (tag, kind, count, bytes) in self.entries {
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend(&count.to_le_bytes()[..word]);
            let mut slot = bytes;
            if slot.len() > word {
                values.resize(values.len().next_multiple_of(8), 0);
                let place = values_at + values.len() as u64;
                values.append(&mut slot);
                slot = place.to_le_bytes().to_vec();
            }
            slot.resize(word, 0);
            directory.extend(slot);
        }
        directory.extend(&[0; 8][..word]);
        directory.extend(values);
        directory
    }
}
