//! Headerless rasters with a text beside them that describes them: Esri's `.flt` and `.bil`, with a `.hdr`.

use super::codec::Codec;
use super::error::{Fault, known_bands};
use super::flat::{Flat, Number, height};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::{Affine, Anchor, Placement};
use super::voids::strike;
use super::{wkt, world};

pub(super) static FLT: Codec = Codec {
    name: "Esri float grid",
    extensions: &["flt"],
    magic: &[],
    companions: &["hdr", "prj"],
    claims_early: true,
    claim: |input| claim(input, &FLT),
    read: |input| read(input, &FLT),
    reads: "32-bit floats, described by a `.hdr` beside them",
    metres: "yes; the unit that a `.prj` gives heights is applied",
    place: "from `.hdr`; EPSG code and unit from `.prj`",
};

pub(super) static BIL: Codec = Codec {
    name: "Esri band file",
    extensions: &["bil", "bip", "bsq"],
    magic: &[],
    companions: &["hdr", "prj", "blw", "bilw", "bpw", "bqw"],
    claims_early: true,
    claim: |input| claim(input, &BIL),
    read: |input| read(input, &BIL),
    reads: "u8 i8 u16 i16 u32 i32 f32 f64 in either byte order, described by a `.hdr` beside them: bands, layout, bytes \
            to skip; of several bands the first, or the one whose number `channel` gives",
    metres: "yes; the unit that a `.prj` gives heights is applied",
    place: "from `.hdr`, or else `.blw`, `.bpw` or `.bqw`; EPSG code and unit from `.prj`",
};

/// The words for the number that marks voids.
const NODATA: [&str; 2] = ["nodata_value", "nodata"];
/// Longest header that is read, in bytes.
const LONGEST: usize = 1 << 16;

/// The words of a header and their values.
struct Header {
    words: Vec<(String, String)>,
}

