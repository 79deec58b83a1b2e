//! r16 and r32: samples and nothing else, little-endian.

use super::codec::{Codec, Form};
use super::error::{Fault, WriteError};
use super::flat::{Flat, Number, height};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::Placement;
use super::sheet::{Sheet, Sink, little_floats, little_words};
use super::sidecar::Sidecar;
use super::write::Written;

pub(super) static CODEC16: Codec = Codec {
    name: "r16",
    extensions: &["r16", "raw"],
    magic: &[],
    companions: &["json"],
    claim: |input| claim(input, 2),
    read: read_integers,
    reads: "16-bit integers without a header, little-endian",
    metres: "with a sidecar that gives the range",
    place: "from the sidecar",
};

pub(super) static CODEC32: Codec = Codec {
    name: "r32",
    extensions: &["r32"],
    magic: &[],
    companions: &["json"],
    claim: |input| claim(input, 4),
    read: read_floats,
    reads: "32-bit floats without a header, little-endian",
    metres: "with a sidecar",
    place: "from the sidecar",
};

pub(super) static INTEGERS: Form = Form {
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

pub(super) static FLOATS: Form = Form {
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

/// What the sidecar claims; without it the file must be square.
fn claim(input: &Input<'_>, width: u64) -> Result<Claim, Fault> {
    let [cols, rows] = size(input, &input.sidecar()?, width)?;
    Claim::new(input, [cols as u64, rows as u64], 0)
}

/// Reads 16-bit integers; the sidecar gives size and range, without it the file must be square.
fn read_integers(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let sidecar = input.sidecar()?;
    let size = size(input, &sidecar, 2)?;
    let data = Flat::packed(size.map(|n| n as u64), Number::U16, false, 0).read(input, |v| v as f32)?;
    let mut file = height_file(size, data, Origin::new(&CODEC16, "u16"), false);
    sidecar.apply(&mut file, Some(65535.0));
    Ok(file)
}

/// Reads 32-bit floats; the sidecar gives the size, without it the file must be square.
fn read_floats(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let sidecar = input.sidecar()?;
    let size = size(input, &sidecar, 4)?;
    let data = Flat::packed(size.map(|n| n as u64), Number::F32, false, 0).read(input, height(None))?;
    // A sidecar vouches for the unit of floats even where it gives no range.
    let metres = sidecar.orograph.is_some();
    let mut file = height_file(size, data, Origin::new(&CODEC32, "f32"), metres);
    let scaled = sidecar.scale.is_some() || sidecar.offset.is_some();
    sidecar.apply(&mut file, (scaled && !metres).then_some(1.0));
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

fn height_file([cols, rows]: [usize; 2], data: Vec<f32>, origin: Origin, metres: bool) -> HeightFile {
    HeightFile { cols, rows, data, metres, placement: Placement::default(), origin }
}

fn size(input: &Input<'_>, sidecar: &Sidecar, width: u64) -> Result<[usize; 2], Fault> {
    let found = input.bytes.len();
    let (cols, rows) = match (sidecar.cols, sidecar.rows) {
        (Some(cols), Some(rows)) => (cols, rows),
        _ => {
            let side = (found / width).isqrt();
            if side * side * width != found || found == 0 {
                return Err(Fault::Unsupported(format!(
                    "{found} bytes are no square of {width}-byte samples; a sidecar of the same name with `cols` and `rows` \
                     would tell the size"
                )));
            }
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
