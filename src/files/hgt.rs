//! SRTM tiles: one degree square, 16-bit big-endian metres, named after their south-west corner.

use super::codec::Codec;
use super::error::Fault;
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::{Affine, Anchor, Placement, Units};
use super::raw::samples;

pub(super) static CODEC: Codec = Codec {
    name: "SRTM .hgt",
    extensions: &["hgt"],
    magic: &[],
    companions: &[],
    claim,
    read,
    reads: "SRTM tile of any size, big-endian; the name gives the corner",
    metres: "yes",
    place: "EPSG:4326",
};

/// The number that marks a void.
const VOID: i16 = i16::MIN;

/// The samples along a side.
fn side(input: &Input<'_>) -> Result<u64, Fault> {
    let found = input.bytes.len() as u64;
    let side = (found / 2).isqrt();
    input.limits.samples(side, side)?;
    if side * side * 2 != found || side < 2 {
        return Err(Fault::damaged(format!("{found} bytes are no square of 16-bit samples")));
    }
    Ok(side)
}

fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let side = side(input)?;
    Claim::new(input, [side, side], 0)
}

/// Reads a tile; the name says where it lies, the length how fine it is.
fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let side = side(input)?;
    let n = side as usize;
    let height = |b: [u8; 2]| match i16::from_be_bytes(b) {
        VOID => f32::NAN,
        v => f32::from(v),
    };
    let mut origin = Origin::new(&CODEC, "i16");
    origin.nodata = Some(f64::from(VOID));
    let placement = match corner(input.name) {
        Some([east, north]) => {
            let step = 1.0 / (side - 1) as f64;
            let affine = Affine::upright([east, north + 1.0], [step, step]);
            Placement::new(affine, Anchor::Point, Some(4326), Units::Degrees, [n, n])
        }
        None => {
            origin
                .notes
                .push("the name is not that of an SRTM tile, such as N44E005.hgt: no place is known".into());
            Placement::default()
        }
    };
    let (pairs, _) = input.bytes.as_chunks::<2>();
    let data = samples(input, pairs, height)?;
    Ok(HeightFile { cols: n, rows: n, data, metres: true, placement, origin })
}

/// Longitude and latitude of the south-west corner in a name such as `dir/N44E005.hgt`.
fn corner(name: &str) -> Option<[f64; 2]> {
    let last = name.rsplit(['/', '\\']).next()?.to_ascii_uppercase();
    let number = |digits: &str| digits.parse::<u16>().ok().map(f64::from);
    let (ns, rest) = (last.get(..1)?, last.get(1..)?);
    let (latitude, ew, longitude) = (rest.get(..2)?, rest.get(2..3)?, rest.get(3..6)?);
    let north = match ns {
        "N" => number(latitude)?,
        "S" => -number(latitude)?,
        _ => return None,
    };
    let east = match ew {
        "E" => number(longitude)?,
        "W" => -number(longitude)?,
        _ => return None,
    };
    (north.abs() <= 90.0 && east.abs() <= 180.0).then_some([east, north])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_corners() {
        assert_eq!(corner("a/b/N44E005.hgt"), Some([5.0, 44.0]));
        assert_eq!(corner("s07w072.SRTMGL1.hgt"), Some([-72.0, -7.0]));
        assert_eq!(corner("height.hgt"), None);
        assert_eq!(corner("N99E005.hgt"), None);
        assert_eq!(corner("Né4E005.hgt"), None);
    }
}
