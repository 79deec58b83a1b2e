//! The form of the files in the cache folder: a magic line, the length of a JSON header, the header, the samples, and
//! the BLAKE3 hash of everything before it.

use std::borrow::Cow;
use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};

use super::FARTHEST;
use crate::engine::cache::Given;
use crate::engine::key::Key;
use crate::name::Name;
use crate::node::{Kind, Summary};
use crate::ports::Wires;
use crate::value::{Grid, Lattice, Quantity, Value, WireType};

/// The number of the form, which is part of the name of the folder. Every change of the form raises it; a test fails
/// where it was not raised.
pub(super) const FORM: u32 = 5;
const MAGIC: &[u8] = b"orograph cache\n";
/// The most bytes of a header, which has some hundred for each output.
const MOST_HEADER: u64 = 1 << 20;
const SUM: usize = blake3::OUT_LEN;

#[derive(Serialize, Deserialize)]
struct Header {
    /// A number in the byte order of the machine, so that files of the other byte order do not match.
    byte_order: [u8; 4],
    /// The key of the result, so that a file that was moved to another key does not match.
    key: String,
    summary: Option<u64>,
    values: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Entry {
    /// Samples.
    Raster {
        port: String,
        quantity: String,
        lattice: (f64, f64, f64, u32),
        window: (i64, i64, usize, usize),
        components: u64,
    },
    /// An object in its own form.
    Object { port: String, bytes: u64 },
}

impl Header {
    /// Bytes of the samples and objects that follow the header; `None` where the sum overflows.
    fn claimed(&self) -> Option<u64> {
        let values = self.values.iter().map(Entry::claimed);
        let numbers = self.summary.map_or(Some(0), |n| n.checked_mul(8));
        values.chain([numbers]).try_fold(0u64, |sum, part| sum.checked_add(part?))
    }
}

impl Entry {
    fn claimed(&self) -> Option<u64> {
        match self {
            Self::Raster { components, .. } => components.checked_mul(4),
            Self::Object { bytes, .. } => Some(*bytes),
        }
    }

    /// The entry of a value, and the bytes that follow.
    fn of<'a>(port: &str, value: &'a Value) -> Option<(Self, Cow<'a, [u8]>)> {
        let port = port.to_owned();
        if let Value::Object(object) = value {
            let data = object.save();
            return Some((Self::Object { port, bytes: data.len() as u64 }, data.into()));
        }
        let (g, quantity) = (value.grid()?, value.quantity()?);
        let l = g.lattice;
        let entry = Self::Raster {
            port,
            quantity: quantity.name().to_owned(),
            lattice: (l.origin[0], l.origin[1], l.span, l.intervals),
            window: (g.col, g.row, g.cols, g.rows),
            components: value.components().len() as u64,
        };
        Some((entry, bytemuck::cast_slice(value.components()).into()))
    }

    /// Reads the value of a port. `None` where the value is not of the type that the kind declares, has a fault, or
    /// does not contain the wanted window.
    fn value(
        &self,
        kind: &Kind,
        wanted: &Grid,
        fill: &mut impl FnMut(&mut [u8]) -> io::Result<()>,
    ) -> io::Result<Option<(Name, Value)>> {
        let (Self::Raster { port, .. } | Self::Object { port, .. }) = self;
        let Some(port) = kind.output(port) else { return Ok(None) };
        let value = match (self, port.wire) {
            (Self::Object { bytes, .. }, WireType::Object(object)) => {
                let mut data = vec![0; *bytes as usize];
                fill(&mut data)?;
                object.load.and_then(|load| load(&data))
            }
            (Self::Raster { quantity, lattice, window, components, .. }, wire) if wire.is_raster() => {
                let mut data = vec![0f32; *components as usize];
                fill(bytemuck::cast_slice_mut(&mut data))?;
                let quantity = Quantity::named(quantity);
                let grid = window_of(*lattice, *window, wanted);
                let made = quantity.zip(grid);
                let made =
                    made.and_then(|(quantity, grid)| Value::from_components(wire, grid, quantity, data));
                made.filter(|value| value.first_not_finite().is_none())
            }
            _ => None,
        };
        Ok(value.map(|value| (port.name.clone(), value)))
    }
}

/// A window, where it contains the wanted one.
fn window_of(
    (x, y, span, intervals): (f64, f64, f64, u32),
    (col, row, cols, rows): (i64, i64, usize, usize),
    wanted: &Grid,
) -> Option<Grid> {
    let near = |start: i64, count: usize| start.abs() <= FARTHEST && count as u64 <= FARTHEST as u64;
    let grid = Grid { lattice: Lattice { origin: [x, y], span, intervals }, col, row, cols, rows };
    // The numbers are checked before they are added, so that the sums do not overflow.
    let sound = col > i64::MIN && row > i64::MIN && near(col, cols) && near(row, rows);
    (sound && cols.checked_mul(rows).is_some() && grid.contains(wanted)).then_some(grid)
}

