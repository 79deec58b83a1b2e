//! Terragen terrains: chunks of a four-letter name and what follows, heights as 16-bit integers of a scale.

use super::codec::Codec;
use super::error::Fault;
use super::flat::{Flat, Number};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::Placement;

pub(super) static CODEC: Codec = Codec {
    name: "Terragen",
    extensions: &["ter"],
    magic: &[b"TERRAGENTERRAIN "],
    companions: &[],
    claims_early: true,
    claim,
    read,
    reads: "Terragen terrain: `SIZE`, `XPTS`, `YPTS`, `SCAL`, `CRAD`, `CRVM`, `ALTW`; rows from the south",
    metres: "yes, by `SCAL`: 30 m a unit where it is missing",
    place: "cell from `SCAL`",
};

/// Metres of a unit where the file does not say.
const UNIT: f64 = 30.0;
/// Most chunks before the heights.
const MOST_CHUNKS: usize = 64;

/// What the chunks say.
#[derive(Clone, Copy, Debug)]
struct Header {
    flat: Flat,
    /// Metres of a unit to the east, to the north and up.
    unit: [f64; 3],
    /// Units of height that 65536 steps are.
    height_scale: f64,
    /// Units of height of the number 0.
    base: f64,
}

impl Header {
    fn of(input: &Input<'_>) -> Result<Self, Fault> {
        let head = input.head()?;
        let (mut size, mut points, mut unit) = (None, [None; 2], [UNIT; 3]);
        let mut at = 16;
        for _ in 0..MOST_CHUNKS {
            let part = |from: usize, len: usize| {
                let short =
                    Fault::Short { what: "a chunk", want: (from + len) as u64, found: input.bytes.len() };
                head.get(from..from + len).ok_or(short)
            };
            let word = |from: usize| part(from, 2).map(|b| u16::from_le_bytes([b[0], b[1]]));
            let float =
                |from: usize| part(from, 4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
            let name = part(at, 4)?;
            at += 4;
            match name {
                b"SIZE" => size = Some(u64::from(word(at)?) + 1),
                b"XPTS" => points[0] = Some(u64::from(word(at)?)),
                b"YPTS" => points[1] = Some(u64::from(word(at)?)),
                b"SCAL" => unit = [float(at)?, float(at + 4)?, float(at + 8)?],
                b"CRAD" | b"CRVM" => (),
                b"ALTW" => {
                    let signed = |from: usize| word(from).map(|w| f64::from(w as i16));
                    let (height_scale, base) = (signed(at)?, signed(at + 2)?);
                    let side = |k: usize| points[k].or(size);
                    let no_size = || Fault::damaged("heights before their size");
                    let (cols, rows) = side(0).zip(side(1)).ok_or_else(no_size)?;
                    if unit.iter().any(|u| !(u.is_normal() && *u > 0.0)) {
                        return Err(Fault::Damaged(format!("a scale of {unit:?}")));
                    }
                    let flat = Flat::packed([cols, rows], Number::I16, false, at as u64 + 4);
                    flat.check(input)?;
                    return Ok(Self { flat, unit, height_scale, base });
                }
                other => {
                    let name = String::from_utf8_lossy(other);
                    return Err(Fault::Damaged(format!(
                        "an unknown chunk `{}` before the heights",
                        name.escape_debug()
                    )));
                }
            }
            at += if name == b"SCAL" { 12 } else { 4 };
        }
        Err(Fault::damaged("no heights"))
    }
}

fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let Header { flat, .. } = Header::of(input)?;
    Claim::new(input, [flat.cols, flat.rows], flat.line)
}

fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let Header { flat, unit: [x, y, up], height_scale, base } = Header::of(input)?;
    // A person's mark of voids is a number of the file, before it is scaled.
    let of = |v: f64| match input.reading.nodata {
        Some(code) if v == code => f32::NAN,
        _ => ((base + v * height_scale / 65536.0) * up) as f32,
    };
    let data = flat.read(input, of)?;
    let (cols, rows) = (flat.cols as usize, flat.rows as usize);
    let mut origin = Origin::new(&CODEC, "i16");
    origin.plain = false;
    let mut file =
        HeightFile { cols, rows, data, metres: true, placement: Placement::of_cell([x, y]), origin };
    file.flip();
    Ok(file)
}
