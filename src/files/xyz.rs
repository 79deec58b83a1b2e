//! Regular grids as lines of x, y and z, in any order of the points; places that no line names are void.

use super::codec::Codec;
use super::error::Fault;
use super::height::{HeightFile, Origin, filled};
use super::input::{Claim, Input};
use super::place::{Affine, Anchor};
use super::voids::strike;
use super::{wkt, world};

pub(super) static CODEC: Codec = Codec {
    name: "XYZ",
    extensions: &["xyz"],
    magic: &[],
    companions: &["prj"],
    claims_early: false,
    claim,
    read,
    reads: "lines of x, y, z on a regular grid, in any order, parted by blanks, tabs, commas or semicolons; a line of names \
            may come first; places without a line are void",
    metres: "yes; the unit that a `.prj` gives heights is applied",
    place: "yes; EPSG code and unit from `.prj`",
};

/// Bytes of text that are read at once.
const BLOCK: usize = 1 << 20;
/// Longest line.
const LONGEST_LINE: usize = 1 << 12;
/// How far from its place on the grid a point may lie, in steps.
const OFF: f64 = 0.1;

/// The grid on which the points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lattice {
    west: f64,
    north: f64,
    step: [f64; 2],
    cols: u64,
    rows: u64,
}

/// What the first pass learns of one coordinate.
#[derive(Clone, Copy, Debug)]
struct Axis {
    min: f64,
    max: f64,
    /// The smallest step between points that follow each other.
    least: f64,
    /// Sum and number of the steps that are about as long.
    sum: f64,
    count: f64,
    before: Option<f64>,
}

impl Axis {
    fn new() -> Self {
        let (min, max) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { min, max, least: f64::INFINITY, sum: 0.0, count: 0.0, before: None }
    }

    fn take(&mut self, v: f64) {
        self.min = self.min.min(v);
        self.max = self.max.max(v);
        if let Some(before) = self.before.replace(v) {
            let step = (v - before).abs();
            if step > 0.0 && step < 0.75 * self.least {
                (self.least, self.sum, self.count) = (step, 0.0, 0.0);
            }
            if step > 0.0 && step < 1.25 * self.least {
                self.sum += step;
                self.count += 1.0;
            }
        }
    }

    /// Step and number of points; digits that were cut off weigh less in the mean, and least over the whole length.
    fn points(&self) -> (f64, u64) {
        let length = self.max - self.min;
        if self.count == 0.0 || length == 0.0 {
            return (1.0, 1);
        }
        let intervals = (length / (self.sum / self.count)).round().max(1.0);
        (length / intervals, (intervals as u64).saturating_add(1))
    }
}

/// Which columns hold x, y and z.
#[derive(Clone, Copy, Debug)]
struct Columns([usize; 3]);

impl Columns {
    /// By the names of a first line, where they are known.
    fn of(line: &str) -> Self {
        let names: Vec<String> =
            words(line).map(|w| w.trim_matches(['"', '#']).to_ascii_lowercase()).collect();
        let find = |known: &[&str]| names.iter().position(|n| known.contains(&n.as_str()));
        let x = find(&["x", "lon", "long", "longitude", "easting", "east", "e"]);
        let y = find(&["y", "lat", "latitude", "northing", "north", "n"]);
        let z = find(&["z", "height", "elevation", "elev", "altitude", "alt", "h", "value"]);
        match (x, y, z) {
            (Some(x), Some(y), Some(z)) => Self([x, y, z]),
            _ => Self([0, 1, 2]),
        }
    }
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    let commas = !line.contains(';') && !line.trim().contains([' ', '\t']);
    line.split(move |c: char| {
        c.is_ascii_whitespace() || c == ';' || (c == ',' && (commas || line.contains(", ")))
    })
    .filter(|w| !w.is_empty())
}

fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| word.replacen(',', ".", 1).parse().ok())
}