impl Header {
    fn of(input: &Input<'_>) -> Result<Self, Fault> {
        let bytes = input.companion("hdr").ok_or_else(|| {
            Fault::unsupported("it has no header of its own, and no .hdr of the same name stands beside it")
        })?;
        if bytes.len() > LONGEST {
            return Err(Fault::Damaged(format!("a .hdr of {} bytes; the limit is {LONGEST}", bytes.len())));
        }
        let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).into_owned();
        let pair = |line: &str| {
            let mut words = line.split_ascii_whitespace();
            let key = words.next()?.trim_end_matches([':', '=']).to_ascii_lowercase();
            let value = words.find(|w| *w != "=")?;
            Some((key, value.to_owned()))
        };
        Ok(Self { words: text.lines().filter_map(pair).collect() })
    }

    fn word(&self, keys: &[&str]) -> Option<&str> {
        self.words.iter().find(|(k, _)| keys.contains(&k.as_str())).map(|(_, v)| v.as_str())
    }

    fn number(&self, keys: &[&str]) -> Option<f64> {
        let word = self.word(keys)?;
        word.parse().ok().or_else(|| word.replacen(',', ".", 1).parse().ok())
    }

    /// A whole number that must make sense where it is there.
    fn count(&self, keys: &[&str]) -> Result<Option<u64>, Fault> {
        let Some(word) = self.word(keys) else { return Ok(None) };
        let whole = word.parse::<f64>().ok().filter(|v| *v >= 0.0 && v.fract() == 0.0 && *v < 1e15);
        match whole {
            Some(v) => Ok(Some(v as u64)),
            None => Err(Fault::Damaged(format!(
                "`{}` of its .hdr must be a whole number, got \"{word}\"",
                keys[0]
            ))),
        }
    }

    fn need(&self, key: &str) -> Result<u64, Fault> {
        let found = self.count(&[key])?.filter(|n| *n > 0);
        found.ok_or_else(|| Fault::Damaged(format!("its .hdr has no `{key}` above 0")))
    }

    /// The type of the numbers.
    fn number_type(&self, codec: &Codec) -> Result<Number, Fault> {
        let bits = self.count(&["nbits"])?;
        let kind = self.word(&["pixeltype"]).unwrap_or_default().to_ascii_uppercase();
        if !(kind.is_empty() || ["FLOAT", "SIGNED", "UNSIGNED"].iter().any(|k| kind.starts_with(k))) {
            return Err(unknown("pixeltype", &kind));
        }
        let float = kind.starts_with("FLOAT") || *codec == FLT;
        let unsigned = kind.starts_with("UNSIGNED") || self.sign_by_default() == Some(false);
        let default = if float { 32 } else { 8 };
        Ok(match (bits.unwrap_or(default), float) {
            (8, false) if kind.starts_with("SIGNED") => Number::I8,
            (8, false) => Number::U8,
            (16, false) if unsigned => Number::U16,
            (16, false) => Number::I16,
            (32, false) if unsigned => Number::U32,
            (32, false) => Number::I32,
            (32, true) => Number::F32,
            (64, true) => Number::F64,
            (bits, _) => {
                return Err(Fault::Unsupported(format!("samples of {bits} bits and type \"{kind}\"")));
            }
        })
    }

    /// Whether integers have a sign, where the header does not say: as GDAL has it, they have none, unless their mark
    /// of voids has one.
    fn sign_by_default(&self) -> Option<bool> {
        let below_zero = self.number(&NODATA).is_some_and(|v| v < 0.0);
        self.word(&["pixeltype"]).is_none().then_some(below_zero)
    }

    /// What a person should know of integers whose sign the header does not tell.
    fn note_of_sign(&self, number: Number) -> Option<String> {
        if !matches!(number, Number::U16 | Number::I16 | Number::U32 | Number::I32) {
            return None;
        }
        let (how, other) = match self.sign_by_default()? {
            true => ("with a sign, as its mark of voids has one", "UNSIGNEDINT"),
            false => ("without a sign, as GDAL does", "SIGNEDINT"),
        };
        Some(format!(
            "its .hdr names no `pixeltype`: the numbers are read {how}; `pixeltype {other}` would say otherwise"
        ))
    }

    /// Whether the highest byte of a number comes first.
    fn is_big_endian(&self) -> Result<bool, Fault> {
        let word = self.word(&["byteorder"]).unwrap_or("I");
        let plain = word.to_ascii_uppercase().replace(['_', '-'], "");
        match plain.as_str() {
            "I" | "II" | "L" | "LSB" | "LSBFIRST" | "INTEL" | "LITTLE" | "LITTLEENDIAN" => Ok(false),
            "M" | "MM" | "MSB" | "MSBFIRST" | "MOTOROLA" | "BIG" | "BIGENDIAN" => Ok(true),
            _ => Err(unknown("byteorder", word)),
        }
    }

    /// What a person should know of a mark of voids that is no number.
    fn note_of_nodata(&self) -> Option<String> {
        let word = self.word(&NODATA).filter(|_| self.number(&NODATA).is_none())?;
        Some(format!("the `nodata` of its .hdr, \"{word}\", is no number: it marks no voids"))
    }

    /// Where the numbers of a band lie.
    fn flat(&self, codec: &Codec, band: u64, bands: u64) -> Result<Flat, Fault> {
        let (cols, rows) = (self.need("ncols")?, self.need("nrows")?);
        let number = self.number_type(codec)?;
        let big = self.is_big_endian()?;
        let width = number.bytes();
        let row = cols.saturating_mul(width);
        let band_row = self.count(&["bandrowbytes"])?.unwrap_or(row);
        let skip = self.count(&["skipbytes"])?.unwrap_or(0);
        let layout = self.word(&["layout", "interleaving"]).unwrap_or("BIL").to_ascii_uppercase();
        let total = self.count(&["totalrowbytes"])?;
        let (step, line, first) = match layout.as_str() {
            "BIP" => {
                let step = width.saturating_mul(bands);
                (step, total.unwrap_or(cols.saturating_mul(step)), band * width)
            }
            "BSQ" => {
                let gap = self.count(&["bandgapbytes"])?.unwrap_or(0);
                let plane = total.unwrap_or(row).saturating_mul(rows).saturating_add(gap);
                (width, total.unwrap_or(row), plane.saturating_mul(band))
            }
            "BIL" => (width, total.unwrap_or(band_row.saturating_mul(bands)), band_row.saturating_mul(band)),
            other => return Err(unknown("layout", other)),
        };
        Ok(Flat { cols, rows, number, big, skip: skip.saturating_add(first), step, line })
    }

    fn placement(&self, [cols, rows]: [usize; 2], system: Option<wkt::System>) -> Placement {
        let cell = self.number(&["cellsize"]);
        let [dx, dy] = [["xdim", "dx"], ["ydim", "dy"]].map(|keys| self.number(&keys).or(cell));
        let Some((dx, dy)) = dx.zip(dy) else {
            return Placement::default();
        };
        // The map's own point is the middle of the north-west cell; a grid's that of the south-west, or its corner.
        let down = dy * (rows - 1) as f64;
        let west = self.number(&["xllcorner"]).map(|x| x + dx / 2.0).or(self.number(&["xllcenter"]));
        let south = self.number(&["yllcorner"]).map(|y| y + dy / 2.0).or(self.number(&["yllcenter"]));
        let west = self.number(&["ulxmap"]).or(west);
        let north = self.number(&["ulymap"]).or(south.map(|y| y + down));
        let (Some(west), Some(north)) = (west, north) else { return Placement::of_cell([dx, dy]) };
        let affine = Affine::upright([west, north], [dx, dy]);
        let centers = self.word(&["xllcenter"]).is_some();
        let anchor = if centers { Anchor::Point } else { Anchor::Area };
        if affine.is_sound() {
            world::placed(affine, anchor, system, [cols, rows])
        } else {
            Placement::default()
        }
    }
}

