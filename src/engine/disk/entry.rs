//! The form of a file of the cache: a line of magic, the length of a JSON header, the header, the samples, and the
//! BLAKE3 of all before it.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};

use super::FARTHEST;
use crate::engine::cache::Given;
use crate::engine::key::Key;
use crate::name::Name;
use crate::node::{Kind, Summary};
use crate::ports::Wires;
use crate::value::{Grid, Lattice, Quantity, Value};

/// Number of the form. It stands in the name of the folder: a change here raises it, and a test holds the two
/// together.
pub(super) const FORM: u32 = 2;
const MAGIC: &[u8] = b"orograph cache\n";
/// Longest header; one has some hundred bytes for each output.
const MOST_HEADER: u64 = 1 << 20;
const SUM: usize = blake3::OUT_LEN;

#[derive(Serialize, Deserialize)]
struct Header {
    /// Written as the machine holds it: a file from a machine of the other byte order does not match.
    byte_order: [u8; 4],
    /// The key of the result: a file that was put in another's place does not match.
    key: String,
    summary: Option<u64>,
    values: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    port: String,
    quantity: String,
    lattice: (f64, f64, f64, u32),
    window: (i64, i64, usize, usize),
    components: u64,
}

impl Header {
    /// Bytes of the samples that follow; none where they do not add up.
    fn claimed(&self) -> Option<u64> {
        let values = self.values.iter().map(|e| e.components.checked_mul(4));
        let numbers = self.summary.map_or(Some(0), |n| n.checked_mul(8));
        values.chain([numbers]).try_fold(0u64, |sum, part| sum.checked_add(part?))
    }
}

impl Entry {
    fn of(port: &str, value: &Value) -> Option<Self> {
        let (g, quantity) = (value.grid()?, value.quantity()?);
        let l = g.lattice;
        Some(Self {
            port: port.to_owned(),
            quantity: quantity.name().to_owned(),
            lattice: (l.origin[0], l.origin[1], l.span, l.intervals),
            window: (g.col, g.row, g.cols, g.rows),
            components: value.components().len() as u64,
        })
    }

    /// The window, where it is on the lattice of a wanted one and holds it.
    fn grid(&self, wanted: &Grid) -> Option<Grid> {
        let (x, y, span, intervals) = self.lattice;
        let (col, row, cols, rows) = self.window;
        let near = |start: i64, count: usize| start.abs() <= FARTHEST && count as u64 <= FARTHEST as u64;
        let grid = Grid { lattice: Lattice { origin: [x, y], span, intervals }, col, row, cols, rows };
        // Before the numbers are added up they must be such that can be.
        let sound = col > i64::MIN && row > i64::MIN && near(col, cols) && near(row, rows);
        (sound && cols.checked_mul(rows).is_some() && grid.contains(wanted)).then_some(grid)
    }

    fn value(&self, kind: &Kind, wanted: &Grid, data: Vec<f32>) -> Option<(Name, Value)> {
        let port = kind.output(&self.port)?;
        let quantity = Quantity::ALL.into_iter().find(|q| q.name() == self.quantity)?;
        Some((port.name.clone(), Value::from_components(port.wire, self.grid(wanted)?, quantity, data)?))
    }
}

fn damaged() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "is damaged")
}

/// The header and the parts that follow it.
fn parts<'a>(key: &Key, given: &'a Given) -> io::Result<(Vec<u8>, Vec<&'a [u8]>)> {
    let (byte_order, key) = (1u32.to_ne_bytes(), key.to_string());
    let (header, parts): (_, Vec<&[u8]>) = match given {
        Given::Summary(summary) => {
            let summary = &*summary.0;
            let count = Some(summary.len() as u64);
            (
                Header { byte_order, key, summary: count, values: Vec::new() },
                vec![bytemuck::cast_slice(summary)],
            )
        }
        Given::Wires(wires) => {
            let values = wires.iter().filter_map(|(port, value)| Entry::of(port, value)).collect();
            let data = wires.iter().map(|(_, v)| bytemuck::cast_slice::<f32, u8>(v.components()));
            (Header { byte_order, key, summary: None, values }, data.collect())
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
    for part in [MAGIC, &length, &header].into_iter().chain(parts) {
        hasher.update(part);
        file.write_all(part)?;
    }
    file.write_all(hasher.finalize().as_bytes())?;
    file.flush()
}

/// Reads a file of a size; what it claims is held against that size before memory is taken.
///
/// # Errors
/// [`io::ErrorKind::InvalidData`] for a damaged file; whatever else for one that could not be read.
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

/// Reads and sums.
struct Summed<R> {
    file: R,
    hasher: blake3::Hasher,
}

impl<R: Read> Summed<R> {
    /// A file that ends too soon is a damaged one.
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => damaged(),
            _ => e,
        })?;
        self.hasher.update(bytes);
        Ok(())
    }

    /// The content. Results are finite (law 8), so that one which is not is no result, whatever its sum says.
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
            let mut data = vec![0f32; entry.components as usize];
            self.fill(bytemuck::cast_slice_mut(&mut data))?;
            let value =
                entry.value(kind, wanted, data).filter(|(_, value)| value.first_not_finite().is_none());
            let (port, value) = value.ok_or_else(damaged)?;
            wires.put(port, value);
        }
        Ok(Given::Wires(wires))
    }
}
