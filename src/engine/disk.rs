//! The cache folder: a folder for each key, in it a file for each window, whole or not there, checked when read.
//!
//! A file is a line of magic, a JSON header with its length, the samples, and the BLAKE3 of all before it. Files are
//! written beside their place and renamed into it, so that many processes may share the folder; one that is damaged
//! is removed and its result computed again. The folder of another program version is never read.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::cache::Given;
use super::key::Key;
use crate::node::{Kind, Summary};
use crate::ports::Wires;
use crate::value::{Grid, Lattice, Quantity, Value};

const MAGIC: &[u8] = b"orograph cache 1\n";
/// Results are keyed by what they depend on; the program itself is in the name of the folder.
const SALT: &str = concat!("orograph-", env!("CARGO_PKG_VERSION"));
/// The folder is trimmed to this many bytes when it is opened.
pub const DEFAULT_LIMIT: u64 = 32 << 30;

/// A folder of results.
#[derive(Debug)]
pub(super) struct Disk {
    folder: PathBuf,
}

#[derive(Serialize, Deserialize)]
struct Header {
    /// Written as the machine holds it: a file from a machine of the other byte order does not match.
    byte_order: [u8; 4],
    summary: Option<usize>,
    values: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    port: String,
    quantity: usize,
    lattice: (f64, f64, f64, u32),
    window: (i64, i64, usize, usize),
    components: usize,
}

impl Disk {
    pub(super) fn open(folder: &Path, limit: u64) -> io::Result<Self> {
        let folder = folder.join(SALT);
        fs::create_dir_all(&folder)?;
        let disk = Self { folder };
        disk.trim(limit)?;
        Ok(disk)
    }

    /// The folder of all windows of a key.
    fn windows(&self, key: &Key) -> PathBuf {
        let name = key.to_string();
        self.folder.join(&name[..2]).join(&name[2..])
    }

    /// A file whose window holds the wanted one: consumers that are cached themselves ask for nothing, so the same
    /// graph may ask for less another time.
    pub(super) fn find(&self, key: &Key, grid: &Grid) -> Option<PathBuf> {
        let folder = self.windows(key);
        let exact = folder.join(name_of(grid));
        if exact.is_file() {
            return Some(exact);
        }
        let files = fs::read_dir(folder).ok()?.flatten();
        let mut wider: Vec<_> = files
            .filter_map(|f| Some((window_of(f.file_name().to_str()?, grid.lattice)?, f.path())))
            .filter(|(window, _)| window.contains(grid))
            .collect();
        wider.sort_by_key(|(window, _)| (window.len(), window.row, window.col));
        wider.into_iter().next().map(|(_, path)| path)
    }

    /// Writes a result; a failure to write is not one of the evaluation.
    pub(super) fn put(&self, key: &Key, grid: &Grid, given: &Given) -> io::Result<()> {
        let folder = self.windows(key);
        fs::create_dir_all(&folder)?;
        let mut file = tempfile::NamedTempFile::new_in(&folder)?;
        write(&mut file, given)?;
        file.persist(folder.join(name_of(grid))).map_err(|e| e.error)?;
        Ok(())
    }

    /// Reads a result, or removes it when it is damaged.
    pub(super) fn get(&self, path: &Path, kind: &Kind) -> Option<Given> {
        let read = File::open(path).and_then(|f| read(f, kind));
        if let Ok(given) = read {
            // Its age tells the trimming what is in use; a folder that cannot be written is still good to read.
            let now = fs::FileTimes::new().set_modified(SystemTime::now());
            let _ = File::options().append(true).open(path).and_then(|f| f.set_times(now));
            return Some(given);
        }
        let _ = fs::remove_file(path);
        None
    }

    /// Removes the files that were not used for longest until the rest fits.
    fn trim(&self, limit: u64) -> io::Result<()> {
        let mut files = Vec::new();
        let below = |path: PathBuf| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path());
        for folder in below(self.folder.clone()).flat_map(below) {
            let Ok(entries) = fs::read_dir(folder) else { continue };
            files.extend(entries.flatten().filter_map(|e| {
                let meta = e.metadata().ok()?;
                Some((meta.modified().ok()?, meta.len(), e.path()))
            }));
        }
        files.sort();
        let mut total: u64 = files.iter().map(|f| f.1).sum();
        for (_, bytes, path) in files {
            if total <= limit {
                break;
            }
            // Another process may have removed it already.
            let _ = fs::remove_file(path);
            total -= bytes;
        }
        Ok(())
    }
}

/// The name of the file of a window.
fn name_of(grid: &Grid) -> String {
    format!("{}_{}_{}_{}", grid.col, grid.row, grid.cols, grid.rows)
}

