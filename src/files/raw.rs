//! r16, r32 and raw: samples and nothing else. What they are, a person says, or a sidecar, or the extension.

use super::codec::{Codec, FormatSpec};
use super::error::{Fault, WriteError};
use super::flat::{Flat, Number, height};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::Placement;
use super::reading::{ByteOrder, RawSample};
use super::sheet::{Sheet, Sink, little_floats, little_words};
use super::sidecar::Sidecar;
use super::write::Written;

pub(super) static CODEC16: Codec = Codec {
    name: "r16",
    extensions: &["r16", "raw"],
    magic: &[],
    companions: &["json"],
    claims_early: true,
    claim: |input| claim(input, RawSample::U16),
    read: |input| read(input, &CODEC16, RawSample::U16),
    reads: "samples without a header: 16-bit integers, little-endian, unless `sample`, `byte_order` and `cols` of a sidecar \
            or of the import say otherwise",
    metres: "with a sidecar that gives the range",
    place: "from the sidecar",
};

pub(super) static CODEC32: Codec = Codec {
    name: "r32",
    extensions: &["r32"],
    magic: &[],
    companions: &["json"],
    claims_early: true,
    claim: |input| claim(input, RawSample::F32),
    read: |input| read(input, &CODEC32, RawSample::F32),
    reads: "the same, of 32-bit floats",
    metres: "with a sidecar",
    place: "from the sidecar",
};

pub(super) static INTEGERS: FormatSpec = FormatSpec {
    name: "r16",
    by_extension: true,
    levels: Some(65535.0),
    channels: &[1],
    sidecar: true,
    flips: true,
    voids: false,
    write: write_integers,
    nanoseconds: 5.0,
    holds: "16-bit integers and nothing else, little-endian",
    purpose: "Unity, Unreal, World Machine …",
};

pub(super) static FLOATS: FormatSpec = FormatSpec {
    name: "r32",
    by_extension: true,
    levels: None,
    channels: &[1],
    sidecar: true,
    flips: true,
    voids: true,
    write: write_floats,
    nanoseconds: 5.0,
    holds: "32-bit floats and nothing else, little-endian",
    purpose: "Houdini, World Machine …",
};

/// What is claimed: by a person, by the sidecar, or by the length of a square.
fn claim(input: &Input<'_>, own: RawSample) -> Result<Claim, Fault> {
    let sidecar = input.sidecar()?;
    let sample = input.reading.sample.or(sidecar.sample).unwrap_or(own);
    let [cols, rows] = size(input, &sidecar, sample)?;
    Claim::new(input, [cols as u64, rows as u64], 0)
}

/// Reads the samples; `own` is the type that the extension stands for.
fn read(input: &Input<'_>, codec: &'static Codec, own: RawSample) -> Result<HeightFile, Fault> {
    let (sidecar, reading) = (input.sidecar()?, input.reading);
    let sample = reading.sample.or(sidecar.sample).unwrap_or(own);
    let said = reading.byte_order.or(sidecar.byte_order);
    let order = said.unwrap_or_default();
    let [cols, rows] = size(input, &sidecar, sample)?;
    let flat = |order: ByteOrder| {
        Flat::packed([cols as u64, rows as u64], sample.number(), order == ByteOrder::Big, 0)
    };
    let data = flat(order).read(input, height(None))?;
    let mut origin = Origin::new(codec, sample.name());
    if said.is_none() && is_likelier(input, flat(order.other()), flat(order))? {
        let other = order.other().name();
        origin.notes.push(format!(
            "its numbers look far more like heights when its bytes are read in the other order; `byte_order` {other} would \
             say so"
        ));
    }
    let scaled = sidecar.scale.is_some() || sidecar.offset.is_some();
    // A sidecar of our own vouches for the unit of floats even where it gives no range.
    let metres = sample == RawSample::F32 && sidecar.orograph.is_some();
    let ends = sample.ends().or((scaled && !metres).then_some([0.0, 1.0]));
    let mut file = HeightFile { cols, rows, data, metres, placement: Placement::default(), origin };
    sidecar.apply(&mut file, ends, reading);
    Ok(file)
}

fn write_integers(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    sheet.no_voids()?;
    let (q, written) = sheet.quantizer()?;
    sheet.plain_rows(out, 2, |row, line| little_words(line, row, |v| q.level(v) as u16))?;
    Ok(written)
}

fn write_floats(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    sheet.plain_rows(out, 4, |row, line| little_floats(line, row, f32::NAN))?;
    Ok(Written::default())
}

/// A number of a float file: what is not finite is a void.
pub(super) fn finite_or_void(v: f32) -> f32 {
    if v.is_finite() { v } else { f32::NAN }
}

/// Samples that are looked at to find the byte order.
const LOOKED_AT: u64 = 1 << 16;
/// How many times smaller differences must be in the other byte order to be worth a note.
const FAR_LESS: f64 = 8.0;

/// How much larger the share of floats that may be heights must be to decide by itself.
const FAR_MORE: f64 = 0.1;

