//! Esri ASCII grids.

use std::str::FromStr;

use rayon::prelude::*;

use super::bands::{self, Band, Split};
use super::codec::{Codec, Format, FormatSpec};
use super::error::{Fault, WriteError};
use super::height::{HeightFile, Origin, room};
use super::input::{Claim, Input};
use super::place::{Affine, Anchor, Placement, Units};
use super::sheet::{Sheet, Sink, unfit};
use super::voids::strike;
use super::wkt::{self, System};
use super::world;
use super::write::Written;

pub(super) static CODEC: Codec = Codec {
    name: "Esri ASCII grid",
    extensions: &["asc"],
    magic: &[],
    companions: &["prj"],
    claims_early: true,
    claim,
    read,
    reads: "Esri ASCII grid: corner or centre, `cellsize` or `dx` and `dy`, decimal points or commas, comments; `null`, \
            `nan` and the like are voids",
    metres: "yes; the unit that a `.prj` gives heights is applied",
    place: "yes; EPSG code and unit from `.prj`",
};

pub(super) static TEXT: FormatSpec = FormatSpec {
    name: "asc",
    by_extension: true,
    levels: None,
    channels: &[1],
    sidecar: false,
    flips: false,
    voids: true,
    write,
    nanoseconds: 140.0,
    holds: "Esri ASCII grid, every number to the bit",
    purpose: "old GIS",
};

/// Bytes of text that one task parses.
const PIECE: usize = 1 << 20;
/// Longest word that may be cut in two by the end of a block.
const LONGEST_WORD: usize = 1 << 12;

/// The header, and where the numbers begin.
fn header(input: &Input<'_>) -> Result<(Header, u64), Fault> {
    let head = input.head()?;
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head);
    let (header, body) = Header::parse(text)?;
    let at = (head.len() - body.len()) as u64;
    let total = input.limits.samples(header.cols, header.rows)?;
    // A number takes a digit and, but for the last, a blank.
    let (want, found) = (2 * total as u64 - 1, input.bytes.len() - at);
    if want > found {
        return Err(Fault::Short { what: "that many numbers", want, found });
    }
    Ok((header, at))
}

/// Bytes of text that are parsed at once.
fn block() -> usize {
    PIECE * 2 * rayon::current_num_threads()
}

/// What the header claims.
fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let (header, _) = header(input)?;
    // A block of text, and what is made of it: a number takes two bytes of text at least and four in memory.
    Claim::new(input, [header.cols, header.rows], 3 * (block() as u64).min(input.bytes.len()))
}

/// Reads a grid.
fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let (header, at) = header(input)?;
    let (cols, rows) = (header.cols as usize, header.rows as usize);
    let mut data = room(cols * rows)?;
    numbers(input, at, header.nodata, &mut data, cols * rows)?;
    let mut origin = Origin::new(&CODEC, "text");
    origin.nodata = header.nodata;
    strike(&mut data, input.reading.nodata);
    let system = world::system(input, &mut origin.notes);
    let placement = header.placement([cols, rows], system);
    let unit = wkt::metres_of_heights(system.as_ref(), &mut origin.notes);
    let mut file = HeightFile { cols, rows, data, metres: true, placement, origin };
    file.scale(unit, 0.0);
    Ok(file)
}

/// The lines before the numbers.
#[derive(Debug, Default)]
struct Header {
    cols: u64,
    rows: u64,
    corner: [Option<f64>; 2],
    center: [Option<f64>; 2],
    cell: [Option<f64>; 2],
    nodata: Option<f64>,
}

