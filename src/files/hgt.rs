//! SRTM tiles: one degree square, 16-bit big-endian metres, named after their south-west corner.

use super::codec::Codec;
use super::error::Fault;
use super::flat::{Flat, Number, height};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::{Affine, Anchor, Placement, Units};

pub(super) static CODEC: Codec = Codec {
    name: "SRTM .hgt",
    extensions: &["hgt"],
    magic: &[],
    companions: &[],
    claims_early: true,
    claim,
    read,
    reads: "SRTM tile, big-endian: a square of any size, or the narrower tiles of high latitudes (1801 x 3601, 601 x 1201 \
            and others of 1/3600, 1/1200 or 1/7200 degree); the name gives the corner",
    metres: "yes",
    place: "EPSG:4326",
};

/// The number that marks a void.
const VOID: f64 = i16::MIN as f64;
/// Rows of tiles that are not square: of half an arc second, of one, of three.
const ROWS: [u64; 3] = [7201, 3601, 1201];
/// How many times fewer columns than rows they have, as tenths: what models of high latitudes use.
const FEWER: [u64; 5] = [15, 20, 30, 50, 100];

/// Samples in a row, and rows: those of a square, or of a narrower tile.
fn size(input: &Input<'_>) -> Result<[u64; 2], Fault> {
    let found = input.bytes.len();
    let side = (found / 2).isqrt();
    if side >= 2 && side * side * 2 == found {
        return Ok([side, side]);
    }
    let narrow = |rows: u64| {
        let cols = found / 2 / rows;
        if cols < 2 || cols * rows * 2 != found {
            return None;
        }
        let fewer = FEWER.iter().any(|tenths| (cols - 1) * tenths == (rows - 1) * 10);
        fewer.then_some([cols, rows])
    };
    // Nothing else than the length tells the size.
    input.limits.samples(side, side)?;
    ROWS.into_iter().find_map(narrow).ok_or_else(|| {
        Fault::damaged(format!(
            "{found} bytes are no square of 16-bit samples, nor a tile of 3601 or 1201 rows with half the columns"
        ))
    })
}

fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    Claim::new(input, size(input)?, 0)
}

/// Reads a tile; the name says where it lies, the length how fine it is.
fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let size = size(input)?;
    let [cols, rows] = size.map(|n| n as usize);
    let mut origin = Origin::new(&CODEC, "i16");
    origin.nodata = Some(VOID);
    let placement = match corner(input.name) {
        Some([east, north]) => {
            let step = size.map(|n| 1.0 / (n - 1) as f64);
            let affine = Affine::upright([east, north + 1.0], step);
            Placement::new(affine, Anchor::Point, Some(4326), Units::Degrees, [cols, rows])
        }
        None => {
            let note = "the name is not that of an SRTM tile, such as N44E005.hgt: no place is known";
            origin.notes.push(note.into());
            Placement::default()
        }
    };
    let data = Flat::packed(size, Number::I16, true, 0).read(input, height(Some(VOID)))?;
    Ok(HeightFile { cols, rows, data, metres: true, placement, origin })
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