/// The window that a file is named for.
fn window_of(name: &str, lattice: Lattice) -> Option<Grid> {
    let mut numbers = name.split('_');
    let mut next = || numbers.next();
    let (col, row) = (next()?.parse().ok()?, next()?.parse().ok()?);
    let (cols, rows) = (next()?.parse().ok()?, next()?.parse().ok()?);
    next().is_none().then_some(Grid { lattice, col, row, cols, rows })
}

fn header(given: &Given) -> (Header, Vec<&[u8]>) {
    let mut parts: Vec<&[u8]> = Vec::new();
    let byte_order = 1u32.to_ne_bytes();
    match given {
        Given::Summary(summary) => {
            parts.push(bytemuck::cast_slice(&summary.0));
            (Header { byte_order, summary: Some(summary.0.len()), values: Vec::new() }, parts)
        }
        Given::Wires(wires) => {
            let entry = |(port, value): (&str, &Value)| {
                let (g, quantity) = (value.grid()?, value.quantity()?);
                let l = g.lattice;
                Some(Entry {
                    port: port.to_owned(),
                    quantity: Quantity::ALL.iter().position(|q| *q == quantity).unwrap_or(0),
                    lattice: (l.origin[0], l.origin[1], l.span, l.intervals),
                    window: (g.col, g.row, g.cols, g.rows),
                    components: value.components().len(),
                })
            };
            let values = wires.iter().filter_map(entry).collect();
            parts.extend(wires.iter().map(|(_, v)| bytemuck::cast_slice::<f32, u8>(v.components())));
            (Header { byte_order, summary: None, values }, parts)
        }
    }
}

fn write(file: &mut impl Write, given: &Given) -> io::Result<()> {
    let (header, parts) = header(given);
    let header = serde_json::to_vec(&header)?;
    let length = (header.len() as u64).to_le_bytes();
    let mut hasher = blake3::Hasher::new();
    for part in [MAGIC, &length, &header].into_iter().chain(parts) {
        hasher.update(part);
        file.write_all(part)?;
    }
    file.write_all(hasher.finalize().as_bytes())?;
    file.flush()
}

fn read(mut file: File, kind: &Kind) -> io::Result<Given> {
    let damaged = || io::Error::new(io::ErrorKind::InvalidData, "damaged");
    let size = file.metadata()?.len();
    let mut hasher = blake3::Hasher::new();
    let mut exact = |file: &mut File, bytes: &mut [u8]| {
        file.read_exact(bytes)?;
        hasher.update(bytes);
        io::Result::Ok(())
    };
    let mut start = [0; MAGIC.len() + 8];
    exact(&mut file, &mut start)?;
    let (magic, length) = start.split_at(MAGIC.len());
    let length = u64::from_le_bytes(length.try_into().map_err(|_| damaged())?);
    if magic != MAGIC || length > size {
        return Err(damaged());
    }
    let mut text = vec![0; length as usize];
    exact(&mut file, &mut text)?;
    let header: Header = serde_json::from_slice(&text)?;
    let claimed = header.values.iter().map(|e| e.components as u64 * 4).sum::<u64>()
        + header.summary.unwrap_or(0) as u64 * 8;
    if header.byte_order != 1u32.to_ne_bytes() || claimed > size {
        return Err(damaged());
    }
    let given = if let Some(n) = header.summary {
        let mut numbers = vec![0f64; n];
        exact(&mut file, bytemuck::cast_slice_mut(&mut numbers))?;
        Given::Summary(Summary(numbers.into()))
    } else {
        let mut wires = Wires::default();
        for entry in &header.values {
            let mut data = vec![0f32; entry.components];
            exact(&mut file, bytemuck::cast_slice_mut(&mut data))?;
            let (port, value) = entry.value(kind, data).ok_or_else(damaged)?;
            wires.put(port, value);
        }
        Given::Wires(wires)
    };
    let mut sum = [0; 32];
    file.read_exact(&mut sum)?;
    if sum != *hasher.finalize().as_bytes() || file.read(&mut [0])? != 0 {
        return Err(damaged());
    }
    Ok(given)
}

impl Entry {
    fn value(&self, kind: &Kind, data: Vec<f32>) -> Option<(&'static str, Value)> {
        let port = kind.output(&self.port)?;
        let quantity = *Quantity::ALL.get(self.quantity)?;
        let (x, y, span, intervals) = self.lattice;
        let (col, row, cols, rows) = self.window;
        let grid = Grid { lattice: Lattice { origin: [x, y], span, intervals }, col, row, cols, rows };
        Some((port.name, Value::from_components(port.wire, grid, quantity, data)?))
    }
}
