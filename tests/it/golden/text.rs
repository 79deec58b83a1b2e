//! An entry as text.
//!
//! ```text
//! blur {} field  v1 1fde67fdbc5f008d  -617.364 -10.323 622.743
//!   48 49 52 55 …
//! ```
//! A raster has its lowest value, its mean and its highest, and below them the means of 16 x 16 blocks in hundredths of
//! the range from lowest to highest: what differs by less than one is not told apart. Components stand side by side.
//! Curves have a line each. What is the same as under other parameters of the kind names those.

use std::collections::BTreeMap;

use orograph::value::curves::Curve;
use orograph::value::{Constraints, Curves, Planes, Value};

const BLOCKS: usize = 16;

/// A result: the version of its kind, its hash, and what a person may look at.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) version: u32,
    pub(super) hash: String,
    pub(super) line: String,
    pub(super) picture: Vec<String>,
}

impl Entry {
    pub(super) fn fails(&self) -> bool {
        self.hash == "fails"
    }

    /// How far it is from what it was.
    pub(super) fn beside(&self, was: &Self) -> String {
        let change = format!("v{} {} was {}", self.version, self.hash, was.hash);
        if self.fails() || was.fails() {
            return format!("{change}: {} was {}", self.line, was.line);
        }
        let numbers = |e: &Self| {
            e.picture.iter().flat_map(|l| l.split_whitespace()).map(str::parse::<i32>).collect::<Vec<_>>()
        };
        let off: Vec<i32> = (numbers(self).iter().zip(numbers(was)))
            .filter_map(|(a, b)| Some((a.as_ref().ok()? - b.ok()?).abs()))
            .filter(|off| *off > 1)
            .collect();
        let line = format!("{change}, {} was {}", self.line, was.line);
        match off.iter().max() {
            None => format!("{line}; all blocks within a hundredth of the range"),
            Some(most) => format!("{line}; {} blocks differ, by up to {most} hundredths", off.len()),
        }
    }
}

/// What a person may look at: a line, and lines below it.
pub(super) fn picture_of(value: &Value) -> (String, Vec<String>) {
    match value {
        Value::Object(object) => match (object.get::<Curves>(), object.get()) {
            (Some(curves), _) => (format!("{} curves", curves.len()), curves.iter().map(of_curve).collect()),
            (_, Some(constraints)) => of_constraints(constraints),
            _ => (format!("{} bytes", object.bytes()), Vec::new()),
        },
        raster => {
            let (grid, all) = (*raster.grid().expect("a raster"), raster.components());
            let parts = raster.wire_type().channels();
            let (lo, mean, hi) = numbers(all);
            let planes: Vec<Vec<f32>> =
                (0..parts).map(|k| all.iter().skip(k).step_by(parts).copied().collect()).collect();
            let blocks: Vec<_> = planes.iter().map(|p| blocks(p, grid.cols, (lo, hi))).collect();
            let line = |j: usize| blocks.iter().map(|b| b[j].as_str()).collect::<Vec<_>>().join("   ");
            let picture = if lo < hi { (0..BLOCKS).map(line).collect() } else { Vec::new() };
            (format!("{} {} {}", short(lo), short(mean), short(hi)), picture)
        }
    }
}

/// The lowest of some numbers, their mean, the highest.
fn numbers(all: &[f32]) -> (f64, f64, f64) {
    let fold = |(lo, hi): (f64, f64), x: &f32| (lo.min(f64::from(*x)), hi.max(f64::from(*x)));
    let (lo, hi) = all.iter().fold((f64::MAX, f64::MIN), fold);
    (lo, all.iter().map(|x| f64::from(*x)).sum::<f64>() / all.len() as f64, hi)
}

/// Six digits at most.
fn short(v: f64) -> String {
    if v != 0.0 && !(1e-3..1e6).contains(&v.abs()) { format!("{v:.3e}") } else { format!("{v:.3}") }
}