fn damaged() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "is damaged")
}

/// The parts of a file after its header.
type Parts<'a> = Vec<Cow<'a, [u8]>>;

/// The header and the parts that follow it.
fn parts<'a>(key: &Key, given: &'a Given) -> io::Result<(Vec<u8>, Parts<'a>)> {
    let (byte_order, key) = (1u32.to_ne_bytes(), key.to_string());
    let (header, parts): (_, Parts<'_>) = match given {
        Given::Summary(summary) => {
            let summary = &*summary.0;
            let count = Some(summary.len() as u64);
            (
                Header { byte_order, key, summary: count, values: Vec::new() },
                vec![bytemuck::cast_slice(summary).into()],
            )
        }
        Given::Wires(wires) => {
            let entries = wires.iter().filter_map(|(port, value)| Entry::of(port, value));
            let (values, data) = entries.unzip();
            (Header { byte_order, key, summary: None, values }, data)
        }
    };
    Ok((serde_json::to_vec(&header)?, parts))
}

/// Bytes of the file of a result.
pub(super) fn size(key: &Key, given: &Given) -> io::Result<u64> {
    let (header, parts) = parts(key, given)?;
    let samples: usize = parts.iter().map(|p| p.len()).sum();
    Ok((MAGIC.len() + 8 + header.len() + samples + SUM) as u64)
}

pub(super) fn write(file: &mut impl Write, key: &Key, given: &Given) -> io::Result<()> {
    let (header, parts) = parts(key, given)?;
    let length = (header.len() as u64).to_le_bytes();
    let mut hasher = blake3::Hasher::new();
    for part in [MAGIC, &length, &header].into_iter().chain(parts.iter().map(|part| &**part)) {
        hasher.update(part);
        file.write_all(part)?;
    }
    file.write_all(hasher.finalize().as_bytes())?;
    file.flush()
}

/// Reads a file of `size` bytes. The sizes in its header are checked against `size` before memory is allocated.
///
/// # Errors
/// Returns [`io::ErrorKind::InvalidData`] for a damaged file, and another kind for one that could not be read.
pub(super) fn read(file: impl Read, size: u64, key: &Key, wanted: &Grid, kind: &Kind) -> io::Result<Given> {
    let mut summed = Summed { file, hasher: blake3::Hasher::new() };
    let mut start = [0; MAGIC.len() + 8];
    summed.fill(&mut start)?;
    let (magic, length) = start.split_at(MAGIC.len());
    let length = u64::from_le_bytes(length.try_into().map_err(|_| damaged())?);
    if magic != MAGIC || length > MOST_HEADER.min(size) {
        return Err(damaged());
    }
    let mut text = vec![0; length as usize];
    summed.fill(&mut text)?;
    let header: Header = serde_json::from_slice(&text).map_err(|_| damaged())?;
    let around = (start.len() + SUM) as u64 + length;
    let whole = header.claimed().and_then(|claimed| claimed.checked_add(around));
    if header.byte_order != 1u32.to_ne_bytes() || header.key != key.to_string() || whole != Some(size) {
        return Err(damaged());
    }
    let given = summed.given(&header, wanted, kind)?;
    let mut sum = [0; SUM];
    let found = summed.hasher.finalize();
    summed.fill(&mut sum)?;
    if sum != *found.as_bytes() { Err(damaged()) } else { Ok(given) }
}

/// A reader that hashes what it reads.
struct Summed<R> {
    file: R,
    hasher: blake3::Hasher,
}

impl<R: Read> Summed<R> {
    /// Fills a buffer; the error of a file that ends too soon is that of a damaged file.
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => damaged(),
            _ => e,
        })?;
        self.hasher.update(bytes);
        Ok(())
    }

    /// Reads the content. Results are finite (law 8), so that a file with other numbers is damaged even if its hash
    /// fits.
    fn given(&mut self, header: &Header, wanted: &Grid, kind: &Kind) -> io::Result<Given> {
        if let Some(count) = header.summary {
            let mut numbers = vec![0f64; count as usize];
            self.fill(bytemuck::cast_slice_mut(&mut numbers))?;
            if numbers.iter().any(|n| !n.is_finite()) {
                return Err(damaged());
            }
            return Ok(Given::Summary(Summary(numbers.into())));
        }
        let mut wires = Wires::default();
        for entry in &header.values {
            let value = entry.value(kind, wanted, &mut |bytes| self.fill(bytes))?;
            let (port, value) = value.ok_or_else(damaged)?;
            wires.put(port, value);
        }
        Ok(Given::Wires(wires))
    }
}