impl Header {
    /// Reads the keys; gives what follows.
    fn parse(mut text: &[u8]) -> Result<(Self, &[u8]), Fault> {
        let (mut header, mut cols, mut rows) = (Self::default(), None, None);
        loop {
            text = text.trim_ascii_start();
            if let [b'#' | b'/' | b'!', ..] = text {
                text = line(text).1;
                continue;
            }
            if !text.first().is_some_and(|c| c.is_ascii_alphabetic()) || is_void(word(text).0) {
                break;
            }
            let (key, rest) = word(text);
            let (value, rest) = word(rest.trim_ascii_start());
            let key = String::from_utf8_lossy(&key[..key.len().min(40)]).to_ascii_lowercase();
            let is_nodata = key.starts_with("nodata");
            let number = parse::<f64>(value)
                .or_else(|| is_void(value).then_some(f64::NAN))
                .filter(|v| v.is_finite() || is_nodata)
                .ok_or_else(|| Fault::Damaged(format!("`{key}` needs a number, got {}", brief(value))))?;
            let count = |v: f64| (v >= 1.0 && v.fract() == 0.0 && v < 1e15).then_some(v as u64);
            match key.trim_end_matches(':') {
                "ncols" => cols = count(number),
                "nrows" => rows = count(number),
                "xllcorner" => header.corner[0] = Some(number),
                "yllcorner" => header.corner[1] = Some(number),
                "xllcenter" | "xllcentre" => header.center[0] = Some(number),
                "yllcenter" | "yllcentre" => header.center[1] = Some(number),
                "cellsize" => {
                    let second = word(line(rest).0.trim_ascii_start()).0;
                    if parse::<f64>(second).is_some() {
                        let second = brief(second);
                        let why = format!("`cellsize` takes one number, and {second} follows it");
                        return Err(Fault::Damaged(format!("{why}; `dx` and `dy` give two")));
                    }
                    header.cell = [Some(number); 2];
                }
                "dx" | "xdim" | "xcellsize" | "cellsize_x" => header.cell[0] = Some(number),
                "dy" | "ydim" | "ycellsize" | "cellsize_y" => header.cell[1] = Some(number),
                "nodata_value" | "nodata" => header.nodata = Some(number),
                _ => return Err(Fault::Damaged(format!("an unknown key `{key}`"))),
            }
            text = rest;
        }
        let need = |v: Option<u64>, key: &str| {
            v.ok_or_else(|| Fault::Damaged(format!("no `{key}` with a whole number above 0")))
        };
        (header.cols, header.rows) = (need(cols, "ncols")?, need(rows, "nrows")?);
        if let Some(cell) = header.cell.iter().flatten().find(|c| **c <= 0.0) {
            return Err(Fault::Damaged(format!("a cell of {cell}")));
        }
        Ok((header, text))
    }

    fn placement(&self, size: [usize; 2], system: Option<System>) -> Placement {
        let [Some(dx), Some(dy)] = self.cell else { return Placement::default() };
        let anchor = if self.center[0].is_some() { Anchor::Point } else { Anchor::Area };
        let west = self.center[0].or(self.corner[0].map(|x| x + dx / 2.0));
        let south = self.center[1].or(self.corner[1].map(|y| y + dy / 2.0));
        let (Some(west), Some(south)) = (west, south) else {
            let metres = match system.map(|s| s.units) {
                Some(Units::Length(metres)) => metres,
                _ => 1.0,
            };
            return Placement::of_cell([dx * metres, dy * metres]);
        };
        let affine = Affine::upright([west, south + dy * (size[1] - 1) as f64], [dx, dy]);
        world::placed(affine, anchor, system, size)
    }
}

/// The first line, and what follows.
fn line(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|c| matches!(c, b'\n' | b'\r')).unwrap_or(text.len());
    text.split_at(end)
}

/// The first word, and what follows.
fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    text.split_at(end)
}

fn brief(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(&word[..word.len().min(80)]).chars().take(30).collect();
    format!("`{text}`")
}

/// Whether a word stands where there is no number: as people write it, and as programs of Microsoft do.
fn is_void(word: &[u8]) -> bool {
    const WORDS: [&[u8]; 11] =
        [b"nan", b"inf", b"infinity", b"null", b"none", b"na", b"n/a", b"nodata", b"no_data", b"void", b"*"];
    let bare = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let bare = bare.strip_suffix(b",").or(bare.strip_suffix(b";")).unwrap_or(bare);
    WORDS.iter().any(|w| bare.eq_ignore_ascii_case(w)) || bare.starts_with(b"1.#")
}