/// Gives every point of the text to `take`, with the number of its line.
fn each_point(
    input: &Input<'_>,
    share: [f32; 2],
    mut take: impl FnMut(u64, [f64; 3]) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let (mut offset, end, mut text) = (0, input.bytes.len(), Vec::new());
    let (mut number_of_line, mut columns) = (0u64, None);
    while offset < end {
        let kept = text.len();
        let count = (end - offset).min(BLOCK as u64) as usize;
        text.resize(kept + count, 0);
        input.bytes.read_at(offset, &mut text[kept..])?;
        offset += count as u64;
        let last = text.iter().rposition(|b| matches!(b, b'\n' | b'\r')).map_or(0, |i| i + 1);
        let cut = if offset == end { text.len() } else { last };
        for line in text[..cut].split(|b| *b == b'\n') {
            number_of_line += 1;
            let line = std::str::from_utf8(line).map_err(|_| bad(number_of_line, "is no text"))?;
            let line = line.trim_start_matches('\u{feff}').trim();
            if line.is_empty() || (line.starts_with(['#', '/', '!']) && columns.is_some()) {
                continue;
            }
            let Columns(at) = *columns.get_or_insert_with(|| Columns::of(line));
            let mut point = [None; 3];
            for (i, word) in words(line).enumerate() {
                at.iter().position(|k| *k == i).into_iter().for_each(|k| point[k] = Some(word));
            }
            match point.map(|w| w.and_then(number)) {
                [Some(x), Some(y), Some(z)] if x.is_finite() && y.is_finite() => {
                    take(number_of_line, [x, y, z])?
                }
                // The first line may be one of names, and remarks may stand before it.
                _ if number_of_line == 1 || line.starts_with(['#', '/', '!', '"']) => {
                    columns = Some(Columns::of(line));
                }
                _ => return Err(bad(number_of_line, "is not x, y and z")),
            }
        }
        text.drain(..cut);
        if text.len() > LONGEST_LINE {
            return Err(bad(number_of_line + 1, "has more than 4096 letters"));
        }
        input.work.step(share[0] + (share[1] - share[0]) * offset as f32 / end as f32)?;
    }
    Ok(())
}

fn bad(line: u64, what: &str) -> Fault {
    Fault::Damaged(format!("line {line} {what}"))
}

/// The grid that the points span.
fn lattice(input: &Input<'_>) -> Result<Lattice, Fault> {
    let (mut x, mut y, mut points) = (Axis::new(), Axis::new(), 0u64);
    each_point(input, [0.0, 0.4], |_, p| {
        x.take(p[0]);
        y.take(p[1]);
        points += 1;
        Ok(())
    })?;
    if points == 0 {
        return Err(Fault::damaged("no line of x, y and z"));
    }
    let ((dx, cols), (dy, rows)) = (x.points(), y.points());
    input.limits.samples(cols, rows)?;
    // Points that are not on a grid make a grid of a great many places, and lie on few of them.
    if cols.saturating_mul(rows) / 64 > points.saturating_add(1024) {
        return Err(Fault::Unsupported(format!("{points} points that lie on no regular grid")));
    }
    Ok(Lattice { west: x.min, north: y.max, step: [dx, dy], cols, rows })
}

fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let Lattice { cols, rows, .. } = lattice(input)?;
    Claim::new(input, [cols, rows], 2 * BLOCK as u64)
}

fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let Lattice { west, north, step: [dx, dy], cols, rows } = lattice(input)?;
    let (cols, rows) = (cols as usize, rows as usize);
    let mut data = filled(cols * rows, f32::NAN, &input.work)?;
    let (mut again, mut first) = (0u64, None);
    each_point(input, [0.4, 1.0], |line, [x, y, z]| {
        let (u, v) = ((x - west) / dx, (north - y) / dy);
        if (u - u.round()).abs() > OFF || (v - v.round()).abs() > OFF {
            return Err(bad(line, "lies on no regular grid with the others"));
        }
        let (i, j) = ((u.round() as usize).min(cols - 1), (v.round() as usize).min(rows - 1));
        let place = &mut data[j * cols + i];
        if !place.is_nan() && *place != z as f32 {
            again += 1;
            first.get_or_insert(line);
        }
        *place = z as f32;
        Ok(())
    })?;
    let mut origin = Origin::new(&CODEC, "text");
    origin.notes.extend(first.map(|line| {
        let lines = if again == 1 { "1 line gives".into() } else { format!("{again} lines give") };
        format!("{lines} a place another height than a line before, the first of them line {line}: the last counts")
    }));
    let system = world::system(input, &mut origin.notes);
    let affine = Affine::upright([west, north], [dx, dy]);
    let placement = world::placed(affine, Anchor::Point, system, [cols, rows]);
    let unit = wkt::metres_of_heights(system.as_ref(), &mut origin.notes);
    let mut file = HeightFile { cols, rows, data, metres: true, placement, origin };
    strike(&mut file.data, input.reading.nodata);
    file.scale(unit, 0.0);
    Ok(file)
}