/// Whether numbers look far more like heights when they are read in one way than in another: more of the floats are of
/// a size that heights have, or else neighbours in a row differ far less.
fn is_likelier(input: &Input<'_>, one: Flat, other: Flat) -> Result<bool, Fault> {
    if one.cols < 3 || one.number.bytes() == 1 {
        return Ok(false);
    }
    let first_rows = |flat: Flat| {
        let rows = flat.rows.min(LOOKED_AT.div_ceil(flat.cols));
        Flat { rows, ..flat }.read(input, height(None))
    };
    let cols = one.cols as usize;
    let (one, other, is_float) = (first_rows(one)?, first_rows(other)?, one.number == Number::F32);
    // Floats of the wrong order are tiny for the most part, and tiny numbers differ by next to nothing.
    let more = share_of_heights(&one) - share_of_heights(&other);
    if is_float && more.abs() > FAR_MORE {
        return Ok(more > 0.0);
    }
    let (here, there) = (roughness(&other, cols), roughness(&one, cols));
    // Whole rows of one number tell nothing.
    Ok(here > FAR_LESS * there && there > 0.0)
}

/// The share of numbers that are 0 or of a size that heights have.
fn share_of_heights(data: &[f32]) -> f64 {
    let is_height = |v: &&f32| **v == 0.0 || (1e-6..=1e6).contains(&v.abs());
    data.iter().filter(is_height).count() as f64 / data.len().max(1) as f64
}

/// The sum of the steps from neighbour to neighbour in all rows.
fn roughness(data: &[f32], cols: usize) -> f64 {
    // A void in one order is a step as large as any.
    let step = |w: &[f32]| match f64::from(w[1]) - f64::from(w[0]) {
        d if d.is_finite() => d.abs().min(1e12),
        _ => 1e12,
    };
    data.chunks_exact(cols).flat_map(|row| row.windows(2)).map(step).sum()
}

/// Columns and rows: by a person's word, by the sidecar, or those of a square.
fn size(input: &Input<'_>, sidecar: &Sidecar, sample: RawSample) -> Result<[usize; 2], Fault> {
    let (found, width) = (input.bytes.len(), sample.bytes());
    let by_cols = |cols: u64| {
        let line = cols.saturating_mul(width).max(1);
        let whole = cols > 0 && found > 0 && found.is_multiple_of(line);
        whole.then_some((cols, found / line)).ok_or_else(|| {
            Fault::Unsupported(format!(
                "{found} bytes are no whole number of rows of {cols} samples of {width} bytes"
            ))
        })
    };
    let (cols, rows) = match (input.reading.cols, sidecar.cols, sidecar.rows) {
        (Some(cols), ..) | (None, Some(cols), None) => by_cols(cols)?,
        (None, Some(cols), Some(rows)) if !is_foreign(input, sidecar, sample) => (cols, rows),
        (None, _, _) => {
            let side = square(found, width);
            let side = side.ok_or_else(|| Fault::Unsupported(no_square(found, width, sidecar)))?;
            (side, side)
        }
    };
    input.limits.samples(cols, rows)?;
    let want = cols * rows * width;
    if want > found {
        return Err(Fault::Short { what: "a raster of the size in the sidecar", want, found });
    }
    if want < found {
        return Err(Fault::Sidecar(format!("says {cols} x {rows} samples, {want} bytes; there are {found}")));
    }
    // Both fit, since their product does.
    Ok([cols as usize, rows as usize])
}

/// The side of the square that some bytes are.
fn square(bytes: u64, width: u64) -> Option<u64> {
    let side = (bytes / width).isqrt();
    (bytes > 0 && side * side * width == bytes).then_some(side)
}

/// Whether a sidecar that neither names the file nor says it is ours speaks of another size, and the file is a square
/// without it.
fn is_foreign(input: &Input<'_>, sidecar: &Sidecar, sample: RawSample) -> bool {
    let size = sidecar.cols.zip(sidecar.rows).and_then(|(cols, rows)| cols.checked_mul(rows));
    let fits = size.and_then(|n| n.checked_mul(sample.bytes())) == Some(input.bytes.len());
    let ours = sidecar.orograph.is_some() || !sidecar.file.is_empty();
    !fits && !ours && square(input.bytes.len(), sample.bytes()).is_some()
}

/// What to say of a length that is no square, and which samples would make it one.
fn no_square(found: u64, width: u64, sidecar: &Sidecar) -> String {
    let fits = |s: &&RawSample| s.bytes() != width && square(found, s.bytes()).is_some();
    let other = RawSample::ALL.iter().find(fits);
    let hint = other.map(|s| format!("; as `sample` {} they would be a square", s.name()));
    let note = sidecar.note.as_ref().map(|note| format!("; {note}"));
    let more = [hint, note].map(Option::unwrap_or_default).concat();
    format!(
        "{found} bytes are no square of {width}-byte samples; `cols`, or a sidecar of the same name with `cols` and \
         `rows`, would tell the size{more}"
    )
}