/// A number in the ways that people's programs write it: `1.5`, `1,5`, `1e3`, `1.5,`, `nan`.
fn parse<T: FromStr>(word: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(v) = text.parse() {
        return Some(v);
    }
    let text = text.trim_end_matches([',', ';']);
    text.parse().or_else(|_| text.replacen(',', ".", 1).parse()).ok()
}

/// Reads all numbers, voids as NaN, block by block.
fn numbers(
    input: &Input<'_>,
    at: u64,
    nodata: Option<f64>,
    data: &mut Vec<f32>,
    total: usize,
) -> Result<(), Fault> {
    let (mut offset, end) = (at, input.bytes.len());
    let (mut text, mut found) = (Vec::new(), 0);
    while offset < end {
        // What the last block left of a word stands before this one.
        let kept = text.len();
        let count = (end - offset).min(block() as u64) as usize;
        text.resize(kept + count, 0);
        input.bytes.read_at(offset, &mut text[kept..])?;
        offset += count as u64;
        let last_blank = text.iter().rposition(u8::is_ascii_whitespace);
        let cut = if offset == end { text.len() } else { last_blank.unwrap_or(0) };
        let pieces = pieces(&text[..cut]);
        let parsed: Vec<Vec<f32>> =
            pieces.par_iter().map(|p| piece(p, nodata)).collect::<Result<_, Fault>>()?;
        for numbers in parsed {
            found += numbers.len();
            // What is too many is counted and not kept.
            data.extend(numbers.into_iter().take(total - data.len()));
        }
        text.drain(..cut);
        if text.len() > LONGEST_WORD {
            return Err(Fault::damaged("a word of more than 4096 letters among the numbers"));
        }
        input.work.step(offset as f32 / end as f32)?;
    }
    if found != total {
        return Err(Fault::Damaged(format!("{found} numbers where {total} should be")));
    }
    Ok(())
}

/// The text cut at blanks into pieces of about [`PIECE`] bytes.
fn pieces(mut body: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    while body.len() > PIECE {
        let cut = body[PIECE..].iter().position(u8::is_ascii_whitespace).map_or(body.len(), |i| PIECE + i);
        let (piece, rest) = body.split_at(cut);
        pieces.push(piece);
        body = rest;
    }
    pieces.push(body);
    pieces
}

fn piece(text: &[u8], nodata: Option<f64>) -> Result<Vec<f32>, Fault> {
    let nodata = nodata.map(|v| v as f32);
    // Numbers of heights take about five bytes; the vector grows where they take fewer.
    let mut out = Vec::with_capacity(text.len() / 5 + 1);
    let mut rest = text.trim_ascii_start();
    while !rest.is_empty() {
        let (number, after) = word(rest);
        let v = parse(number).or_else(|| is_void(number).then_some(f32::NAN));
        let v: f32 = v.ok_or_else(|| Fault::Damaged(format!("{} is no number", brief(number))))?;
        out.push(if nodata == Some(v) || !v.is_finite() { f32::NAN } else { v });
        rest = after.trim_ascii_start();
    }
    Ok(out)
}

/// The text of a grid's first lines.
fn first_lines(size: [usize; 2], placement: &Placement, nodata: Option<f64>) -> String {
    use std::fmt::Write;
    let step = |a: &Affine| [libm::hypot(a.col[0], a.col[1]), libm::hypot(a.row[0], a.row[1])];
    let [dx, dy] = placement.affine.as_ref().map(step).or(placement.cell).unwrap_or([1.0, 1.0]);
    let [west, south] = placement.affine.map_or([0.0, 0.0], |a| a.at(0.0, (size[1] - 1) as f64));
    let mut text = format!("ncols {}\nnrows {}\n", size[0], size[1]);
    // Writing to a string cannot fail.
    let _ = match placement.anchor {
        Anchor::Point => write!(text, "xllcenter {west}\nyllcenter {south}\n"),
        Anchor::Area => write!(text, "xllcorner {}\nyllcorner {}\n", west - dx / 2.0, south - dy / 2.0),
    };
    let _ = if dx == dy { writeln!(text, "cellsize {dx}") } else { write!(text, "dx {dx}\ndy {dy}\n") };
    if let Some(nodata) = nodata {
        let _ = writeln!(text, "NODATA_value {nodata}");
    }
    text
}