/// The means of blocks in hundredths of a range, a text a row.
fn blocks(data: &[f32], cols: usize, (lo, hi): (f64, f64)) -> Vec<String> {
    let rows = data.len() / cols;
    let cut = |k: usize, n: usize| (k * n / BLOCKS, ((k + 1) * n / BLOCKS).max(k * n / BLOCKS + 1).min(n));
    let mean = |j: usize, i: usize| {
        let ((r0, r1), (c0, c1)) = (cut(j, rows), cut(i, cols));
        let all = (r0..r1).flat_map(|r| &data[r * cols + c0..r * cols + c1]);
        let share =
            all.map(|x| (f64::from(*x) - lo) / (hi - lo)).sum::<f64>() / ((r1 - r0) * (c1 - c0)) as f64;
        format!("{:02}", (share * 100.0).round() as i64)
    };
    let line = |j: usize| (0..BLOCKS).map(|i| mean(j, i)).collect::<Vec<_>>().join(" ");
    (0..BLOCKS).map(line).collect()
}

fn of_curve(curve: &Curve) -> String {
    let place = |u: f64| {
        let [x, y] = curve.point(u);
        let height = curve.height(u).map_or(String::new(), |h| format!(" at {h:.2} m"));
        format!("{x:.1} {y:.1}{height}")
    };
    let (points, name) = (curve.points().len(), curve.name());
    let ends = [0.0, 0.5, 1.0].map(place).join(", ");
    format!("`{name}` {} pieces, {:.1} m, {points} points: {ends}", curve.pieces(), curve.length())
}

fn of_constraints(constraints: &Constraints) -> (String, Vec<String>) {
    let Planes { marks, height, lean, direction, steepness, trust, ground, noise, envelope } =
        constraints.planes();
    let known: Vec<f32> = marks.iter().map(|m| f32::from(u8::from(*m != 0))).collect();
    let single = [height, steepness, trust, ground, envelope].map(|p| p.as_deref().unwrap_or(&[]));
    let pairs = [lean, direction, noise].map(|p| p.as_deref().map_or(&[][..], bytemuck::cast_slice));
    let names = ["height", "steepness", "trust", "ground", "envelope", "lean", "direction", "noise"];
    let of = |(name, plane): (&str, &[f32])| {
        let (lo, mean, hi) = numbers(plane);
        (!plane.is_empty()).then(|| format!("{name} {} {} {}", short(lo), short(mean), short(hi)))
    };
    let planes = names.into_iter().zip(single.into_iter().chain(pairs)).filter_map(of);
    let mut picture = blocks(&known, constraints.grid().cols, (0.0, 1.0));
    picture.extend(planes);
    (format!("{:.4} known", numbers(&known).1), picture)
}

/// Entries as they stand in the file.
pub(super) fn write(entries: &BTreeMap<String, Entry>) -> String {
    let one = |(name, e): (&String, &Entry)| {
        let picture: String = e.picture.iter().map(|l| format!("  {l}\n")).collect();
        format!("{name}  v{} {}  {}\n{picture}", e.version, e.hash, e.line)
    };
    entries.iter().map(one).collect()
}

/// Entries from the file; what is none is left out, and the file is then not as it would be written.
pub(super) fn read(text: &str) -> BTreeMap<String, Entry> {
    let mut all: Vec<(String, Entry)> = Vec::new();
    for line in text.lines() {
        match (line.strip_prefix("  "), all.last_mut()) {
            (Some(picture), Some((_, entry))) => entry.picture.push(picture.to_owned()),
            _ => all.extend(head(line)),
        }
    }
    all.into_iter().collect()
}

fn head(line: &str) -> Option<(String, Entry)> {
    let (name, rest) = line.split_once("  v")?;
    let (mark, line) = rest.split_once("  ")?;
    let (version, hash) = mark.split_once(' ')?;
    let (version, hash, line) = (version.parse().ok()?, hash.to_owned(), line.to_owned());
    Some((name.to_owned(), Entry { version, hash, line, picture: Vec::new() }))
}