/// The fault of a value that would change how all numbers are read, and is not known.
fn unknown(key: &str, value: &str) -> Fault {
    Fault::Unsupported(format!("`{key} {value}` in its .hdr, which is not known"))
}

/// Which band is read, of how many.
fn band(input: &Input<'_>, header: &Header) -> Result<(u64, u64), Fault> {
    let bands = header.count(&["nbands"])?.unwrap_or(1).max(1);
    let Some(asked) = input.reading.channel.as_deref() else { return Ok((0, bands)) };
    let number = asked.parse::<u64>().ok().filter(|n| (1..=bands).contains(n));
    let unknown = || Fault::Channel { asked: asked.to_owned(), known: known_bands(bands) };
    Ok((number.ok_or_else(unknown)? - 1, bands))
}

fn claim(input: &Input<'_>, codec: &Codec) -> Result<Claim, Fault> {
    let header = Header::of(input)?;
    let (band, bands) = band(input, &header)?;
    let flat = header.flat(codec, band, bands)?;
    flat.check(input)?;
    Claim::new(input, [flat.cols, flat.rows], flat.line)
}

fn read(input: &Input<'_>, codec: &'static Codec) -> Result<HeightFile, Fault> {
    let header = Header::of(input)?;
    let (band, bands) = band(input, &header)?;
    let flat = header.flat(codec, band, bands)?;
    let nodata = header.number(&NODATA);
    let mut data = flat.read(input, height(nodata))?;
    strike(&mut data, input.reading.nodata);
    let (cols, rows) = (flat.cols as usize, flat.rows as usize);
    let mut origin = Origin::new(codec, flat.number.name());
    origin.nodata = nodata;
    origin.bands = bands as usize;
    origin.notes.extend(header.note_of_sign(flat.number));
    origin.notes.extend(header.note_of_nodata());
    if bands > 1 {
        origin.notes.push(format!("{bands} bands, of which number {} is read", band + 1));
    }
    let system = world::system(input, &mut origin.notes);
    let mut placement = header.placement([cols, rows], system);
    if placement.affine.is_none()
        && let Some(affine) = world::beside(input, &mut origin.notes)
    {
        placement = world::placed(affine, Anchor::Area, system, [cols, rows]);
    }
    let unit = wkt::metres_of_heights(system.as_ref(), &mut origin.notes);
    let mut file = HeightFile { cols, rows, data, metres: true, placement, origin };
    file.scale(unit, 0.0);
    Ok(file)
}