/// Appends a row of numbers, each the shortest that reads back to the bit.
fn append_row(row: &[f32], nodata: f64, out: &mut Vec<u8>) {
    use std::io::Write;
    for (i, &v) in row.iter().enumerate() {
        let blank = if i == 0 { "" } else { " " };
        // Writing to a vector cannot fail.
        let _ = if v.is_nan() {
            write!(out, "{blank}{nodata}")
        } else if v != 0.0 && !(1e-5..1e15).contains(&v.abs()) {
            write!(out, "{blank}{v:e}")
        } else {
            write!(out, "{blank}{v}")
        };
    }
    out.push(b'\n');
}

/// A place that is read as it was meant, since an `.asc` names no unit, and what of the sheet's own is lost.
fn readable(sheet: &Sheet<'_>) -> (Placement, Option<String>) {
    let own = sheet.placement;
    let Some(a) = own.affine else {
        let lost =
            "how far apart its samples are is not known: an .asc must have a cell, and one of 1 is written";
        return (own, own.cell.is_none().then(|| lost.into()));
    };
    let system = own.epsg.map(|epsg| format!("EPSG:{epsg}"));
    let system = system.unwrap_or_else(|| "its own system".into());
    let read_as = Units::guess(&a, [sheet.cols, sheet.rows]);
    match own.units {
        units if units == read_as => {
            let lost = own.epsg.map(|_| format!("an .asc cannot say that it lies in {system}"));
            (own, lost)
        }
        Units::Length(1.0) => {
            let lost = "an .asc names no unit, and steps as short as these are often taken for degrees";
            (own, Some(lost.into()))
        }
        Units::Length(metres) => {
            let scaled = |v: [f64; 2]| v.map(|x| x * metres);
            let affine = Affine { origin: scaled(a.origin), col: scaled(a.col), row: scaled(a.row) };
            let lost = format!(
                "an .asc names no unit: its coordinates are written in metres, {metres} times those of {system}"
            );
            (Placement { affine: Some(affine), ..own }, Some(lost))
        }
        Units::Degrees | Units::WebMercator => {
            let step = own.cell.unwrap_or([1.0; 2]);
            let affine = Affine::upright([0.0, step[1] * (sheet.rows - 1) as f64], step);
            let written = match own.cell {
                Some(_) => "the cell is written in metres on the ground",
                None => "how far apart its samples are is not known, a cell of 1 is written",
            };
            let lost = format!("an .asc names no system: {written}, and the place in {system} is lost");
            (Placement { affine: Some(affine), ..own }, Some(lost))
        }
    }
}

fn write(sheet: &Sheet<'_>, out: &mut dyn Sink) -> Result<Written, WriteError> {
    let upright = sheet.placement.affine.is_none_or(|a| a.is_north_up());
    if !upright {
        return Err(unfit(Format::Asc, "a grid that is turned", "tiff can"));
    }
    let nodata = match sheet.nodata {
        Some(v) if v.is_finite() => Some(v),
        _ => sheet.has_voids().then_some(-9999.0),
    };
    let void = nodata.unwrap_or(-9999.0);
    let (placement, lost) = readable(sheet);
    out.write_all(first_lines([sheet.cols, sheet.rows], &placement, nodata).as_bytes())?;
    let make = |band: Band| {
        let mut text = Vec::with_capacity(band.rows * sheet.cols * 9);
        (band.first_row..band.first_row + band.rows).for_each(|j| append_row(sheet.row(j), void, &mut text));
        text
    };
    let split = Split::new(sheet.rows, sheet.cols * 9);
    bands::in_order(&split, &sheet.writing.work, make, |_, text| out.write_all(&text))?;
    Ok(Written { notes: lost.into_iter().collect(), ..Written::default() })
}
